r"""From 21 moved points back to the rotations of the clip's own skeleton.

The network moves points; a BVH file needs rotations of bones that keep their length. From the hips
outwards each joint's world rotation is turned by the smallest amount that points its bones where
the points say, so that twist, fingers and every joint that feeds no slot come from the content
clip.
"""

import numpy as np

from . import rotation
from .clip import POSITION_CHANNELS
from .features import FPS
from .joints import PARENTS, SLOT
from .skeleton import forward_kinematics, with_pose


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
