"""Golden vectors: inputs and outputs as files that can be read without Python.

A folder holds `manifest.json` and, for each case, `vectors/NAME.npz`: a zip of `.npy` arrays,
stored without compression, little-endian, in C order (the .npy format is a one-line text header
before the numbers). Inputs are stored, never seeds: random streams change, numbers do not.

The manifest holds the SHA-256 of every file, and of itself: of its JSON text without the key
"sha256", keys sorted, no spaces, ASCII. A folder that is not as it was exported certifies nothing:
`read_folder` says what is wrong and hands out no case.
"""

from collections.abc import Iterable
import hashlib
import json
import math
import os
from pathlib import Path
import re
import stat
from typing import Any

import numpy as np

from .. import __version__
from ..nn.conventions import CONVENTIONS
from ..storage import FormatError, atomic_write, read_arrays
from .backend import LOOSEST, OPERATIONS, TOLERANCES, nearest, reference
from .calls import EXACT, Case
from .cases import cases

FORMAT, VERSION = "golden vectors", 2
KEYS = {"id": str, "operation": str, "function": str, "equation": str, "precision": str,
        "file": str, "sha256": str, "arguments": list, "attributes": dict, "outputs": list}


def export(folder: str | Path, *, seed: int = 0, operations: Iterable[str] | None = None) -> int:
    """Write all cases that have outputs.   ->  number of cases

    Everything is written before the manifest, which is written last and whole: a folder with a
    manifest is complete. Vectors of an earlier export that are no part of this one are taken away;
    other files stay.
    """
    folder = Path(folder)
    (folder / "vectors").mkdir(parents=True, exist_ok=True)
    earlier = _listed(folder)
    Path(os.path.realpath(folder / "manifest.json")).unlink(missing_ok=True)
    entries = [_write_case(folder, case)
               for case in cases(seed=seed, operations=operations, profile="small")
               if case.kind in ("float64", "float32", "empty batch")]
    for name in earlier - {entry["file"] for entry in entries}:
        (folder / name).unlink(missing_ok=True)
    manifest = {
        "format": FORMAT, "version": VERSION, "made_by": f"refimpl {__version__}",
        "arrays": "(clips, channels, frames); filters (outputs, inputs / groups, width)",
        "bound": "largest difference allowed, in units of the largest element of the expected "
                 "array (of 1 where all are 0)",
        "conventions": [{"where": c.where, "here": c.here,
                         "rivals": [f"{r}: {who}" for r, who in c.rivals]} for c in CONVENTIONS],
        "cases": entries}
    with atomic_write(folder / "manifest.json") as file:
        json.dump({**manifest, "sha256": manifest_hash(manifest)}, file, indent=1)
        file.write("\n")
    return len(entries)


def _listed(folder):
    """The vectors of an export that stands in the folder already."""
    try:
        entries = read_manifest(folder)["cases"]
    except FormatError:
        return set()
    return {e["file"] for e in entries if isinstance(e, dict) and _is_vector(e.get("file"))}


def _is_vector(name):
    return isinstance(name, str) and bool(re.fullmatch(r"vectors/[a-z0-9-]+\.npz", name))


def manifest_hash(manifest: dict[str, Any]) -> str:
    """SHA-256 of a manifest without its own key "sha256", however its text is laid out."""
    rest = {key: value for key, value in manifest.items() if key != "sha256"}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def _write_case(folder, case):
    """Write a case's vectors.   ->  its entry in the manifest"""
    arrays: dict[str, Any] = {}

    def _stored(label, value, **more):
        if not isinstance(value, np.ndarray):
            return {**more, "value": list(value) if isinstance(value, tuple) else value}
        arrays[label] = np.asarray(value, dtype=value.dtype.newbyteorder("<"), order="C")
        return {**more, "array": label}
    entry = {
        "id": case.id, "operation": case.operation.name, "function": case.function,
        "equation": case.operation.equation, "precision": case.precision, "file": "", "sha256": "",
        "arguments": [_stored(f"in{number}", value, name=name) for number, (name, value)
                      in enumerate(zip(case.names, case.arguments))],
        "attributes": {key: _stored(f"attribute_{key}", value)
                       for key, value in case.attributes.items()},
        "outputs": [None if value is None else
                    {**_stored(f"out{number}", value), "shape": list(value.shape), "bound": bound}
                    for number, (value, bound) in enumerate(zip(case.expected, case.bounds()))]}
    name = re.sub(r"[^a-z0-9]+", "-", case.id.lower()).strip("-")
    path = folder / "vectors" / f"{name}.npz"
    with atomic_write(path, "wb") as file:
        np.savez(file, **arrays)
    entry["file"] = f"vectors/{path.name}"
    entry["sha256"] = hashlib.sha256(path.read_bytes()).hexdigest()
    return entry


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
    entries, functions = manifest["cases"], reference().functions
    wrong = [f"manifest.json, case {number}: {what}" for number, entry in enumerate(entries)
             for what in _complaints(entry, functions)]
    if not wrong:
        for key in ("id", "file"):
            names = [entry[key].lower() for entry in entries]
            wrong += [f"manifest.json: found {key} {name!r} {names.count(name)} times, needed it "
                      "once" for name in dict.fromkeys(names) if names.count(name) > 1]
    if manifest.get("sha256") != manifest_hash(manifest):
        wrong.append("manifest.json: is not the one that was exported, its SHA-256 differs; export "
                     "again")
    if wrong:
        return [], wrong
    wrong += _unlisted(folder, {entry["file"] for entry in entries})
    found = []
    for entry in entries:
        try:
            found.append(_read_case(folder, entry))
        except (OSError, ValueError) as error:
            wrong.append(f"{entry['id']}: {entry['file']}: {error}")
    return found, wrong


def _once(pairs):
    """A JSON object whose keys all differ."""
    if len(dict(pairs)) != len(pairs):
        raise ValueError("a key stands twice in an object")
    return dict(pairs)


def _no_number(word):
    raise ValueError(f"{word} is no number")


def read_manifest(folder: str | Path) -> dict[str, Any]:
    """manifest.json of a folder: strict JSON of this format and version.   Raises FormatError."""
    path = Path(folder) / "manifest.json"
    if not path.is_file():
        raise FormatError(f"{path}: found no such file, needed the manifest that `refimpl export` "
                          "writes last; was the export cut short?")
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"), object_pairs_hook=_once,
                              parse_constant=_no_number)
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{path}: found no strict JSON ({str(error)[:120]}), needed the manifest "
                          "that `refimpl export` wrote") from None
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT or not isinstance(
            manifest.get("cases"), list):
        raise FormatError(f"{path}: found no manifest of {FORMAT}, needed one that `refimpl "
                          "export` wrote")
    version = manifest.get("version")
    if type(version) is not int or version != VERSION:
        raise FormatError(f"{path}: found version {str(version)[:20]} of {FORMAT}, needed version "
                          f"{VERSION}; export it again with this release")
    return manifest


def _complaints(entry, functions):
    """What an entry of the manifest lacks, or has that it should not."""
    if not isinstance(entry, dict) or set(entry) != set(KEYS):
        return [f"found {sorted(entry) if isinstance(entry, dict) else type(entry).__name__}, "
                f"needed {', '.join(KEYS)}"]
    wrong = [f"{key}: found {type(entry[key]).__name__}, needed {kind.__name__}"
             for key, kind in KEYS.items() if type(entry[key]) is not kind]
    if wrong:
        return wrong
    function, operation = entry["function"], OPERATIONS.get(entry["operation"])
    if operation is None or function not in functions or function not in (
            operation.name, f"{operation.name}_backward"):
        near = nearest(function, functions)
        return [f"function: found {function!r} of operation {entry['operation']!r}, needed one of "
                "this package's" + (f"; {near}?" if near else "")]
    if entry["precision"] not in TOLERANCES:
        wrong.append(f"precision: found {entry['precision']!r}, needed {' or '.join(TOLERANCES)}")
    if not _is_vector(entry["file"]):
        wrong.append(f"file: found {entry['file']!r}, needed vectors/NAME.npz inside the folder")
    upstream = ("upstream gradient",) * function.endswith("_backward")
    expected = list(upstream + operation.arguments)
    names = [given.get("name") if isinstance(given, dict) else None for given in entry["arguments"]]
    if names != expected[:len(names)]:
        wrong.append(f"arguments: found {names}, needed {expected}, in this order")
    if not all(isinstance(given, dict) and len(set(given) & {"array", "value"}) == 1
               and isinstance(given.get("array", ""), str)
               for given in [*entry["arguments"], *entry["attributes"].values()]):
        wrong.append("arguments, attributes: needed for each either the name of an array or a "
                     "value")
    wrong += [f"output {number}: {what}" for number, output in enumerate(entry["outputs"])
              if output is not None for what in _output_complaints(output)]
    if not any(output is not None for output in entry["outputs"]):
        wrong.append("outputs: found none, needed at least one")
    return wrong


def _output_complaints(output):
    if not isinstance(output, dict) or set(output) != {"array", "shape", "bound"}:
        return ["found something else than array, shape and bound"]
    bound, shape = output["bound"], output["shape"]
    wrong = []
    if not isinstance(bound, float) or not math.isfinite(bound) or not 0 < bound <= LOOSEST:
        wrong.append(f"bound: found {repr(bound)[:40]}, needed a number above 0 and up to "
                     f"{LOOSEST}")
    if not isinstance(shape, list) or not all(type(n) is int and n >= 0 for n in shape):
        wrong.append(f"shape: found {repr(shape)[:40]}, needed whole numbers")
    return wrong


def _unlisted(folder, listed):
    """Files in the folder of vectors that the manifest does not know."""
    try:
        found = sorted(os.listdir(folder / "vectors"))
    except OSError as error:
        return [f"vectors: cannot be listed ({error.strerror})"]
    return [f"vectors/{name}: found a file that the manifest does not list" for name in found
            if f"vectors/{name}" not in listed]


def _read_case(folder, entry):
    """An entry and its arrays as a Case.   Raises ValueError, OSError."""
    path = folder / entry["file"]
    if not stat.S_ISREG(os.lstat(path).st_mode):
        raise ValueError("is no plain file")
    data = path.read_bytes()
    if hashlib.sha256(data).hexdigest() != entry["sha256"]:
        raise ValueError("is not the file that was exported, its SHA-256 differs")
    arrays, outputs = read_arrays(data), entry["outputs"]
    names = sorted(given["array"] for given in (
        *entry["arguments"], *entry["attributes"].values(), *filter(None, outputs))
        if "array" in given)
    if names != sorted(arrays):
        raise ValueError(f"holds {', '.join(sorted(arrays))}, needed {', '.join(names)}")
    if any(array.dtype.kind not in "fiub" or not array.flags.c_contiguous
           for array in arrays.values()):
        raise ValueError("holds an array that is not of real numbers in C order")
    for output in filter(None, outputs):
        shape = list(arrays[output["array"]].shape)
        if shape != output["shape"]:
            raise ValueError(f"{output['array']} has shape {shape}, needed {output['shape']}")
    operation = OPERATIONS[entry["operation"]]
    base = TOLERANCES[entry["precision"]] * operation.tolerance
    bounds = [output["bound"] if output else base for output in outputs]
    exact = all(output is None or output["bound"] == EXACT for output in outputs)
    if not exact and min(bounds) < base:
        raise ValueError(f"has a bound of {min(bounds):.3g}, needed at least {base:.3g}")

    def _value(given):
        if "array" in given:
            return arrays[given["array"]]
        return tuple(given["value"]) if isinstance(given["value"], list) else given["value"]
    return Case(entry["id"], operation, entry["function"], entry["id"].rsplit("/", 1)[-1],
                tuple(map(_value, entry["arguments"])),
                {key: _value(given) for key, given in entry["attributes"].items()},
                tuple(output and arrays[output["array"]] for output in outputs), exact=exact,
                allowed=() if exact else tuple(bounds), folder=str(folder),
                single=entry["precision"] == "float32")
