"""A result of motion style transfer: features back on the skeleton of the clip that they were made
of."""

from dataclasses import dataclass, replace

import numpy as np

from .body import Take, fit_pose, points, with_strays
from .clip import Clip
from .features import FPS, decode
from .foot_ik import lock_feet
from .known import STRANGE
from .skeleton import with_pose

# How far the path of T(I) may lie from the content's: a share of the way, and so many legs.
ASTRAY = 0.1, 0.2


@dataclass(frozen=True)
class Stylised:
    """A stylised take.

    clip : on its own skeleton;  positions : (T, 21, 3) of its 21 points, y up;  features : (T, 66)
    as the network left them, in the take's unit;
    astray : mean distance of the path of T(I) from the content's, and way : the length of the
    content's, in legs;
    kept : whether the content's path was kept instead;  strays : what is said of rows that were
    left as they are;  hinges : joints whose new pose needs more rotation channels than the file
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


def onto_skeleton(take: Take, features: np.ndarray, *, clean: bool = True) -> Stylised:
    """Features (T, 66) in the take's unit as a clip on the take's skeleton, which begins where the
    take begins.

    clean : lock the feet where the content's are planted (`motion.foot_ik`)
    """
    pose = fit_pose(take, decode(features, take.start))
    if clean:
        goals = lock_feet(points(take, *pose), take.contacts, take.toes)
        pose = fit_pose(replace(take, rotations=pose[0], translations=pose[1]), goals)
    clip = with_pose(take.clip, *with_strays(take, *pose), 1.0 / FPS)
    hinges = tuple(new.name for new, old in zip(clip.joints, take.clip.joints)
                   if new.channels != old.channels)
    return Stylised(clip, points(take, *pose), features, strays=take.strays.said(), hinges=hinges)
