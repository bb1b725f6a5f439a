"""Compare a backend's outputs with the reference's, element by element, and say which convention it follows where they differ."""

from dataclasses import dataclass

import numpy as np

from .backend import as_backend, is_expected_failure
from .record import as_tuple, relative_difference
from .rivals import RIVALS


@dataclass(frozen=True)
class Outcome:
    """The verdict on one case. status : passed, failed, skipped, xfailed (an expected failure) or xpassed (one that passed)."""

    case: object
    status: str
    message: str = ""
    worst: dict = None
    rival: str = ""
    difference: float = 0.0


EXACT = 1e-15                                                    # where a rule decides and nothing is rounded


class Difference(Exception):
    """What is wrong with a result; carries the worst element."""

    def __init__(self, message, **worst):
        super().__init__(message)
        self.worst = worst


def judge_all(backend, chosen, expected_failures=()):
    """Outcomes of all cases, in order.   backend : whatever `as_backend` takes"""
    backend = as_backend(backend)
    for case in chosen:
        outcome = judge(case, backend)
        if is_expected_failure(case.id, expected_failures) and outcome.status in ("passed", "failed"):
            outcome = Outcome(case, "xfailed" if outcome.status == "failed" else "xpassed", outcome.message, outcome.worst, outcome.rival)
        yield outcome


def judge(case, backend):
    """->  Outcome of one case"""
    backend = as_backend(backend)
    if case.function not in backend.functions:
        return Outcome(case, "skipped", f"{backend.name} has no {case.function}")
    try:
        with np.errstate(all="ignore"):
            difference = _try(case, backend)
    except Difference as wrong:
        rival = follows(case, backend)
        lines = [f"{case.id}: {wrong}"] + ([f"It matches {rival}."] if rival else []) + [_reproduction(case, backend)]
        return Outcome(case, "failed", "\n".join(lines), wrong.worst, rival)
    except Exception as error:                                   # a backend may raise anything; that is a failure of its own
        return Outcome(case, "failed", f"{case.id}: raised {type(error).__name__}: {str(error)[:300]}\n{_reproduction(case, backend)}")
    return Outcome(case, "passed", difference=difference or 0.0)


def _try(case, backend):
    if case.kind == "refused":
        return _refused(case, backend)
    if case.kind in _PROMISES:
        return _PROMISES[case.kind](case, backend)
    return compare(case.call(backend), case, tolerance(case, backend))


def tolerance(case, backend):
    return backend.tolerances[case.precision] * case.operation.tolerance


def compare(found, case, allowed):
    """Raise Difference unless all outputs have the expected shape, type and values.   ->  largest difference relative to the largest element"""
    if len(found) != len(case.expected):
        raise Difference(f"found {len(found)} outputs, needed {len(case.expected)}")
    largest = 0.0
    for number, (got, wanted) in enumerate(zip(found, case.expected)):
        label = _output_name(case, number)
        if wanted is None or got is None:
            if wanted is not None:
                raise Difference(f"{label}: found None, needed an array of shape {wanted.shape}")
            continue
        slack = case.slack[number] if case.slack else 0.0
        largest = max(largest, _compare_arrays(label, got, np.asarray(wanted), allowed + slack, case))
    return largest


def _output_name(case, number):
    if case.function.endswith("_backward"):
        names = case.operation.arguments
        return f"gradient of {names[number] if number < len(names) else number}"
    return "output" if len(case.expected) == 1 else f"output {number}"


def _compare_arrays(label, got, wanted, allowed, case):
    if got.shape != wanted.shape:
        raise Difference(f"{label}: found shape {got.shape}, needed {wanted.shape}")
    dtype = np.dtype(case.precision) if wanted.dtype.kind == "f" else wanted.dtype
    if got.dtype != dtype and not (dtype.kind in "iu" and got.dtype.kind in "iu"):
        raise Difference(f"{label}: found dtype {got.dtype}, needed {dtype}")
    if not wanted.size:
        return 0.0
    off = relative_difference(got, wanted)
    worst = np.unravel_index(np.argmax(off), off.shape)
    allowed = EXACT if case.exact else allowed
    if off[worst] > allowed:
        index = [int(i) for i in worst]
        raise Difference(f"{label}, worst at {index}: got {float(got[worst]):.17g}, wanted {float(wanted[worst]):.17g} "
                         f"({off[worst]:.3g} of the largest element, allowed {allowed:.1g}; {int((off > allowed).sum())} of {off.size} elements differ)",
                         output=label, index=index, got=float(got[worst]), wanted=float(wanted[worst]), relative=float(off[worst]))
    return float(off[worst])


def _refused(case, backend):
    try:
        case.call(backend)
    except ValueError as error:
        if backend.name == "refimpl" and not str(error).startswith(case.argument + ":"):
            raise Difference(f"refused with {str(error)!r}, needed a message that names {case.argument!r} first") from None
        return
    except Exception:                                            # another implementation may refuse in its own way
        if backend.name == "refimpl":
            raise
        return
    raise Difference(f"was accepted, needed an error about {case.argument}")


def _left_alone(case, backend):
    for writeable in (True, False):
        arguments = tuple(a.copy() if isinstance(a, np.ndarray) else a for a in case.arguments)
        for a in arguments:
            if isinstance(a, np.ndarray):
                a.flags.writeable = writeable
        as_tuple(backend.functions[case.function](*arguments, **case.attributes))
        for name, before, after in zip(case.names, case.arguments, arguments):
            if isinstance(before, np.ndarray) and before.tobytes() != after.tobytes():
                raise Difference(f"changed its argument {name}, needed to leave it alone")


def _same_bits(case, backend):
    first = [None if a is None else a.copy() for a in case.call(backend)]
    other = tuple(a + 1 if isinstance(a, np.ndarray) and a.dtype.kind == "f" else a for a in case.arguments)
    as_tuple(backend.functions[case.function](*other, **case.attributes))    # a state that another call leaves behind would show
    for number, (a, b) in enumerate(zip(first, case.call(backend))):
        if a is not None and (a.shape != b.shape or a.tobytes() != b.tobytes()):
            raise Difference(f"{_output_name(case, number)}: found other bits on a second call with the same arguments")


def _own_memory(case, backend):
    for number, out in enumerate(case.call(backend)):
        for name, a in zip(case.names, case.arguments):
            if isinstance(a, np.ndarray) and out is not None and np.shares_memory(out, a):
                raise Difference(f"{_output_name(case, number)}: shares memory with {name}, needed memory of its own")


def _linear(case, backend):
    upstream, *rest = case.arguments
    other = np.cos(3.0 * np.arange(upstream.size)).reshape(upstream.shape)
    function = backend.functions[case.function]
    first, second = case.call(backend), as_tuple(function(other, *rest, **case.attributes))
    mixed = as_tuple(function(1.7 * upstream - 0.6 * other, *rest, **case.attributes))
    for number, (a, b, both) in enumerate(zip(first, second, mixed)):
        if a is not None:
            size = max(np.abs(a).max(initial=0), np.abs(b).max(initial=0)) or 1.0
            off = np.abs(1.7 * a - 0.6 * b - both).max(initial=0) / size
            if not off <= 10 * tolerance(case, backend):
                raise Difference(f"{_output_name(case, number)}: is not linear in the upstream gradient (off by {off:.3g} of the largest element)")


_PROMISES = {"leaves its inputs alone": _left_alone, "same bits twice": _same_bits, "memory of its own": _own_memory,
             "linear in the upstream gradient": _linear}


@np.errstate(all="ignore")
def follows(case, backend):
    """The rival convention whose outputs the backend's equal, with how nearly; "" when none fits."""
    if case.kind == "refused" or case.kind in _PROMISES:
        return ""
    try:
        found = case.call(backend)
    except Exception:
        return ""
    for label, rival in RIVALS.get(case.function, ()):
        try:
            expected = as_tuple(rival(*case.arguments, **case.attributes))
            if len(expected) != len(found):
                continue
            off = [_distance(a, b) for a, b in zip(found, expected)]
        except (ValueError, TypeError, IndexError):
            continue
        if max(off, default=np.inf) <= max(tolerance(case, backend), 1e-15):
            return f"{label}, to {max(off):.0e}"
    return ""


def _distance(a, b):
    if a is None or b is None:
        return 0.0 if a is b else np.inf
    if a.shape != b.shape:
        return np.inf
    return float(relative_difference(a, b).max(initial=0.0))


def _reproduction(case, backend):
    """Lines to paste."""
    load = "reference()" if backend.name == "refimpl" else f"load_backend({backend.name!r})"
    return (f"    from refimpl.conformance import case, {load.split('(')[0]}\n"
            f"    c = case({case.id!r})\n    print(c.call({load}), c.expected)")
