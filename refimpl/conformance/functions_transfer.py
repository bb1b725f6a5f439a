"""The reference for what is done with trained networks, as functions of arrays alone: a motion
through both networks of 2017, its projection, and how a clip goes on beyond its ends before that.
"""

import numpy as np

from ..holden2017 import networks, objective, transfer
from ..holden2017.trained import Manifold, Style
from ..motion import extend
from ..motion.windows import Normaliser
from .functions_holden import T_NAMES
from .specification import Array


def manifold_of(W0: Array, b0: Array, mean: Array, deviation: Array) -> Manifold:
    """A trained loss network of arrays alone."""
    return Manifold({"W0": W0, "b0": b0}, Normaliser(mean, deviation, "these", "groups"),
                    objective.LEG, np.ones(0))


def stylised_numbers(features: Array, *arrays: Array, W0: Array,
                     b0: Array, mean: Array, deviation: Array, projected: bool = True) -> Array:
    """`project` of `transform` of (features - mean) / deviation, one clip, and back; without the
    projection where it is not asked for.

    features : (T, 66);  W1 ... b3 : as for `transform`   ->  (T, 66)
    """
    style = Style(dict(zip(T_NAMES.split(), arrays)), manifold_of(W0, b0, mean, deviation), "style",
                  {})
    return transfer.stylise(features, style, projected=projected)


def projected_numbers(features: Array, W0: Array, b0: Array, *, mean: Array,
                      deviation: Array) -> Array:
    """The mean of `project` of the normalised features and of the same with the first frame doubled
    before and dropped after, and back: of both ways to take frames in pairs.

    features : (T, 66)   ->  (T, 66)
    """
    return transfer.project_features(features, manifold_of(W0, b0, mean, deviation))


def fitted_weights(leg: Array, *, hidden: int = 256, reading: str = "norm") -> Array:
    """The weights of `total_loss` where a leg has another length than the 80 that they are for,
    and the loss network other than 256 units: foot, bone and trajectory times (leg / 80)^-2,
    and, for mean_squares, times 256 / hidden; 10,000 times (leg / 80)^2.

    leg : (L,)   ->  (L, 6): content, style, foot, bone, trajectory, squared lengths for a squared
    radian
    """
    fitted = [objective.WEIGHTS[reading].fitted(float(length), hidden) for length in leg]
    return np.array([[getattr(w, name) for name in objective.WEIGHED] for w in fitted])


def decode_untied(H: Array, V0: Array, c0: Array, *, chosen: Array | None = None) -> Array:
    """Equation 2 with filters and biases of its own:   X = conv_transpose1d(avg_depool1d(H, 2), V0)
    + c0

    H : (N, m, U), V0 : (m, C, K), c0 : (C,);  chosen : as for `decode`   ->  (N, C, 2 U)
    """
    return networks.decode(H, {"V0": V0, "c0": c0}, chosen=chosen)


def decode_untied_backward(dX: Array, H: Array, V0: Array, c0: Array, *,
                           chosen: Array | None = None) -> tuple[Array, ...]:
    """dX : (N, C, 2 U)  ->  dH (N, m, U), dV0 (m, C, K), dc0 (C,)"""
    dH, found = networks.decode_backward(dX, H, {"V0": V0, "c0": c0}, chosen=chosen)
    return dH, found["V0"], found["c0"]


def extended(positions: Array, *, frames: int) -> Array:
    """The clip with so many frames more after it, and before it the same told backwards.

    A frame is told by 42 vectors: its joints as seen from under the hips, facing ahead (across =
    (LeftArm - RightArm) + (LeftUpLeg - RightUpLeg) turned to +x), and 5 times their speeds seen so
    (np.gradient, then the mean of three frames, the ends repeated). Of frames 0 ... T - frames - 2
    the one nearest to the last, by the root mean square of distances, is the source: what follows
    it is turned and set down so that its hips face and stand where the last frame's do; k frames on
    (1 - e(k / 20)) times the jump from there to the last frame is added,

        e(u) = 6 u^5 - 15 u^4 + 10 u^3,   1 from u = 1 on.

    Where the nearest is farther than 0.15 legs, or T < frames + 3, the clip comes to rest:
    last + 3 e(k / 12) times the mean of its last three steps.

    positions : (T, 21, 3), y up   ->  (T + 2 frames, 21, 3)
    """
    return extend.extended(positions, frames)
