"""What a manifest of golden vectors says beside its cases, and the JSON schema that it satisfies.

The facts are for somebody who has the folder and no source: each operation's formula as `refimpl
check --explain` prints it, the constants that a formula names, and what the words of a case mean.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict
import json
import operator
from pathlib import Path
import re
from typing import Any

import numpy as np

from ..holden2016 import losses, rows
from ..holden2017.objective import WEIGHTS
from ..motion.features import FORWARD, POSITIONS, SIDEWAYS, TURN
from ..motion.joints import BONES, FEET, SLOTS
from ..nn.conventions import CONVENTIONS
from ..storage import FormatError
from .backend import LOOSEST, OPERATIONS, TOLERANCES
from .cases import generator
from .explain import explain
from .specification import as_tuple
from .vectors import options, output_names

FORMAT, VERSION = "golden vectors", 3
MEANING = {
    "arrays": "(clips, channels, frames); filters (outputs, inputs / groups, width)",
    "allowed": "an answer agrees where |found - expected| <= allowed for each element, NaN is "
               "where NaN is expected and infinities are equal; -0 is 0",
    "bound": "the largest element of allowed, in units of the largest finite element of the "
             "expected array (of 1 where all are 0)",
    "exact": "true where nothing is rounded: choices, copies, and what a rule decides at a kink or "
             "tie; allowed is then a few last digits",
    "versions": "the version rises whenever a key, a file or a meaning is added, taken away or "
                "changed; within a version only cases, texts and numbers may differ, from one "
                "release (made_by) or seed to the next. A reader refuses every other version"}
# How another program is asked, in an exported folder's README.txt and in --help.
PROTOCOL = """\
The program is started as PROGRAM FOLDER. The folder holds case.json and the inputs as .npy files;
the program writes its answers there as .npy files, little-endian and in C order: out0.npy, out1.npy
... , each of the dtype that "outputs" in case.json gives it, and none where that has null. Exit
status 0: answered; 3: the operation, or an option of it, is not offered; any other: refused, with
the last line of standard error as the reason. It is asked for more than golden vectors hold, also
with inputs that are to be refused (then "outputs" has no dtype); taking them is told, and fails
with --require alone. A command whose last word is - is started once: it reads folders from standard
input, one a line, and answers each with a line on standard output, written at once: 0, 3, or 1 and
the reason."""


def _object(required: dict[str, Any], **optional: Any) -> dict[str, Any]:
    return {"type": "object", "required": list(required), "additionalProperties": False,
            "properties": {**required, **optional}}


def _map(values: dict[str, Any]) -> dict[str, Any]:
    return {"type": "object", "additionalProperties": values}


def _list(items: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {"type": "array", "items": items, **more}


WORD, YES = {"type": "string"}, {"const": True}
WORDS = _list(WORD)
HASH, COUNT = {"type": "string", "pattern": "^[0-9a-f]{64}$"}, {"type": "integer", "minimum": 0}
LABEL = {"type": "string", "pattern": "^[A-Za-z0-9_]+$"}
GIVEN = {"oneOf": [{"required": ["array", "dtype", "shape"]}, {"required": ["value"]}]}
INPUT = {"array": LABEL, "dtype": WORD, "shape": _list(COUNT), "value": {}, "default": YES}
OUTPUT = _object({"name": WORD, "array": LABEL, "dtype": WORD, "shape": _list(COUNT),
                  "allowed": LABEL,
                  "bound": {"type": "number", "exclusiveMinimum": 0, "maximum": LOOSEST}})
CASE = {
    "id": {**WORD, "pattern": "^[ -~]+$"}, "operation": WORD, "function": WORD, "equation": WORD,
    "precision": {"enum": list(TOLERANCES)}, "exact": {"type": "boolean"},
    "arguments": _list({**_object({"name": WORD}, **INPUT), **GIVEN}),
    "attributes": _map({**_object({}, **INPUT), **GIVEN}),
    "outputs": _list({**OUTPUT, "type": ["object", "null"]}, minItems=1)}
SCHEMA = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "title": f"manifest.json of {FORMAT}, version {VERSION}",
    **_object({
        "format": {"const": FORMAT}, "version": {"const": VERSION}, "made_by": WORD,
        **dict.fromkeys(MEANING, WORD),
        "constants": {"type": "object"},
        "conventions": _list(_object({"where": WORD, "here": WORD, "rivals": WORDS})),
        "operations": _map(_object({
            "equation": WORD, "text": WORDS, "arguments": WORDS, "options": WORDS,
            "defaults": _map({}), "outputs": WORDS,
            "gradients": {**WORDS, "type": ["array", "null"]}})),
        "cases": _list(_object({
            **CASE, "folder": {"type": "string", "pattern": "^vectors/[a-z0-9-]+$"},
            "file": {"type": "string", "pattern": "^vectors/[a-z0-9-]+\\.npz$"}, "sha256": HASH,
            "files": _map(HASH)}), minItems=1),
        "files": _object({"README.txt": HASH, "manifest.schema.json": HASH}), "sha256": HASH})}
BOUNDS = (("minimum", "at least", operator.ge), ("maximum", "at most", operator.le),
          ("exclusiveMinimum", "above", operator.gt))
TYPES = {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None)}


def facts() -> dict[str, Any]:
    """All that a manifest says beside its cases.   ->  as JSON has it"""
    return {
        **MEANING, "constants": _constants(),
        "conventions": [{"where": c.where, "here": c.here,
                         "rivals": [f"{r}: {who}" for r, who in c.rivals]} for c in CONVENTIONS],
        "operations": {name: _operation(operation) for name, operation in OPERATIONS.items()}}


def _constants():
    span = [POSITIONS.start, POSITIONS.stop - 1]
    return {
        "joints": list(SLOTS), "feet": list(FEET), "bones": [list(bone) for bone in BONES],
        "rows of the 66 numbers": {"positions": span, "turn": TURN, "forward": FORWARD,
                                   "sideways": SIDEWAYS},
        "equation 7": "v_r = (sideways, 0, forward), omega x p = (turn p_z, 0, -turn p_x), "
                      "v_j[t] = p_j[t+1] - p_j[t]; all else is of frame t",
        "gaussian_filter1d(x, sigma)": "sum_k g_k x[t + k] with g_k = exp(-k^2 / (2 sigma^2)), |k| "
                                       "<= floor(4 sigma + 1/2), divided by their sum; beyond its "
                                       "ends x is mirrored, ends included (c b a | a b c | c b a), "
                                       "or keeps its end where mode is nearest",
        "weights of total_loss": {reading: {name: weight for name, weight in asdict(weights).items()
                                            if name != "reading"}
                                  for reading, weights in WEIGHTS.items()},
        "rows of the 73 numbers of 2016": {
            "positions": [rows.POSITIONS.start, rows.POSITIONS.stop - 1],
            "sideways": rows.VELOCITY.start, "forward": rows.VELOCITY.stop - 1,
            "minus the turn": rows.TURN},
        "bones of 2016": [[int(joint) for joint in bone] for bone in losses.BONES],
        "lengths of bones of 2016": losses.LENGTHS.tolist()}


def _operation(operation):
    sample = operation.samples(generator(operation, 0))[0]
    answer = as_tuple(operation.f(*sample.inputs, **sample.attributes))
    gradients = operation.backward and as_tuple(operation.backward(
        np.ones_like(answer[0]), *sample.inputs, **sample.attributes))
    names, defaults = options(operation)
    return {
        "equation": operation.equation, "text": explain(operation),
        "arguments": list(operation.arguments), "options": names, "defaults": defaults,
        "outputs": output_names(operation, operation.name, len(answer)),
        "gradients": gradients and output_names(operation, f"{operation.name}_backward",
                                                len(gradients))}


def mistakes(value: Any, schema: dict[str, Any] = SCHEMA, where: str = "") -> Iterator[str]:
    """What in a JSON value contradicts a schema, of the words of JSON Schema that SCHEMA has.

    >>> list(mistakes({"a": -1}, _object({"a": COUNT, "b": WORD})))
    ["found no 'b', needed it", 'a: found -1, needed at least 0']
    """
    start, kinds = f"{where}: " if where else "", schema.get("type", [])
    kinds = [kinds] if isinstance(kinds, str) else kinds
    if kinds and not any(_is(value, kind) for kind in kinds):
        yield f"{start}found {_shown(value)}, needed {' or '.join(kinds)}"
    elif "const" in schema and json.dumps(value) != json.dumps(schema["const"]):
        yield f"{start}found {_shown(value)}, needed {_shown(schema['const'])}"
    elif value not in schema.get("enum", [value]):
        yield f"{start}found {_shown(value)}, needed one of {', '.join(schema['enum'])}"
    elif isinstance(value, dict):
        yield from _of_object(value, schema, where, start)
    elif isinstance(value, list):
        if len(value) < schema.get("minItems", 0):
            yield f"{start}found {len(value)} items, needed at least {schema['minItems']}"
        for number, item in enumerate(value):
            yield from mistakes(item, schema.get("items", {}), f"{where}[{number}]")
    elif isinstance(value, str):
        if not re.search(schema.get("pattern", ""), value):
            yield f"{start}found {_shown(value)}, needed {schema['pattern']}"
    elif isinstance(value, (int, float)):
        for word, needed, holds in BOUNDS:
            if word in schema and not holds(value, schema[word]):
                yield f"{start}found {_shown(value)}, needed {needed} {schema[word]}"


def _shown(value):
    return json.dumps(value)[:60]


def _is(value, kind):
    if kind in ("integer", "number"):
        return type(value) is int or (kind == "number" and type(value) is float)
    return isinstance(value, TYPES[kind])


def _of_object(value, schema, where, start):
    for key in schema.get("required", ()):
        if key not in value:
            yield f"{start}found no {key!r}, needed it"
    known, rest = schema.get("properties", {}), schema.get("additionalProperties", {})
    for key, item in value.items():
        if key not in known and rest is False:
            yield f"{start}found {key!r}, needed {', '.join(known)}"
        else:
            yield from mistakes(item, known.get(key, rest), f"{where}.{key}".lstrip("."))
    forms = [form["required"] for form in schema.get("oneOf", ())]
    if forms and sum(all(key in value for key in form) for form in forms) != 1:
        yield f"{start}needed either {' or '.join(', '.join(form) for form in forms)}"


def _once(pairs):
    """A JSON object whose keys all differ."""
    for key, times in Counter(key for key, _ in pairs).items():
        if times > 1:
            raise ValueError(f"the key {key!r} stands {times} times in an object")
    return dict(pairs)


def _no_number(text):
    """What is said of NaN and the infinities, with the line of the first."""
    def _refuse(word):
        before = re.split(r"[:,\[]\s*-?(?:NaN|Infinity)\s*[,\]}]", text)[0]
        raise ValueError(f"{word} is no number: line {before.count(chr(10)) + 1}")
    return _refuse


def read_manifest(folder: str | Path) -> dict[str, Any]:
    """manifest.json of a folder: strict JSON of this format and version.   Raises FormatError."""
    path = Path(folder) / "manifest.json"
    if not path.is_file():
        raise FormatError(f"{path}: found no such file, needed the manifest that `refimpl export` "
                          "writes last; was the export cut short?")
    text = ""
    try:
        text = path.read_text(encoding="utf-8")
        manifest = json.loads(text, object_pairs_hook=_once, parse_constant=_no_number(text))
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{path}: found no strict JSON ({str(error)[:120]}), needed the manifest "
                          "that `refimpl export` wrote") from None
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
        raise FormatError(f"{path}: found no object whose format is {FORMAT!r}, needed the "
                          "manifest that `refimpl export` wrote")
    version = manifest.get("version")
    if type(version) is not int or version != VERSION:
        raise FormatError(f"{path}: found version {str(version)[:20]} of {FORMAT}, needed version "
                          f"{VERSION}; export it again with this release")
    return manifest
