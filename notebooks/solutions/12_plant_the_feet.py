"""Answers to 12_plant_the_feet.ipynb."""

import numpy as np

from refimpl.motion import foot_ik


def my_locks(points, labels):
    out = np.full_like(points, np.nan)
    for begin, end in foot_ik.stretches(labels):
        # the step after the last label ends one frame later
        frames = slice(begin, end + 1)
        out[frames] = points[frames].mean(axis=0)
    return out


def my_fade(x):
    x = np.clip(x, 0, 1)
    return 1 - 3 * x**2 + 2 * x**3


def my_two_bone(hip, ankle, thigh, shin, bend):
    along = ankle - hip
    d = np.linalg.norm(along, axis=1)
    u = along / d[:, None]
    c = (thigh**2 - shin**2 + d**2) / (2 * d)
    n = bend - np.sum(bend * u, axis=1, keepdims=True) * u
    n = n / np.linalg.norm(n, axis=1, keepdims=True)
    return hip + c[:, None] * u + np.sqrt(thigh**2 - c**2)[:, None] * n
