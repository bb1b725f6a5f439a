"""Is the answer right, and which function does the notebook go on with?

    conv1d_backward_x = attempt(my_conv1d_backward_x, reference,
                                {"odd width": (x, w), "even width": (x, v)}, f=nn.conv1d, wrt="x")

prints `name | exact | approximate | max difference | checked by` and "passed", or what is wrong,
in which case, and what kind of mistake that looks like; and returns the function to go on with.
"""

from collections.abc import Callable, Mapping
import copy
import functools
import inspect
from typing import Any

import numpy as np

from .answers import Counting, as_array, compared, named_results, taken
from .lines import crash, parameters, sketch, unwritten
from .mistakes import explain
from .repairs import WORK, counted, one_change
from .rivals import Failure
from ..gradcheck import derivative
from ..gradcheck.contract import changed
from ..gradcheck.errors import GradientError, UndecidedError
from ..gradcheck.gradient import check_gradient, upstream
from ..gradcheck.report import Row, verdicts
from ..gradcheck.structure import is_float

TOLERANCE = 1e-10     # against the package's own function, relative to the largest element
SINGLY = 100          # elements of an input that are checked one by one; of more, a sample


def attempt(mine: Callable[..., Any], reference: Callable[..., Any], cases: Mapping[str, tuple], *,
            f: Callable[..., Any] | None = None, wrt: str | tuple[str, ...] | None = None,
            kinks: Mapping[str, tuple] | None = None, tolerance: float = TOLERANCE,
            most_calls: int | None = None, most_products: int | None = None) -> Callable[..., Any]:
    """Judge a student's function, and say aloud what came out.

    mine, reference : the student's function and the package's, with the same arguments; of several
    results, a tuple, or a dict of named ones, which are told one by one;
    cases : {label: inputs}, each a tuple of arguments (for a gradient, those of f). The label of a
    case is told when it fails, so it names what is special about it;
    f : given for a gradient. Then mine(dy, *inputs) is asked for the gradients with respect to
    `wrt`, a name of one of f's parameters or a tuple of them (all float arrays unless given), for a
    random dy, and checked twice: every element by `reference`, and by complex step or central
    differences of f (of an input of more than 100 elements a sample, and all of them along a
    line). Without f the values of mine(*inputs) are compared with those of
    reference(*inputs);
    kinks : more cases, at ties and kinks, where differences have no verdict and the stated rule,
    `reference`, decides alone;
    tolerance : of the comparison with `reference`;
    most_calls : how often a function among the arguments may be called in a case;
    most_products : how many products of two arrays may be taken in a case
    ->  mine if it is right (lists that it returns made arrays), else reference: what comes after
    never breaks.

    >>> def double(x):
    ...     return x + x
    >>> attempt(double, lambda x: 2 * x, {"two numbers": (np.array([1.0, 2.0]),)}) is double
    name        | exact | approximate | max difference | checked by
    two numbers | True  | True        |      0.000e+00 | the package's own function
    passed
    True
    """
    _chosen(f, next(iter(cases.values())), wrt) if f else None
    rows: list[Row] = []
    failures: list[tuple[str, str, Failure | None]] = []
    whole = {**cases, **(kinks or {})}
    known: dict[str, tuple] = {}
    for label, inputs in whole.items():
        arguments = (upstream(f, inputs, 0), *inputs) if f else tuple(inputs)
        known[label] = arguments, _expected(reference, f, arguments, wrt)
        try:
            judged, message, failure = _values(mine, arguments, known[label][1], tolerance,
                                               most_calls, most_products)
            if not message and f and label in cases:
                instruments, message = _gradient(mine, f, inputs, wrt)
                judged = instruments + judged
        except NotImplementedError as error:
            print(unwritten(mine, error))
            return reference
        except Exception as error:               # the student's own: told, not raised
            judged, message, failure = [], crash(mine, error, arguments), None
        rows += [Row(f"{row.name}, {label}" if row.name else label, row.exact, row.approximate,
                     row.difference, row.checked_by) for row in judged]
        failures += [(label, message, failure)] if message else []
    if rows:
        print(*verdicts(rows), sep="\n")
    if not failures:
        print("passed")
        return _with_arrays(mine, *next(iter(known.values())))
    print(*_told(mine, reference, failures, known, bool(f), tolerance), sep="\n")
    return reference


def gradient_by_steps(f: Callable[..., Any], x: np.ndarray, dy: Any = 1.0) -> np.ndarray:
    """The gradient of sum(dy * f(x)), measured: the reference for an intermediate that nobody wants
    to give away. By complex step, or by differences where f is not analytic.

    >>> gradient_by_steps(np.sin, np.zeros(2), np.array([1.0, 3.0])).tolist()
    [1.0, 3.0]
    """
    measured = np.zeros(x.shape)
    for index in np.ndindex(x.shape):
        unit = np.zeros(x.shape)
        unit[index] = 1
        along = derivative.line(f, (x,), {0: unit})
        dy_all = np.broadcast_to(dy, np.shape(f(x)))
        exact = derivative.complex_step(along, dy_all)
        measured[index] = derivative.extrapolate(along, dy_all)[0] if exact is None else exact
    return measured


def _with_arrays(mine, arguments, expected):
    """The student's function, or, where it returns lists for arrays, one that returns arrays."""
    found, needed = mine(*_copied(arguments)), list(expected.values())
    one = len(needed) == 1
    if isinstance(found, dict) or not any(isinstance(x, (list, tuple)) for x in (
            [found] if one else found)):
        return mine
    wrapped = one and len(found) == 1 and np.shape(found) != np.shape(needed[0])

    @functools.wraps(mine)
    def _arrays(*inputs, **options):
        made = mine(*inputs, **options)
        made = [made[0] if wrapped else made] if one else made
        made = [np.asarray(x) if isinstance(y, np.ndarray) else x for x, y in zip(made, needed)]
        return made[0] if one else tuple(made)
    return _arrays


def _told(mine, reference, failures, known, linear, tolerance):
    """Lines: the smallest case that failed, what it looks like, where it is right."""
    passed = {label: arguments for label, (arguments, _) in known.items()
              if label not in [failed for failed, _, _ in failures]}
    mended = one_change(mine, _right_in(known.values(), tolerance))
    values = [failure for _, _, failure in failures if failure]
    label, message, failure = min(failures, key=lambda told: (
        not told[2], sum(np.size(y) for y in told[2].expected) or np.inf if told[2] else 0))
    yield f"wrong: {mine.__name__}, {label}: {message}"
    if failure:
        yield from sketch(failure)

        def _listed(function):
            left, each = [WORK // 2], [0]

            def _answers(*arguments):
                if not each[0]:
                    made, each[0] = counted(lambda: _asked(*arguments))
                    return made
                left[0] -= each[0]
                if left[0] < 0:
                    raise TimeoutError("asked often enough")
                return _asked(*arguments)

            def _asked(*arguments):
                with np.errstate(all="ignore"):
                    found = taken(function(*_copied(arguments)), known[label][1])
                return [np.asarray(y) for y in found.values()]
            return _answers
        looks = explain(_listed(mine), _listed(reference), values,
                        list(passed.values()), linear, brief=bool(mended))
        if looks:
            yield f"  looks like: {looks}"
    if mended:
        yield f"  {mended}"
    if passed and 3 * len(failures) <= len(passed):
        yield "  looks like: right, except in: " + "; ".join(failed for failed, _, _ in failures)
    elif passed:
        yield f"  right in: {'; '.join(passed)}"
    if len(failures) > 1 and 3 * len(failures) > len(passed):
        yield "  wrong in: " + "; ".join(failed for failed, _, _ in failures)
    yield ("  The notebook goes on with the package's own version, until yours passes.")


def _right_in(known, tolerance):
    """->  whether a function is right in all cases, the smallest first"""
    def _size(case):
        return sum(x.size for x in (*case[0], *case[1].values()) if isinstance(x, np.ndarray))
    cases = sorted(known, key=_size)

    def _right(function):
        for arguments, expected in cases:
            handed_out = _copied(arguments)
            found = taken(function(*handed_out), expected)
            if any(compared(name, found[name], y, tolerance)[1] for name, y in expected.items()):
                return False
            if next(iter(changed(arguments, arguments, handed_out)), None):
                return False
        return True
    return _right


def _gradient(mine, f, inputs, wrt):
    """One case by differences of f.   ->  list of Row, message or ""."""
    places, names = _chosen(f, inputs, wrt)

    def _complete(chosen):
        chosen = dict(zip(places, chosen))
        return [chosen.get(place, x) for place, x in enumerate(_copied(inputs))]

    def _claims(dy, *chosen):
        found = mine(dy, *_complete(chosen))
        named = dict(zip(names, chosen))
        return tuple(np.asarray(y, float) if isinstance(y, list) else y
                     for y in taken(found, named).values())
    try:
        report: Any = check_gradient(lambda *chosen: f(*_complete(chosen)), _claims,
                                     *(inputs[place] for place in places), names=names, report=True,
                                     elements=SINGLY)
    except (GradientError, UndecidedError) as error:
        return [Row(", ".join(names), False, False, np.inf, "its type")], str(error)
    failures = [failure.splitlines()[0] for failure in report.failures]
    return list(report.rows), failures[0] if failures else ""


def _copied(arguments):
    """Arguments that may be written into; lists of arrays too."""
    return list(copy.deepcopy(tuple(arguments)))


def _expected(reference, f, arguments, wrt):
    """The right results of one case by name."""
    expected = named_results(reference(*_copied(arguments)))
    if f and ("" in expected or "output 0" in expected):
        return dict(zip(_chosen(f, arguments[1:], wrt)[1], expected.values()))
    return expected


def _values(mine, arguments, expected, tolerance, most_calls, most_products):
    """The outputs of both functions, element by element; the arguments must be left as they were.
    ->  list of Row, message or "", Failure or None
    """
    handed_out, calls = _copied(arguments), [0]

    def _counted(function):
        def _call(*inputs, **options):
            calls[0] += 1
            return function(*inputs, **options)
        return _call
    if most_calls is not None:
        handed_out = [_counted(x) if callable(x) else x for x in handed_out]
    found = mine(*handed_out)
    try:
        found = taken(found, expected)
    except TypeError as error:
        return [Row("", False, False, np.inf, "its count")], str(error), None
    judged = [compared(name, found[name], y, tolerance) for name, y in expected.items()]
    rows, messages = [row for row, _ in judged], [message for _, message in judged if message]
    names = parameters(mine, arguments)
    if messages:
        arrays = [[as_array(y)[0] for y in values.values()] for values in (found, expected)]
        failure = None if any(x is None for side in arrays for x in side) else Failure(
            names, tuple(arguments), *arrays)
        right = [row.name for row, message in judged if not message and row.name]
        return rows, messages[0] + (f" {', '.join(right)}: right." if right else ""), failure
    for name, _ in changed(names, arguments, handed_out):
        return rows, (f"found {name} changed, needed it as it was; arguments are only to be read, "
                      "so work on a copy"), None
    if most_calls is not None and calls[0] > most_calls:
        return rows, f"the value is right, after {calls[0]} calls; {most_calls} are enough", None
    if most_products is not None:
        Counting.products = 0
        mine(*(x.view(Counting) if isinstance(x, np.ndarray) else x for x in _copied(arguments)))
        if Counting.products > most_products:
            return rows, (f"the value is right, by {Counting.products} products; "
                          f"{most_products} are enough"), None
    return rows, "", None


def _chosen(f, inputs, wrt):
    """Places of the inputs that the gradient is asked for, and what to call their gradients."""
    names = [name for name, _ in zip(inspect.signature(f).parameters, inputs)]
    if wrt is None:
        wrt = tuple(name for name, x in zip(names, inputs) if is_float(x))
    wrt = (wrt,) if isinstance(wrt, str) else tuple(wrt)
    if not set(wrt) <= set(names):
        raise ValueError(f"wrt: found {', '.join(wrt)}, needed parameters of f among "
                         f"{', '.join(names)}")
    return [names.index(name) for name in wrt], [f"d{name}" for name in wrt]
