"""Training that survives: after every epoch everything needed to go on is in one file, written
whole or not at all.

A run that was killed and resumed on the same processor ends with the same bits as one that was
never interrupted: parameters and moments are stored exactly, and an epoch's random numbers depend
on the seed and the epoch alone. On another processor, whose BLAS adds up in another order, the
training data come out with other last digits; then it goes on too, and whoever resumes is told.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import hashlib
import json
import math
import os
from pathlib import Path
from typing import Any

import numpy as np

from ..storage import FormatError, load_npz, save_npz
from ..holden2017.train import Record, State

VERSION = 2
NEAR = 1e-4                    # how near the summaries of one run's data lie on any processor


@dataclass(frozen=True)
class Run:
    """What a training run is known by.

    settings : a word that differs when the settings or the shapes of the data differ;  bits : one
    that differs when a bit of the data does;  summary : mean, spread and a weighted mean of each
    array
    """

    settings: str
    bits: str
    summary: np.ndarray = field(repr=False)


def fingerprint(settings: Any, *arrays: np.ndarray) -> Run:
    """What a run with these settings and data is known by.   settings : plain values   ->  Run"""
    words = hashlib.sha256(json.dumps(settings, sort_keys=True).encode())
    data, numbers = hashlib.sha256(), []
    for array in arrays:
        words.update(f"{array.dtype} {array.shape}".encode())
        data.update(np.ascontiguousarray(array).data)
        wide = array.astype(float).ravel()
        spread = float(wide.std()) if wide.size else 0.0
        weighted = float(wide @ np.cos(np.arange(wide.size))) / max(wide.size, 1)
        numbers.append([float(wide.mean()) if wide.size else 0.0, spread, weighted])
    return Run(words.hexdigest(), data.hexdigest(), np.array(numbers).reshape(-1, 3))


def save_checkpoint(path: str | Path, state: State, records: Sequence[Record], run: Run) -> None:
    """Write where a run stands.

    state : after an epoch;  records : one for every epoch so far;  run : of `fingerprint`
    """
    groups = (("p", state.params), ("m", state.adam["m"]), ("v", state.adam["v"]))
    arrays = {f"{kind} {name}": array for kind, group in groups for name, array in group.items()}
    save_npz(path, "checkpoint", VERSION, {**arrays, "summary": run.summary},
             {"epoch": state.epoch, "steps": state.adam["t"], "names": list(state.params),
              "settings": run.settings, "bits": run.bits,
              "records": json.dumps([vars(r) for r in records])})


def load_checkpoint(path: str | Path, run: Run, like: Mapping[str, np.ndarray],
                    epochs: int) -> tuple[State, list[Record], bool]:
    """Read where a run stood.

    run : of `fingerprint`;  like : parameters of the shapes and types that it must hold;
    epochs : of the whole run
    ->  State, list of Record, whether the data are the same to the last bit
    Raises FormatError when it belongs to a run with other settings or other data, or is damaged.
    """
    arrays, facts = load_npz(
        path, "checkpoint", VERSION, ("summary",),
        {"epoch": int, "steps": int, "names": list, "settings": str, "bits": str, "records": str})
    if facts["settings"] != run.settings or not _near(arrays["summary"], run.summary):
        raise FormatError(
            f"{path}: found a checkpoint of a run with other settings or other data, needed the "
            "same; resume with the words it was started with, or leave --resume out: then it is "
            "kept under another name and training begins anew")
    if facts["names"] != list(like):
        raise FormatError(
            f"{path}: found parameters {', '.join(facts['names'])[:80]}, needed {', '.join(like)}")
    for key, name in [(f"{kind} {name}", name) for kind in "pmv" for name in like]:
        array, wanted = arrays.get(key), like[name]
        if (array is None or array.shape != wanted.shape or array.dtype != wanted.dtype
                or not np.isfinite(array).all()):
            raise FormatError(
                f"{path}: found {name} missing, of another shape or type or not finite, needed "
                f"finite numbers {wanted.dtype} {wanted.shape}")
    records = _records(path, facts["records"])
    if (not 1 <= facts["epoch"] <= epochs or facts["epoch"] != len(records)
            or not 1 <= facts["steps"] < 2 ** 53):
        raise FormatError(
            f"{path}: found {str(facts['epoch'])[:20]} epochs with {len(records)} records and "
            f"{str(facts['steps'])[:20]} steps, needed numbers of one training of {epochs} epochs")
    params, m, v = ({name: arrays[f"{kind} {name}"] for name in like} for kind in "pmv")
    return (State(params, {"t": facts["steps"], "m": m, "v": v}, facts["epoch"]), records,
            facts["bits"] == run.bits)


def set_aside(path: str | Path) -> Path | None:
    """Give a file the first free name of PATH.1, PATH.2 ... and return it; None without a file."""
    path, number = Path(path), 1
    if not os.path.lexists(path):
        return None
    while os.path.lexists(f"{path}.{number}"):
        number += 1
    return path.rename(f"{path}.{number}")


def _near(found, needed):
    """Whether two summaries are those of one data set, computed on whatever processor."""
    if found.shape != needed.shape or found.dtype.kind != "f":
        return False
    scale = np.abs(needed).max(axis=1, keepdims=True, initial=0.0)
    return bool((np.abs(found - needed) <= NEAR * scale).all())


def _records(path, text):
    try:
        records = [Record(**r) for r in json.loads(text)]
        good = all(type(r.epoch) is int and isinstance(r.losses, dict)
                   and all(map(_is_number, (r.gradient_norm, r.seconds, *r.losses.values())))
                   for r in records)
    except (ValueError, TypeError, RecursionError):
        good = False
    if not good:
        raise FormatError(
            f"{path}: found damaged records of its epochs, needed those that training wrote")
    return records


def _is_number(value):
    return type(value) in (int, float) and math.isfinite(value)
