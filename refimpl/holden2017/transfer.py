r"""Running it, section "Manifold Projection": stylise(I) = P(T(I)) for a clip of any length, back
on the clip's own skeleton.

Beyond both ends of a clip the convolutions see the clip going on (`motion.extend`). Networks see
every clip on the one body that they know, and a clip gets back what changed (`motion.canonical`).
"""

from dataclasses import replace
from typing import Any

import numpy as np

from ..motion.body import MARGIN, Take, seen
from ..motion.feet import pace
from ..motion.features import TRANSLATION, VELOCITIES, path_error, path_length
from ..motion.stylised import Stylised, onto_skeleton
from . import networks as text
from .trained import Manifold, Style


def stylise(features: np.ndarray, style: Style, *, projected: bool = True,
            networks: Any = text) -> np.ndarray:
    """P(T(I)) of features on the model's scale, or T(I) alone.   (T, 66)  ->  (T, 66)

    networks : who computes `transformation` and `project`, this room's definitions unless given;
    `fast.networks` is sooner
    """
    manifold = style.manifold
    O = networks.transformation(manifold.network_input(features), style.params)
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
    mean = networks.project(X, params)
    mean += shifted
    mean /= 2
    return manifold.motion(mean)


def transfer(take: Take, style: Style, *, projected: bool = True, clean: bool = True,
             own_pace: bool = False, networks: Any = text, strength: float = 1.0,
             **back: Any) -> Stylised:
    """Stylise a take.

    clean, strength, back (only, fps) : see `onto_skeleton`;  networks : as in `stylise`
    own_pace : walk the path as fast as the feet step (`feet.pace`), so that an old man's short
    steps need not become long ones

    The take is brought to the body that the model knows, and what changes there comes back
    (`motion.canonical`). The root keeps the content's velocities, to which equation 9 holds those
    of T(I); with `clean` False those of T(I), since the projection would lead the path astray
    (`docs/departures.md`). Where the clip is none that the style can know it fades
    (`motion.known`), unless `clean` is False.
    """
    manifold = style.manifold
    there = seen(take, manifold.body)
    content = there.features
    share, strange = (style.known.outside(content, manifold.leg) if style.known
                      else (float("nan"), ""))
    trust = style.known.trust(content, manifold.leg) if style.known and clean else 1.0
    moved = stylise(there.around, style, projected=False, networks=networks)
    transformed = moved[MARGIN:-MARGIN]
    astray, way = (length / manifold.leg for length in (path_error(transformed, content)[0],
                                                        path_length(content)))
    velocities = (content if clean else transformed)[:, VELOCITIES].copy()
    # An hour of features is 114 MB: what the networks have seen goes.
    there = replace(there, around=there.around[:0].copy())
    del content
    if projected:
        moved = project_features(moved, manifold, networks=networks)
    del transformed
    moved = moved[MARGIN:-MARGIN]
    moved[:, VELOCITIES] = velocities
    if own_pace:
        moved[:, TRANSLATION] *= pace(moved, take.contacts)
    result = onto_skeleton(take, there, moved, clean=clean, strength=strength * trust, **back)
    return replace(result, astray=astray, way=way, strangeness=share, strange=strange)
