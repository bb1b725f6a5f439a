"""A body in motion: a clip made ready for the networks, and the way back to its own skeleton.

There, a clip is read, mapped to the 21 joints, brought to 60 frames a second and y up, and turned into
its 66 numbers. Back, the networks move points while a BVH file needs rotations of bones that keep
their length: from the hips outwards each joint's world rotation is turned by the smallest amount
that points its bones where the points say, so that twist, fingers and every joint that feeds no slot
come from the content clip.
"""

from dataclasses import dataclass, field

import numpy as np

from ..storage import plausible
from . import bvh, rotation
from .clip import POSITION_CHANNELS
from .features import FPS, LEG_RANGE, Start, encode, leg_length, scale
from .joints import BONES, HEELS, PARENTS, SLOT, Mapping, map_joints
from .feet import foot_contacts
from .skeleton import clip_at, forward_kinematics, with_pose

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


def to_scale(features, leg, new_leg):
    """Features of a character with this leg as those of one with another; left alone within 0.1 %,
    the noise of a capture.
    """
    return features if abs(new_leg / leg - 1) < 1e-3 else scale(features, new_leg / leg)


def fit_pose(take, targets):
    r"""Local rotations and translations that bring the clip's skeleton onto the target points.

    For joint j with world rotation R_j in the content clip, already turned with its parent by A:

    - one child point:  D_j = shortest_rotation(A a, b) A,
      a = the bone in the content clip, b = the bone between the targets;
    - several (hips, chest):  D_j = best_rotation(a_n, b_n), the least-squares rotation of all of
      them;
    - none (a head, a finger):  D_j = A.

    The new world rotation is D_j R_j. A joint between two slots (a collar bone) points from where
    it is to the next target.

    take : Take, targets : (T, 21, 3) in the take's own unit, y up  ->  rotations (T, J, 3, 3),
    translations (T, J, 3)
    """
    parents = take.clip.parents
    # back into the file's own axes
    targets = targets @ take.upright
    world_rotations, world = forward_kinematics(parents, take.rotations, take.translations)
    slot_of = _joint_slots(take.mapping)
    goals = _goals(parents, take.mapping, slot_of)
    hips = take.mapping.joints[SLOT["Hips"]]

    translations = take.translations.copy()
    turned, new_rotations, new_world = [None] * len(parents), [None] * len(parents), [
        None] * len(parents)
    rotations = take.rotations.copy()
    carrier = _carrier(take.clip, hips)
    for j, parent in enumerate(parents):
        above = new_rotations[parent] if parent >= 0 else np.broadcast_to(
            np.eye(3), world_rotations[:, 0].shape)
        if j == carrier:
            goal = targets[:, SLOT["Hips"]] - (world[:, hips] - world[:, carrier])
            origin = new_world[parent] if parent >= 0 else 0.0
            translations[:, j] = ((goal - origin)[:, None] @ above)[:, 0]
        place = (above @ translations[:, j, :, None])[..., 0]
        new_world[j] = place if parent < 0 else new_world[parent] + place

        turn = turned[parent] if parent >= 0 else np.broadcast_to(np.eye(3), above.shape)
        if goals[j]:
            # (T, n, 3)
            content = _points(take.mapping, world_rotations, world, goals[j]) - world[:, j, None]
            start = targets[:, slot_of[j], None] if j in slot_of else new_world[j][:, None]
            wanted = targets[:, goals[j]] - start
            turn = _turn(turn, content, wanted)
        turned[j], new_rotations[j] = turn, turn @ world_rotations[:, j]
        rotations[:, j] = above.swapaxes(1, 2) @ new_rotations[j]
    return rotations, translations


def _turn(turn, content, wanted):
    """Turn on from the parent's turn: by the shortest rotation for one bone, by the best one for
    several.
    """
    if content.shape[1] == 1:
        bone = (turn @ content[:, 0, :, None])[..., 0]
        return rotation.shortest_rotation(bone, wanted[:, 0]) @ turn
    return rotation.best_rotation(content, wanted)


def _joint_slots(mapping):
    """{file joint: slot} of the joints that are slots themselves (a made-up tip is not)."""
    return {
        int(joint): slot for slot, joint in enumerate(mapping.joints)
        if not mapping.tips[slot].any()}


def _goals(parents, mapping, slot_of):
    """For each joint of the file the slots that it points at: the nearest ones below it on every
    branch.

    Joints above the hips and beside the 21 slots' tree point at nothing.
    ->  list of lists of slots
    """
    goals = [[] for _ in parents]
    for slot, parent_slot in enumerate(PARENTS):
        if parent_slot < 0:
            continue
        base = mapping.joints[parent_slot]
        if mapping.tips[slot].any():
            # a tip: its base joint points at it
            goals[mapping.joints[slot]].append(slot)
            continue
        j = mapping.joints[slot]
        while j != base:
            j = parents[j]
            goals[j].append(slot)
    return [_nearest(slots) for slots in goals]


def _nearest(slots):
    """Drop a slot whose parent slot is in the list as well (a joint above a whole limb points at
    the limb's root).
    """
    return [slot for slot in slots if PARENTS[slot] not in slots]


def _points(mapping, world_rotations, world, slots):
    """World positions of some slots.   ->  (T, n, 3)"""
    joints = mapping.joints[slots]
    return world[:, joints] + (world_rotations[:, joints] @ mapping.tips[slots][:, :, None])[..., 0]


def _carrier(clip, hips):
    """The joint whose position channels carry the hips: the hips themselves or the nearest joint
    above that has all three.

    Without any the skeleton stays where it is.
    """
    j = hips
    while j >= 0 and not set(POSITION_CHANNELS) <= set(clip.joints[j].channels):
        j = clip.joints[j].parent
    return j


def carries_hips(take):
    """Whether some joint of the take's file has the position channels that a path needs.   ->  bool
    """
    return _carrier(take.clip, int(take.mapping.joints[SLOT["Hips"]])) >= 0


def to_clip(take, targets):
    """The take's clip with its 21 points moved to the targets, at 60 frames a second: ready for
    `bvh.write_bvh`.

    take : Take, targets : (T, 21, 3)  ->  Clip on the same joints with T frames
    """
    return with_pose(take.clip, *fit_pose(take, targets), 1.0 / FPS)


def points(take, rotations, translations):
    """The 21 points of a pose of the take's skeleton, y up.
    (T, J, 3, 3), (T, J, 3)  ->  (T, 21, 3)
    """
    return take.mapping.positions(
        *forward_kinematics(take.clip.parents, rotations, translations)) @ take.upright.T
