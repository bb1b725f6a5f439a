"""Which single change would make a wrong function right?

A mistake is often one sign, one axis, one index. Such changes are made to the student's own text,
one at a time, until the function is right in every case: the line and the kind of the change are
then told. What has to stand there instead is not.
"""

import ast
from collections.abc import Callable, Iterator
import contextlib
import copy
import io
from itertools import islice
import linecache
import sys
from typing import Any
import warnings

import numpy as np

MOST, FEWEST = 3000, 100      # changes that are tried
WORK = 500_000                # calls that all of them together may take, or about so
LINES = 20_000                # that a changed loop may run through before it counts as endless
_SIGN, _ORDER, _NUMBER = "a sign", "the order of two things", "a number"
_MUCH = "something stands there that should not"
_OPERATORS = {ast.Add: ("-", _SIGN), ast.Sub: ("+", _SIGN), ast.Mult: ("/", "times or divided by"),
              ast.Div: ("*", "times or divided by"), ast.FloorDiv: ("/", "whole-number division"),
              ast.BitAnd: ("|", "and, or or"), ast.BitOr: ("&", "and, or or"),
              ast.MatMult: ("*", "which product"), ast.Pow: ("*", "a power")}
_FUNCTIONS = {"sum": ("mean", "max"), "mean": ("sum", "max"), "max": ("min", "sum", "mean"),
              "min": ("max",),
              "maximum": ("minimum",), "minimum": ("maximum",), "argmax": ("argmin",),
              "argmin": ("argmax",), "floor": ("ceil", "round"), "ceil": ("floor",),
              "round": ("floor", "ceil"), "sin": ("cos",), "cos": ("sin",), "any": ("all",),
              "all": ("any",), "zeros": ("ones",), "ones": ("zeros",), "real": ("imag",),
              "zeros_like": ("ones_like",), "ones_like": ("zeros_like",), "imag": ("real",),
              "std": ("var",), "var": ("std",)}
_LENGTHS = ("({}).shape[0]", "({}).shape[1]", "({}).shape[-1]", "({}).size", "({})[0].size")
_WORDS = ("edge", "constant", "wrap", "reflect", "valid", "same", "full")
_MISSING = {_SIGN: ("-({})",), "a factor is missing": ("({}) * 2", "({}) / 2"),
            "one more or one less": ("({}) + 1", "({}) - 1"),
            "a power or a root is missing": ("({}) ** 2", "np.sqrt({})"),
            "a transpose is missing": ("({}).swapaxes(-1, -2)", "({}).T",
                                       "({0}) + ({0}).swapaxes(-1, -2)"),
            "the direction along an axis": ("({})[::-1]", "({})[..., ::-1]", "({})[:, ::-1]"),
            "the opposite is needed": ("1 - ({})", "~({})", "1 / ({})"),
            "something is to be cut off or made positive": ("np.abs({})", "np.maximum({}, 0)"),
            "an axis of length 1 is missing": ("({})[:, None]", "({})[..., None]",
                                               "({})[:, None, None]", "({})[None]"),
            "a sum is missing": ("({}).sum(axis=0)", "({}).sum(axis=-1)", "({}).sum(axis=(0, 2))",
                                 "({}).sum(axis=-1, keepdims=True)"),
            "another kind of number": ("({}).astype(float)", "({}).astype(int)")}
_WITH = {"a factor is missing": ("({}) * {}", "({}) * ({} > 0)", "({}) * len({})", "({}) * {}.size",
                                 "({}) / {}", "({}) / len({})", "({}) / {}.size",
                                 "({}) / {}[0].size", "({}) * {}[:, None, None]"),
         "a term is missing": ("({}) + {}", "({}) - {}")}


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
    tree, main = found
    endless = any(isinstance(node, ast.While) for node in ast.walk(tree))
    for kind, line in islice(_changes(tree), min(MOST, max(FEWEST, WORK // calls))):
        names = dict(function.__globals__)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                exec(compile(tree, "<changed>", "exec"), names)
        except Exception:                        # no text of Python
            continue
        if _good(names[main.name], right, endless):
            shown = linecache.getline(function.__code__.co_filename, line).strip()
            first = function.__code__.co_firstlineno
            where = f"line {line - first + 1}" if line >= first else "a function that it calls"
            return f"One change in {where}, `{shown}`, makes it right in every case: {kind}."
    return ""


def counted(work: Callable[[], Any]) -> tuple[Any, int]:
    """What a piece of work returns, and how many calls it takes: how costly it is, on any machine.

    >>> counted(lambda: max(1, 2))
    (2, 3)
    """
    calls = [1]

    def _count(frame, event, _):
        calls[0] += event in ("call", "c_call")
    if sys.getprofile() is not None:             # somebody else is counting
        return work(), 1000
    sys.setprofile(_count)
    try:
        return work(), calls[0]
    finally:
        sys.setprofile(None)


def _text(function):
    """The functions' tree, of this one and of those beside it that it calls.   ->  tree, its node"""
    code = getattr(function, "__code__", None)
    if code is None or code.co_freevars:
        return None
    try:
        whole = ast.parse("".join(linecache.getlines(code.co_filename)))
    except SyntaxError:
        return None
    beside = [node for node in whole.body if isinstance(node, ast.FunctionDef)]
    main = next((node for node in beside if node.name == code.co_name
                 and node.lineno == code.co_firstlineno), None)
    if main is None:
        return None
    called = {node.id for node in ast.walk(main) if isinstance(node, ast.Name)}
    kept = [main, *(node for node in beside if node.name in called and node is not main)]
    return ast.Module(kept, []), main


def _good(function, right, endless=False):
    """Whether a function is right, its words and warnings unheard; endless loops are left."""
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
            return right(function)
        except Exception:                        # it crashes
            return False
        finally:
            sys.settrace(before)


def _changes(tree):
    """Changes the tree in one place after the other, and back.   ->  kind of the change, line"""
    names = list(dict.fromkeys([a.arg for node in tree.body for a in node.args.args] + [
        node.id for node in ast.walk(tree) if isinstance(node, ast.Name)
        and isinstance(node.ctx, ast.Store)]))
    known = [*names, *{repr(node.value) for node in ast.walk(tree) if isinstance(
        node, ast.Constant) and isinstance(node.value, float)}]
    slots = [slot for function in tree.body for slot in _slots(function)]
    for make in (_small, _statements, _names, _missing, _with):
        for holder, field, index, node, where in slots:
            for kind, new in make(node, where, known if make is _with else names):
                kept = getattr(holder, field)
                put = new if isinstance(new, list) else [new]
                setattr(holder, field, new if index is None else
                        [*kept[:index], *put, *kept[index + 1:]])
                for part in put:
                    ast.fix_missing_locations(part)
                yield kind, node.lineno
                setattr(holder, field, kept)


def _slots(node, where=""):
    """(holder, field, index, node, what it is part of) of all that can be changed."""
    for field, value in ast.iter_fields(node):
        inside = ("an index" if isinstance(node, ast.Subscript) and field == "slice" else
                  "an axis" if isinstance(node, ast.keyword) and node.arg == "axis" else where)
        if field in ("args", "decorator_list", "returns") and isinstance(node, ast.FunctionDef):
            continue
        for index, child in enumerate(value) if isinstance(value, list) else [(None, value)]:
            if isinstance(child, (ast.expr, ast.stmt, ast.keyword)):
                if hasattr(child, "lineno"):
                    yield node, field, index, child, inside
                yield from _slots(child, inside)


def _made(text):
    return ast.parse(text, mode="eval").body


def _small(node, where, names):
    """(kind, node) of what may stand there instead, made of what stands there."""
    if isinstance(node, ast.BinOp):
        left, right = ast.unparse(node.left), ast.unparse(node.right)
        if type(node.op) in _OPERATORS:
            sign, kind = _OPERATORS[type(node.op)]
            yield kind, _made(f"({left}) {sign} ({right})")
        if not isinstance(node.op, (ast.Add, ast.Mult)):
            yield (_SIGN if isinstance(node.op, ast.Sub) else _ORDER), ast.BinOp(
                node.right, node.op, node.left)
        yield from ((where or _MUCH, part) for part in (node.left, node.right))
    elif isinstance(node, ast.UnaryOp):
        yield (_SIGN if isinstance(node.op, ast.USub) else "the opposite"), node.operand
    elif isinstance(node, ast.Compare):
        for op in (ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.Eq, ast.NotEq):
            yield "a comparison", ast.Compare(node.left, [op()], node.comparators[:1])
    elif isinstance(node, ast.BoolOp):
        yield "and, or or", ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(),
                                       node.values)
        yield from ((_MUCH, part) for part in node.values)
    elif isinstance(node, ast.Constant):
        n = node.value
        values = ([not n] if isinstance(n, bool) else [n + 1, n - 1, -n, 2 * n, n / 2, 0, 1] + [
                      n * 10.0 ** k for k in (1, -1, 2, -2, 3, -3, 4, 6) if isinstance(n, float)]
                  if isinstance(n, (int, float)) else _WORDS if n in _WORDS else [0, 1, -1] if n is None and where == "an axis" else [])
        whole = isinstance(n, int)
        yield from ((where or _NUMBER, ast.Constant(
            int(value) if whole and value == int(value) else value)) for value in values
            if isinstance(value, (str, bool)) or value != n)
        if isinstance(n, int) and where == "an axis":
            yield from (("an axis", _made(text)) for text in ("None", "(0, 2)", "(1, 2)", "(0, 1)"))
    elif isinstance(node, ast.Slice):
        low, high = node.lower, node.upper
        one, less = ast.Constant(1), ast.UnaryOp(ast.USub(), ast.Constant(1))
        for lower, upper, step in ((one, high, node.step), (low, less, node.step), (None, high, None),
                                   (low, None, None), (one, None, None), (None, less, None),
                                   (low, high, less), (low, high, None), (None, None, None)):
            yield "where a slice begins, ends or goes", ast.Slice(lower, upper, step)
    elif isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Load):
        yield "an index too many", node.value
        if getattr(node.value, "attr", "") == "shape":
            yield from (("which length", _made(form.format(ast.unparse(node.value.value))))
                        for form in _LENGTHS)
    elif isinstance(node, ast.Attribute) and node.attr == "size":
        yield from (("which length", _made(form.format(ast.unparse(node.value))))
                    for form in _LENGTHS)
    elif isinstance(node, (ast.Attribute, ast.Name)) and getattr(node, "attr", "") in _FUNCTIONS:
        yield from (("which function", _made(f"({ast.unparse(node.value)}).{name}"))
                    for name in _FUNCTIONS[node.attr])
    elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load):
        yield _MUCH, node.value
    elif isinstance(node, ast.Tuple) and isinstance(node.ctx, ast.Load):
        for i in range(len(node.elts)):
            yield where or _ORDER, ast.Tuple(
                [*node.elts[:i], *node.elts[i + 1:i + 2], node.elts[i], *node.elts[i + 2:]],
                ast.Load())
            yield where or _MUCH, ast.Tuple([*node.elts[:i], *node.elts[i + 1:]], ast.Load())
    elif isinstance(node, ast.IfExp):
        yield from (("a case that is told apart, or not", part) for part in (node.body, node.orelse))
    if isinstance(node, ast.Call):
        yield from _calls(node)


def _calls(node):
    arguments, options = node.args, node.keywords
    yield from ((_MUCH, part) for part in arguments)
    if isinstance(node.func, ast.Attribute):
        yield _MUCH, node.func.value
    for i in range(len(arguments) - 1):
        yield _ORDER, ast.Call(node.func, [*arguments[:i], arguments[i + 1], arguments[i],
                                           *arguments[i + 2:]], options)
    yield from (("an argument too many", ast.Call(node.func, arguments, [
        other for other in options if other is not option])) for option in options)
    if getattr(node.func, "attr", getattr(node.func, "id", "")) in (
            "sum", "mean", "max", "min", "norm", "diff", "cumsum", "flip", "argmax", "argmin", "all",
            "any", "std", "concatenate", "stack", "repeat"):
        yield from (("an axis", ast.Call(node.func, arguments, [
            *(other for other in options if other.arg != "axis"),
            ast.keyword("axis", _made(axis))])) for axis in ("0", "1", "2", "-1", "(1, 2)"))
        yield "an axis that is to stay", ast.Call(node.func, arguments, [
            *options, ast.keyword("keepdims", ast.Constant(True))])


def _statements(node, where, names):
    """(kind, statement or statements) instead of a statement."""
    if isinstance(node, ast.AugAssign):
        load = _made(ast.unparse(node.target))
        for op in (ast.Add, ast.Sub):
            yield "=, += or -=", ast.AugAssign(node.target, op(), node.value)
        yield "=, += or -=", ast.Assign([node.target], node.value)
        yield _ORDER, ast.Assign([node.target], ast.BinOp(node.value, node.op, load))
    elif isinstance(node, ast.Assign) and isinstance(node.targets[0], (ast.Subscript, ast.Name)):
        for op in (ast.Add, ast.Sub):
            yield "=, += or -=", ast.AugAssign(node.targets[0], op(), node.value)
    elif isinstance(node, ast.If):
        yield "a condition", ast.If(ast.UnaryOp(ast.Not(), node.test), node.body, node.orelse)
        yield "a condition that should not be there", node.body
    elif isinstance(node, ast.For) and isinstance(node.body[-1], ast.Return):
        yield "where return stands", [ast.For(node.target, node.iter, node.body[:-1], []),
                                      node.body[-1]]
    elif isinstance(node, ast.For):
        yield "the direction of a loop", ast.For(
            node.target, _made(f"list({ast.unparse(node.iter)})[::-1]"), node.body, node.orelse)
    if isinstance(node, (ast.Assign, ast.AugAssign, ast.Expr, ast.If)) and not (
            isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)):
        yield "a line that should not be there", ast.Pass()


def _names(node, where, names):
    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
        yield from (("which name stands there", _made(name)) for name in names if name != node.id)


def _missing(node, where, names):
    """(kind, node) of something that is wrapped round what stands there."""
    if where == "an index" and isinstance(node, ast.Name):
        yield from ((where, _made(f"{name} - 1 - {node.id}")) for name in names)
    if isinstance(node, (ast.Name, ast.Attribute, ast.Subscript, ast.Call, ast.BinOp)) and not (
            isinstance(getattr(node, "ctx", None), ast.Store)):
        text = ast.unparse(node)
        yield from ((kind, _made(form.format(text))) for kind, forms in _MISSING.items()
                    for form in forms)


def _with(node, where, names):
    """(kind, node) with a name more in what a statement computes or a function is given."""
    if isinstance(node, ast.Call) and node.args:
        for new in _more(node.args[0], names):
            yield new[0], ast.Call(node.func, [new[1], *node.args[1:]], node.keywords)
    elif isinstance(node, (ast.Assign, ast.AugAssign, ast.Return)) and node.value is not None:
        parts = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
        for i, part in enumerate(parts):
            for kind, new in _more(part, names):
                changed = copy.copy(node)
                changed.value = new if len(parts) == 1 else ast.Tuple(
                    [*parts[:i], new, *parts[i + 1:]], ast.Load())
                yield kind, changed


def _more(part, names):
    text = ast.unparse(part)
    yield from ((kind, _made(form.format(text, name))) for kind, forms in _WITH.items()
                for form in forms for name in names)
