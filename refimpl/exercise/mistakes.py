"""Which mistake would give just these numbers?

No exercise is known here. Rival answers are made by applying common mistakes to what the right
function is asked, or to what it answers; a rival is named only if it gives the student's numbers in
every case that failed. Where none does, the student's function is asked a few questions: which
arguments does it listen to, how does it grow with them, do clips reach each other, and where are
the wrong elements.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
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


def explain(mine: Callable[..., Any], right: Callable[..., list],
            failures: Sequence[Failure]) -> str:
    """What the mistake looks like, in a sentence, or "".

    mine, right : functions of a case's arguments to a list of arrays

    >>> dy, x = np.array([1.0, 2.0]), np.array([3.0, 5.0])
    >>> case = Failure(("dy", "x"), (dy, x), [x * dy], [2 * x * dy])
    >>> explain(lambda dy, x: [x * dy], lambda dy, x: [2 * x * dy], [case])
    'Everything is half of what is needed.'
    """
    failures = sorted(failures, key=lambda case: sum(np.size(y) for y in case.expected))[:4]
    with np.errstate(all="ignore"):
        return (_form(failures) or _rival(right, failures) or _difference(failures)
                or " ".join([*_questions(mine, right, failures), *_place(failures)][:2]))


def _same(found, expected):
    return len(found) == len(expected) and all(
        np.shape(a) == np.shape(b) and differences(a, b).max(initial=0.0)
        <= CLOSE * max(largest(b), TINY) for a, b in zip(found, expected))


def _axis(k, name="it"):
    return f"the {AXES[k]} axis" if k < len(AXES) else f"axis {k}"


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
        for k in range(max(np.ndim(y) for y in case.found + case.expected)):
            for text, change in ((f"{_axis(k)} was kept, with length 1",
                                  lambda y: np.expand_dims(y, k)),
                                 (f"{_axis(k)} was summed away", lambda y: np.sum(y, axis=k)),
                                 (f"{_axis(k)} was averaged away", lambda y: np.mean(y, axis=k)),
                                 (f"the first position of {_axis(k)} is missing",
                                  lambda y: np.delete(y, 0, axis=k)),
                                 (f"the last position of {_axis(k)} is missing",
                                  lambda y: np.delete(y, -1, axis=k))):
                yield text, _each(change, case.expected)
            for m in range(k):
                yield (f"{_axis(m)} and {_axis(k)} are exchanged",
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
    return "The length is wrong along " + " and ".join(_axis(k) for k in wrong) + "."


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
            sizes |= {f"the length of {_axis(k)} of {name}": n for k, n in enumerate(x.shape)}
            sizes |= {f"the lengths of {_axis(m)} and {_axis(k)} of {name}, multiplied":
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
        if any_factor and np.size(arrays[0]) > 1:
            yield "wrong by one factor, the same throughout a case", case.found


def _of_answers(y):
    """(text, array) of what is made of an answer too much or too little."""
    y = np.asarray(y)
    for k in range(y.ndim):
        yield f"reversed along {_axis(k)}", np.flip(y, k)
        for step, way in ((1, "later"), (-1, "earlier")):
            yield f"one position {way} along {_axis(k)}, and wrapped round", np.roll(y, step, k)
            for edge, mode in (("zeros", "constant"), ("the edge repeated", "edge")):
                wide = np.pad(y, [(1, 1) if a == k else (0, 0) for a in range(y.ndim)], mode)
                part = slice(0, y.shape[k]) if step == 1 else slice(2, None)
                yield (f"one position {way} along {_axis(k)}, with {edge}",
                       wide[(slice(None),) * k + (part,)])
        yield f"summed up along {_axis(k)}", np.cumsum(y, k)
        yield f"summed over {_axis(k)}", np.sum(y, k, keepdims=True) + 0 * y
        yield f"averaged over {_axis(k)}", np.mean(y, k, keepdims=True) + 0 * y
        yield f"without its mean along {_axis(k)}", y - np.mean(y, k, keepdims=True)
        for m in range(k):
            if y.shape[m] == y.shape[k]:
                yield f"transposed ({_axis(m)} and {_axis(k)} exchanged)", y.swapaxes(m, k)
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
    if isinstance(x, str):
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
            yield f"{name} had lost its sign", np.abs(x)
            yield f"{name} were cut off below 0", np.maximum(x, 0)
        if x.ndim:
            mean = x.mean() if x.dtype.kind == "f" else x.max()
            yield f"{name} were its mean everywhere", np.full_like(x, mean)
            yield f"{name} were its sum everywhere", np.full_like(x, x.sum())
        for k in range(x.ndim):
            yield f"{name} were reversed along {_axis(k)}", np.flip(x, k).copy()
            for step, way in ((1, "later"), (-1, "earlier")):
                moved = np.roll(x, step, k)
                yield f"{name} were one position {way} along {_axis(k)}, wrapped round", moved
                edge = moved.copy()
                at = (slice(None),) * k + (0 if step == 1 else -1,)
                edge[at] = 0
                yield f"{name} were one position {way} along {_axis(k)}", edge
                edge = moved.copy()
                edge[at] = x[at]
                yield f"{name} were one position {way} along {_axis(k)}, its edge twice", edge
            if x.dtype.kind == "f":
                yield (f"{name} were summed over {_axis(k)}",
                       np.sum(x, k, keepdims=True) + np.zeros_like(x))
                yield (f"{name} were averaged over {_axis(k)}",
                       np.mean(x, k, keepdims=True) + np.zeros_like(x))
                yield f"{name} were without its mean along {_axis(k)}", x - x.mean(k, keepdims=True)
            first = x[(slice(None),) * k + (slice(0, 1),)]
            yield f"{name} were everywhere what it is at the start of {_axis(k)}", (
                np.repeat(first, x.shape[k], k))
            yield f"{name} were everywhere what it is at the end of {_axis(k)}", (
                np.repeat(np.flip(x, k)[(slice(None),) * k + (slice(0, 1),)], x.shape[k], k))
            for m in range(k):
                if x.shape[m] == x.shape[k]:
                    yield f"{name} were transposed", x.swapaxes(m, k).copy()


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
        for i, y in enumerate(case.expected):                    # one of several results
            if len(case.expected) > 1 and np.shape(y) == np.shape(case.found[i]):
                others = [*case.found[:i], y, *case.found[i + 1:]]
                if _same(others, case.expected):
                    one = Failure(case.names, case.arguments, [case.found[i]], [y])
                    for text, _ in _scaled(one, [y]):
                        yield f"Result {i} is {text}.", case.found
                    for text, array in _of_answers(y):
                        yield f"Result {i} is {text}.", [
                            *case.found[:i], array, *case.found[i + 1:]]

    def _inputs(case, kept):
        for i, (name, x) in enumerate(zip(case.names, case.arguments)):
            for text, value in _of_argument(name, x):
                if kept is None or any(f" if {text}" in other for other in kept):
                    yield from _asked(case, {i: value}, text)
            for j, y in enumerate(case.arguments[:i]):
                if type(x) is type(y) and np.shape(x) == np.shape(y):
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
    return _common(failures, _outputs) or _common(failures, _inputs) or _common(
        failures, lambda case, _: ((f"Everything is {text}.", arrays) for text, arrays in
                                _scaled(case, case.expected, any_factor=True)))


def _difference(failures):
    """What was added that should not be, or is missing."""
    def _terms(case, _):
        for name, x in zip(case.names, case.arguments):
            if isinstance(x, (np.ndarray, float)) and np.asarray(x).dtype.kind == "f":
                for factor, text in ((1, "once too often"), (-1, "once too rarely"),
                                     (-2, "with the wrong sign"), (-.5, "by half too rarely")):
                    for axes in ("", "[:, None]", "[:, None, None]"):
                        shaped = np.reshape(x, np.shape(x) + (1,) * axes.count("None"))
                        try:
                            yield f"{name} is added {text}.", [
                                y + factor * shaped + 0 * y for y in case.expected]
                        except ValueError:       # does not broadcast
                            pass
    return _common(failures, _terms)


def _questions(mine, right, failures):
    """Sentences on how the student's function behaves where the right one behaves otherwise."""
    case = failures[0]
    asked = [_answer(function, case.arguments) for function in (mine, right)]
    again = _answer(mine, case.arguments)
    if None in asked or again is None:
        return
    if not _same(again, asked[0]):
        yield "It gives another answer when it is asked again: is something drawn or remembered?"
        return
    for i, (name, x) in enumerate(zip(case.names, case.arguments)):
        number = isinstance(x, float) or (isinstance(x, np.ndarray) and x.dtype.kind == "f")
        if not number or not np.size(x) or not np.any(x):
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
    changed = [np.concatenate([1.5 * x[:1] + .25, x[1:]]) if isinstance(x, np.ndarray) and x.ndim
               and x.dtype.kind == "f" and len(x) == N else x for x in case.arguments]
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
                here.add(f"Wrong only in {at} of {_axis(k)}.")
        told.append(here)
    return sorted(set.intersection(*told), key=lambda text: "only in pos" in text) if told else []


def _what(a, b, off, case):
    """What stands at the wrong elements: sentences."""
    here = set()
    if np.isnan(a[off]).all() and not np.isnan(b[off]).any():
        here.add("NaN stands where it is wrong: 0 divided by 0?")
    elif np.isnan(b[off]).all():
        here.add("Wrong only where NaN is needed.")
    elif off.all():
        return here
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
