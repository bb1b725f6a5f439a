"""Calls at the ends: NaN and infinities in each argument, the largest and the smallest numbers, and
very different sizes side by side."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..gradcheck.difference import differences, largest
from ..gradcheck.structure import is_float
from .calls import Case, answered, precisions
from .specification import as_tuple
from .yardstick import Yardstick

POISONS = {"NaN first": (0, np.nan), "NaN in the middle": (0.5, np.nan), "NaN last": (1, np.nan),
           "infinity": (0.5, np.inf), "minus infinity": (0.3, -np.inf)}
SCALES = {"float32": 10.0 ** np.array([35, 30, 25, 17, 12, 6]),
          "float64": 10.0 ** np.array([300, 250, 200, 150, 100, 50])}
# What sums has some room left below the largest number; what chooses needs none.
CHOOSING = ("relu", "max_pool1d", "max_pool1d_indices", "max_unpool1d", "random_depool1d",
            "avg_depool1d")
NATURAL = "gaussian_kernel", "exponential_map", "effort_measures"    # float64 alone, not searched
APART = {"float32": (1e22, 1e6), "float64": (1e160, 1e50)}  # a clip or channel from its neighbour


def _places(call):
    """Floating-point arrays of a call: (name, how to get it, how to put another in its stead)."""
    for i, x in enumerate(call.arguments):
        if is_float(x) and x.size:
            yield call.names[i], x, lambda y, i=i: replace(
                call, arguments=(*call.arguments[:i], y, *call.arguments[i + 1:]))
    for name, x in call.attributes.items():
        if is_float(x) and x.size:
            yield name, x, lambda y, name=name: replace(
                call, attributes={**call.attributes, name: y})


def poisoned(call: Case, reference: Callable) -> Iterator[Case]:
    """NaN and infinities in each argument in turn (in a network NaN, in the first alone); not where
    a mask may multiply them or leave them out."""
    masked = any(isinstance(x, np.ndarray) and x.dtype.kind in "bui"
                 for x in (*call.arguments, *call.attributes.values()))
    whole = call.operation.whole_range or call.operation.name in NATURAL
    single = "float32" in call.operation.precisions
    if not whole and (not single or masked):
        return
    for one, precision in precisions(call):
        places = list(_places(one))
        for name, x, put in places if whole else places[:1]:
            every = call.operation.whole_range
            for kind, (place, value) in list(POISONS.items())[:None if every else 3]:
                y = x.copy()
                y.flat[int(place * (y.size - 1))] = value
                try:
                    case = answered(put(y), reference, f"{kind}, {name}{precision}")
                    yield _either_way(case, reference, name, y, put)
                except ValueError:                               # refused, which is tried elsewhere
                    continue


def _either_way(case, reference, name, poisoned_array, put):
    """Whether a convolution multiplies the zeros of its padding, or of its stride, is its own
    affair: a number times nothing is then 0 or NaN."""
    if case.operation.name == "gram":                    # (D + D^T) H, or D H + D^T H
        return replace(case, free=tuple(np.isinf(y) for y in case.expected))
    if case.operation.name == "gaussian_kernel":         # its points may be centred first
        return replace(case, free=tuple(np.isfinite(y) for y in case.expected))
    if case.operation.name not in ("conv1d", "conv_transpose1d"):
        return case
    here = ~np.isfinite(poisoned_array)
    other = [as_tuple(reference(*put(np.where(here, value, poisoned_array)).arguments,
                                **case.attributes)) for value in (1.0, 2.0)]
    backward = case.function.endswith("_backward")
    free: list[Any] = []
    expected: list[Any] = []
    for number, (a, b, y) in enumerate(zip(*other, case.expected)):
        if y is None or not (name == "w" or (backward and number == 1)):
            free.append(None)
            expected.append(y)
            continue
        reached = a != b                                # by the one element, through a product
        row = reached.any(axis=-1, keepdims=True) & ~reached
        free.append(row)
        expected.append(np.where(row, a, y))
    finite = put(np.where(here, 1.0, poisoned_array).astype(poisoned_array.dtype))
    sizes = Yardstick(reference, finite.arguments, finite.attributes, other[0])
    return replace(case, expected=tuple(expected), free=tuple(free), yardstick=sizes)


def ranges(call: Case, reference: Callable) -> Iterator[Case]:
    """Each argument, and all of them, as large and as small as the answer allows; and clips, or
    channels, of very different sizes side by side."""
    for one, precision in precisions(call):
        limits = np.finfo(one.precision)
        places = [place for place in _places(one) if call.operation.whole_range
                  or place[0] in one.names]
        every = [*places, ("all", None, lambda scale: None)] if call.operation.whole_range else []
        for name, x, put in every:
            for kind, sign in (("huge", 1.0), ("tiny", -1.0)):
                scales = list(SCALES[one.precision] ** sign)
                if x is not None and call.operation.name in CHOOSING:
                    scales.insert(0, 0.0)                        # stands for the very end
                end = 0.95 * limits.max if sign > 0 else limits.tiny / 50
                for scale in scales:
                    case = _within(
                        _scaled(one, scale) if x is None else put(_times(x, scale)) if scale else
                        put(_times(_times(x, 1 / (largest(x) or 1.0)), float(end))), reference,
                        f"{kind}, {name}{precision}", limits)
                    if case is not None:
                        yield case
                        break
        floats = [place for place in places if place[0] in one.names]
        for (name, x, put), (other, y, _) in zip(floats,
                                                 floats[1:]) if call.operation.whole_range else ():
            at = one.names.index(other)
            little = limits.tiny / 50 * (1e6 if _shared(one) else 1.0)
            small = put(_times(_times(x, 1 / (largest(x) or 1.0)), float(little)))
            pair = replace(small, arguments=tuple(_times(v, SCALES[one.precision][1]) if i == at
                                                  else v for i, v in enumerate(small.arguments)))
            case = _within(pair, reference, f"{'very small' if _shared(one) else 'subnormal'} "
                           f"{name}, huge {other}{precision}", limits)
            if case is not None:
                yield case
        far = APART[one.precision] if call.operation.whole_range else APART[one.precision][1:]
        yield from beside(one, reference, far, precision)


def _shared(call):
    """Whether an upstream gradient is divided by a number of elements, which may be done first."""
    return (call.operation.name in ("mean_squares", "squared_error", "absolute_error")
            and call.attributes.get("reduction", "mean") == "mean")


def beside(call: Case, reference: Callable, factors: Sequence[float] = (),
           precision: str = "") -> Iterator[Case]:
    """Clips, and channels, of very different size side by side, in the call's own precision or, for
    no factors, a little apart in both."""
    if not factors:
        for one, precision in precisions(call):
            yield from beside(one, reference, (1e7,), precision)
        return
    for axis, what in ((0, "clips"), (1, "channels")):
        for factor in factors:
            case = _within(_uneven(call, axis, 1 / factor), reference,
                           f"{what} {factor:g} apart{precision}", np.finfo(call.precision))
            if case is not None:
                yield case


def _scaled(call, scale):
    return replace(call,
                   arguments=tuple(_times(x, scale) if is_float(x) else x for x in call.arguments))


@np.errstate(all="ignore")
def _times(x, scale):
    return np.asarray((x.astype(float) * scale).astype(x.dtype))


def _within(call, reference, kind, limits):
    """The case, if numbers and answer are normal numbers with room to spare, else None."""
    if not all(np.isfinite(x).all() for x in (*call.arguments, *call.attributes.values())
               if is_float(x)):
        return None
    try:
        case = answered(call, reference, kind)
    except (ValueError, np.linalg.LinAlgError):
        return None
    sizes = case.yardstick.sizes if case.yardstick else ()
    if not all(x is None or _normal(x, size, limits)
               for x, size in zip(case.expected or (), sizes)):
        return None
    at_the_end = any(is_float(x)
                     and not np.all((np.abs(x) < limits.max / 16)
                                    & ((x == 0) | (np.abs(x) > limits.tiny)))
                     for x in (*call.arguments, *(case.expected or ())))
    sure = call.operation.whole_range and not at_the_end
    return case if sure or _decided(case, reference) else None


@np.errstate(all="ignore")
def _decided(case, reference):
    """Whether the reference finds the answer in the case's precision too: where one argument of a
    network drowns another, which of two frames is the larger is a matter of rounding, and a
    subnormal number has few digits."""
    found = as_tuple(reference(*case.arguments, **case.attributes))
    return all(y is None or np.all(differences(x, y) <= allowed)
               for x, y, allowed in zip(found, case.expected, case.allowances()))


@np.errstate(all="ignore")
def _normal(x, summed, limits):
    """Whether there is room above what the elements sum, and below them; a number that is chosen
    and not computed needs none."""
    size, summed = np.abs(x[x != 0]), np.broadcast_to(summed, np.shape(x))[x != 0]
    if np.all(summed <= 8 * size.max(initial=0.0)) and np.all(size <= limits.max):
        return True
    return bool(np.isfinite(size).all() and np.all(summed < limits.max / 1e3)
                and np.all(size > limits.tiny * 1e3))


def _uneven(call, axis, factor):
    """The call with every second clip, or channel, of its batched arguments far smaller."""
    upstream = call.function.endswith("_backward")
    batched = {i + upstream for i in call.operation.batched}
    arguments = list(call.arguments)
    for i in batched:
        x = arguments[i]
        if not isinstance(x, np.ndarray) or x.dtype.kind != "f" or x.ndim <= axis:
            continue
        shape = [1] * x.ndim
        shape[axis] = -1
        sizes = np.where(np.arange(x.shape[axis]) % 2, factor, 1.0).astype(x.dtype)
        arguments[i] = _times(x, sizes.reshape(shape))
    return replace(call, arguments=tuple(arguments))
