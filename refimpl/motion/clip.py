"""What a clip is: joints, channels and a table of numbers, nothing lost of the BVH file it came
from.
"""

from dataclasses import dataclass, field

import numpy as np

POSITION_CHANNELS = ("Xposition", "Yposition", "Zposition")
ROTATION_CHANNELS = ("Xrotation", "Yrotation", "Zrotation")


class BVHError(ValueError):
    """A file that is not the BVH it should be; the message names file and line, what was found and
    what was needed.
    """


@dataclass(frozen=True)
class Joint:
    """One joint of the hierarchy.

    parent : index of the parent joint, -1 for the root;  offset : (x, y, z) from the parent in the
    file's length unit;
    channels : names in file order;  end_site : (x, y, z) of the End Site below this joint, or None.
    """

    name: str
    parent: int
    offset: tuple
    channels: tuple
    end_site: tuple = None

    @property
    def rotation_order(self):
        """The axes of the rotation channels as listed, for example "ZXY"."""
        return "".join(c[0] for c in self.channels if c in ROTATION_CHANNELS)


@dataclass(frozen=True)
class Clip:
    """The content of a BVH file, nothing lost: joints in file order, seconds a frame, and the raw
    channel values.

    values : (frames, channels) float64, degrees and length units as in the file.
    """

    joints: tuple
    frame_time: float
    values: np.ndarray = field(repr=False)

    @property
    def names(self):
        return tuple(joint.name for joint in self.joints)

    @property
    def parents(self):
        return np.array([joint.parent for joint in self.joints])

    @property
    def frames(self):
        return len(self.values)

    @property
    def fps(self):
        """Frames a second. Files round 1/30 to 0.0333333; a rate within 0.01 % of a whole number is
        taken as that number.
        """
        rate = 1.0 / self.frame_time
        return float(round(rate)) if abs(rate - round(rate)) < 1e-4 * rate else rate
