"""Small changes to the text of a function: what may stand in a place instead of what stands there.

Each comes with its kind, in words for who wrote the function; the words do not tell the text.
"""

import ast
from collections.abc import Callable, Iterable, Iterator, Sequence
import copy

_Change = tuple[str, ast.AST | list]              # its kind, and the node or statements put there
_SIGN, _ORDER, _NUMBER = "a sign", "the order of two things", "a number"
_BRACKET = "where a bracket closes"
_MUCH = "something stands there that should not"
_OPERATORS: dict[type, tuple[str, str, str]] = {
    ast.Add: ("+", "-", _SIGN), ast.Sub: ("-", "+", _SIGN), ast.Pow: ("**", "*", "a power"),
    ast.Mult: ("*", "/", "times or divided by"), ast.Div: ("/", "*", "times or divided by"),
    ast.FloorDiv: ("//", "/", "whole-number division"), ast.Mod: ("%", "//", "which operation"),
    ast.BitAnd: ("&", "|", "and, or or"), ast.BitOr: ("|", "&", "and, or or"),
    ast.MatMult: ("@", "*", "which product")}
_FUNCTIONS = {"sum": ("mean", "max"), "mean": ("sum", "max"), "max": ("min", "sum", "mean"),
              "min": ("max",), "maximum": ("minimum",), "minimum": ("maximum",),
              "argmax": ("argmin",), "argmin": ("argmax",), "floor": ("ceil", "round"),
              "ceil": ("floor",), "round": ("floor", "ceil"), "sin": ("cos",), "cos": ("sin",),
              "any": ("all",), "all": ("any",), "zeros": ("ones",), "ones": ("zeros",),
              "zeros_like": ("ones_like",), "ones_like": ("zeros_like",), "real": ("imag",),
              "imag": ("real",), "std": ("var",), "var": ("std",)}
_ALONG = ("sum", "mean", "max", "min", "norm", "diff", "cumsum", "flip", "argmax", "argmin", "all",
          "any", "std", "concatenate", "stack", "repeat")
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
                                 "({}) / {}[0].size", "({}) * {}[:, None, None]",
                                 "({}) * {}[:, None]",
                                 "({}) * (1 - {})", "({}) * np.eye(len({}))"),
         "a product of matrices is missing": ("({1}) @ ({0})", "({0}) @ ({1})"),
         "a term is missing": ("({}) + {}", "({}) - {}")}


def changes(tree: ast.Module) -> Iterator[tuple[str, int]]:
    """Changes a tree in one place after the other, and back.   ->  yields kind of the change, line

    >>> tree = ast.parse("def f(x):\\n    return x - 1")
    >>> next((kind, ast.unparse(tree.body[0].body[0])) for kind, _ in changes(tree))
    ('a sign', 'return x + 1')
    """
    names = list(dict.fromkeys(
        [a.arg for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)
         for a in node.args.args]
        + [node.id for node in ast.walk(tree) if isinstance(node, ast.Name)
           and isinstance(node.ctx, ast.Store)]))
    known = [*names, *dict.fromkeys(repr(node.value) for node in ast.walk(tree) if isinstance(
        node, ast.Constant) and isinstance(node.value, float))]
    slots = [slot for function in tree.body for slot in _slots(function)]
    alike: dict[str, list] = {}
    for slot in slots:
        if isinstance(slot[3], ast.expr) and not isinstance(slot[3], ast.Constant):
            alike.setdefault(ast.unparse(slot[3]), []).append(slot)
    several = [group for group in alike.values() if len(group) > 1]
    for make, groups in ((_small, [[slot] for slot in slots]), (_statements, [[s] for s in slots]),
                         (_names, [[slot] for slot in slots]), (_small, several),
                         (_missing, [[slot] for slot in slots]), (_names, several),
                         (_with, [[slot] for slot in slots]), (_missing, several)):
        for group in groups:
            _, _, _, node, where = group[0]
            told = known if make in (_with, _names) else names
            for kind, new in _parsed(make(node, where, told)):
                put = new if isinstance(new, list) else [new]
                before = [(holder, field, getattr(holder, field)) for holder, field, *_ in group]
                for holder, field, index, *_ in group:
                    now = getattr(holder, field)
                    setattr(holder, field, new if index is None else
                            [*now[:index], *put, *now[index + 1:]])
                for part in put:
                    ast.fix_missing_locations(part)
                yield kind + " (everywhere)" * (len(group) > 1), node.lineno
                for holder, field, kept in reversed(before):
                    setattr(holder, field, kept)


def _parsed(made):
    try:
        yield from made
    except SyntaxError:                          # what stands there cannot stand in another text
        return


def _slots(node, where=""):
    """(holder, field, index, node, what it is part of) of all that can be changed."""
    for field, value in ast.iter_fields(node):
        inside = ("an index" if isinstance(node, ast.Subscript) and field == "slice" else
                  "an axis" if isinstance(node, ast.keyword) and node.arg == "axis" else where)
        if isinstance(node, ast.FunctionDef) and field in ("args", "decorator_list", "returns"):
            continue
        for index, child in enumerate(value) if isinstance(value, list) else [(None, value)]:
            if isinstance(child, (ast.expr, ast.stmt, ast.keyword)):
                yield node, field, index, child, inside
                yield from _slots(child, inside)


def _made(text):
    return ast.parse(text, mode="eval").body


def _small(node, where, names):
    """What may stand there, made of what stands there."""
    making = _BY_TYPE.get(type(node))
    if making and not isinstance(getattr(node, "ctx", None), ast.Store):
        for kind, new in making(node, where):
            yield kind, _made(new) if isinstance(new, str) else new


def _operation(node, where):
    left, right = ast.unparse(node.left), ast.unparse(node.right)
    sign, other, kind = _OPERATORS.get(type(node.op), ("", "", ""))
    if sign:
        yield kind, f"({left}) {other} ({right})"
    if sign and sign not in "+*":
        yield _SIGN if sign == "-" else _ORDER, f"({right}) {sign} ({left})"
    yield from ((where or _MUCH, part) for part in (node.left, node.right))
    if sign and isinstance(node.left, ast.Call) and len(node.left.args) == 1:
        inner = ast.unparse(node.left.args[0])
        yield _BRACKET, f"{ast.unparse(node.left.func)}(({inner}) {sign} ({right}))"


def _comparison(node, where):
    for op in (ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.Eq, ast.NotEq):
        yield "a comparison", ast.Compare(node.left, [op()], node.comparators[:1])


def _logic(node, where):
    op = ast.Or() if isinstance(node.op, ast.And) else ast.And()
    yield "and, or or", ast.BoolOp(op, node.values)
    yield from ((_MUCH, part) for part in node.values)


def _constant(node, where):
    n = node.value
    if isinstance(n, bool):
        yield _NUMBER, repr(not n)
    elif isinstance(n, (int, float)):
        values = [n + 1, n - 1, -n, 2 * n, n / 2, 0, 1] + [
            n * 10.0 ** k for k in (1, -1, 2, -2, 3, -3, 4, 6) if isinstance(n, float)]
        whole = isinstance(n, int)
        yield from ((where or _NUMBER, repr(int(value) if whole and value == int(value) else value))
                    for value in values if value != n)
    elif n in _WORDS:
        yield from (("a word", repr(word)) for word in _WORDS)
    if where == "an axis":
        yield from ((where, text) for text in ("None", "0", "-1", "(0, 2)", "(1, 2)", "(0, 1)"))


def _slice(node, where):
    low, high, one, less = node.lower, node.upper, _made("1"), _made("-1")
    for lower, upper, step in ((one, high, node.step), (low, less, node.step), (None, high, None),
                               (low, None, None), (one, None, None), (None, less, None),
                               (low, high, less), (low, high, None), (None, None, None)):
        yield "where a slice begins, ends or goes", ast.Slice(lower, upper, step)


def _index(node, where):
    yield "an index too many", node.value
    if getattr(node.value, "attr", "") == "shape":
        yield from (("which length", form.format(ast.unparse(node.value.value)))
                    for form in _LENGTHS)


def _attribute(node, where):
    text = ast.unparse(node.value)
    yield from (("which function", f"({text}).{name}") for name in _FUNCTIONS.get(node.attr, ()))
    if node.attr == "size":
        yield from (("which length", form.format(text)) for form in _LENGTHS)
    elif node.attr not in _FUNCTIONS:
        yield _MUCH, node.value


def _several(node, where):
    for i, part in enumerate(node.elts):
        rest = [*node.elts[:i], *node.elts[i + 1:]]
        yield where or _ORDER, ast.Tuple([*rest[:i + 1], part, *rest[i + 1:]], ast.Load())
        yield where or _MUCH, ast.Tuple(rest, ast.Load())


def _call(node, where):
    given, options = node.args, node.keywords
    yield from ((_MUCH, part) for part in given)
    if isinstance(node.func, ast.Attribute):
        yield _MUCH, node.func.value
    if len(given) == 1 and isinstance(given[0], ast.BinOp) and type(given[0].op) in _OPERATORS:
        name, sign = ast.unparse(node.func), _OPERATORS[type(given[0].op)][0]
        left, right = ast.unparse(given[0].left), ast.unparse(given[0].right)
        yield _BRACKET, f"{name}({left}) {sign} ({right})"
        yield _BRACKET, f"({left}) {sign} {name}({right})"
    for i in range(len(given) - 1):
        swapped = [*given[:i], given[i + 1], given[i], *given[i + 2:]]
        yield _ORDER, ast.Call(node.func, swapped, options)
    for option in options:
        rest = [other for other in options if other is not option]
        yield "an argument too many", ast.Call(node.func, given, rest)
    if getattr(node.func, "attr", "") == "zeros":
        yield from (("what an array begins with", f"np.full({ast.unparse(given[0])}, {number})")
                    for number in ("np.inf", "np.nan") if given)
    if getattr(node.func, "attr", getattr(node.func, "id", "")) in _ALONG:
        rest = [option for option in options if option.arg != "axis"]
        for axis in ("0", "1", "2", "-1", "(1, 2)"):
            yield "an axis", ast.Call(node.func, given, [*rest, ast.keyword("axis", _made(axis))])
        yield "an axis that is to stay", ast.Call(node.func, given, [
            *options, ast.keyword("keepdims", ast.Constant(True))])


_BY_TYPE: dict[type, Callable[..., Iterable[tuple[str, ast.AST | str]]]] = {
    ast.BinOp: _operation, ast.Compare: _comparison, ast.BoolOp: _logic, ast.Slice: _slice,
    ast.Constant: _constant, ast.Subscript: _index, ast.Attribute: _attribute, ast.Call: _call,
    ast.Tuple: _several,
    ast.UnaryOp: lambda node, where: [(_SIGN if isinstance(node.op, ast.USub)
                                       else "the opposite", node.operand)],
    ast.IfExp: lambda node, where: [("a condition", part) for part in (node.body, node.orelse)]}


def _statements(node: ast.AST, where: str, names: Sequence[str]) -> Iterator[_Change]:
    """What may stand there instead of a statement."""
    signs = "=, += or -="
    if isinstance(node, ast.AugAssign):
        turned = ast.BinOp(node.value, node.op, _made(ast.unparse(node.target)))
        yield signs, ast.Assign([node.target], node.value)
        yield _ORDER, ast.Assign([node.target], turned)
    if isinstance(node, (ast.Assign, ast.AugAssign)):
        target = node.target if isinstance(node, ast.AugAssign) else node.targets[0]
        if isinstance(target, (ast.Subscript, ast.Name)):
            yield from ((signs, ast.AugAssign(target, op(), node.value))
                        for op in (ast.Add, ast.Sub))
    elif isinstance(node, ast.If):
        yield "a condition", ast.If(ast.UnaryOp(ast.Not(), node.test), node.body, node.orelse)
        yield "a condition that should not be there", node.body
    elif isinstance(node, ast.For):
        turned = _made(f"list({ast.unparse(node.iter)})[::-1]")
        yield "the direction of a loop", ast.For(node.target, turned, node.body, node.orelse)
        if isinstance(node.body[-1], ast.Return) and node.body[:-1]:
            yield "where return stands", [ast.For(node.target, node.iter, node.body[:-1], []),
                                          node.body[-1]]
    if isinstance(node, (ast.Assign, ast.AugAssign, ast.If)) or (
            isinstance(node, ast.Expr) and not isinstance(node.value, ast.Constant)):
        yield "a line that should not be there", ast.Pass()


def _names(node, where, names):
    if isinstance(node, ast.Constant) and repr(node.value) in names:
        yield from ((_NUMBER, _made(name)) for name in names if name != repr(node.value))
    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
        yield from (("which name stands there", _made(name)) for name in names
                    if name.isidentifier() and name != node.id)


def _missing(node, where, names):
    """Something that is wrapped round what stands there."""
    if where == "an index" and isinstance(node, ast.Name):
        yield from ((where, _made(f"{name} - 1 - {node.id}")) for name in names)
    if isinstance(node, (ast.Name, ast.Attribute, ast.Subscript, ast.Call, ast.BinOp)) and not (
            isinstance(getattr(node, "ctx", None), ast.Store)):
        text = ast.unparse(node)
        yield from ((kind, _made(form.format(text))) for kind, forms in _MISSING.items()
                    for form in forms)


def _with(node, where, names):
    """A name more in what a statement computes, or a function is given."""
    if isinstance(node, ast.Call) and node.args:
        for kind, new in _more(node.args[0], names):
            yield kind, ast.Call(node.func, [new, *node.args[1:]], node.keywords)
    elif isinstance(node, ast.BinOp) and isinstance(node.op, (ast.Add, ast.Sub)):
        for kind, new in _more(node.left, names):
            yield kind, ast.BinOp(new, node.op, node.right)
        for kind, new in _more(node.right, names):
            yield kind, ast.BinOp(node.left, node.op, new)
    elif isinstance(node, (ast.Assign, ast.AugAssign, ast.Return)) and node.value is not None:
        whole, field = node.value, {ast.Tuple: "elts", ast.Dict: "values"}.get(type(node.value))
        for i, part in enumerate(getattr(whole, field) if field else [whole]):
            for kind, new in _more(part, names):
                changed, parts = copy.copy(node), copy.copy(whole)
                if field:
                    setattr(parts, field, [*getattr(whole, field)])
                    getattr(parts, field)[i] = new
                changed.value = parts if field else new
                yield kind, changed


def _more(part, names):
    text = ast.unparse(part)
    yield from ((kind, _made(form.format(text, name))) for kind, forms in _WITH.items()
                for form in forms for name in names)
