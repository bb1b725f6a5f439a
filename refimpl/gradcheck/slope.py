r"""The slope of a function along a line, on both sides of a point, and how well it is known.

Large steps meet curvature and kinks, small ones rounding, and nobody knows beforehand which size is
right: 1e-3 is far too long for sin(1e5 x), and too short for 1e12 + x^2. So all sizes are tried,
from an eighth of the line's unit down to where rounding takes over, and three things are read off:

- the noise of f itself, from differences of high order: those of a smooth function fall from order
  to order, those of rounding do not (Moré and Wild 2011, Estimating computational noise);
- whether there is a kink *here*: the quotients to the right and to the left differ, and go on
  differing as the steps shrink. Beside a kink they agree once the step is shorter than the way to
  it;
- the slope, extrapolated to h = 0 from those steps alone over which the function is smooth, with
  the spread of the two best extrapolations as the error.
"""

from collections.abc import Callable, Sequence
from math import factorial
from typing import Any, NamedTuple

import numpy as np

from .derivative import Line, independent, value_at

LADDER = 0.125 * 4.0 ** -np.arange(26)            # down to 1e-16
SPACINGS = 1e-13, 1e-11, 1e-9, 1e-8, 1e-7        # at which the noise is looked for
LOCAL = 1e-4            # the shortest step is that whose quotient rounding leaves four digits
CURVED = 8              # by which a difference of quotients may grow when the step grows fourfold
ROUNDING = 20           # of the noise: less is no difference
BESIDE = 100            # times the noise of the other side: that is a kink
CERTAIN = 20            # of the error: more is no accident


class Slope(NamedTuple):
    """To both sides of a point.

    left, right : the derivatives; equal where there is no kink; NaN on a side without values
    error : of each, estimated
    why : what keeps the slope from being known, or ""
    """

    left: float
    right: float
    error: float
    why: str = ""

    @property
    def kink(self) -> bool:
        """Whether the two sides differ."""
        return bool(self.left != self.right and np.isfinite(self.left + self.right))

    @property
    def value(self) -> float:
        """The derivative: of the only side, or the middle of both."""
        sides = [s for s in (self.left, self.right) if np.isfinite(s)]
        return float(np.mean(sides)) if sides else np.nan

    def distance(self, claimed: float) -> float:
        """How far a claim lies outside of what is between both sides; inf for NaN.

        >>> Slope(-1.0, 1.0, 1e-12).distance(0.5), Slope(2.0, 2.0, 1e-12).distance(2.5)
        (0.0, 0.5)
        """
        sides = [s for s in (self.left, self.right) if np.isfinite(s)] or [np.nan]
        off = max(min(sides) - claimed, claimed - max(sides), 0.0)
        return np.inf if np.isnan(claimed - sides[0]) else float(off)


@np.errstate(all="ignore")
def slope_at(along: Line, dy: np.ndarray, size: float) -> Slope:
    """The slope of sum(dy * along(h)) at h = 0, whatever kinks, noise and curvature are near.

    size : of the slopes that matter; less than 1e-10 of it need not be resolved

    >>> [round(side, 6) for side in slope_at(np.abs, np.ones(()), 1.0)[:2]]
    [-1.0, 1.0]
    >>> beside = slope_at(lambda h: np.abs(h + 1e-9), np.ones(()), 1.0)
    >>> round(beside.left, 4), beside.kink
    (1.0, False)
    """
    rise, still = _rise(along, dy)
    probes = [[rise(h), rise(-h)] for h in LADDER]
    both = np.array([[up[0] / h, down[0] / -h] for h, (up, down) in zip(LADDER, probes)]).T
    right, left = both
    finite = np.isfinite(both)
    floor = max([size for pair in probes for value, size in pair if np.isfinite(value + size)
                 and abs(value) < size / LOCAL ** 2] or [0.0])
    rounding = 4 * (noise(rise, _plateau(right, left)) + floor) / LADDER + still()
    if not finite.all(axis=0).any():
        return _boundary(both, finite, rounding)
    large = np.where(finite, np.abs(both), 0).max(axis=0)
    rounding += 2 * np.finfo(float).eps * large / LADDER          # of the inputs, x + h v
    local = finite.all(axis=0) & (rounding <= LOCAL * np.maximum(large, 1e-6 * size))
    if not local.any():
        best = int(np.argmin(np.where(finite.all(axis=0), rounding, np.inf)))
        middle = float(both[:, best].mean())
        return Slope(middle, middle, float(rounding[best] + large[best]),
                     "nothing but rounding is seen")
    k = int(np.nonzero(local)[0].max())
    gap = np.abs(right - left)
    if gap[k] > ROUNDING * rounding[k] and k and gap[k - 1] < 1.6 * gap[k]:
        beside = _beside(both, rounding, gap, k)
        if beside:
            return beside
        return _kink(both, rounding, k)
    if gap[k] > ROUNDING * rounding[k] and (not k or gap[k - 1] < 2.5 * gap[k]):
        middle = float(both[:, k].mean())
        return Slope(middle, middle, float(gap[k]),
                     "its slope changes down to the shortest steps that have digits")
    first, seen = k, ROUNDING * rounding
    while first and _smooth(gap[first - 1], gap[first], seen[first - 1], seen[first]):
        first -= 1
    if first and gap[first - 1] <= seen[first] and not _smooth(gap[first - 1], gap[first], 0, 0):
        return _kink(both, rounding, first - 1)          # hidden by rounding further on
    zone = slice(first, k + 1)
    value, error = _limit(both.mean(axis=0)[zone], rounding[zone], 2)
    jump, unsure = _limit((right - left)[zone], rounding[zone], 1)
    half = jump / 2 if abs(jump) > CERTAIN * unsure else 0.0     # a kink among many smooth terms
    if _stairs(both, k):
        return Slope(value, value, float(np.abs(both).max()),
                     "f rises in steps, it is flat between them")
    return Slope(value - half, value + half, max(error, unsure))


def _smooth(longer, shorter, hidden_longer, hidden_shorter):
    """Whether the difference of both sides, at one step and at a quarter of it, is a smooth
    function's: hidden in rounding, or fourfold (64-fold, where the curvature is 0) at the longer.
    """
    if longer <= hidden_longer:
        return True
    return longer <= CURVED ** 2 * max(shorter, hidden_shorter) and longer >= 2.5 * shorter


def noise_of(values: Sequence[Any]) -> np.ndarray:
    r"""The noise of eight values in a row of something smooth, from differences of the orders 4
    to 6:

        sigma_k^2 = (k!)^2 / (2 k)!  mean (Delta^k)^2

    of rounding the same for every order, of a smooth function smaller with each; the smallest
    counts, and none where they fall tenfold.   ->  one for each element of a value

    >>> float(noise_of([1.0, 1.0, 1.0, 1.0, 1.1, 1.0, 1.0, 1.0])) > 0.01
    True
    """
    table, levels = np.array(values), []
    size = np.abs(table).max(axis=0) + float(np.nextafter(0, 1))
    table = table / size                         # squares of the smallest numbers would be 0
    for k in range(1, 7):
        table = np.diff(table, axis=0)
        levels.append(np.sqrt(factorial(k) ** 2 / factorial(2 * k)
                              * np.mean(np.square(table), axis=0)))
    return size * np.where(levels[5] < 0.1 * levels[3], 0.0, np.min(levels[3:], axis=0))


def noise(rise: Callable[[float], tuple[float, float]], longest: float = 1.0) -> float:
    """The noise of a function at several spacings. Of the two sides the calmer one where the other
    is much worse: a kink may lie there.

    rise : h -> value, anything;  longest : spacing that is looked at

    >>> noise(lambda h: (h ** 2, 0.0)) < 1e-20
    True
    """
    sides = []
    for sign in (1, -1):
        found = [0.0]
        for spacing in [s for s in SPACINGS if s <= longest]:
            level = float(noise_of([rise(sign * spacing * k)[0] for k in range(8)]))
            found += [level] if np.isfinite(level) else []
        sides.append(max(found))
    return max(sides) if max(sides) < BESIDE * min(sides) else min(sides)


def _plateau(right, left):
    """The longest of the shortest three neighbouring steps or more over which the quotients of both
    sides agree to a hundredth: what is seen over longer steps is no noise.
    """
    mean = (right + left) / 2
    near = (np.abs(right - left) <= np.abs(mean) / 3) & (mean != 0)
    near[1:] &= np.abs(np.diff(mean)) <= np.abs(mean[1:]) / 3
    run = [i for i in range(2, len(LADDER)) if near[i - 2:i + 1].all()]
    if not run:
        return 1.0
    first = run[-1] - 2
    while first and near[first - 1]:
        first -= 1
    return float(LADDER[first])


def _rise(along, dy):
    """->  h -> sum dy (along(h) - along(0)), output by output, and the rounding of the outputs that
    have changed;   () -> the slope that those which never changed may have
    """
    here = np.asarray(along(0.0))
    moved = independent(along, here)             # or never will
    eps, smallest = float(np.finfo(float).eps), float(np.nextafter(0, 1))

    def _at(h):
        there = value_at(along, h, here)
        changed = there != here
        moved[...] |= changed
        terms = np.where(changed, dy * (there - here), 0.0)
        size = np.where(changed, dy * np.maximum(np.abs(there), np.abs(here)), 0.0)
        return float(terms.sum()), eps * _norm(size) + smallest

    def _still():                # the slope of outputs whose rise was too small for their digits
        return eps / LADDER[0] * _norm(np.where(moved, 0.0, dy * here))
    return _at, _still


def _norm(x):
    """The Euclidean norm, of the smallest numbers too."""
    size = float(np.abs(x).max(initial=0.0))
    return size * float(np.linalg.norm(x / size)) if 0 < size < np.inf else size


def _limit(values, rounding, power):
    """Quotients of steps that fall fourfold, extrapolated to 0 (Richardson, all of the table).
    power : of h with which they err, and its multiples   ->  value, error
    """
    found = [(float(rounding[-1]), float(values[-1]))]
    previous: list[float] = []
    for value, doubt in zip(values, rounding):
        row = [value]
        for k, coarser in enumerate(previous, start=1):
            row.append(row[-1] + (row[-1] - coarser) / (4.0 ** (power * k) - 1))
            found.append((max(abs(row[-1] - row[-2]), abs(row[-1] - coarser), doubt), row[-1]))
        previous = row
    found.sort()
    (error, best), (_, second) = found[0], found[min(1, len(found) - 1)]
    return float(best), float(max(error, abs(best - second)))


def _beside(both, rounding, gap, k):
    """Where two digits are left of still shorter steps, and the sides agree over those: the slope
    there, for the kink lies beside the point.   ->  Slope or None
    """
    told = np.flatnonzero(rounding <= 0.01 * gap[k])
    j = int(told.max()) if len(told) else k
    if gap[j] > 0.5 * gap[k]:
        return None
    middle = float(both[:, j].mean())
    return Slope(middle, middle, float(gap[j] + rounding[j]))


def _kink(both, rounding, k):
    """The slopes to both sides, from steps down to the k-th."""
    right, left = (_side(quotients, rounding, k) for quotients in both)
    return Slope(left[0], right[0], max(left[1], right[1]))


def _side(quotients, rounding, k):
    """One side of a kink.   ->  slope, error"""
    first, gap = k, np.abs(np.diff(quotients, prepend=np.nan))
    while first > 1 and gap[first - 1] <= CURVED * gap[first] + ROUNDING * rounding[first]:
        first -= 1
    return _limit(quotients[max(first - 1, 0):k + 1], rounding[max(first - 1, 0):k + 1], 1)


def _boundary(both, finite, rounding):
    """Where the function has values on one side alone, or on none."""
    nowhere = Slope(np.nan, np.nan, np.inf, "f has no finite values around it")
    sides = [i for i in (0, 1) if finite[i].any()]
    if len(sides) != 1:
        return nowhere
    quotients = both[sides[0]]
    local = finite[sides[0]] & (rounding <= LOCAL * np.abs(quotients))
    if not local.any():
        return nowhere
    k = int(np.nonzero(local)[0].max())
    if k and abs(quotients[k]) > 1.3 * abs(quotients[k - 1]):
        return Slope(np.nan, np.nan, np.inf, "its slope grows without bound towards it")
    value, error = _side(quotients, rounding, k)
    return Slope(np.nan, value, error) if sides[0] == 0 else Slope(value, np.nan, error)


def _stairs(both, k):
    """A function that rises in steps is flat between them, on both sides, and then rises at once:
    the shortest step that moves it has as steep a quotient as one 64 times as long.
    """
    sudden = []
    for side in np.abs(both):
        first = int(np.flatnonzero(side)[-1]) if side.any() else 0
        sudden.append(first >= 3 and side[first] >= 0.25 * side[first - 3])
    return not both[:, k:].any() and all(sudden)
