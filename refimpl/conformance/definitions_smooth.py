"""What the second derivations of both papers of Holden et al. share: what they do to a motion,
frame by frame, and a training as a plain loop.
"""

from collections.abc import Callable, Iterable, Sequence
import math
from typing import Any

import numpy as np

from ..motion.joints import SLOT
from .definitions_nn import adam_step
from .specification import Array


def smoothed(x: Any, sigma: float) -> Array:
    """A Gaussian of `sigma` frames over the first axis, cut at four sigma, the ends repeated."""
    reach = int(4 * sigma + 0.5)
    weights = [math.exp(-0.5 * (i / sigma) ** 2) for i in range(-reach, reach + 1)]
    return np.array([sum(w * x[min(max(t + i, 0), len(x) - 1)]
                         for i, w in zip(range(-reach, reach + 1), weights)) / sum(weights)
                     for t in range(len(x))])


def turned(v: Sequence[float] | Array, yaw: float) -> Array:
    """About the vertical: what looks along z then looks along (sin yaw, 0, cos yaw)."""
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([c * v[0] + s * v[2], v[1], c * v[2] - s * v[0]])


def across(frame: Array) -> Array:
    """From the right to the left, at shoulders and hips together.   (21, 3)  ->  (3,)"""
    return sum((frame[SLOT[f"Left{part}"]] - frame[SLOT[f"Right{part}"]]
                for part in ("Arm", "UpLeg")), np.zeros(3))


def deviation_of(numbers: Iterable[float]) -> float:
    """Of the population.

    >>> deviation_of([1.0, 3.0])
    1.0
    """
    values = list(numbers)
    middle = sum(values) / len(values)
    return math.sqrt(sum((v - middle) ** 2 for v in values) / len(values))


def trained(arrays: Iterable[Array], order: Array, batch: int, rates: Any,
            of_batch: Callable[..., Any], counts: Callable[[list], int] = len,
            ) -> tuple[Array, ...]:
    """Adam written out over the gradients of each batch.

    rates : of the epochs;  of_batch : (arrays, indices, epoch) ->  loss, gradients;
    counts : what a batch's loss counts in its epoch's mean   ->  arrays, and those means
    """
    moved, met, t = list(arrays), [], 0
    moments: list[Any] = [(np.zeros(a.shape), np.zeros(a.shape)) for a in moved]
    for epoch, row in enumerate(order.tolist()):
        total, of = 0.0, 0
        while row:
            indices, row = row[:batch], row[batch:]
            (loss, slopes), t = of_batch(moved, indices, epoch), t + 1
            total, of = total + counts(indices) * float(loss), of + counts(indices)
            for k, slope in enumerate(slopes):
                moved[k], *moments[k] = adam_step(moved[k], slope, *moments[k], t=t,
                                                  rate=rates[epoch])
        met.append(total / of)
    return (*moved, np.array(met))
