"""Verdicts for people (a table and the failures) and for machines (JSON, JUnit XML)."""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any
from xml.etree import ElementTree

from ..gradcheck.report import columns
from ..storage import atomic_write
from .backend import OPERATIONS, is_expected_failure
from .causes import causes
from .judge import GRADES

STATUSES = ("passed", "failed", "skipped", "xfailed", "xpassed")
ALWAYS = ("agrees", "wrong", "not offered")


def table(outcomes: Sequence[Any]) -> list[str]:
    """A row for each operation: how many cases have which grade, and the largest difference of
    those that agree.   ->  list of str"""
    names = list(dict.fromkeys(outcome.case.operation.name for outcome in outcomes))
    shown = [g for g in GRADES if g in ALWAYS or any(o.grade == g for o in outcomes)]
    expected = [s for s in ("xfailed", "xpassed") if any(o.status == s for o in outcomes)]
    rows = [["operation", *shown, *expected, "largest difference"]]
    for name in names + ["all"]:
        mine = [o for o in outcomes if name in ("all", o.case.operation.name)]
        grades, statuses = Counter(o.grade for o in mine), Counter(o.status for o in mine)
        precise = [o.difference for o in mine
                   if o.status == "passed" and o.case.precision == "float64"]
        rows.append([name, *(str(grades[g]) for g in shown), *(str(statuses[s]) for s in expected),
                     f"{max(precise):.1e}" if precise else "-"])
    return columns(rows)


def verification_table(found: Sequence[Any]) -> list[str]:
    """The reference's own table.   list of Verification  ->  list of str"""
    rows = [["operation", "values", "gradients", "contract", "cases", "failed",
             "largest difference"]]
    for p in found:
        counted = (p.values, p.gradients, p.contracts, p.cases, len(p.failures))
        rows.append([p.operation, *map(str, counted), f"{p.difference:.1e}"])
    total = [sum(getattr(p, key) for p in found)
             for key in ("values", "gradients", "contracts", "cases")]
    rows.append(["all", *map(str, total), str(sum(len(p.failures) for p in found)),
                 f"{max(p.difference for p in found):.1e}"])
    return columns(rows)


def failures(outcomes: Sequence[Any], most: int = 10) -> list[str]:
    """The failures by cause, a line each with its first case in full for the first few; what is
    not offered by name.   ->  list of str
    """
    found, lines = causes(outcomes), []
    for cause in found[:most]:
        lines += ["", str(cause), *cause.outcomes[0].message.splitlines()]
    lines += ["", *map(str, found[most:])] if found[most:] else []
    absent = sorted({str(o.expected) for o in outcomes if o.grade == "not offered"})
    return lines + (["", "not offered by the backend: " + ", ".join(absent)] if absent else [])


def verdict(outcomes: Sequence[Any], required: Iterable[str] = ()) -> str:
    """"agrees", "disagrees" or, where no call that has an answer was asked, "nothing checked".

    required : functions that must be offered and take exactly what the reference takes
    """
    if not any(o.grade != "not offered" and o.case.kind != "refused" for o in outcomes):
        return "nothing checked"
    for o in outcomes:
        strict = o.case.function in required
        bad = o.grade in ("wrong", "convention", "undecidable") or (strict and o.grade != "agrees")
        if o.status == "xpassed" or (bad and o.status != "xfailed"):
            return "disagrees"
    return "agrees"


def idle_patterns(patterns: Iterable[str], outcomes: Sequence[Any]) -> list[str]:
    """Patterns of failures that are expected of the operations that were judged, or of none that
    there is, and which none of their cases shows any more.   ->  list of str"""
    judged = {o.case.operation.name for o in outcomes}
    failed = [o.case.id for o in outcomes if o.status in ("xfailed", "xpassed")]

    def _about(pattern, names):
        return any(is_expected_failure(name, [pattern.partition("/")[0]]) for name in names)
    return [pattern for pattern in patterns
            if (_about(pattern, judged) or not _about(pattern, OPERATIONS))
            and not any(is_expected_failure(identity, [pattern]) for identity in failed)]


def misspelt(backend: Any, most: int = 20) -> list[str]:
    """A line for each name in a backend that is no operation.   ->  list of str"""
    lines = [f"{backend.name}: {name!r} is no operation and was not judged"
             + (f"; do you mean {near}?" if near else "") for name, near in backend.unknown[:most]]
    more = len(backend.unknown) - most
    return lines + [f"{backend.name}: ... and {more} more such names"] * (more > 0)


def last_line(outcomes: Sequence[Any], verdict: str) -> str:
    """How it ended, with the counts."""
    grades = Counter(o.grade for o in outcomes)
    counted = ", ".join(f"{grades[g]} {g}" for g in GRADES if grades[g])
    return f"verdict: {verdict} ({counted or 'no case'})"


def counts(outcomes: Sequence[Any]) -> dict[str, int]:
    """{status: how many outcomes have it}"""
    return {status: sum(o.status == status for o in outcomes) for status in STATUSES}


def row(outcome: Any) -> dict[str, Any]:
    """One case for machines.   ->  flat dict"""
    o = outcome
    return {"operation": o.case.operation.name, "case": o.case.id, "function": o.case.function,
            "dtype": o.case.precision, "grade": o.grade, "convention": o.rival,
            "found": _number(o.found), "needed": _number(o.expected), "status": o.status,
            "difference": _number(o.difference), "message": o.message}


def write_junit(path: Any, backend: Any, outcomes: Sequence[Any],
                complaints: Sequence[str] = ()) -> None:
    """JUnit's XML, one test case each; an expected failure counts as skipped, an unexpected pass as
    a failure."""
    tallies = counts(outcomes)
    suite = ElementTree.Element(
        "testsuite", name=f"refimpl check {_printable(backend.name)}",
        tests=str(len(outcomes) + len(complaints)),
        failures=str(tallies["failed"] + tallies["xpassed"] + len(complaints)), errors="0",
        skipped=str(tallies["skipped"] + tallies["xfailed"]))
    for o in outcomes:
        operation, name = o.case.id.split("/", 1)
        element = ElementTree.SubElement(suite, "testcase", classname=operation, name=name)
        first = _printable(o.message.split("\n")[0])
        if o.status in ("failed", "xpassed"):
            failure = ElementTree.SubElement(
                element, "failure", message=first or "passed, although expected to fail")
            failure.text = _printable(o.message)
        elif o.status in ("skipped", "xfailed"):
            ElementTree.SubElement(element, "skipped", message=first)
    for complaint in complaints:
        element = ElementTree.SubElement(suite, "testcase", classname="golden folder",
                                         name=_printable(complaint)[:80])
        ElementTree.SubElement(element, "failure", message=_printable(complaint))
    with atomic_write(path, "wb") as file:
        ElementTree.ElementTree(suite).write(file, encoding="utf-8", xml_declaration=True)


def _number(value):
    """JSON has no NaN and no infinity."""
    if isinstance(value, float) and (value != value or abs(value) == float("inf")):
        return repr(value)
    return value


def _printable(text):
    """XML allows no control characters and no halves of surrogate pairs."""
    return "".join(c if c in "\t\n" or (ord(c) >= 32 and not 0xD800 <= ord(c) <= 0xDFFF) else "?"
                   for c in text)
