r"""Running it, section "Manifold Projection": stylise(I) = P(T(I)) for a clip of any length, back
on the clip's own skeleton.

Two things are not right yet. The convolutions see zeros, the mean pose, beyond both ends of a clip:
joints of the first four frames are off by some 7 cm, up to the 24th by some 3. And a clip is
brought to the size of the training data's legs and no further: on a body of other proportions hips
and shoulders are drawn towards the training skeleton's.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..motion.clip import Clip
from ..motion.body import to_scale
from ..motion.features import FPS, TRANSLATION, VELOCITIES, decode, path_error, path_length
from ..motion.foot_ik import lock_feet
from ..motion.feet import pace
from ..motion.known import STRANGE
from ..motion.body import fit_pose, points
from ..motion.skeleton import with_pose
from ..motion.body import Take
from . import networks as text
from .trained import Manifold, Style

# How far the path of T(I) may lie from the content's: a share of the way, and so many legs.
ASTRAY = 0.1, 0.2


@dataclass(frozen=True)
class Stylised:
    """A stylised take.

    clip : on its own skeleton;  positions : (T, 21, 3) of its 21 points, y up;  features : (T, 66)
    as the network left them, in the take's unit;
    astray : mean distance of the path of T(I) from the content's, and way : the length of the
    content's, in legs;
    kept : whether the content's path was kept instead;  strangeness : of the content
    (`known.Known`), NaN where the style does not know
    """

    clip: Clip
    positions: np.ndarray
    features: np.ndarray
    astray: float = float("nan")
    way: float = float("nan")
    kept: bool = False
    strangeness: float = float("nan")

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why not to trust this result."""
        said = []
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


def stylise(features: np.ndarray, style: Style, *, projected: bool = True,
            networks: Any = text) -> np.ndarray:
    """P(T(I)) of features on the model's scale, or T(I) alone.   (T, 66)  ->  (T, 66)

    networks : who computes `transform` and `project`, this room's definitions unless given;
    `fast.networks` is sooner
    """
    manifold = style.manifold
    O = networks.transform(manifold.network_input(features), style.params)
    return manifold.motion(networks.project(O, manifold.params) if projected else O)


def project_features(features: np.ndarray, manifold: Manifold, *,
                     networks: Any = text) -> np.ndarray:
    """P(X) = L+(L(X)) of features on the model's scale, the mean over both ways of taking frames in
    pairs.   (T, 66)  ->  (T, 66)

    The pooling takes frames 0 and 1 together, or 1 and 2: what P puts out has a step between pairs,
    at other frames each time, and half of it is gone in the mean. On motion that is smoother than
    recordings are it halves the jerk that P adds.
    """
    X, params = manifold.network_input(features), manifold.params
    shifted = networks.project(np.concatenate([X[:, :, :1], X], axis=2), params)[:, :, 1:]
    return manifold.motion((networks.project(X, params) + shifted) / 2)


def transfer(take: Take, style: Style, *, projected: bool = True, clean: bool = True,
             own_pace: bool = False, networks: Any = text) -> Stylised:
    """Stylise a take.

    clean : see `onto_skeleton`;  networks : as in `stylise`
    own_pace : walk the path as fast as the feet step (`feet.pace`), so that an old man's short
    steps need not become long ones

    The character is brought to the model's size and back, and starts where and as the content
    starts. Its root keeps the velocities of T(I), which equation 9 holds to the content's; the
    projection would lead the path astray (see the README's deviations). Where T leads it astray
    itself (`ASTRAY`), as with contents of other speeds than it has learnt, the content's path is
    kept, unless `clean` is False.
    """
    leg, manifold = take.leg, style.manifold
    content = to_scale(take.features, leg, manifold.leg)
    transformed = stylise(content, style, projected=False, networks=networks)
    moved = (project_features(transformed, manifold, networks=networks) if projected
             else transformed.copy())
    astray, way = (length / manifold.leg for length in (path_error(transformed, content)[0],
                                                        path_length(content)))
    kept = clean and astray > ASTRAY[0] * way + ASTRAY[1]
    moved[:, VELOCITIES] = (content if kept else transformed)[:, VELOCITIES]
    if own_pace:
        moved[:, TRANSLATION] *= pace(moved, take.contacts)
    strangeness = style.known.strangeness(content) if style.known else float("nan")
    return replace(onto_skeleton(take, to_scale(moved, manifold.leg, leg), clean=clean),
                   astray=astray, way=way, kept=bool(kept), strangeness=strangeness)


def onto_skeleton(take: Take, features: np.ndarray, *, clean: bool = True) -> Stylised:
    """Features (T, 66) in the take's unit as a clip on the take's skeleton, which begins where the
    take begins.

    clean : lock the feet where the content's are planted (`motion.foot_ik`)
    """
    pose = fit_pose(take, decode(features, take.start))
    if clean:
        goals = lock_feet(points(take, *pose), take.contacts, take.start.floor)
        pose = fit_pose(replace(take, rotations=pose[0], translations=pose[1]), goals)
    return Stylised(with_pose(take.clip, *pose, 1.0 / FPS), points(take, *pose), features)
