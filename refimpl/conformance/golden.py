"""Golden vectors: inputs and outputs as files that can be read without Python.

A folder holds `manifest.json` and, for each case, `vectors/NAME.npz`: a zip of `.npy` arrays, stored without compression, little-endian, in C order
(the .npy format is a one-line text header before the numbers). Inputs are stored, never seeds: random streams change, numbers do not.
"""

import hashlib
import json
from pathlib import Path
import re

import numpy as np

from .. import __version__
from ..nn.conventions import CONVENTIONS
from ..storage import FormatError, atomic_write
from .backend import TOLERANCES
from .cases import PROMISES, cases
from .record import as_tuple, relative_difference

FORMAT, VERSION = "golden vectors", 1


def export(folder, *, seed=0, operations=None):
    """Write all cases that have outputs.   ->  number of cases

    Everything is written before the manifest, which is written last and whole: a folder with a manifest is complete.
    """
    folder = Path(folder)
    (folder / "vectors").mkdir(parents=True, exist_ok=True)
    records = [_write_case(folder, case) for case in cases(seed=seed, operations=operations)
               if case.kind in ("float64", "float32", "empty batch") and case.kind not in PROMISES]
    manifest = {"format": FORMAT, "version": VERSION, "made_by": f"refimpl {__version__}",
                "arrays": "(clips, channels, frames); filters (outputs, inputs / groups, width)",
                "bound": "largest difference allowed, in units of the largest element of the expected array (of 1 where all are 0)",
                "conventions": [{"where": c.where, "here": c.here, "rivals": [f"{r}: {who}" for r, who in c.rivals]} for c in CONVENTIONS], "cases": records}
    with atomic_write(folder / "manifest.json") as file:
        json.dump(manifest, file, indent=1)
        file.write("\n")
    return len(records)


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
            attributes[key] = {"value": value}
    outputs = []
    for number, value in enumerate(case.expected):
        if value is not None:
            arrays[f"out{number}"] = _little_endian(value)
        bound = 1e-15 if case.exact else TOLERANCES[case.precision] * case.operation.tolerance + (case.slack[number] if case.slack else 0.0)
        outputs.append({"array": f"out{number}", "shape": list(value.shape), "bound": bound} if value is not None else None)
    path = folder / "vectors" / f"{name}.npz"
    with atomic_write(path, "wb") as file:
        np.savez(file, **arrays)
    return {"id": case.id, "operation": case.operation.name, "function": case.function, "equation": case.operation.equation, "precision": case.precision,
            "file": f"vectors/{path.name}", "sha256": hashlib.sha256(path.read_bytes()).hexdigest(), "arguments": arguments, "attributes": attributes,
            "outputs": outputs}


def _little_endian(array):
    return np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<")).reshape(array.shape)


def verify(folder, functions):
    """Read a folder back and hold functions against it.

    functions : {name: callable}, the reference's own or a backend's   ->  yields (case id, message), message "" where all is well
    Raises FormatError when the folder is no such folder.
    """
    folder = Path(folder)
    for record in read_manifest(folder)["cases"]:
        yield record["id"], _verify_case(folder, record, functions)


def read_manifest(folder):
    """manifest.json of a folder, checked.   ->  dict"""
    path = Path(folder) / "manifest.json"
    if not path.is_file():
        raise FormatError(f"{path}: found no such file, needed the manifest that `refimpl export` writes last; was the export cut short?")
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
        good = manifest["format"] == FORMAT and manifest["version"] == VERSION and isinstance(manifest["cases"], list)
    except (ValueError, KeyError, TypeError):
        good = False
    if not good:
        raise FormatError(f"{path}: found no manifest of version {VERSION} of {FORMAT}, needed one that `refimpl export` wrote")
    return manifest


def _verify_case(folder, record, functions):
    try:
        path = folder / record["file"]
        if not path.resolve().is_relative_to(folder.resolve()):
            return f"names the file {record['file']!r}, which lies outside the folder"
        data = path.read_bytes()
        if hashlib.sha256(data).hexdigest() != record["sha256"]:
            return f"{record['file']} is not the file that was exported: its SHA-256 differs"
        if record["function"] not in functions:
            return ""
        with np.load(path, allow_pickle=False) as arrays:
            arguments = [arrays[a["array"]] if "array" in a else a["value"] for a in record["arguments"]]
            attributes = {k: arrays[a["array"]] if "array" in a else _attribute(a["value"]) for k, a in record["attributes"].items()}
            wanted = [None if o is None else arrays[o["array"]] for o in record["outputs"]]
        with np.errstate(all="ignore"):
            found = as_tuple(functions[record["function"]](*arguments, **attributes))
        return _compare(found, wanted, [o and o["bound"] for o in record["outputs"]])
    except (OSError, ValueError, KeyError, TypeError) as error:
        return f"{type(error).__name__}: {error}"


def _attribute(value):
    return tuple(value) if isinstance(value, list) else value


def _compare(found, wanted, bounds):
    if len(found) != len(wanted):
        return f"found {len(found)} outputs, needed {len(wanted)}"
    for number, (a, b, bound) in enumerate(zip(found, wanted, bounds)):
        if b is None:
            continue
        if a is None or a.shape != b.shape:
            return f"output {number}: found shape {getattr(a, 'shape', None)}, needed {b.shape}"
        off = relative_difference(a, b).max(initial=0.0)
        if off > bound:
            return f"output {number}: differs by {off:.3g} of the largest element, allowed {bound:.1g}"
    return ""
