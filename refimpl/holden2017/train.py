r"""Training the two networks with Adam. Both loops are generators: a record and the state to go on
from, after every epoch.

Nothing is printed and no global state is touched; whoever iterates shows the progress and may stop
at any epoch. The random numbers of an epoch depend on the seed and the epoch alone, so that a run
that is resumed goes the same way as one that was never interrupted.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
import time
from typing import Any

import numpy as np

from .. import nn
from ..nn.adam import annealed
from ..storage import plausible
from .trained import Manifold
from .networks import (SPARSE, CHANNELS, DEPOOLING, HIDDEN, WIDTH, Found, Gradients, Params,
                       Reconstruction, autoencoder_gradients, init_loss_network,
                       init_transformation_network)
from .objective import EQUATION_10, Terms, Weights, style_gradients
from .pairing import TrainingSet

BATCH, RATE = 10, 1e-3
AUTOENCODER_RATE = 5e-4                                          # with 1e-3 its loss ends higher


@dataclass(frozen=True)
class Record:
    """One epoch: its number (from 1), mean losses by name, mean norm of the gradient, seconds it
    took."""

    epoch: int
    losses: dict[str, float]
    gradient_norm: float
    seconds: float


@dataclass(frozen=True)
class State:
    """Everything needed to go on after an epoch: parameters, Adam's moments, epochs done."""

    params: Gradients
    adam: dict[str, Any]
    epoch: int


class TrainingError(ValueError):
    """Training cannot go on; the message says at which epoch and batch."""


def start_state(params: Params) -> State:
    """A State before the first epoch, its arrays laid out as fast gradients read them best."""
    laid_out = {name: np.asfortranarray(p) for name, p in params.items()}
    return State(laid_out, nn.adam_start(laid_out), 0)


def train_autoencoder(X: np.ndarray, *, epochs: int, batch: int = BATCH,
                      rate: float = AUTOENCODER_RATE, alpha: float = SPARSE, dropout: float = 0.02,
                      depooling: str = "random", hidden: int = HIDDEN, width: int = WIDTH,
                      seed: int = 0, state: State | None = None,
                      gradients: Callable = autoencoder_gradients,
                      draws: Callable = np.random.default_rng) -> Iterator[tuple[Record, State]]:
    r"""Train the loss network by equation 3.

    X : (N, 66, T) normalised windows, float32 or float64, T even
    dropout : share of input numbers set to 0 (the others grow by 1 / (1 - dropout)), so that the
    network learns to mend motion; 0 is equation 3 as printed
    depooling : "random", which gives one of two frames the whole value while the network learns, or
    "average" (equation 2 as printed), with which it learns to jitter
    state : to go on from;  gradients : makes of alpha what each batch asks for, (params,
    `networks.Reconstruction`) -> losses, gradients; `fast.gradients.autoencoder_gradients` is
    sooner;  draws : makes the random numbers of an epoch, of a list of whole numbers
    ->  yields (Record, State) after each epoch
    """
    if depooling not in DEPOOLING:
        raise ValueError(f"depooling: found {depooling!r}, needed {' or '.join(DEPOOLING)}")
    state = state or start_state(
        init_loss_network(np.random.default_rng(seed), hidden=hidden, width=width, dtype=X.dtype))
    of_batch = gradients(alpha)

    def step(params: Params, indices: np.ndarray, rng: np.random.Generator) -> Found:
        clean = X[indices]
        keep = rng.random(clean.shape, dtype=np.float32) >= dropout
        noisy = clean * keep * X.dtype.type(1 / (1 - dropout)) if dropout else None
        units = (len(clean), clean.shape[2] // 2, len(params["b0"]))
        chosen = (rng.integers(2, size=units, dtype=np.int8).swapaxes(1, 2)
                  if depooling == "random" else None)
        return of_batch(params, Reconstruction(clean, noisy, chosen))

    yield from _epochs(state, epochs, (seed, 1), len(X), batch, rate, step, draws)


def train_style(training_set: TrainingSet, manifold: Manifold, *, epochs: int,
                weights: Weights = Weights(), terms: Terms = EQUATION_10, batch: int = BATCH,
                rate: float = RATE, channels: int = CHANNELS, width: int = WIDTH, seed: int = 0,
                state: State | None = None, gradients: Callable = style_gradients,
                draws: Callable = np.random.default_rng) -> Iterator[tuple[Record, State]]:
    r"""Train a transformation network by the objective against a fixed loss network.

    weights : for the data's unit;  terms : of the objective (`objective.Term`);  state : to go on
    from;  gradients : makes, of the loss network, the normaliser's mean and standard deviation,
    weights and terms, what each batch asks for, (params, `objective.Batch`) -> losses, gradients;
    `fast.gradients.style_gradients` is sooner;  draws : as for `train_autoencoder`
    ->  yields (Record, State) after each epoch
    """
    X, normaliser = training_set.X, manifold.normaliser
    state = state or start_state(init_transformation_network(
        np.random.default_rng([seed, 2]), channels=channels, width=width, dtype=X.dtype))
    of_batch = gradients(manifold.params, normaliser.mean, normaliser.deviation, weights,
                         tuple(terms))

    def step(params: Params, indices: np.ndarray, rng: np.random.Generator) -> Found:
        found, g = of_batch(params, training_set.batch(indices))
        return {"loss": sum(found.values()), **found}, g

    yield from _epochs(state, epochs, (seed, 3), len(X), batch, rate, step, draws)


def _epochs(state, epochs, seeds, count, size, rate, step, draws):
    """The epochs that are left, each in a random order of its own, its last batch as small as it
    comes.   step : (params, indices, rng) -> losses, gradients
    """
    for epoch in range(state.epoch + 1, epochs + 1):
        rng = draws([*seeds, epoch])
        record, state = run_epoch(state, epoch, rng.permutation(count), size,
                                  lambda params, indices: step(params, indices, rng),
                                  annealed(rate, epoch, epochs))
        yield record, state


@np.errstate(over="ignore", invalid="ignore")                    # what is not finite is told below
def run_epoch(state: State, epoch: int, order: np.ndarray, size: int,
              step: Callable[[Params, np.ndarray], Found], rate: float) -> tuple[Record, State]:
    """One epoch: the windows in an order, so many at a time, the last batch as small as it comes.

    order : (N,) whole numbers;  step : (params, indices) -> losses, gradients;  rate : of Adam
    """
    began = time.perf_counter()
    batches = [order[i:i + size] for i in range(0, len(order), size)]
    sums: dict[str, float] = {}
    norms = []
    params, adam = state.params, state.adam
    for number, indices in enumerate(batches, start=1):
        losses, gradients = step(params, indices)
        norm = float(np.sqrt(sum(float(np.vdot(g.T, g.T)) for g in gradients.values())))
        if not np.isfinite(norm) or not np.isfinite(losses["loss"]):
            raise TrainingError(
                f"epoch {epoch}, batch {number} of {len(batches)}: found loss {losses['loss']} and "
                f"gradient norm {norm}, needed finite numbers; lower the learning rate or look for "
                "a bad clip in this batch")
        for name, loss in losses.items():
            sums[name] = sums.get(name, 0.0) + float(loss) * len(indices)
        norms.append(norm)
        params, adam = nn.adam_step(params, gradients, adam, rate=rate)
    if wild := [name for name, p in params.items() if not plausible(p)]:
        raise TrainingError(f"epoch {epoch}: found {', '.join(wild)} not finite or beyond 1e9, "
                            "needed weights that can be used; lower the learning rate")
    means = {name: total / len(order) for name, total in sums.items()}
    return (Record(epoch, means, float(np.mean(norms)), time.perf_counter() - began),
            State(params, adam, epoch))
