r"""Running it, section "Manifold Projection": stylise(I) = P(T(I)) for a clip of any length, back on the clip's own skeleton."""

from dataclasses import dataclass

import numpy as np

from ..motion.dataset import to_scale
from ..motion.features import VELOCITIES, decode
from ..motion.retarget import to_clip
from .networks import project, transform


@dataclass(frozen=True)
class Stylised:
    """A stylised take: clip on its own skeleton, positions (T, 21, 3) the network moved, y up, and features (T, 66), in the take's unit."""

    clip: object
    positions: np.ndarray
    features: np.ndarray


def stylise(features, style, *, projected=True, stylist=None, kernels=None):
    """P(T(I)) of features on the model's scale, or T(I) alone.   (T, 66)  ->  (T, 66)

    stylist : the style's own unless given (one with more threads, say);  kernels : who computes the definition instead, `refimpl.nn` say
    """
    X, manifold = style.manifold.network_input(features), style.manifold
    if kernels is not None:
        O = transform(X, style.params, kernels=kernels)
        return manifold.motion(project(O, manifold.params, kernels=kernels) if projected else O)
    stylist = stylist or style.stylist
    return manifold.motion(stylist.stylise(X) if projected else stylist.transform(X))


def project_features(features, manifold, *, stylist=None, kernels=None):
    """P(X) = L+(L(X)) of features on the model's scale.   (T, 66)  ->  (T, 66)"""
    X = manifold.network_input(features)
    if kernels is not None:
        return manifold.motion(project(X, manifold.params, kernels=kernels))
    return manifold.motion((stylist or manifold.stylist).project(X))


def transfer(take, style, *, projected=True, stylist=None, kernels=None):
    """Stylise a take.   Take, Style  ->  Stylised.   stylist, kernels : as in `stylise`

    The character is brought to the model's size and back, and starts where and as the content starts. Its root keeps the velocities of
    T(I), which equation 9 holds to the content's; the projection would lead the path astray (see the README's deviations).
    """
    leg, manifold = take.leg, style.manifold
    transformed = stylise(to_scale(take.features, leg, manifold.leg), style, projected=False, stylist=stylist, kernels=kernels)
    moved = project_features(transformed, manifold, stylist=stylist, kernels=kernels) if projected else transformed.copy()
    moved[:, VELOCITIES] = transformed[:, VELOCITIES]
    features = to_scale(moved, manifold.leg, leg)
    positions = decode(features, take.start)
    return Stylised(to_clip(take, positions), positions, features)
