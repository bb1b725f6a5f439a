"""Points in: motion that is given as joint positions, (T, J, 3) in `.npy` or `.npz` files, as
networks put it out that make motion.

Twenty-one points are in the order of `joints.SLOTS`; twenty-two or twenty-four in that of SMPL and
HumanML3D. Others need a mapping of slots to numbers of joints. They become a clip on the 21 joints
that stands in a T-pose at rest, with the lengths of their bones (medians), and from there on are
like any other.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..storage import LARGEST_FILE, plausible, read_arrays, read_bytes, read_npy
from .canonical import change, measured
from .clip import POSITION_CHANNELS, Clip, Joint
from .joints import JOINTS, PARENTS, SLOT, SLOTS, MappingError
from .made_up import FINGER
from .skeleton import with_pose

ENDINGS = (".npy", ".npz")
# The slots among SMPL's joints: its spine1 and spine3 are Spine and Chest, its foot is the toe.
SMPL = dict(zip(SLOTS, (0, 1, 4, 7, 10, 2, 5, 8, 11, 3, 9, 12, 15, 16, 18, 20, 22, 17, 19, 21, 23)))
# Frames a second where none is told; 20 is HumanML3D's.
USUAL_RATES = {21: 60.0, 22: 20.0, 24: 20.0}
LONGEST = 1 << 28                # bytes of an array in a file


class PointsError(ValueError):
    """A file that holds no motion as points."""


def is_points(path: str | Path) -> bool:
    """Whether a file's name says that points are in it."""
    return str(path).lower().endswith(ENDINGS)


def read_points(path: str | Path, overrides: Mapping[str, str] | None = None,
                rate: float | None = None) -> Clip:
    """Read points as a clip of the 21 joints.

    overrides : {slot: number of the joint}, for other orders;  rate : frames a second, by the
    number of joints unless given   ->  Clip
    Raises PointsError, MappingError, OSError.
    """
    points = _array(path)
    frames, count = points.shape[:2]
    if not plausible(points):
        raise PointsError(f"{path}: found points that are not finite or beyond 1e9, needed motion")
    slots = _slots(count, dict(overrides or {}), path)
    whole = np.zeros((frames, JOINTS, 3))
    for slot, j in slots.items():
        whole[:, SLOT[slot]] = points[:, j]
    for side in ("Left", "Right"):
        if side + "Finger" not in slots:
            elbow, hand = (whole[:, SLOT[side + part]] for part in ("ForeArm", "Hand"))
            whole[:, SLOT[side + "Finger"]] = hand + FINGER * (hand - elbow)
    return clip_of_points(whole, rate or USUAL_RATES.get(count, 60.0))


def _array(path):
    """The one array of points in a file.   ->  (T, J, 3)"""
    data = read_bytes(path, LARGEST_FILE)
    try:
        found = ({"": read_npy(data)} if str(path).lower().endswith(".npy") else
                 read_arrays(data, most=LONGEST))
    except (ValueError, EOFError, OSError) as why:
        raise PointsError(f"{path}: found no array of numbers ({str(why)[:80]}), needed (T, J, 3); "
                          "a pickled dictionary must be saved as its array") from None
    shapes = {name: array.shape for name, array in found.items()}
    good = [array for array in found.values() if array.dtype.kind in "fi" and array.ndim in (3, 4)
            and array.shape[-1] == 3 and array.size and (array.ndim == 3 or len(array) == 1)]
    if len(good) != 1:
        raise PointsError(f"{path}: found {shapes}, needed one array (T, J, 3) of one motion")
    return np.asarray(good[0].reshape(good[0].shape[-3:]), dtype=float)


def _slots(count, overrides, path):
    """{slot: number of its joint}"""
    known = (dict(SLOT) if count == JOINTS else {s: j for s, j in SMPL.items() if j < count}
             if count in USUAL_RATES else {})
    for slot, number in overrides.items():
        if not number.isdigit() or int(number) >= count:
            raise MappingError(f"{path}: found joint {number!r} for {slot}, needed a number below "
                               f"{count}")
        known[slot] = int(number)
    missing = [s for s in SLOTS if s not in known and not s.endswith("Finger")]
    if missing:
        raise MappingError(
            f"{path}: found {count} points a frame and nothing for {', '.join(missing)}, needed 21 "
            "in this package's order, 22 or 24 in SMPL's, or a mapping file with lines slot,number")
    return known


def clip_of_points(points: np.ndarray, fps: float) -> Clip:
    """Points as a clip of the 21 joints, in a T-pose at rest, with the medians of their bones.

    points : (T, 21, 3)   ->  Clip in their unit and axes

    >>> from refimpl.motion.body import make_take
    >>> from refimpl.embedded.walkers import make_clip
    >>> positions = make_take(make_clip(seconds=0.5).clip).positions
    >>> again = make_take(clip_of_points(positions, 60.0)).positions
    >>> bool(abs(again - positions).max() < 1e-6)
    True
    """
    head, feet = points[:, SLOT["Head"]], points[:, [SLOT["LeftFoot"], SLOT["RightFoot"]]]
    rise = np.abs(np.mean(head - feet.mean(axis=1), axis=0))
    turn = np.eye(3)[[0, 2, 1]] * [[1], [1], [-1]] if rise[2] > rise[1] else np.eye(3)
    upright = points @ turn.T
    rest = measured(upright).rest
    offsets = rest - np.where(PARENTS[:, None] >= 0, rest[PARENTS], 0.0)
    found = change(np.broadcast_to(rest, points.shape), upright)
    world = turn.T @ found.turns                     # at rest no joint is turned
    local = np.stack([world[:, j] if parent < 0 else world[:, parent].swapaxes(1, 2) @ world[:, j]
                      for j, parent in enumerate(PARENTS)], axis=1)
    translations = np.broadcast_to(offsets, points.shape).copy()
    translations[:, 0] = points[:, 0]
    turns = ("Zrotation", "Xrotation", "Yrotation")
    joints = tuple(Joint(name, int(parent), tuple(map(float, offset)),
                         turns if parent >= 0 else POSITION_CHANNELS + turns)
                   for name, parent, offset in zip(SLOTS, PARENTS, offsets))
    ends = set(range(JOINTS)) - set(PARENTS.tolist())
    joints = tuple(Joint(j.name, j.parent, j.offset, j.channels, (0.0, 0.0, 0.0) if n in ends
                         else None) for n, j in enumerate(joints))
    return with_pose(Clip(joints, 1.0 / fps, np.zeros((len(points), 0))), local, translations,
                     1.0 / fps)
