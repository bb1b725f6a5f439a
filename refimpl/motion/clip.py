"""What a clip is: joints, channels and a table of numbers, nothing lost of the BVH file it came
from.
"""

from dataclasses import dataclass, field, replace

import numpy as np

POSITIONS_MEAN = ("replace", "add")      # what a position channel does to its joint's OFFSET
POSITION_CHANNELS = ("Xposition", "Yposition", "Zposition")
ROTATION_CHANNELS = ("Xrotation", "Yrotation", "Zrotation")


class BVHError(ValueError):
    """A file that is not the BVH it should be; the message names file and line, what was found and
    what was needed.
    """


@dataclass(frozen=True)
class Joint:
    """One joint of the hierarchy.

    parent : index of the parent joint, -1 for the root
    offset : (x, y, z) from the parent in the file's length unit
    channels : names in file order
    end_site : (x, y, z) of the End Site below this joint, or None
    """

    name: str
    parent: int
    offset: tuple[float, ...]
    channels: tuple[str, ...]
    end_site: tuple[float, ...] | None = None

    @property
    def rotation_order(self) -> str:
        """The axes of the rotation channels as listed, for example "ZXY"."""
        return "".join(c[0] for c in self.channels if c in ROTATION_CHANNELS)


@dataclass(frozen=True)
class Clip:
    """The content of a BVH file, nothing lost: joints in file order, seconds a frame, and the raw
    channel values.

    values : (frames, channels) float64, degrees and length units as in the file.

    >>> hips = Joint("Hips", -1, (0.0, 0.0, 0.0), ("Zrotation", "Xrotation"))
    >>> clip = Clip((hips,), 0.0333333, np.zeros((4, 2)))
    >>> clip.names, clip.frames, clip.fps, hips.rotation_order
    (('Hips',), 4, 30.0, 'ZX')
    """

    joints: tuple[Joint, ...]
    frame_time: float
    values: np.ndarray = field(repr=False)

    @property
    def names(self) -> tuple[str, ...]:
        """The joints' names in file order."""
        return tuple(joint.name for joint in self.joints)

    @property
    def angles(self) -> np.ndarray:
        """Which columns of `values` are rotations.   ->  (channels,) bool"""
        return np.array([c in ROTATION_CHANNELS for joint in self.joints for c in joint.channels])

    @property
    def parents(self) -> np.ndarray:
        """The index of each joint's parent, -1 for the root.   ->  (J,)"""
        return np.array([joint.parent for joint in self.joints])

    @property
    def frames(self) -> int:
        """How many frames there are."""
        return len(self.values)

    @property
    def fps(self) -> float:
        """Frames a second. Files round 1/30 to 0.0333333; a rate within 0.01 % of a whole number is
        taken as that number.
        """
        rate = 1.0 / self.frame_time
        return float(round(rate)) if abs(rate - round(rate)) < 1e-4 * rate else rate


def plus_offsets(clip: Clip, sign: float = 1.0) -> Clip:
    """A clip whose position channels hold differences from the OFFSET, as one where they replace
    it; with sign -1 the other way.

    >>> hips = Joint("Hips", -1, (0.0, 9.0, 0.0), ("Yposition",))
    >>> plus_offsets(Clip((hips,), 0.1, np.array([[0.5]]))).values
    array([[9.5]])
    """
    added = [joint.offset[POSITION_CHANNELS.index(c)] if c in POSITION_CHANNELS else 0.0
             for joint in clip.joints for c in joint.channels]
    return replace(clip, values=clip.values + sign * np.array(added))
