"""A clip made ready for the networks: read, mapped to the 21 joints, at 60 frames a second, y up,
with its 66 numbers.
"""

from dataclasses import dataclass, field

import numpy as np

from ..storage import plausible
from . import bvh
from .features import FPS, LEG_RANGE, Start, encode, leg_length
from .joints import BONES, HEELS, SLOT, Mapping, map_joints
from .prepare import foot_contacts
from .skeleton import clip_at, forward_kinematics

# Turns a z-up world into a y-up one: (x, y, z) -> (x, z, -y).
_Z_UP_TO_Y_UP = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])


@dataclass(frozen=True)
class Take:
    """One clip and everything derived from it, in the file's own length unit.

    clip : as read;  rotations (T, J, 3, 3), translations (T, J, 3) : its pose at 60 frames a
    second;  mapping : file joints to slots;
    upright : (3, 3) that turns the file's world y-up;  positions (T, 21, 3) : y up;  features (T,
    66), start, contacts (T, 4).
    """

    clip: bvh.Clip
    rotations: np.ndarray = field(repr=False)
    translations: np.ndarray = field(repr=False)
    mapping: Mapping
    upright: np.ndarray
    positions: np.ndarray = field(repr=False)
    features: np.ndarray = field(repr=False)
    start: Start
    contacts: np.ndarray = field(repr=False)

    @property
    def leg(self):
        return leg_length(self.positions)


def make_take(clip, overrides=None, name="the clip"):
    """Clip, {slot: joint}  ->  Take.
    Raises MappingError (a joint is missing) or ValueError (no legs, nothing finite).
    """
    mapping = map_joints(clip.joints, overrides, name)
    # what is beyond all measure is told below
    with np.errstate(over="ignore", invalid="ignore"):
        rotations, translations = clip_at(clip, FPS)
        positions = mapping.positions(*forward_kinematics(clip.parents, rotations, translations))
        upright = _Z_UP_TO_Y_UP if up_axis(positions) == "z" else np.eye(3)
        positions = positions @ upright.T
        leg = leg_length(positions)
    if not leg > 0:
        raise ValueError(
            f"{name}: found legs of length 0, needed thighs and shins; are all offsets and "
            "positions 0?")
    if not LEG_RANGE[0] <= leg <= LEG_RANGE[1] or not plausible(positions):
        raise ValueError(
            f"{name}: found a leg {leg:g} long and joints up to {np.abs(positions).max():g} away, "
            "needed a "
            f"leg from {LEG_RANGE[0]:g} to {LEG_RANGE[1]:g} and joints within 1e9; is an OFFSET or "
            "a position absurd?")
    across = positions[:, SLOT["LeftUpLeg"]] - positions[:, SLOT["RightUpLeg"]]
    if not np.linalg.norm(across[:, [0, 2]], axis=1).min() > 0:
        raise ValueError(
            f"{name}: found hips with no width in some frame, needed two different hip joints to "
            "know where it faces")
    features, start = encode(positions)
    if not np.isfinite(features).all():
        raise ValueError(
            f"{name}: found shoulders exactly opposite to the hips in some frame, needed to know "
            "where the body faces")
    return Take(clip, rotations, translations, mapping, upright, positions, features, start,
                foot_contacts(positions, start.floor))


def read_take(path, overrides=None):
    """Read a BVH file and make it ready.   path, {slot: joint}  ->  Take.
    Raises BVHError, MappingError, ValueError, OSError.
    """
    try:
        return make_take(bvh.read_bvh(path), overrides, str(path))
    except ValueError as error:
        if str(path) in str(error):
            raise
        raise ValueError(f"{path}: {error}") from None


def up_axis(positions):
    """"y" or "z": the axis along which the head is farther from the ankles, over all frames.
    (T, 21, 3)  ->  str
    """
    rise = np.abs(np.mean(positions[:, SLOT["Head"]] - positions[:, HEELS].mean(axis=1), axis=0))
    return "z" if rise[2] > rise[1] else "y"


def bone_lengths(positions):
    """Median length of each bone of `joints.BONES`.   (T, 21, 3)  ->  (20,)"""
    parents, children = np.array(BONES).T
    return np.median(np.linalg.norm(positions[:, children] - positions[:, parents], axis=-1),
                     axis=0)


def standing_height(lengths):
    """Height of the head joint above the floor when standing straight: ankle (0.147 legs) + leg +
    trunk + neck.   (20,)  ->  float
    """
    by_joint = dict(zip((child for _, child in BONES), lengths))
    leg = by_joint[SLOT["LeftLeg"]] + by_joint[SLOT["LeftFoot"]]
    return float(1.147 * leg + sum(by_joint[SLOT[name]]
                                   for name in ("Spine", "Chest", "Neck", "Head")))


def guess_unit(height):
    """The likely length unit of a skeleton whose head joint stands this high (an adult's: about 1.4
    m).
    """
    for unit, low, high in (("metres", 0.9, 2.2), ("inches", 36.0, 80.0),
                            ("centimetres", 90.0, 220.0), ("millimetres", 900.0, 2200.0)):
        if low <= height <= high:
            return unit
    return f"units of about {140.0 / height:.2g} cm"
