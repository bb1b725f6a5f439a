"""A file to fill in: every operation as a function that is not written yet."""

from collections.abc import Iterable
import inspect
import textwrap

from .backend import OPERATIONS
from .explain import documentation, signature

# What is said at the top of the file, and what it imports.
HEADS = {
    "numpy": ("with their gradients", "import numpy as np"),
    "torch": ("for tensors; autograd makes the gradients",
              "import torch\n\nfrom refimpl.adapters.torch import backend"),
    "jax": ("for JAX's arrays; jax.vjp makes the gradients",
            "import jax\nfrom jax import numpy as jnp\n\nfrom refimpl.adapters.jax import backend")}
OPENING = '''"""The operations of refimpl, to be written {}.

`refimpl check stub:BACKEND` judges those that are written; while one ends in NotImplementedError it
counts as not offered. `refimpl check --explain OPERATION` tells what it is held to.
"""

{}'''


def stub(library: str, operations: Iterable[str] | None = None) -> str:
    """The text of a backend in which nothing is written yet.

    library : "numpy", "torch" or "jax";  operations : names to limit it to

    >>> stub("numpy", ["l1"]).count("raise NotImplementedError")
    2
    """
    functions = []
    for operation in (OPERATIONS[name] for name in operations or OPERATIONS):
        functions.append((operation.name, signature(operation), operation.f))
        if library == "numpy" and operation.backward:
            upstream = next(iter(inspect.signature(operation.backward).parameters))
            functions.append((f"{operation.name}_backward",
                              signature(operation).replace("(", f"({upstream}, ", 1),
                              operation.backward))
    pair = '"{0}": {0}' if library == "numpy" else "{0}={0}"
    offered = textwrap.indent(",\n".join(pair.format(name) for name, _, _ in functions), "    ")
    made = f"{{\n{offered}}}" if library == "numpy" else f"backend(\n{offered})"
    return "\n\n\n".join([OPENING.format(*HEADS[library]), *(_function(*f) for f in functions),
                          f"BACKEND = {made}\n"])


def _function(name, arguments, reference):
    lines = textwrap.wrap(f"def {name}{arguments}:", 100, subsequent_indent=" " * (len(name) + 5))
    text = documentation(reference)
    end = "\n" if "\n" in text or len(text) > 89 else ""
    quoted = textwrap.indent(f'"""{text}{end}"""', "    ")
    return "\n".join([*lines, quoted, "    raise NotImplementedError"])
