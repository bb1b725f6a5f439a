"""What the check cell of a notebook calls: your function is judged element by element or, as long
as it is not written, replaced.

    conv1d_backward_x = attempt(my_conv1d_backward_x, reference,
                                {"odd width": (x, w), "even width": (x, v)}, f=nn.conv1d, wrt="x")

prints `name | exact | approximate | max difference | checked by`, raises an AssertionError that
names the worst element, and returns the function to go on with.
"""

from collections.abc import Callable, Mapping
import inspect
from typing import Any

import numpy as np

from .gradcheck.contract import changed, copies
from .gradcheck.difference import TINY, differences, largest
from .gradcheck.errors import GradientError, describe
from .gradcheck.gradient import check_gradient, upstream
from .gradcheck.report import Row, verdicts

TOLERANCE = 1e-10     # against the package's own function, relative to the largest element
OWN_FUNCTION = "the package's own function"
SINGLY = 100          # elements of an input that are checked one by one; of more, a sample


def attempt(mine: Callable[..., Any], reference: Callable[..., Any], cases: Mapping[str, tuple], *,
            f: Callable[..., Any] | None = None, wrt: str | tuple[str, ...] | None = None,
            kinks: Mapping[str, tuple] | None = None,
            tolerance: float = TOLERANCE) -> Callable[..., Any]:
    """Judge a student's function.

    mine, reference : the student's function and the package's, with the same arguments;
    cases : {label: inputs}, each a tuple of arguments (for a gradient, those of f);
    f : given for a gradient. Then mine(dy, *inputs) is asked for the gradients with respect to
    `wrt`, a name of one of f's parameters or a tuple of them (all float arrays unless given), for a
    random dy, and checked twice: every element by `reference`, and by complex step or central
    differences of f (of an input of more than 100 elements a sample, and all of them along a
    line). Without f the values of mine(*inputs) are compared with those of
    reference(*inputs);
    kinks : more cases, at ties and kinks, where differences have no verdict and the stated rule,
    `reference`, decides alone;
    tolerance : of the comparison with `reference`
    ->  mine, or reference while mine raises NotImplementedError.
    Raises AssertionError with the case, the worst element, what was found and needed.

    >>> def double(x):
    ...     return x + x
    >>> attempt(double, lambda x: 2 * x, {"two numbers": (np.array([1.0, 2.0]),)}) is double
    name        | exact | approximate | max difference | checked by
    two numbers | True  | True        |      0.000e+00 | the package's own function
    passed
    True
    """
    rows, failures = [], []
    judged = [(label, inputs, _gradient if f else _values) for label, inputs in cases.items()]
    judged += [(label, inputs, _values) for label, inputs in (kinks or {}).items()]
    try:
        for label, inputs, judge in judged:
            for row, failure in judge(mine, reference, f, inputs, wrt, tolerance):
                name = f"{row.name}, {label}" if row.name else label
                rows.append(Row(name, row.exact, row.approximate, row.difference, row.checked_by))
                failures += [f"{label}: {failure}"] if failure else []
    except NotImplementedError:
        print(f"open: {mine.__name__} is yours to write; the package's own version is used from "
              "here on")
        return reference
    print(*verdicts(rows), sep="\n")
    if failures:
        raise GradientError(f"{mine.__name__}, {failures[0]}")
    print("passed")
    return mine


def _gradient(mine, reference, f, inputs, wrt, tolerance):
    """One case by differences of f, and by the package's own gradient.
    ->  list of (Row, message or None)
    """
    places, names = _chosen(f, inputs, wrt)

    def _complete(chosen):
        chosen = dict(zip(places, chosen))
        return [chosen.get(place, x) for place, x in enumerate(copies(inputs))]
    try:
        report: Any = check_gradient(lambda *chosen: f(*_complete(chosen)),
                                     lambda dy, *chosen: mine(dy, *_complete(chosen)),
                                     *(inputs[place] for place in places), names=names, report=True,
                                     elements=SINGLY)
    except GradientError as error:                               # no gradient at all
        return [(Row(", ".join(names), False, False, np.inf, "its type"), str(error))]
    failures = [failure.splitlines()[0] for failure in report.failures]
    judged = [(row, failures.pop(0) if failures and not row.approximate else None)
              for row in report.rows]
    if failures:                             # not an element: a contract broken, or a random line
        judged[-1] = judged[-1][0], judged[-1][1] or failures[0]
    return judged + _values(mine, reference, f, inputs, wrt, tolerance)


def _values(mine, reference, f, inputs, wrt, tolerance):
    """The outputs of both functions, element by element, for a random upstream gradient where f is
    given; and the arguments must be left as they were.   ->  list of (Row, message or None)
    """
    arguments = (upstream(f, inputs, 0), *inputs) if f else inputs
    expected, handed_out = reference(*arguments), copies(arguments)
    count = len(expected) if isinstance(expected, tuple) else 1
    found = mine(*handed_out)
    found, expected = (list(y) if isinstance(y, (tuple, list)) and count > 1 else [y]
                       for y in (found, expected))
    names = [""] if count == 1 else [f"output {i}" for i in range(count)]
    names = _chosen(f, inputs, wrt)[1] if f else names
    if len(found) != count:
        return [(Row("", False, False, np.inf, "its count"),
                 f"found {len(found)} outputs, needed {count}")]
    judged = [_compare(name, x, y, tolerance) for name, x, y in zip(names, found, expected)]
    for name, _ in changed(inspect.signature(mine).parameters, arguments, handed_out):
        judged[-1] = judged[-1][0], judged[-1][1] or (
            f"found {name} changed, needed it as it was; arguments are only to be read")
    return judged


def _compare(name, found, expected, tolerance):
    """->  Row, message of the worst element or None"""
    numbers = isinstance(found, (np.ndarray, np.generic, int, float))
    if not numbers or np.shape(found) != np.shape(expected):
        kind = f"shape {found.shape}" if isinstance(found, np.ndarray) else type(found).__name__
        message = f"{name}: found {kind}, needed shape {np.shape(expected)}".removeprefix(": ")
        return Row(name, False, False, np.inf, "its shape"), message
    found, expected = np.asarray(found, float), np.asarray(expected, float)
    off, bound = differences(found, expected), tolerance * max(largest(expected), TINY)
    good = off <= bound
    row = Row(name, bool((off == 0).all()), bool(good.all()), float(off.max(initial=0.0)),
              OWN_FUNCTION)
    if good.all():
        return row, None
    worst = np.unravel_index(int(np.argmax(off)), off.shape)
    where = ", ".join(str(int(n)) for n in worst)
    said = describe(found[worst], expected[worst], bound)
    return row, (f"{name}[{where}]: {said} by {OWN_FUNCTION}; "
                 f"{int((~good).sum())} of {good.size} elements are wrong.")


def _chosen(f, inputs, wrt):
    """Places of the inputs that the gradient is asked for, and what to call their gradients."""
    names = [name for name, _ in zip(inspect.signature(f).parameters, inputs)]
    if wrt is None:
        wrt = tuple(name for name, x in zip(names, inputs)
                    if isinstance(x, np.ndarray) and x.dtype.kind == "f")
    wrt = (wrt,) if isinstance(wrt, str) else tuple(wrt)
    if not set(wrt) <= set(names):
        raise ValueError(f"wrt: found {', '.join(wrt)}, needed parameters of f among "
                         f"{', '.join(names)}")
    return [names.index(name) for name in wrt], [f"d{name}" for name in wrt]
