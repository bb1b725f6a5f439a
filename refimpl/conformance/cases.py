"""The cases of the kit: every operation with every sample, forwards and backwards, in both
precisions, in odd layouts, and what must be refused."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
import functools
from typing import Any
import zlib

import numpy as np

from ..gradcheck.contract import LAYOUTS, copies
from ..gradcheck.difference import relative_difference
from .backend import OPERATIONS, TOLERANCES, as_backend, ask, meant
from .specification import Operation, Sample, as_tuple, cast, cast_attributes

EXACT = 1e-15                                         # where a rule decides and nothing is rounded
PROMISES = ("leaves its inputs alone", "same bits twice", "memory of its own",
            "linear in the upstream gradient")


@dataclass(frozen=True)
class Case:
    """One call of one function of a backend and what must come of it.

    id : operation/sample/what/kind;  function : the backend's name for it;  kind : "float64",
    "float32", a layout, a promise, "empty batch" or "refused"
    arguments, attributes : the inputs, which are never handed out: `fresh` makes copies
    expected : outputs of the reference (in float64), None for a call that must be refused
    exact : a rule decides, nothing is rounded;  sensitivity : for each output, how much of its
    largest element it moves when the inputs move by float32's last digit, where terms cancel
    others : ((arguments, attributes), ...) of other valid calls, to be asked in between
    factors : on the tolerance of each output;  seed : of the inputs;  folder : of the golden
    vectors that it was read from, if it was
    """

    id: str
    operation: Operation
    function: str
    kind: str
    arguments: tuple = field(repr=False)
    attributes: dict[str, Any] = field(repr=False)
    expected: tuple | None = field(repr=False, default=None)
    exact: bool = False
    sensitivity: tuple[float, ...] = ()
    argument: str = ""
    others: tuple = field(repr=False, default=())
    seed: int = 0
    folder: str = ""
    single: bool = False
    factors: tuple[float, ...] = ()

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
        return "float32" if self.kind == "float32" or self.single else "float64"

    def bounds(self, tolerances: Mapping[str, float] = TOLERANCES) -> tuple[float, ...]:
        """How far each output may be off, in units of its largest element.

        tolerances : {precision: bound}, the kit's own unless a backend declares others
        """
        count = len(self.expected or ())
        if self.exact:
            return (EXACT,) * count
        pairs = zip(self.factors or (1.0,) * count, self.sensitivity or (0.0,) * count)
        return tuple(tolerances[self.precision] * (self.operation.tolerance * factor) + sensitivity
                     for factor, sensitivity in pairs)

    def fresh(self, writeable: bool = True) -> tuple[tuple, dict[str, Any]]:
        """Copies of the arguments and attributes, laid out in memory as the case's kind says."""
        layout = self.kind if self.kind in LAYOUTS else ""
        attributes = copies(self.attributes.values(), writeable=writeable)
        return (tuple(copies(self.arguments, layout, writeable)),
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


def cases(*, seed: int = 0, operations: Iterable[str] | None = None,
          supported_by: Any = None) -> list[Case]:
    """All cases, the same for the same seed.

    operations : names to limit them to;  supported_by : a backend whose functions limit them
    ->  list of Case.   Raises ValueError for an unknown operation.

        @pytest.mark.parametrize("case", conformance.cases(supported_by=MINE), ids=str)
        def test_conformance(case):
            case.check(MINE)

    >>> [str(c) for c in cases(operations=["gram"]) if c.kind == "refused"]
    ['gram/two dimensions/forward/refused']
    """
    names = list(OPERATIONS) if operations is None else list(operations)
    for name in names:
        if name not in OPERATIONS:
            raise ValueError(f"operations: found {name!r}, needed some of {', '.join(OPERATIONS)}"
                             + meant(name, OPERATIONS))
    found = [case for name in names for case in _of_operation(OPERATIONS[name], seed)]
    if supported_by is not None:
        functions = as_backend(supported_by).functions
        found = [case for case in found if case.function in functions]
    return found


@functools.lru_cache(maxsize=4)
def _by_id(seed):
    return {case.id: case for case in cases(seed=seed)}


def case(identity: str, *, seed: int = 0) -> Case:
    """The case with this id, to look at a failure.

    ->  Case.   Raises ValueError for an unknown id.
    """
    if identity not in _by_id(seed):
        raise ValueError(f"case: found no {identity!r}, needed an id as `refimpl check` prints it")
    return _by_id(seed)[identity]


def generator(operation: Operation, seed: int) -> np.random.Generator:
    """The random numbers of an operation depend on the seed and its name alone, so that a new
    operation changes no other's cases."""
    return np.random.default_rng([seed, zlib.crc32(operation.name.encode())])


def _of_operation(operation: Operation, seed: int) -> Iterator[Case]:
    rng = generator(operation, seed)
    for number, sample in enumerate(operation.samples(rng)):
        yield from _values(operation, sample, rng, seed)
        if number == 0:
            yield from _layouts(operation, sample, rng, seed)
            yield from _promises(operation, sample, rng, seed)
            if operation.batched:
                yield from _empty_batch(operation, sample, rng, seed)
    for bad in operation.bad():
        yield Case(f"{operation.name}/{bad.label}/forward/refused", operation, operation.name,
                   "refused", bad.inputs, bad.attributes, argument=bad.argument, seed=seed)


def _calls(operation, sample, rng, seed):
    """The forward and the backward call of a sample.

    ->  yields Case without a kind, reference, known answer or None
    """
    known = sample.known or {}
    call = Case(f"{operation.name}/{sample.label}/forward", operation, operation.name, "",
                sample.inputs, sample.attributes, seed=seed)
    yield call, operation.f, known.get("outputs") if operation.backward else None
    if operation.backward and (sample.smooth or known):
        upstream = known["upstream"] if known else rng.standard_normal(
            np.shape(operation.f(*sample.inputs, **sample.attributes)))
        yield (replace(call, id=f"{operation.name}/{sample.label}/backward",
                       function=f"{operation.name}_backward",
                       arguments=(np.asarray(upstream), *sample.inputs)),
               operation.backward, known.get("gradients"))


def _of_kind(call, kind, expected, **changes):
    return replace(call, id=f"{call.id}/{kind}", kind=kind, expected=expected, **changes)


def _answer(reference, call):
    """The reference's outputs in float64."""
    return as_tuple(reference(*cast(call.arguments, np.float64),
                              **cast_attributes(call.attributes, np.float64)))


def _values(operation, sample, rng, seed):
    for call, reference, known in _calls(operation, sample, rng, seed):
        yield _of_kind(call, "float64", known or _answer(reference, call),
                       exact=not sample.smooth, factors=sample.factors)
        if sample.smooth and "float32" in operation.precisions:
            call = replace(call, arguments=cast(call.arguments, np.float32),
                           attributes=cast_attributes(call.attributes, np.float32))
            expected = _answer(reference, call)
            yield _of_kind(call, "float32", expected,
                           sensitivity=_sensitivity(reference, call, expected))


def _sensitivity(reference, call, expected):
    """How far the reference itself moves when every input moves by its last digit in float32: an
    answer cannot be surer than that.

    ->  for each output the largest of four random moves, tenfold, in units of its largest element
    """
    moves, eps = [], np.finfo(np.float32).eps
    for number in range(4):
        rng = np.random.default_rng(number)

        def _moved(values):
            return tuple(v * (1 + eps * rng.choice([-1.0, 1.0], v.shape))
                         if isinstance(v, np.ndarray) and v.dtype.kind == "f" else v
                         for v in cast(values, np.float64))
        arguments, attributes = _moved(call.arguments), _moved(call.attributes.values())
        outputs = as_tuple(reference(*arguments, **dict(zip(call.attributes, attributes))))
        moves.append([0.0 if e is None else float(relative_difference(o, e).max(initial=0.0))
                      for o, e in zip(outputs, expected)])
    return tuple(10 * max(column) for column in zip(*moves))


def _layouts(operation, sample, rng, seed):
    for call, reference, _ in _calls(operation, sample, rng, seed):
        expected = _answer(reference, call)
        for layout in LAYOUTS:
            yield _of_kind(call, layout, expected, factors=sample.factors)


def _promises(operation, sample, rng, seed):
    others = _other_calls(operation, seed)
    for call, reference, _ in _calls(operation, sample, rng, seed):
        expected = _answer(reference, call)
        for promise in PROMISES[:2] if call.function == operation.name else PROMISES:
            yield _of_kind(call, promise, expected, others=others[call.function])


def _other_calls(operation, seed):
    """Valid calls with other numbers: of the first sample's shapes, and of the second's.

    ->  {function: ((arguments, attributes), ...)}
    """
    rng = generator(operation, seed + 1)
    found: dict[str, tuple] = {}
    for sample in operation.samples(rng)[:2]:
        for call, _, _ in _calls(operation, sample, rng, seed):
            there = found.get(call.function, ())
            found[call.function] = (*there, (call.arguments, call.attributes))
    return found


def _empty_batch(operation, sample, rng, seed):
    empty = tuple(a[:0] if i in operation.batched else a for i, a in enumerate(sample.inputs))
    upstream = np.zeros(np.shape(operation.f(*empty, **sample.attributes)))
    sample = Sample(sample.label, empty, sample.attributes, known={"upstream": upstream})
    for call, reference, _ in _calls(operation, sample, rng, seed):
        yield _of_kind(call, "empty batch", _answer(reference, call))
