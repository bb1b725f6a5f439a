"""The reference against itself would tell nothing. Here it is held against a second derivation and
against instruments that know no derivation:

- values: the fast form against `definitions`, which spell the formula out element by element;
- gradients: the hand-written backward against the complex step or Richardson differences *of the
  definition*;
- contract: what every backward must keep;
- rules: kinks, ties and NaN against answers worked by hand; refused inputs against the argument
  that must be named.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..gradcheck import GradientError, check_contract, check_gradient
from ..gradcheck.difference import relative_difference
from .backend import OPERATIONS, TOLERANCES, reference
from .cases import cases, generator
from .judge import judge_all
from .report import row
from .specification import Operation, as_tuple

VALUES = 1e-12                                                   # relative to the largest element
# bounds that each term of a sum has to come to in each sample
WEIGHS = 100.0
ELEMENTS = 8                   # of a gradient; of a larger one a sample, and all of it along a line


@dataclass(frozen=True)
class Verification:
    """One operation's verdict: how many checks of each kind were made, the largest difference of
    its values, what failed, and a row for each check (`report.row`'s keys)."""

    operation: str
    values: int
    gradients: int
    contracts: int
    cases: int
    difference: float
    failures: tuple[str, ...]
    rows: tuple[dict[str, Any], ...] = ()


def verify(*, seed: int = 0, operations: Iterable[str] | None = None) -> Iterator[Verification]:
    """Hold the operations one after the other against what knows nothing of them.

    operations : names, all unless given   ->  yields Verification

    >>> found, = verify(operations=["gram"])
    >>> found.failures, found.cases
    ((), 48)
    """
    for name in operations or OPERATIONS:
        yield verify_operation(OPERATIONS[name], seed)


def verify_operation(operation: Operation, seed: int = 0) -> Verification:
    """The Verification of one operation."""
    made = {"definition": 0, "gradient": 0, "contract": 0, "terms": 0}
    difference, failures, rows = 0.0, [], []

    def _note(sample, what, message="", found="", needed=""):
        made[what] += 1
        if message:
            failures.append(f"{operation.name}/{sample.label}: {message}")
        function = (operation.name if what in ("definition", "terms")
                    else f"{operation.name}_backward")
        rows.append({"operation": operation.name, "case": f"{operation.name}/{sample.label}/{what}",
                     "function": function, "dtype": "float64",
                     "grade": "wrong" if message else "agrees", "convention": "", "found": found,
                     "needed": needed, "status": "failed" if message else "passed",
                     "message": message})

    def _try(sample, what, check, *functions, **options):
        try:
            check(*(_with_attributes(f, sample) for f in functions), *sample.inputs, seed=seed,
                  names=operation.arguments[:len(sample.inputs)], **options)
        except GradientError as error:
            _note(sample, what, str(error), "refused", "accepted")
        else:
            _note(sample, what)

    for number, sample in enumerate(operation.samples(generator(operation, seed))):
        off, allowed = _values_differ(operation, sample), VALUES * operation.tolerance
        difference = max(difference, off)
        _note(sample, "definition", "" if off <= allowed else
              f"the fast form and the definition differ by {off:.3g} of the largest element",
              str(off), str(allowed))
        if operation.terms:
            _note(sample, "terms", *too_light(operation.terms(sample)))
        if operation.backward and sample.smooth:
            _try(sample, "gradient", check_gradient, operation.definition, operation.backward,
                 contract=False, elements=ELEMENTS)
            if number == 0:
                _try(sample, "contract", check_contract, operation.f, operation.backward)
    chosen = cases(seed=seed, operations=[operation.name], profile="small")
    outcomes = list(judge_all(reference(), chosen))
    failures += [outcome.message for outcome in outcomes if outcome.status != "passed"]
    return Verification(operation.name, made["definition"], made["gradient"], made["contract"],
                        len(outcomes), difference, tuple(failures), (*rows, *map(row, outcomes)))


def too_light(terms: Mapping[str, float]) -> tuple[str, ...]:
    """What is said of the lightest term of a sum if an error in it could hide in the bounds.

    terms : {name: what it comes to}
    ->  message, found, needed; nothing where each would be missed
    """
    least = WEIGHS * TOLERANCES["float32"]
    name = min(terms, key=lambda name: terms[name])
    share = terms[name] / sum(terms.values())
    if share >= least:
        return ()
    return (f"{name} is {share:.2g} of the sum, too little to be seen: needed {least:.2g}, "
            f"{WEIGHS:g} times the bound", str(share), str(least))


def _with_attributes(function, sample):
    return lambda *arguments: function(*arguments, **sample.attributes)


def _values_differ(operation, sample):
    """Largest difference of the fast form from the definition, in largest elements; inf where
    shapes or NaN differ."""
    with np.errstate(all="ignore"):
        pairs = zip(as_tuple(operation.f(*sample.inputs, **sample.attributes)),
                    as_tuple(operation.definition(*sample.inputs, **sample.attributes)))
        worst = 0.0
        for found, expected in pairs:
            if found.shape != expected.shape:
                return np.inf
            worst = max(worst, float(relative_difference(found, expected).max(initial=0.0)))
    return worst
