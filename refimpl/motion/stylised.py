"""A result of motion style transfer: features back on the skeleton of the clip that they were made
of."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .body import Seen, Take
from .canonical import Change, LongChange, applied, change, restricted
from .clip import Clip
from .features import AT_A_TIME, in_pieces, placed, root_motion, scale
from .foot_ik import locked_legs, on_legs
from .known import STRANGE
from .moved import moved_clip, rig


WHOLLY = 0.25                # of a strength: from here on feet are planted, and not at all at 0


@dataclass(frozen=True)
class Stylised:
    """A stylised take.

    clip : on its own skeleton;  positions : (T, 21, 3) of its 21 points, y up;  made : (T, 66)
    as the network left them, of a body `ratio` times as large;
    astray : mean distance of the path of T(I) from the content's, and way : the length of the
    content's, in legs
    strays : what is said of the content (`body.Take.doubts`);  hinges : joints whose new pose
    needs more rotation channels than the file has for them
    strangeness : the share of the content's frames that lie outside of what the style knows, NaN
    where it does not know (`known.Known.outside`);  strange : what lies farthest, in words
    """

    clip: Clip
    positions: np.ndarray
    made: np.ndarray
    ratio: float
    astray: float = float("nan")
    way: float = float("nan")
    strays: str = ""
    hinges: tuple[str, ...] = ()
    strangeness: float = float("nan")
    strange: str = ""

    @property
    def features(self) -> np.ndarray:
        """As the network left them, in the take's unit.   ->  (T, 66)"""
        return scale(self.made, 1 / self.ratio)

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
    share = np.broadcast_to(np.reshape(strength, (-1, 1, 1)), (len(features), 1, 1))
    lock = clean and (not only or bool({"hips", "legs"} & set(only)))
    said = "; ".join(take.doubts)                    # before memory is scarce
    clip, positions = _moved(take, content, features, share, only, lock, fps)
    hinges = tuple(new.name for new, old in zip(clip.joints, take.clip.joints)
                   if _turning(new) > _turning(old) > 0)
    return Stylised(clip, positions, features, content.ratio, strays=said, hinges=hinges)


def _moved(take, content, features, share, only, lock, fps):
    """The change of a take, a piece at a time.   ->  Clip, (T, 21, 3)"""
    root, yaw = root_motion(features, content.start)
    how, frames = rig(take.clip.joints, take.mapping), len(features)
    locked: Any = None

    def _styled(some):
        before, made = content.positions[some], placed(features[some], root[some], yaw[some])
        found = change(before, before + share[some] * (made - before))
        found = Change(found.turns, found.shift / content.ratio)
        found = restricted(found, only) if only else found
        return found, applied(take.positions[some], found, how.carries)

    once = _styled(slice(0, frames)) if frames <= AT_A_TIME else None

    def _whole(some):
        found, positions = once or _styled(some)
        if locked is not None:
            firm = np.clip(share[some] / WHOLLY, 0.0, 1.0)
            stands = on_legs(positions, *(part[some] for part in locked))
            steps = change(positions, positions + firm * (stands - positions))
            found, positions = found.then(steps), applied(positions, steps, how.carries)
        if how.carrier < 0:                          # nothing in the file could carry the hips
            found = Change(found.turns, 0 * found.shift)
            positions = applied(take.positions[some], found, how.carries)
        return found, positions

    if lock:
        rests = take.rests
        locked = locked_legs(in_pieces(lambda some: (once or _styled(some))[1], frames),
                             take.contacts, rests[1::2], heels=rests[::2])
    found: Any
    if frames <= AT_A_TIME:
        found, positions = _whole(slice(0, frames))
    else:
        found = LongChange(lambda some: _whole(some)[0], frames)
        positions = in_pieces(lambda some: _whole(some)[1], frames)
    return moved_clip(take, how, found, fps), positions


def _turning(joint):
    return sum(channel.endswith("rotation") for channel in joint.channels)
