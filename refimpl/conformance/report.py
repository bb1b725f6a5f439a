"""Verdicts for people (a table and the failures) and for machines (JSON, JUnit XML)."""

from collections import Counter
import json
from xml.etree import ElementTree

from ..storage import atomic_write

STATUSES = ("passed", "failed", "skipped", "xfailed", "xpassed")


def table(outcomes):
    """A row for each operation: how many cases ended how, and the largest difference of those that passed.   ->  list of str"""
    names = list(dict.fromkeys(outcome.case.operation.name for outcome in outcomes))
    shown = [s for s in STATUSES if s in ("passed", "failed", "skipped") or any(o.status == s for o in outcomes)]
    rows = [["operation", *shown, "largest difference"]]
    for name in names + ["all"]:
        mine = [o for o in outcomes if name in ("all", o.case.operation.name)]
        counts = Counter(o.status for o in mine)
        precise = [o.difference for o in mine if o.status == "passed" and o.case.precision == "float64"]
        rows.append([name, *(str(counts[s]) for s in shown), f"{max(precise):.1e}" if precise else "-"])
    return _columns(rows)


def proof_table(proofs):
    """The reference's own table.   list of Proof  ->  list of str"""
    rows = [["operation", "values", "gradients", "contract", "cases", "failed", "largest difference"]]
    for p in proofs:
        rows.append([p.operation, *map(str, (p.values, p.gradients, p.contracts, p.cases, len(p.failures))), f"{p.difference:.1e}"])
    total = [sum(getattr(p, key) for p in proofs) for key in ("values", "gradients", "contracts", "cases")]
    rows.append(["all", *map(str, total), str(sum(len(p.failures) for p in proofs)), f"{max(p.difference for p in proofs):.1e}"])
    return _columns(rows)


def failures(outcomes, most=10):
    """The messages of the failed cases, the first few in full; skipped functions by name.   ->  list of str"""
    failed = [o for o in outcomes if o.status == "failed"]
    lines = [line for o in failed[:most] for line in ["", *o.message.splitlines()]]
    if len(failed) > most:
        lines += ["", f"... and {len(failed) - most} more: " + ", ".join(o.case.id for o in failed[most:most + 8]) + (" ..." if len(failed) > most + 8 else "")]
    rivals = Counter(o.rival.rsplit(", to ", 1)[0] for o in failed if o.rival)
    lines += [""] + [f"{count} of the failures follow a rival convention: {rival}" for rival, count in rivals.most_common()] if rivals else []
    skipped = sorted({o.case.function for o in outcomes if o.status == "skipped"})
    return lines + (["", "skipped, not offered by the backend: " + ", ".join(skipped)] if skipped else [])


def counts(outcomes):
    return {status: sum(o.status == status for o in outcomes) for status in STATUSES}


def write_json(path, backend, outcomes):
    """{"backend", "tolerances", "counts", "cases": [{"id", "function", "status", "message", "worst", "rival", "difference"}]}"""
    content = {"backend": backend.name, "tolerances": dict(backend.tolerances), "counts": counts(outcomes),
               "cases": [{"id": o.case.id, "function": o.case.function, "status": o.status, "message": o.message, "worst": _plain(o.worst), "rival": o.rival,
                          "difference": _number(o.difference)} for o in outcomes]}
    with atomic_write(path) as file:
        json.dump(content, file, indent=1)
        file.write("\n")


def write_junit(path, backend, outcomes):
    """JUnit's XML, one test case each; an expected failure counts as skipped, an unexpected pass as a failure."""
    tallies = counts(outcomes)
    suite = ElementTree.Element("testsuite", name=f"refimpl check {backend.name}", tests=str(len(outcomes)),
                                failures=str(tallies["failed"] + tallies["xpassed"]), errors="0", skipped=str(tallies["skipped"] + tallies["xfailed"]))
    for o in outcomes:
        operation, name = o.case.id.split("/", 1)
        element = ElementTree.SubElement(suite, "testcase", classname=operation, name=name)
        if o.status in ("failed", "xpassed"):
            ElementTree.SubElement(element, "failure", message=_printable(o.message.split("\n")[0] or "passed, although expected to fail")).text = _printable(o.message)
        elif o.status in ("skipped", "xfailed"):
            ElementTree.SubElement(element, "skipped", message=_printable(o.message.split("\n")[0]))
    with atomic_write(path, "wb") as file:
        ElementTree.ElementTree(suite).write(file, encoding="utf-8", xml_declaration=True)


def _columns(rows):
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return ["  ".join(cell.ljust(w) if i == 0 else cell.rjust(w) for i, (cell, w) in enumerate(zip(row, widths))) for row in rows]


def _plain(worst):
    return None if worst is None else {k: _number(v) if isinstance(v, float) else v for k, v in worst.items()}


def _number(value):
    """JSON has no NaN and no infinity."""
    return value if value == value and abs(value) != float("inf") else repr(value)


def _printable(text):
    """XML allows no control characters."""
    return "".join(c for c in text if c in "\t\n" or ord(c) >= 32)
