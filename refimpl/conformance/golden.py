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
from .cases import EXACT, Case, cases

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
    records = [_write_case(folder, case) for case in cases(seed=seed, operations=operations)
               if case.kind in ("float64", "float32", "empty batch")]
    for name in earlier - {record["file"] for record in records}:
        (folder / name).unlink(missing_ok=True)
    manifest = {
        "format": FORMAT, "version": VERSION, "made_by": f"refimpl {__version__}",
        "arrays": "(clips, channels, frames); filters (outputs, inputs / groups, width)",
        "bound": "largest difference allowed, in units of the largest element of the expected "
                 "array (of 1 where all are 0)",
        "conventions": [{"where": c.where, "here": c.here,
                         "rivals": [f"{r}: {who}" for r, who in c.rivals]} for c in CONVENTIONS],
        "cases": records}
    with atomic_write(folder / "manifest.json") as file:
        json.dump({**manifest, "sha256": manifest_hash(manifest)}, file, indent=1)
        file.write("\n")
    return len(records)


def _listed(folder):
    """The vectors of an export that stands in the folder already."""
    try:
        records = read_manifest(folder)["cases"]
    except FormatError:
        return set()
    return {r["file"] for r in records if isinstance(r, dict) and _is_vector(r.get("file"))}


def _is_vector(name):
    return isinstance(name, str) and bool(re.fullmatch(r"vectors/[a-z0-9-]+\.npz", name))


def manifest_hash(manifest: dict[str, Any]) -> str:
    """SHA-256 of a manifest without its own key "sha256", however its text is laid out."""
    rest = {key: value for key, value in manifest.items() if key != "sha256"}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def _write_case(folder, case):
    name = re.sub(r"[^a-z0-9]+", "-", case.id.lower()).strip("-")
    arrays, arguments, attributes = {}, [], {}
    for number, value in enumerate(case.arguments):
        label = case.names[number]
        if isinstance(value, np.ndarray):
            arrays[f"in{number}"] = _little_endian(value)
            arguments.append({"name": label, "array": f"in{number}"})
        else:
            arguments.append({"name": label, "value": value})
    for key, value in case.attributes.items():
        if isinstance(value, np.ndarray):
            arrays[f"attribute_{key}"] = _little_endian(value)
            attributes[key] = {"array": f"attribute_{key}"}
        else:
            attributes[key] = {"value": list(value) if isinstance(value, tuple) else value}
    outputs = []
    for number, value in enumerate(case.expected):
        if value is None:
            outputs.append(None)
            continue
        arrays[f"out{number}"] = _little_endian(value)
        outputs.append({"array": f"out{number}", "shape": list(value.shape),
                        "bound": case.bounds()[number]})
    path = folder / "vectors" / f"{name}.npz"
    with atomic_write(path, "wb") as file:
        np.savez(file, **arrays)
    return {"id": case.id, "operation": case.operation.name, "function": case.function,
            "equation": case.operation.equation, "precision": case.precision,
            "file": f"vectors/{path.name}", "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
            "arguments": arguments, "attributes": attributes, "outputs": outputs}


def _little_endian(array):
    return np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<")).reshape(array.shape)


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
    records, wrong = manifest["cases"], []
    functions = reference().functions
    for number, record in enumerate(records):
        label = f"manifest.json, case {number}"
        wrong += [f"{label}: {what}" for what in _complaints(record, functions)]
    if not wrong:
        for key in ("id", "file"):
            names = [record[key].lower() for record in records]
            wrong += [f"manifest.json: found {key} {name!r} {names.count(name)} times, needed it "
                      "once" for name in dict.fromkeys(names) if names.count(name) > 1]
    if manifest.get("sha256") != manifest_hash(manifest):
        wrong.append("manifest.json: is not the one that was exported, its SHA-256 differs; export "
                     "again")
    if wrong:
        return [], wrong
    wrong += _unlisted(folder, {record["file"] for record in records})
    found = []
    for record in records:
        try:
            found.append(_read_case(folder, record))
        except (OSError, ValueError) as error:
            wrong.append(f"{record['id']}: {record['file']}: {error}")
    return found, wrong


def _once(pairs):
    """A JSON object whose keys all differ."""
    found = dict(pairs)
    if len(found) != len(pairs):
        raise ValueError("a key stands twice in an object")
    return found


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


def _complaints(record, functions):
    """What a record lacks, or has that it should not."""
    if not isinstance(record, dict) or set(record) != set(KEYS):
        return [f"found {sorted(record) if isinstance(record, dict) else type(record).__name__}, "
                f"needed {', '.join(KEYS)}"]
    wrong = [f"{key}: found {type(record[key]).__name__}, needed {kind.__name__}"
             for key, kind in KEYS.items() if type(record[key]) is not kind]
    if wrong:
        return wrong
    operation = OPERATIONS.get(record["operation"])
    if operation is None or record["function"] not in functions or record["function"] not in (
            operation.name, f"{operation.name}_backward"):
        near = nearest(record["function"], functions)
        return [f"function: found {record['function']!r} of operation {record['operation']!r}, "
                "needed one of this package's" + (f"; {near}?" if near else "")]
    if record["precision"] not in TOLERANCES:
        wrong.append(f"precision: found {record['precision']!r}, needed {' or '.join(TOLERANCES)}")
    if not _is_vector(record["file"]):
        wrong.append(f"file: found {record['file']!r}, needed vectors/NAME.npz inside the folder")
    upstream = ("upstream gradient",) * record["function"].endswith("_backward")
    names = [entry.get("name") if isinstance(entry, dict) else None
             for entry in record["arguments"]]
    if tuple(names) != (upstream + operation.arguments)[:len(names)]:
        wrong.append(f"arguments: found {names}, needed {list(upstream + operation.arguments)}, in "
                     "this order")
    entries = [*record["arguments"], *record["attributes"].values()]
    if not all(isinstance(entry, dict) and len(set(entry) & {"array", "value"}) == 1
               and isinstance(entry.get("array", ""), str) for entry in entries):
        wrong.append("arguments, attributes: needed for each either the name of an array or a "
                     "value")
    for number, output in enumerate(record["outputs"]):
        if output is not None:
            wrong += [f"output {number}: {what}" for what in _output_complaints(output)]
    if not any(output is not None for output in record["outputs"]):
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


def _read_case(folder, record):
    """A record and its arrays as a Case.   Raises ValueError, OSError."""
    path = folder / record["file"]
    if not stat.S_ISREG(os.lstat(path).st_mode):
        raise ValueError("is no plain file")
    data = path.read_bytes()
    if hashlib.sha256(data).hexdigest() != record["sha256"]:
        raise ValueError("is not the file that was exported, its SHA-256 differs")
    arrays = read_arrays(data)
    entries = [*record["arguments"], *record["attributes"].values(),
               *filter(None, record["outputs"])]
    names = [entry["array"] for entry in entries if "array" in entry]
    if sorted(names) != sorted(arrays):
        raise ValueError(f"holds {', '.join(sorted(arrays))}, needed {', '.join(sorted(names))}")
    if any(array.dtype.kind not in "fiub" or not array.flags.c_contiguous
           for array in arrays.values()):
        raise ValueError("holds an array that is not of real numbers in C order")
    for output in filter(None, record["outputs"]):
        if list(arrays[output["array"]].shape) != output["shape"]:
            raise ValueError(f"{output['array']} has shape {list(arrays[output['array']].shape)}, "
                             f"needed {output['shape']}")
    operation, single = OPERATIONS[record["operation"]], record["precision"] == "float32"
    base = TOLERANCES[record["precision"]] * operation.tolerance
    allowed = [output["bound"] if output else base for output in record["outputs"]]
    exact = all(output is None or output["bound"] == EXACT for output in record["outputs"])
    if not exact and min(allowed) < base:
        raise ValueError(f"has a bound of {min(allowed):.3g}, needed at least {base:.3g}")
    arguments = tuple(arrays[e["array"]] if "array" in e else e["value"]
                      for e in record["arguments"])
    attributes = {key: arrays[e["array"]] if "array" in e else _attribute(e["value"])
                  for key, e in record["attributes"].items()}
    expected = tuple(None if output is None else arrays[output["array"]]
                     for output in record["outputs"])
    kind = record["id"].rsplit("/", 1)[-1]
    return Case(record["id"], operation, record["function"], kind, arguments, attributes, expected,
                exact=exact, sensitivity=tuple(bound - base for bound in allowed), folder=str(folder),
                single=single)


def _attribute(value):
    return tuple(value) if isinstance(value, list) else value
