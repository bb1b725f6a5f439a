r"""The clean-up that the paper leaves to "a fast post process": planted feet stay where they are,
and no bone changes its length.

1. Every stretch of frames in which an ankle or a toe is planted gets one point to stay at
   (`locks`); an ankle's and a toe's that meet are as far apart as the foot is long.
2. The feet go there and, before and after, blend back into what they did (`foot_targets`); no free
   foot's toe goes below the floor (under a locked heel it may: nothing lifts it there).
3. Where a leg is too short, the whole body sinks, ahead of time and smoothly (`lowered`).
4. Thigh and shin reach the ankle by the law of cosines, the knee on the side where it was
   (`two_bone`).

All lengths are in the unit of the positions, y is up. A label at frame t covers the step from t to
t + 1, as in `feet.foot_contacts`.
"""

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from .easing import blended
from .feet import checked_contacts
from .features import checked_positions
from .joints import LEGS
from .rotation import shortest_rotation

# frames before and after a lock in which a foot finds its way: 0.13 s
BLEND = 8
# of thigh + shin: farther the body does not sink; a foot locked too far away slides instead
DEEPEST = 0.12
# of thigh + shin: a leg that the clean-up moves keeps its knee from locking
REACH = 0.9995


def lock_feet(positions, contacts, floor=0.0, *, blend=BLEND):
    """Lock planted feet. Every bone below the hips keeps its length in every frame; nothing else
    moves, except down with the hips.

    positions : (T, 21, 3);  contacts : (T, 4) in the order of `joints.FEET`;  floor : height of a
    resting toe joint;  blend : frames
    ->  (T, 21, 3).   Raises ValueError.
    A foot out of reach even of a body that sinks stops short of its point.
    """
    raw = checked_positions(positions)
    contacts, blend = checked_contacts(contacts, len(raw)), _checked_blend(blend)
    feet = [
        foot_targets(raw[:, ankle], raw[:, toe], contacts[:, 2 * n:2 * n + 2], floor, blend)
        for n, (_, _, ankle, toe) in enumerate(LEGS)]
    planted = raw.copy()
    planted[..., 1] -= lowered(raw, [ankle for ankle, _ in feet], blend)[:, None]
    for (hip, knee, ankle, toe), (goal, foot) in zip(LEGS, feet):
        thigh, shin = (np.linalg.norm(raw[:, a] - raw[:, b], axis=1)
                       for a, b in ((knee, hip), (ankle, knee)))
        planted[:, ankle] = _within(planted[:, hip], goal, *_limits(raw, hip, knee, ankle))
        old = raw[:, ankle] - raw[:, hip]
        bend = shortest_rotation(
            old, planted[:, ankle] - planted[:, hip]) @ (raw[:, knee] - raw[:, hip])[..., None]
        planted[:, knee] = two_bone(planted[:, hip], planted[:, ankle], thigh, shin,
                                    bend[..., 0] + 1e-6 * foot)
        planted[:, toe] = planted[:, ankle] + foot
    return planted


def two_bone(hip, ankle, thigh, shin, bend):
    r"""Where the knee of a leg from hip to ankle is, by the law of cosines, on the side of `bend`:

        d = |ankle - hip|,   a = (thigh^2 - shin^2 + d^2) / (2 d),   knee = hip + a u + sqrt(thigh^2 - a^2) n

    u : direction from hip to ankle;  n : direction of `bend` normal to u.
    hip, ankle, bend : (T, 3);  thigh, shin : (T,), |thigh - shin| <= d <= thigh + shin   ->  (T, 3)
    """
    along = ankle - hip
    d = np.linalg.norm(along, axis=-1)
    u = along / np.maximum(d, np.finfo(float).tiny)[..., None]
    a = np.clip((thigh**2 - shin**2 + d**2) / np.maximum(2 * d,
                                                         np.finfo(float).tiny), -thigh, thigh)
    n = bend - np.sum(bend * u, axis=-1, keepdims=True) * u
    size = np.linalg.norm(n, axis=-1, keepdims=True)
    n = np.where(size > 0, n / np.where(size > 0, size, 1.0), _any_normal(u))
    return hip + a[..., None] * u + np.sqrt(np.maximum(thigh ** 2 - a ** 2, 0.0))[..., None] * n


def foot_targets(ankle, toe, contacts, floor, blend=BLEND):
    """Where one foot shall be: its ankle, and the foot from ankle to toe, as long as it was.

    ankle, toe : (T, 3);  contacts : (T, 2) of ankle and toe   ->  (T, 3), (T, 3)
    """
    long = np.linalg.norm(toe - ankle, axis=1)
    points = locks(ankle, toe, contacts, floor, blend)
    held = [~np.isnan(p[:, 0]) for p in points]
    foot = _as_long(
        toe - ankle + blended(points[1] - points[0] - (toe - ankle), held[0] & held[1], blend), long)
    goal = np.where(held[0][:, None], points[0], np.where(held[1][:, None], points[1] - foot,
                                                          np.nan))
    goal = ankle + blended(goal - ankle, held[0] | held[1], blend)
    depth = np.maximum(0.0, floor - np.minimum(goal[:, 1], goal[:, 1] + foot[:, 1]))
    goal[:, 1] += np.where(held[0] | held[1], 0.0, depth)
    return goal, foot


def locks(ankle, toe, contacts, floor, blend=BLEND):
    """One point for each stretch of planted frames, NaN elsewhere: the mean of where the joint was,
    a toe at the height of the floor.

    A stretch of labels a..b locks frames a..b + 1. One that begins while the foot's other joint is
    locked, or up to `blend` frames later (that one then holds until there), gets the point nearest
    to its own mean at the foot's length from the other's.   ->  (T, 3), (T, 3)
    """
    T, raw, points = len(ankle), (ankle, toe), np.full((2, len(ankle), 3), np.nan)
    length, last = float(np.median(np.linalg.norm(toe - ankle, axis=1))), None
    for begin, end, which in sorted(
        (*run, which) for which in (0, 1) for run in stretches(contacts[:, which])):
        end = min(end + 1, T)
        point = raw[which][begin:end].mean(axis=0)
        point[1] = floor if which else max(point[1], floor)
        if last is not None and last[2] != which and begin - last[1] < blend:
            other = points[last[2], last[1] - 1]
            points[last[2], last[1]:begin + 1] = other
            point = _at_distance(other, point, length, floor)
        points[which, begin:end] = point
        if last is None or end > last[1] or last[2] == which:
            last = (begin, end, which)
    return points[0], points[1]


def stretches(labels):
    """Runs of true labels.   (T,) bool  ->  list of (begin, end), end not among them"""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], labels, [False]]).astype(int)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2])]


def lowered(raw, ankles, blend=BLEND):
    """How far the body goes down so that both legs reach, as far as going down helps: the largest
    need nearby, its running mean; never beyond `DEEPEST`.

    raw : (T, 21, 3);  ankles : where the two shall be, (T, 3) each   ->  (T,) >= 0
    """
    need, deepest = np.zeros(len(raw)), np.inf
    for (hip, knee, ankle, _), goal in zip(LEGS, ankles):
        _, far = _limits(raw, hip, knee, ankle)
        across = goal - raw[:, hip]
        down = np.sqrt(np.maximum(far ** 2 - across[:, 0] ** 2 - across[:, 2] ** 2, 0.0))
        need = np.maximum(need, -across[:, 1] - down)
        deepest = min(deepest, DEEPEST * float(far.max()))
    need = np.minimum(need, deepest)
    return uniform_filter1d(maximum_filter1d(need, 2 * blend + 1, mode="nearest"), 2 * blend + 1,
                            mode="nearest")


def _limits(raw, hip, knee, ankle):
    """Nearest and farthest that the ankle may be from the hip; what a leg did before it may do
    again.   ->  (T,), (T,)
    """
    thigh, shin, d = (np.linalg.norm(raw[:, a] - raw[:, b], axis=1)
                      for a, b in ((knee, hip), (ankle, knee), (ankle, hip)))
    return np.minimum(d,
                      np.abs(thigh - shin) + (1 - REACH) *
                      (thigh + shin)), np.maximum(d, REACH * (thigh + shin))


def _within(centre, point, near, far):
    """The point, or the nearest to it between two spheres."""
    along = point - centre
    d = np.linalg.norm(along, axis=-1)
    along = np.where(d[:, None] > 0, along, [0.0, -1.0, 0.0])
    return centre + along * (np.clip(d, near, far) / np.where(d > 0, d, 1.0))[:, None]


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


def _as_long(v, length):
    size = np.linalg.norm(v, axis=1)
    return v * (length / np.where(size > 0, size, 1.0))[:, None]


def _any_normal(u):
    """Some direction normal to u, forward where u is upright."""
    axis = np.where(np.abs(u[..., 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    n = axis - np.sum(axis * u, axis=-1, keepdims=True) * u
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


def _checked_blend(blend):
    if not isinstance(blend, (int, np.integer)) or isinstance(blend, bool) or blend < 1:
        raise ValueError(f"blend: found {blend!r}, needed a whole number of frames from 1 on")
    return int(blend)
