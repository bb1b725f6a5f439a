"""What a student's function handed back, beside what the right one does."""

from typing import Any

import numpy as np

from ..gradcheck.difference import TINY, differences, largest
from ..gradcheck.report import Row

OWN_FUNCTION = "the package's own function"
_PRODUCTS = ("dot", "einsum", "tensordot", "inner", "vdot", "convolve", "correlate", "outer",
             "kron")


class Counting(np.ndarray):
    """An array that counts the products of two arrays that it takes part in."""

    products = 0

    def __array_ufunc__(self, ufunc, method, *inputs, **options):
        arrays = [np.asarray(x) for x in inputs]
        pair = len(arrays) == 2 and min(x.size for x in arrays) > 1
        Counting.products += ufunc is np.matmul or (ufunc is np.multiply and pair)
        if "out" in options:
            options["out"] = tuple(np.asarray(x) for x in options["out"])
        made = getattr(ufunc, method)(*arrays, **options)
        return made.view(Counting) if isinstance(made, np.ndarray) else made

    def __array_function__(self, func, types, args, kwargs):
        Counting.products += func.__name__ in _PRODUCTS
        return super().__array_function__(func, types, args, kwargs)


def named_results(expected: Any) -> dict[str, Any]:
    """The results of the right function by name.

    >>> named_results((1, 2)), named_results(3)
    ({'output 0': 1, 'output 1': 2}, {'': 3})
    """
    if isinstance(expected, dict):
        return expected
    if isinstance(expected, tuple) and len(expected) > 1:
        return {f"output {i}": y for i, y in enumerate(expected)}
    return {"": expected[0] if isinstance(expected, tuple) and expected else expected}


def taken(found: Any, expected: dict[str, Any]) -> dict[str, Any]:
    """The student's results by the same names; lists and tuples do for arrays.   ->  {name: array}
    Raises TypeError: nothing returned, or another number of results.

    >>> taken([1, 2], {"a": 0, "b": 0})
    {'a': 1, 'b': 2}
    """
    if found is None:
        raise TypeError("found None, needed " + (", ".join(filter(None, expected)) or "an array")
                        + "; is there a return?")
    if isinstance(found, dict) and set(found) == set(expected):
        return {name: found[name] for name in expected}
    if len(expected) == 1:
        shape = np.shape(next(iter(expected.values())))
        if isinstance(found, (tuple, list)) and len({np.shape(y) for y in found if isinstance(
                y, np.ndarray)}) > 1:
            raise TypeError(f"found {len(found)} results, needed 1")
        if isinstance(found, (tuple, list)) and len(found) == 1 and np.shape(found) != shape:
            found = found[0]
        elif isinstance(found, (tuple, list)) and any(isinstance(y, np.ndarray) and np.shape(y)
                                                      == shape for y in found[:1]):
            raise TypeError(f"found {len(found)} results, needed 1")
        found = [found]
    if not isinstance(found, (tuple, list, np.ndarray)) or len(found) != len(expected):
        count = len(found) if isinstance(found, (tuple, list, dict)) else 1
        raise TypeError(f"found {count} results, needed {len(expected)}")
    return dict(zip(expected, found))


def as_array(value: Any) -> tuple[np.ndarray | None, str]:
    """A value as an array.   ->  array, or None and what it is instead.

    >>> as_array([1, 2])[0], as_array(1j)
    (array([1, 2]), (None, 'complex numbers'))
    """
    try:
        array = np.asarray(value)
    except ValueError:
        return None, "lists of different lengths"
    return (array, "") if array.dtype.kind in "biuf" else (
        None, "complex numbers" if array.dtype.kind == "c" else type(value).__name__)


def compared(name: str, found: Any, expected: Any, tolerance: float) -> tuple[Row, str]:
    """One result against the right one.   ->  Row, message of the worst element or ""

    >>> compared("dx", [1.0, 2.0], np.array([1.0, 3.0]), 1e-9)[1]
    'dx[1]: found 2, needed 3; 1 of 2 elements are wrong.'
    """
    begin = f"{name}: " if name else ""
    array, what = as_array(found)
    expected = np.asarray(expected)
    if array is None:
        return (Row(name, False, False, np.inf, "its type"),
                f"{begin}found {what}, needed numbers of shape {expected.shape}")
    if isinstance(found, (list, tuple)) and array.size == expected.size == 0:
        array = array.reshape(expected.shape)                    # a list of nothing has no shape
    if array.shape != expected.shape:
        return (Row(name, False, False, np.inf, "its shape"),
                f"{begin}found shape {array.shape}, needed {expected.shape}")
    kinds = {"b": "True and False", "i": "whole numbers", "u": "whole numbers", "f": "float64"}
    needs, has = kinds[expected.dtype.kind], kinds[array.dtype.kind]
    if expected.dtype.kind == "f":
        other = array.dtype.kind == "f" and array.dtype.itemsize != expected.dtype.itemsize
        has, needs = (str(array.dtype), str(expected.dtype)) if other else (needs, needs)
        if expected.dtype.itemsize < 8 and tolerance:
            tolerance = max(tolerance, 1e-5)             # a sum in another order
    if expected.size and has != needs and isinstance(found, (np.ndarray, np.generic)):
        return (Row(name, False, False, np.inf, "its type"),
                f"{begin}found {has}, needed {needs}: another kind of number (dtype)")
    x, y = array.astype(float), expected.astype(float)
    off, bound = differences(x, y), tolerance * max(largest(y), TINY)
    good = off <= bound
    row = Row(name, bool((off == 0).all()), bool(good.all()), float(off.max(initial=0.0)),
              OWN_FUNCTION)
    if good.all():
        return row, ""
    worst = np.unravel_index(int(np.argmax(off)), off.shape)
    where = f"[{', '.join(str(int(n)) for n in worst)}]" if off.ndim else ""
    return row, (f"{begin or 'the result'}{where}".replace(": [", "[") + f": found {x[worst]:.6g}, "
                 f"needed {y[worst]:.6g}; {int((~good).sum())} of {good.size} elements are wrong.")
