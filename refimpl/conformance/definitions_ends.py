"""How a clip goes on beyond its ends a second time: one joint of one frame at a time."""

import math

import numpy as np

from .definitions_smooth import across, turned
from .definitions_whole import _leg
from .specification import Array


def extended(positions: Array, *, frames: int) -> Array:
    """What follows the clip, and what follows it when it is told backwards."""
    track = list(positions)
    return np.array([*_after(track[::-1], frames)[::-1], *track, *_after(track, frames)])


def _after(track, frames):
    T, last = len(track), track[-1]
    told = [_told(track, t) for t in range(T)]
    off = [math.sqrt(sum(math.dist(a, b) ** 2 for a, b in zip(told[t], told[-1])) / len(told[-1]))
           for t in range(T - frames - 1)] if T > frames + 2 else []
    if not off or min(off) > 0.15 * _leg(np.array(track)):
        begin = max(T - 4, 0)
        speed = (last - track[begin]) / max(T - 1 - begin, 1)
        return [last + 3 * _eased(k / 12) * speed for k in range(1, frames + 1)]
    source = off.index(min(off))
    turn, hips = _yaw(last) - _yaw(track[source]), last[0] * [1, 0, 1]

    def _set_down(t):
        return np.array([turned(p - track[source][0] * [1, 0, 1], turn) + hips for p in track[t]])
    jump = last - _set_down(source)
    return [_set_down(source + k) + (1 - _eased(k / 20)) * jump for k in range(1, frames + 1)]


def _told(track, t):
    """21 joints in the character's frame, then five times what they move a frame."""
    T, yaw = len(track), _yaw(track[t])
    speeds = []
    for s in (min(max(t + k, 0), T - 1) for k in (-1, 0, 1)):
        a, b = max(s - 1, 0), min(s + 1, T - 1)
        speeds.append((track[b] - track[a]) / max(b - a, 1))
    return ([turned(p - track[t][0] * [1, 0, 1], -yaw) for p in track[t]]
            + [turned(5 * v, -yaw) for v in sum(speeds) / 3])


def _yaw(frame):
    x, _, z = across(frame)
    return math.atan2(-z, x)


def _eased(u):
    return 1.0 if u >= 1 else u ** 3 * (6 * u ** 2 - 15 * u + 10)
