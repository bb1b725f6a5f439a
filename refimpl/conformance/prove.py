"""The reference against itself would prove nothing. Here it is held against a second derivation and against instruments that know no derivation:

- values: the fast form against `definitions`, which spell the formula out element by element;
- gradients: the hand-written backward against the complex step or Richardson differences *of the definition*;
- contract: what every backward must keep;
- rules: kinks, ties and NaN against answers worked by hand; refused inputs against the argument that must be named.
"""

from dataclasses import dataclass

import numpy as np

from ..nn import GradientError, check_contract, check_gradient
from .backend import reference
from .cases import OPERATIONS, cases, generator
from .judge import judge
from .record import as_tuple, relative_difference

VALUES = 1e-12                                                   # relative to the largest element
ELEMENTS = 40                                                    # of a gradient; of a larger one a sample, and all of it along a line


@dataclass(frozen=True)
class Proof:
    """One operation's verdict: how many checks of each kind passed, the largest difference of its values, and what failed."""

    operation: str
    values: int
    gradients: int
    contracts: int
    cases: int
    difference: float
    failures: tuple


def prove(*, seed=0, operations=None):
    """Prove the operations one after the other.   operations : names, all unless given   ->  yields Proof"""
    for name in operations or OPERATIONS:
        yield prove_operation(OPERATIONS[name], seed)


def prove_operation(operation, seed=0):
    """->  Proof of one operation"""
    values = gradients = contracts = 0
    difference, failures = 0.0, []
    for number, sample in enumerate(operation.samples(generator(operation, seed))):
        off = _values_differ(operation, sample)
        difference = max(difference, off)
        if off > VALUES * operation.tolerance:
            failures.append(f"{operation.name}/{sample.label}: the fast form and the definition differ by {off:.3g} of the largest element")
        values += 1
        if operation.backward and sample.smooth:
            f, backward = _with_attributes(operation.definition, sample), _with_attributes(operation.backward, sample)
            names = operation.arguments[:len(sample.inputs)]
            try:
                check_gradient(f, backward, *sample.inputs, names=names, seed=seed, contract=False, elements=ELEMENTS)
                gradients += 1
                if number == 0:
                    check_contract(_with_attributes(operation.f, sample), backward, *sample.inputs, names=names, seed=seed)
                    contracts += 1
            except GradientError as error:
                failures.append(f"{operation.name}/{sample.label}: {error}")
    outcomes = [judge(case, reference()) for case in cases(seed=seed, operations=[operation.name])]
    failures += [outcome.message for outcome in outcomes if outcome.status != "passed"]
    return Proof(operation.name, values, gradients, contracts, len(outcomes), difference, tuple(failures))


def _with_attributes(function, sample):
    return lambda *arguments: function(*arguments, **sample.attributes)


def _values_differ(operation, sample):
    """Largest difference of the fast form from the definition, in largest elements; inf where shapes or NaN differ."""
    with np.errstate(all="ignore"):
        pairs = zip(as_tuple(operation.f(*sample.inputs, **sample.attributes)), as_tuple(operation.definition(*sample.inputs, **sample.attributes)))
        worst = 0.0
        for found, needed in pairs:
            if found.shape != needed.shape:
                return np.inf
            worst = max(worst, float(relative_difference(found, needed).max(initial=0.0)))
    return worst
