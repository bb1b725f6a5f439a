"""Which single change would make a wrong function right?

A mistake is often one sign, one axis, one index. Such changes are made to the student's own text,
one at a time, until the function is right in every case: the line and the kind of the change are
then told. What has to stand there instead is not.
"""

import ast
from collections.abc import Callable
import contextlib
import io
from itertools import islice
import linecache
import sys
from typing import Any
import warnings

import numpy as np

from .changes import changes

MOST, ATLEAST = 6000, 150      # changes that are tried
WORK = 1_000_000              # calls that all of them together may take, or about so
LINES = 20_000                # that a changed loop may run through before it counts as endless


def one_change(function: Callable[..., Any], right: Callable[[Callable[..., Any]], bool]) -> str:
    """Where a single change makes a function right, and of what kind it is, or "".

    function : whose text is at hand;  right : whether a function is right in every case

    >>> def half(x):
    ...     return 2 * x - 1
    >>> one_change(half, lambda f: f(3) == 7)
    'One change in line 2, `return 2 * x - 1`, makes it right in every case: a sign.'
    """
    found = _text(function)
    good, calls = counted(lambda: _good(function, right))
    if found is None or good:
        return ""                                # nothing to change, or no fault that `right` sees
    tree, name = found
    endless = any(isinstance(node, ast.While) for node in ast.walk(tree))
    for kind, line in islice(changes(tree), min(MOST, max(ATLEAST, WORK // calls))):
        changed = _function(tree, name, function.__globals__)
        if changed and _good(changed, right, endless, 20 * calls + LINES):
            shown = linecache.getline(function.__code__.co_filename, line).strip()
            number = line - function.__code__.co_firstlineno + 1
            where = f"line {number}" if number > 0 else "a function that it calls"
            return f"One change in {where}, `{shown}`, makes it right in every case: {kind}."
    return ""


def counted(work: Callable[[], Any], most: float = np.inf) -> tuple[Any, int]:
    """What a piece of work returns, and how many calls it takes: how costly it is, on any machine.

    Raises TimeoutError after more than `most` calls.

    >>> counted(lambda: max(1, 2))[0]
    2
    """
    calls = [1]

    def _count(frame, event, _):
        calls[0] += event in ("call", "c_call")
        if calls[0] > most:
            raise TimeoutError("it does not end")
    if sys.getprofile() is not None:             # somebody else is counting
        return work(), 1000
    sys.setprofile(_count)
    try:
        return work(), calls[0]
    finally:
        sys.setprofile(None)


def _text(function):
    """The tree of a function and of those beside it that it calls.   ->  tree, name; or None"""
    code = getattr(function, "__code__", None)
    if code is None or code.co_freevars:
        return None
    try:
        whole = ast.parse("".join(linecache.getlines(code.co_filename)))
    except SyntaxError:
        return None
    beside = [node for node in whole.body if isinstance(node, ast.FunctionDef)]
    main = [node for node in beside if node.name == code.co_name
            and node.lineno == code.co_firstlineno]
    called = {node.id for top in main for node in ast.walk(top) if isinstance(node, ast.Name)}
    others = [node for node in beside if node.name in called and node not in main]
    return (ast.Module([*main, *others], []), code.co_name) if main else None


def _function(tree, name, known):
    """The function that a tree makes, or None."""
    names = dict(known)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")          # of the compiler, about the text
        try:
            exec(compile(tree, "<changed>", "exec"), names)
        except Exception:                        # no text of Python
            return None
    return names[name]


def _good(function, right, endless=False, most=None):
    """Whether a function is right, its words and warnings unheard. Loops that do not end are left:
    its own are traced if it has any that may be endless, those of others have to call something.
    """
    count, before = [0], sys.gettrace()

    def _trace(*_):
        count[0] += 1
        if count[0] > LINES:
            raise TimeoutError
        return _trace
    with contextlib.redirect_stdout(io.StringIO()), np.errstate(
            all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            if endless:
                sys.settrace(_trace)
            return counted(lambda: right(function), most)[0] if most else right(function)
        except Exception:                        # it crashes
            return False
        finally:
            sys.settrace(before)
