"""Which mistake would give just these numbers?

No exercise is known here. Rival answers are made by applying common mistakes to what the right
function is asked, or to what it answers; a rival is named only if it gives the student's numbers in
every case that failed. Where none does, the student's function is asked a few questions
(`behaviour`): which arguments does it listen to, how does it grow with them, do clips reach each
other, and where are the wrong elements.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from .behaviour import lost, places, questions, reached, simpler
from .rivals import (Failure, axis_name, ORDINALS, made_of_answer, made_of_argument, same,
                     scaled_answers)
from ..gradcheck.contract import copies


def explain(mine: Callable[..., Any], right: Callable[..., list], failures: Sequence[Failure],
            passed: Sequence[tuple] = (), linear: bool = False, brief: bool = False) -> str:
    """What the mistake looks like, in a sentence or two, or "".

    mine, right : functions of a case's arguments to a list of arrays;
    passed : the arguments of the cases that did not fail;
    linear : whether the first argument is an upstream gradient;
    brief : whether only a mistake that gives just these numbers is to be told

    >>> dy, x = np.array([1.0, 2.0]), np.array([3.0, 5.0])
    >>> case = Failure(("dy", "x"), (dy, x), [x * dy], [2 * x * dy])
    >>> explain(lambda dy, x: [x * dy], lambda dy, x: [2 * x * dy], [case])
    'Everything is half of what is needed.'
    """
    count = len(failures[0].expected)
    wrong = [i for i in range(count) if any(not same(case.found[i:i + 1], case.expected[i:i + 1])
                                            for case in failures)]
    kept = [Failure(case.names, case.arguments, [case.found[i] for i in wrong],
                    [case.expected[i] for i in wrong]) for case in failures]

    def _chosen(function):
        def _some(*arguments):
            made = function(*arguments)
            return [made[i] for i in wrong]
        return _some
    mine, right = _chosen(mine), _chosen(right)
    kept = sorted(kept, key=lambda case: sum(np.size(y) for y in case.expected))
    few = [case for case in kept if any(np.any(y) for y in case.expected)][:4] or kept[:4]
    with np.errstate(all="ignore"):
        if brief:
            return _form(few) or _rival(right, few, brief)
        where = told_apart(failures[0].names, [case.arguments for case in failures], passed)
        if all(np.asarray(y).dtype == bool and np.size(y) == 1 for y in few[0].expected):
            return where                         # yes or no: nothing to compare
        return _form(few) or " ".join(filter(None, [
            _rival(right, few) or _difference(few) or _behaviour(mine, right, few, kept, linear),
            where]))


def _behaviour(mine, right, few, kept, linear):
    """At most four sentences: of places with a reason, of what would have to be simpler, others."""
    told = [*lost(few), *places(few), *(reached(mine, right, kept) if linear else ()),
            *questions(mine, right, few)]
    reasons = [text for text in told if "only where" in text]
    others = sorted((text for text in told if text not in reasons), key=lambda t: "positions" in t)
    return " ".join([*reasons, *[*simpler(mine, right, few)][:2], *others][:4])


def told_apart(names: Sequence[str], failed: Sequence[tuple], passed: Sequence[tuple]) -> str:
    """What all cases that failed have in common and none that passed, or "".

    >>> told_apart(["x"], [(np.zeros(3),), (np.zeros(5),)], [(np.zeros(2),), (np.zeros(4),)])
    'Wrong where the first axis of x has an odd length.'
    """
    if len(passed) < 2:
        return ""
    common = set.intersection(*(set(_traits(names, case)) for case in failed))
    told = [trait for trait in _traits(names, failed[0]) if trait in common and not any(
        trait in _traits(names, case) for case in passed)]
    return f"Wrong where {told[0]}." if told else ""


def _traits(names, arguments):
    """What can be said of the arguments of a case."""
    lengths: dict[str, float] = {}
    for name, x in zip(names, arguments):
        if isinstance(x, np.ndarray):
            lengths |= {(f"{axis_name(k, 9)} of {name}"): n for k, n in enumerate(x.shape)}
            if x.dtype.kind == "f" and x.size:
                yield from (text for holds, text in ((not x.all(), f"{name} has zeros"),
                                                     (np.isnan(x).any(), f"{name} has NaN"),
                                                     (np.abs(x).max() < 1e-3, f"{name} is small"))
                            if holds)
            yield f"{name} has {x.ndim} axes"
            yield f"{name} has not {5 - x.ndim} axes" if x.ndim in (2, 3) else ""
    numbers = {name: x for name, x in zip(names, arguments) if isinstance(x, (int, float))}
    for what, n in lengths.items():
        yield f"{what} has an {'odd' if n % 2 else 'even'} length"
        yield f"{what} has {'the length ' + str(n) if n < 2 else 'a length above 1'}"
    for i, (one, n) in enumerate(numbers.items()):
        for other, m in list(numbers.items())[:i]:
            yield f"{one} is {other}" if n == m else f"{one} is not {other}"
            yield f"{one} is above {other}" if n > m else f"{one} is not above {other}"
            yield (f"{other} is above half of {one}" if 2 * m > n + 1
                   else f"{other} is not above half of {one}")
    for name, x in numbers.items():
        yield f"{name} is {x:g}"
        yield from (f"{name} is not {number}" for number in (0, 1) if x != number)


def _common(failures, candidates: Callable[..., Iterator[tuple[str, list]]]):
    """The first sentence whose arrays are the found ones in every failure."""
    kept: dict[str, None] | None = None
    for case in failures:
        told = dict.fromkeys(text for text, arrays in candidates(case, kept)
                             if (kept is None or text in kept) and same(case.found, arrays))
        kept = told if kept is None else {text: None for text in kept if text in told}
        if not kept:
            return ""
    return next(iter(kept or ()), "")


def _form(failures):
    """Answers of the wrong shape."""
    if all(np.shape(a) == np.shape(b) for case in failures
           for a, b in zip(case.found, case.expected)):
        return ""
    if _common(failures, lambda case, _: iter([("x", case.expected[::-1])])):
        return "The results are the right ones, in another order."

    def _shapes(case, _):
        ndim = max(np.ndim(y) for y in case.found + case.expected)
        for k in range(ndim):
            axis = axis_name(k, ndim)
            for text, change in (
                    (f"{axis} was kept, with length 1", lambda y: np.expand_dims(y, k)),
                    (f"{axis} was summed away", lambda y: np.sum(y, axis=k)),
                    (f"{axis} was averaged away", lambda y: np.mean(y, axis=k)),
                    (f"the first position of {axis} is missing", lambda y: np.delete(y, 0, k)),
                    (f"the last position of {axis} is missing", lambda y: np.delete(y, -1, k))):
                yield text, _each(change, case.expected)
            for m in range(k):
                yield (f"{axis_name(m, ndim)} and {axis} are exchanged",
                       _each(lambda y: np.swapaxes(y, m, k), case.expected))
        yield "it was flattened", _each(np.ravel, case.expected)
    text = _common(failures, _shapes)
    if text:
        return f"The numbers are right, but {text}." if "missing" not in text else f"{text}."

    def _sums(case, _):
        for k in range(max(np.ndim(y) for y in case.found)):
            yield (f"It would be right once summed over its {ORDINALS[k]} axis: what is shared "
                   "collects from all who share it."), [
                found if same([np.sum(found, axis=k)], [needed]) else needed
                for found, needed in zip(case.found, case.expected) if np.ndim(found) > k]
    return _common(failures, _sums) or _wrong_shape(failures)


def _wrong_shape(failures):
    a, b = next((a, b) for case in failures for a, b in zip(case.found, case.expected)
                if np.shape(a) != np.shape(b))
    if np.ndim(a) > np.ndim(b):
        return "It has too many axes: one was not summed, or broadcasting lined up the wrong ones."
    if np.ndim(a) < np.ndim(b):
        return "It has too few axes: one was summed or indexed away that has to stay."
    wrong = [k for k, (n, m) in enumerate(zip(np.shape(a), np.shape(b))) if n != m]
    if sorted(np.shape(a)) == sorted(np.shape(b)):
        return "The lengths are those needed, on other axes: it is transposed."
    axes = " and ".join(axis_name(k, np.ndim(a)) for k in wrong)
    return f"The length is wrong along {axes}."


def _each(change, arrays):
    changed = []
    for y in arrays:
        try:
            changed.append(change(np.asarray(y)))
        except Exception:                        # this array has no such axis: it stays
            changed.append(np.asarray(y))
    return changed


def _rival(right, failures, brief=False):
    """A mistake that gives all the numbers that were found."""
    def _outputs(case, _):
        for text, arrays in scaled_answers(case, case.expected):
            yield f"Everything is {text}.", arrays
        for made in zip(*(list(made_of_answer(y)) for y in case.expected)):
            if len({text for text, _ in made}) == 1:
                arrays = [array for _, array in made]
                yield f"It is {made[0][0]}.", arrays
                for text, scaled in scaled_answers(case, arrays):
                    yield f"It is {made[0][0]}, and {text}.", scaled

    def _inputs(case, kept):
        for i, (name, x) in enumerate(zip(case.names, case.arguments)):
            for text, value in made_of_argument(name, x):
                if kept is None or any(f" if {text}" in other for other in kept):
                    yield from _asked(case, {i: value}, text)
            for j, y in enumerate(case.arguments[:i]):
                if isinstance(x, str) and isinstance(y, np.ndarray) and y.ndim:
                    yield from _asked(case, {i: x[::-1], j: np.flip(y, -1)},
                                      f"{case.names[j]} and {name} were both read backwards")
                if type(x) is type(y) and np.shape(x) == np.shape(y):
                    for a, b in ((i, j), (j, i)):
                        yield from _asked(case, {a: case.arguments[b]}, f"{case.names[b]} stood "
                                          f"in the place of {case.names[a]}")
                    yield from _asked(case, {i: y, j: x},
                                      f"{case.names[j]} and {name} were exchanged")

    def _asked(case, changed, text):
        try:
            arrays = right(*(changed.get(i, x) for i, x in enumerate(copies(case.arguments))))
        except Exception:                        # the right function is not for these
            return
        yield f"It is what would be right if {text}.", arrays
        for more, scaled in scaled_answers(case, arrays):
            yield f"It is what would be right if {text}, and {more}.", scaled
        if all(y.ndim > 1 and y.shape[-1] == y.shape[-2] for y in arrays):
            yield (f"It is what would be right if {text}, and the result transposed.",
                   [y.swapaxes(-1, -2) for y in arrays])
    several = any(np.size(y) > 2 for case in failures for y in case.expected)
    exact = _common(failures, _outputs) or _common(failures, _inputs)
    if exact or brief:
        return exact
    return several and _common(failures, lambda case, _: (
        (f"Everything is {text}.", arrays) for text, arrays in
        scaled_answers(case, case.expected, any_factor=True))) or ""


def _constant(x, axes):
    """Whether an array is the same all along some axes."""
    return same([np.mean(x, axes, keepdims=True) + 0 * x], [x])


def _difference(failures):
    """What was added that should not be, what is missing, and numbers in other places."""
    def _terms(case, _):
        for name, x in zip(case.names, case.arguments):
            if not isinstance(x, (np.ndarray, float)) or np.asarray(x).dtype.kind != "f":
                continue
            if all(np.shape(x) == np.shape(y) for y in case.expected):
                moved = Failure(case.names, case.arguments, [y - x for y in case.found], [])
                for text, _ in scaled_answers(moved, [y - x for y in case.expected], any_factor=any(
                        np.size(y) > 2 for other in failures for y in other.expected)):
                    yield f"The step away from {name} is {text}.", case.found
            for factor, text in ((1, "once too often"), (-1, "once too rarely"),
                                 (-2, "with the wrong sign"), (-.5, "by half too rarely")):
                for axes in (0, 1, 2):
                    shaped = np.reshape(x, np.shape(x) + (1,) * axes)
                    try:
                        yield f"{name} is added {text}.", [
                            y + factor * shaped + 0 * y for y in case.expected]
                    except ValueError:           # does not broadcast
                        pass

    def _places(case, _):
        pairs = [(np.asarray(x, float), np.asarray(y, float)) for x, y in
                 zip(case.found, case.expected)]
        if all(y.size > 1 for _, y in pairs):
            whole = all(y.ndim > 1 and y.all() and x.all() and np.isfinite(x).all()
                        for x, y in pairs)
            for k in range(min(y.ndim for _, y in pairs)):
                name = axis_name(k, pairs[0][1].ndim)
                if all(same([np.sort(x, k)], [np.sort(y, k)]) for x, y in pairs):
                    yield f"The numbers are right, in other places along {name}.", case.found
                if whole and all(_constant(x / y, tuple(m for m in range(y.ndim) if m != k))
                                 for x, y in pairs):
                    yield (f"Each position of {name} is wrong by a factor of its own, the same "
                           "within it."), case.found
                if whole and all(y.shape[k] > 1 and _constant(x / y, k) for x, y in pairs):
                    yield (f"The factor by which it is wrong is the same all along {name}."), (
                        case.found)
                if all(y.ndim > 1 and np.isfinite(x - y).all() and _constant(x - y, k)
                       for x, y in pairs):
                    yield f"It is off by something that is the same all along {name}.", case.found
            if all(same([np.sort(x.ravel())], [np.sort(y.ravel())]) for x, y in pairs):
                yield "The numbers are the right ones, in other places.", case.found
            if all(same([np.abs(x)], [np.abs(y)]) for x, y in pairs):
                yield "The signs of some elements are wrong, and nothing else.", case.found
    return _common(failures, _terms) or _common(failures, _places)
