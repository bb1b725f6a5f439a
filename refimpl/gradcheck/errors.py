"""What a failed check says."""

from typing import Any


class GradientError(AssertionError):
    """A gradient, or the function that claims it, is wrong; the message says where, what was found
    and what was needed.
    """


class UndecidedError(GradientError):
    """Whether a gradient is right cannot be told with the digits that the function has there; not
    shown to be wrong, and not shown to be right.
    """


def describe(found: Any, expected: Any, tolerance: float) -> str:
    """Two numbers and how far they may be apart, in words.

    >>> describe(1.25, 1.5, 1e-12)
    'found 1.25, needed 1.5 (difference 0.25, allowed 1e-12)'
    """
    found, expected = float(found), float(expected)
    return (f"found {found:.17g}, needed {expected:.17g} (difference {abs(found - expected):.3g}, "
            f"allowed {tolerance:.3g})")
