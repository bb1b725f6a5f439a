r"""Golden vectors: inputs and answers as files that can be read without Python.

    manifest.json          all cases, and what the words of a case mean; written last, so that a
                           folder that has it is complete
    manifest.schema.json   the JSON Schema (draft 2020-12) that it satisfies
    README.txt             this text
    vectors/NAME/          a case: case.json, inputs (in0.npy, attribute_bones.npy ...), answers
                           (out0.npy ...) and how far each element may be off (allowed0.npy ...)
    vectors/NAME.npz       the same arrays in one file: a zip, without compression, of those .npy

A case names a function (an operation, or its gradient with _backward behind the name), its inputs
and what must come of them:

    arguments    in their order: {"name": "x", "array": "in0", "dtype": "float64", "shape": [2, 9]},
                 whose numbers are in in0.npy, or {"name": "width", "value": 2, "default": true}. A
                 gradient takes the upstream gradient first. A number that JSON has not (NaN, an
                 infinity) is an array of shape [].
    attributes   the options by name, given in the same way. None is left out: those that a caller
                 need not give have "default": true.
    outputs      in their order: name, array, dtype and shape that an answer must have, and the
                 array that it is judged by. null: there is none, as the gradient of what is null.
                 Expected answers are in float64 even where an answer must be in float32.

In manifest.json "allowed", "bound" and "exact" say how an answer is judged; "operations" has for
each operation its formula, arguments, options with their defaults, and the names of its outputs and
gradients; "constants" what the formulas name; "conventions" what is done where the mathematics
leaves a choice. The folder holds inputs, never seeds: random streams change, numbers do not.

A .npy file has the bytes 93 4E 55 4D 50 59 01 00, two bytes with the length of a header (all
numbers are little-endian), the header, such as

    {'descr': '<f8', 'fortran_order': False, 'shape': (2, 3, 9), }

filled up with spaces and a line feed, and the numbers, last axis fastest: <f8, <f4 floating point,
<i8, <i4 ... and |u1 whole numbers, |b1 a byte of 0 or 1. The shape () is that of one number.
case.json has a key a line and ": " and ", " between what it holds: whoever has no parser may look
for "stride": {"value": .

"files" holds the SHA-256 of every file, "sha256" of a case that of its .npz. The last "sha256" is
that of manifest.json itself with 64 zeros in its place. A folder that is not as it was exported
certifies nothing: `refimpl check --golden` says what is wrong, and computes the answers and what
they are allowed again. Other files may lie beside these four, none below vectors.
"""

from collections import Counter
from collections.abc import Callable, Iterable
import contextlib
import hashlib
import io
import json
import os
from pathlib import Path
import re
import stat
from typing import Any

import numpy as np

from .. import __version__
from ..gradcheck.difference import largest
from ..storage import FormatError, atomic_write, read_arrays
from .backend import OPERATIONS, nearest, reference
from .calls import Case
from .cases import answerable, known_operation
from .schema import FORMAT, PROTOCOL, SCHEMA, VERSION, facts, mistakes, read_manifest
from .vectors import case_files, described, options, with_answers

ZEROS = 64 * "0"
MADE_BY = f"refimpl {__version__}"


def export(folder: str | Path, *, seed: int = 0, operations: Iterable[str] | None = None,
           report: Callable[[str], Any] = lambda operation: None) -> int:
    """Write all cases that have outputs.   ->  number of cases

    Everything is written before the manifest, which is written last and whole. Vectors of an
    earlier export that are no part of this one are taken away; other files stay.
    report : called with each operation when its cases are written
    Raises FormatError where a README.txt or manifest stands that no export wrote.
    """
    folder, names = Path(folder), list(OPERATIONS if operations is None else operations)
    for name in names:
        known_operation(name)
    for name, mark in (("manifest.json", f'"{FORMAT}"'), ("README.txt", str(__doc__)[:14]),
                       ("manifest.schema.json", FORMAT)):
        if (folder / name).is_file() and mark not in (folder / name).read_text(
                encoding="utf-8", errors="replace")[:200]:
            raise FormatError(f"{folder / name}: found a file that no export wrote, needed a place "
                              "without one; nothing was written")
    (folder / "vectors").mkdir(parents=True, exist_ok=True)
    earlier = _listed(folder)
    Path(os.path.realpath(folder / "manifest.json")).unlink(missing_ok=True)
    entries = []
    for name in names:
        entries += [_write_case(folder, case) for case in answerable(seed, [name])]
        report(name)
    for name in earlier - {name for entry in entries for name in _files(entry)}:
        (folder / name).unlink(missing_ok=True)
        with contextlib.suppress(OSError):                       # other files may lie there
            (folder / name).parent.rmdir()
    for name, data in texts().items():
        _write(folder / name, data)
    manifest = {"format": FORMAT, "version": VERSION, "made_by": MADE_BY, **facts(),
                "cases": entries,
                "files": {name: _hash(data) for name, data in texts().items()}, "sha256": ZEROS}
    text = json.dumps(manifest, indent=1) + "\n"
    text = text.replace(ZEROS, manifest_hash(text, ZEROS))
    _write(folder / "manifest.json", text.encode("ascii"))
    return len(entries)


def texts() -> dict[str, bytes]:
    """The files of a folder that are the same in each of this release.   ->  {name: content}"""
    return {"README.txt": f"{__doc__}\nAnother program is judged by `refimpl check --command`.\n\n"
            f"{PROTOCOL}\n".encode("ascii"),
            "manifest.schema.json": f"{json.dumps(SCHEMA, indent=1)}\n".encode("ascii")}


def _write(path, data):
    with atomic_write(path, "wb") as file:
        file.write(data)


def _hash(data):
    return hashlib.sha256(data).hexdigest()


def manifest_hash(text: str, stated: str) -> str:
    """SHA-256 of the text of a manifest with zeros in the place of the hash that it states."""
    return _hash(text.replace(stated, ZEROS).encode("utf-8"))


def _files(entry):
    """What the manifest lists for a case.   ->  {name: SHA-256}"""
    return {entry["file"]: entry["sha256"],
            **{f"{entry['folder']}/{name}": digest for name, digest in entry["files"].items()}}


def _listed(folder):
    """The vectors of an export that stands in the folder already."""
    try:
        found = [name for entry in read_manifest(folder)["cases"] for name in _files(entry)]
    except (FormatError, LookupError, TypeError, AttributeError):
        return set()
    return {name for name in found if re.fullmatch(
        r"vectors/[a-z0-9-]+(\.npz|/\w+\.(npy|json))", str(name))}


def _write_case(folder, case):
    """Write a case's vectors.   ->  its entry in the manifest"""
    entry, arrays = with_answers(*described(case), zip(case.expected, case.allowances()))
    place = f"vectors/{re.sub(r'[^a-z0-9]+', '-', case.id.lower()).strip('-')}"
    (folder / place).mkdir(exist_ok=True)
    files = case_files(entry, arrays)
    for name, data in files.items():
        (folder / place / name).write_bytes(data)
    archive = io.BytesIO()
    np.savez(archive, **arrays)                                  # type: ignore[arg-type]
    _write(folder / f"{place}.npz", archive.getvalue())
    return {**entry, "folder": place, "file": f"{place}.npz", "sha256": _hash(archive.getvalue()),
            "files": {name: _hash(data) for name, data in files.items()}}


def golden_case(folder: str, identity: str) -> Case:
    """One case of a folder, to look at a failure.   Raises FormatError, ValueError."""
    found, wrong = read_folder(folder)
    for case in found:
        if case.id == identity:
            return case
    raise ValueError(f"{folder}: found no case {identity!r}, needed an id of its manifest"
                     + (f"; {wrong[0]}" if wrong else ""))


def read_folder(folder: str | Path) -> tuple[list[Case], list[str]]:
    """A folder's cases, for `judge_all`, and what is wrong with the folder.

    ->  cases (none where the manifest is not the exported one), complaints
    Raises FormatError when the folder is no such folder at all.
    """
    folder = Path(folder)
    manifest = read_manifest(folder)
    wrong = [f"manifest.json: {_with_id(what, manifest)}" for what in mistakes(manifest)]
    if not wrong:
        entries = manifest["cases"]
        text = (folder / "manifest.json").read_text(encoding="utf-8")
        wrong += [f"manifest.json: {entry['id']}: {what}" for entry in entries
                  for what in _complaints(entry)]
        for key in ("id", "folder", "file"):
            names = Counter(entry[key].lower() for entry in entries)
            wrong += [f"manifest.json: found {key} {name!r} {count} times, needed it once"
                      for name, count in names.items() if count > 1]
        if manifest["sha256"] != manifest_hash(text, manifest["sha256"]):
            wrong.append("manifest.json: is not the one that was exported, its SHA-256 differs; "
                         "export again")
    if wrong:
        return [], wrong
    wrong += _unlisted(folder, {name for entry in entries for name in _files(entry)})
    found = []
    for entry in entries:
        try:
            found.append(_read_case(folder, entry))
        except (OSError, ValueError, TypeError) as error:
            wrong.append(f"{entry['id']}: {error}")
    for name, digest in manifest["files"].items():
        try:
            _exported(folder, name, digest)
        except (OSError, ValueError) as error:
            wrong.append(str(error))
    return found, wrong


def _with_id(what, manifest):
    """What the schema says of a case, with the case's id where it has one."""
    place = re.match(r"cases\[(\d+)\]", what)
    entry = manifest["cases"][int(place[1])] if place else {}
    identity = entry.get("id") if isinstance(entry, dict) else None
    return f"{what} ({identity})" if isinstance(identity, str) else what


def _complaints(entry):
    """What in an entry that satisfies the schema is not of this package."""
    function, operation = entry["function"], OPERATIONS.get(entry["operation"])
    functions = reference().functions
    if operation is None or function not in functions or function not in (
            operation.name, f"{operation.name}_backward"):
        near = nearest(function, functions)
        return [f"function: found {function!r} of operation {entry['operation']!r}, needed one of "
                "this package's" + (f"; {near}?" if near else "")]
    upstream = ["upstream gradient"] * function.endswith("_backward")
    wrong = [f"{key}: found {found}, needed {needed}" for key, found, needed in (
        ("arguments", [given["name"] for given in entry["arguments"]],
         [*upstream, *operation.arguments]),
        ("attributes", sorted(entry["attributes"]), sorted(options(operation)[0])),
        ("file", entry["file"], f"{entry['folder']}.npz"),
        ("files", sorted(entry["files"]), sorted(
            ["case.json", *(f"{label}.npy" for label in _labels(entry))]))) if found != needed]
    if not any(entry["outputs"]):
        wrong.append("outputs: found none, needed at least one")
    return wrong


def _labels(entry):
    """Names of a case's arrays."""
    outputs = [output for output in entry["outputs"] if output]
    given = [*entry["arguments"], *entry["attributes"].values(), *outputs]
    return [*(item["array"] for item in given if "array" in item),
            *(output["allowed"] for output in outputs)]


def _unlisted(folder, listed):
    """What the folder of vectors holds that the manifest does not know, and links of folders."""
    found: list[str] = []
    known = listed | {os.path.dirname(name) for name in listed}
    for place, folders, files in os.walk(folder / "vectors", onerror=lambda error: found.append(
            f"{error.filename}: {error.strerror}, needed a folder whose files can be listed")):
        for path in (Path(place, name) for name in (*files, *folders)):
            name = path.relative_to(folder).as_posix()
            if name not in known or (name not in listed and path.is_symlink()):
                found.append(f"{name}: found what the manifest does not list")
    return sorted(found)


def _exported(folder, name, digest):
    """The bytes of a file that is as it was exported.   Raises ValueError, OSError."""
    path = folder / name
    if not stat.S_ISREG(os.lstat(path).st_mode):
        raise ValueError(f"{name}: is no plain file")
    data = path.read_bytes()
    if _hash(data) != digest:
        raise ValueError(f"{name}: is not the file that was exported, its SHA-256 differs")
    return data


def _read_case(folder, entry):
    """An entry and its arrays as a Case: what this case would be written as is what was read.

    Raises ValueError, OSError.
    """
    stored = {name: _exported(folder, name, digest) for name, digest in _files(entry).items()}
    archive, outputs = entry["file"], entry["outputs"]
    arrays = read_arrays(stored.pop(archive))
    if sorted(arrays) != sorted(_labels(entry)):
        raise ValueError(f"{archive}: found {', '.join(sorted(arrays))}, needed "
                         f"{', '.join(_labels(entry))}")
    if not all(a.flags.c_contiguous and a.dtype.kind in "fiub" for a in arrays.values()):
        raise ValueError(f"{archive}: holds an array that is not of real numbers in C order")

    def _value(given):
        return arrays[given["array"]] if "array" in given else _tuples(given["value"])
    answers: list[Any] = [(None, None) if output is None else (
        arrays[output["array"]], arrays[output["allowed"]]) for output in outputs]
    case = Case(entry["id"], OPERATIONS[entry["operation"]], entry["function"],
                entry["id"].rsplit("/", 1)[-1],
                tuple(_value(given) for given in entry["arguments"] if "default" not in given),
                {key: _value(given) for key, given in entry["attributes"].items()
                 if "default" not in given}, tuple(y for y, _ in answers), exact=entry["exact"],
                allowed=tuple(y is None or allowed / (largest(y) or 1.0) for y, allowed in answers),
                folder=str(folder), single=entry["precision"] == "float32")
    for (y, allowed), needed in zip(answers, case.allowances()):
        if y is not None and not ((allowed >= 0).all() and (
                not case.exact or np.allclose(allowed, needed, 1e-9, 0))):
            raise ValueError(f"{archive}: found another allowance than what is exact may have")
    again, plain = with_answers(*described(case), answers)
    again["equation"] = entry["equation"]
    for key, value in again.items():
        if json.dumps(value) != json.dumps(entry[key]):          # 1 is not 1.0, nor true
            raise ValueError(f"{archive}: {key} in the manifest is not that of its arrays")
    for name, data in case_files(again, plain).items():
        if stored[f"{entry['folder']}/{name}"] != data:
            raise ValueError(f"{entry['folder']}/{name}: is not what the manifest and {archive} "
                             "say")
    return case


def _tuples(value):
    return tuple(map(_tuples, value)) if isinstance(value, list) else value
