r"""The clean-up that the paper leaves to "a fast post process": planted feet stay where they are,
and no bone changes its length.

1. Each stance of an ankle or a toe gets one point to stay at (`locks`), also where its label stops
   for a moment; an ankle's and a toe's that meet are as far apart as the foot is long.
2. The feet are moved there by the smoothest correction that does it (`smoothest`): firm within a
   stance, soft at its ends, fading where nothing is held. No toe goes below the floor.
3. Where a leg is too short, the heel is lifted about the toe (`heel_lifted`), unless it is planted,
   and a body that hangs too high over the floor, or steps much too far, is lowered, ahead of time
   and smoothly (`lowered`).
4. Thigh and shin reach the ankle by the law of cosines, the knee on the side where it was
   (`two_bone`); a leg approaches its full length gently, and a foot a little beyond it slides.

To lower the body for every step that is too long takes the slide to a half, and bends knees that a
style keeps straight: on two styles it left 0.71 and 0.61 of the style where this leaves 0.56 and
0.31, and no clean-up 0.40 and 0.25.

All lengths are in the unit of the positions, y is up. A label at frame t covers the step from t to
t + 1, as in `feet.foot_contacts`.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.linalg import solveh_banded
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from .easing import softened
from .feet import checked_contacts
from .features import checked_positions
from .ground import stretches
from .joints import LEGS
from .rotation import shortest_rotation

BLEND = 6            # frames that a correction takes to fade, and that a gap in a stance may last
TAPER = 4            # frames at each end of a stance in which its lock is not yet firm
FIRM = 30.0          # how much more a lock weighs than what bends the correction
SAME_PLACE = 0.5     # of a foot: one that moves further in a gap begins another stance
DEEPEST = 0.12       # of a leg: the body goes no lower
SOFT, STRAIGHT = 0.9, 0.9999     # of thigh + shin: where a leg begins to stretch less, and ends
FALLS_SHORT = 1.03   # of a leg: where a leg is so much too short for its step, the body sinks
GENTLE, LIFT = 0.006, 0.5        # what a lifted heel weighs beside its bending; of a foot, at most


def lock_feet(positions: np.ndarray, contacts: np.ndarray, floor: Any = 0.0, *,
              heels: Any = -np.inf, blend: int = BLEND) -> np.ndarray:
    """Lock planted feet. Every bone below the hips keeps its length in every frame; nothing else
    moves, except down with the hips. A foot out of reach stops short of its point.

    positions : (T, 21, 3);  contacts : (T, 4) in the order of `joints.FEET`
    floor, heels : height of a resting toe joint and ankle, or of the left and of the right one; no
    foot goes below them;  blend : frames
    ->  (T, 21, 3).   Raises ValueError for wrong shapes, labels or frames.
    """
    return on_legs(checked_positions(positions),
                   *locked_legs(positions, contacts, floor, heels=heels, blend=blend))


def on_legs(positions: np.ndarray, down: np.ndarray, legs: np.ndarray) -> np.ndarray:
    """A body with the hips and the legs of `locked_legs`.

    positions : (T, 21, 3);  down : (T,);  legs : (T, 6, 3)   ->  (T, 21, 3)
    """
    moved = positions.copy()
    moved[..., 1] -= down[:, None]
    moved[:, [joint for leg in LEGS for joint in leg[1:]]] = legs
    return moved


def locked_legs(positions: np.ndarray, contacts: np.ndarray, floor: Any = 0.0, *,
                heels: Any = -np.inf, blend: int = BLEND) -> tuple[np.ndarray, np.ndarray]:
    """What `lock_feet` changes.   ->  (T,) how far the body goes down, (T, 6, 3) where knee, ankle
    and toe of both legs are"""
    raw = checked_positions(positions)
    contacts = checked_contacts(contacts, len(raw))
    if not isinstance(blend, (int, np.integer)) or isinstance(blend, bool) or blend < 1:
        raise ValueError(f"blend: found {blend!r}, needed a whole number of frames from 1 on")
    rests = zip(np.broadcast_to(floor, 2), np.broadcast_to(heels, 2))
    feet = [foot_targets(raw[:, ankle], raw[:, toe], contacts[:, 2 * n:2 * n + 2], toes, blend,
                         rest)
            for n, ((_, _, ankle, toe), (toes, rest)) in enumerate(zip(LEGS, rests))]
    feet = [heel_lifted(raw, leg, *foot, contacts[:, 2 * n], blend)
            for n, (leg, foot) in enumerate(zip(LEGS, feet))]
    down, legs = lowered(raw, [ankle for ankle, _ in feet], blend), []
    for (hip, knee, ankle, _), (goal, foot) in zip(LEGS, feet):
        thigh, shin, d, near, far = _leg(raw, hip, knee, ankle)
        socket = raw[:, hip].copy()
        socket[:, 1] -= down
        along = goal - socket
        asked = np.linalg.norm(along, axis=-1)
        along = np.where(asked[:, None] > 0, along, [0.0, -1.0, 0.0])
        reached = np.maximum(softened(asked, np.maximum(d, SOFT * (thigh + shin)), far), near)
        end = socket + along * (reached / np.where(asked > 0, asked, 1.0))[:, None]
        turn = shortest_rotation(raw[:, ankle] - raw[:, hip], end - socket)
        bend = (turn @ (raw[:, knee] - raw[:, hip])[..., None])[..., 0] + 1e-6 * foot
        legs += [two_bone(socket, end, thigh, shin, bend), end, end + foot]
    return down, np.stack(legs, axis=1)


def two_bone(hip: np.ndarray, ankle: np.ndarray, thigh: np.ndarray | float,
             shin: np.ndarray | float, bend: np.ndarray) -> np.ndarray:
    r"""Where the knee of a leg from hip to ankle is, by the law of cosines, on the side of `bend`:

        d = |ankle - hip|,   a = (thigh^2 - shin^2 + d^2) / (2 d),
        knee = hip + a u + sqrt(thigh^2 - a^2) n

    with u the direction from hip to ankle and n that of `bend` normal to u.

    hip, ankle, bend : (T, 3);  thigh, shin : (T,), |thigh - shin| <= d <= thigh + shin
    ->  (T, 3)

    >>> hip, ankle, forward = np.array([[[0, 8, 0]], [[0, 0, 0]], [[0, 0, 1]]])
    >>> two_bone(hip, ankle, 5.0, 5.0, forward)
    array([[0., 4., 3.]])
    """
    along = ankle - hip
    d = np.maximum(np.linalg.norm(along, axis=-1), np.finfo(float).tiny)
    u = along / d[..., None]
    a = np.clip((thigh ** 2 - shin ** 2 + d ** 2) / (2 * d), -thigh, thigh)
    n = bend - np.sum(bend * u, axis=-1, keepdims=True) * u
    size = np.linalg.norm(n, axis=-1, keepdims=True)
    n = np.where(size > 0, n / np.where(size > 0, size, 1.0), _any_normal(u))
    return hip + a[..., None] * u + np.sqrt(np.maximum(thigh ** 2 - a ** 2, 0.0))[..., None] * n


def foot_targets(ankle: np.ndarray, toe: np.ndarray, contacts: np.ndarray, floor: float,
                 blend: int = BLEND, heel: float = -np.inf) -> tuple[np.ndarray, np.ndarray]:
    """Where one foot shall be: its ankle, and the foot from ankle to toe, as long as it was.

    ankle, toe : (T, 3);  contacts : (T, 2) of ankle and toe
    floor, heel : at which height its toe and its ankle rest;  blend : frames
    ->  (T, 3), (T, 3)
    """
    at_ankle, at_toe = locks(ankle, toe, contacts, floor, blend, heel)
    held, tip = ~np.isnan(at_ankle[:, 0]), ~np.isnan(at_toe[:, 0])
    firm = steadiness(held + 2 * tip)
    old = toe - ankle
    length = np.linalg.norm(old, axis=1)
    foot = _of_length(old + smoothest(at_toe - at_ankle - old, np.where(held & tip, firm, 0.0),
                                      blend), length)
    on_toe = smoothest(np.ones((len(toe), 1)), np.where(tip, firm, 0.0), blend)[:, 0]
    down = np.clip(on_toe, 0.0, 1.0) * np.maximum(0.0, foot[:, 1] - (floor - heel))
    foot = _of_rise(foot, foot[:, 1] - down, length)             # who stands on a toe, flat at most
    goal = np.where(held[:, None], at_ankle, at_toe - foot)      # NaN where neither is held
    goal = ankle + smoothest(goal - ankle, firm, blend)
    lift = np.maximum(0.0, max(floor, heel) - goal[:, 1])        # about the toe
    goal[:, 1] += lift
    return goal, _of_rise(foot, np.maximum(foot[:, 1] - lift, floor - goal[:, 1]), length)


def smoothest(values: np.ndarray, weight: np.ndarray, frames: float) -> np.ndarray:
    r"""The curve c that bends least, near given values where they weigh, and near 0 elsewhere:

        min  sum_t frames^4 ( |c[t+1] - 2 c[t] + c[t-1]|^2 + w[t] |c[t] - v[t]|^2 ) + |c[t]|^2

    It fades within about so many frames.

    values : (T, D), not read where weight (T,) is 0   ->  (T, D)

    >>> smoothest(np.full((5, 1), 8.0), np.array([0.0, 0, 1e9, 0, 0]), 2)[:, 0].round(1)
    array([6.3, 7.4, 8. , 7.4, 6.3])
    """
    T, stiff = len(values), float(frames) ** 4
    bend = {1: (1.0,), 2: (-1.0, 1.0)}.get(T, (1.0, -2.0, 1.0))
    bands, rows = np.zeros((3, T)), T - len(bend) + 1
    for a, p in enumerate(bend):
        for b, q in enumerate(bend[a:], start=a):
            bands[2 - b + a, b:b + rows] += stiff * p * q
    bands[2] += stiff * weight + 1.0
    known = np.where(weight[:, None] > 0, values, 0.0)
    return solveh_banded(bands, stiff * weight[:, None] * known)


def heel_lifted(raw: np.ndarray, leg: Sequence[int], goal: np.ndarray, foot: np.ndarray,
                planted: np.ndarray, blend: int = BLEND) -> tuple[np.ndarray, np.ndarray]:
    """The foot turned about its toe, smoothly, so that its leg is asked to stretch less; not where
    its heel is planted, nor where the leg was as long before.

    raw : (T, 21, 3);  leg : of `joints.LEGS`;  goal, foot : (T, 3), as `foot_targets` has them;
    planted : (T,) bool, the heel;  blend : frames   ->  (T, 3), (T, 3)
    """
    hip, knee, ankle, _ = leg
    thigh, shin, d, *_ = _leg(raw, hip, knee, ankle)
    size, up = np.linalg.norm(foot, axis=1), raw[:, hip] - goal
    asked = np.linalg.norm(up, axis=1)
    held = maximum_filter1d(planted.astype(int), 2)              # a label locks its last frame too
    wanted = np.clip(asked - np.maximum(d, SOFT * (thigh + shin)), 0.0, LIFT * size) * (1 - held)
    lift = smoothest(wanted[:, None], np.where(held, steadiness(held), GENTLE), blend)
    nearer = goal + np.maximum(lift, 0.0) * _of_length(up, np.ones(len(up)))
    turned = _of_length(goal + foot - nearer, size)
    return goal + foot - turned, turned


def steadiness(state: np.ndarray) -> np.ndarray:
    """How firm a lock is in each frame: `FIRM` within a stretch of one state, less near its ends
    (not at those of the clip), 0 in state 0.

    state : (T,) whole numbers  ->  (T,)

    >>> (steadiness(np.array([0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0])) / FIRM).round(3)
    array([0.   , 0.008, 0.064, 0.216, 0.512, 1.   , 0.512, 0.216, 0.064,
           0.008, 0.   ])
    """
    T, firm = len(state), np.zeros(len(state))
    edges = [0, *(np.flatnonzero(np.diff(state)) + 1), T]
    for begin, end in zip(edges, edges[1:]):
        if state[begin]:
            t = np.arange(begin, end)
            near = np.minimum(t - begin + 1 if begin else T, end - t if end < T else T)
            firm[begin:end] = FIRM * np.minimum(near / (TAPER + 1), 1.0) ** 3
    return firm


def locks(ankle: np.ndarray, toe: np.ndarray, contacts: np.ndarray, floor: float,
          blend: int = BLEND, heel: float = -np.inf) -> tuple[np.ndarray, np.ndarray]:
    """One point for each stance, NaN elsewhere: the mean of where the joint was, a toe at the
    height of the floor.

    A stance is a stretch of labels a..b and locks frames a..b + 1; one that goes on after a gap of
    up to 2 `blend` frames in which it moves no further than `SAME_PLACE` is the same stance. One
    that begins while the foot's other joint is locked, or up to `blend` frames later (that one then
    holds until there), gets the point nearest to its own mean at the foot's length from the
    other's.

    ankle, toe : (T, 3);  contacts : (T, 2);  floor, blend, heel : as in `foot_targets`
    ->  (T, 3), (T, 3)
    """
    T, raw, points = len(ankle), (ankle, toe), np.full((2, len(ankle), 3), np.nan)
    length = float(np.median(np.linalg.norm(toe - ankle, axis=1)))
    last_end, last_which = -blend, -1                # of the lock that lasts longest so far
    for begin, end, which in sorted((*run, which) for which in (0, 1) for run in _stances(
            contacts[:, which], raw[which], 2 * blend, SAME_PLACE * length)):
        end = min(end + 1, T)
        point = raw[which][begin:end].mean(axis=0)
        point[1] = floor if which else max(point[1], floor, heel)
        if last_which == 1 - which and begin - last_end < blend:
            other = points[last_which, last_end - 1]
            points[last_which, last_end:begin + 1] = other
            point = _at_distance(other, point, length, floor)
        points[which, begin:end] = point
        if end > last_end or last_which == which:
            last_end, last_which = end, which
    return points[0], points[1]


def _stances(labels, path, gap, near):
    """Stretches of labels, those that are one stance together."""
    found: list[tuple[int, int]] = []
    for begin, end in stretches(labels):
        if found and begin - found[-1][1] <= gap:
            first, last = found[-1]
            if np.linalg.norm(path[begin] - path[last - 1]) <= near:
                found[-1] = first, end
                continue
        found.append((begin, end))
    return found


def lowered(raw: np.ndarray, ankles: Sequence[np.ndarray], blend: int = BLEND) -> np.ndarray:
    """How far the body goes down so that both legs reach the height of their feet where these were,
    and all but 3 % of the way to where they shall be: the largest need nearby, smoothed; never
    beyond `DEEPEST`.

    raw : (T, 21, 3);  ankles : where the two shall be, (T, 3) each;  blend : frames   ->  (T,) >= 0
    """
    need, deepest = np.zeros(len(raw)), np.inf
    for (hip, knee, ankle, _), goal in zip(LEGS, ankles):
        *_, far = _leg(raw, hip, knee, ankle)
        for aim, reach in ((raw[:, ankle], far), (goal, FALLS_SHORT * far)):
            aside = np.linalg.norm((aim - raw[:, hip])[:, [0, 2]], axis=1)
            need = np.maximum(need, raw[:, hip, 1] - goal[:, 1]
                              - np.sqrt(np.maximum(reach ** 2 - aside ** 2, 0.0)))
        deepest = min(deepest, DEEPEST * float(far.max()))
    nearby = maximum_filter1d(np.minimum(need, deepest), 2 * blend + 1, mode="nearest")
    return gaussian_filter1d(nearby, blend / 2, mode="nearest")


def _leg(raw, hip, knee, ankle):
    """Lengths of thigh and shin, how far the ankle is from the hip, and how near and how far it may
    be; what a leg did before it may do again.   ->  five of (T,)
    """
    thigh, shin, d = (np.linalg.norm(raw[:, a] - raw[:, b], axis=1)
                      for a, b in ((knee, hip), (ankle, knee), (ankle, hip)))
    near = np.abs(thigh - shin) + 1e-3 * (thigh + shin)
    return thigh, shin, d, np.minimum(d, near), np.maximum(d, STRAIGHT * (thigh + shin))


def _of_length(vectors, length):
    """(T, 3) in their directions, (T,) long."""
    size = np.linalg.norm(vectors, axis=1)
    return vectors * (length / np.where(size > 0, size, 1.0))[:, None]


def _of_rise(foot, rise, length):
    """The foot tilted so that its tip lies so high above the ankle, as far as it is long."""
    wanted = np.clip(rise, -0.999 * length, 0.999 * length)
    level = np.linalg.norm(foot[:, [0, 2]], axis=1)
    share = np.sqrt(np.maximum(length ** 2 - wanted ** 2, 0.0)) / np.where(level > 0, level, 1.0)
    tilted = np.stack([foot[:, 0] * share, wanted, foot[:, 2] * share], axis=1)
    return np.where((rise == foot[:, 1])[:, None], foot, tilted)


def _at_distance(centre, point, length, floor):
    """The point at this distance from the centre that keeps the point's height, as far as it can,
    and its direction.
    """
    rise = np.clip(max(point[1], floor) - centre[1], -0.999 * length, 0.999 * length)
    level = (point - centre)[[0, 2]]
    size = np.linalg.norm(level)
    level = level / size if size > 0 else np.array([0.0, 1.0])
    x, z = np.sqrt(length ** 2 - rise ** 2) * level
    return centre + np.array([x, rise, z])


def _any_normal(u):
    """Some direction normal to u, forward where u is upright."""
    axis = np.where(np.abs(u[..., 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    n = axis - np.sum(axis * u, axis=-1, keepdims=True) * u
    return n / np.linalg.norm(n, axis=-1, keepdims=True)
