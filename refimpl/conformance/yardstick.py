r"""How near is near? What each element of an answer sums, as the measure of its rounding.

An element y = sum_i t_i of many terms is rounded by about a last digit of S = sum_i |t_i|, whatever
the sum itself comes to. S is not asked of the operation: it is measured. Let every input move by a
tiny share delta c_i of itself, where the c_i are drawn from Cauchy's distribution. Then

    y' - y = delta sum_i c_i t_i      is Cauchy's again, with the scale delta S,

so that the median of |y' - y| / delta over a few draws is S. (Normal numbers would give the root of
the summed squares, which forgets how many terms there are.)
"""

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from ..gradcheck.difference import largest
from ..gradcheck.structure import is_float
from .specification import as_tuple, cast

FAR_MOVES = 12                                  # of numbers that have fewer digits
MOVES, SHARE, FARTHEST = 5, 1e-11, 1e5         # draws; delta; of the distribution, the tails' end


class Yardstick:
    """Sizes for the outputs of one call: S, and at least the elements themselves; the largest of a
    clip and channel (the last axis of an output, the elements of a vector alone).

    reference, arguments, attributes : the call, in float64;  expected : its outputs
    whole : one size for a whole output, its largest element: for searches, and where a tie or a
    kink lies so near that the answer jumps;  firm : the elements themselves are the measure
    """

    def __init__(self, reference: Callable, arguments: tuple, attributes: Mapping[str, Any],
                 expected: tuple, whole: bool = False, firm: bool = False) -> None:
        self._call = reference, arguments, attributes
        self._expected, self._whole, self._firm = expected, whole, firm
        self._digit = 0.0

    def coarse(self, digit: float) -> "Yardstick":
        """The same call measured for numbers that have fewer digits: how far the answer goes, ties
        and kinks included, when each input moves by up to half of their last one."""
        found = Yardstick(*self._call, self._expected)
        found._digit = digit
        return found

    def again(self, arguments: tuple, attributes: Mapping[str, Any],
              expected: tuple) -> "Yardstick":
        """The same for another call of the function."""
        found = Yardstick(self._call[0], arguments, attributes, expected, self._whole, self._firm)
        found._digit = self._digit
        return found

    @cached_property
    def least(self) -> tuple[np.ndarray | float | None, ...]:
        """What the sizes come to at least, the answer's own: nothing has to be measured for it."""
        if self._whole:
            return tuple(None if y is None else largest(y) for y in self._expected)
        return tuple(None if y is None else of_rows(np.where(
            np.isfinite(y), np.abs(y).astype(float), 0.0)) for y in self._expected)

    @cached_property
    def sizes(self) -> tuple[np.ndarray | float | None, ...]:
        """For each output an array that broadcasts to it (None for one that is None)."""
        if self._whole or self._firm:
            return self.least
        moved = self._moved_far() if self._digit else self._moved()
        return tuple(None if own is None else np.maximum(own, of_rows(np.asarray(size)))
                     for own, size in zip(self.least, moved))

    @np.errstate(all="ignore")
    def _outputs(self, times, draw):
        """The reference's outputs, each time with every input moved by a share that `draw` makes of
        its shape."""
        reference, arguments, attributes = self._call
        for _ in range(times):
            moved = [v * (1 + draw(v.shape)) if is_float(v)
                     else v for v in cast((*arguments, *attributes.values()), np.float64)]
            yield as_tuple(reference(*moved[:len(arguments)],
                                     **dict(zip(attributes, moved[len(arguments):]))))

    @np.errstate(all="ignore")
    def _moved_far(self):
        rng = np.random.default_rng(0)
        most: list[Any] = [0.0] * len(self._expected)
        for outputs in self._outputs(FAR_MOVES, lambda shape: self._digit * rng.uniform(
                -0.5, 0.5, shape)):
            most = [None if y is None else np.maximum(far, np.abs(z - y) / self._digit)
                    for far, y, z in zip(most, self._expected, outputs)]
        return most

    @np.errstate(all="ignore")
    def _moved(self):
        rng = np.random.default_rng(0)
        found = [[0.0 if y is None else np.where(
            np.isfinite(y) & np.isfinite(z), np.abs(z - y), 0.0) / SHARE
            for y, z in zip(self._expected, outputs)]
            for outputs in self._outputs(MOVES, lambda shape: SHARE * np.clip(
                rng.standard_cauchy(shape), -FARTHEST, FARTHEST))]
        return [np.median(np.stack(column), axis=0) if np.ndim(column[0]) else
                float(np.median(column)) for column in zip(*found)]


def of_rows(sizes: np.ndarray) -> np.ndarray:
    """The largest along the last axis; the elements of a vector themselves.

    >>> of_rows(np.array([[1.0, 3.0], [2.0, 0.0]])).tolist()
    [[3.0], [2.0]]
    """
    if sizes.ndim < 2 or not sizes.size:
        return sizes
    return sizes.max(axis=-1, keepdims=True)
