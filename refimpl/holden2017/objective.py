r"""The objective of training: equation 10, the sum of five losses of the transformation network's
output.

    Loss(O) = content + style + foot + bone + trajectory          (Holden 2017, Equation 10)

`EQUATION_10` is that sum as a list of terms. Whatever sums, names, weighs, plots or checks terms
walks such a list, and a term from outside is trained with by `terms=[*EQUATION_10, mine]`.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..nn import tiled
from . import losses
from .networks import HIDDEN, encode, encode_backward_to_input, transform, transform_backward


# centimetres, for which the weights are
LEG = 80.0


@dataclass(frozen=True)
class Weights:
    """What each loss counts in training, and how the bars of equations 4 and 5 are read
    (`losses.READINGS`).

    c and s are the paper's. The constraints, which the paper scales "with respect to the units of
    the data", are for centimetres (a leg of 80), 256 hidden units and windows of 240 frames;
    `fitted` converts them. `turn` is what a squared radian is worth in squared lengths: as if seen
    at a point one metre away; with less a style learnt from straight walks forgets to turn.
    """

    content: float = 1.0
    style: float = 0.01
    foot: float = 2e-4
    bone: float = 2e-5
    trajectory: float = 1e-2
    turn: float = 10000.0
    reading: str = "mean_squares"

    def fitted(self, leg, hidden=HIDDEN):
        """The same weights for data in which a leg has this length and a loss network of so many
        units.

        Squared lengths shrink or grow with the square of the leg. A mean over fewer units is
        larger, since each has more to say.
        """
        share = HIDDEN / hidden if self.reading == "mean_squares" else 1.0
        fitted = {term.name: term.weight_of(self) * ((leg / LEG) ** term.power * share)
                  for term in EQUATION_10 if term.power}
        return replace(self, **fitted, turn=self.turn * (leg / LEG) ** 2)


# What training takes for each reading. A mean of squares pulls with 2 |D| / (m T), some 1/200 of a
# norm's pull, where D = L(I) - L(T(I)) has m T = 30,720 elements (256 hidden units, windows of 240
# frames) and is some 75 long; a sum with 2 |D|. The constraints of squares are four times those of
# norms beside the rest, which keeps the path (the curve stands in the README). s weighs a square of
# the hidden units against the units: for norms, 0.01 leaves a third more of the style.
WEIGHTS = {"norm": Weights(1.0, 0.06, 0.01, 0.001, 0.5, reading="norm"),
           "mean_squares": Weights(),
           "sum_squares": Weights(1.0, 0.01, 6.0, 0.6, 300.0, reading="sum_squares")}


@dataclass(frozen=True)
class Batch:
    """Some windows and what the network's output for them is compared with: what travels from
    pairing to gradient.

    I : (N, 66, T) normalised input;  gram : the style's Gram matrices (N, m, m), or N of them;
    contacts : (N, 4, T); bones : (20,);  trajectory : (N, 3, T) denormalised velocities of the
    input;  hidden : L(I) (N, m, T // 2), and motion : I in lengths and radians (N, 66, T), both
    computed where they are not given;  foot_velocity : r' of equation 7
    """

    I: np.ndarray
    gram: Any
    contacts: np.ndarray
    bones: np.ndarray
    trajectory: np.ndarray
    hidden: np.ndarray | None = None
    motion: np.ndarray | None = None
    foot_velocity: Any = 0.0


@dataclass(frozen=True)
class Term:
    """One term of the objective.

    reads : "hidden", L(O) (N, m, T // 2), or "motion", O in lengths and radians (N, 66, T);
    loss : (x, Batch, Weights) ->  (N,);  backward : (dloss (N,), x, Batch, Weights) ->  dx, both
    without the weight; weight : None for that of `Weights` under its name;  power : of the leg's
    length, with which the weight goes
    """

    name: str
    reads: str
    loss: Callable
    backward: Callable
    weight: float | None = None
    power: int = 0

    def weight_of(self, weights: Weights) -> float:
        return getattr(weights, self.name) if self.weight is None else self.weight


def _grams(batch):
    return batch.gram if isinstance(batch.gram, np.ndarray) else np.stack(batch.gram)


# Each loss of a batch, beside its backward; named functions, so that a process can be sent them.

def content(H, batch, weights):
    return losses.content_loss(batch.hidden, H, reading=weights.reading)


def content_backward(dloss, H, batch, weights):
    return losses.content_loss_backward(dloss, batch.hidden, H, reading=weights.reading)[1]


def style(H, batch, weights):
    return losses.style_loss(_grams(batch), H, s=1.0, reading=weights.reading)


def style_backward(dloss, H, batch, weights):
    return losses.style_loss_backward(dloss, _grams(batch), H, s=1.0, reading=weights.reading)[1]


def foot(motion, batch, weights):
    return losses.foot_loss(motion, batch.contacts, target=batch.foot_velocity)


def foot_backward(dloss, motion, batch, weights):
    return losses.foot_loss_backward(dloss, motion, batch.contacts, target=batch.foot_velocity)


def bone(motion, batch, weights):
    return losses.bone_loss(motion, batch.bones)


def bone_backward(dloss, motion, batch, weights):
    return losses.bone_loss_backward(dloss, motion, batch.bones)


def trajectory(motion, batch, weights):
    return losses.trajectory_loss(motion, batch.trajectory, turn_weight=weights.turn)


def trajectory_backward(dloss, motion, batch, weights):
    return losses.trajectory_loss_backward(dloss, motion, batch.trajectory,
                                           turn_weight=weights.turn)


CONTENT = Term("content", "hidden", content, content_backward)
STYLE = Term("style", "hidden", style, style_backward)
FOOT = Term("foot", "motion", foot, foot_backward, power=-2)
BONE = Term("bone", "motion", bone, bone_backward, power=-2)
TRAJECTORY = Term("trajectory", "motion", trajectory, trajectory_backward, power=-2)
EQUATION_10 = (CONTENT, STYLE, FOOT, BONE, TRAJECTORY)
CONSTRAINTS = (FOOT, BONE, TRAJECTORY)
WEIGHED = (*(term.name for term in EQUATION_10), "turn")


def term_losses(x: np.ndarray, batch: Batch, terms: Iterable[Term],
                weights: Weights) -> dict[str, np.ndarray]:
    """Weighted losses of terms that all read x.   ->  {term: (N,)}"""
    return {term.name: term.weight_of(weights) * term.loss(x, batch, weights) for term in terms}


def term_losses_backward(dloss: np.ndarray, x: np.ndarray, batch: Batch, terms: Iterable[Term],
                         weights: Weights) -> np.ndarray:
    """Gradient of their sum.   dloss : (N,)  ->  dx"""
    dx = np.zeros_like(x)
    for term in terms:
        dx = dx + term.backward(term.weight_of(weights) * dloss, x, batch, weights)
    return dx


def motion_losses(O, batch, loss_network, mean, deviation, weights=Weights(), *, terms=EQUATION_10,
                  kernels=tiled):
    r"""The terms of the objective for an output O of the transformation network.

    O : (N, 66, T) normalised;  loss_network : W0, b0;  mean, deviation : (66,) of the normaliser
    ->  {term: (N,)}
    """
    batch = completed(batch, loss_network, mean, deviation, kernels)
    H, motion = encode(O, loss_network, kernels=kernels), denormalise(O, mean, deviation)
    found = {**term_losses(H, batch, reading("hidden", terms), weights),
             **term_losses(motion, batch, reading("motion", terms), weights)}
    return {term.name: found[term.name] for term in terms}


def motion_losses_backward(dloss, O, batch, loss_network, mean, deviation, weights=Weights(), *,
                           terms=EQUATION_10, kernels=tiled):
    r"""Gradient of the sum of the terms.   dloss : (N,), O : (N, 66, T)  ->  dO (N, 66, T)

    What reads hidden units comes back through the loss network, what reads motion through the
    denormalisation  motion = O deviation + mean.
    """
    batch = completed(batch, loss_network, mean, deviation, kernels)
    dH = term_losses_backward(dloss, encode(O, loss_network, kernels=kernels), batch,
                              reading("hidden", terms), weights)
    dmotion = term_losses_backward(dloss, denormalise(O, mean, deviation), batch,
                                   reading("motion", terms), weights)
    return encode_backward_to_input(dH, O, loss_network,
                                    kernels=kernels) + dmotion * column(deviation, O)


def total_loss(params, batch, loss_network, mean, deviation, weights=Weights(), *,
               terms=EQUATION_10, kernels=tiled):
    """The objective of T(I), a mean over the batch, and its terms.
    params : of T  ->  scalar, {term: scalar}
    """
    O = transform(batch.I, params, kernels=kernels)
    found = motion_losses(O, batch, loss_network, mean, deviation, weights, terms=terms,
                          kernels=kernels)
    means = {name: loss.mean() for name, loss in found.items()}
    return sum(means.values()), means


def total_loss_backward(dloss, params, batch, loss_network, mean, deviation, weights=Weights(), *,
                        terms=EQUATION_10, kernels=tiled):
    """Gradient of `total_loss` with respect to the parameters of T.
    dloss : scalar  ->  gradients with the keys of params
    """
    O = transform(batch.I, params, kernels=kernels)
    per_clip = np.full(len(O), dloss / len(O), dtype=O.real.dtype)
    dO = motion_losses_backward(per_clip, O, batch, loss_network, mean, deviation, weights,
                                terms=terms, kernels=kernels)
    return transform_backward(dO, batch.I, params, kernels=kernels)[1]


def reading(what, terms):
    """The terms that read hidden units, or those that read motion."""
    return [term for term in terms if term.reads == what]


def completed(batch, loss_network, mean, deviation, kernels=tiled):
    """The batch with L(I) and with I in lengths and radians, where it lacks them."""
    hidden = encode(batch.I, loss_network,
                    kernels=kernels) if batch.hidden is None else batch.hidden
    motion = denormalise(batch.I, mean, deviation) if batch.motion is None else batch.motion
    return replace(batch, hidden=hidden, motion=motion)


def denormalise(O, mean, deviation):
    """(N, 66, T) back to lengths and radians, in O's own precision."""
    return O * column(deviation, O) + column(mean, O)


def column(values, like):
    """Numbers of the 66 rows beside arrays (N, 66, T), in their precision."""
    return np.asarray(values, dtype=like.real.dtype)[:, None]
