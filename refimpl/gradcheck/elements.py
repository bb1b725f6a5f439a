"""Each element of a gradient, by the instrument that suits it; and all of them along a line.

First what is quick: the complex step, or central differences over the usual steps, trusted where
their own error is small and no kink shows. What does not agree with the quick measurement is
measured again with the slopes to both sides (see `slope`), and that decides.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from . import derivative
from .contract import copies
from .difference import TINY
from .errors import describe
from .report import Row
from .slope import CERTAIN, Slope, noise_of, slope_at
from .structure import is_float, paired

Function = Callable[..., Any]

EXACT = 1e-13           # of the terms that an element sums: the complex step's rounding
PLAIN = 1e-12           # of a derivative by differences, beyond its own error
RESOLVED, NEGLIGIBLE = 1e-4, 1e-9       # of the element, of the largest: what must be told
BLURRED = 1e-6          # of the largest, where kinks or noise are near
JUDGED = 12             # so many of the elements that disagree at first sight are measured again
SHORTER = 0.7e-30, 0.3e-30               # other complex steps: f's own rounding differs in them
CLAIMS_APART = 1e-9     # between the points at which the rounding of a claim is measured


def judge_elements(f: Function, f_backward: Function, dy: np.ndarray, inputs: Sequence[Any], i: int,
                   name: str, claim: np.ndarray, rng: np.random.Generator, seed: int, most: int,
                   sample: int) -> tuple[Row, str, str]:
    """One input's gradient.   ->  Row, message of the worst wrong element or "", message of the
    first undecided one or ""
    """
    x = inputs[i]
    if claim.shape != x.shape:
        return (Row(name, False, False, np.inf, "its shape"),
                f"{name}: found a gradient of shape {claim.shape}, needed {x.shape}, the input's",
                "")
    v = random_directions(inputs, [i], rng)
    analytic = derivative.is_analytic(derivative.line(f, inputs, v), dy)
    elements = np.arange(x.size)
    if x.size > most:
        elements = rng.choice(x.size, min(most, sample), replace=False)
        for way in (v[i], own_sizes(x, v[i])):
            if not _line_agrees(f, dy, inputs, i, claim, way, analytic):
                elements = np.union1d(elements, _locate(f, dy, inputs, i, claim, way, analytic))
    look = _Look(f, f_backward, dy, inputs, i, claim)
    claimed = claim.ravel()[elements].astype(float)
    measured, allowed = look.quickly(elements, analytic)
    differences = np.abs(claimed - measured)
    suspects = np.flatnonzero(~(differences <= allowed))
    order = np.argsort(-np.where(np.isnan(differences), np.inf, differences)[suspects],
                       kind="stable")
    wrong, doubts = [], []
    for n in suspects[order][:JUDGED]:
        good, slope, allowed[n] = look.again(elements[n], measured[n] if analytic else None)
        differences[n] = slope.distance(claimed[n])
        if good is None:
            doubts.append((n, slope))
        elif not good:
            wrong.append((n, slope))
    instrument = "complex step" if analytic else "central differences"
    row = Row(name, bool((claimed == measured).all()), not wrong and not doubts,
              float(differences.max(initial=0.0)),
              f"{instrument}, {len(elements)} of {x.size} elements",
              float(np.max(allowed, initial=0.0) / max(np.abs(claim).max(initial=0.0), TINY)))
    where = [", ".join(str(int(n)) for n in np.unravel_index(elements[m], x.shape))
             for m, _ in (wrong or doubts)]
    if wrong:
        worst = int(np.argmax([differences[n] for n, _ in wrong]))
        count = f"{'at least ' * (len(suspects) > JUDGED)}{len(wrong)} of {len(elements)}"
        return row, _wrong(f"{name}[{where[worst]}]", wrong[worst][1], claimed[wrong[worst][0]],
                           allowed[wrong[worst][0]], instrument, count, seed, name,
                           where[worst]), ""
    if doubts:
        n, slope = doubts[0]
        return row, "", (f"{name}[{where[0]}]: {undecided(claimed[n], slope)}; {len(doubts)} of "
                         f"{len(elements)} elements are undecided")
    return row, "", ""


def undecided(claimed: float, slope: Slope) -> str:
    """Why there is no verdict, in words.

    >>> undecided(1.0, Slope(0.5, 0.5, 0.25))
    'found 1, which is undecided: f has the digits for 0.5 +- 0.25 alone'
    """
    if slope.why:
        return f"found {claimed:.17g}, which is undecided: {slope.why}"
    return (f"found {claimed:.17g}, which is undecided: f has the digits for {slope.value:.17g} +- "
            f"{slope.error:.3g} alone")


def _wrong(where, slope, claimed, allowed, instrument, count, seed, name, place):
    """The message of a wrong element."""
    if slope.kink:
        low, high = sorted((slope.left, slope.right))
        needed = f"a value between {low:.9g} and {high:.9g}"
        said = (f"found {claimed:.17g}, needed {needed}, the slopes to both sides of a kink "
                f"(allowed {allowed:.3g}),")
    else:
        needed = f"{slope.value!r}"
        said = describe(claimed, slope.value, allowed)
    return (f"{where}: {said} by {instrument}; {count} elements are wrong.\n"
            "See it again, with f, f_backward and inputs as they are now:\n"
            f"    dy = np.random.default_rng({seed}).standard_normal(np.shape(f(*inputs)))\n"
            f"    gradients = f_backward(dy, *inputs)      # the one of {name} at [{place}] "
            f"should be {needed}")


class _Look:
    """Measures the elements of one input's gradient."""

    def __init__(self, f: Function, f_backward: Function, dy: np.ndarray, inputs: Sequence[Any],
                 i: int, claim: np.ndarray) -> None:
        self.f, self.f_backward, self.dy = f, f_backward, dy
        self.inputs, self.i, self.claim = inputs, i, claim
        self.size = max(float(np.abs(claim[np.isfinite(claim)]).max(initial=0.0)), TINY)
        self._noise: np.ndarray | None = None

    def _along(self, e, step):
        v = np.zeros(self.inputs[self.i].size)
        v[e] = step
        return derivative.line(self.f, self.inputs, {self.i: v.reshape(self.inputs[self.i].shape)})

    def quickly(self, elements: np.ndarray, analytic: bool) -> tuple[np.ndarray, np.ndarray]:
        """->  measured, how far each may be off; NaN where nothing was measured"""
        found = np.full((len(elements), 2), np.nan)
        step = typical_size(self.inputs[self.i])
        for n, e in enumerate(elements):
            if analytic:
                exact = derivative.complex_step_with_terms(self._along(e, 1.0), self.dy)
                found[n] = (exact[0], EXACT * exact[1]) if exact else np.nan
                continue
            value, error, jump = derivative.extrapolate_with_jump(self._along(e, step), self.dy)
            bound = 10 * error + PLAIN * abs(value)
            smooth = jump <= 1e-3 * abs(value) + bound
            told = bound <= max(1e-3 * RESOLVED * abs(value), NEGLIGIBLE * self.size * step)
            found[n] = value / step, (bound / step if smooth and told else np.nan)
        return found[:, 0], found[:, 1]

    def again(self, e: int, exact: float | None) -> tuple[bool | None, Slope, float]:
        """->  right, wrong (False) or undecided (None); its Slope; how far it may be off"""
        claimed = float(self.claim.flat[e])
        element = abs(float(self.inputs[self.i].flat[e]))
        rounding = self.rounding(e)
        slope = self._measured(e, typical_size(self.inputs[self.i]))
        if slope.why or CERTAIN * slope.error > RESOLVED * abs(slope.value):
            other = self._measured(e, element or 1.0)
            slope = min(slope, other, key=lambda one: (bool(one.why), one.error))
        # where the step's product is too small for its digits, the differences decide alone
        if exact is not None and 1e-270 < abs(exact) < np.inf and not slope.kink:
            along = self._along(e, 1.0)
            others = [derivative.complex_step_with_terms(along, self.dy, step) for step in SHORTER]
            rounding += max(CERTAIN * abs(exact - value) + EXACT * terms
                            for value, terms in filter(None, others))
            if not np.isfinite(slope.value) or abs(slope.value - exact) <= max(
                    CERTAIN * slope.error, 1e-6 * abs(exact)):
                slope = Slope(exact, exact, 0.0)
        allowed = CERTAIN * slope.error + PLAIN * abs(slope.value) * (slope.error > 0) + rounding
        off = slope.distance(claimed)
        if not np.isfinite(slope.value):
            return None, slope, allowed
        if not off <= allowed:
            return False, slope, allowed
        told = allowed <= max(RESOLVED * max(abs(slope.left), abs(slope.right)),
                              BLURRED * self.size) or (claimed == slope.left == slope.right == 0
                                                       and not slope.why)
        return (True if told else None), slope, allowed

    def _measured(self, e, step):
        slope = slope_at(self._along(e, step), self.dy, self.size * step)
        return Slope(slope.left / step, slope.right / step, slope.error / step, slope.why)

    def rounding(self, e: int) -> float:
        """What the rounding of the backward does to an element: the noise of its claims at eight
        points in a row, thirty times that, at most 1e-10 of the largest.
        """
        if self._noise is None:
            rng = np.random.default_rng(0)
            chosen = [n for n, x in enumerate(self.inputs) if is_float(x)]
            v = random_directions(self.inputs, chosen, rng, own=True)
            claims = []
            for k in range(8):
                inputs = [x + k * CLAIMS_APART * v[n] if n in v else x
                          for n, x in enumerate(self.inputs)]
                try:
                    found = paired(self.f_backward(*copies((self.dy, *inputs))), inputs)[self.i]
                    claims.append(found if np.shape(found) == self.claim.shape
                                  else np.full(self.claim.shape, np.nan))
                except Exception:                # whatever it is: it is not for these
                    claims.append(self.claim)
            self._noise = 30 * noise_of(claims)
        noise = float(self._noise.flat[e])
        return min(noise, 1e-10 * self.size) if np.isfinite(noise) else 0.0


def agrees_along(along: derivative.Line, dy: np.ndarray, claims: dict[int, np.ndarray],
                 v: dict[int, np.ndarray], tolerance: float
                 ) -> tuple[bool | None, Slope, float, float]:
    """Whether claimed gradients are right together, along direction v.   ->  True, False, or None
    where it cannot be told; the Slope; what was claimed; what was allowed
    """
    claimed, size = summed_along(claims, v)
    terms = sum(float(np.abs(claims[i] * v[i]).sum()) for i in v)
    loose = tolerance * size + PLAIN * terms
    value, error, jump = derivative.extrapolate_with_jump(along, dy)
    bound = 10 * error + loose
    if abs(value - claimed) <= bound <= max(RESOLVED, 2 * tolerance) * size and (
            jump <= 1e-3 * size + bound):
        return True, Slope(value, value, error), claimed, bound
    slope = slope_at(along, dy, size)
    allowed = CERTAIN * slope.error + loose
    off = slope.distance(claimed)
    if off <= allowed:
        told = allowed <= max(RESOLVED, 2 * tolerance) * size
        return (True if told else None), slope, claimed, allowed
    hidden = bool(slope.why) or slope.kink or not np.isfinite(slope.value)
    return (None if hidden else False), slope, claimed, allowed


def _line_agrees(f, dy, inputs, i, claim, v, analytic):
    """Whether all elements of one gradient are right together, along direction v."""
    along = derivative.line(f, inputs, {i: v})
    if not analytic:
        return bool(agrees_along(along, dy, {i: claim}, {i: v}, 0.0)[0])
    claimed, _ = summed_along({i: claim}, {i: v})
    exact = derivative.complex_step(along, dy)
    return exact is not None and abs(exact - claimed) <= EXACT * float(np.abs(claim * v).sum())


def _locate(f, dy, inputs, i, claim, v, analytic):
    """The element where a large gradient is wrong, by halving the line: that half whose derivative
    differs more holds it.   ->  flat index
    """
    def _mismatch(elements):
        part = np.zeros(v.size)
        part[elements] = v.ravel()[elements]
        along = derivative.line(f, inputs, {i: part.reshape(v.shape)})
        found = derivative.complex_step(along, dy) if analytic else None
        found = derivative.extrapolate(along, dy)[0] if found is None else found
        # of these elements alone: no NaN of another one times 0
        claimed = float(np.sum(claim.ravel()[elements] * part[elements]))
        return np.inf if np.isnan(found - claimed) else abs(found - claimed)
    elements = np.arange(v.size)
    while len(elements) > 1:
        elements = max(np.array_split(elements, 2), key=_mismatch)
    return elements[0]


def summed_along(claims: dict[int, np.ndarray], v: dict[int, Any]) -> tuple[float, float]:
    """sum <gradient, v>, the claimed derivative along a line, and the size of its terms (as if
    their signs were random).
    """
    terms = [np.ravel(claims[i] * v[i]) for i in v]
    size = float(np.sqrt(sum(np.square(t).sum() for t in terms)))
    return float(sum(t.sum() for t in terms)), max(size, TINY)


def random_directions(inputs: Sequence[Any], chosen: Iterable[int], rng: np.random.Generator,
                      own: bool = False) -> dict[int, np.ndarray]:
    """A direction for each chosen input, of the input's own size, or (own) each element's."""
    v = {i: typical_size(inputs[i]) * rng.standard_normal(inputs[i].shape) for i in chosen}
    return {i: own_sizes(inputs[i], v[i]) for i in v} if own else v


def own_sizes(x: np.ndarray, v: np.ndarray) -> np.ndarray:
    """A direction that moves each element by its own size; zeros as before. No kink at 0 is crossed
    along it.
    """
    return np.where(x == 0, v, v * np.abs(x) / typical_size(x))


def typical_size(x: np.ndarray) -> float:
    """The size of an input's elements, to which steps are relative; 1 for zeros.

    >>> typical_size(np.array([3.0, -3.0])), typical_size(np.zeros(2))
    (3.0, 1.0)
    """
    size = float(np.sqrt(np.mean(np.square(x)))) if x.size else 0.0
    return size if 0 < size < np.inf else 1.0
