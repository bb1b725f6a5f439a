"""The 21 joints of the papers' skeleton, and which joint of a file feeds each.

The slots are those of Holden's 2016 and 2017 systems (a CMU skeleton without the joints that barely
move). A file's joints are found by name; whoever has other names brings a mapping file with lines
`slot,joint`.
"""

from dataclasses import dataclass
import re

import numpy as np

from ..storage import read_table

SLOTS = ("Hips",
         "LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToe",
         "RightUpLeg", "RightLeg", "RightFoot", "RightToe",
         "Spine", "Chest", "Neck", "Head",
         "LeftArm", "LeftForeArm", "LeftHand", "LeftFinger",
         "RightArm", "RightForeArm", "RightHand", "RightFinger")
PARENTS = np.array([-1, 0, 1, 2, 3, 0, 5, 6, 7, 0, 9, 10, 11, 10, 13, 14, 15, 10, 17, 18, 19])
SLOT = {name: index for index, name in enumerate(SLOTS)}
JOINTS = len(SLOTS)
BONES = [(int(parent), joint) for joint, parent in enumerate(PARENTS) if parent >= 0]
HEELS = (SLOT["LeftFoot"], SLOT["RightFoot"])
TOES = (SLOT["LeftToe"], SLOT["RightToe"])
FEET = (HEELS[0], TOES[0], HEELS[1], TOES[1])                # the order of the contact labels
LEGS = [(SLOT[f"{side}UpLeg"], SLOT[f"{side}Leg"], SLOT[f"{side}Foot"], SLOT[f"{side}Toe"])
        for side in ("Left", "Right")]

# a made-up fingertip: this far beyond the hand, in forearm lengths
FINGER_PER_FOREARM = 0.175

# Names by family of skeletons, in the order of SLOTS. An empty name: the family has no such joint,
# the tip is made up.
FAMILIES = {
    "CMU": "Hips LeftUpLeg LeftLeg LeftFoot LeftToeBase RightUpLeg RightLeg RightFoot RightToeBase Spine Spine1 Neck1 Head "
    "LeftArm LeftForeArm LeftHand LeftHandIndex1 RightArm RightForeArm RightHand RightHandIndex1",
    "Mixamo": "Hips LeftUpLeg LeftLeg LeftFoot LeftToeBase RightUpLeg RightLeg RightFoot RightToeBase Spine Spine2 Neck Head "
    "LeftArm LeftForeArm LeftHand LeftHandMiddle1 RightArm RightForeArm RightHand RightHandMiddle1",
    "Bandai": "Hips UpperLeg_L LowerLeg_L Foot_L Toes_L UpperLeg_R LowerLeg_R Foot_R Toes_R Spine Chest Neck Head "
    "UpperArm_L LowerArm_L Hand_L - UpperArm_R LowerArm_R Hand_R -", "papers": " ".join(SLOTS), }


class MappingError(ValueError):
    """A skeleton whose joints do not feed all 21 slots, or a mapping file that names what is not
    there.
    """


@dataclass(frozen=True)
class Mapping:
    """Which joint of a file feeds each slot.

    joints : (21,) joint indices of the file;  tips : (21, 3) a point in that joint's own frame
    (zero: the joint itself; for a finger or a toe that the file lacks: a point beyond the hand or
    the foot);  family : the names that fitted, for `inspect`.
    """

    joints: np.ndarray
    tips: np.ndarray
    family: str

    def positions(self, world_rotations, world_positions):
        """The 21 points in the world.   (T, J, 3, 3), (T, J, 3)  ->  (T, 21, 3)"""
        return world_positions[:, self.joints] + (world_rotations[:, self.joints]
                                                  @ self.tips[:, :, None])[..., 0]


def plain_name(name):
    """A joint's name without a name space ("mixamorig:", "Character1_") and in lower case."""
    return re.sub(r"^(mixamorig\d*|character\d+|bip\d+)[:_ ]|^.*:", "", name.strip(),
                  flags=re.IGNORECASE).lower()


def map_joints(joints, overrides=None, name="the skeleton"):
    """Find the 21 slots among a file's joints.

    joints : the clip's tuple of bvh.Joint;  overrides : {slot: joint name} as `read_mapping` gives
    it.   ->  Mapping
    Raises MappingError that names the slots without a joint and the joints that are there.
    """
    overrides = overrides or {}
    by_name = {joint.name: index for index, joint in enumerate(joints)}
    by_plain = {plain_name(joint.name): index for index, joint in reversed(list(enumerate(joints)))}
    for slot, wanted in overrides.items():
        if wanted not in by_name:
            raise MappingError(
                f"mapping: found joint {wanted!r} for slot {slot}, needed one of "
                f"{', '.join(by_name)}")
    best = None
    for family, names in FAMILIES.items():
        found = {
            slot: by_plain[wanted.lower()] for slot, wanted in zip(SLOTS, names.split())
            if wanted.lower() in by_plain}
        found.update({slot: by_name[wanted] for slot, wanted in overrides.items()})
        if best is None or len(found) > len(best[1]):
            best = family, found
    family, found = best
    if set(overrides) >= set(SLOTS):
        family = "the mapping's"
    tips = np.zeros((JOINTS, 3))
    for side in ("Left", "Right"):
        for tip, base, make in ((f"{side}Finger", f"{side}Hand", _finger_tip),
                                (f"{side}Toe", f"{side}Foot", _toe_tip)):
            if tip not in found and base in found:
                point = make(joints, found[base])
                if point is not None:
                    found[tip], tips[SLOT[tip]] = found[base], point
    missing = [slot for slot in SLOTS if slot not in found]
    if missing:
        raise MappingError(
            f"{name}: found no joint for {', '.join(missing)} among {', '.join(by_name)}; "
            "needed all 21; give a mapping file with lines slot,joint")
    indices = np.array([found[slot] for slot in SLOTS])
    for slot, index, parent in zip(SLOTS, indices, PARENTS):
        if parent >= 0 and not _is_below(joints, index, indices[parent]):
            raise MappingError(
                f"{name}: found {joints[index].name!r} for {slot}, needed a joint below "
                f"{joints[indices[parent]].name!r}, which feeds {SLOTS[parent]}")
    return Mapping(indices, tips, family)


def _finger_tip(joints, hand):
    """Straight on from the forearm, as the bone lies in the hand's frame at rest."""
    return FINGER_PER_FOREARM * np.array(joints[hand].offset)


def _toe_tip(joints, foot):
    """The foot's own End Site, where there is one away from the ankle."""
    end = joints[foot].end_site
    return np.array(end) if end is not None and np.linalg.norm(end) > 0 else None


def _is_below(joints, index, ancestor):
    """Whether a joint hangs below another one, or is it (a made-up tip shares its base's joint)."""
    while index != ancestor and index >= 0:
        index = joints[index].parent
    return index == ancestor


def read_mapping(path):
    """A user's mapping file: CSV lines `slot,joint`, with or without that header; `#` begins a
    comment.

    ->  {slot: joint name}.   Raises MappingError with file and line.
    """
    overrides = {}
    for line, row in enumerate(read_table(path, "lines slot,joint", MappingError), start=1):
        if not any(row) or row[0].startswith("#") or (line == 1 and row == ["slot", "joint"]):
            continue
        if len(row) != 2 or row[0] not in SLOT or not row[1] or row[0] in overrides:
            raise MappingError(
                f"{path}:{line}: found {','.join(row)!r}, needed slot,joint with a slot not named "
                "before, "
                f"one of {', '.join(SLOTS)}")
        overrides[row[0]] = row[1]
    if not overrides:
        raise MappingError(f"{path}: found no line slot,joint, needed at least one")
    return overrides
