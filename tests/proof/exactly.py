"""Fractions in the place of floating-point numbers."""

from fractions import Fraction

import numpy as np


def exactly(value):
    """Every floating-point number as the fraction that it is; what is none stays."""
    if isinstance(value, float):
        return Fraction(value)
    if isinstance(value, np.ndarray) and value.dtype.kind == "f":
        return fractions(value.astype(object).flat, value.shape)
    return value


def fractions(numbers, shape):
    """An array of these numbers as fractions."""
    return np.array([None, *map(Fraction, numbers)], dtype=object)[1:].reshape(shape)


def is_exact(value):
    """Whether nothing in an answer is rounded: fractions and whole numbers, or none at all."""
    if value is None:
        return True
    value = np.asarray(value)
    return value.dtype.kind in "iub" or value.dtype.kind == "O" and all(
        isinstance(v, (int, np.integer, Fraction)) or v == -np.inf for v in value.flat)
