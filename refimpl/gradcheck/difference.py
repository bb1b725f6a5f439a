"""How far two arrays are apart, wherever a verdict depends on it."""

from typing import Any

import numpy as np

TINY = float(np.finfo(float).tiny)


@np.errstate(all="ignore")
def differences(found: Any, expected: Any) -> np.ndarray:
    """|found - expected|, element by element, in float64.

    Two arrays (or numbers) of one shape  ->  array of that shape: 0 where both are equal, infinite
    alike or NaN, inf where only one of them is infinite or NaN

    >>> differences([1.0, 2.5, np.nan, np.inf], [1.0, 2.0, np.nan, 3.0]).tolist()
    [0.0, 0.5, 0.0, inf]
    """
    found, expected = np.asarray(found), np.asarray(expected)
    if expected.dtype.kind not in "fc":
        found, expected = found.astype(float), expected.astype(float)
    off = np.abs(found - expected).astype(float)
    same = (found == expected) | (np.isnan(found) & np.isnan(expected))
    return np.where(same, 0.0, np.where(np.isnan(off), np.inf, off))


def largest(x: Any) -> float:
    """The size of the largest finite element, 0 where there is none.

    >>> largest([1.0, -3.0, np.inf, np.nan])
    3.0
    """
    x = np.asarray(x)
    x = x if x.dtype.kind in "fc" else x.astype(float)
    return float(np.abs(x[np.isfinite(x)]).max(initial=0.0))


def relative_difference(found: Any, expected: Any) -> np.ndarray:
    """`differences` in units of the largest finite element expected, of 1 where all are 0.

    >>> relative_difference([1.0, 3.0], [1.0, 4.0]).tolist()
    [0.0, 0.25]
    """
    return differences(found, expected) / (largest(expected) or 1.0)
