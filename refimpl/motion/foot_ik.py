r"""The clean-up that the paper leaves to "a fast post process": planted feet stay where they are,
and no bone changes its length.

1. Every stretch of frames in which an ankle or a toe is planted gets one point to stay at
   (`locks`); an ankle's and a toe's that meet are as far apart as the foot is long.
2. The feet go there and, before and after, blend back into what they did (`foot_targets`); no free
   foot's toe goes below the floor (under a locked heel it may: nothing lifts it there).
3. Where a leg is too short, the whole body is lowered, ahead of time and smoothly (`lowered`).
4. Thigh and shin reach the ankle by the law of cosines, the knee on the side where it was
   (`two_bone`).

All lengths are in the unit of the positions, y is up. A label at frame t covers the step from t to
t + 1, as in `feet.foot_contacts`.
"""

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from .easing import blended
from .feet import checked_contacts
from .features import checked_positions
from .joints import LEGS
from .rotation import shortest_rotation

BLEND = 8            # frames before and after a lock in which a foot finds its way: 0.13 s
DEEPEST = 0.12       # of a leg: the body goes no lower; a foot locked too far away slides instead
STRAIGHT = 0.9995    # of thigh + shin: no leg is stretched further, so that its knee does not lock


def lock_feet(positions: np.ndarray, contacts: np.ndarray, floor: float = 0.0, *,
              blend: int = BLEND) -> np.ndarray:
    """Lock planted feet. Every bone below the hips keeps its length in every frame; nothing else
    moves, except down with the hips. A foot out of reach even of a lowered body stops short of its
    point.

    positions : (T, 21, 3);  contacts : (T, 4) in the order of `joints.FEET`
    floor : height of a resting toe joint;  blend : frames
    ->  (T, 21, 3).   Raises ValueError for wrong shapes, labels or frames.
    """
    raw = checked_positions(positions)
    contacts = checked_contacts(contacts, len(raw))
    if not isinstance(blend, (int, np.integer)) or isinstance(blend, bool) or blend < 1:
        raise ValueError(f"blend: found {blend!r}, needed a whole number of frames from 1 on")
    feet = [foot_targets(raw[:, ankle], raw[:, toe], contacts[:, 2 * n:2 * n + 2], floor, blend)
            for n, (_, _, ankle, toe) in enumerate(LEGS)]
    moved = raw.copy()
    moved[..., 1] -= lowered(raw, [ankle for ankle, _ in feet], blend)[:, None]
    for (hip, knee, ankle, toe), (goal, foot) in zip(LEGS, feet):
        thigh, shin, near, far = _leg(raw, hip, knee, ankle)
        moved[:, ankle] = _within(moved[:, hip], goal, near, far)
        turn = shortest_rotation(raw[:, ankle] - raw[:, hip], moved[:, ankle] - moved[:, hip])
        bend = (turn @ (raw[:, knee] - raw[:, hip])[..., None])[..., 0] + 1e-6 * foot
        moved[:, knee] = two_bone(moved[:, hip], moved[:, ankle], thigh, shin, bend)
        moved[:, toe] = moved[:, ankle] + foot
    return moved


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
                 blend: int = BLEND) -> tuple[np.ndarray, np.ndarray]:
    """Where one foot shall be: its ankle, and the foot from ankle to toe, as long as it was.

    ankle, toe : (T, 3);  contacts : (T, 2) of ankle and toe;  floor, blend : as in `lock_feet`
    ->  (T, 3), (T, 3)
    """
    at_ankle, at_toe = locks(ankle, toe, contacts, floor, blend)
    heel_held, toe_held = ~np.isnan(at_ankle[:, 0]), ~np.isnan(at_toe[:, 0])
    held = heel_held | toe_held
    old = toe - ankle
    foot = old + blended(at_toe - at_ankle - old, heel_held & toe_held, blend)
    size = np.linalg.norm(foot, axis=1)
    foot = foot * (np.linalg.norm(old, axis=1) / np.where(size > 0, size, 1.0))[:, None]
    goal = np.where(heel_held[:, None], at_ankle, at_toe - foot)     # NaN where neither is held
    goal = ankle + blended(goal - ankle, held, blend)
    depth = np.maximum(0.0, floor - np.minimum(goal[:, 1], goal[:, 1] + foot[:, 1]))
    goal[:, 1] += np.where(held, 0.0, depth)
    return goal, foot


def locks(ankle: np.ndarray, toe: np.ndarray, contacts: np.ndarray, floor: float,
          blend: int = BLEND) -> tuple[np.ndarray, np.ndarray]:
    """One point for each stretch of planted frames, NaN elsewhere: the mean of where the joint was,
    a toe at the height of the floor.

    A stretch of labels a..b locks frames a..b + 1. One that begins while the foot's other joint is
    locked, or up to `blend` frames later (that one then holds until there), gets the point nearest
    to its own mean at the foot's length from the other's.

    ankle, toe : (T, 3);  contacts : (T, 2);  floor, blend : as in `lock_feet`   ->  (T, 3), (T, 3)
    """
    T, raw, points = len(ankle), (ankle, toe), np.full((2, len(ankle), 3), np.nan)
    length = float(np.median(np.linalg.norm(toe - ankle, axis=1)))
    last_end, last_which = -blend, -1                # of the lock that lasts longest so far
    for begin, end, which in sorted((*run, which) for which in (0, 1)
                                    for run in stretches(contacts[:, which])):
        end = min(end + 1, T)
        point = raw[which][begin:end].mean(axis=0)
        point[1] = floor if which else max(point[1], floor)
        if last_which == 1 - which and begin - last_end < blend:
            other = points[last_which, last_end - 1]
            points[last_which, last_end:begin + 1] = other
            point = _at_distance(other, point, length, floor)
        points[which, begin:end] = point
        if end > last_end or last_which == which:
            last_end, last_which = end, which
    return points[0], points[1]


def stretches(labels: np.ndarray) -> list[tuple[int, int]]:
    """Runs of true labels.   labels : (T,) bool  ->  (begin, end) of each, end not among them

    >>> stretches(np.array([True, True, False, True]))
    [(0, 2), (3, 4)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], labels, [False]]).astype(int)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2])]


def lowered(raw: np.ndarray, ankles: Sequence[np.ndarray], blend: int = BLEND) -> np.ndarray:
    """How far the body goes down so that both legs reach, as far as going down helps: the largest
    need nearby, its running mean; never beyond `DEEPEST`.

    raw : (T, 21, 3);  ankles : where the two shall be, (T, 3) each;  blend : frames   ->  (T,) >= 0
    """
    need, deepest = np.zeros(len(raw)), np.inf
    for (hip, knee, ankle, _), goal in zip(LEGS, ankles):
        far = _leg(raw, hip, knee, ankle)[-1]
        x, y, z = (goal - raw[:, hip]).T
        need = np.maximum(need, -y - np.sqrt(np.maximum(far ** 2 - x ** 2 - z ** 2, 0.0)))
        deepest = min(deepest, DEEPEST * float(far.max()))
    nearby = maximum_filter1d(np.minimum(need, deepest), 2 * blend + 1, mode="nearest")
    return uniform_filter1d(nearby, 2 * blend + 1, mode="nearest")


def _leg(raw, hip, knee, ankle):
    """Lengths of thigh and shin, and how near to the hip and how far from it the ankle may be; what
    a leg did before it may do again.   ->  four of (T,)
    """
    thigh, shin, d = (np.linalg.norm(raw[:, a] - raw[:, b], axis=1)
                      for a, b in ((knee, hip), (ankle, knee), (ankle, hip)))
    near = np.abs(thigh - shin) + (1 - STRAIGHT) * (thigh + shin)
    return thigh, shin, np.minimum(d, near), np.maximum(d, STRAIGHT * (thigh + shin))


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


def _any_normal(u):
    """Some direction normal to u, forward where u is upright."""
    axis = np.where(np.abs(u[..., 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    n = axis - np.sum(axis * u, axis=-1, keepdims=True) * u
    return n / np.linalg.norm(n, axis=-1, keepdims=True)
