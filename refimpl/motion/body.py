"""A body in motion: a clip made ready for the networks, and moved points brought back to its
skeleton.

There, a clip is read, mapped to the 21 joints, brought to 60 frames a second and y up, and turned
into its 66 numbers. Back, the networks move points while a BVH file needs rotations of bones that
keep their length: from the hips outwards each joint's world rotation is turned by the smallest
amount that points its bones where the points say, so that twist, fingers and every joint that feeds
no slot come from the content clip.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ..storage import plausible
from . import bvh, rotation
from .clip import Clip, plus_offsets
from .extend import extended
from .features import FLOOR, FPS, LEG_RANGE, Start, encode, leg_length, root_motion, scale
from .ground import planted_feet, resting_heights
from .joints import BONES, HEELS, PARENTS, SLOT, Mapping
from .mapping import map_clip
from .skeleton import (ancestors, carrier, forward_kinematics, local_pose, resample, with_pose)
from .strays import Strays, bridged, find_strays

MARGIN = 48          # frames beyond both ends: the networks see 36 + 13 to each side of a frame
# Turns a z-up world into a y-up one: (x, y, z) -> (x, z, -y).
_Z_UP_TO_Y_UP = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])


@dataclass(frozen=True)
class Take:
    """One clip and everything derived from it, in the file's own length unit.

    clip : as read
    rotations (T, J, 3, 3), translations (T, J, 3) : its pose at 60 frames a second
    mapping : which joint of the file feeds each slot
    upright : (3, 3) turns the file's world y up
    positions : (T, 21, 3), y up
    features (T, 66), start, contacts (T, 4) : the 66 numbers, what they leave out, planted feet
    around : (T + 2 MARGIN, 66), the features with frames before and after, in which the clip goes
    on (`extend`), for networks that look to both sides of a frame
    strays : the clip's rows that are not part of its motion, of which all the rest knows nothing
    """

    clip: Clip
    rotations: np.ndarray = field(repr=False)
    translations: np.ndarray = field(repr=False)
    mapping: Mapping
    upright: np.ndarray
    positions: np.ndarray = field(repr=False)
    features: np.ndarray = field(repr=False)
    start: Start
    contacts: np.ndarray = field(repr=False)
    around: np.ndarray = field(repr=False)
    strays: Strays = field(repr=False)

    @property
    def toes(self) -> np.ndarray:
        """At which height the left and the right toe joint rest.   ->  (2,)"""
        return resting_heights(self.positions)[1::2]

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
    mapping = map_clip(clip, overrides, name)
    with np.errstate(over="ignore", invalid="ignore"):       # what is absurd is refused below
        strays = find_strays(mapping.positions(*forward_kinematics(clip.parents,
                                                                   *local_pose(clip))), clip.fps)
        rotations, translations = resample(*bridged(*local_pose(clip), strays), clip.fps, FPS)
        positions = mapping.positions(*forward_kinematics(clip.parents, rotations, translations))
        upright = _Z_UP_TO_Y_UP if up_axis(positions) == "z" else np.eye(3)
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
    around, first = encode(extended(positions, MARGIN), floor)
    root, yaw = root_motion(around, first)
    features = around[MARGIN:-MARGIN]
    start = Start(float(root[MARGIN, 0]), float(root[MARGIN, 2]), float(yaw[MARGIN]), floor)
    if not np.isfinite(features).all():
        raise ValueError(f"{name}: found shoulders exactly opposite to the hips in some frame, "
                         "needed to know where the body faces")
    return Take(clip, rotations, translations, mapping, upright, positions, features, start,
                contacts, around, strays)


def read_clip(path: str | Path, *, rate: float | None = None, positions: str = "replace") -> Clip:
    """Read a BVH file that may say what is not so.

    path : the file;  rate : its frames a second, where its Frame Time is wrong;  positions : "add"
    where position channels hold differences from the OFFSET   ->  Clip
    Raises BVHError, OSError.
    """
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
        return make_take(read_clip(path, rate=rate, positions=positions), overrides, str(path))
    except ValueError as error:
        if str(path) in str(error):
            raise
        raise ValueError(f"{path}: {error}") from None


def with_strays(take: Take, rotations: np.ndarray,
                translations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A new pose for the take's motion, with the rows that are not part of it as they were.

    rotations (T, J, 3, 3), translations (T, J, 3), 60 frames a second  ->  the same for all rows
    """
    strays, every = take.strays, FPS / take.clip.fps
    own = local_pose(take.clip)
    counts = [round(strays.begin * every), round((take.clip.frames - strays.end) * every)]
    rows = [(np.arange(n) / every).astype(int) + first for n, first in zip(counts, (0, strays.end))]
    lost = np.flatnonzero(strays.lost[strays.begin:strays.end])
    at = np.rint(np.arange(len(rotations)) / every).astype(int)
    found = []
    for new, old in zip((rotations, translations), own):
        new = new.copy()
        back = np.isin(at, lost)
        new[back] = old[strays.begin + at[back]]
        found.append(np.concatenate([old[rows[0]], new, old[rows[1]]]))
    return found[0], found[1]


def up_axis(positions: np.ndarray) -> str:
    """Which way is up: the axis along which the head is farther from the ankles, over all frames.

    positions : (T, 21, 3)  ->  "y" or "z"

    >>> body = np.zeros((1, 21, 3))
    >>> body[:, SLOT["Head"]] = [0, 20, 150]
    >>> up_axis(body)
    'z'
    """
    rise = np.abs(np.mean(positions[:, SLOT["Head"]] - positions[:, HEELS].mean(axis=1), axis=0))
    return "z" if rise[2] > rise[1] else "y"


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


def fit_pose(take: Take, targets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    r"""Local rotations and translations that bring the clip's skeleton onto the target points.

    For joint j with world rotation R_j in the content clip, already turned with its parent by A:

    - one child point:  D_j = shortest_rotation(A a, b) A,
      a = the bone in the content clip, b = the bone between the targets;
    - several (hips, chest):  D_j = best_rotation(a_n, b_n), the least-squares rotation of all of
      them;
    - none (a head, a finger):  D_j = A.

    The new world rotation is D_j R_j. A joint between two slots (a collar bone) points from where
    it is to the next target.

    take : the content;  targets : (T, 21, 3) in the take's own unit, y up
    ->  rotations (T, J, 3, 3), translations (T, J, 3)
    """
    clip, mapping = take.clip, take.mapping
    targets = targets @ take.upright                 # back into the file's own axes
    old_rotations, old = forward_kinematics(clip.parents, take.rotations, take.translations)
    slot_of = {int(joint): slot for slot, joint in enumerate(mapping.joints)
               if not mapping.tips[slot].any()}
    goals = _goals(clip.joints, mapping)
    hips = int(mapping.joints[SLOT["Hips"]])
    carrying = carrier(clip.joints, hips)

    rotations, translations = take.rotations.copy(), take.translations.copy()
    still = np.broadcast_to(np.eye(3), rotations[:, 0].shape)
    turns, new_rotations, new = {-1: still}, {-1: still}, {-1: np.zeros_like(old[:, 0])}
    for j, parent in enumerate(clip.parents):
        above = new_rotations[parent]
        if j == carrying:
            goal = targets[:, SLOT["Hips"]] - (old[:, hips] - old[:, j])
            translations[:, j] = ((goal - new[parent])[:, None] @ above)[:, 0]
        new[j] = new[parent] + (above @ translations[:, j, :, None])[..., 0]
        turns[j] = turns[parent]
        if goals[j]:
            start = targets[:, slot_of[j]] if j in slot_of else new[j]
            content = mapping.positions(old_rotations, old, slots=goals[j]) - old[:, j, None]
            wanted = targets[:, goals[j]] - start[:, None]           # (T, n, 3), like content
            if len(goals[j]) == 1:
                bone = (turns[j] @ content[:, 0, :, None])[..., 0]
                turns[j] = rotation.shortest_rotation(bone, wanted[:, 0]) @ turns[j]
            else:
                turns[j] = rotation.best_rotation(content, wanted)
        new_rotations[j] = turns[j] @ old_rotations[:, j]
        rotations[:, j] = above.swapaxes(1, 2) @ new_rotations[j]
    return rotations, translations


def _goals(joints, mapping):
    """For each joint of the file the slots that it points at: the nearest ones below it on every
    branch. Joints above the hips and beside the 21 slots' tree point at nothing.

    ->  list of lists of slots
    """
    goals: list[list[int]] = [[] for _ in joints]
    for parent, slot in BONES:
        above = ancestors(joints, mapping.joints[slot])
        if mapping.tips[slot].any():                 # its base joint points at a made-up tip
            goals[above[0]].append(slot)
        else:
            for j in above[1:above.index(mapping.joints[parent]) + 1]:
                goals[j].append(slot)
    # a joint above a whole limb points at the limb's root
    return [[slot for slot in slots if PARENTS[slot] not in slots] for slots in goals]


def carries_hips(take: Take) -> bool:
    """Whether some joint of the take's file has the position channels that a path needs."""
    return carrier(take.clip.joints, int(take.mapping.joints[SLOT["Hips"]])) >= 0


def to_clip(take: Take, targets: np.ndarray) -> Clip:
    """The take's clip with its 21 points moved to the targets, at 60 frames a second: ready for
    `bvh.write_bvh`.

    take : the content;  targets : (T, 21, 3)  ->  Clip on the same joints with T frames
    """
    return with_pose(take.clip, *fit_pose(take, targets), 1.0 / FPS)


def points(take: Take, rotations: np.ndarray, translations: np.ndarray) -> np.ndarray:
    """The 21 points of a pose of the take's skeleton, y up.

    rotations : (T, J, 3, 3), translations : (T, J, 3)  ->  (T, 21, 3)
    """
    world = forward_kinematics(take.clip.parents, rotations, translations)
    return take.mapping.positions(*world) @ take.upright.T
