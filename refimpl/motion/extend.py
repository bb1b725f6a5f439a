r"""A clip goes on beyond both its ends, so that what reads a neighbourhood of each frame (the
smoothing of the 66 numbers, the convolutions) does not read nothing there.

It goes on in phase: as the clip itself goes on from the frame that is most like its last one, set
down where that one ended. What jump remains fades out. Where nothing is alike, or the clip is too
short, the last pose stands still.
"""

import numpy as np
from scipy.ndimage import uniform_filter1d

from .easing import ease
from .features import AT_A_TIME, across, leg_length
from .joints import SLOT
from .rotation import yaw_rotation

FADE = 20                        # frames in which the remaining jump fades out
ALIKE = 0.15                     # legs: how far joints (with their speed over FADE / 4) may be off
HOLD = 12                        # frames in which a motion that nothing continues comes to rest


def extended(positions: np.ndarray, frames: int) -> np.ndarray:
    """The clip with so many frames more before and after.

    positions : (T, 21, 3), y up  ->  (T + 2 frames, 21, 3)

    >>> extended(np.ones((3, 21, 3)), 2).shape
    (7, 21, 3)
    """
    positions = positions if positions.dtype.kind == "f" else positions.astype(float)
    after = _continued(positions, frames)
    before = _continued(positions[::-1], frames)[::-1]
    return np.concatenate([before, positions, after])


def _continued(positions, frames):
    """Frames after the last.   ->  (frames, 21, 3)"""
    last, T = positions[-1], len(positions)
    source = _most_alike(positions, frames) if T > frames + 2 else -1
    if source < 0:
        speed = np.mean(np.diff(positions[-4:], axis=0), axis=0) if T > 1 else 0 * last
        k = np.arange(1, frames + 1)[:, None, None]
        way = HOLD * ease(np.minimum(k / HOLD, 1.0)) / 2     # comes to rest
        return last + way * speed * 0.5
    yaw = _yaw(positions)
    turn = yaw_rotation(yaw[-1] - yaw[source])
    ground = [1.0, 0.0, 1.0]
    hips, there = (positions[t, SLOT["Hips"]] * ground for t in (-1, source))
    goes_on = (positions[source:source + frames + 1] - there) @ turn.T + hips
    fade = 1 - ease(np.arange(1, frames + 1) / FADE)
    return goes_on[1:] + fade[:, None, None] * (last - goes_on[0])


def _most_alike(positions, frames):
    """The frame whose pose and speed are nearest to the last one's, -1 where none is near."""
    last, off = _states(positions[-AT_A_TIME:])[-1], np.empty(len(positions) - frames - 1)
    for n in range(0, len(off), AT_A_TIME):
        begin = max(n - 4, 0)                        # a speed is made of three frames on each side
        state = _states(positions[begin:n + AT_A_TIME + 4])[n - begin:][:len(off[n:n + AT_A_TIME])]
        off[n:n + AT_A_TIME] = np.sqrt(np.mean(np.sum((state - last) ** 2, axis=-1), axis=1))
    best = int(np.argmin(off))
    return best if off[best] <= ALIKE * leg_length(positions) else -1


def _states(positions):
    """Pose and speed, seen from where the body faces.   ->  (T, 42, 3)"""
    yaw = _yaw(positions)
    local = positions - positions[:, [SLOT["Hips"]]] * [1.0, 0.0, 1.0]
    local = local @ yaw_rotation(-yaw).swapaxes(1, 2)
    speed = uniform_filter1d(np.gradient(positions, axis=0), 3, axis=0, mode="nearest")
    speed = speed @ yaw_rotation(-yaw).swapaxes(1, 2)
    return np.concatenate([local, FADE / 4 * speed], axis=1)


def _yaw(positions):
    x, _, z = np.moveaxis(across(positions), -1, 0)
    return np.arctan2(-z, x)
