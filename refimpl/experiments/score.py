r"""How good is a result of motion style transfer? Told from files alone, whoever made them.

A result R is put beside its content C, at 60 frames a second, y up, on the scale of C's bones:

    path        how far R is from C at equal shares of the way, both begun alike and turned so that
                they face alike, at the beginning or on average, whichever is nearer
    timing      how much sooner or later, in seconds, the joints do what they do in C (`lags`)
    movement    correlation of the joints' places in the character's frame, at equal times
    slide       horizontal speed of the worse foot near its own resting height, below a swing's
    floor       the lowest foot and the resting toes above C's floor
    bones       lengths that changed, and how much they vary;  widths: of pelvis and shoulders
    jerk, speed, acceleration, and how much more R is off from C at its ends than in its middle

What R looks like is said by judges that see no network (`judges`). Lengths are in legs of C.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ..motion.body import Take, make_take, read_clip, read_take
from ..motion.features import FPS, across, bone_lengths_by_frame, leg_length, root_path
from ..motion.feet import jerk
from ..motion.ground import planted_feet, resting_heights
from ..motion.joints import BONES, FEET, JOINTS, SLOTS
from ..motion.points import is_points
from ..motion.rotation import yaw_rotation
from ..motion.skeleton import forward_kinematics, local_pose, resample
from .bodies import ACROSS, ENDS

LIMBS = [n for n, (_, slot) in enumerate(BONES) if not SLOTS[slot].endswith(("UpLeg", "tArm"))]
SHARES = np.linspace(0.0, 1.0, 101)
LOW_FOOT, SLOW_FOOT = 0.03, 1.0   # legs above its rest and legs a second: a foot that should stand
FARTHEST, ABOUT_THEN = 60, 12.0   # frames: of a lag, and about a frame that is looked at
RELUCTANCE = 0.2                 # of correlation, to believe in a lag of a second
SHORTEST_CLIP = 4                 # frames at 60 a second, of which a jerk can be told
PATH_MET = 0.05, 0.1              # of the way, and legs: how far a path may lie
RESAMPLES = 400


class ScoreError(ValueError):
    """What cannot be scored; the message says why."""


@dataclass(frozen=True)
class Track:
    """A clip as it stands in its file, no row of it left out.

    positions : (T, 21, 3), 60 frames a second, y up;  contacts : (T, 4);  floor : its height
    fps : of the file;  doubts : why not to trust it (`motion.body.Take.doubts`)
    """

    positions: np.ndarray = field(repr=False)
    contacts: np.ndarray = field(repr=False)
    floor: float
    fps: float
    doubts: tuple[str, ...] = ()


def read_motion(path: str | Path, beside: Track | None = None) -> Track:
    """A BVH file or points.   beside : a content, whose rate points have that have as many rows
    Raises ValueError (what `body.read_take` raises) or OSError.
    """
    if is_points(path):
        clip = read_clip(path)
        if beside and abs((len(beside.positions) - 1) * beside.fps / FPS + 1 - clip.frames) < 1:
            clip = replace(clip, frame_time=1 / beside.fps)
        motion = motion_of(make_take(clip, {slot: slot for slot in SLOTS}, str(path)))
    else:
        motion = motion_of(read_take(path))
    if len(motion.positions) < SHORTEST_CLIP:
        raise ScoreError(f"{path}: found {len(motion.positions)} frames at 60 a second, needed "
                         f"{SHORTEST_CLIP} and more")
    return motion


def motion_of(take: Take) -> Track:
    """A take with every row of its clip, those that `motion.strays` leaves out too."""
    pose = resample(*local_pose(take.clip), take.clip.fps, FPS)
    positions = take.mapping.positions(*forward_kinematics(take.clip.parents, *pose))
    positions = positions @ take.upright.T
    floor, contacts = planted_feet(positions)
    return Track(positions, contacts, floor, take.clip.fps, take.doubts)


def compare(result: Track, content: Track) -> dict[str, float]:
    """What became of a content: see above.   ->  {what, with its unit: number}, nan where a clip is
    too short for it
    """
    lengths = [bone_lengths_by_frame(m.positions) for m in (result, content)]
    usual = np.median(lengths[1], axis=0)
    ratio = np.median((usual / np.median(lengths[0], axis=0))[LIMBS])
    R, C, leg = ratio * result.positions, content.positions, leg_length(content.positions)
    apart = np.abs(ratio * lengths[0][:, LIMBS] / usual[LIMBS] - 1)
    vary = (ratio * lengths[0].std(axis=0) / usual)[LIMBS]
    found = {**_way(R, C, leg), **_when(R, C),
             "bones off (share)": float(np.median(apart, axis=0).max()),
             "bones vary (share)": float(vary.max())}
    for name, (a, b) in ACROSS.items():
        wide = [np.median(np.linalg.norm(p[:, SLOTS.index(a)] - p[:, SLOTS.index(b)], axis=1))
                for p in (R, C)]
        found[f"{name} width off (share)"] = float(abs(wide[0] / wide[1] - 1))
    rate = min(result.fps, content.fps)
    for name, p in (("", R), (" of content", C)):
        speeds, sudden = (np.linalg.norm(np.diff(p, n=n, axis=0), axis=-1) * FPS ** n / leg
                          for n in (1, 2))
        found |= {f"slide{name} (legs/s)": _slide(p, leg),
                  f"lowest foot{name} (legs)": float((p[:, FEET, 1].min() - content.floor) / leg),
                  f"toes above floor{name} (legs)": float(
                      (resting_heights(p)[1::2].min() - content.floor) / leg),
                  f"jerk{name} (legs/s^3)": jerk(p, range(JOINTS), recorded=rate) / leg,
                  f"largest speed{name} (legs/s)": float(speeds.max()),
                  f"largest acceleration{name} (legs/s^2)": float(sudden.max())}
    return found


def _way(R, C, leg):
    """How far the path lies from the content's, both begun at one place."""
    places, yaws, ways = [], [], []
    for p in (R, C):
        path = root_path(p)
        gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
        shares = gone / gone[-1] if gone[-1] > 1e-6 * leg else np.linspace(0.0, 1.0, len(path))
        places.append(np.stack([np.interp(SHARES, shares, xz) for xz in (path - path[0]).T],
                               axis=1))
        yaws.append(np.interp(SHARES * (len(p) - 1), np.arange(len(p)), np.unwrap(_yaw(p))))
        ways.append(gone[-1] / leg)
    turns = np.exp(1j * (yaws[1] - yaws[0]))
    off = min(np.linalg.norm(places[0] @ yaw_rotation(np.angle(turn))[::2, ::2].T - places[1],
                             axis=1).mean() / leg for turn in (turns.mean(), turns[:5].mean()))
    return {"path error (legs)": float(off), "way of content (legs)": float(ways[1]),
            "path met": bool(off <= PATH_MET[0] * ways[1] + PATH_MET[1])}


def _yaw(p):
    x, _, z = np.moveaxis(across(p), -1, 0)
    return np.arctan2(-z, x)


def _when(R, C):
    """When the same is done, and how alike what is done at equal times."""
    n = min(len(R), len(C))
    here, there = (seen_from_within(p[:n]) for p in (R, C))
    found = {"timing off (s)": float(np.abs(lags(here, there)).mean() / FPS),
             "duration off (s)": (len(R) - len(C)) / FPS,
             "movement kept (correlation)": correlation(here, there),
             "ends off (ratio)": float("nan")}
    if len(R) == len(C) and n >= 4 * ENDS:
        off = np.linalg.norm(here - there, axis=-1).mean(axis=1) / leg_length(C) + 1e-3
        found["ends off (ratio)"] = float(max(off[:ENDS].mean(), off[-ENDS:].mean())
                                          / np.median(off[ENDS:-ENDS]))
    return found


def lags(here: np.ndarray, there: np.ndarray) -> np.ndarray:
    """How many frames later a motion does what another does at each of its frames: where within
    `FARTHEST` frames the joints' deviations about then correlate most, of equals the nearest.

    here, there : (T, J, 3)  ->  (T,)

    >>> wave = np.sin(np.arange(200.0) / 9)[:, None, None] ** 3 * np.ones((1, 2, 3))
    >>> lags(wave[:-6], wave[6:])[60:120].mean().round(1)
    np.float64(6.0)
    """
    a, b = ((x - x.mean(axis=0)).reshape(len(x), -1) for x in (here, there))
    tried = sorted(range(-FARTHEST, FARTHEST + 1), key=abs)
    found = np.full((len(tried), len(a)), -1.0)
    for row, lag in zip(found, tried):
        when = slice(max(0, -lag), len(a) - max(0, lag))
        if when.start < when.stop:                 # else the clip is shorter than the lag
            x, y = a[when.start + lag:when.stop + lag], b[when]
            both, own, other = (gaussian_filter1d(np.sum(p * q, axis=1), ABOUT_THEN, mode="nearest")
                                for p, q in ((x, y), (x, x), (y, y)))
            row[when] = both / np.sqrt(np.maximum(own * other, 1e-12)) - RELUCTANCE * abs(lag) / FPS
    return np.array(tried)[found.argmax(axis=0)]


def correlation(here: np.ndarray, there: np.ndarray) -> float:
    """Of two motions, each joint about its own mean place.   (T, J, 3) both  ->  -1 to 1

    >>> wave = np.sin(np.arange(60.0))[:, None, None] * np.ones((1, 2, 3))
    >>> round(correlation(3 * wave + 5, wave), 6), round(correlation(-wave, wave), 6)
    (1.0, -1.0)
    """
    a, b = here - here.mean(axis=0), there - there.mean(axis=0)
    size = np.sqrt(np.sum(a * a) * np.sum(b * b))
    return float(np.sum(a * b) / size) if size > 0 else float(np.array_equal(a, b))


def seen_from_within(p: np.ndarray) -> np.ndarray:
    """Joints in each frame from the hips' place on the floor, turned with the shoulders and hips,
    nothing smoothed.   (T, 21, 3)  ->  (T, 21, 3)
    """
    return (p - p[:, :1] * [1.0, 0.0, 1.0]) @ yaw_rotation(_yaw(p))


def _slide(p, leg):
    heights = (p[:-1, FEET, 1] - resting_heights(p)) / leg
    speeds = FPS * np.linalg.norm(np.diff(p[:, FEET][..., [0, 2]], axis=0), axis=-1) / leg
    low = heights < LOW_FOOT
    chosen = low & (speeds < SLOW_FOOT) if (low & (speeds < SLOW_FOOT)).any() else low
    feet = [speeds[:, foot][chosen[:, foot]] for foot in (slice(0, 2), slice(2, 4))]
    return float(max((foot.mean() for foot in feet if foot.size), default=np.nan))


def summary(rows: Sequence[Mapping[str, Any]], group: str = "style asked for", *,
            seed: int = 0) -> dict[str, float]:
    """Over the rows of a system: shares of what is true or false, medians of the rest, each with
    the interval in which 95 % of `RESAMPLES` resamples lie, first of groups, then of their rows.

    It does not depend on the order of the rows.   ->  {what: number, "what, low": ..., "high"}
    """
    found: dict[str, float] = {}
    names = sorted({str(row.get(group)) for row in rows})
    for key in dict.fromkeys(key for row in rows for key in row):
        own = [sorted(float(row[key]) for row in rows if str(row.get(group)) == name
                      and _is_number(row.get(key))) for name in names]
        own = sorted(values for values in own if values)
        if not own:
            continue
        truth = isinstance(next(row[key] for row in rows if _is_number(row.get(key))), bool)
        usual = np.mean if truth else np.median
        rng = np.random.default_rng(seed)
        again = [usual(np.concatenate([rng.choice(own[g], len(own[g]))
                                       for g in rng.integers(len(own), size=len(own))]))
                 for _ in range(RESAMPLES)]
        low, high = np.quantile(again, [0.025, 0.975])
        found |= {key: float(usual(np.concatenate(own))), f"{key}, low": float(low),
                  f"{key}, high": float(high)}
    return found


def _is_number(value):
    return isinstance(value, (int, float, np.number, np.bool_)) and bool(np.isfinite(value))
