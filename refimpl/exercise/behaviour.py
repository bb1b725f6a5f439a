"""How a wrong answer behaves: where its wrong elements are, what it listens to, how it grows, and
which property of the right one it has lost.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from .rivals import CLOSE, Failure, axis_name, same, scaled_answers
from ..gradcheck.contract import copies
from ..gradcheck.difference import TINY, differences, largest
from ..gradcheck.structure import is_float

Asked = Callable[..., list[Any]]


def lost(failures: Sequence[Failure]) -> Iterator[str]:
    """What holds of every right answer and of no found one.

    >>> list(lost([Failure([], (), [np.array([0.5, 1])], [np.array([0.0, 1])])]))
    ['The right answer is made of whole numbers; this one is not.']
    """
    def _square(y):
        return y.ndim > 1 and y.shape[-1] == y.shape[-2] > 1
    properties = {
        "a rotation, which keeps lengths": lambda y: _square(y) and np.allclose(
            y @ y.swapaxes(-1, -2), np.eye(y.shape[-1]), atol=1e-8),
        "symmetric": lambda y: _square(y) and np.allclose(y, y.swapaxes(-1, -2), 1e-9, 1e-12),
        "nowhere below 0": lambda y: y.size > 1 and (y >= 0).all(),
        "the same number in many places, which share it": lambda y: (
            y != 0).sum() > 8 and len(np.unique(y[y != 0])) <= (y != 0).sum() / 2,
        "made of whole numbers": lambda y: y.size > 1 and (y == np.round(y)).all()}
    for text, holds in properties.items():
        pairs = [(np.asarray(x, float), np.asarray(y, float)) for case in failures
                 for x, y in zip(case.found, case.expected)]
        if all(holds(y) and not holds(x) for x, y in pairs):
            yield f"The right answer is {text}; this one is not."


def reached(mine: Asked, right: Asked, failures: Sequence[Failure]) -> Iterator[str]:
    """Where a single upstream 1 arrives, and where it should.

    >>> case = Failure(["dy"], (np.ones((1, 3)),), [np.ones((1, 3))], [np.ones((1, 3))])
    >>> next(reached(lambda dy: [0 * dy], lambda dy: [dy], [case]))[:51]
    'A single upstream 1 reaches fewer places than it sh'
    """
    told = dict.fromkeys(text for case in failures[-4:] for text in [_reached(mine, right, case)]
                         if text)
    if told:
        yield f"A single upstream 1 {min(told, key=lambda text: 'should not' in text)}."


def _reached(mine, right, case):
    """Where single upstream 1s of one case arrive, in words, or ""."""
    dy, said = case.arguments[0], set()
    if np.size(dy) < 2 or np.ndim(dy) < 2 or np.size(dy) > 1000:
        return ""
    for at in np.random.default_rng(0).permutation(dy.size)[:12]:
        one = np.zeros(dy.size)
        one[at] = 1
        answers = [_answer(f, (one.reshape(dy.shape), *case.arguments[1:])) for f in (mine, right)]
        if None in answers:
            return ""
        x, y = (np.concatenate([np.ravel(a) for a in answer]) for answer in answers)
        here, there = x != 0, y != 0
        if not same([x], [y]):
            said.add("reaches places that it should not" if (here & ~there).any() else
                     "reaches fewer places than it should: something is left out or overwritten"
                     if (there & ~here).any() else
                     "reaches the right places by the right factors, in another order"
                     if same([np.sort(x)], [np.sort(y)]) else "")
    said.discard("")
    return said.pop() if len(said) == 1 else "reaches places that it should not" if said else ""


def simpler(mine: Asked, right: Asked, failures: Sequence[Failure]) -> Iterator[str]:
    """What would have to be simpler for the student's function to be right: one argument at a time.

    >>> case = Failure(["a", "k"], (np.arange(4.0), 3.0), [], [])
    >>> list(simpler(lambda a, k: [a * k * k], lambda a, k: [a * k], [case]))
    ['It would be right if k were 1.']
    """
    case = failures[-1]
    here = _answer(right, case.arguments)
    for i in sorted(range(len(case.names)), key=lambda i: np.size(case.arguments[i])
                    if isinstance(case.arguments[i], np.ndarray) else 0):
        for text, value in _simple(case.arguments[i]):
            changed = (*case.arguments[:i], value, *case.arguments[i + 1:])
            found, needed = _answer(mine, changed), _answer(right, changed)
            if None in (found, needed, here) or same(needed, here) or not same(found, needed):
                continue
            seen = np.unique(np.concatenate([np.ravel(y) for y in needed]))
            if len(seen) > 2 or seen.any() and all(np.size(y) == 1 for y in needed):
                yield f"It would be right if {case.names[i]} {text}."
                break


def _simple(x):
    """(text, value) of what is simpler than an argument."""
    if isinstance(x, (int, float)) and not isinstance(x, bool):
        yield from (("were 0", 0 * x), ("were 1", 1 + 0 * x))
    elif is_float(x) and x.size:
        yield "were all zeros", 0 * x
        if x.ndim > 1 and x.shape[-1] == x.shape[-2]:
            yield "were the identity", np.eye(x.shape[-1]) + 0 * x
            yield "were symmetric", (x + x.swapaxes(-1, -2)) / 2
        yield "were all ones", np.ones_like(x)
        yield "were nowhere negative", np.abs(x)
        for k in range(x.ndim):
            if x.shape[k] > 1:
                first = np.take(x, [0], axis=k)
                yield f"were the same all along {axis_name(k, x.ndim)}", first + 0 * x


def questions(mine: Asked, right: Asked, failures: Sequence[Failure]) -> Iterator[str]:
    """Sentences on how the student's function behaves where the right one behaves otherwise.

    >>> case = Failure(["a"], (np.full(2, 3.0),), [], [])
    >>> list(questions(lambda a: [a * a], lambda a: [a], [case]))
    ['Doubling a multiplies it by 4, where it multiplies it by 2 if right.']
    """
    case = failures[-1]
    asked = [_answer(function, case.arguments) for function in (mine, right)]
    again = _answer(mine, case.arguments)
    if None in asked or again is None:
        return
    if not same(again, asked[0]):
        yield "It gives another answer when it is asked again: is something drawn or remembered?"
        return
    for i, (name, x) in enumerate(zip(case.names, case.arguments)):
        number = isinstance(x, float) or is_float(x)
        if not number or not np.size(x) or not np.any(x) or set(np.unique(x)) <= {0.0, 1.0}:
            continue

        def _with(value):
            changed = (*case.arguments[:i], value, *case.arguments[i + 1:])
            return [_answer(function, changed) for function in (mine, right)]
        moved = _with(x * (1 + 0.1 * np.cos(np.arange(np.size(x)))).reshape(np.shape(x))
                      if np.ndim(x) else 1.1 * x)
        if None in moved:
            continue
        listens = [not same(a, b) for a, b in zip(moved, asked)]
        if listens == [False, True]:
            yield f"It does not listen to {name}."
        elif listens == [True, False]:
            yield f"It depends on {name}, which should make no difference here."
        grown = _with(2.0 * x)
        if None in grown or not all(listens):
            continue
        powers = [next((p for p in (-2, -1, -.5, 0, .5, 1, 2, 3, 4) if same(
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
        reach = [not same(before, now) for before, now in zip(*others)]
    except (IndexError, TypeError):
        return
    if reach == [True, False]:
        yield ("What stands in position 0 of the first axis reaches the others, which is not so if "
               "right.")


def _answer(function, arguments):
    """A list of arrays, or None where a function refuses."""
    try:
        return function(*copies(arguments))
    except Exception:
        return None


def places(failures: Sequence[Failure]) -> list[str]:
    """Sentences on where the wrong elements are and what stands there.

    >>> places([Failure([], (), [np.array([1.0, 0])], [np.array([1.0, 2])])])[0]
    'Where it is wrong, 0 stands: something is missing there.'
    """
    told: list[set[str]] = []
    for case in failures:
        here: set[str] = set()
        for a, b in zip(map(np.asarray, case.found), map(np.asarray, case.expected)):
            off = differences(a, b) > CLOSE * max(largest(b), TINY)
            if not off.any() or not off.ndim:
                continue
            here |= _what(a, b, off, case)
            part = Failure(case.names, case.arguments, [a[off]], [])
            here |= {f"Where it is wrong, it is {text}." for text, _ in scaled_answers(
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
                if len(wrong) == 2 and same([np.moveaxis(a, k, 0)[wrong]], [others[wrong[::-1]]]):
                    at = f"{at}, which are exchanged for each other,"
                here.add(f"Wrong only in {at} of {axis_name(k, off.ndim)}.")
        told.append(here)
    common = set.intersection(*told) if told else set()
    return sorted(common, key=lambda text: ("only in" in text, text))


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
