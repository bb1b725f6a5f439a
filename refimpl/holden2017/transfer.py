r"""Running it, section "Manifold Projection": stylise(I) = P(T(I)) for a clip of any length, back
on the clip's own skeleton.

Beyond both ends of a clip the convolutions see the clip going on (`motion.extend`). One thing is
not right yet: a clip is brought to the size of the training data's legs and no further, so that on
a body of other proportions hips and shoulders are drawn towards the training skeleton's.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from ..motion.body import MARGIN, Take, to_scale
from ..motion.feet import pace
from ..motion.features import TRANSLATION, VELOCITIES, path_error, path_length
from ..motion.stylised import ASTRAY, Stylised, onto_skeleton
from . import networks as text
from .trained import Manifold, Style


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
    around = to_scale(take.around, leg, manifold.leg)            # (T + 2 MARGIN, 66)
    transformed = stylise(around, style, projected=False, networks=networks)
    moved = (project_features(transformed, manifold, networks=networks) if projected
             else transformed.copy())
    content, transformed, moved = (f[MARGIN:-MARGIN] for f in (around, transformed, moved))
    astray, way = (length / manifold.leg for length in (path_error(transformed, content)[0],
                                                        path_length(content)))
    kept = clean and astray > ASTRAY[0] * way + ASTRAY[1]
    moved[:, VELOCITIES] = (content if kept else transformed)[:, VELOCITIES]
    if own_pace:
        moved[:, TRANSLATION] *= pace(moved, take.contacts)
    strangeness = style.known.strangeness(content) if style.known else float("nan")
    return replace(onto_skeleton(take, to_scale(moved, manifold.leg, leg), clean=clean),
                   astray=astray, way=way, kept=bool(kept), strangeness=strangeness)
