"""What common mistakes make of a right answer, or of what is asked: the rivals that a wrong answer
is compared with.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np

from ..gradcheck.difference import TINY, differences, largest

CLOSE = 1e-8              # a rival that is this near, relative to the largest element, is the same
ORDINALS = ("first", "second", "third", "fourth")
SIMPLE = {0.5: "half of what is needed", 2.0: "twice what is needed",
          1 / 3: "a third of what is needed", 3.0: "three times what is needed",
          -1.0: "the right one negated",
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


def same(found: Sequence[Any], expected: Sequence[Any]) -> bool:
    """Whether two lists of arrays are the same, within what a rival may differ by.

    >>> same([np.ones(2)], [np.ones(2) + 1e-12]), same([np.ones(2)], [np.ones(3)])
    (True, False)
    """
    return len(found) == len(expected) and all(
        np.shape(a) == np.shape(b) and differences(a, b).max(initial=0.0)
        <= CLOSE * max(largest(b), TINY) for a, b in zip(found, expected))


def axis_name(k: int, ndim: int) -> str:
    """An axis in words.

    >>> axis_name(0, 3), axis_name(2, 3)
    ('the first axis', 'the last axis')
    """
    return ("the first axis" if k == 0 else "the last axis" if k == ndim - 1 else
            f"the {ORDINALS[k]} axis" if k < len(ORDINALS) else f"axis {k}")


def _factors(case):
    """(text, number) of the factors by which an answer may be wrong."""
    yield from ((text, factor) for factor, text in SIMPLE.items())
    sizes: dict[str, float] = {}
    for name, x in zip([*case.names, *["the result"] * len(case.expected)],
                       [*case.arguments, *case.expected]):
        if isinstance(x, np.ndarray) and x.ndim:
            axes = [axis_name(k, x.ndim) for k in range(x.ndim)]
            sizes |= {f"the length of {axes[k]} of {name}": n for k, n in enumerate(x.shape)}
            sizes |= {f"the lengths of {axes[m]} and {axes[k]} of {name}, multiplied":
                      n * x.shape[m] for k, n in enumerate(x.shape) for m in range(k)}
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


def scaled_answers(case: Failure, arrays: Sequence[Any], any_factor: bool = False
                   ) -> Iterator[tuple[str, list]]:
    """(text, arrays) for the factors that lead from some arrays to the found ones.

    any_factor : also for one that has no name

    >>> case = Failure(["x"], (np.ones(3),), [np.full(3, 2.0)], [np.ones(3)])
    >>> next(scaled_answers(case, case.expected))[0]
    'twice what is needed'
    """
    if any(np.shape(a) != np.shape(b) for a, b in zip(case.found, arrays)):
        return
    pairs = [(f.flat[np.argmax(np.abs(y))], np.max(np.abs(y)), y) for f, y in
             zip(map(np.asarray, case.found), map(np.asarray, arrays)) if y.size and y.dtype.kind
             in "fiu"]
    ratio = next((f / y.flat[np.argmax(np.abs(y))] for f, size, y in pairs if size > 0), None)
    if ratio is None or not np.isfinite(ratio) or ratio == 0:
        return
    scaled = [ratio * np.asarray(y, float) for y in arrays]
    if same(case.found, scaled):
        for text, factor in _factors(case):
            if abs(ratio - factor) <= 1e-8 * abs(factor):
                yield text, case.found
        if any_factor:
            yield "wrong by one factor, the same throughout a case", case.found


def made_of_answer(y: Any) -> Iterator[tuple[str, np.ndarray]]:
    """(text, array) of what is made of an answer too much or too little.

    >>> [text for text, x in made_of_answer(np.array([1.0, 2.0])) if x[0] == 2][0]
    'reversed along the first axis'
    """
    y = np.asarray(y)
    for k in range(y.ndim):
        axis = axis_name(k, y.ndim)
        yield f"reversed along {axis}", np.flip(y, k)
        for step, way in ((1, "later"), (-1, "earlier")):
            yield f"one position {way} along {axis}, and wrapped round", np.roll(y, step, k)
            for edge in ("constant", "edge"):
                wide = np.pad(y, [(1, 1) if a == k else (0, 0) for a in range(y.ndim)],
                              edge)  # type: ignore[call-overload]
                part = slice(0, y.shape[k]) if step == 1 else slice(2, None)
                yield (f"one position {way} along {axis}, with "
                       f"{'zeros' if edge == 'constant' else 'the edge repeated'}",
                       wide[(slice(None),) * k + (part,)])
        yield f"summed up along {axis}", np.cumsum(y, k)
        yield f"summed over {axis}", np.sum(y, k, keepdims=True) + 0 * y
        yield f"averaged over {axis}", np.mean(y, k, keepdims=True) + 0 * y
        yield f"without its mean along {axis}", y - np.mean(y, k, keepdims=True)
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


def made_of_argument(name: str, x: Any) -> Iterator[tuple[str, Any]]:
    """(text, value) of what an argument may be taken for.

    >>> [text for text, value in made_of_argument("t", 3) if value == 4]
    ['t were 1 more']
    """
    if is_dataclass(x) and not isinstance(x, type):
        for field in fields(x):
            for text, value in made_of_argument(f"{name}.{field.name}", getattr(x, field.name)):
                yield text, replace(x, **{field.name: value})
    elif hasattr(x, "_asdict"):
        for field, old in x._asdict().items():
            for text, value in made_of_argument(f"{name}.{field}", old):
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
        yield from ((f"{name} {text}", value) for text, value in _made_of_array(x))


def _made_of_array(x):
    """What an array may be taken for, without its name."""
    yield "were all ones or left out", np.ones_like(x)
    yield "were all zeros or left out", np.zeros_like(x)
    if x.dtype != bool:
        yield from (("were negated", -x), ("were squared", x * x), ("were halved", x / 2),
                    ("were doubled", 2 * x), ("were in degrees", x * (180 / np.pi)),
                    ("were turned to radians twice", x * (np.pi / 180)),
                    ("were turned round, 0 for 1 and 1 for 0", 1 - x))
        if x.ndim > 1 and x.shape[-1] == x.shape[-2]:
            yield "were the identity or left out", np.eye(x.shape[-1]) + 0 * x
        yield from (("had lost its sign", np.abs(x)), ("were cut off below 0", np.maximum(x, 0)))
    if x.ndim:
        mean = x.mean() if x.dtype.kind == "f" else x.max()
        yield "were its mean everywhere", np.full_like(x, mean)
        yield "were its sum everywhere", np.full_like(x, x.sum())
    for k in range(x.ndim):
        axis = axis_name(k, x.ndim)
        yield f"were reversed along {axis}", np.flip(x, k).copy()
        for step, way, at in ((1, "later", 0), (-1, "earlier", -1)):
            moved = np.roll(x, step, k)
            yield f"were one position {way} along {axis}, wrapped round", moved
            for end, text in ((0, ""), (np.take(x, at, k), ", its edge twice")):
                changed = moved.copy()
                changed[(slice(None),) * k + (at,)] = end
                yield f"were one position {way} along {axis}{text}", changed
        if x.dtype.kind == "f":
            yield f"were summed over {axis}", np.sum(x, k, keepdims=True) + np.zeros_like(x)
            yield f"were averaged over {axis}", np.mean(x, k, keepdims=True) + np.zeros_like(x)
            yield f"were without its mean along {axis}", x - x.mean(k, keepdims=True)
        for at, where in ((0, "start"), (-1, "end")):
            yield (f"were everywhere what it is at the {where} of {axis}",
                   np.repeat(np.take(x, [at], k), x.shape[k], k))
        for m in range(k):
            if x.shape[m] == x.shape[k]:
                yield (f"were transposed{' in its first axes' * (k < x.ndim - 1)}",
                       x.swapaxes(m, k).copy())
