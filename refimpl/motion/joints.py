"""The 21 joints of the papers' skeleton, and which joint of a file feeds each.

The slots are those of Holden's 2016 and 2017 systems (a CMU skeleton without the joints that barely
move). `mapping.map_clip` finds a file's joints; whoever wants others brings a mapping file with
lines `slot,joint`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .tables import read_table

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


class MappingError(ValueError):
    """A skeleton whose joints do not feed all 21 slots, or a mapping file that names what is not
    there.

    guesses : {slot: joint name} of what was found nevertheless
    """

    def __init__(self, text: str, guesses: dict[str, str] | None = None) -> None:
        super().__init__(text)
        self.guesses = guesses or {}


@dataclass(frozen=True)
class Mapping:
    """Which joint of a file feeds each slot.

    joints : (21,) joint indices of the file
    tips : (21, 3) a point in that joint's own frame: zero for the joint itself, and a point beside
        it for a slot that the file has no joint for and that was made up
    how : for each slot what found it: "name", "tree", "mapping", or how it was made up
    """

    joints: np.ndarray
    tips: np.ndarray
    how: tuple[str, ...]

    @property
    def made_up(self) -> dict[str, str]:
        """{slot: how} of the slots that were made up."""
        return {slot: how for slot, how, tip in zip(SLOTS, self.how, self.tips) if tip.any()}

    def positions(self, world_rotations: np.ndarray, world_positions: np.ndarray, *,
                  slots: Sequence[int] | slice = slice(None)) -> np.ndarray:
        """The 21 points in the world, or those of some slots.

        world_rotations : (T, J, 3, 3), world_positions : (T, J, 3)  ->  (T, 21 or fewer, 3)
        """
        joints, tips = self.joints[slots], self.tips[slots]
        return (world_positions[:, joints]
                + (world_rotations[:, joints] @ tips[:, :, None])[..., 0])


def read_mapping(path: str | Path) -> dict[str, str]:
    """A user's mapping file: CSV lines `slot,joint`, with or without that header; `#` begins a
    comment, and a joint `?` leaves the slot to be found.

    path : the file  ->  {slot: joint name}.   Raises MappingError with file and line.
    """
    overrides: dict[str, str] = {}
    for line, row in enumerate(read_table(path, "lines slot,joint", MappingError), start=1):
        if not any(row) or row[0].startswith("#") or (line == 1 and row == ["slot", "joint"]):
            continue
        if (len(row) != 2 or row[0] not in SLOT or not row[1] or row[0] in overrides
                or row[1] in overrides.values()):
            raise MappingError(
                f"{path}:{line}: found {','.join(row)!r}, needed slot,joint with a slot and a "
                f"joint not named before, the slot one of {', '.join(SLOTS)}")
        if row[1] != "?":                            # what `inspect` could not tell
            overrides[row[0]] = row[1]
    if not overrides:
        raise MappingError(f"{path}: found no line slot,joint, needed at least one")
    return overrides
