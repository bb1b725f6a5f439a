r"""The 2016 code's trainer (`train.py`, `AdamTrainer`): the autoencoder window by window.

Its script takes batches of one window, Adam's rate 1e-5 with epsilon 1e-8 outside the root, and 100
epochs over CMU, HDM05, MHAD, Edinburgh's locomotion, xsens and the authors' own recordings; the
clips of the style transfer are not among them.
"""

from collections.abc import Callable, Iterator
import time

import numpy as np

from .. import nn
from ..holden2017.train import Record, State, TrainingError
from .network import DROPOUT, autoencoder_loss, autoencoder_loss_backward, init_network

RATE, EPOCHS = 1e-5, 100


def train(X: np.ndarray, *, epochs: int = EPOCHS, batch: int = 1, rate: float = RATE,
          hidden: int = 256, width: int = 25, seed: int = 0, chance: bool = True,
          shuffle: bool = True, state: State | None = None,
          draws: Callable = np.random.default_rng) -> Iterator[tuple[Record, State]]:
    """Minimise `network.autoencoder_loss` over windows.

    X : (N, 73, T) normalised, T even
    batch : windows a step
    rate : Adam's learning rate
    hidden, width : hidden units and width of the filters
    chance : False for neither dropout nor depooling by chance
    shuffle : False for the windows in their order
    state : to go on from, or to begin at
    draws : makes the random numbers of an epoch, of a list of whole numbers
    ->  yields (Record, State) after each epoch; an epoch's chances depend on seed and epoch alone
    Raises ValueError, TrainingError when the loss is no longer finite.
    """
    if X.ndim != 3 or not len(X) or X.shape[2] % 2:
        raise ValueError(f"X: found shape {X.shape}, needed (windows, numbers, frames) with an "
                         "even number of frames")
    if batch < 1 or not width % 2:
        raise ValueError(f"batch, width: found {batch} and {width}, needed at least one window and "
                         "an odd width")
    if state is None:
        params = init_network(np.random.default_rng(seed), hidden=hidden, width=width,
                              numbers=X.shape[1], dtype=X.dtype)
        state = State(params, nn.adam_start(params), 0)
    for epoch in range(state.epoch + 1, epochs + 1):
        began, rng = time.perf_counter(), draws([seed, 16, epoch])
        params, adam = state.params, state.adam
        order = rng.permutation(len(X)) if shuffle else np.arange(len(X))
        costs, sizes = [], []
        for begin in range(0, len(order), batch):
            windows = X[order[begin:begin + batch]]
            chances = draw(rng, windows.shape, len(params["be"])) if chance else {}
            costs.append(float(autoencoder_loss(windows, params, **chances)))
            if not np.isfinite(costs[-1]):
                raise TrainingError(f"epoch {epoch}, window {begin}: found a loss of {costs[-1]}, "
                                    f"needed a finite one; a rate below {rate:g} may help")
            gradients = autoencoder_loss_backward(X.dtype.type(1), windows, params, **chances)[1]
            sizes.append(float(np.sqrt(sum(np.sum(g * g) for g in gradients.values()))))
            params, adam = nn.adam_step(params, gradients, adam, rate=rate)
        state = State(params, adam, epoch)
        yield (Record(epoch, {"loss": float(np.mean(costs))}, float(np.mean(sizes)),
                      time.perf_counter() - began), state)


def draw(rng: np.random.Generator, shape: tuple[int, int, int],
         hidden: int) -> dict[str, np.ndarray]:
    """What chance decides for one batch: each number is kept with probability 3/4 before each
    convolution, and one frame of each pair gets a hidden unit's whole value.

    shape : (N, 73, T), hidden : m  ->  the keywords of `network.autoencoder_loss`

    >>> chances = draw(np.random.default_rng(0), (1, 73, 8), 4)
    >>> {name: array.shape for name, array in chances.items()}
    {'kept': (1, 73, 8), 'chosen': (1, 4, 4), 'kept_hidden': (1, 4, 8)}
    """
    N, _, T = shape
    return {"kept": (rng.random(shape) >= DROPOUT).astype(np.int8),
            "chosen": rng.integers(2, size=(N, hidden, T // 2), dtype=np.int8),
            "kept_hidden": (rng.random((N, hidden, T)) >= DROPOUT).astype(np.int8)}
