"""What the second derivations of both papers of Holden et al. do to a motion, frame by frame."""

from collections.abc import Sequence
import math
from typing import Any

import numpy as np


def smoothed(x: Any, sigma: float) -> np.ndarray:
    """A Gaussian of `sigma` frames over the first axis, cut at four sigma, the ends repeated."""
    reach = int(4 * sigma + 0.5)
    weights = [math.exp(-0.5 * (i / sigma) ** 2) for i in range(-reach, reach + 1)]
    return np.array([sum(w * x[min(max(t + i, 0), len(x) - 1)]
                         for i, w in zip(range(-reach, reach + 1), weights)) / sum(weights)
                     for t in range(len(x))])


def turned(v: Sequence[float] | np.ndarray, yaw: float) -> np.ndarray:
    """About the vertical: what looks along z then looks along (sin yaw, 0, cos yaw)."""
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([c * v[0] + s * v[2], v[1], c * v[2] - s * v[0]])
