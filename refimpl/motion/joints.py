"""The 21 joints of the papers' skeleton, and which joint of a file feeds each.

The slots are those of Holden's 2016 and 2017 systems (a CMU skeleton without the joints that barely
move). A file's joints are found by name; whoever has other names brings a mapping file with lines
`slot,joint`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
import re

import numpy as np

from ..storage import read_table
from .clip import Joint
from .skeleton import ancestors

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

FINGER_PER_FOREARM = 0.175       # a made-up fingertip: so far beyond the hand, in forearm lengths

# Names by family of skeletons, in the order of SLOTS. A hyphen: the family has no such joint, and
# the tip is made up.
FAMILIES = {
    "CMU": "Hips LeftUpLeg LeftLeg LeftFoot LeftToeBase RightUpLeg RightLeg RightFoot RightToeBase "
           "Spine Spine1 Neck1 Head LeftArm LeftForeArm LeftHand LeftHandIndex1 "
           "RightArm RightForeArm RightHand RightHandIndex1",
    "Mixamo": "Hips LeftUpLeg LeftLeg LeftFoot LeftToeBase "
              "RightUpLeg RightLeg RightFoot RightToeBase "
              "Spine Spine2 Neck Head LeftArm LeftForeArm LeftHand LeftHandMiddle1 "
              "RightArm RightForeArm RightHand RightHandMiddle1",
    "Bandai": "Hips UpperLeg_L LowerLeg_L Foot_L Toes_L UpperLeg_R LowerLeg_R Foot_R Toes_R "
              "Spine Chest Neck Head UpperArm_L LowerArm_L Hand_L - UpperArm_R LowerArm_R Hand_R -",
    "papers": " ".join(SLOTS)}


class MappingError(ValueError):
    """A skeleton whose joints do not feed all 21 slots, or a mapping file that names what is not
    there.
    """


@dataclass(frozen=True)
class Mapping:
    """Which joint of a file feeds each slot.

    joints : (21,) joint indices of the file
    tips : (21, 3) a point in that joint's own frame: zero for the joint itself, and a point beyond
        the hand or the foot for a finger or a toe that the file lacks
    family : the names that fitted, for `inspect`
    """

    joints: np.ndarray
    tips: np.ndarray
    family: str

    def positions(self, world_rotations: np.ndarray, world_positions: np.ndarray, *,
                  slots: Sequence[int] | slice = slice(None)) -> np.ndarray:
        """The 21 points in the world, or those of some slots.

        world_rotations : (T, J, 3, 3), world_positions : (T, J, 3)  ->  (T, 21 or fewer, 3)
        """
        joints, tips = self.joints[slots], self.tips[slots]
        return (world_positions[:, joints]
                + (world_rotations[:, joints] @ tips[:, :, None])[..., 0])


def plain_name(name: str) -> str:
    """A joint's name without a name space and in lower case.

    >>> plain_name("mixamorig:LeftFoot"), plain_name("Character1_Hips")
    ('leftfoot', 'hips')
    """
    return re.sub(r"^(mixamorig\d*|character\d+|bip\d+)[:_ ]|^.*:", "", name.strip(),
                  flags=re.IGNORECASE).lower()


def map_joints(joints: Sequence[Joint], overrides: dict[str, str] | None = None,
               name: str = "the skeleton") -> Mapping:
    """Find the 21 slots among a file's joints.

    joints : those of the clip;  overrides : {slot: joint name} as `read_mapping` gives it
    name : the file's, for messages   ->  Mapping
    Raises MappingError that names the slots without a joint and the joints that are there.

    >>> names = FAMILIES["CMU"].split()
    >>> joints = [Joint(n, int(p), (0.0, 1.0, 0.0), ()) for n, p in zip(names, PARENTS)]
    >>> map_joints(joints).family
    'CMU'
    """
    overrides = overrides or {}
    by_name = {joint.name: index for index, joint in enumerate(joints)}
    by_plain = {plain_name(joint.name): index for index, joint in reversed(list(enumerate(joints)))}
    for slot, wanted in overrides.items():
        if wanted not in by_name:
            raise MappingError(f"mapping: found joint {wanted!r} for slot {slot}, needed one of "
                               f"{', '.join(by_name)}")
    given = {slot: by_name[wanted] for slot, wanted in overrides.items()}
    fits = {family: {slot: by_plain[wanted.lower()] for slot, wanted in zip(SLOTS, names.split())
                     if wanted.lower() in by_plain} | given
            for family, names in FAMILIES.items()}
    family = max(fits, key=lambda family: len(fits[family]))         # the first of equals
    found = fits[family]
    tips = np.zeros((JOINTS, 3))
    for side in ("Left", "Right"):
        for tip, base, make in ((f"{side}Finger", f"{side}Hand", _finger_tip),
                                (f"{side}Toe", f"{side}Foot", _toe_tip)):
            point = make(joints[found[base]]) if tip not in found and base in found else None
            if point is not None:
                found[tip], tips[SLOT[tip]] = found[base], point
    missing = [slot for slot in SLOTS if slot not in found]
    if missing:
        raise MappingError(
            f"{name}: found no joint for {', '.join(missing)} among {', '.join(by_name)}; "
            "needed all 21; give a mapping file with lines slot,joint")
    indices = [found[slot] for slot in SLOTS]
    for parent, child in BONES:
        if indices[parent] not in ancestors(joints, indices[child]):     # a tip may be its base
            raise MappingError(
                f"{name}: found {joints[indices[child]].name!r} for {SLOTS[child]}, needed a joint "
                f"below {joints[indices[parent]].name!r}, which feeds {SLOTS[parent]}")
    by_family = {slot for slot, joint in found.items() if slot not in given and not
                 tips[SLOT[slot]].any()}
    family = " and ".join([family] * bool(by_family) + ["the mapping's"] * bool(given))
    return Mapping(np.array(indices), tips, family)


def _finger_tip(hand):
    """Straight on from the forearm, as the bone lies in the hand's frame at rest."""
    return FINGER_PER_FOREARM * np.array(hand.offset)


def _toe_tip(foot):
    """The foot's own End Site, where there is one away from the ankle."""
    return np.array(foot.end_site) if np.any(foot.end_site or 0) else None


def read_mapping(path: str | Path) -> dict[str, str]:
    """A user's mapping file: CSV lines `slot,joint`, with or without that header; `#` begins a
    comment.

    path : the file  ->  {slot: joint name}.   Raises MappingError with file and line.
    """
    overrides: dict[str, str] = {}
    for line, row in enumerate(read_table(path, "lines slot,joint", MappingError), start=1):
        if not any(row) or row[0].startswith("#") or (line == 1 and row == ["slot", "joint"]):
            continue
        if len(row) != 2 or row[0] not in SLOT or not row[1] or row[0] in overrides:
            raise MappingError(
                f"{path}:{line}: found {','.join(row)!r}, needed slot,joint with a slot not named "
                f"before, one of {', '.join(SLOTS)}")
        overrides[row[0]] = row[1]
    if not overrides:
        raise MappingError(f"{path}: found no line slot,joint, needed at least one")
    return overrides
