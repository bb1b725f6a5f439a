r"""Equation 10: the five losses together, as a function of the transformation network's output."""

from dataclasses import dataclass, replace

import numpy as np

from ..nn import tiled
from . import losses
from .networks import HIDDEN, encode, encode_backward_to_input, transform, transform_backward


@dataclass(frozen=True)
class Weights:
    """What each loss counts in training, and how the bars of equations 4 and 5 are read (`losses.READINGS`).

    c and s are the paper's. The constraints, which the paper scales "with respect to the units of the data", are for centimetres (a leg of
    80), 256 hidden units and windows of 240 frames; `fitted` converts them. `turn` is what a squared radian is worth in squared lengths: as if seen at a
    point one metre away; with less a style learnt from straight walks forgets to turn.
    """

    content: float = 1.0
    style: float = 0.01
    foot: float = 2e-4
    bone: float = 2e-5
    trajectory: float = 1e-2
    turn: float = 10000.0
    reading: str = "mean_squares"

    def fitted(self, leg, hidden=HIDDEN):
        """The same weights for data in which a leg has this length and a loss network of so many units.

        Squared lengths shrink or grow with the square of the leg. A mean over fewer units is larger, since each has more to say.
        """
        factor = (80.0 / leg) ** 2
        share = factor * (HIDDEN / hidden if self.reading == "mean_squares" else 1.0)
        return replace(self, foot=self.foot * share, bone=self.bone * share, trajectory=self.trajectory * share, turn=self.turn / factor)


# What training takes for each reading. A mean of squares pulls with 2 |D| / (m T), some 1/200 of a norm's pull, where
# D = L(I) - L(T(I)) has m T = 30,720 elements (256 hidden units, windows of 240 frames) and is some 75 long; a sum with 2 |D|. The
# constraints of squares are four times those of norms beside the rest, which keeps the path (the curve stands in the README). s weighs a
# square of the hidden units against the units: for norms, 0.01 leaves a third more of the style.
WEIGHTS = {"norm": Weights(1.0, 0.06, 0.01, 0.001, 0.5, reading="norm"),
           "mean_squares": Weights(),
           "sum_squares": Weights(1.0, 0.01, 6.0, 0.6, 300.0, reading="sum_squares")}


@dataclass(frozen=True)
class Target:
    """What the output of a batch is compared with, all constants.

    hidden : L(I) (N, m, T // 2);  gram : style target (N, m, m);  contacts : (N, 4, T);  bones : (20,);  trajectory : (N, 3, T);
    foot_velocity : r' of equation 7.
    """

    hidden: np.ndarray
    gram: np.ndarray
    contacts: np.ndarray
    bones: np.ndarray
    trajectory: np.ndarray
    foot_velocity: object = 0.0


TERMS = ("content", "style", "foot", "bone", "trajectory")
WEIGHED = (*TERMS, "turn")


def motion_losses(O, target, loss_network, mean, deviation, weights=Weights(), *, kernels=tiled):
    r"""The five terms of equation 10 for an output O of the transformation network.

    O : (N, 66, T) normalised;  loss_network : W0, b0;  mean, deviation : (66,) of the normaliser   ->  {term: (N,)}
    """
    H = encode(O, loss_network, kernels=kernels)
    return {"content": losses.content_loss(target.hidden, H, c=weights.content, reading=weights.reading),
            "style": losses.style_loss(target.gram, H, s=weights.style, reading=weights.reading),
            **constraint_losses(denormalise(O, mean, deviation), target, weights)}


def motion_losses_backward(dloss, O, target, loss_network, mean, deviation, weights=Weights(), *, kernels=tiled):
    r"""Gradient of the sum of the five terms.   dloss : (N,), O : (N, 66, T)  ->  dO (N, 66, T)

    Content and style come back through the loss network, the constraints through the denormalisation  motion = O deviation + mean.
    """
    H = encode(O, loss_network, kernels=kernels)
    dH = (losses.content_loss_backward(dloss, target.hidden, H, c=weights.content, reading=weights.reading)[1]
          + losses.style_loss_backward(dloss, target.gram, H, s=weights.style, reading=weights.reading)[1])
    dmotion = constraint_losses_backward(dloss, denormalise(O, mean, deviation), target, weights)
    return encode_backward_to_input(dH, O, loss_network, kernels=kernels) + dmotion * column(deviation, O)


def constraint_losses(motion, target, weights=Weights()):
    """The three terms about real lengths.   motion : (N, 66, T) denormalised   ->  {term: (N,)}"""
    return {"foot": weights.foot * losses.foot_loss(motion, target.contacts, target=target.foot_velocity),
            "bone": weights.bone * losses.bone_loss(motion, target.bones),
            "trajectory": weights.trajectory * losses.trajectory_loss(motion, target.trajectory, turn_weight=weights.turn)}


def constraint_losses_backward(dloss, motion, target, weights=Weights()):
    """Gradient of their sum.   dloss : (N,), motion : (N, 66, T)  ->  dmotion (N, 66, T)"""
    return (losses.foot_loss_backward(weights.foot * dloss, motion, target.contacts, target=target.foot_velocity)
            + losses.bone_loss_backward(weights.bone * dloss, motion, target.bones)
            + losses.trajectory_loss_backward(weights.trajectory * dloss, motion, target.trajectory, turn_weight=weights.turn))


def total_loss(params, I, target, loss_network, mean, deviation, weights=Weights(), *, kernels=tiled):
    """Equation 10 of T(I), a mean over the batch, and its terms.   params : of T, I : (N, 66, T)  ->  scalar, {term: scalar}"""
    terms = motion_losses(transform(I, params, kernels=kernels), target, loss_network, mean, deviation, weights, kernels=kernels)
    means = {name: loss.mean() for name, loss in terms.items()}
    return sum(means.values()), means


def total_loss_backward(dloss, params, I, target, loss_network, mean, deviation, weights=Weights(), *, kernels=tiled):
    """Gradient of `total_loss` with respect to the parameters of T.   dloss : scalar  ->  gradients with the keys of params"""
    O = transform(I, params, kernels=kernels)
    per_clip = np.full(len(I), dloss / len(I), dtype=I.real.dtype)
    dO = motion_losses_backward(per_clip, O, target, loss_network, mean, deviation, weights, kernels=kernels)
    return transform_backward(dO, I, params, kernels=kernels)[1]


def denormalise(O, mean, deviation):
    """(N, 66, T) back to lengths and radians, in O's own precision."""
    return O * column(deviation, O) + column(mean, O)


def column(values, like):
    """Numbers of the 66 rows beside arrays (N, 66, T), in their precision."""
    return np.asarray(values, dtype=like.real.dtype)[:, None]
