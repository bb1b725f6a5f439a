"""Compare a backend's outputs with the reference's, element by element, and say which convention it
follows where they differ.

A call gets copies of its own, made before the first one, and the first thing that is looked at is
whether it left them alone. What a function says is judged once; the same answer is then held
against the conventions of others (`attribution`).
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

import numpy as np

from ..gradcheck.contract import changed, mixture, nonlinearity, same_bits, sharing
from ..gradcheck.difference import relative_difference
from . import attribution
from .backend import Backend, NoAnswer, as_backend, ask, is_expected_failure
from .cases import Case
from .specification import has_type

# How a library says that it does not take something.
REFUSALS = (ValueError, TypeError, NotImplementedError)
GRADES = ("agrees", "wrong", "convention", "stricter", "laxer", "not offered", "undecidable")


@dataclass(frozen=True)
class Outcome:
    """The verdict on one case.

    status : passed, failed, skipped, xfailed (an expected failure) or xpassed (one that passed);
    grade : one of GRADES;  message : for people;  found, expected : in a few words or numbers;
    rival : the convention that it follows instead, "" when none is known;  answer : its outputs
    """

    case: Case
    status: str
    message: str = ""
    worst: dict[str, Any] | None = None
    rival: str = ""
    difference: float = 0.0
    grade: str = ""
    found: Any = ""
    expected: Any = ""
    answer: tuple | None = None
    error: BaseException | None = None


class Difference(Exception):
    """What is wrong with a result, found and expected in a few words or numbers, and the worst
    element.
    """

    def __init__(self, message: str, found: Any = "", expected: Any = "", **worst: Any) -> None:
        super().__init__(message)
        self.worst, self.found, self.expected = worst, found, expected


def judge_all(backend: Any, chosen: Iterable[Case],
              expected_failures: Iterable[str] = ()) -> Iterator[Outcome]:
    """Outcomes of all cases, in order.   backend : whatever `as_backend` takes

    The cases of one operation are judged together: a convention is named only where it explains
    every failure of a function.
    """
    backend = as_backend(backend)
    for _, group in groupby(chosen, key=lambda case: case.operation.name):
        for outcome in _weighed([_first_look(case, backend) for case in group], backend):
            expected = is_expected_failure(outcome.case.id, expected_failures)
            if expected and outcome.status in ("passed", "failed"):
                status = "xfailed" if outcome.status == "failed" else "xpassed"
                outcome = replace(outcome, status=status)
            yield outcome


def judge(case: Case, backend: Any) -> Outcome:
    """The Outcome of one case, judged alone.

    >>> from refimpl.conformance import case, reference
    >>> judge(case("gram/plain/forward/float64"), reference()).grade
    'agrees'
    """
    backend = as_backend(backend)
    return _weighed([_first_look(case, backend)], backend)[0]


def _first_look(case, backend):
    if case.function not in backend.functions:
        return Outcome(case, "skipped", f"{backend.name} has no {case.function}",
                       grade="not offered", expected=case.function)
    answer: list[tuple] = []
    try:
        with np.errstate(all="ignore"):
            difference = _try(case, backend, answer)
    except Difference as wrong:
        laxer = case.kind == "refused"
        return Outcome(case, "failed", str(wrong), wrong.worst, grade="laxer" if laxer else "wrong",
                       found=wrong.found or str(wrong), expected=wrong.expected,
                       answer=answer[0] if answer else None)
    except NoAnswer as silent:
        return Outcome(case, "failed", str(silent), grade="wrong", found=str(silent),
                       expected="an answer", error=silent.error)
    return Outcome(case, "passed", difference=difference or 0.0, grade="agrees")


def _weighed(outcomes, backend):
    """What one case alone cannot tell: refusals, conventions; and the lines to paste."""
    answered = {o.case.function for o in outcomes
                if o.grade == "agrees" and o.case.kind != "refused"}
    named = attribution.conventions([o for o in outcomes if o.grade == "wrong"])
    found = []
    for o in outcomes:
        rival = named.get(o.case.id, "") or attribution.as_good(o)
        if o.grade == "wrong" and o.error is not None and _is_refusal(o, answered):
            o = replace(o, grade="stricter")
        elif rival:
            o = replace(o, grade="convention", rival=rival)
        elif (o.grade == "agrees" and o.case.kind == "refused" and o.case.function not in answered
              and any(p.error is not None for p in outcomes if p.case.function == o.case.function)):
            o = replace(o, status="failed", grade="undecidable",
                        expected="an answer to some valid call",
                        message="refused, as it should be; but it answers no valid call either")
        if o.status == "failed":
            says = [f"{o.case.id}: {o.message}"] + ([f"It matches {rival}."] if rival else [])
            o = replace(o, message="\n".join([*says, reproduction(o.case, backend)]))
        found.append(replace(o, answer=None))
    return found


def _is_refusal(outcome, answered):
    """Whether a function that answers other calls says that it does not take this one."""
    case = outcome.case
    special = case.attributes or case.kind not in ("float64", "float32")
    return isinstance(outcome.error, REFUSALS) and bool(special) and case.function in answered


def _try(case, backend, answer):
    if case.kind == "refused":
        return _refused(case, backend)
    if case.kind in _PROMISES:
        return _PROMISES[case.kind](case, backend)
    answer.append(_call(case, backend))
    return compare(answer[0], case, case.bounds(backend.tolerances))


def _call(case, backend, upstream=None, writeable=True):
    """Outputs of the function for copies of the case's arguments, which it must leave alone."""
    arguments, attributes = case.fresh(writeable)
    before = case.arguments
    if upstream is not None:
        before = (upstream, *before[1:])
        arguments = (upstream.copy(), *arguments[1:])
    try:
        return ask(backend.functions[case.function], arguments, attributes)
    finally:
        for name, _ in changed((*case.names[:len(before)], *case.attributes),
                               (*before, *case.attributes.values()),
                               (*arguments, *attributes.values())):
            raise Difference(f"changed its argument {name}, needed to leave it alone",
                             f"changed {name}", f"{name} left alone")


def compare(found: tuple, case: Case, bounds: Sequence[float]) -> float:
    """Raise Difference unless all outputs have the expected shape, type and values.

    bounds : of `Case.bounds`   ->  largest difference relative to the largest element
    """
    expected, worst = case.expected or (), 0.0
    if len(found) != len(expected):
        raise Difference(f"found {len(found)} outputs, needed {len(expected)}",
                         f"{len(found)} outputs", f"{len(expected)} outputs")
    for number, (a, b, bound) in enumerate(zip(found, expected, bounds)):
        label = _output_name(case, number)
        if b is not None and a is None:
            raise Difference(f"{label}: found None, needed an array of shape {b.shape}",
                             "None", f"shape {b.shape}")
        if b is not None:
            worst = max(worst, _compare_arrays(label, a, np.asarray(b), bound, case))
    return worst


def _output_name(case, number):
    if case.function.endswith("_backward"):
        names = case.operation.arguments
        return f"gradient of {names[number] if number < len(names) else number}"
    return "output" if len(case.expected) == 1 else f"output {number}"


def _compare_arrays(label, found, expected, bound, case):
    if found.shape != expected.shape:
        raise Difference(f"{label}: found shape {found.shape}, needed {expected.shape}",
                         f"shape {found.shape}", f"shape {expected.shape}")
    if not has_type(found, expected, case.precision):
        dtype = case.precision if expected.dtype.kind == "f" else expected.dtype
        raise Difference(f"{label}: found dtype {found.dtype}, needed {dtype}",
                         f"dtype {found.dtype}", f"dtype {dtype}")
    if not expected.size:
        return 0.0
    off = relative_difference(found, expected)
    worst = np.unravel_index(np.argmax(off), off.shape)
    if not off[worst] <= bound:
        index, values = [int(i) for i in worst], (float(found[worst]), float(expected[worst]))
        raise Difference(f"{label}, worst at {index}: got {values[0]:.17g}, wanted "
                         f"{values[1]:.17g} ({off[worst]:.3g} of the largest element, allowed "
                         f"{bound:.1g}; {int((~(off <= bound)).sum())} of {off.size} elements "
                         "differ)", *values, output=label, index=index, got=values[0],
                         wanted=values[1], relative=float(off[worst]))
    return float(off[worst])


def _refused(case, backend):
    try:
        _call(case, backend)
    except NoAnswer as silent:
        if not isinstance(silent.error, Exception):              # leaving the program is no refusal
            raise
        if backend.name != "refimpl":             # another implementation may refuse in its own way
            return
        if not isinstance(silent.error, ValueError):
            raise
        if not str(silent.error).startswith(case.argument + ":"):
            raise Difference(f"refused with {str(silent.error)!r}, needed a message that names "
                             f"{case.argument!r} first") from None
        return
    raise Difference(f"was accepted, needed an error about {case.argument}", "an answer",
                     f"an error about {case.argument}")


def _left_alone(case, backend):
    """Read-only arguments too."""
    _call(case, backend)
    _call(case, backend, writeable=False)


def _same_bits(case, backend):
    """A state that other calls leave behind would show, and a buffer that is used again."""
    first = _call(case, backend)
    kept = [None if a is None else a.copy() for a in first]
    for arguments, attributes in case.others:
        ask(backend.functions[case.function], arguments, attributes)
    _compare_bits(case, kept, first, "in the arrays of the first answer after other calls (a "
                                     "buffer used twice?)")
    _compare_bits(case, kept, _call(case, backend), "on a second call with the same arguments")


def _compare_bits(case, kept, found, when):
    for number, (a, b) in enumerate(zip(kept, found)):
        if a is not None and not same_bits(a, b):
            raise Difference(f"{_output_name(case, number)}: found other bits {when}", "other bits",
                             "the same bits on every call")


def _own_memory(case, backend):
    arguments, attributes = case.fresh()
    outputs = ask(backend.functions[case.function], arguments, attributes)
    for number, out in enumerate(outputs):
        for name in sharing(out, zip(case.names, arguments)):
            raise Difference(f"{_output_name(case, number)}: shares memory with {name}, needed "
                             "memory of its own", f"memory of {name}", "memory of its own")


def _linear(case, backend):
    upstream = case.arguments[0]
    other = np.cos(3.0 * np.arange(upstream.size)).reshape(upstream.shape)
    first, second, mixed = (_call(case, backend, dy)
                            for dy in (upstream, other, mixture(upstream, other)))
    bound = 10 * backend.tolerances[case.precision] * case.operation.tolerance
    for number, (a, b, both) in enumerate(zip(first, second, mixed)):
        if a is not None:
            size = max(np.abs(a).max(initial=0), np.abs(b).max(initial=0)) or 1.0
            off = nonlinearity(a, b, both) / size
            if not off <= bound:
                raise Difference(f"{_output_name(case, number)}: is not linear in the upstream "
                                 f"gradient (off by {off:.3g} of the largest element)",
                                 float(off), float(bound))


_PROMISES = {"leaves its inputs alone": _left_alone, "same bits twice": _same_bits,
             "memory of its own": _own_memory, "linear in the upstream gradient": _linear}


def reproduction(case: Case, backend: Backend) -> str:
    """Lines to paste, which make the same inputs again."""
    if case.folder:
        lines = ["from refimpl.conformance.golden import golden_case",
                 f"c = golden_case({case.folder!r}, {case.id!r})"]
    else:
        lines = ["from refimpl.conformance import case", f"c = case({case.id!r}, seed={case.seed})"]
    if backend.name == "refimpl":
        lines += ["from refimpl.conformance import reference",
                  "print(c.call(reference()), c.expected)"]
    elif backend.loaded:
        lines += ["from refimpl.conformance import load_backend",
                  f"print(c.call(load_backend({backend.name!r})), c.expected)"]
    else:
        lines += [f"{'c.check(MINE)':48} # MINE: the mapping that you gave"]
    return "\n".join(f"    {line}" for line in lines)
