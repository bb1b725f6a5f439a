r"""A batch in parts, side by side: for threads, processes or machines, any
`concurrent.futures.Executor`, or whatever has such a `map`.

The loss of a batch is a mean over its windows, so is its gradient:
g = sum over parts of (windows of the part / windows of the batch) g_part. `of_part` is a function
of its argument alone and can be sent to another process; the parts are summed in their order, so
that the result does not depend on who was faster. What a worker keeps between calls (spectra, large
arrays) is only a memory of work done.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
import secrets
import threading
from typing import Any

import numpy as np

from ..holden2017.networks import Found

_kept = threading.local()


@dataclass(frozen=True)
class Part:
    """One part of a batch.

    run, number : which training and which part of its batches: under these a worker keeps the
    arrays that the answer stands in, so that two parts of one batch never share them
    once : the `Run`, or None for a worker that should know it
    batch : some windows, or their numbers in the run's training set
    """

    run: str
    number: int
    once: "Run | None"
    params: dict[str, np.ndarray]
    batch: Any


@dataclass(frozen=True)
class Run:
    """What does not change in a training.

    make : of the constants, (params, batch) -> losses, gradients;  training_set : or None
    """

    make: Callable
    constants: tuple
    training_set: Any


def of_part(part: Part) -> tuple[int, dict[str, Any], dict[str, np.ndarray]] | None:
    """Losses and gradients of a part.   ->  number of windows, {term: mean}, gradients; None where
    the part comes without its run and this worker does not know it

    The gradients' function is made at the first call in this thread; an earlier run is forgotten.
    """
    if getattr(_kept, "name", None) != part.run:
        if part.once is None:
            return None
        _kept.name, _kept.run, _kept.gradients = part.run, part.once, {}
    run = _kept.run
    if part.number not in _kept.gradients:
        _kept.gradients[part.number] = run.make(*run.constants)
    batch = part.batch if run.training_set is None else run.training_set.batch(part.batch)
    with np.errstate(over="ignore", invalid="ignore"):           # the training loop looks for them
        return (len(batch), *_kept.gradients[part.number](part.params, batch))


def sharded(make: Callable, parts: int, executor: Any = None, training_set: Any = None) -> Callable:
    """What `train_style` and `train_autoencoder` take as `gradients`, each batch in parts.

    make : `gradients.style_gradients`, say;  executor : who computes the parts, one after the other
    unless given; the same number of parts gives the same bits, whoever computes them
    training_set : that of `train_style`: a worker is sent it once, as it is the constants, and with
    each part the parameters and the numbers of its windows alone. For processes and machines
    """
    each = executor.map if executor else map

    def _made(*constants):
        name = secrets.token_hex(8)          # under which workers keep their arrays; in no result
        once = Run(make, constants, training_set)

        def _of_batch(params, batch):
            rows = np.array_split(np.arange(len(batch)), min(parts, len(batch)))
            work = [Part(name, number, None, params, batch.part(some) if training_set is None
                         else batch.rows[some]) for number, some in enumerate(rows)]
            results = list(each(of_part, work))
            new = [number for number, result in enumerate(results) if result is None]
            if new:
                told = each(of_part, [replace(work[number], once=once) for number in new])
                for number, result in zip(new, told):
                    results[number] = result
            return summed(results)
        return _of_batch
    return _made


def summed(results: Iterable[tuple[int, dict[str, Any], dict[str, np.ndarray]]]) -> Found:
    """The mean losses and gradients of a batch from its parts, in order.

    ->  losses, gradients (the first part's own arrays when it is the only one)

    >>> summed([(1, {"loss": 2.0}, {"w": np.array([4.0])}), (3, {"loss": 6.0}, {"w": np.zeros(1)})])
    ({'loss': 5.0}, {'w': array([1.])})
    """
    results = list(results)
    if len(results) == 1:
        return results[0][1:]
    total = sum(count for count, _, _ in results)
    shares = [count / total for count, _, _ in results]
    losses = {name: sum(share * part[name] for share, (_, part, _) in zip(shares, results))
              for name in results[0][1]}
    gradients = {name: sum(part[name].dtype.type(share) * part[name]
                           for share, (_, _, part) in zip(shares, results))
                 for name in results[0][2]}
    return losses, gradients
