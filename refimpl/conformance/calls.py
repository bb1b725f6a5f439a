"""One call of one function of a backend, and what must come of it."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..gradcheck.contract import copies
from ..gradcheck.difference import largest
from .backend import TOLERANCES, as_backend, ask
from .specification import Operation, as_tuple, cast, cast_attributes
from .yardstick import Yardstick, of_rows

LEAST = 1e-9              # of an output's largest element, what an element is taken to sum
OF_FILTERS = 1e-2                                      # the same for the gradient of a filter
COARSE = 4.0                        # last digits that an element may be off where there are few
EXACT = 1e-15                                         # where a rule decides and nothing is rounded


@dataclass(frozen=True)
class Case:
    """One call of one function of a backend and what must come of it.

    id : operation/sample/what/kind;  function : the backend's name for it;  kind : "float64",
    "float32", a layout, a promise, NaN or a range, "empty batch" or "refused"
    arguments, attributes : the inputs, which are never handed out: `fresh` makes copies
    expected : outputs of the reference (in float64), None for a call that must be refused
    exact : nothing is rounded;  yardstick : what the outputs' elements sum
    allowed : for each output, in units of its largest element, instead of a yardstick
    layout, only : how the floating-point arguments lie in memory, and which one alone
    others : ((arguments, attributes), ...) of other valid calls, to be asked in between
    factors : on the tolerance of each output;  single : in float32;  seed : of the inputs
    digits : the last digit of what a profile lets be multiplied, 0 for the precision's own
    free : for each output where NaN is as good as the expected number
    folder : of the golden vectors that it was read from, if it was
    """

    id: str
    operation: Operation
    function: str
    kind: str
    arguments: tuple = field(repr=False)
    attributes: dict[str, Any] = field(repr=False)
    expected: tuple | None = field(repr=False, default=None)
    exact: bool = False
    yardstick: Yardstick | None = field(repr=False, default=None)
    allowed: tuple[float, ...] = ()
    argument: str = ""
    layout: str = ""
    only: int | None = None
    others: tuple = field(repr=False, default=())
    seed: int = 0
    folder: str = ""
    single: bool = False
    factors: tuple[float, ...] = ()
    digits: float = 0.0
    free: tuple = field(repr=False, default=())

    def __str__(self) -> str:
        return self.id

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the arguments, the upstream gradient first in a backward."""
        upstream = ("upstream gradient",) if self.function.endswith("_backward") else ()
        return upstream + self.operation.arguments

    @property
    def precision(self) -> str:
        """The precision of the inputs, which the outputs must have."""
        return "float32" if self.single else "float64"

    def allowances(self, tolerances: Mapping[str, float] = TOLERANCES,
                   measured: bool = True) -> tuple[Any, ...]:
        """How far each element of each output may be off (None for an output that is None): the
        tolerance times what the elements of its clip and channel sum.

        tolerances : {precision: bound}, the kit's own unless a backend declares others
        measured : False for the least that it comes to, which costs nothing
        """
        expected = self.expected or ()
        if self.exact:
            exact = max(EXACT, EXACT / np.finfo(float).eps * np.finfo(self.precision).eps)
            return tuple(None if y is None else exact * of_rows(
                np.where(np.isfinite(y), np.abs(y), 0.0)) for y in map(_array, expected))
        tolerance = max(tolerances[self.precision], COARSE * self.digits)
        if self.allowed:
            own = TOLERANCES[self.precision]
            return tuple(None if y is None else bound * max(tolerance / own, 1.0)
                         * (largest(y) or 1.0) for y, bound in zip(expected, self.allowed))
        yardstick = self.yardstick
        sizes = (yardstick.sizes if yardstick and measured else yardstick.least if yardstick
                 else tuple(None if y is None else largest(y) or 1.0 for y in expected))
        factors = self.factors or (1.0,) * len(expected)
        least = 4.0 * float(np.finfo(self.precision).smallest_subnormal)
        return tuple(None if size is None else least + tolerance * self.operation.tolerance * factor
                     * np.maximum(size, self._least(number) * largest(y))
                     for number, (size, factor, y) in enumerate(zip(sizes, factors, expected)))

    def _least(self, output):
        """Filters are for all clips together, and a transform may sum over all of them at once; one
        number for each clip is that clip's alone."""
        names = self.operation.arguments
        if self.operation.whole_range and self.function == self.operation.name and (
                np.ndim((self.expected or (0.0,))[output]) == 1):
            return 0.0
        of_filters = (self.function.endswith("_backward") and output < len(names)
                      and names[output].lower().startswith("w"))
        return OF_FILTERS if of_filters else LEAST

    def fresh(self, writeable: bool = True) -> tuple[tuple, dict[str, Any]]:
        """Copies of the arguments and attributes, laid out in memory as the case says."""
        attributes = copies(self.attributes.values(), writeable=writeable)
        return (tuple(copies(self.arguments, self.layout, writeable, self.only)),
                dict(zip(self.attributes, attributes)))

    def call(self, backend: Any) -> tuple:
        """Outputs of the backend's function as a tuple of arrays (None where there is none)."""
        arguments, attributes = self.fresh()
        return ask(as_backend(backend).functions[self.function], arguments, attributes)

    def check(self, backend: Any) -> None:
        """For a test of one's own: raises AssertionError with the worst element, the convention it
        follows instead and how to see it again."""
        from .judge import judge
        outcome = judge(self, backend)
        if outcome.status == "failed":
            raise AssertionError(outcome.message)


@np.errstate(all="ignore")
def _answer(reference, call):
    """The reference's outputs in float64."""
    return as_tuple(reference(*cast(call.arguments, np.float64),
                              **cast_attributes(call.attributes, np.float64)))


def answered(call: Case, reference: Callable, kind: str, *, whole: bool = False,
             firm: bool = False, **changes: Any) -> Case:
    """The call as a case of a kind, with the reference's answer and what its elements sum."""
    expected = _answer(reference, call)
    grows = call.operation.grows
    whole = whole or (call.operation.backward is None and not grows)
    sizes = Yardstick(reference, call.arguments, call.attributes, expected, whole, firm)
    return replace(call, id=f"{call.id}/{kind}", kind=kind, expected=expected, **{
        "yardstick": sizes.coarse(float(np.finfo(call.precision).eps)) if grows else sizes,
        **changes})


def in_single(call: Case) -> Case:
    """The call in float32."""
    return replace(call, arguments=cast(call.arguments, np.float32), single=True,
                   attributes=cast_attributes(call.attributes, np.float32))


def precisions(call: Case, thorough: bool = True) -> Iterator[tuple[Case, str]]:
    """The call in each precision that its operation is tried in, and what a kind's name gets."""
    yield call, ""
    if thorough and "float32" in call.operation.precisions:
        yield in_single(call), ", float32"


def _array(y):
    return None if y is None else np.asarray(y)
