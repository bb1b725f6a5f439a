"""A case as files: case.json says what is to be computed, .npy files hold its arrays.

It is what golden vectors are made of, and what a program is asked by.
"""

from collections.abc import Iterable
import inspect
import io
import json
import math
from typing import Any

import numpy as np

from ..gradcheck.difference import largest
from .calls import EXACT, Case
from .specification import Operation

# Names of several outputs, in their order.
OUTPUTS = {
    "adam_step": "p m v", "space_time_interpolation": "angles root",
    "principal_components": "mean basis coefficients",
    "support_vector_regression": "objective predictions",
    "one_stage_segmentation": "cost fragments ends costs", "best_pair": "pair alpha style error",
    "motion_to_numbers": "numbers start", "motion_windows": "features contacts",
    "normaliser": "mean deviation", "train_loss_network": "W0 b0 losses",
    "train_transformation_network": "W1 b1 W2 b2 W3 b3 losses",
    "style_search_2016": "result after_style before_tail"}


def options(operation: Operation) -> tuple[list[str], dict[str, Any]]:
    """Names of an operation's keyword arguments, and what stands for each input that is left out.

    >>> from refimpl.conformance import OPERATIONS
    >>> options(OPERATIONS["search_loss_2016"])
    (['content', 'gram', 'amount'], {'amount': 0.1})
    """
    parameters = [p for p in inspect.signature(operation.f).parameters.values()
                  if p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)]
    return ([p.name for p in parameters if p.name not in operation.arguments],
            {p.name: p.default for p in parameters if p.default is not p.empty})


def output_names(operation: Operation, function: str, count: int) -> list[str]:
    """What the outputs of an operation's function, or of its gradient, are called.

    >>> from refimpl.conformance import OPERATIONS
    >>> output_names(OPERATIONS["conv1d"], "conv1d_backward", 3)
    ['gradient of x', 'gradient of w', 'gradient of b']
    """
    if function != operation.name:
        return [f"gradient of {name}" for name in operation.arguments[:count]]
    names = OUTPUTS.get(function, "").split()
    return names if len(names) == count else [
        f"output {number}" if count > 1 else "output" for number in range(count)]


def described(case: Case) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """What case.json says of a call, every input and option of it, and its arrays by their names
    there."""
    arrays: dict[str, np.ndarray] = {}

    def _stored(label, value):
        if isinstance(value, float) and not math.isfinite(value):
            value = np.float64(value)                            # JSON has no such number
        if not isinstance(value, (np.ndarray, np.generic)):
            return {"value": value}
        arrays[label] = _plain(value)
        return {"array": label, "dtype": str(value.dtype), "shape": list(value.shape)}
    names, defaults = options(case.operation)
    unsaid = {name: {"value": value, "default": True} for name, value in defaults.items()
              if name not in case.attributes}
    arguments = [{"name": name, **_stored(f"in{number}", value)}
                 for number, (name, value) in enumerate(zip(case.names, case.arguments))]
    arguments += [{"name": name, **unsaid[name]}
                  for name in case.names[len(arguments):] if name in unsaid]
    attributes = {name: _stored(f"attribute_{name}", value)
                  for name, value in case.attributes.items()}
    attributes |= {name: unsaid[name] for name in names if name in unsaid}
    return {"id": case.id, "operation": case.operation.name, "function": case.function,
            "equation": case.operation.equation, "precision": case.precision, "exact": case.exact,
            "arguments": arguments, "attributes": attributes, "outputs": _outputs(case)}, arrays


def _plain(value):
    return np.asarray(value, dtype=value.dtype.newbyteorder("<"), order="C")


def _outputs(case):
    """Names and types of the outputs; of a call that must be refused no type is known."""
    if case.expected is None:
        return [{"name": "output", "array": "out0"}]
    return [None if y is None else {
        "name": name, "array": f"out{number}",
        "dtype": case.precision if y.dtype.kind == "f" else str(y.dtype)} for number, (name, y) in
        enumerate(zip(output_names(case.operation, case.function, len(case.expected)),
                      case.expected))]


def with_answers(entry: dict[str, Any], arrays: dict[str, np.ndarray],
                 answers: Iterable[tuple]) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """The same with what must come of the call.

    entry, arrays : of `described`;  answers : for each output the array and how far each of its
    elements may be off (None, None where there is none)
    """
    outputs, arrays = [], dict(arrays)
    for number, (output, (y, allowed)) in enumerate(zip(entry["outputs"], answers)):
        if y is not None:
            allowed = np.broadcast_to(allowed, y.shape).astype("<f8", order="C")
            arrays |= {f"out{number}": _plain(y), f"allowed{number}": allowed}
            output = {**output, "shape": list(y.shape), "allowed": f"allowed{number}",
                      "bound": max(EXACT, float(allowed.max(initial=0.0)) / (largest(y) or 1.0))}
        outputs.append(output)
    return {**entry, "outputs": outputs}, arrays


def case_files(entry: dict[str, Any], arrays: dict[str, np.ndarray]) -> dict[str, bytes]:
    """The files of a case's folder.   entry, arrays : as above   ->  {name: bytes}"""
    lines = ",\n".join(f" {json.dumps(key)}: {json.dumps(entry[key])}" for key in entry)
    return {"case.json": f"{{\n{lines}\n}}\n".encode("ascii"),
            **{f"{label}.npy": _npy(array) for label, array in arrays.items()}}


def _npy(array):
    file = io.BytesIO()
    np.lib.format.write_array(file, array, version=(1, 0), allow_pickle=False)
    return file.getvalue()


def read_npy(data: bytes) -> np.ndarray:
    """The array of the bytes of a .npy file of real numbers, little-endian, in C order.

    Raises ValueError for anything else.

    >>> read_npy(_npy(np.eye(2)))
    array([[1., 0.],
           [0., 1.]])
    """
    file = io.BytesIO(data)
    try:
        version = np.lib.format.read_magic(file)
        shape, fortran, dtype = {(1, 0): np.lib.format.read_array_header_1_0,
                                 (2, 0): np.lib.format.read_array_header_2_0}[version](file)
    except Exception as error:                                   # of some ten kinds
        raise ValueError(f"found no header of .npy 1.0 or 2.0 ({str(error)[:60]!r})") from None
    if fortran or dtype.kind not in "fiub" or dtype.byteorder == ">":
        raise ValueError(f"found {dtype.str}{', Fortran order' * fortran}, needed real numbers, "
                         "little-endian, in C order")
    if file.tell() + math.prod(shape) * dtype.itemsize != len(data):
        raise ValueError(f"found {len(data) - file.tell()} bytes of numbers, needed "
                         f"{math.prod(shape) * dtype.itemsize} for {dtype.str} {shape}")
    return np.frombuffer(data, dtype, offset=file.tell()).reshape(shape).copy()
