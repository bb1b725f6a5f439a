"""A body in motion: a clip made ready for the networks.

It is read, mapped to the 21 joints, brought to 60 frames a second and y up, and, on the body that
the networks know (`canonical`), turned into its 66 numbers. `moved` leads back.
"""

from dataclasses import dataclass, field, replace
import functools
from pathlib import Path
from typing import Any

import numpy as np

from ..storage import plausible
from . import bvh
from .canonical import Physique, to_body
from .clip import Clip, plus_offsets
from .doubts import doubts
from .extend import extended
from .features import (AT_A_TIME, FLOOR, FPS, LEG_RANGE, Start, encode, facing_yaw, leg_length,
                       root_motion, scale)
from .ground import planted_feet, resting_heights
from .joints import BONES, HEELS, JOINTS, SLOT, Mapping
from .mapping import map_clip
from .points import is_points, read_points
from .rotation import nearest_turn
from .skeleton import carrier, forward_kinematics, local_pose, resample
from .strays import Strays, bridged, find_strays

ROUNDED_AWAY = 1e9   # degrees of an angle whose last digits are coarser than a ten-millionth
MARGIN = 48          # frames beyond both ends: the networks see 36 + 13 to each side of a frame
# What turns a world of which this axis is up into a y-up one, as (x, y, z) -> (x, z, -y) for z.
_UPRIGHT = {"y": np.eye(3), "z": np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]),
            "-y": np.diag([1.0, -1, -1]), "-z": np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])}


@dataclass(frozen=True)
class Take:
    """One clip and everything derived from it, in the file's own length unit.

    clip : as read
    mapping : which joint of the file feeds each slot
    upright : (3, 3) turns the file's world y up
    positions : (T, 21, 3), y up
    start, contacts (T, 4) : what the 66 numbers leave out, planted feet
    strays : the clip's rows that are not part of its motion, of which all the rest knows nothing
    """

    clip: Clip
    mapping: Mapping
    upright: np.ndarray
    positions: np.ndarray = field(repr=False)
    start: Start
    contacts: np.ndarray = field(repr=False)
    strays: Strays = field(repr=False)

    @functools.cached_property
    def features(self) -> np.ndarray:
        """The 66 numbers.   ->  (T, 66)"""
        return _around(self.positions, self.start.floor)[0][MARGIN:-MARGIN]

    @property
    def up(self) -> str:
        """The axis of the file that was taken for up, of `up_axis`."""
        return next(axis for axis, turn in _UPRIGHT.items() if (turn == self.upright).all())

    @property
    def doubts(self) -> tuple[str, ...]:
        """Why not to trust it, in words: rows that are not motion, and what no body does."""
        said = [self.strays.said()] if self.strays.said() else []
        values = self.clip.values
        largest = np.maximum(values.max(axis=0), -values.min(axis=0))[self.clip.angles].max(
            initial=0)
        if largest > ROUNDED_AWAY:
            said.append(f"an angle is {largest:.3g} degrees: what is left of it is rounding")
        yaw = facing_yaw(extended(self.positions, MARGIN))
        turn = nearest_turn(np.diff(yaw))[MARGIN:1 - MARGIN]
        return (*said, *doubts(self.positions, turn, self.clip.fps, self.up))

    @property
    def rests(self) -> np.ndarray:
        """At which height each of `joints.FEET` rests.   ->  (4,)"""
        return resting_heights(self.positions)

    @property
    def leg(self) -> float:
        """The leg's length, see `features.leg_length`."""
        return leg_length(self.positions)


def make_take(clip: Clip, overrides: dict[str, str] | None = None,
              name: str = "the clip") -> Take:
    """Make a clip ready.

    clip : of any skeleton;  overrides : {slot: joint};  name : the clip's, for messages   ->  Take
    Raises MappingError (a joint is missing) or ValueError (no legs, nothing finite).
    """
    with np.errstate(over="ignore", invalid="ignore"):       # what is absurd is refused below
        mapping = map_clip(clip, overrides, name)
        positions = slot_positions(clip, mapping)
        strays = find_strays(positions, clip.fps)
        if clip.fps != FPS or strays.said():
            positions = _even_positions(clip, mapping, strays)
        upright = _UPRIGHT[up_axis(positions)]
        positions = positions @ upright.T
        leg = leg_length(positions)
    if not leg > 0:
        raise ValueError(f"{name}: found legs of length 0, needed thighs and shins; position "
                         "channels replace the OFFSET: if they hold differences from it, say "
                         "--positions add; else all offsets and positions are 0")
    if not LEG_RANGE[0] <= leg <= LEG_RANGE[1] or not plausible(positions):
        raise ValueError(f"{name}: found a leg {leg:g} long and joints up to "
                         f"{np.abs(positions).max():g} away, needed a leg from {LEG_RANGE[0]:g} to "
                         f"{LEG_RANGE[1]:g} and joints within 1e9; is an OFFSET or a position "
                         "absurd?")
    hips = positions[:, SLOT["LeftUpLeg"]] - positions[:, SLOT["RightUpLeg"]]
    if not np.linalg.norm(hips[:, FLOOR["y"]], axis=1).min() > 0:
        raise ValueError(f"{name}: found hips with no width in some frame, needed two different "
                         "hip joints to know where it faces")
    floor, contacts = planted_feet(positions)
    around, start = _around(positions, floor)
    if not np.isfinite(around[MARGIN:-MARGIN]).all():
        raise ValueError(f"{name}: found shoulders exactly opposite to the hips, needed to know "
                         "where the body faces")
    return Take(clip, mapping, upright, positions, start, contacts, strays)


def slot_positions(clip: Clip, mapping: Mapping) -> np.ndarray:
    """Where the 21 joints are, at the clip's own rate; some rows at a time, since a pose takes
    ten times the memory.   ->  (rows, 21, 3)
    """
    found = np.empty((clip.frames, JOINTS, 3))
    for n in range(0, clip.frames, AT_A_TIME):
        pose = local_pose(replace(clip, values=clip.values[n:n + AT_A_TIME]))
        found[n:n + AT_A_TIME] = mapping.positions(*forward_kinematics(clip.parents, *pose))
    return found


def _even_positions(clip, mapping, strays):
    """Where the 21 joints are at 60 frames a second, without strays; some joints at a time, whose
    curves are whole.   ->  (T, 21, 3)
    """
    begins = np.cumsum([0, *(len(joint.channels) for joint in clip.joints)])
    together, parents = max(1, 64 * AT_A_TIME // clip.frames), clip.parents
    world: dict[int, tuple[np.ndarray, np.ndarray]] = {}     # of joints whose children come later
    slots: list[Any] = [None] * JOINTS
    for n in range(0, len(parents), together):
        some = clip.joints[n:n + together]
        part = replace(clip, joints=some, values=clip.values[:, begins[n]:begins[n + len(some)]])
        pose = resample(*bridged(*local_pose(part), strays), clip.fps, FPS)
        for j, (R, t) in enumerate(zip(*(np.moveaxis(p, 1, 0) for p in pose)), start=n):
            if parents[j] >= 0:
                above, base = world[parents[j]]
                R, t = above @ R, base + (above @ t[..., None])[..., 0]
            world[j] = R, t
            for slot in np.flatnonzero(mapping.joints == j):
                slots[slot] = t + (R @ mapping.tips[slot][:, None])[..., 0]
        world = {j: world[j] for j in set(parents[n + len(some):]) & set(world)}
    return np.stack(slots, axis=1)


def _around(positions, floor):
    """Features with frames before and after, and the start of the first frame between."""
    around, first = encode(extended(positions, MARGIN), floor)
    root, yaw = root_motion(around, first)
    return around, Start(float(root[MARGIN, 0]), float(root[MARGIN, 2]), float(yaw[MARGIN]), floor)


@dataclass(frozen=True)
class Seen:
    """A take as networks see it, on a body that they know.

    positions : (T, 21, 3) of that body
    around : (T + 2 MARGIN, 66), the features with frames before and after, in which the clip goes
    on (`extend`);  start : of the first frame between;  ratio : how much longer that body's leg is
    """

    positions: np.ndarray = field(repr=False)
    around: np.ndarray = field(repr=False)
    start: Start
    ratio: float

    @property
    def features(self) -> np.ndarray:
        """Those of the clip itself.   ->  (T, 66)"""
        return self.around[MARGIN:-MARGIN]


def seen(take: Take, body: Physique | None = None) -> Seen:
    """A take on another body, its own unless given."""
    if body is None:
        around, start = _around(take.positions, take.start.floor)
        return Seen(take.positions, around, start, 1.0)
    positions = to_body(take.positions, body, take.contacts)
    around, start = _around(positions, 0.0)
    return Seen(positions, around, start, body.leg / take.leg)


def features_on(positions: np.ndarray, body: Physique, contacts: np.ndarray) -> np.ndarray:
    """The 66 numbers of points on another body.   (T, 21, 3), (T, 4)  ->  (T, 66)"""
    return _around(to_body(positions, body, contacts), 0.0)[0][MARGIN:-MARGIN]


def read_clip(path: str | Path, overrides: dict[str, str] | None = None, *,
              rate: float | None = None, positions: str = "replace") -> Clip:
    """Read a BVH file that may say what is not so, or a file of points (`points`).

    path : the file;  overrides : {slot: number of a point};  rate : its frames a second, where its
    Frame Time is wrong;  positions : "add" where position channels hold differences from the OFFSET
    ->  Clip
    Raises BVHError, OSError.
    """
    if is_points(path):
        return read_points(path, overrides, rate)
    clip = bvh.read_bvh(path)
    clip = plus_offsets(clip) if positions == "add" else clip
    return replace(clip, frame_time=1.0 / rate) if rate else clip


def read_take(path: str | Path, overrides: dict[str, str] | None = None, *,
              rate: float | None = None, positions: str = "replace") -> Take:
    """Read a BVH file and make it ready.

    overrides : {slot: joint};  path, rate, positions : as in `read_clip`   ->  Take
    Raises BVHError, MappingError, ValueError, OSError.
    """
    try:
        return make_take(read_clip(path, overrides, rate=rate, positions=positions),
                         None if is_points(path) else overrides, str(path))
    except ValueError as error:
        if str(path) in str(error):
            raise
        raise ValueError(f"{path}: {error}") from None


def up_axis(positions: np.ndarray) -> str:
    """Which way is up: the axis along which the head is farther from the ankles, over all frames.

    positions : (T, 21, 3)  ->  "y" or "z", "-y" or "-z" where the head lies towards that side

    >>> body = np.zeros((1, 21, 3))
    >>> body[:, SLOT["Head"]] = [0, 20, 150]
    >>> up_axis(body), up_axis(-body)
    ('z', '-z')
    """
    rise = np.mean(positions[:, SLOT["Head"]] - positions[:, HEELS].mean(axis=1), axis=0)
    axis = "z" if abs(rise[2]) > abs(rise[1]) else "y"
    return axis if rise["xyz".index(axis)] >= 0 else f"-{axis}"


def standing_height(lengths: np.ndarray) -> float:
    """Height of the head joint above the floor when standing straight: ankle (0.147 legs) + leg +
    trunk + neck.

    lengths : (20,) of the bones in the order of `joints.BONES`  ->  float

    >>> standing_height(np.full(20, 10.0))           # a leg of two bones, four bones above the hips
    62.94
    """
    by_joint = dict(zip((child for _, child in BONES), lengths))
    leg = by_joint[SLOT["LeftLeg"]] + by_joint[SLOT["LeftFoot"]]
    return float(1.147 * leg + sum(by_joint[SLOT[name]]
                                   for name in ("Spine", "Chest", "Neck", "Head")))


def guess_unit(height: float) -> str:
    """The likely length unit of a skeleton whose head joint stands this high (an adult's: about
    1.4 m).

    >>> guess_unit(141.0), guess_unit(55.0), guess_unit(7.0)
    ('centimetres', 'inches', 'units of about 20 cm')
    """
    for unit, low, high in (("metres", 0.9, 2.2), ("inches", 36.0, 80.0),
                            ("centimetres", 90.0, 220.0), ("millimetres", 900.0, 2200.0)):
        if low <= height <= high:
            return unit
    return f"units of about {140.0 / height:.2g} cm"


def metres(height: float) -> float:
    """How many metres one unit is, of a skeleton whose head joint stands this high.

    >>> metres(141.0), metres(1.5), round(metres(28.0), 4)
    (0.01, 1.0, 0.05)
    """
    known = {"metres": 1.0, "inches": 0.0254, "centimetres": 0.01, "millimetres": 0.001}
    return known.get(guess_unit(height), 1.4 / height)


def relative_size(size: float, other: float) -> float:
    """How much larger one body is than another; 1 within 0.1 %, the noise of a capture, and beside
    a body without a size.

    >>> relative_size(90.0, 60.0), relative_size(80.01, 80.0)
    (1.5, 1.0)
    """
    ratio = size / other if other > 0 else 1.0
    return 1.0 if abs(ratio - 1) < 1e-3 else ratio


def to_scale(features: np.ndarray, leg: float, new_leg: float) -> np.ndarray:
    """Features of a character with this leg as those of one with another, see `relative_size`.

    features : (T, 66);  leg, new_leg : lengths in one unit   ->  (T, 66)
    """
    return scale(features, relative_size(new_leg, leg))


def carries_hips(take: Take) -> bool:
    """Whether some joint of the take's file has the position channels that a path needs."""
    return carrier(take.clip.joints, int(take.mapping.joints[SLOT["Hips"]])) >= 0
