"""Golden vectors held against what this release would have written.

A hash tells that a folder was edited, until somebody mends the hash as well. What can be computed
again is therefore computed again: the answers to the inputs that are stored, how far each element
may be off, and, where the folder says that it is this release's, its cases and all its texts.
"""

from collections.abc import Iterator
from dataclasses import replace
import json
from pathlib import Path

from .backend import OPERATIONS, reference
from .calls import Case
from .cases import answerable
from .golden import MADE_BY, texts
from .judge import judge_all
from .schema import facts, read_manifest

# How much more than what is measured again an element may be off: what is measured depends on the
# last digits of a machine. Up to ten times of what costs nothing to know, nothing is measured.
SLACK = ((False, 10.0), (True, 2.0))


def objections(folder: str | Path, found: list[Case]) -> Iterator[str]:
    """What in a folder that is as its hashes say is not what this release would have written.

    found : the cases of `read_folder`, which had no complaint
    ->  yields complaints.   A folder of another release may have other cases and other texts.
    """
    manifest = read_manifest(folder)
    mine = {case.id: case for case in answerable(
        operations=dict.fromkeys(case.operation.name for case in found))}
    if manifest["made_by"] == MADE_BY:
        yield from _texts(Path(folder), manifest)
        there = {case.id for case in found}
        yield from (f"{name}: found no such case, needed all of its operation"
                    for name in mine if name not in there)
        yield from (f"{name}: found a case that {MADE_BY} does not export"
                    for name in sorted(there - mine.keys()))
    for outcome in judge_all(reference(), found):
        if outcome.status == "failed":
            yield (f"{outcome.case.id}: is not the answer to its inputs; here they give: "
                   f"{outcome.found}")
    for case in found:
        own = mine.get(case.id)
        if own and _kind(case) != _kind(own):
            yield (f"{case.id}: has another function, precision or exactness than its id says, or "
                   "other arguments")
        elif own and _allows_more(case, own):
            yield f"{case.id}: allows its answer to be off by more than this release does"


def _texts(folder, manifest):
    needed = json.loads(json.dumps(facts()))
    for key, fact in needed.items():
        if isinstance(fact, dict):
            names = [f"{key}: {name}" for name in {**fact, **manifest[key]}
                     if fact.get(name) != manifest[key].get(name)]
        else:
            names = [key] * (fact != manifest[key])
        yield from (f"manifest.json: {name}: is not that of {MADE_BY}" for name in names)
    for entry in manifest["cases"]:
        if entry["equation"] != OPERATIONS[entry["operation"]].equation:
            yield f"{entry['id']}: equation: is not that of {MADE_BY}"
    for name, text in texts().items():
        if (folder / name).read_bytes() != text:
            yield f"{name}: is not that of {MADE_BY}"


def _kind(case):
    return case.function, case.single, case.exact, len(case.arguments), list(case.attributes)


def _allows_more(case, own):
    """Whether an element may be off by more than in the case of this release, asked anew."""
    again = replace(own, arguments=case.arguments, attributes=case.attributes,
                    expected=case.expected, yardstick=own.yardstick and own.yardstick.again(
                        case.arguments, case.attributes, case.expected))
    return not any(all(given is None or (given <= slack * needed).all() for given, needed in zip(
        case.allowances(), again.allowances(measured=measured))) for measured, slack in SLACK)
