r"""Training the two networks with Adam. Both loops are generators: a record and the state to go on
from, after every epoch.

Nothing is printed and no global state is touched; whoever iterates shows the progress and may stop
at any epoch. The random numbers of an epoch depend on the seed and the epoch alone, so that a run
that is resumed goes the same way as one that was never interrupted.
"""

from dataclasses import dataclass
import time

import numpy as np

from .. import nn
from .networks import init_loss_network, init_transformation_network
from .parts import AutoencoderWork, StyleWork, autoencoder_part, in_parts, new_run, style_part, summed
from .lesson import batch_of
from .objective import EQUATION_10, Weights

BATCH, RATE = 10, 1e-3
AUTOENCODER_RATE = 5e-4                                         # with 1e-3 its loss ends higher
# while the loss network learns; it runs with averages
DEPOOLING = ("random", "average")


@dataclass(frozen=True)
class Record:
    """One epoch: its number (from 1), mean losses by name, mean norm of the gradient, seconds it
    took.
    """

    epoch: int
    losses: dict
    gradient_norm: float
    seconds: float


@dataclass(frozen=True)
class State:
    """Everything needed to go on after an epoch: parameters, Adam's moments, epochs done."""

    params: dict
    adam: dict
    epoch: int


class TrainingError(ValueError):
    """Training cannot go on; the message says at which epoch and batch."""


def start_state(params):
    """A State before the first epoch.
    params : dict of arrays, which are laid out as the steps read them best
    """
    params = {name: np.asfortranarray(p) for name, p in params.items()}
    return State(params, nn.adam_start(params), 0)


def train_autoencoder(X, *, epochs, batch=BATCH, rate=AUTOENCODER_RATE, alpha=0.01, dropout=0.02,
                      depooling="random", hidden=256, width=25, seed=0, state=None, kernels=None,
                      executor=None, parts=1):
    r"""Train the loss network by equation 3.

    X : (N, 66, T) normalised windows, float32 or float64, T even;  dropout : share of input numbers
    set to 0 (the others grow by 1 / (1 - dropout)), so that the network learns to mend motion; 0 is
    equation 3 as printed;  depooling : "random", which gives one of two frames the whole value
    while the network learns, or "average" (equation 2 as printed), with which it learns to jitter;
    state : to go on from
    kernels, executor, parts : see `train_style`   ->  yields (Record, State) after each epoch
    """
    if depooling not in DEPOOLING:
        raise ValueError(f"depooling: found {depooling!r}, needed {' or '.join(DEPOOLING)}")
    state = state or start_state(
        init_loss_network(np.random.default_rng(seed), hidden=hidden, width=width, dtype=X.dtype))
    run, each = new_run(), executor.map if executor else map
    for epoch in range(state.epoch + 1, epochs + 1):
        rng = np.random.default_rng([seed, 1, epoch])

        def step(params, indices):
            clean = X[indices]
            keep = rng.random(clean.shape, dtype=np.float32) >= dropout
            noisy = clean * keep * X.dtype.type(1 / (1 - dropout)) if dropout else None
            units = (len(clean), clean.shape[2] // 2, len(params["b0"]))
            chosen = rng.integers(2, size=units, dtype=np.int8).swapaxes(
                1, 2) if depooling == "random" else None

            def work(part, i):
                return AutoencoderWork(run, part, params, alpha, clean[i],
                                       noisy if noisy is None else noisy[i],
                                       chosen if chosen is None else chosen[i], kernels)
            return summed(
                each(autoencoder_part, [
                    work(part, i)
                    for part, i in enumerate(in_parts(np.arange(len(indices)), parts))]))

        record, state = _epoch(state, epoch, _batches(rng, len(X), batch), step,
                               annealed(rate, epoch, epochs))
        yield record, state


def train_style(lesson, manifold, *, epochs, weights=Weights(), terms=EQUATION_10, batch=BATCH,
                rate=RATE, channels=128, width=25, seed=0, state=None, kernels=None, executor=None,
                parts=1):
    r"""Train a transformation network by equation 10 against a fixed loss network.

    lesson : Lesson;  manifold : Manifold;  weights : for the data's unit;  terms : of the objective
    (`objective.Term`);  kernels : None for the shared steps of `step`, or who provides the
    convolutions of the definition (`refimpl.nn` for the direct ones);  executor : a
    `concurrent.futures.Executor` that computes the `parts` of each batch; the same number of parts
    gives the same bits, whoever computes them   ->  yields (Record, State) after each epoch
    """
    state = state or start_state(
        init_transformation_network(np.random.default_rng([seed, 2]), channels=channels,
                                    width=width, dtype=lesson.X.dtype))
    constants = (manifold.params, (manifold.normaliser.mean, manifold.normaliser.deviation),
                 weights, tuple(terms), kernels)
    run, each = new_run(), executor.map if executor else map

    def work(params, part, i):
        return StyleWork(run, part, params, batch_of(lesson, i), *constants)

    def step(params, indices):
        found, gradients = summed(
            each(style_part,
                 [work(params, part, i) for part, i in enumerate(in_parts(indices, parts))]))
        return {"loss": sum(found.values()), **found}, gradients

    for epoch in range(state.epoch + 1, epochs + 1):
        rng = np.random.default_rng([seed, 3, epoch])
        record, state = _epoch(state, epoch, _batches(rng, len(lesson.X), batch), step,
                               annealed(rate, epoch, epochs))
        yield record, state


def annealed(rate, epoch, epochs):
    """The learning rate of an epoch (from 1): constant in the first half, then falling in a
    straight line to nearly 0.

    Norms that are not squared pull equally hard near their minimum; with a constant rate the
    weights would tremble there to the end.
    """
    return rate * min(1.0, 2.0 * (1.0 - (epoch - 0.5) / epochs))


def _batches(rng, count, size):
    """Indices of an epoch in random order, the last batch as small as it comes."""
    order = rng.permutation(count)
    return [order[i:i + size] for i in range(0, count, size)]


def _epoch(state, epoch, batches, step, rate):
    """Run one epoch.   step : (params, indices) -> losses, gradients   ->  Record, State"""
    # the state that came in stays as it is
    params = {name: p.copy(order="F") for name, p in state.params.items()}
    adam = {
        "t": state.adam["t"], **{
            moment: {
                name: a.copy(order="F") for name, a in state.adam[moment].items()} for moment in "mv"}
    }
    began, sums, norms = time.perf_counter(), {}, []
    for number, indices in enumerate(batches, start=1):
        losses, gradients = step(params, indices)
        norm = float(np.sqrt(sum(float(np.vdot(g.T, g.T)) for g in gradients.values())))
        if not np.isfinite(norm) or not np.isfinite(losses["loss"]):
            raise TrainingError(
                f"epoch {epoch}, batch {number} of {len(batches)}: found loss {losses['loss']} and "
                f"gradient norm {norm}, "
                "needed finite numbers; lower the learning rate or look for a bad clip in this "
                "batch")
        for name, loss in losses.items():
            sums[name] = sums.get(name, 0.0) + float(loss) * len(indices)
        norms.append(norm)
        params, adam = nn.adam_step(params, gradients, adam, rate=rate)
    count = sum(map(len, batches))
    means = {name: total / count for name, total in sums.items()}
    return Record(epoch, means, float(np.mean(norms)),
                  time.perf_counter() - began), State(params, adam, epoch)
