"""Which mistake would give just these numbers?

No exercise is known here. Rival answers are made by applying common mistakes to what the right
function is asked, or to what it answers; a rival is named only if it gives the student's numbers in
every case that failed. Where none does, the student's function is asked a few questions: which
arguments does it listen to, how does it grow with them, do clips reach each other, and where are
the wrong elements.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np

from ..gradcheck.contract import copies
from ..gradcheck.difference import TINY, differences, largest

CLOSE = 1e-8              # a rival that is this near, relative to the largest element, is the same
AXES = ("first", "second", "third", "fourth")
SIMPLE = {0.5: "half of what is needed", 2.0: "twice what is needed", -1.0: "the right one negated",
          -0.5: "minus half of what is needed", -2.0: "minus twice what is needed",
          0.25: "a quarter of what is needed", 4.0: "four times what is needed",
          180 / np.pi: "in degrees, and radians are needed",
          np.pi / 180: "turned from degrees to radians once too often"}


@dataclass(frozen=True)
class Failure:
    """A case that failed: what was asked, by name, and both answers, a list of arrays each."""

    names: Sequence[str]
    arguments: tuple
    found: list
    expected: list


def explain(mine: Callable[..., Any], right: Callable[..., list], failures: Sequence[Failure],
            passed: Sequence[tuple] = (), linear: bool = False) -> str:
    """What the mistake looks like, in a sentence or two, or "".

    mine, right : functions of a case's arguments to a list of arrays;
    passed : the arguments of the cases that did not fail;
    linear : whether the first argument is an upstream gradient

    >>> dy, x = np.array([1.0, 2.0]), np.array([3.0, 5.0])
    >>> case = Failure(("dy", "x"), (dy, x), [x * dy], [2 * x * dy])
    >>> explain(lambda dy, x: [x * dy], lambda dy, x: [2 * x * dy], [case])
    'Everything is half of what is needed.'
    """
    count = len(failures[0].expected)
    wrong = [i for i in range(count) if any(not _same(case.found[i:i + 1], case.expected[i:i + 1])
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
        where = split(failures[0].names, [case.arguments for case in failures], passed)
        if all(np.asarray(y).dtype == bool and np.size(y) == 1 for y in few[0].expected):
            return where                         # yes or no: nothing to compare
        return _form(few) or " ".join(filter(None, [
            _rival(right, few) or _difference(few) or " ".join(sorted(
                [*_lost(few), *_place(few), *(_reach(mine, right, few[-1]) if linear else ()),
                 *_questions(mine, right, few)], key=lambda text: "positions" in text)[:3]), where]))


def split(names: Sequence[str], failed: Sequence[tuple], passed: Sequence[tuple]) -> str:
    """What all cases that failed have in common and none that passed, or "".

    >>> split(["x"], [(np.zeros(3),), (np.zeros(5),)], [(np.zeros(2),), (np.zeros(4),)])
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
    lengths = {}
    for name, x in zip(names, arguments):
        if isinstance(x, np.ndarray):
            lengths |= {(f"{_axis(k, 9)} of {name}"): n for k, n in enumerate(x.shape)}
            if x.dtype.kind == "f" and x.size:
                yield from (text for holds, text in (
                    (not x.all(), f"{name} has zeros"), (x.min() < 0, f"{name} has numbers below 0"),
                    (np.isnan(x).any(), f"{name} has NaN"),
                    (np.abs(x).max() < 1e-3, f"{name} is small"), (x.any(), f"{name} is not all 0"))
                    if holds)
            yield f"{name} has {x.ndim} axes"
            yield f"{name} has not {5 - x.ndim} axes" if x.ndim in (2, 3) else ""
    numbers = {name: x for name, x in zip(names, arguments) if isinstance(x, (int, float))}
    for what, n in lengths.items():
        yield f"{what} has an {'odd' if n % 2 else 'even'} length"
        yield f"{what} has {'the length ' + str(n) if n < 2 else 'a length above 1'}"
    for group, verb in ((lengths, "is as long as"), (numbers, "is")):
        for i, (one, n) in enumerate(group.items()):
            for other, m in list(group.items())[:i]:
                yield f"{one} {verb} {other}" if n == m else f"{one} differs from {other}"
                yield f"{one} is above {other}" if n > m else f"{one} is not above {other}"
                yield f"{other} is above {one}" if m > n else f"{other} is not above {one}"
                yield (f"{other} is above half of {one}" if 2 * m > n + 1
                       else f"{other} is not above half of {one}")
    for name, x in numbers.items():
        yield f"{name} is {x:g}"
        yield from (f"{name} is not {number}" for number in (0, 1) if x != number)


def _same(found, expected):
    return len(found) == len(expected) and all(
        np.shape(a) == np.shape(b) and differences(a, b).max(initial=0.0)
        <= CLOSE * max(largest(b), TINY) for a, b in zip(found, expected))


def _axis(k, ndim):
    return ("the first axis" if k == 0 else "the last axis" if k == ndim - 1 else
            f"the {AXES[k]} axis" if k < len(AXES) else f"axis {k}")


def _common(failures, candidates: Callable[..., Iterator[tuple[str, list]]]):
    """The first sentence whose arrays are the found ones in every failure."""
    kept: dict[str, None] | None = None
    for case in failures:
        told = dict.fromkeys(text for text, arrays in candidates(case, kept)
                             if (kept is None or text in kept) and _same(case.found, arrays))
        kept = told if kept is None else {text: None for text in kept if text in told}
        if not kept:
            return ""
    return next(iter(kept or ()), "")


def _form(failures):
    """Answers of the wrong shape."""
    if all(np.shape(a) == np.shape(b) for case in failures
           for a, b in zip(case.found, case.expected)):
        return ""
    turned = [list(case.found) for case in failures]
    if _common(failures, lambda case, _: iter([("x", case.expected[::-1])])):
        return "The results are the right ones, in another order."

    def _shapes(case, _):
        ndim = max(np.ndim(y) for y in case.found + case.expected)
        for k in range(ndim):
            for text, change in ((f"{_axis(k, ndim)} was kept, with length 1",
                                  lambda y: np.expand_dims(y, k)),
                                 (f"{_axis(k, ndim)} was summed away", lambda y: np.sum(y, axis=k)),
                                 (f"{_axis(k, ndim)} was averaged away", lambda y: np.mean(y, axis=k)),
                                 (f"the first position of {_axis(k, ndim)} is missing",
                                  lambda y: np.delete(y, 0, axis=k)),
                                 (f"the last position of {_axis(k, ndim)} is missing",
                                  lambda y: np.delete(y, -1, axis=k))):
                yield text, _each(change, case.expected)
            for m in range(k):
                yield (f"{_axis(m, ndim)} and {_axis(k, ndim)} are exchanged",
                       _each(lambda y: np.swapaxes(y, m, k), case.expected))
        yield "it was flattened", _each(np.ravel, case.expected)
    text = _common(failures, _shapes)
    if text:
        return f"The numbers are right, but {text}." if "missing" not in text else f"{text}."

    def _sums(case):
        for k in range(max(np.ndim(y) for y in case.found)):
            yield (f"It would be right once summed over its {AXES[k]} axis: what is shared collects "
                   "from all who share it.", _each(lambda y: np.sum(y, axis=k), case.found))
    for case in failures:
        for text, arrays in _sums(case):
            if _same(arrays, case.expected):
                return text
    return _wrong_shape(turned, failures)


def _wrong_shape(found, failures):
    a, b = next((a, b) for case in failures for a, b in zip(case.found, case.expected)
                if np.shape(a) != np.shape(b))
    if np.ndim(a) > np.ndim(b):
        return "It has too many axes: one was not summed, or broadcasting lined up the wrong ones."
    if np.ndim(a) < np.ndim(b):
        return "It has too few axes: one was summed or indexed away that has to stay."
    wrong = [k for k, (n, m) in enumerate(zip(np.shape(a), np.shape(b))) if n != m]
    if sorted(np.shape(a)) == sorted(np.shape(b)):
        return "The lengths are those needed, on other axes: it is transposed."
    return "The length is wrong along " + " and ".join(_axis(k, np.ndim(a)) for k in wrong) + "."


def _each(change, arrays):
    changed = []
    for y in arrays:
        try:
            changed.append(change(np.asarray(y)))
        except Exception:                        # this array has no such axis: it stays
            changed.append(np.asarray(y))
    return changed


def _factors(case):
    """(text, number) of the factors by which an answer may be wrong."""
    yield from ((text, factor) for factor, text in SIMPLE.items())
    sizes = {}
    for name, x in zip([*case.names, *["the result"] * len(case.expected)],
                       [*case.arguments, *case.expected]):
        if isinstance(x, np.ndarray) and x.ndim:
            sizes |= {f"the length of {_axis(k, x.ndim)} of {name}": n for k, n in enumerate(x.shape)}
            sizes |= {f"the lengths of {_axis(m, x.ndim)} and {_axis(k, x.ndim)} of {name}, multiplied":
                      n * x.shape[m]
                      for k, n in enumerate(x.shape) for m in range(k)}
            sizes[f"the number of elements of {name}"] = x.size
            sizes[f"the number of elements of a clip of {name}"] = x.size // max(len(x), 1)
        elif isinstance(x, (int, float)) and not isinstance(x, bool):
            sizes[name] = x
    for part, power, factor in (("", 1, 1), ("the square of ", 2, 1), ("twice ", 1, 2),
                                ("half of ", 1, .5)):
        for what, size in sizes.items():
            n, counted = factor * size ** power, what.startswith(("the length", "the number"))
            if size not in (0, 1, -1):
                yield (f"divided by {part}{what} once too often"
                       + ": a mean for a sum" * counted, 1 / n)
                yield (f"multiplied by {part}{what} once too often"
                       + ", or not divided: a sum for a mean" * counted, n)


def _scaled(case, arrays, any_factor=False):
    """(text, arrays) for the factors that lead from some arrays to the found ones."""
    if any(np.shape(a) != np.shape(b) for a, b in zip(case.found, arrays)):
        return
    pairs = [(f.flat[np.argmax(np.abs(y))], np.max(np.abs(y)), y) for f, y in
             zip(map(np.asarray, case.found), map(np.asarray, arrays)) if y.size and y.dtype.kind
             in "fiu"]
    ratio = next((f / y.flat[np.argmax(np.abs(y))] for f, size, y in pairs if size > 0), None)
    if ratio is None or not np.isfinite(ratio) or ratio == 0:
        return
    scaled = [ratio * np.asarray(y, float) for y in arrays]
    if _same(case.found, scaled):
        for text, factor in _factors(case):
            if abs(ratio - factor) <= 1e-8 * abs(factor):
                yield text, case.found
        if any_factor:
            yield "wrong by one factor, the same throughout a case", case.found


def _of_answers(y):
    """(text, array) of what is made of an answer too much or too little."""
    y = np.asarray(y)
    for k in range(y.ndim):
        yield f"reversed along {_axis(k, y.ndim)}", np.flip(y, k)
        for step, way in ((1, "later"), (-1, "earlier")):
            yield f"one position {way} along {_axis(k, y.ndim)}, and wrapped round", np.roll(y, step, k)
            for edge, mode in (("zeros", "constant"), ("the edge repeated", "edge")):
                wide = np.pad(y, [(1, 1) if a == k else (0, 0) for a in range(y.ndim)], mode)
                part = slice(0, y.shape[k]) if step == 1 else slice(2, None)
                yield (f"one position {way} along {_axis(k, y.ndim)}, with {edge}",
                       wide[(slice(None),) * k + (part,)])
        yield f"summed up along {_axis(k, y.ndim)}", np.cumsum(y, k)
        yield f"summed over {_axis(k, y.ndim)}", np.sum(y, k, keepdims=True) + 0 * y
        yield f"averaged over {_axis(k, y.ndim)}", np.mean(y, k, keepdims=True) + 0 * y
        yield f"without its mean along {_axis(k, y.ndim)}", y - np.mean(y, k, keepdims=True)
        for m in range(k):
            if y.shape[m] == y.shape[k]:
                last = (m, k) == (y.ndim - 2, y.ndim - 1)
                yield (f"transposed: {'the last two' if last else 'two'} axes are exchanged",
                       y.swapaxes(m, k))
    yield "squared", y * y
    yield "the root of what is needed", np.sqrt(y)
    yield "the right one without its sign", np.abs(y)
    yield "cut off below 0", np.maximum(y, 0)
    yield "cut to whole numbers", np.trunc(y)
    yield "rounded to whole numbers", np.round(y)
    yield "in single precision", np.float32(y).astype(float)
    yield "all zero", 0 * y
    yield "inverted: 1 divided by it", 1 / y
    if y.dtype == bool:
        yield "the opposite of what is needed", ~y


def _of_argument(name, x):
    """(text, value) of what an argument may be taken for."""
    if is_dataclass(x):
        for field in fields(x):
            for text, value in _of_argument(f"{name}.{field.name}", getattr(x, field.name)):
                yield text, replace(x, **{field.name: value})
    elif hasattr(x, "_asdict"):
        for field, old in x._asdict().items():
            for text, value in _of_argument(f"{name}.{field}", old):
                yield text, x._replace(**{field: value})
    elif isinstance(x, str):
        yield f"{name} were read backwards", x[::-1]
    elif isinstance(x, (bool, np.bool_)):
        yield f"{name} were the opposite", not x
    elif isinstance(x, (int, float)):
        for text, value in (("were 0 or left out", 0 * x), ("were 1 or left out", 1 + 0 * x),
                            ("were negated", -x), ("were doubled", 2 * x), ("were halved", x / 2),
                            ("were squared", x * x), ("were its root", abs(x) ** .5),
                            ("were inverted", 1 / x if x else x), ("were 1 more", x + 1),
                            ("were 1 less", x - 1), ("were half less", x - .5),
                            ("were half more", x + .5), ("were 1 minus itself", 1 - x)):
            yield f"{name} {text}", value
    elif isinstance(x, np.ndarray) and x.dtype.kind in "fib" and x.size:
        yield f"{name} were all ones or left out", np.ones_like(x)
        yield f"{name} were all zeros or left out", np.zeros_like(x)
        if x.dtype != bool:
            yield f"{name} were negated", -x
            yield f"{name} were squared", x * x
            yield f"{name} were halved", x / 2
            yield f"{name} were doubled", 2 * x
            yield f"{name} were in degrees", x * (180 / np.pi)
            yield f"{name} were turned to radians twice", x * (np.pi / 180)
            yield f"{name} were turned round, 0 for 1 and 1 for 0", 1 - x
            if x.ndim > 1 and x.shape[-1] == x.shape[-2]:
                yield f"{name} were the identity or left out", np.eye(x.shape[-1]) + 0 * x
            yield f"{name} had lost its sign", np.abs(x)
            yield f"{name} were cut off below 0", np.maximum(x, 0)
        if x.ndim:
            mean = x.mean() if x.dtype.kind == "f" else x.max()
            yield f"{name} were its mean everywhere", np.full_like(x, mean)
            yield f"{name} were its sum everywhere", np.full_like(x, x.sum())
        for k in range(x.ndim):
            yield f"{name} were reversed along {_axis(k, x.ndim)}", np.flip(x, k).copy()
            for step, way in ((1, "later"), (-1, "earlier")):
                moved = np.roll(x, step, k)
                yield f"{name} were one position {way} along {_axis(k, x.ndim)}, wrapped round", moved
                edge = moved.copy()
                at = (slice(None),) * k + (0 if step == 1 else -1,)
                edge[at] = 0
                yield f"{name} were one position {way} along {_axis(k, x.ndim)}", edge
                edge = moved.copy()
                edge[at] = x[at]
                yield f"{name} were one position {way} along {_axis(k, x.ndim)}, its edge twice", edge
            if x.dtype.kind == "f":
                yield (f"{name} were summed over {_axis(k, x.ndim)}",
                       np.sum(x, k, keepdims=True) + np.zeros_like(x))
                yield (f"{name} were averaged over {_axis(k, x.ndim)}",
                       np.mean(x, k, keepdims=True) + np.zeros_like(x))
                yield f"{name} were without its mean along {_axis(k, x.ndim)}", x - x.mean(k, keepdims=True)
            first = x[(slice(None),) * k + (slice(0, 1),)]
            yield f"{name} were everywhere what it is at the start of {_axis(k, x.ndim)}", (
                np.repeat(first, x.shape[k], k))
            yield f"{name} were everywhere what it is at the end of {_axis(k, x.ndim)}", (
                np.repeat(np.flip(x, k)[(slice(None),) * k + (slice(0, 1),)], x.shape[k], k))
            for m in range(k):
                if x.shape[m] == x.shape[k]:
                    yield (f"{name} were transposed{' in its first axes' * (k < x.ndim - 1)}",
                           x.swapaxes(m, k).copy())


def _rival(right, failures):
    """A mistake that gives all the numbers that were found."""
    def _outputs(case, _):
        for text, arrays in _scaled(case, case.expected):
            yield f"Everything is {text}.", arrays
        for made in zip(*(list(_of_answers(y)) for y in case.expected)):
            if len({text for text, _ in made}) == 1:
                arrays = [array for _, array in made]
                yield f"It is {made[0][0]}.", arrays
                for text, scaled in _scaled(case, arrays):
                    yield f"It is {made[0][0]}, and {text}.", scaled

    def _inputs(case, kept):
        for i, (name, x) in enumerate(zip(case.names, case.arguments)):
            for text, value in _of_argument(name, x):
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
        for more, scaled in _scaled(case, arrays):
            yield f"It is what would be right if {text}, and {more}.", scaled
        if all(y.ndim > 1 and y.shape[-1] == y.shape[-2] for y in arrays):
            yield (f"It is what would be right if {text}, and the result transposed.",
                   [y.swapaxes(-1, -2) for y in arrays])
    several = any(np.size(y) > 2 for case in failures for y in case.expected)
    return (_common(failures, _outputs) or _common(failures, _inputs)
            or several and _common(failures, lambda case, _: (
                (f"Everything is {text}.", arrays) for text, arrays in
                _scaled(case, case.expected, any_factor=True)))
            or _mostly(failures, _outputs) or "")


def _mostly(failures, candidates):
    """What explains at least half of the failures, and two of them."""
    told: dict[str, int] = {}
    for case in failures:
        for text in dict.fromkeys(text for text, arrays in candidates(case, None)
                                  if _same(case.found, arrays)):
            told[text] = told.get(text, 0) + 1
    most = max(told, key=lambda text: told[text], default="")
    enough = most and told[most] >= max(2, len(failures) / 2)
    return f"In some cases: {most[0].lower()}{most[1:]}" if enough else ""


def _difference(failures):
    """What was added that should not be, what is missing, and numbers in other places."""
    def _terms(case, _):
        for name, x in zip(case.names, case.arguments):
            if not isinstance(x, (np.ndarray, float)) or np.asarray(x).dtype.kind != "f":
                continue
            if all(np.shape(x) == np.shape(y) for y in case.expected):
                moved = Failure(case.names, case.arguments, [y - x for y in case.found], [])
                for text, _ in _scaled(moved, [y - x for y in case.expected], any_factor=any(
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
            for k in range(min(y.ndim for _, y in pairs)):
                name, rest = _axis(k, pairs[0][1].ndim), [
                    tuple(m for m in range(y.ndim) if m != k) for _, y in pairs]
                if all(_same([np.sort(x, k)], [np.sort(y, k)]) for x, y in pairs):
                    yield f"The numbers are right, in other places along {name}.", case.found
                if all(y.ndim > 1 and y.all() and np.all(x != 0) and np.isfinite(x).all() and _same(
                        [np.mean(x / y, axes, keepdims=True) + 0 * y], [x / y])
                       for (x, y), axes in zip(pairs, rest)):
                    yield (f"Each position of {name} is wrong by a factor of its own, the same "
                           "within it."), case.found
                if all(y.ndim > 1 and y.shape[k] > 1 and y.all() and np.all(x) and np.isfinite(
                        x).all() and _same(
                        [np.mean(x / y, k, keepdims=True) + 0 * y], [x / y]) for x, y in pairs):
                    yield (f"The factor by which it is wrong is the same all along {name}."), (
                        case.found)
                offs = [x - y for x, y in pairs]
                if all(y.ndim > 1 and np.isfinite(d).all() and _same([np.mean(d, k, keepdims=True) + 0 * y], [d])
                       for d, (_, y) in zip(offs, pairs)):
                    yield f"It is off by something that is the same all along {name}.", case.found
            if all(_same([np.sort(x.ravel())], [np.sort(y.ravel())]) for x, y in pairs):
                yield "The numbers are the right ones, in other places.", case.found
            if all(_same([np.abs(x)], [np.abs(y)]) for x, y in pairs):
                yield "The signs of some elements are wrong, and nothing else.", case.found
    return _common(failures, _terms) or _common(failures, _places)


def _lost(failures):
    """What holds of every right answer and of no found one."""
    def _square(y):
        return y.ndim > 1 and y.shape[-1] == y.shape[-2] > 1
    properties = {
        "a rotation, which keeps lengths": lambda y: _square(y) and np.allclose(
            y @ y.swapaxes(-1, -2), np.eye(y.shape[-1]), atol=1e-8),
        "symmetric": lambda y: _square(y) and np.allclose(y, y.swapaxes(-1, -2), 1e-9, 1e-12),
        "nowhere below 0": lambda y: y.size > 1 and (y >= 0).all(),
        "made of whole numbers": lambda y: y.size > 1 and (y == np.round(y)).all()}
    for text, holds in properties.items():
        pairs = [(np.asarray(x, float), np.asarray(y, float)) for case in failures
                 for x, y in zip(case.found, case.expected)]
        if all(holds(y) and not holds(x) for x, y in pairs):
            yield f"The right answer is {text}; this one is not."


def _reach(mine, right, case):
    """Where a single upstream 1 arrives, and where it should."""
    dy = case.arguments[0]
    if np.size(dy) < 2 or np.ndim(dy) < 2:
        return
    said = set()
    for at in np.random.default_rng(0).permutation(dy.size)[:12]:
        one = np.zeros(dy.size)
        one[at] = 1
        answers = [_answer(f, (one.reshape(dy.shape), *case.arguments[1:])) for f in (mine, right)]
        if None in answers:
            return
        x, y = (np.concatenate([np.ravel(a) for a in answer]) for answer in answers)
        here, there = x != 0, y != 0
        if _same([x], [y]):
            continue
        said.add("reaches places that it should not" if (here & ~there).any() else
                 "reaches fewer places than it should: something is left out or overwritten"
                 if (there & ~here).any() else
                 "reaches the right places by the right factors, in another order"
                 if _same([np.sort(x)], [np.sort(y)]) else "")
    said.discard("")
    if len(said) == 1 or "reaches places that it should not" in said:
        text = said.pop() if len(said) == 1 else "reaches places that it should not"
        yield f"A single upstream 1 {text}."


def _questions(mine, right, failures):
    """Sentences on how the student's function behaves where the right one behaves otherwise."""
    case = failures[-1]
    asked = [_answer(function, case.arguments) for function in (mine, right)]
    again = _answer(mine, case.arguments)
    if None in asked or again is None:
        return
    if not _same(again, asked[0]):
        yield "It gives another answer when it is asked again: is something drawn or remembered?"
        return
    for i, (name, x) in enumerate(zip(case.names, case.arguments)):
        number = isinstance(x, float) or (isinstance(x, np.ndarray) and x.dtype.kind == "f")
        if not number or not np.size(x) or not np.any(x) or set(np.unique(x)) <= {0.0, 1.0}:
            continue

        def _with(value):
            changed = (*case.arguments[:i], value, *case.arguments[i + 1:])
            return [_answer(function, changed) for function in (mine, right)]
        moved = _with(x * (1 + 0.1 * np.cos(np.arange(np.size(x)))).reshape(np.shape(x))
                      if np.ndim(x) else 1.1 * x)
        if None in moved:
            continue
        listens = [not _same(a, b) for a, b in zip(moved, asked)]
        if listens == [False, True]:
            yield f"It does not listen to {name}."
        elif listens == [True, False]:
            yield f"It depends on {name}, which should make no difference here."
        grown = _with(2.0 * x)
        if None in grown or not all(listens):
            continue
        powers = [next((p for p in (-2, -1, -.5, 0, .5, 1, 2, 3, 4) if _same(
            after, [2.0 ** p * np.asarray(y, float) for y in before])), None)
            for after, before in zip(grown, asked)]
        if powers[1] is not None and powers[0] != powers[1]:
            times = [f"multiplies it by {2.0 ** p:g}" if p is not None else "does not scale it"
                     for p in powers]
            yield f"Doubling {name} {times[0]}, where it {times[1]} if right."
    yield from _clips(mine, right, case, asked)


def _clips(mine, right, case, asked):
    """Whether one clip's numbers reach another clip."""
    sizes = [len(y) if np.ndim(y) else 0 for y in asked[1]]
    N = sizes[0] if sizes else 0
    changed = [np.concatenate([1.5 * x[:1] + .25 if x.dtype.kind == "f" else x[:1] ^ 1, x[1:]])
               if isinstance(x, np.ndarray) and x.ndim and x.dtype.kind in "fi" and len(x) == N
               else x for x in case.arguments]
    after = [_answer(function, changed) for function in (mine, right)]
    if N < 2 or None in after or any(n != N for n in sizes):
        return
    others = [[[y[1:] for y in answer] for answer in pair] for pair in (asked, after)]
    try:
        reach = [not _same(before, now) for before, now in zip(*others)]
    except (IndexError, TypeError):
        return
    if reach == [True, False]:
        yield f"What stands in position 0 of the first axis reaches the others, which is not so if right."


def _answer(function, arguments):
    """A list of arrays, or None where a function refuses."""
    try:
        return function(*copies(arguments))
    except Exception:
        return None


def _place(failures):
    """Sentences on where the wrong elements are and what stands there."""
    told: list[set[str]] = []
    for case in failures:
        here: set[str] = set()
        for i, (a, b) in enumerate(zip(map(np.asarray, case.found), map(np.asarray, case.expected))):
            off = differences(a, b) > CLOSE * max(largest(b), TINY)
            if not off.any() or not off.ndim:
                continue
            here |= _what(a, b, off, case)
            part = Failure(case.names, case.arguments, [a[off]], [])
            here |= {f"Where it is wrong, it is {text}." for text, _ in _scaled(
                part, [b[off]]) if not off.all() and off.sum() > 1}
            for k in range(off.ndim):
                wrong = np.flatnonzero(off.any(axis=tuple(m for m in range(off.ndim) if m != k)))
                n = off.shape[k]
                if len(wrong) == n:
                    continue
                at = {(0,): "the first position", (n - 1,): "the last position",
                      (0, n - 1): "the first and the last position"}.get(tuple(wrong))
                at = at or ("the first positions" if wrong[-1] == len(wrong) - 1 else
                            "the last positions" if wrong[0] == n - len(wrong) else
                            "positions " + ", ".join(map(str, wrong[:6])))
                others = np.moveaxis(b, k, 0)
                if len(wrong) == 2 and _same([np.moveaxis(a, k, 0)[wrong]], [others[wrong[::-1]]]):
                    at = f"{at}, which are exchanged for each other,"
                here.add(f"Wrong only in {at} of {_axis(k, off.ndim)}.")
        told.append(here)
    return sorted(set.intersection(*told), key=lambda text: ("only in" in text, text)) if told else []


def _what(a, b, off, case):
    """What stands at the wrong elements: sentences."""
    here = set()
    if np.isnan(a[off]).all() and not np.isnan(b[off]).any():
        here.add("NaN stands where it is wrong: 0 divided by 0?")
    elif np.isnan(b[off]).all():
        here.add("Wrong only where NaN is needed.")
    elif off.all():
        return here | {"0 is needed everywhere here."} if not b.any() else here
    elif not a[off].any():
        here.add("Where it is wrong, 0 stands: something is missing there.")
    elif not b[off].any():
        here.add("Wrong only where 0 is needed: something that switches off is missing.")
    for name, x in zip(case.names, case.arguments):
        if isinstance(x, np.ndarray) and x.shape == off.shape and x.dtype.kind == "f":
            for where, text in ((x < 0, "is negative"), (x > 0, "is positive"), (x == 0, "is 0"),
                                (np.isnan(x), "is NaN"), (np.isinf(x), "is infinite")):
                if where.any() and not where.all() and not (off & ~where).any():
                    here.add(f"Wrong only where {name} {text}.")
    return here
