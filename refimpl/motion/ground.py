r"""Where a body stands: the height of the floor, and which feet are planted, from where *this*
body's foot joints stand still.

A heel joint lies at an ankle's height above the floor on one skeleton and at half of that on
another, so that no height in legs fits all. What all have in common is that a planted joint stands
still, again and again at one height:

1. paths without single bad rows and without the noise of a capture;
2. the resting height of heels, and of toes: the lowest at which they often stand still;
3. planted is what is slow and near its resting height. A stance begins below lower bounds than
   those that end it, is bridged where it stops for a moment, and lasts for some frames.

Lengths are in the unit of the positions, frames are at 60 a second, y is up.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import gaussian_filter1d

from .features import AT_A_TIME, leg_length
from .joints import FEET

SPEED = 0.0148                   # legs a frame below which a foot is slow (71 cm/s for a leg of 80)
NEAR = 0.0375                    # legs above its resting height: 3 cm
HYSTERESIS = 1.1                 # so much above the bounds a stance ends, so much below it begins
SHORTEST, GAP = 4, 4             # frames of the shortest stance, and of the longest gap bridged
LOW, BAND = 0.05, 0.0125         # share of still frames below the lowest height; legs above it
NOISE_SIGMA = 1.0                # frames of the Gaussian
HELD_UP = 0.08                   # legs above the other foot, which no floor or shoe explains


def foot_paths(positions: np.ndarray) -> np.ndarray:
    """The four foot joints without single bad rows and noise.   (T, 21, 3)  ->  (T, 4, 3)

    Of five frames the one that is nearest to the others (a median that knows no axes), then a
    Gaussian.
    """
    near = np.pad(positions[:, FEET], ((2, 2), (0, 0), (0, 0)), mode="edge")
    every = sliding_window_view(near, 5, axis=0).transpose(0, 1, 3, 2)           # (T, 4, 5, 3)
    paths = np.empty((len(positions), len(FEET), 3))
    for n in range(0, len(paths), AT_A_TIME):
        five = every[n:n + AT_A_TIME]
        apart = np.linalg.norm(five[..., None, :] - five[..., None, :, :], axis=-1).sum(axis=-1)
        apart[..., 2] *= 1 - 1e-9                                # of equals the frame itself
        chosen = apart.argmin(axis=-1)[..., None, None]
        paths[n:n + AT_A_TIME] = np.take_along_axis(five, chosen, axis=2)[:, :, 0]
    return gaussian_filter1d(paths, NOISE_SIGMA, axis=0, mode="nearest")


def foot_speeds(paths: np.ndarray) -> np.ndarray:
    """Length a frame, by central differences.   (T, 4, 3)  ->  (T, 4)"""
    if len(paths) < 2:
        return np.zeros(paths.shape[:2])
    return np.linalg.norm(np.gradient(paths, axis=0), axis=-1)


def resting_heights(positions: np.ndarray) -> np.ndarray:
    """At which height each foot joint stands when it is planted.

    The lowest height at which it often stands still: 5 % of these frames may lie below it, so that
    a few bad rows do not count. Where it hardly stands still, the lowest 5 % of all frames; and
    where it stands far higher than the other foot's, which is held up then, the other's.

    positions : (T, 21, 3)  ->  (4,) y in the order of `joints.FEET`
    """
    paths, leg = foot_paths(positions), leg_length(positions)
    still = foot_speeds(paths) < 0.5 * SPEED * leg
    found = np.zeros(len(FEET))
    for n, (heights, slow) in enumerate(zip(paths[..., 1].T, still.T)):
        chosen = heights[slow] if slow.sum() >= max(SHORTEST, 0.02 * slow.size) else heights
        lowest = np.quantile(chosen, LOW, method="lower")
        found[n] = np.median(chosen[np.abs(chosen - lowest) <= BAND * leg])
    other = found[[2, 3, 0, 1]]
    return np.where(found > other + HELD_UP * leg, other, found)


def planted_feet(positions: np.ndarray) -> tuple[float, np.ndarray]:
    """The floor, which is the height of resting toes, and which feet are planted.

    positions : (T, 21, 3) at 60 frames a second, y up
    ->  float, (T, 4) bool in the order of `joints.FEET`; a label at frame t covers the step from t
    to t + 1
    """
    rest, leg = resting_heights(positions), leg_length(positions)
    paths = foot_paths(positions)
    slow, high = foot_speeds(paths) / (SPEED * leg), (paths[..., 1] - rest) / (NEAR * leg)
    worst = np.maximum(slow, high)
    labels = np.stack([_stances(worst[:, n]) for n in range(len(FEET))], axis=1)
    return float(rest[[1, 3]].min()), labels


def _stances(worst):
    """Where a number that is 1 at the bounds tells a stance.   (T,)  ->  (T,) bool"""
    labels = np.zeros(len(worst), bool)
    for begin, end in stretches(worst < HYSTERESIS):
        labels[begin:end] = worst[begin:end].min() < 1 / HYSTERESIS
    for begin, end in stretches(~labels):                        # between two stances
        if begin > 0 and end < len(labels) and end - begin <= GAP:
            labels[begin:end] = True
    for begin, end in stretches(labels):
        if end - begin < SHORTEST and begin > 0 and end < len(labels):
            labels[begin:end] = False
    return labels


def stretches(labels: np.ndarray) -> list[tuple[int, int]]:
    """Runs of true labels.   labels : (T,) bool  ->  (begin, end) of each, end not among them

    >>> stretches(np.array([True, True, False, True]))
    [(0, 2), (3, 4)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], labels, [False]]).astype(int)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2])]
