"""What the check cell of a notebook calls: your function is judged element by element or, as long
as it is not written, replaced.

    conv1d_backward_x = attempt(my_conv1d_backward_x, own, {"odd width": (x, w), "even width": (x, v)}, f=nn.conv1d, wrt="x")

prints `name | exact | approximate | max difference | checked by`, raises an AssertionError that
names the worst element, and returns the function to go on with.
"""

import inspect

import numpy as np

from .gradcheck.gradient import Row, check_gradient, upstream
from .gradcheck.errors import GradientError, describe

# against the package's own function, relative to the largest element
TOLERANCE = 1e-10


def attempt(mine, own, cases, *, f=None, wrt=None, kinks=None, tolerance=TOLERANCE):
    """Judge a student's function.

    mine, own : the student's function and the package's, with the same arguments;
    cases : {label: inputs}, each a tuple of arguments (for a gradient, those of f);
    f : given for a gradient. Then mine(dy, *inputs) is asked for the gradients with respect to
    `wrt`, a name of one of f's parameters or a tuple of them (all float arrays unless given), for a
    random dy, and every element is checked twice: by complex step or central differences of f, and
    by `own`. Without f the values of mine(*inputs) are compared with those of own(*inputs);
    kinks : more cases, at ties and kinks, where differences have no verdict and the stated rule,
    `own`, decides alone;
    tolerance : of the comparison with `own`
    ->  mine, or own while mine raises NotImplementedError.
    Raises AssertionError with the case, the worst element, what was found and needed.
    """
    rows, failures = [], []
    try:
        for label, inputs in cases.items():
            case = _gradient(mine, own, f, inputs, wrt, tolerance) if f else _values(
                mine, own, inputs, inputs, tolerance)
            _collect(label, case, rows, failures)
        for label, inputs in (kinks or {}).items():
            _collect(label, _against_own(mine, own, f, inputs, wrt, tolerance), rows, failures)
    except NotImplementedError:
        print(
            f"open: {mine.__name__} is yours to write; the package's own version is used from here "
            "on")
        return own
    print(_table(rows))
    if failures:
        raise GradientError(f"{mine.__name__}, {failures[0]}")
    print("passed")
    return mine


def _collect(label, case, rows, failures):
    for row, failure in case:
        rows.append(
            Row(f"{row.name}, {label}" if row.name else label, row.exact, row.approximate,
                row.difference, row.checked_by))
        if failure:
            failures.append(f"{label}: {failure}")


def _gradient(mine, own, f, inputs, wrt, tolerance):
    """One case by differences of f, and by the package's own gradient.
    ->  list of (Row, message or None)
    """
    places, names = _chosen(f, inputs, wrt)

    def complete(chosen):
        chosen = dict(zip(places, chosen))
        return [chosen.get(place, _copy(x)) for place, x in enumerate(inputs)]
    try:
        report = check_gradient(lambda *chosen: f(*complete(chosen)),
                                lambda dy, *chosen: mine(dy, *complete(chosen)),
                                *(inputs[place] for place in places), names=names, report=True)
    except GradientError as error:                               # no gradient at all
        return [(Row(", ".join(names), False, False, np.inf, "its type"), str(error))]
    failures = list(report.failures)
    judged = [(row, failures.pop(0).splitlines()[0] if failures and not row.approximate else None)
              for row in report.rows]
    # not an element: a contract broken, or a random line
    if failures:
        judged[-1] = judged[-1][0], judged[-1][1] or failures[0].splitlines()[0]
    return judged + _against_own(mine, own, f, inputs, wrt, tolerance)


def _against_own(mine, own, f, inputs, wrt, tolerance):
    """One case by the package's own gradient alone."""
    _, names = _chosen(f, inputs, wrt)
    return _values(mine, own, inputs, (upstream(f, inputs, 0), *inputs), tolerance, names)


def _values(mine, own, inputs, arguments, tolerance, names=None):
    """The outputs of both functions, element by element; and the arguments must be left as they
    were.
    """
    needed = own(*arguments)
    count = len(needed) if isinstance(needed, tuple) else 1
    copies = [_copy(x) for x in arguments]
    found = mine(*copies)
    found, needed = (list(y) if isinstance(y, (tuple, list)) and count > 1 else [y]
                     for y in (found, needed))
    names = names or ([""] if count == 1 else [f"output {i}" for i in range(count)])
    if len(found) != count:
        return [(Row("", False, False, np.inf,
                     "its count"), f"found {len(found)} outputs, needed {count}")]
    judged = [_compare(name, x, y, tolerance) for name, x, y in zip(names, found, needed)]
    for name, before, after in zip(inspect.signature(mine).parameters, arguments, copies):
        if isinstance(before, np.ndarray) and not np.array_equal(
                before, after, equal_nan=before.dtype.kind in "fc"):
            judged[-1] = judged[-1][0], judged[-1][
                1] or f"found {name} changed, needed it as it was; arguments are only to be read"
    return judged


def _copy(x):
    return x.copy() if isinstance(x, np.ndarray) else x


def _compare(name, found, needed, tolerance):
    """->  Row, message of the worst element or None"""
    checked_by = "the package's own function"
    if not isinstance(found,
                      (np.ndarray, np.generic, int, float)) or np.shape(found) != np.shape(needed):
        shape = f"shape {np.shape(found)}" if isinstance(found,
                                                         np.ndarray) else type(found).__name__
        return Row(
            name, False, False, np.inf,
            "its shape"), f"{name}: found {shape}, needed shape {np.shape(needed)}".removeprefix(
                ": ")
    found, needed = np.asarray(found, float), np.asarray(needed, float)
    difference = np.where((found == needed) | (np.isnan(found) & np.isnan(needed)), 0.0,
                          np.abs(found - needed))
    difference = np.where(np.isnan(difference), np.inf, difference)
    bound = tolerance * max(
        np.abs(needed[np.isfinite(needed)]).max(initial=0.0),
        np.finfo(float).tiny)
    good = difference <= bound
    row = Row(name, bool((difference == 0).all()), bool(good.all()),
              float(difference.max(initial=0.0)), checked_by)
    if good.all():
        return row, None
    worst = np.unravel_index(int(np.argmax(difference)), difference.shape)
    where = ", ".join(str(int(n)) for n in worst)
    return row, (
        f"{name}[{where}]: {describe(found[worst], needed[worst], bound)} by {checked_by}; "
        f"{int((~good).sum())} of {good.size} elements are wrong.")


def _chosen(f, inputs, wrt):
    """Places of the inputs that the gradient is asked for, and what to call their gradients."""
    names = [name for name, _ in zip(inspect.signature(f).parameters, inputs)]
    if wrt is None:
        wrt = tuple(name for name, x in zip(names, inputs)
                    if isinstance(x, np.ndarray) and x.dtype.kind == "f")
    wrt = (wrt,) if isinstance(wrt, str) else tuple(wrt)
    if not set(wrt) <= set(names):
        raise ValueError(
            f"wrt: found {', '.join(wrt)}, needed parameters of f among {', '.join(names)}")
    return [names.index(name) for name in wrt], [f"d{name}" for name in wrt]


def _table(rows):
    width = max([4] + [len(row.name) for row in rows])
    lines = [f"{'name':{width}} | exact | approximate | max difference | checked by"]
    return "\n".join(lines + [
        f"{row.name:{width}} | {str(row.exact):5} | {str(row.approximate):11} | "
        f"{row.difference:14.3e} | {row.checked_by}"
        for row in rows])
