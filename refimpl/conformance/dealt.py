"""What is handed to the reference's own loops: random numbers that are none, but were dealt before,
and of the options those that are said.
"""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np


class Dealt:
    """Stands where a numpy.random.Generator would.

    order : what a permutation comes to;  parts : for each window, what it gets, in turn, each time
    that something is drawn for a batch (None for ones);  numbers : of [0, 1), one after the other
    """

    def __init__(self, order: Any = (), *parts: Any, numbers: Any = ()) -> None:
        self.order, self.parts, self.numbers = order, parts, numbers
        self.calls = self.at = 0

    def permutation(self, x: Any) -> Any:
        """The order, or numbers in it."""
        return self.order if np.ndim(x) == 0 else np.asarray(x)[self.order]

    def random(self, shape: tuple[int, ...], dtype: Any = float) -> np.ndarray:
        """What the next windows of the order get."""
        part, self.calls = self.calls % len(self.parts), self.calls + 1
        if part == 0:
            self.rows = self.order[self.at:self.at + shape[0]]
            self.at += shape[0]
        given = self.parts[part]
        return np.ones(shape) if given is None else given[self.rows]

    def integers(self, high: int, size: tuple[int, ...], dtype: Any = int) -> np.ndarray:
        """The same."""
        return self.random(size)

    def uniform(self, low: float, high: float, size: tuple[int, ...]) -> np.ndarray:
        """The next of the numbers, between these ends."""
        count, begin = int(np.prod(size)), self.at
        self.at += count
        return (low + (high - low) * self.numbers[begin:begin + count]).reshape(size)


def draws_of(order: np.ndarray, *parts: Any) -> Callable[[Any], Dealt]:
    """Makes what is dealt in an epoch, whose number (from 1) comes last in what it is asked by.

    order : (epochs, N);  parts : by epoch
    """
    return lambda seeds: Dealt(order[seeds[-1] - 1], *(
        None if part is None else part[seeds[-1] - 1] for part in parts))


def trained(epochs: Iterable[Any], dtype: Any) -> tuple[np.ndarray, ...]:
    """The parameters after a training of (Record, State), and what each epoch's loss was."""
    met = []
    for record, state in epochs:
        met.append(record.losses["loss"])
    return (*state.params.values(), np.array(met, dtype=dtype))


def said(**options: Any) -> dict[str, Any]:
    """The options that are not None, so that the reference's own defaults stand for the others.

    >>> said(length=3, step=None)
    {'length': 3}
    """
    return {name: value for name, value in options.items() if value is not None}
