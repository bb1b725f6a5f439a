r"""Running it, section "Manifold Projection": stylise(I) = P(T(I)) for a clip of any length, back on the clip's own skeleton."""

from dataclasses import dataclass

import numpy as np

from ..motion.dataset import to_scale
from ..motion.features import VELOCITIES, decode
from ..motion.retarget import to_clip
from ..nn import tiled
from .networks import project, transform


@dataclass(frozen=True)
class Stylised:
    """A stylised take: clip on its own skeleton, positions (T, 21, 3) the network moved, y up, and features (T, 66), in the take's unit."""

    clip: object
    positions: np.ndarray
    features: np.ndarray


def stylise(features, style, *, projected=True, kernels=tiled):
    """P(T(I)) of features on the model's scale, or T(I) alone.   (T, 66)  ->  (T, 66)"""
    output = style.manifold.motion(transform(style.manifold.network_input(features), style.params, kernels=kernels))
    return project_features(output, style.manifold, kernels=kernels) if projected else output


def project_features(features, manifold, *, kernels=tiled):
    """P(X) = L+(L(X)) of features on the model's scale.   (T, 66)  ->  (T, 66)"""
    return manifold.motion(project(manifold.network_input(features), manifold.params, kernels=kernels))


def transfer(take, style, *, projected=True, kernels=tiled):
    """Stylise a take.   Take, Style  ->  Stylised

    The character is brought to the model's size and back, and starts where and as the content starts. Its root keeps the velocities of
    T(I), which equation 9 holds to the content's; the projection would lead the path astray (see the README's deviations).
    """
    leg, manifold = take.leg, style.manifold
    transformed = stylise(to_scale(take.features, leg, manifold.leg), style, projected=False, kernels=kernels)
    moved = project_features(transformed, manifold, kernels=kernels) if projected else transformed.copy()
    moved[:, VELOCITIES] = transformed[:, VELOCITIES]
    features = to_scale(moved, manifold.leg, leg)
    positions = decode(features, take.start)
    return Stylised(to_clip(take, positions), positions, features)
