"""The cases of the kit: every operation with every sample, forwards and backwards, in both
precisions, in odd layouts, and what must be refused."""

from collections.abc import Iterable
from dataclasses import dataclass, field
import functools
from typing import Any
import zlib

import numpy as np

from ..gradcheck.contract import LAYOUTS
from . import operations_2016, operations_holden, operations_nn, operations_torresani
from .backend import as_backend, ask, meant
from ..gradcheck.difference import relative_difference
from .specification import Operation, as_tuple, cast

OPERATIONS = {operation.name: operation for operation in (
    operations_nn.OPERATIONS + operations_holden.OPERATIONS + operations_2016.OPERATIONS
    + operations_torresani.OPERATIONS)}
PROMISES = ("leaves its inputs alone", "same bits twice", "memory of its own",
            "linear in the upstream gradient")


@dataclass(frozen=True)
class Case:
    """One call of one function of a backend and what must come of it.

    id : operation/sample/what/kind;  function : the backend's name for it;  kind : "float64",
    "float32", a layout, a promise, "empty batch" or "refused"
    arguments, attributes : the inputs, which are never handed out: `fresh` makes copies
    expected : outputs of the reference (in float64), None for a call that must be refused
    exact : a rule decides, nothing is rounded;  slack : for each output, how much of its largest
    element it moves when the inputs move by float32's last digit, where terms cancel
    others : ((arguments, attributes), ...) of other valid calls, to be asked in between
    factors : on the tolerance of each output;  seed : of the inputs;  folder : of the golden
    vectors that it was read from, if it was
    """

    id: str
    operation: Operation
    function: str
    kind: str
    arguments: tuple = field(repr=False)
    attributes: dict = field(repr=False)
    expected: tuple | None = field(repr=False, default=None)
    exact: bool = False
    slack: tuple = ()
    argument: str = ""
    others: tuple = field(repr=False, default=())
    seed: int = 0
    folder: str = ""
    single: bool = False
    factors: tuple = ()

    def __str__(self) -> str:
        return self.id

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the arguments, the upstream gradient first in a backward."""
        upstream = ("upstream gradient",) if self.function.endswith("_backward") else ()
        return upstream + self.operation.arguments

    @property
    def precision(self) -> str:
        return "float32" if self.kind == "float32" or self.single else "float64"

    @property
    def allowances(self) -> tuple[float, ...]:
        """The factor on the tolerance for every output."""
        count = len(self.expected or ())
        return tuple(self.operation.tolerance * f for f in self.factors or (1.0,) * count)

    @property
    def slacks(self) -> tuple[float, ...]:
        """The slack of every output, 0 where none was measured."""
        return self.slack or (0.0,) * len(self.expected or ())

    def fresh(self) -> tuple[tuple, dict]:
        """Copies of the arguments and attributes, laid out in memory as the case's kind says."""
        lay = LAYOUTS.get(self.kind)

        def copy(value: Any) -> Any:
            if not isinstance(value, np.ndarray):
                return value
            value = value.copy()
            return lay(value) if lay and value.ndim and value.dtype.kind == "f" else value
        return (tuple(map(copy, self.arguments)),
                {key: value.copy() if isinstance(value, np.ndarray) else value
                 for key, value in self.attributes.items()})

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


def _of_operation(operation, seed):
    rng = generator(operation, seed)
    found = []
    for number, sample in enumerate(operation.samples(rng)):
        found += _values(operation, sample, rng, seed)
        if number == 0:
            found += (_layouts(operation, sample, rng, seed)
                      + _promises(operation, sample, rng, seed)
                      + _empty_batch(operation, sample, seed))
    return found + [Case(f"{operation.name}/{bad.label}/forward/refused", operation, operation.name,
                         "refused", bad.inputs, bad.attributes, argument=bad.argument, seed=seed)
                    for bad in operation.bad()]


def _calls(operation, sample, rng):
    """(what, function name, reference, arguments, known answer) of the forward and the backward
    call."""
    known = sample.known or {}
    outputs = known.get("outputs") if operation.backward else None
    yield "forward", operation.name, operation.f, sample.inputs, outputs
    if operation.backward and (sample.smooth or known):
        upstream = known["upstream"] if known else rng.standard_normal(
            np.shape(operation.f(*sample.inputs, **sample.attributes)))
        yield ("backward", f"{operation.name}_backward", operation.backward,
               (np.asarray(upstream), *sample.inputs), known.get("gradients"))


def _values(operation, sample, rng, seed):
    found = []
    for what, name, reference, arguments, known in _calls(operation, sample, rng):
        expected = known or as_tuple(reference(*arguments, **sample.attributes))
        found.append(Case(f"{operation.name}/{sample.label}/{what}/float64", operation, name,
                          "float64", arguments, sample.attributes, expected,
                          exact=not sample.smooth, factors=sample.factors, seed=seed))
        if sample.smooth and "float32" in operation.precisions:
            small = cast(arguments, np.float32)
            attributes = _cast_attributes(sample.attributes, np.float32)
            wide = as_tuple(reference(*cast(small, np.float64),
                                      **_cast_attributes(attributes, np.float64)))
            found.append(Case(f"{operation.name}/{sample.label}/{what}/float32", operation, name,
                              "float32", small, attributes, wide,
                              slack=_slack(reference, small, attributes, wide), seed=seed))
    return found


def _slack(reference, arguments, attributes, wanted):
    """How far the reference itself moves when every input moves by its last digit in float32: an
    answer cannot be surer than that.

    ->  for each output the largest of four random moves, tenfold, in units of its largest element
    """
    moves = []
    eps = np.finfo(np.float32).eps
    for number in range(4):
        rng = np.random.default_rng(number)

        def moved(values: tuple) -> tuple:
            return tuple(v * (1 + eps * rng.choice([-1.0, 1.0], v.shape))
                         if isinstance(v, np.ndarray) and v.dtype.kind == "f" else v
                         for v in cast(values, np.float64))
        outputs = as_tuple(reference(*moved(arguments),
                                     **dict(zip(attributes, moved(tuple(attributes.values()))))))
        moves.append([0.0 if w is None else float(relative_difference(o, w).max(initial=0.0))
                      for o, w in zip(outputs, wanted)])
    return tuple(10 * max(column) for column in zip(*moves))


def _cast_attributes(attributes, dtype):
    return dict(zip(attributes, cast(tuple(attributes.values()), dtype)))


def _layouts(operation, sample, rng, seed):
    found = []
    for what, name, reference, arguments, _ in _calls(operation, sample, rng):
        expected = as_tuple(reference(*arguments, **sample.attributes))
        found += [Case(f"{operation.name}/{sample.label}/{what}/{layout}", operation, name, layout,
                       arguments, sample.attributes, expected, factors=sample.factors, seed=seed)
                  for layout in LAYOUTS]
    return found


def _promises(operation, sample, rng, seed):
    found = []
    others = _other_calls(operation, seed)
    for what, name, reference, arguments, _ in _calls(operation, sample, rng):
        for promise in PROMISES[:2] if what == "forward" else PROMISES:
            found.append(Case(f"{operation.name}/{sample.label}/{what}/{promise}", operation, name,
                              promise, arguments, sample.attributes,
                              as_tuple(reference(*arguments, **sample.attributes)),
                              others=others[what], seed=seed))
    return found


def _other_calls(operation, seed):
    """Valid calls with other numbers: of the first sample's shapes, and of the second's.

    ->  {"forward" or "backward": ((arguments, attributes), ...)}
    """
    rng = generator(operation, seed + 1)
    found: dict = {"forward": (), "backward": ()}
    for sample in operation.samples(rng)[:2]:
        for what, _, _, arguments, _ in _calls(operation, sample, rng):
            found[what] += ((arguments, sample.attributes),)
    return found


def _empty_batch(operation, sample, seed):
    if not operation.batched:
        return []
    empty = tuple(a[:0] if i in operation.batched else a for i, a in enumerate(sample.inputs))
    found = [("forward", operation.name, operation.f, empty)]
    if operation.backward:
        upstream = np.zeros(np.shape(operation.f(*empty, **sample.attributes)))
        found.append(("backward", f"{operation.name}_backward", operation.backward,
                      (upstream, *empty)))
    return [Case(f"{operation.name}/{sample.label}/{what}/empty batch", operation, name,
                 "empty batch", arguments, sample.attributes,
                 as_tuple(reference(*arguments, **sample.attributes)), seed=seed)
            for what, name, reference, arguments in found]
