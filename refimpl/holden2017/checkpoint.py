"""Training that survives: after every epoch everything needed to go on is in one file, written whole or not at all.

A run that was killed and resumed ends with the same bits as one that was never interrupted: parameters and moments are stored exactly, and an epoch's random
numbers depend on the seed and the epoch alone.
"""

import hashlib
import json

import numpy as np

from ..storage import FormatError, load_npz, save_npz
from .train import Record, State

VERSION = 1


def fingerprint(settings, *arrays):
    """A word that differs when the settings or the data differ.   settings : plain values   ->  str"""
    digest = hashlib.sha256(json.dumps(settings, sort_keys=True).encode())
    for array in arrays:
        digest.update(f"{array.dtype} {array.shape}".encode())
        digest.update(np.ascontiguousarray(array))
    return digest.hexdigest()


def save_checkpoint(path, state, records, print_of_run):
    """state : State, records : list of Record so far, print_of_run : of `fingerprint`"""
    arrays = {f"{kind} {name}": array for kind, group in (("p", state.params), ("m", state.adam["m"]), ("v", state.adam["v"])) for name, array in group.items()}
    save_npz(path, "checkpoint", VERSION, arrays,
             {"epoch": state.epoch, "steps": state.adam["t"], "names": list(state.params), "run": print_of_run, "records": json.dumps([vars(r) for r in records])})


def load_checkpoint(path, print_of_run):
    """->  State, list of Record.   Raises FormatError when it belongs to a run with other settings or other data."""
    arrays, facts = load_npz(path, "checkpoint", VERSION, (), {"epoch": int, "steps": int, "names": list, "run": str, "records": str})
    if facts["run"] != print_of_run:
        raise FormatError(f"{path}: found a checkpoint of a run with other settings or other data, needed the same; "
                          "resume with the words it was started with, or delete it to begin anew")
    groups = [{name: arrays.get(f"{kind} {name}") for name in facts["names"]} for kind in "pmv"]
    if any(array is None for group in groups for array in group.values()):
        raise FormatError(f"{path}: found a checkpoint with parameters missing, needed all of {', '.join(facts['names'])}")
    params, m, v = groups
    return State(params, {"t": facts["steps"], "m": m, "v": v}, facts["epoch"]), [Record(**r) for r in json.loads(facts["records"])]
