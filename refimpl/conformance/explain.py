"""What a backend must offer for one operation: arguments, shapes, units, defaults, and what to hold
to."""

from collections.abc import Callable
import inspect
import textwrap

import numpy as np

from ..gradcheck.report import columns
from ..holden2016 import losses, rows
from ..motion.features import FORWARD, SIDEWAYS, TURN
from ..motion.joints import BONES, FEET, SLOTS
from .backend import OPERATIONS, TOLERANCES
from .cases import generator
from .specification import Operation
from .rivals import RIVALS

# Whose arrays are the 66 numbers.
MOTION = ("foot_loss", "bone_loss", "trajectory_loss", "total_loss", "facing_direction",
          "floor_height", "foot_contacts", "planted_feet", "extended", "motion_to_numbers",
          "numbers_to_motion", "motion_windows", "normaliser", "train_transformation_network")
MOTION_2016 = ("foot_loss_2016", "bone_loss_2016", "trajectory_loss_2016", "style_search_2016")


def explain(operation: Operation) -> list[str]:
    """The lines that `refimpl check --explain OPERATION` prints.   ->  list of str"""
    lines = [f"{operation.name}    {operation.equation}".rstrip(), ""]
    lines += [f"    {operation.name}{signature(operation)}", *_indented(operation.f), ""]
    lines += _sample(operation)
    if operation.backward:
        lines += ["", f"Its gradient: {operation.name}_backward(upstream gradient, the same "
                  "arguments), which returns a gradient for each array,",
                  "in the order of the arguments, of its shape and precision (None where an array "
                  "was None or is a constant).", *_indented(operation.backward)]
    if operation.name in MOTION:
        lines += ["", *_joints()]
    if operation.name in MOTION_2016:
        lines += ["", *_joints_2016()]
    lines += ["", *_how_near(operation), *_refused(operation)]
    for function in (operation.name, f"{operation.name}_backward"):
        if function in RIVALS:
            lines += [f"Conventions of others that {function} is held against:",
                      *(f"    {label}" for label, _ in RIVALS[function])]
    return lines


def listed() -> list[str]:
    """A line for each operation: its name, its gradient's, and its equation or else where the
    reference stands.

    >>> listed()[0].split(maxsplit=2)
    ['conv1d', 'conv1d_backward', 'the * of equations 1 and 2']
    """
    rows = [[name, f"{name}_backward" if operation.backward else "-",
             operation.equation or f"{operation.f.__module__}.{operation.f.__name__}"]
            for name, operation in OPERATIONS.items()]
    return columns(rows, "<")


def signature(operation: Operation) -> str:
    """Names and defaults as Python writes them, without types.

    >>> from refimpl.conformance import OPERATIONS
    >>> signature(OPERATIONS["avg_depool1d"])
    '(h, width=2)'
    """
    parameters = [p.replace(annotation=inspect.Parameter.empty)
                  for p in inspect.signature(operation.f).parameters.values()]
    if any(p.kind is p.VAR_POSITIONAL for p in parameters):
        # A network's arrays one after the other.
        names = [inspect.Parameter(n, inspect.Parameter.POSITIONAL_OR_KEYWORD)
                 for n in operation.arguments]
        rest = [p for p in parameters if p.kind is p.KEYWORD_ONLY]
        parameters = names + rest
    return str(inspect.Signature(parameters))


def documentation(function: Callable) -> str:
    """A function's docstring without its examples, "" where it has none.

    >>> documentation(signature).splitlines()
    ['Names and defaults as Python writes them, without types.']
    """
    return (inspect.getdoc(function) or "").split("\n>>> ")[0].rstrip()


def _indented(function):
    return textwrap.indent(documentation(function), "        ").splitlines()


def _sample(operation):
    """Shapes and types of the first sample's inputs and outputs."""
    sample = operation.samples(generator(operation, 0))[0]
    lines = ["As the kit's first case calls it:"]
    for name, value in zip(operation.arguments, sample.inputs):
        lines.append(f"    {name:12} {_kind(value)}")
    lines += [f"    {name + '=':12} {_kind(value)}" for name, value in sample.attributes.items()]
    outputs = operation.f(*sample.inputs, **sample.attributes)
    for number, value in enumerate(outputs if isinstance(outputs, tuple) else (outputs,)):
        lines.append(f"    {'->' if not number else '':12} {_kind(np.asarray(value))}")
    return lines


def _kind(value):
    return f"{value.dtype} {value.shape}" if isinstance(value, np.ndarray) else repr(value)


def _how_near(operation):
    bounds = " and ".join(f"{TOLERANCES[p] * operation.tolerance:g} in {p}"
                          for p in operation.precisions)
    lines = [f"How near: {bounds}, of what an element sums: the size of its terms, with that of",
             "its clip and channel; unless the backend declares its own. Choices and copies are "
             "exact."]
    if operation.whole_range:
        lines.append("It is right wherever the answer can be written: nothing overflows or "
                     "vanishes on the way to it.")
    return [*lines, "An answer has the precision of its inputs." if "float32" in
            operation.precisions else "It is tried in float64 alone.",
            "It is new: inputs are left as they are, and no later call changes it."]


def _refused(operation):
    """What is no input, by the argument that an error has to be about."""
    labels: dict[str, list[str]] = {}
    for bad in operation.bad():
        labels.setdefault(bad.argument, []).append(bad.label)
    return ["To be refused is what does not fit, such as"] * bool(labels) + [
        line for name, said in labels.items()
        for line in textwrap.wrap(f"{name}: {', '.join(said)}", 96, initial_indent="    ",
                                  subsequent_indent="        ")]


def _joints():
    """The layout of the 66 numbers, and which rows the feet and bones are."""
    lines = ["The 66 numbers of a frame: x, y, z (sideways, up, forward) of 21 joints in the "
             "file's unit of length,",
             f"then row {TURN} turn (radians a frame), row {FORWARD} forward and row {SIDEWAYS} "
             "sideways (length a frame).", "Joints, three rows each:", *_slots()]
    lines += [_feet(), "Bones (order of lengths):", *_bones(BONES)]
    return lines


def _joints_2016():
    """The same for the 73 numbers of the 2016 code."""
    joints = rows.POSITIONS.start
    lines = [f"The 73 numbers of a frame: rows {joints} to {rows.POSITIONS.stop - 1} x, y, z of 21 "
             f"joints, behind three of a reference joint; rows {rows.VELOCITY.start}",
             f"sideways, {rows.VELOCITY.stop - 1} forward, {rows.TURN} minus the turn, from the "
             "frame to the next; then four contacts. Joints:", *_slots(), _feet(),
             "Bones:", *_bones(losses.BONES), "Their lengths:"]
    return lines + _wrapped([f"{length:.2f}" for length in losses.LENGTHS])


def _slots():
    return _wrapped([f"{j} {slot}" for j, slot in enumerate(SLOTS)])


def _feet():
    return "Feet (rows of contacts): " + ", ".join(f"{j} {SLOTS[j]}" for j in FEET)


def _bones(bones):
    return _wrapped([f"{a}-{b}" for a, b in bones])


def _wrapped(words):
    return textwrap.wrap(", ".join(words), 96, initial_indent="    ", subsequent_indent="    ")
