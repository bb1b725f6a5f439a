"""Checks of arguments: an error names the argument, what was found, what was needed and the likely fix."""

import numpy as np

# The precision ladder: every type that an operation takes, and the real type that carries its precision.
PRECISION = {np.dtype(t): np.dtype(p) for t, p in (
    (np.float32, np.float32), (np.complex64, np.float32), (np.float64, np.float64), (np.complex128, np.float64),
    (np.longdouble, np.longdouble), (np.clongdouble, np.longdouble))}


def check_arrays(*, ndim=None, real=False, **arrays):
    """All arrays of a call must be of one precision, and real numbers where `real` says so. None is passed over.

    ndim : {name: number of dimensions needed}.   Raises ValueError.
    """
    first = None
    for name, array in arrays.items():
        if array is None:
            continue
        dtype = getattr(array, "dtype", None)
        if not isinstance(array, (np.ndarray, np.generic)) or dtype not in PRECISION:
            found = f"dtype {dtype}" if dtype is not None else type(array).__name__
            raise ValueError(f"{name}: found {found}, needed an array of float32, float64 or longdouble; try np.asarray({name}, dtype=float)")
        if dtype.kind == "c" and real:
            raise ValueError(f"{name}: found dtype {dtype}, needed real numbers; this operation compares sizes and is not analytic")
        if ndim and name in ndim and array.ndim != ndim[name]:
            raise ValueError(f"{name}: found shape {array.shape}, needed {ndim[name]} dimensions")
        if first is None:
            first = name, PRECISION[dtype]
        elif PRECISION[dtype] != first[1]:
            raise ValueError(f"{name}: found dtype {dtype}, needed the precision of {first[0]}, {first[1]}; "
                             f"try {name}.astype({first[0]}.dtype)")


def check_whole(name, value, least):
    """A whole number from `least` on; bool is none.   ->  int"""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)) or value < least:
        raise ValueError(f"{name}: found {value!r}, needed a whole number from {least} on")
    return int(value)


def check_shape(name, array, shape, because=""):
    """Raise ValueError unless the array has this shape."""
    if np.shape(array) != tuple(shape):
        raise ValueError(f"{name}: found shape {np.shape(array)}, needed {tuple(shape)}{because}")
