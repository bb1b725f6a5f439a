r"""Gradients of parts of a batch, for threads, processes or machines: any
`concurrent.futures.Executor`, or whatever has such a `map`.

The loss of a batch is a mean over its windows, so is its gradient:
g = sum over parts of (windows of the part / windows of the batch) g_part. `style_part` and
`autoencoder_part` are functions of their argument alone and can be sent to another process; the
parts are summed in their order, so that the result does not depend on who was faster. What a worker
keeps between calls (spectra, large arrays) is only a memory of work done.
"""

from dataclasses import dataclass
import secrets
import threading

import numpy as np

from .networks import autoencoder_loss, autoencoder_loss_backward
from .step import AutoencoderStep, StyleStep
from .objective import EQUATION_10, Batch, total_loss, total_loss_backward

_kept = threading.local()


@dataclass(frozen=True)
class StyleWork:
    """One part of a batch, and the constants of its training run.

    run, part : which training and which part of its batches: under these a worker keeps the arrays
    that the answer stands in, so that two parts of one batch never share them;  kernels : None for
    the shared step, or who computes the definition
    """

    run: str
    part: int
    params: dict
    batch: Batch
    loss_network: dict
    normaliser: tuple
    weights: object
    terms: tuple = EQUATION_10
    kernels: object = None


@dataclass(frozen=True)
class AutoencoderWork:
    """One part of a batch: clean windows, what is encoded instead of them (or None), and the
    choices of depooling by chance (or None).
    """

    run: str
    part: int
    params: dict
    alpha: float
    X: np.ndarray
    noisy: object
    chosen: object = None
    kernels: object = None


def new_run():
    """A name for a training run, under which workers keep what belongs to it. It enters no result.
    """
    return secrets.token_hex(8)


# the training loop looks for numbers that are not finite, and says where
@np.errstate(over="ignore", invalid="ignore")
def style_part(work):
    """Equation 10 on a part.   StyleWork  ->  number of windows, {term: mean}, gradients"""
    shape = work.batch.I.shape
    if work.kernels is not None:
        arguments, how = (work.params, work.batch, work.loss_network, *work.normaliser,
                          work.weights), {"terms": work.terms, "kernels": work.kernels}
        return shape[0], total_loss(*arguments,
                                    **how)[1], total_loss_backward(1.0, *arguments, **how)
    step = _keep(
        work, shape, lambda: StyleStep(*shape[::2], work.params, work.loss_network, *work.
                                       normaliser, work.weights, work.terms))
    return (shape[0], *step(work.params, work.batch))


@np.errstate(over="ignore", invalid="ignore")
def autoencoder_part(work):
    """Equation 3 on a part.   AutoencoderWork  ->  number of windows, {"loss": mean}, gradients"""
    if work.kernels is not None:
        settings = dict(alpha=work.alpha, noisy=work.noisy, chosen=work.chosen,
                        kernels=work.kernels)
        loss = autoencoder_loss(work.X, work.params, **settings)
        return len(work.X), {"loss": loss}, autoencoder_loss_backward(work.X.dtype.type(1), work.X,
                                                                      work.params, **settings)[1]
    step = _keep(
        work, work.X.shape, lambda: AutoencoderStep(*work.X.shape[::2], work.params, alpha=work.
                                                    alpha, random=work.chosen is not None))
    loss, gradients = step(work.params, work.X, work.noisy, work.chosen)
    return len(work.X), {"loss": loss}, gradients


def _keep(work, shape, make):
    """The step of this run for this part and its shape, made at the first call in this thread;
    those of an earlier run are forgotten.
    """
    if getattr(_kept, "run", None) != work.run:
        _kept.run, _kept.steps = work.run, {}
    if (work.part, shape) not in _kept.steps:
        _kept.steps[work.part, shape] = make()
    return _kept.steps[work.part, shape]


def summed(results):
    """The mean losses and gradients of a batch from its parts, in order.
    ->  losses, gradients (the first part's own arrays when it is the only one)
    """
    results = list(results)
    if len(results) == 1:
        return results[0][1:]
    total = sum(count for count, _, _ in results)
    shares = [count / total for count, _, _ in results]
    losses = {
        name: sum(share * part[name] for share, (_, part, _) in zip(shares, results))
        for name in results[0][1]}
    gradients = {
        name: sum(
            g.dtype.type(share) * g
            for share, g in ((share, part[name]) for share, (_, _, part) in zip(shares, results)))
        for name in results[0][2]}
    return losses, gradients


def in_parts(indices, parts):
    """Indices cut in parts of nearly the same size, none empty.   ->  list of arrays"""
    return [part for part in np.array_split(indices, min(parts, len(indices)))]
