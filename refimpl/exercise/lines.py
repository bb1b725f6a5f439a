"""Lines of what a student is told: a small case drawn, a crash in five lines, what is not written.
"""

from collections.abc import Callable, Iterator, Sequence
import inspect
import linecache
import re
from typing import Any

import numpy as np

from .rivals import Failure
from ..gradcheck.difference import differences

PICTURED = 30            # elements that an array may have to be drawn


def sketch(failure: Failure) -> Iterator[str]:
    """Lines: the arguments, the answer found and the one needed, where they are small."""
    pairs = [(x, y) for x, y in zip(failure.found, failure.expected)
             if np.shape(x) == np.shape(y) and differences(x, y).any()][:1]
    if not pairs or np.size(pairs[0][1]) > PICTURED or np.ndim(pairs[0][1]) == 0:
        return
    shown = [(name, x) for name, x in zip(failure.names, failure.arguments)
             if isinstance(x, np.ndarray) and x.size <= PICTURED] + [
        ("yours", pairs[0][0]), ("needed", pairs[0][1])]
    for name, x in shown:
        text = np.array2string(np.squeeze(np.asarray(x)), precision=3, suppress_small=True)
        first, *rest = text.splitlines()
        yield f"  {name:>8} = {first}"
        yield from (" " * 13 + line for line in rest if line.strip())


def unwritten(mine: Callable[..., Any], error: BaseException) -> str:
    """What is not written: this function, or one that it calls."""
    trace: Any = error.__traceback__
    while trace.tb_next:
        trace = trace.tb_next
    other = trace.tb_frame.f_code.co_name
    called = "" if other == mine.__name__ else f" (it calls {other}, which is not written yet)"
    return (f"open: {mine.__name__} is yours to write{called}; the package's own version is used "
            "from here on")


def crash(mine: Callable[..., Any], error: BaseException, arguments: Sequence[Any]) -> str:
    """Five lines: the error, the student's line, the shapes of what stands in it, the arguments."""
    where = mine.__code__.co_filename if hasattr(mine, "__code__") else ""
    trace: Any = error.__traceback__
    here: Any = None
    while trace:
        here = trace if trace.tb_frame.f_code.co_filename == where else here
        trace = trace.tb_next
    lines = [f"it stopped with {type(error).__name__}: {str(error).splitlines()[0][:200]}"
             if str(error) else f"it stopped with {type(error).__name__}"]
    if here:
        code = linecache.getline(where, here.tb_lineno).strip()
        first = here.tb_frame.f_code.co_firstlineno
        lines.append(f"  at line {here.tb_lineno - first + 1} of {here.tb_frame.f_code.co_name}: "
                     f"{code}")
        names = dict.fromkeys(re.findall(r"\b[A-Za-z_]\w*\b", code))
        known = {n: here.tb_frame.f_locals[n] for n in names if n in here.tb_frame.f_locals}
        if known:
            lines.append("  there: " + ", ".join(f"{n} {_kind(x)}" for n, x in known.items()))
    named = zip(parameters(mine, arguments), arguments)
    lines.append("  called with: " + ", ".join(f"{name} {_kind(x)}" for name, x in named))
    return "\n".join(lines)


def _kind(x):
    return (f"{x.shape}" if isinstance(x, np.ndarray) else f"= {x!r}" if isinstance(
        x, (int, float, str, np.generic)) else f"({type(x).__name__})")


def parameters(mine: Callable[..., Any], arguments: Sequence[Any]) -> list[str]:
    """Names of the arguments, and of those that the function has no name for.

    >>> parameters(lambda x: x, (1, 2))
    ['x', 'argument 1']
    """
    names = list(inspect.signature(mine).parameters)
    return [*names, *(f"argument {i}" for i in range(len(names), len(arguments)))]
