"""What a backend's function must keep, whatever it computes."""

import numpy as np

from ..gradcheck.contract import copies, mixture, nonlinearity, same_bits, sharing
from .backend import ask
from .comparison import Difference, call, output_name


def _left_alone(case, backend):
    """Read-only arguments too."""
    call(case, backend)
    call(case, backend, writeable=False)


def _same_bits(case, backend):
    """A state that other calls leave behind would show, and a buffer that is used again."""
    first = call(case, backend)
    kept = [None if a is None else a.copy() for a in first]
    for arguments, attributes in case.others:
        ask(backend.functions[case.function], arguments, attributes)
    _compare_bits(case, kept, first, "in the arrays of the first answer after other calls",
                  "a buffer that is used again")
    _compare_bits(case, kept, call(case, backend), "on a second call with the same arguments",
                  "another answer on a second call")


def _compare_bits(case, kept, found, when, what):
    for number, (a, b) in enumerate(zip(kept, found)):
        if a is not None and not same_bits(a, b):
            raise Difference(f"{output_name(case, number)}: found other bits {when} ({what})", what,
                             "the same bits on every call")


def _own_memory(case, backend):
    call(case, backend)
    arguments, attributes = case.fresh()
    outputs = ask(backend.functions[case.function], arguments, attributes)
    others = [*zip(case.names, arguments), *attributes.items()]
    for number, out in enumerate(outputs):
        label = output_name(case, number)
        for name in sharing(out, others):
            raise Difference(f"{label}: shares memory with {name}, needed memory of its own",
                             f"memory of {name}", "memory of its own")
        if out is not None and not out.flags.writeable:
            raise Difference(f"{label}: is read-only (np.broadcast_to?), needed memory of its own",
                             "read-only", "memory of its own")
        others.append((f"the {label}", out))


def _linear(case, backend):
    upstream = case.arguments[0]
    other = np.cos(3.0 * np.arange(upstream.size)).reshape(upstream.shape).astype(upstream.dtype)
    first, second, mixed = (call(case, backend, dy) for dy in (
        upstream, other, mixture(upstream, other).astype(upstream.dtype)))
    bound = 10 * backend.tolerances[case.precision] * case.operation.tolerance
    for number, (a, b, both) in enumerate(zip(first, second, mixed)):
        if a is not None:
            size = max(np.abs(a).max(initial=0), np.abs(b).max(initial=0)) or 1.0
            off = nonlinearity(a, b, both) / size
            if not off <= bound:
                raise Difference(f"{output_name(case, number)}: is not linear in the upstream "
                                 f"gradient (off by {off:.3g} of the largest element)",
                                 float(off), float(bound))


def _anew(case, backend):
    """The same arrays with other numbers in them: what was remembered of the first would show."""
    call(case, backend)
    function = backend.functions[case.function]
    for other, given in case.others:
        arguments, attributes = case.fresh()
        if [np.shape(a) for a in other] != [np.shape(a) for a in arguments]:
            continue
        expected = ask(function, copies(other), dict(zip(given, copies(given.values()))))
        ask(function, arguments, attributes)
        for a, b in zip(arguments, other):
            if isinstance(a, np.ndarray):
                a[...] = b
        found = ask(function, arguments, dict(zip(given, copies(given.values()))))
        _compare_bits(case, expected, found,
                      "for arrays whose numbers were changed since the last call",
                      "what it had kept of an earlier call")


CHECKS = {"leaves its inputs alone": _left_alone, "same bits twice": _same_bits,
          "memory of its own": _own_memory, "reads its arguments anew": _anew,
          "linear in the upstream gradient": _linear}
