r"""What every backward must keep, whatever it computes.

Inputs and upstream gradient are read and left as they were, to the last bit; the gradient has its
input's shape and type and memory of its own; it is the same bits on every call, whatever was
computed in between; it is linear in the upstream gradient; and it does not depend on how the arrays
lie in memory.

`check_contract` checks all of it. The questions it asks, from `copies` to `nonlinearity`, are those
of every judge in this package, of other implementations and of exercises.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from .difference import TINY, differences, largest
from .errors import GradientError
from .structure import is_float, paired

LINEAR, LAYOUT = 1e-12, 1e-12                                    # relative to the largest element
MIXTURE = 1.7, -0.6                                   # weights with which two gradients are added
MULTIPLES = -1.0, 1000.0, 1e-3                   # of dy: abs, clipping or a threshold would show


def _filler(x):
    """What stands between the elements: of whole numbers nothing that could be missed."""
    return np.nan if x.dtype.kind == "f" else 0


def _every_second(x):
    """The same array as every second element of a larger one."""
    large = np.full(tuple(2 * n for n in x.shape), _filler(x), x.dtype)
    spread = large[(slice(None, None, 2),) * x.ndim]
    spread[...] = x
    return spread


def _slice(x, axis):
    """The same array as a part of one that is longer along an axis."""
    larger = [(2, 1) if n == axis else (0, 0) for n in range(x.ndim)]
    wide = np.pad(x, larger, constant_values=_filler(x))
    return wide[(slice(None),) * axis + (slice(2, 2 + x.shape[axis]),)]


def _any_stride(x):
    """A stride along an axis of one element is never walked: it may be anything."""
    x = x.copy()
    strides = [s if n > 1 else 7 * x.itemsize for n, s in zip(x.shape, x.strides)]
    return np.lib.stride_tricks.as_strided(x, x.shape, strides)


LAYOUTS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "Fortran order": np.asfortranarray, "every second element of a larger array": _every_second,
    "negative strides": lambda x: np.flip(np.ascontiguousarray(np.flip(x))),
    "a slice of the last axis": lambda x: _slice(x, x.ndim - 1),
    "a slice of the second axis": lambda x: _slice(x, min(1, x.ndim - 1)),
    "the last axis reversed": lambda x: np.ascontiguousarray(x[..., ::-1])[..., ::-1],
    "the last two axes exchanged": lambda x: np.ascontiguousarray(
        x.swapaxes(-1, -min(2, x.ndim))).swapaxes(-1, -min(2, x.ndim)),
    "any stride along an axis of one": _any_stride}
# For arrays that are equal along their first axis, or everywhere.
STRIDE_0 = {"stride 0": lambda x: np.broadcast_to(x[:1].copy(), x.shape),
            "stride 0 of the last axis": lambda x: np.broadcast_to(x[..., :1].copy(), x.shape),
            "every stride 0": lambda x: np.broadcast_to(x.flat[0].copy(), x.shape)}


def copies(values: Iterable[Any], layout: str = "", writeable: bool = True,
           only: int | None = None) -> list[Any]:
    """Copies of the arrays among some values, which are handed out in their stead.

    layout : a key of LAYOUTS, in which the arrays then lie in memory;  only : the place of the one
    value that does, instead of all

    >>> copies([np.eye(2), 3], layout="negative strides")[0].strides
    (-16, -8)
    """
    found = [x.copy() if isinstance(x, np.ndarray) else x for x in values]
    if layout:
        lie = {**LAYOUTS, **STRIDE_0}[layout]
        found = [lie(x) if isinstance(x, np.ndarray) and x.ndim
                 and only in (None, place) else x for place, x in enumerate(found)]
    for x in found:
        if isinstance(x, np.ndarray) and x.flags.writeable and not writeable:
            x.flags.writeable = False
    return found


def same_bits(a: Any, b: Any) -> bool:
    """Whether two arrays agree in shape, type and every bit.

    >>> same_bits(0.0, -0.0), same_bits(np.nan, np.nan)
    (False, True)
    """
    a, b = np.asarray(a), np.asarray(b)
    return a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes()


def changed(names: Iterable[str], before: Iterable[Any],
            after: Iterable[Any]) -> Iterator[tuple[str, str]]:
    """Which arrays are no longer, to the last bit, what they were.   ->  yields name, place

    >>> list(changed(["x", "y"], [np.zeros(2), np.ones(2)], [np.zeros(2), np.array([1.0, 5.0])]))
    [('y', '[1]')]
    """
    for name, old, new in zip(names, before, after):
        if isinstance(old, np.ndarray) and not same_bits(old, new):
            if old.shape != new.shape:
                yield name, "its shape"
                continue
            places = np.argwhere(~((old == new) | ((old != old) & (new != new))))
            yield name, str(places[0].tolist()) if len(places) else "a sign bit"


def sharing(array: Any, others: Iterable[tuple[str, Any]]) -> Iterator[str]:
    """Names of those (name, value) that an array shares memory with.

    >>> x = np.zeros(4)
    >>> list(sharing(x[1:], [("x", x), ("a copy", x.copy())]))
    ['x']
    """
    for name, other in others:
        if isinstance(array, np.ndarray) and isinstance(other, np.ndarray):
            if np.shares_memory(array, other):
                yield name


def mixture(first: Any, second: Any) -> Any:
    """1.7 first - 0.6 second: of two upstream gradients, and of what comes of them."""
    return MIXTURE[0] * first + MIXTURE[1] * second


def nonlinearity(first: np.ndarray, second: np.ndarray, mixed: np.ndarray) -> float:
    """How far the gradient for a mixture of two upstream gradients is from the mixture of their
    gradients.   ->  largest difference

    >>> round(nonlinearity(np.ones(1), np.zeros(1), np.array([2.0])), 3)
    0.3
    """
    return float(np.abs(mixture(first, second) - mixed).max(initial=0.0))


def check_contract(f: Callable[..., Any], f_backward: Callable[..., Any], *inputs: Any,
                   names: Sequence[str] | None = None, seed: int = 0,
                   batched: Collection[int] | None = None, single: bool = False) -> None:
    """Check all of it.

    f, f_backward, inputs, names : as for `check_gradient`;  batched : indices of the inputs whose
    first axis is the batch, to try a batch of 0 clips;  single : also try float32 (not for
    functions that hold float64 arrays of their own).   Raises GradientError.

    >>> check_contract(np.negative, lambda dy, x: -dy, np.array([1.0, 2.0]))
    """
    names = names or tuple(f"input {i}" for i in range(len(inputs)))
    rng = np.random.default_rng([seed, 3])
    _left_alone("f", f, inputs, names)
    y = np.asarray(f(*inputs))
    dy = rng.standard_normal(y.shape).astype(y.dtype)
    _left_alone("f_backward", f_backward, (dy, *inputs), ("the upstream gradient", *names))
    gradients = _gradients(f_backward, dy, inputs)
    _own_memory(gradients, dy, inputs, names)
    _types(gradients, inputs, names)
    _repeatable(f, f_backward, dy, inputs, names, rng)
    _linear(f_backward, dy, inputs, names, gradients, rng)
    _spread_upstream(f_backward, y, inputs, names)
    _layouts(f, f_backward, dy, inputs, names, gradients)
    if single:
        small = [x.astype(np.float32) if is_float(x) else x for x in inputs]
        y = np.asarray(f(*small)).astype(np.float32)
        _types(_gradients(f_backward, y, small), small, names)
    if batched:
        _empty_batch(f, f_backward, inputs, names, batched)


def _gradients(f_backward, dy, inputs):
    """{input: gradient} of the inputs that have one."""
    return paired(f_backward(dy, *inputs), inputs)


def _left_alone(what, function, arguments, names):
    """Neither writeable nor read-only arguments may change."""
    for writeable in (True, False):
        handed_out = copies(arguments, writeable=writeable)
        try:
            function(*handed_out)
        except ValueError as error:
            if "read-only" not in str(error):
                raise
            raise GradientError(f"{what}: tried to write to a read-only argument ({error}); inputs "
                                "are only to be read") from None
        for name, place in changed(names, arguments, handed_out):
            raise GradientError(f"{what}: changed {name} at {place}; inputs are only to be read")


def _own_memory(gradients, dy, inputs, names):
    """No memory shared with an argument or another gradient, and writeable: the caller may add to
    it in place.
    """
    others = [("the upstream gradient", dy), *zip(names, inputs)]
    for i, gradient in gradients.items():
        if isinstance(gradient, np.ndarray) and not gradient.flags.writeable:
            raise GradientError(f"{names[i]}: found a read-only gradient (np.broadcast_to?), "
                                "needed memory of its own")
        for name in sharing(gradient, others):
            raise GradientError(f"{names[i]}: its gradient shares memory with {name}, needed "
                                "memory of its own")
        others.append((f"the gradient of {names[i]}", gradient))


def _types(gradients, inputs, names):
    for i, gradient in gradients.items():
        found = np.asarray(gradient)
        if found.shape != inputs[i].shape or found.dtype != inputs[i].dtype:
            raise GradientError(f"{names[i]}: found a gradient {found.dtype} {found.shape}, needed "
                                f"{inputs[i].dtype} {inputs[i].shape}, as its input")


def _repeatable(f, f_backward, dy, inputs, names, rng):
    """Again, after other upstream gradients and other inputs: a hidden state, a stale cache or a
    buffer used twice would show.
    """
    first = _gradients(f_backward, dy, inputs)
    kept = {i: np.array(gradient) for i, gradient in first.items()}

    def _compare(gradients, when):
        for i, gradient in gradients.items():
            if not same_bits(kept[i], gradient):
                raise GradientError(f"{names[i]}: found another gradient {when}; needed the same "
                                    "bits")
    _compare(_gradients(f_backward, dy, inputs), "on a second call with the same arguments")
    f_backward(rng.standard_normal(dy.shape).astype(dy.dtype), *inputs)
    _compare(first, "later in the array of the first call (a buffer used twice?)")
    _compare(_gradients(f_backward, dy, inputs), "after a call with another upstream gradient")
    # the same numbers elsewhere: still where f is defined
    others = [np.flip(x).copy() if is_float(x) else x for x in inputs]
    try:
        f_backward(rng.standard_normal(np.shape(f(*others))).astype(dy.dtype), *others)
        f(*others)
    except ValueError:                                           # f takes special inputs only
        return
    _compare(_gradients(f_backward, dy, inputs), "after calls with other inputs")


def _linear(f_backward, dy, inputs, names, gradients, rng):
    other = rng.standard_normal(dy.shape).astype(dy.dtype)
    second = _gradients(f_backward, other, inputs)
    mixed = _gradients(f_backward, mixture(dy, other).astype(dy.dtype), inputs)
    for i, gradient in gradients.items():
        difference = nonlinearity(gradient, second[i], mixed[i])
        size = max(np.abs(MIXTURE[0] * gradient).max(initial=0.0),
                   np.abs(MIXTURE[1] * second[i]).max(initial=0.0))
        if not difference <= LINEAR * max(size, TINY):
            raise GradientError(f"{names[i]}: its gradient is not linear in the upstream gradient "
                                f"(off by {difference:.3g} at a size of {size:.3g})")
    for factor in MULTIPLES:
        for i, scaled in _gradients(f_backward, factor * dy, inputs).items():
            if not _close(scaled, factor * gradients[i]):
                raise GradientError(f"{names[i]}: its gradient is not linear in the upstream "
                                    f"gradient: for {factor:g} times it, found another one than "
                                    f"{factor:g} times the gradient")


def _spread_upstream(f_backward, y, inputs, names):
    """An upstream gradient of stride 0, as a sum's backward makes it with np.broadcast_to, is as
    good as any.
    """
    spread = np.broadcast_to(y.dtype.type(0.7), y.shape)
    expected = _gradients(f_backward, spread.copy(), inputs)
    for i, gradient in _gradients(f_backward, spread, inputs).items():
        if not _close(gradient, expected[i]):
            raise GradientError(f"{names[i]}: found another gradient for an upstream gradient of "
                                "stride 0 (np.broadcast_to)")


def _layouts(f, f_backward, dy, inputs, names, gradients):
    """Other strides, the same numbers: values and gradients must not change (beyond the order of a
    sum).
    """
    y = f(*inputs)
    for layout in LAYOUTS:
        upstream, *arrays = copies((dy, *inputs), layout)
        if not _close(f(*arrays), y):
            raise GradientError(f"f: found another value for inputs in {layout}")
        for i, gradient in _gradients(f_backward, upstream, arrays).items():
            if not _close(gradient, gradients[i]):
                raise GradientError(f"{names[i]}: found another gradient for inputs and upstream "
                                    f"gradient in {layout}")


def _empty_batch(f, f_backward, inputs, names, batched):
    empty = [x[:0] if i in batched else x for i, x in enumerate(inputs)]
    gradients = _gradients(f_backward, np.zeros_like(np.asarray(f(*empty))), empty)
    for i, gradient in gradients.items():
        if np.shape(gradient) != empty[i].shape or np.any(gradient):
            raise GradientError(f"{names[i]}: for a batch of 0 clips found a gradient of shape "
                                f"{np.shape(gradient)}, needed zeros of {empty[i].shape}")


def _close(found, expected):
    off = differences(found, expected).max(initial=0.0)
    return off <= LAYOUT * max(largest(expected), TINY)
