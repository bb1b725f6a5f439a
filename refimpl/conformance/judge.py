"""Compare a backend's outputs with the reference's, element by element, and say which convention it
follows where they differ.

A call gets copies of its own, made before the first one, and the first thing that is looked at is
whether it left them alone. What a function says is judged once; the same answer is then held
against the conventions of others (`attribution`).
"""

from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import groupby
from types import MappingProxyType
from typing import Any

import numpy as np

from . import attribution
from .backend import Backend, NoAnswer, as_backend, ask, is_expected_failure
from .capabilities import covering
from .cases import Case
from .comparison import Difference, call, compare
from .promises import CHECKS

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


def judge_all(backend: Any, chosen: Iterable[Case],
              expected_failures: Collection[str] = ()) -> Iterator[Outcome]:
    """Outcomes of all cases, in order.   backend : whatever `as_backend` takes

    The cases of one operation are judged together: a convention is named only where it explains
    every failure of a function.
    """
    backend = as_backend(backend)
    for _, group in groupby(chosen, key=lambda case: case.operation.name):
        yield from judge_together(list(group), backend, expected_failures)


def judge_together(chosen: Iterable[Case], backend: Backend,
                   expected_failures: Collection[str] = (), *,
                   settled: Mapping[str, str] = MappingProxyType({}), given_up: Container[str] = (),
                   asking: Callable[[Case], None] = lambda case: None,
                   weighing: Callable[[], None] = lambda: None) -> list[Outcome]:
    """Outcomes of one operation's cases.

    settled : {case id: why it has no answer}, which are not asked;  given_up : those of them after
    which the function is not asked any more
    asking, weighing : told of each case before it is asked, and when none will be any more
    """
    looks: list[Outcome] = []
    silent: set[str] = set()
    for case in chosen:
        if case.function in silent:
            looks.append(Outcome(case, "skipped", "not asked any more", grade="undecidable",
                                 found="not asked any more", expected="an answer"))
        elif case.id in settled:
            looks.append(Outcome(case, "failed", settled[case.id], grade="wrong",
                                 found=settled[case.id], expected="an answer"))
            if case.id in given_up:
                silent.add(case.function)
        else:
            asking(case)
            looks.append(_first_look(case, backend))
    weighing()
    found = []
    for outcome in _weighed(_without_stubs(looks, backend), backend):
        identity = outcome.case.id
        if is_expected_failure(identity, expected_failures):
            if outcome.status == "failed":
                outcome = replace(outcome, status="xfailed")
            elif outcome.status == "passed" and identity in expected_failures:
                outcome = replace(outcome, status="xpassed")     # a pattern may be wider
        found.append(outcome)
    return found


def judge(case: Case, backend: Any) -> Outcome:
    """The Outcome of one case, judged alone.

    >>> from refimpl.conformance import case, reference
    >>> judge(case("gram/plain/forward/float64"), reference()).grade
    'agrees'
    """
    backend = as_backend(backend)
    return _weighed([_first_look(case, backend)], backend)[0]


def _first_look(case, backend):
    declared = covering(case, backend.lacks)
    if declared or case.function not in backend.functions:
        return _not_offered(case, backend, declared or case.function)
    answer: list[tuple] = []
    try:
        with np.errstate(all="ignore"):
            difference = _try(case, backend, answer)
    except Difference as wrong:
        laxer = case.kind == "refused"
        return Outcome(case, "failed", str(wrong), wrong.worst, grade="laxer" if laxer else "wrong",
                       found=str(wrong) if wrong.found == "" else wrong.found,
                       expected=wrong.expected, answer=answer[0] if answer else None)
    except NoAnswer as silent:
        return Outcome(case, "failed", str(silent), grade="wrong", found=str(silent),
                       expected="an answer", error=silent.error)
    return Outcome(case, "passed", difference=difference or 0.0, grade="agrees")


def _not_offered(case, backend, what):
    return Outcome(case, "skipped", f"{backend.name} has no {what}", grade="not offered",
                   expected=what)


def _without_stubs(looks, backend):
    """Of a function that says of every valid call that it is not written yet, nothing is offered.
    """
    valid = [o for o in looks if o.case.kind != "refused" and o.grade != "not offered"]
    written = {o.case.function for o in valid if not isinstance(o.error, NotImplementedError)}
    stubs = {o.case.function for o in valid} - written
    return [_not_offered(o.case, backend, o.case.function) if o.case.function in stubs else o
            for o in looks]


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
    promise = CHECKS.get(case.kind.removesuffix(", float32"))
    if promise is not None:
        return promise(case, backend)
    for arguments, attributes in case.others:
        ask(backend.functions[case.function], arguments, attributes)
    answer.append(call(case, backend))
    try:                                   # most answers are near enough without any measurement
        return compare(answer[0], case, case.allowances(backend.tolerances, measured=False))
    except Difference:
        return compare(answer[0], case, case.allowances(backend.tolerances))


def _refused(case, backend):
    try:
        call(case, backend)
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
