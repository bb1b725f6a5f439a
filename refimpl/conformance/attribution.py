"""Which convention of others does a failing backend follow? A name helps only if it is never wrong.

A rival (`rivals`) explains a failure when

- the backend's *first* answer equals the rival's to rounding, type included; a tolerance that the
  backend declares for itself does not count;
- the rival is far from the reference there, by a thousand bounds: where both agree nothing can be
  told.

It is named for a function when it contradicts none of the function's failures and explains at least
one; where several do, all are named. Failures in which it is too near the reference to tell get the
name only if no other rival has a claim. A function that gives other bits on a second call follows
none.
"""

from collections.abc import Iterable
from itertools import groupby
from typing import Any

import numpy as np

from ..gradcheck.difference import differences
from .backend import TOLERANCES
from .rivals import RIVALS
from .specification import as_tuple, cast, cast_attributes, has_type
from .variations import PROMISES
from .yardstick import of_rows

NEAR = 10.0                            # bounds from a rival: they are measured for the reference
FAR = 1000.0                                             # bounds between a rival and the reference


def conventions(failures: Iterable[Any]) -> dict[str, str]:
    """Names for failed outcomes.   list of Outcome (of one operation)  ->  {case id: names}"""
    named = {}
    by_function = groupby(sorted(failures, key=lambda o: o.case.function),
                          key=lambda o: o.case.function)
    for function, group in by_function:
        outcomes = list(group)
        if any(o.case.kind.startswith("same bits twice") for o in outcomes):
            continue
        valued = [o for o in outcomes if o.case.expected is not None
                  and o.case.kind.removesuffix(", float32") not in PROMISES]
        fits = {label: _fits(rival, valued) for label, rival in RIVALS.get(function, ())}
        able = {label: fit for label, fit in fits.items() if "explains" in fit}
        for number, o in enumerate(valued):
            labels = [label for label, fit in able.items()
                      if fit[number] == "explains" or len(able) == 1]
            if labels:
                named[o.case.id] = " or ".join(labels)
    return named


def _fits(rival, outcomes):
    """How a rival fits each outcome, nothing if it contradicts one."""
    found = []
    for outcome in outcomes:
        found.append(_fit(rival, outcome))
        if found[-1] == "contradicts":
            return []
    return found


@np.errstate(all="ignore")
def _fit(rival, outcome):
    """"explains" a failure, is "silent" about it (it equals the reference there), or "contradicts"
    it."""
    case, answer = outcome.case, outcome.answer
    if answer is None or len(answer) != len(case.expected):
        return "contradicts"
    arguments, attributes = case.fresh()
    try:
        expected = as_tuple(rival(*cast(arguments, np.float64),
                                  **cast_attributes(attributes, np.float64)))
    except (ValueError, TypeError, IndexError):
        return "contradicts"
    if len(expected) != len(answer):
        return "contradicts"
    off = from_reference = 0.0
    # The kit's own bounds, never those of the tolerances that a backend declares.
    for found, theirs, ours, allowed in zip(answer, expected, case.expected, case.allowances()):
        if ours is None or found is None or theirs is None:
            if (found is None) != (theirs is None) and ours is not None:
                return "contradicts"
            continue
        if not has_type(found, np.asarray(ours), case.precision) or found.shape != theirs.shape:
            return "contradicts"
        own = TOLERANCES[case.precision] * of_rows(np.where(np.isfinite(theirs), np.abs(theirs), 0))
        nearest = own if theirs.shape != np.shape(ours) else np.maximum(allowed, own)
        off = max(off, _bounds_apart(found, theirs, nearest))
        if theirs.shape == np.shape(ours):
            from_reference = max(from_reference, _bounds_apart(theirs, np.asarray(ours), allowed))
        else:
            from_reference = np.inf
    if off > NEAR:
        return "contradicts"
    return "explains" if from_reference >= FAR else "silent"


def _bounds_apart(a, b, allowed):
    """How far two arrays are apart, in bounds of the kit."""
    off = differences(a, b)
    return float(np.where(off > 0, off / allowed, 0.0).max(initial=0.0))


def as_good(outcome: Any) -> str:
    """What an answer follows that is another one than the reference's and as good, "" where it is
    not."""
    case = outcome.case
    if case.operation.same is None or outcome.answer is None or outcome.grade != "wrong":
        return ""
    try:
        return case.operation.same(outcome.answer, *case.fresh())
    except (ValueError, TypeError, IndexError):
        return ""
