"""A result of motion style transfer: features back on the skeleton of the clip that they were made
of."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .body import Seen, Take
from .canonical import Change, applied, change, weighed
from .clip import Clip
from .features import decode, scale
from .foot_ik import lock_feet
from .known import STRANGE
from .moved import moved_clip, rig

# How far the path of T(I) may lie from the content's: a share of the way, and so many legs.
ASTRAY = 0.1, 0.2


@dataclass(frozen=True)
class Stylised:
    """A stylised take.

    clip : on its own skeleton;  positions : (T, 21, 3) of its 21 points, y up;  features : (T, 66)
    as the network left them, in the take's unit;
    astray : mean distance of the path of T(I) from the content's, and way : the length of the
    content's, in legs;
    kept : whether the content's path was kept instead;  strays : what is said of the
    content;  hinges : joints whose new pose needs more rotation channels than the file
    has for them;  strangeness : of the content (`known.Known`), NaN where the style does not
    know
    """

    clip: Clip
    positions: np.ndarray
    features: np.ndarray
    astray: float = float("nan")
    way: float = float("nan")
    kept: bool = False
    strays: str = ""
    hinges: tuple[str, ...] = ()
    strangeness: float = float("nan")

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why not to trust this result."""
        said = [self.strays] if self.strays else []
        if self.hinges:
            said.append(f"{', '.join(self.hinges)}: found fewer than three rotation channels for "
                        "what the new pose turns; written with three")
        if self.strangeness > STRANGE:
            said.append(
                "the clip is nothing like what the style learnt on (it lies "
                f"{self.strangeness:.1f} times as far from the nearest of that as the "
                f"farthest of those clips from the others; {STRANGE:g} is allowed): expect a "
                "figure that moves as the style knows, not as this clip does")
        if self.kept:
            said.append(
                f"the style would leave a way of {self.way:.1f} legs by {self.astray:.1f} legs on "
                f"average (allowed: {ASTRAY[0]:.0%} of the way and {ASTRAY[1]:g} leg): the "
                "content's own path is kept")
        return tuple(said)


def onto_skeleton(take: Take, content: Seen, features: np.ndarray, *, clean: bool = True,
                  strength: float = 1.0, only: Sequence[str] = (),
                  fps: float | None = None) -> Stylised:
    """What became of a take as networks see it, as a change of the take on its own skeleton.

    content : the take as it was given to them;  features : (T, 66) what they made of it
    clean : lock the feet where the content's are planted (`motion.foot_ik`)
    strength, only : see `canonical.weighed`;  fps : frames a second, the clip's unless given
    """
    found = change(content.positions, decode(features, content.start))
    found = weighed(Change(found.turns, found.shift / content.ratio), strength, only)
    how = rig(take.clip.joints, take.mapping)
    positions = applied(take.positions, found, how.carries)
    if clean:
        planted = lock_feet(positions, take.contacts, take.toes)
        found = found.then(change(positions, planted))
        positions = planted
    if how.carrier < 0:                              # nothing in the file could carry the hips
        found = Change(found.turns, 0 * found.shift)
        positions = applied(take.positions, found, how.carries)
    clip = moved_clip(take, how, found, fps)
    hinges = tuple(new.name for new, old in zip(clip.joints, take.clip.joints)
                   if _turning(new) > _turning(old) > 0)
    return Stylised(clip, positions, scale(features, 1 / content.ratio),
                    strays="; ".join(take.doubts), hinges=hinges)


def _turning(joint):
    return sum(channel.endswith("rotation") for channel in joint.channels)
