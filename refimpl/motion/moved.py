r"""Back to the clip's own skeleton: a change of the 21 slots carried to every joint of the file.

A joint that feeds a slot turns with it. What feeds none is carried by the slot it hangs on: fingers
by the hand, collar bones by the chest, twist joints by the limb, further spine joints by the spine.
Thighs and collar bones belong to hips and chest wherever the file hangs them, and get position
channels where they need them for it. No bone changes its
length, and where nothing changes the clip is as it was.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .body import Take
from .canonical import Change, LongChange
from .clip import Clip, Joint
from .features import AT_A_TIME, FPS
from .joints import BONES, SLOT, Mapping
from .rotation import slerp
from .skeleton import (ancestors, carrier, forward_kinematics, local_pose, resample, with_poses)
from .strays import bridged


@dataclass(frozen=True)
class Rig:
    """How a file's joints follow the 21 slots.

    owner : for each joint the slot that it turns with, -1 for none
    carries : (21,) the slot with which the bone to each slot turns
    placed : {joint: slot} of joints that hang elsewhere than on the slot that carries them
    carrier : the joint whose position channels carry the hips, -1 for none
    """

    owner: tuple[int, ...]
    carries: tuple[int, ...]
    placed: dict[int, int]
    carrier: int


def rig(joints: Sequence[Joint], mapping: Mapping) -> Rig:
    """Which joint follows which slot."""
    own = {int(j): slot for slot, (j, tip) in enumerate(zip(mapping.joints, mapping.tips))
           if not tip.any()}
    owner = [-1] * len(joints)
    hips, spine = (int(mapping.joints[SLOT[name]]) for name in ("Hips", "Spine"))
    beside = -1                                      # above the hips where the spine leaves there
    if hips not in ancestors(joints, spine):
        beside = next(j for j in ancestors(joints, hips) if j in ancestors(joints, spine))
    for j, joint in enumerate(joints):
        inherited = owner[joint.parent] if joint.parent >= 0 else -1
        owner[j] = own.get(j, 0 if j == beside else inherited)
    placed: dict[int, int] = {}
    tops = {"LeftUpLeg": "Hips", "RightUpLeg": "Hips", "LeftArm": "Chest", "RightArm": "Chest"}
    for limb, base in tops.items():
        j = int(mapping.joints[SLOT[limb]])
        while joints[j].parent >= 0 and joints[j].parent not in own:
            j = joints[j].parent
            owner[j] = SLOT[base]
        parent = joints[j].parent
        if parent < 0 or owner[parent] == SLOT[base]:
            continue
        placed[j] = SLOT[base]
    carries = [0] * len(mapping.joints)
    for _, slot in BONES:
        j = int(mapping.joints[slot])
        carries[slot] = owner[j] if mapping.tips[slot].any() else owner[joints[j].parent]
    for limb, base in tops.items():
        carries[SLOT[limb]] = SLOT[base]
    return Rig(tuple(owner), tuple(max(slot, 0) for slot in carries), placed,
               carrier(joints, hips))


def moved_pose(clip: Clip, mapping: Mapping, how: Rig, rotations: np.ndarray,
               translations: np.ndarray, found: Change) -> tuple[np.ndarray, np.ndarray]:
    """A pose of the clip's joints after a change, both in the file's own axes.

    rotations (T, J, 3, 3), translations (T, J, 3)  ->  the same
    """
    joints = clip.joints
    world, old = forward_kinematics(clip.parents, rotations, translations)
    new = np.stack([found.turns[:, slot] @ world[:, j] if slot >= 0 else world[:, j]
                    for j, slot in enumerate(how.owner)], axis=1)
    local = np.stack([new[:, j] if joint.parent < 0 else
                      new[:, joint.parent].swapaxes(1, 2) @ new[:, j]
                      for j, joint in enumerate(joints)], axis=1)
    translations, hips = translations.copy(), int(mapping.joints[0])
    at = forward_kinematics(clip.parents, local, translations)[1]
    if how.carrier >= 0:
        miss = old[:, hips] + found.shift - at[:, hips]
        above = joints[how.carrier].parent
        translations[:, how.carrier] += miss if above < 0 else (miss[:, None] @ new[:, above])[:, 0]
    for j, slot in how.placed.items():
        at = forward_kinematics(clip.parents, local, translations)[1]
        base, above = int(mapping.joints[slot]), joints[j].parent
        there = (found.turns[:, slot] @ (old[:, j] - old[:, base])[..., None])[..., 0]
        wanted = at[:, base] + there
        translations[:, j] = ((wanted - at[:, above])[:, None] @ new[:, above])[:, 0]
    return local, translations


def sampled(found: Change | LongChange, times: np.ndarray) -> Change:
    """A change between its frames.   times : (U,) in frames  ->  Change of U frames"""
    last = len(found) - 1
    times = np.clip(times, 0, last)
    a = np.minimum(np.round(times, 9).astype(int), last)
    b, t = np.minimum(a + 1, last), np.round(times - a, 9)
    between = (t > 0)[:, None, None, None]
    here = found.at(a)
    if not between.any():
        return here
    there = found.at(b)
    return Change(np.where(between, slerp(here.turns, there.turns, t[:, None]), here.turns),
                  here.shift + t[:, None] * (there.shift - here.shift))


def _pose_of(clip, rows):
    """`local_pose` of some rows."""
    return local_pose(replace(clip, values=clip.values[rows]))


def moved_clip(take: Take, how: Rig, found: Change | LongChange,
               fps: float | None = None) -> Clip:
    """The take's clip after a change of its motion, its strays as they were.

    how : of `rig`;  found : at 60 frames a second, y up;  fps : frames a second of the result, the
    clip's unless given   ->  Clip
    """
    clip, strays, own = take.clip, take.strays, take.clip.fps
    rate, rows = fps or own, len(clip.values)
    whole_pose = (None if rate == own else
                  resample(*bridged(*local_pose(clip), strays), own, rate))
    count = strays.end - strays.begin if whole_pose is None else len(whole_pose[0])
    every, turn = rate / own, take.upright
    before, after = ((np.arange(round(n * every)) / every).astype(int) + first
                     for n, first in ((strays.begin, 0), (rows - strays.end, strays.end)))

    def _poses():
        yield _pose_of(clip, before)
        for n in range(0, count, AT_A_TIME):         # a pose takes ten times the clip's memory
            some = np.arange(n, min(n + AT_A_TIME, count))
            pose = (_pose_of(clip, strays.begin + some) if whole_pose is None else
                    (whole_pose[0][some], whole_pose[1][some]))
            here = sampled(found, some * (FPS / rate))
            here = Change(turn.T @ here.turns @ turn, here.shift @ turn)
            moved = moved_pose(clip, take.mapping, how, pose[0], pose[1], here)
            at = np.minimum(strays.begin + np.rint(some / every).astype(int), rows - 1)
            lost = strays.lost[at]
            for new, old in zip(moved, _pose_of(clip, at[lost])):
                new[lost] = old
            yield moved
        yield _pose_of(clip, after)

    return with_poses(clip, len(before) + count + len(after), _poses(),
                      clip.frame_time if rate == own else 1.0 / rate, free=how.placed)
