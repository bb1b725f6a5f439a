"""A result of motion style transfer: features back on the skeleton of the clip that they were made
of."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .body import Seen, Take
from .canonical import Change, applied, change, restricted
from .clip import Clip
from .features import decode, scale
from .foot_ik import lock_feet
from .known import STRANGE
from .moved import moved_clip, rig


WHOLLY = 0.25                # of a strength: from here on feet are planted, and not at all at 0


@dataclass(frozen=True)
class Stylised:
    """A stylised take.

    clip : on its own skeleton;  positions : (T, 21, 3) of its 21 points, y up;  features : (T, 66)
    as the network left them, in the take's unit;
    astray : mean distance of the path of T(I) from the content's, and way : the length of the
    content's, in legs
    strays : what is said of the content (`body.Take.doubts`);  hinges : joints whose new pose
    needs more rotation channels than the file has for them
    strangeness : the share of the content's frames that lie outside of what the style knows, NaN
    where it does not know (`known.Known.outside`);  strange : what lies farthest, in words
    """

    clip: Clip
    positions: np.ndarray
    features: np.ndarray
    astray: float = float("nan")
    way: float = float("nan")
    strays: str = ""
    hinges: tuple[str, ...] = ()
    strangeness: float = float("nan")
    strange: str = ""

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why not to trust this result."""
        said = [self.strays] if self.strays else []
        if self.hinges:
            said.append(f"{', '.join(self.hinges)}: found fewer than three rotation channels for "
                        "what the new pose turns; written with three")
        if self.strangeness > STRANGE:
            said.append(f"{self.strangeness:.0%} of the clip lies outside of what the style learnt "
                        f"on ({self.strange}): the style fades where it knows too little, and the "
                        "path is the clip's own")
        return tuple(said)


def onto_skeleton(take: Take, content: Seen, features: np.ndarray, *, clean: bool = True,
                  strength: float | np.ndarray = 1.0, only: Sequence[str] = (),
                  fps: float | None = None) -> Stylised:
    """What became of a take as networks see it, as a change of the take on its own skeleton.

    content : the take as it was given to them;  features : (T, 66) what they made of it
    clean : lock the feet where the content's are planted (`motion.foot_ik`), if legs or hips move
    strength : how far every joint goes from where it was to where it is in the style: 0 nowhere, 1
    all the way, more beyond it; one number, or (T,) of them
    only : see `canonical.restricted`;  fps : frames a second, the clip's unless given
    """
    share, made = np.reshape(strength, (-1, 1, 1)), decode(features, content.start)
    found = change(content.positions, content.positions + share * (made - content.positions))
    found = Change(found.turns, found.shift / content.ratio)
    found = restricted(found, only) if only else found
    how = rig(take.clip.joints, take.mapping)
    positions = applied(take.positions, found, how.carries)
    if clean and (not only or {"hips", "legs"} & set(only)):
        planted = lock_feet(positions, take.contacts, take.rests[1::2], heels=take.rests[::2])
        firm = np.clip(share / WHOLLY, 0.0, 1.0)
        steps = change(positions, positions + firm * (planted - positions))
        found, positions = found.then(steps), applied(positions, steps, how.carries)
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
