"""The cases of the kit: every operation with every sample, forwards and backwards, in both precisions, in odd layouts, and what must be refused."""

from dataclasses import dataclass, field
import functools
import zlib

import numpy as np

from ..nn.contract import LAYOUTS
from . import operations_holden, operations_nn, operations_torresani
from .record import as_tuple, cast, relative_difference

OPERATIONS = {operation.name: operation for operation in operations_nn.OPERATIONS + operations_holden.OPERATIONS + operations_torresani.OPERATIONS}
PROMISES = ("leaves its inputs alone", "same bits twice", "memory of its own", "linear in the upstream gradient")


@dataclass(frozen=True)
class Case:
    """One call of one function of a backend and what must come of it.

    id : operation/sample/what/kind;  function : the backend's name for it;  kind : "float64", "float32", a layout, a promise, "empty batch" or
    "refused";  expected : outputs of the reference (in float64), None for a call that must be refused;  exact : a rule decides, nothing is rounded;
    slack : for each output, how much of its largest element it moves when the inputs move by float32's last digit, where terms cancel.
    """

    id: str
    operation: object
    function: str
    kind: str
    arguments: tuple = field(repr=False)
    attributes: dict = field(repr=False)
    expected: tuple = field(repr=False, default=None)
    exact: bool = False
    slack: tuple = ()
    argument: str = ""

    def __str__(self):
        return self.id

    @property
    def names(self):
        """Names of the arguments, the upstream gradient first in a backward."""
        upstream = ("upstream gradient",) if self.function.endswith("_backward") else ()
        return upstream + self.operation.arguments

    @property
    def precision(self):
        return "float32" if self.kind == "float32" else "float64"

    def call(self, backend):
        """Outputs of the backend's function as a tuple of arrays (None where there is none)."""
        function = backend.functions[self.function] if hasattr(backend, "functions") else backend[self.function]
        return as_tuple(function(*self.arguments, **self.attributes))

    def check(self, backend):
        """For a test of one's own: raises AssertionError with the worst element, the rival it follows and how to see it again."""
        from .judge import judge
        outcome = judge(self, backend)
        if outcome.status == "failed":
            raise AssertionError(outcome.message)


def cases(*, seed=0, operations=None, supported_by=None):
    """All cases, the same for the same seed.

    operations : names to limit them to;  supported_by : a backend whose functions limit them   ->  list of Case

        @pytest.mark.parametrize("case", conformance.cases(supported_by=MINE), ids=str)
        def test_conformance(case):
            case.check(MINE)
    """
    names = list(OPERATIONS) if operations is None else list(operations)
    unknown = [name for name in names if name not in OPERATIONS]
    if unknown:
        raise ValueError(f"operations: found {', '.join(unknown)}, needed some of {', '.join(OPERATIONS)}")
    found = [case for name in names for case in _of_operation(OPERATIONS[name], seed)]
    if supported_by is not None:
        functions = getattr(supported_by, "functions", supported_by)
        found = [case for case in found if case.function in functions]
    return found


@functools.lru_cache(maxsize=4)
def _by_id(seed):
    return {case.id: case for case in cases(seed=seed)}


def case(identity, *, seed=0):
    """The case with this id, to look at a failure.   ->  Case"""
    if identity not in _by_id(seed):
        raise ValueError(f"case: found no {identity!r}, needed an id as `refimpl check` prints it")
    return _by_id(seed)[identity]


def generator(operation, seed):
    """The random numbers of an operation depend on the seed and its name alone, so that a new operation changes no other's cases."""
    return np.random.default_rng([seed, zlib.crc32(operation.name.encode())])


def _of_operation(operation, seed):
    rng = generator(operation, seed)
    found = []
    for number, sample in enumerate(operation.samples(rng)):
        found += _values(operation, sample, rng)
        if number == 0:
            found += _layouts(operation, sample, rng) + _promises(operation, sample, rng) + _empty_batch(operation, sample)
    return found + [Case(f"{operation.name}/{bad.label}/forward/refused", operation, operation.name, "refused", bad.inputs, bad.attributes,
                         argument=bad.argument) for bad in operation.bad()]


def _calls(operation, sample, rng):
    """(what, function name, reference, arguments, known answer) of the forward and the backward call."""
    known = sample.known or {}
    yield "forward", operation.name, operation.f, sample.inputs, known.get("outputs") if operation.backward else None
    if operation.backward and (sample.smooth or known):
        upstream = known["upstream"] if known else rng.standard_normal(np.shape(operation.f(*sample.inputs, **sample.attributes)))
        yield "backward", f"{operation.name}_backward", operation.backward, (np.asarray(upstream), *sample.inputs), known.get("gradients")


def _values(operation, sample, rng):
    found = []
    for what, name, reference, arguments, known in _calls(operation, sample, rng):
        expected = known or as_tuple(reference(*arguments, **sample.attributes))
        found.append(Case(f"{operation.name}/{sample.label}/{what}/float64", operation, name, "float64", arguments, sample.attributes, expected,
                          exact=not sample.smooth))
        if sample.smooth and "float32" in operation.precisions:
            small, attributes = cast(arguments, np.float32), _cast_attributes(sample.attributes, np.float32)
            wide = as_tuple(reference(*cast(small, np.float64), **_cast_attributes(attributes, np.float64)))
            found.append(Case(f"{operation.name}/{sample.label}/{what}/float32", operation, name, "float32", small, attributes, wide,
                              slack=_slack(reference, small, attributes, wide)))
    return found


def _slack(reference, arguments, attributes, wanted):
    """How far the reference itself moves when every input moves by its last digit in float32: an answer cannot be surer than that.

    ->  for each output the largest of four random moves, tenfold, in units of its largest element
    """
    moves = []
    for number in range(4):
        rng = np.random.default_rng(number)

        def moved(values):
            return tuple(v * (1 + np.finfo(np.float32).eps * rng.choice([-1.0, 1.0], v.shape)) if isinstance(v, np.ndarray) and v.dtype.kind == "f" else v
                         for v in cast(values, np.float64))
        outputs = as_tuple(reference(*moved(arguments), **dict(zip(attributes, moved(tuple(attributes.values()))))))
        moves.append([0.0 if w is None else float(relative_difference(o, w).max(initial=0.0)) for o, w in zip(outputs, wanted)])
    return tuple(10 * max(column) for column in zip(*moves))


def _cast_attributes(attributes, dtype):
    return dict(zip(attributes, cast(tuple(attributes.values()), dtype)))


def _layouts(operation, sample, rng):
    found = []
    for what, name, reference, arguments, _ in _calls(operation, sample, rng):
        expected = as_tuple(reference(*arguments, **sample.attributes))
        for layout, lay in LAYOUTS.items():
            laid = tuple(lay(a) if isinstance(a, np.ndarray) and a.ndim and a.dtype.kind == "f" else a for a in arguments)
            found.append(Case(f"{operation.name}/{sample.label}/{what}/{layout}", operation, name, layout, laid, sample.attributes, expected))
    return found


def _promises(operation, sample, rng):
    found = []
    for what, name, reference, arguments, _ in _calls(operation, sample, rng):
        for promise in PROMISES[:2] if what == "forward" else PROMISES:
            found.append(Case(f"{operation.name}/{sample.label}/{what}/{promise}", operation, name, promise, arguments, sample.attributes,
                              as_tuple(reference(*arguments, **sample.attributes))))
    return found


def _empty_batch(operation, sample):
    if not operation.batched:
        return []
    empty = tuple(a[:0] if i in operation.batched else a for i, a in enumerate(sample.inputs))
    found = [("forward", operation.name, operation.f, empty)]
    if operation.backward:
        upstream = np.zeros(np.shape(operation.f(*empty, **sample.attributes)))
        found.append(("backward", f"{operation.name}_backward", operation.backward, (upstream, *empty)))
    return [Case(f"{operation.name}/{sample.label}/{what}/empty batch", operation, name, "empty batch", arguments, sample.attributes,
                 as_tuple(reference(*arguments, **sample.attributes))) for what, name, reference, arguments in found]
