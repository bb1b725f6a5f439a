"""Checks of arguments: an error names the argument, what was found, what was needed and the likely
fix."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from numbers import Rational
import sys
from typing import Any

import numpy as np

# The precision ladder: every type that an operation takes, and the real type of its precision.
# O stands for exact numbers, `are_exact`.
PRECISION = {np.dtype(code): np.zeros(1, code).real.dtype for code in "fdgFDGO"}
# of a width, stride, padding ...: an index that any machine holds
LARGEST_INDEX = 2 ** 31 - 1


def check_arrays(*, ndim: Mapping[str, int] = {}, real: bool = False, exact: bool = True,
                 shape: Any = None, because: str = ", the shape of the output",
                 **arrays: Any) -> None:
    """Raise ValueError unless all arrays of a call are of one precision and of the right shape.

    arrays : by the names that errors call them; only b, the bias, may be None
    ndim : {name: number of dimensions needed};   real : whether complex numbers are refused;
    exact : whether exact numbers are taken
    shape, because : what the last of the arrays must have, or one of them that has it, and why

    >>> check_arrays(x=np.zeros(3), w=np.zeros(3, "float32"))
    Traceback (most recent call last):
    ValueError: w: found dtype float32, needed the precision of x, float64; try w.astype(x.dtype)
    """
    first = ""
    for name, array in arrays.items():
        if array is None and name == "b":
            continue
        dtype = getattr(array, "dtype", None)
        if (not isinstance(array, (np.ndarray, np.generic)) or dtype not in PRECISION
                or dtype.kind == "O" and not are_exact(array)):
            found = type(array).__name__ if dtype is None else f"dtype {dtype}"
            raise ValueError(f"{name}: found {found}, needed an array of float32, float64 or "
                             f"longdouble; try np.asarray({name}, dtype=float)")
        if dtype.kind == "c" and real:
            raise ValueError(f"{name}: found dtype {dtype}, needed real numbers; this operation "
                             "compares sizes and is not analytic")
        if dtype.kind == "O" and not exact:
            raise ValueError(f"{name}: found exact numbers, needed floating-point ones; this "
                             "operation takes roots that are no fractions")
        if array.ndim != ndim.get(name, array.ndim):
            raise ValueError(f"{name}: found shape {array.shape}, needed {ndim[name]} dimensions")
        first = first or name
        precision = PRECISION[arrays[first].dtype]
        if PRECISION[dtype] != precision:
            raise ValueError(f"{name}: found dtype {dtype}, needed the precision of {first}, "
                             f"{precision}; try {name}.astype({first}.dtype)")
    if shape is not None:
        check_shape(name, array, getattr(shape, "shape", shape), because)


def are_exact(array: Any) -> bool:
    """Whether an array holds fractions or expressions of sympy, with which an operation computes
    exactly. Whole numbers may stand among them, nothing that is rounded.

    >>> are_exact(np.array([Fraction(1, 3), 0])), are_exact(np.array([Fraction(1, 3), 0.5]))
    (True, False)
    """
    return (all(map(_is_exact, array.flat))
            and not all(isinstance(number, (int, np.integer)) for number in array.flat))


def _is_exact(number):
    sympy = sys.modules.get("sympy")                             # nobody else has its expressions
    if sympy is not None and isinstance(number, sympy.Expr):
        return not number.has(sympy.Float)
    if isinstance(number, np.generic):
        return isinstance(number, np.integer) and number == 0    # of np.pad
    return isinstance(number, Rational) and not isinstance(number, bool)


def in_precision(values: Any, like: np.ndarray) -> Any:
    """Numbers in the real precision of an array. Beside exact numbers each becomes the fraction
    that it is.

    >>> in_precision([1, 2], np.zeros(3, "float32")).dtype
    dtype('float32')
    >>> in_precision(0.25, np.array([Fraction(1, 3)]))
    Fraction(1, 4)
    """
    if like.dtype.kind != "O":
        return np.asarray(values, dtype=like.real.dtype)
    return np.frompyfunc(_fraction, 1, 1)(values)


def _fraction(number):
    return number if _is_exact(number) and not isinstance(number, int) else Fraction(number)


def check_shape(name: str, array: Any, shape: Sequence[int], because: str = "") -> None:
    """Raise ValueError unless the array has this shape.

    >>> check_shape("b", np.zeros(3), (4,), ", one for each filter")
    Traceback (most recent call last):
    ValueError: b: found shape (3,), needed (4,), one for each filter
    """
    if np.shape(array) != tuple(shape):
        raise ValueError(f"{name}: found shape {np.shape(array)}, needed {tuple(shape)}{because}")


def check_whole(name: str, value: Any, least: int, most: int = LARGEST_INDEX) -> int:
    """A whole number from `least` to `most`; bool is none.   ->  int.   Raises ValueError.

    >>> check_whole("stride", np.int32(2), 1)
    2
    >>> check_whole("stride", 2.0, 1)
    Traceback (most recent call last):
    ValueError: stride: found 2.0, needed a whole number from 1 on
    """
    whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not whole or not least <= value <= most:
        limits = f"of at most {most}" if whole and value > most else f"from {least} on"
        raise ValueError(f"{name}: found {_short(value)}, needed a whole number {limits}")
    return int(value)


def check_positive(name: str, value: Any, error: type[ValueError] = ValueError) -> float:
    """A finite real number above 0.   ->  float.   Raises `error`.

    >>> check_positive("gamma", float("nan"))
    Traceback (most recent call last):
    ValueError: gamma: found nan, needed a finite number above 0
    """
    number = (isinstance(value, (int, float, np.integer, np.floating))
              and not isinstance(value, bool))
    if not number or not 0 < value <= sys.float_info.max:
        raise error(f"{name}: found {_short(value)}, needed a finite number above 0")
    return float(value)


def _short(value):
    """A value for a message; of numbers with hundreds of digits only how long they are."""
    if isinstance(value, int) and value.bit_length() > 200:
        return f"a number of {value.bit_length()} bits"
    return repr(value)[:80]
