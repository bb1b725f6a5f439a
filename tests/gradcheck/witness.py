"""Is it true what a checker says? A `Witness` stands in a case's place, notes what it was called
with, and compares the numbers of a message with the derivatives there.

The words of a message are the checker's own; only "found F", "needed X", "between A and B" and
"± U" (or "within U", "allowed U") are looked for.
"""

import re
from typing import Any, NamedTuple

import numpy as np

from tests.gradcheck.cases import Between, Case

NUMBER = r"([-+]?(?:\d+(?:\.\d+)?|\.\d+)(?:[eE][-+]?\d+)?|nan|[-+]?inf)(?![\w])"
FILLING = r"(?:(?:a|any|all|about|exactly|the|is|derivative|value|number|something|from|in)\s+)*"
NEEDED = re.compile(rf"needed:?\s+{FILLING}(?:(?:between\s+)?\[?{NUMBER}\s*(?:and|to|,|\.\.+)\s*)?"
                    rf"{NUMBER}(?!\s*(?:more|digits?|inputs?|arrays?|results?|elements?|axes)\b)")
FOUND = re.compile(rf"found\s+{NUMBER}")
UNCERTAIN = re.compile(rf"(?:±|\+-|\+/-|within|give or take|uncertain\w*(?:\s(?:of|by))?|allowed)"
                       rf"\s*{NUMBER}")
PROMISES = {"linear": r"linear|homogen|-dy|1000 ?\*? ?dy", "repeat": r"repeat|same bits|another "
            r"gradient|calls?\b", "changed": r"changed|overwr|unchanged|only to be read|in place",
            "memory": r"buffer|memory|its own|view|alias", "layout": r"Fortran|layout|order|stride",
            "dtype": r"float32|dtype", "shape": r"shape"}


class Claim(NamedTuple):
    """A sentence "found F, needed from A to B, give or take U", and its numbers as printed."""
    found: str | None
    low: str
    high: str
    uncertainty: float


def leaves(values: Any, inputs: tuple) -> list:
    """One entry for each array of float64 among the inputs (dicts opened), out of values in the
    form of a gradient; None where there is none."""
    values = values if isinstance(values, tuple) else (values,)
    floats = [isinstance(x, dict) or getattr(x, "dtype", None) in (float, complex) for x in inputs]
    if len(values) == len(inputs):
        values = tuple(v for v, is_float in zip(values, floats) if is_float)
    flat: list = []
    for x, v in zip([x for x, is_float in zip(inputs, floats) if is_float], values):
        flat += [None if v is None else v[key] for key in x] if isinstance(x, dict) else [v]
    return flat


def replaced(inputs: tuple, arrays: list) -> tuple:
    """The inputs with these arrays in the places of those of float64."""
    rest = iter(arrays)
    return tuple({key: next(rest) for key in x} if isinstance(x, dict) else
                 next(rest) if getattr(x, "dtype", None) == float else x for x in inputs)


class Witness:
    """A case's f and f_backward, and what they were called with."""

    def __init__(self, case: Case):
        self.case = case
        self.points: list = []    # inputs of f that differ in more than a step along one element
        self.calls: list = []     # (arrays of the inputs, claimed gradients, derivatives)

    def f(self, *inputs):
        arrays = [np.array(x) for x in leaves(inputs, inputs)]
        last = self.points[-1] if self.points else []
        if len(self.points) < 100 and (
                [x.shape for x in arrays] != [x.shape for x in last]
                or sum(np.sum(x != y) for x, y in zip(arrays, last)) > 2):
            self.points.append(arrays)
        return self.case.f(*inputs)

    def f_backward(self, dy, *inputs):
        arrays = [np.array(x) for x in leaves(inputs, inputs)]
        upstream = tuple(map(np.array, dy)) if isinstance(dy, tuple) else np.array(dy)
        gradients = self.case.f_backward(dy, *inputs)
        if len(self.calls) < 60:
            claimed = [None if g is None else np.array(g) for g in leaves(gradients, inputs)]
            truth = [t if t is None or isinstance(t, Between) else Between(t, t)
                     for t in leaves(self.case.truth(upstream, *replaced(inputs, arrays)), inputs)]
            self.calls.append((arrays, claimed, truth))
        return gradients

    def bears_out(self, message: str) -> bool:
        """Is every sentence of the message true of one of the calls?"""
        message = re.split("see it again", message, flags=re.IGNORECASE)[0]
        claims = read(message)
        kinds = {kind for kind, words in PROMISES.items() if re.search(words, message)}
        broken = bool(kinds & set(self.case.breaks.split()))
        if not claims:
            return broken or not kinds
        count = re.search(r"(\d+) of (\d+) elements are wrong", message)
        return (broken or all(self.holds(claim) for claim in claims)) and (
            count is None or any(int(count[1]) <= wrong for wrong in self.counts()))

    def holds(self, claim: Claim) -> bool:
        return any(element(claim, g, t) for _, claimed, truth in self.calls
                   for g, t in zip(claimed, truth) if t is not None and np.shape(g) == t.low.shape
                   ) or any(self.along(claim, *call) for call in self.calls)

    def along(self, claim: Claim, arrays, claimed, truth) -> bool:
        """Does the claim hold along a line that f was called on, not along an axis?

        The line's length is not known, so that the relative error is compared; where 0 was found
        that says nothing.
        """
        middle = [t and (t.low + t.high) / 2 for t in truth]
        kept = [i for i, m in enumerate(middle) if m is not None]
        if (not claim.found or float(claim.found) == 0
                or any(np.shape(claimed[i]) != middle[i].shape for i in kept)):
            return False
        for point in self.points if claim.low == claim.high else []:
            if [x.shape for x in point] == [x.shape for x in arrays]:
                steps = [(p - x).imag if np.iscomplexobj(p) else p - x
                         for p, x in zip(point, arrays)]
                if sum(map(np.count_nonzero, steps)) < 2:
                    continue
                needed = sum(np.sum(steps[i] * middle[i]) for i in kept)
                error = sum(np.sum(steps[i] * (claimed[i] - middle[i])) for i in kept)
                off = (float(claim.found) - float(claim.low)) * needed - float(claim.low) * error
                if not needed and abs(float(claim.low)) <= claim.uncertainty and error:
                    return True                  # flat along the line: its length does not matter
                if needed and abs(off) <= 1e-4 * abs(float(claim.low) * error) + abs(needed) * (
                        claim.uncertainty + unit(claim.low) + unit(claim.found)):
                    return True
        return False

    def counts(self):
        """How many elements of one input, and of all, are wrong in each call."""
        for _, claimed, truth in self.calls:
            each = [np.sum(~((g >= t.low) & (g <= t.high))) for g, t in zip(claimed, truth)
                    if t is not None and np.shape(g) == t.low.shape]
            yield from [*each, sum(each)]


def read(message: str) -> list[Claim]:
    """The claims of a message that have numbers in them."""
    claims, end = [], 0
    for match in NEEDED.finditer(message):
        before = list(FOUND.finditer(message[end:match.start()]))
        after = message[match.end():match.end() + 90].split("needed")[0].split("\n")[0]
        named = UNCERTAIN.search(after)
        claims.append(Claim(before[-1][1] if before else None, match[1] or match[2], match[2],
                            float(named[1]) if named else 0.0))
        end = match.end()
    return claims


def unit(text: str) -> float:
    """Half of the last printed digit's unit, or 5 % of the number where that is less."""
    if not np.isfinite(float(text)):
        return 0.0
    mantissa, _, exponent = text.lower().partition("e")
    places = len(mantissa.partition(".")[2])
    return min(0.5 * 10.0 ** (int(exponent or 0) - places), abs(float(text)) * 0.05)


def element(claim: Claim, claimed: np.ndarray, truth: Between) -> bool:
    """Is the claim true of one of the elements?

    At a kink it must name both one-sided derivatives; elsewhere its range must hold the derivative,
    up to the uncertainty and the digits that it gives.
    """
    low, high = float(claim.low), float(claim.high)
    slack = (claim.uncertainty + max(unit(claim.low), unit(claim.high)) + 1e-13 * np.abs(truth.low)
             + 1e-15 * np.max(np.abs(truth.low), initial=0))
    holds = (low - slack <= truth.low) & (truth.high <= high + slack)
    width = np.asarray(truth.high) - truth.low
    holds &= (width == 0) | ((low >= truth.low - slack - width / 100)
                             & (high <= truth.high + slack + width / 100))
    if claim.found is not None:
        found = float(claim.found)
        holds &= np.isclose(claimed, found, rtol=1e-13, atol=unit(claim.found), equal_nan=True)
    return bool(np.any(holds))
