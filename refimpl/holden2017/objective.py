r"""The objective of training, the sum of five losses of the transformation network's output.

`EQUATION_10` is that sum as a list of terms. Whatever sums, names, weighs, plots or checks terms
walks such a list, and a term from outside is trained with by `terms=[*EQUATION_10, mine]`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from . import losses
from .networks import (HIDDEN, Found, Gradients, Params, encode, encode_backward_to_input,
                       transformation, transformation_backward)

LEG = 80.0                                        # centimetres, for which the weights are


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

    def fitted(self, leg: float, hidden: int = HIDDEN) -> "Weights":
        """The same weights for data in which a leg has this length and a loss network of so many
        units.

        Squared lengths shrink or grow with the square of the leg. A mean over fewer units is
        larger, since each has more to say.

        >>> Weights().fitted(leg=0.8).bone                       # metres
        0.2
        """
        share = HIDDEN / hidden if self.reading == "mean_squares" else 1.0
        fitted: dict[str, Any] = {
            term.name: term.weight_of(self) * ((leg / LEG) ** term.power * share)
            for term in EQUATION_10 if term.power}
        return replace(self, **fitted, turn=self.turn * (leg / LEG) ** 2)


# What training takes for each reading. A mean of squares pulls with 2 |D| / (m T), some 1/200 of a
# norm's pull, where D = L(I) - L(T(I)) has m T = 30,720 elements (256 hidden units, windows of 240
# frames) and is some 75 long; a sum with 2 |D|. The constraints of squares are four times those of
# norms beside the rest, which keeps the path (`docs/recipe.md` has the curve). s weighs a square of
# the hidden units against the units: for norms, 0.01 leaves a third more of the style.
WEIGHTS = {"norm": Weights(1.0, 0.06, 0.01, 0.001, 0.5, reading="norm"),
           "mean_squares": Weights(),
           "sum_squares": Weights(1.0, 0.01, 6.0, 0.6, 300.0, reading="sum_squares")}


@dataclass(frozen=True)
class Batch:
    """Some windows and what the network's output for them is compared with: what travels from
    pairing to gradient.

    I : (N, 66, T) normalised input;  gram : (N, m, m), the style's Gram matrices;
    contacts : (N, 4, T); bones : (20,);  trajectory : (N, 3, T) denormalised velocities of the
    input;  hidden : L(I) (N, m, T // 2), and motion : I in lengths and radians (N, 66, T), both
    computed where they are not given;  foot_velocity : r' of equation 7;  rows : the windows'
    numbers in the training set
    """

    I: np.ndarray
    gram: np.ndarray | None
    contacts: np.ndarray
    bones: np.ndarray
    trajectory: np.ndarray
    hidden: np.ndarray | None = None
    motion: np.ndarray | None = None
    foot_velocity: Any = 0.0
    rows: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.I)

    def part(self, rows: Any) -> "Batch":
        """Some of the windows; what all share stays."""
        of_each = ["I", "gram", "contacts", "trajectory", "hidden", "motion", "rows"]
        if np.ndim(self.foot_velocity) == 4 and len(self.foot_velocity) == len(self):
            of_each.append("foot_velocity")
        return replace(self, **{name: getattr(self, name)[rows] for name in of_each
                                if getattr(self, name) is not None})


@dataclass(frozen=True)
class Term:
    """One term of the objective.

    reads : "hidden", L(O) (N, m, T // 2), or "motion", O in lengths and radians (N, 66, T)
    loss, backward : (x, Batch, Weights) -> (N,) and (dloss (N,), x, Batch, Weights) -> dx, both
    without the weight
    weight : None for that of `Weights` under its name
    power : of the leg's length, with which the weight goes
    """

    name: str
    reads: str
    loss: Callable
    backward: Callable
    weight: float | None = None
    power: int = 0

    def weight_of(self, weights: Weights) -> float:
        """What the term counts."""
        return getattr(weights, self.name) if self.weight is None else self.weight


# The losses as terms: (x, batch, w), the backward with dloss in front. Named functions, so that a
# process can be sent them.

def _content(H, batch, w):
    return losses.content_loss(batch.hidden, H, reading=w.reading)


def _content_backward(dloss, H, batch, w):
    return losses.content_loss_backward(dloss, batch.hidden, H, reading=w.reading)[1]


def _style(H, batch, w):
    return losses.style_loss(batch.gram, H, s=1.0, reading=w.reading)


def _style_backward(dloss, H, batch, w):
    return losses.style_loss_backward(dloss, batch.gram, H, s=1.0, reading=w.reading)[1]


def _foot(motion, batch, w):
    return losses.foot_loss(motion, batch.contacts, target=batch.foot_velocity)


def _foot_backward(dloss, motion, batch, w):
    return losses.foot_loss_backward(dloss, motion, batch.contacts, target=batch.foot_velocity)


def _bone(motion, batch, w):
    return losses.bone_loss(motion, batch.bones)


def _bone_backward(dloss, motion, batch, w):
    return losses.bone_loss_backward(dloss, motion, batch.bones)


def _trajectory(motion, batch, w):
    return losses.trajectory_loss(motion, batch.trajectory, turn_weight=w.turn)


def _trajectory_backward(dloss, motion, batch, w):
    return losses.trajectory_loss_backward(dloss, motion, batch.trajectory, turn_weight=w.turn)


CONTENT = Term("content", "hidden", _content, _content_backward)
STYLE = Term("style", "hidden", _style, _style_backward)
FOOT = Term("foot", "motion", _foot, _foot_backward, power=-2)
BONE = Term("bone", "motion", _bone, _bone_backward, power=-2)
TRAJECTORY = Term("trajectory", "motion", _trajectory, _trajectory_backward, power=-2)
Terms = Sequence[Term]
EQUATION_10 = (CONTENT, STYLE, FOOT, BONE, TRAJECTORY)
CONSTRAINTS = (FOOT, BONE, TRAJECTORY)
WEIGHED = (*(term.name for term in EQUATION_10), "turn")


def term_losses(x: np.ndarray, batch: Batch, terms: Terms,
                weights: Weights) -> dict[str, np.ndarray]:
    """Weighted losses of terms that all read x.   ->  {term: (N,)}"""
    return {term.name: term.weight_of(weights) * term.loss(x, batch, weights) for term in terms}


def term_losses_backward(dloss: np.ndarray, x: np.ndarray, batch: Batch, terms: Terms,
                         weights: Weights) -> np.ndarray:
    """Gradient of their sum.   dloss : (N,)  ->  dx"""
    return sum((term.backward(term.weight_of(weights) * dloss, x, batch, weights)
                for term in terms), np.zeros_like(x))


def motion_losses(O: np.ndarray, batch: Batch, loss_network: Params, mean: np.ndarray,
                  deviation: np.ndarray, weights: Weights = Weights(), *,
                  terms: Terms = EQUATION_10) -> dict[str, np.ndarray]:
    r"""The terms of the objective for an output O of the transformation network.

    O : (N, 66, T) normalised;  loss_network : W0, b0;  mean, deviation : (66,) of the normaliser
    ->  {term: (N,)}
    """
    batch = completed(batch, loss_network, mean, deviation)
    found = {**term_losses(encode(O, loss_network), batch, reading("hidden", terms), weights),
             **term_losses(denormalise(O, mean, deviation), batch, reading("motion", terms),
                           weights)}
    return {term.name: found[term.name] for term in terms}


def motion_losses_backward(dloss: np.ndarray, O: np.ndarray, batch: Batch, loss_network: Params,
                           mean: np.ndarray, deviation: np.ndarray, weights: Weights = Weights(),
                           *, terms: Terms = EQUATION_10) -> np.ndarray:
    r"""Gradient of the sum of the terms.   dloss : (N,), O : (N, 66, T)  ->  dO (N, 66, T)

    What reads hidden units comes back through the loss network, what reads motion through the
    denormalisation  motion = O deviation + mean.
    """
    batch = completed(batch, loss_network, mean, deviation)
    dH = term_losses_backward(dloss, encode(O, loss_network), batch, reading("hidden", terms),
                              weights)
    dmotion = term_losses_backward(dloss, denormalise(O, mean, deviation), batch,
                                   reading("motion", terms), weights)
    return encode_backward_to_input(dH, O, loss_network) + dmotion * column(deviation, O)


def total_loss(params: Params, batch: Batch, loss_network: Params, mean: np.ndarray,
               deviation: np.ndarray, weights: Weights = Weights(), *,
               terms: Terms = EQUATION_10) -> tuple[Any, dict[str, Any]]:
    r"""The objective of T(I), a mean over the batch (Holden 2017, Equation 10):

        Loss(O) = content + style + foot + bone + trajectory,   O = T(I)

    params : of T  ->  scalar, {term: scalar}
    """
    found = motion_losses(transformation(batch.I, params), batch, loss_network, mean, deviation,
                          weights, terms=terms)
    means = {name: loss.mean() for name, loss in found.items()}
    return sum(means.values()), means


def total_loss_backward(dloss: Any, params: Params, batch: Batch, loss_network: Params,
                        mean: np.ndarray, deviation: np.ndarray, weights: Weights = Weights(), *,
                        terms: Terms = EQUATION_10) -> Gradients:
    """Gradient of `total_loss` with respect to the parameters of T.

    dloss : scalar  ->  gradients with the keys of params
    """
    O = transformation(batch.I, params)
    per_clip = np.full(len(O), dloss / len(O), dtype=O.real.dtype)
    dO = motion_losses_backward(per_clip, O, batch, loss_network, mean, deviation, weights,
                                terms=terms)
    return transformation_backward(dO, batch.I, params)[1]


def style_gradients(loss_network: Params, mean: np.ndarray, deviation: np.ndarray,
                    weights: Weights = Weights(), terms: Terms = EQUATION_10,
                    ) -> Callable[[Params, Batch], Found]:
    """What training asks for each batch, by the definition.

    ->  (params, Batch) -> {term: scalar}, gradients
    """
    def of_batch(params: Params, batch: Batch) -> Found:
        constants = (params, batch, loss_network, mean, deviation, weights)
        return (total_loss(*constants, terms=terms)[1],
                total_loss_backward(1.0, *constants, terms=terms))

    return of_batch


def reading(what: str, terms: Terms) -> list[Term]:
    """The terms that read hidden units, or those that read motion."""
    return [term for term in terms if term.reads == what]


def completed(batch: Batch, loss_network: Params, mean: np.ndarray,
              deviation: np.ndarray) -> Batch:
    """The batch with L(I) and with I in lengths and radians, where it lacks them."""
    hidden = encode(batch.I, loss_network) if batch.hidden is None else batch.hidden
    motion = denormalise(batch.I, mean, deviation) if batch.motion is None else batch.motion
    return replace(batch, hidden=hidden, motion=motion)


def denormalise(O: np.ndarray, mean: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """(N, 66, T) back to lengths and radians, in O's own precision."""
    return O * column(deviation, O) + column(mean, O)


def column(values: np.ndarray, like: np.ndarray) -> np.ndarray:
    """Numbers of the 66 rows beside arrays (N, 66, T), in their precision.   (66,)  ->  (66, 1)"""
    return np.asarray(values, dtype=like.real.dtype)[:, None]
