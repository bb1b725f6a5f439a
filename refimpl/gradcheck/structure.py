"""Functions of dicts and tuples of arrays, as functions of arrays; which gradient is whose.

Every check walks through arrays. Networks take dicts of parameters, and some operations return
tuples; here both are taken apart and put together again.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .errors import GradientError


def is_float(x: Any) -> bool:
    """Whether something is an array that can have a gradient.

    >>> is_float(np.zeros(2)), is_float(np.arange(2)), is_float(1.0)
    (True, False, False)
    """
    return isinstance(x, np.ndarray) and x.dtype.kind == "f"


def paired(gradients: Any, inputs: Sequence[Any]) -> dict[int, Any]:
    """What a backward returned, by the input: one array or a tuple, for all inputs or for those
    alone that can have a gradient; without those that are None.

    >>> paired((1.0, None), [np.zeros(2), 3]), paired(2.0, [3, np.zeros(2)])
    ({0: 1.0}, {1: 2.0})
    """
    gradients = gradients if isinstance(gradients, (tuple, list)) else (gradients,)
    chosen = [i for i, x in enumerate(inputs) if is_float(x)]
    if len(gradients) == len(inputs):
        gradients = [gradients[i] for i in chosen]
    return {i: gradient for i, gradient in zip(chosen, gradients) if gradient is not None}


def leaves(value: Any, name: str) -> list[tuple[str, Any]]:
    """The arrays (and whatever else) in a dict, list or tuple, with their names.

    >>> leaves({"W": 1.0, "b": (2.0, 3.0)}, "params")
    [("params['W']", 1.0), ("params['b'][0]", 2.0), ("params['b'][1]", 3.0)]
    """
    if isinstance(value, dict):
        return [leaf for key, x in value.items() for leaf in leaves(x, f"{name}[{key!r}]")]
    if isinstance(value, (tuple, list)):
        return [leaf for i, x in enumerate(value) for leaf in leaves(x, f"{name}[{i}]")]
    return [(name, value)]


def rebuilt(like: Any, values: Any) -> Any:
    """The next of some values, an iterator, in the form of another one.

    >>> rebuilt({"W": 1.0, "b": (2.0, 3.0)}, iter("xyz"))
    {'W': 'x', 'b': ('y', 'z')}
    """
    if isinstance(like, dict):
        return {key: rebuilt(x, values) for key, x in like.items()}
    if isinstance(like, (tuple, list)):
        make = getattr(like, "_make", type(like))                               # a named tuple's
        return make([rebuilt(x, values) for x in like])
    return next(values)


def flattened(f: Callable[..., Any], f_backward: Callable[..., Any], inputs: Sequence[Any],
              names: Sequence[str]) -> tuple[Callable, Callable, list[Any], list[str]]:
    """The same function and backward of the arrays in its inputs, with one array as its output.

    ->  f, f_backward, inputs, names: unchanged where there are neither dicts nor tuples
    """
    y = f(*rebuilt(tuple(inputs), iter([x.copy() if isinstance(x, np.ndarray) else x
                                        for _, x in leaves(tuple(inputs), "")])))
    nested = any(isinstance(x, (dict, tuple, list)) for x in inputs)
    several = isinstance(y, (dict, tuple, list))
    if not nested and not several:
        return f, f_backward, list(inputs), list(names)
    parts = [np.asarray(part) for _, part in leaves(y, "")]
    cuts = np.cumsum([part.size for part in parts])[:-1]
    named = [leaf for name, x in zip(names, inputs) for leaf in leaves(x, name)]
    arrays = [x for _, x in named]

    def _flat(*given):
        y = f(*rebuilt(tuple(inputs), iter(given)))
        return np.concatenate([np.ravel(part) for _, part in leaves(y, "")]) if several else y

    def _flat_backward(dy, *given):
        pieces = np.split(dy, cuts) if several else [dy]
        dy = rebuilt(y, iter([piece.reshape(part.shape) for piece, part in zip(pieces, parts)]))
        gradients = f_backward(dy, *rebuilt(tuple(inputs), iter(given)))
        if len(inputs) > 1:
            gradients = _completed(gradients, inputs, names)
        elif isinstance(gradients, tuple) and not _fits(inputs[0], gradients):
            gradients = gradients[:1]
        else:
            gradients = [gradients]
        return tuple(leaf for name, x, gradient in zip(names, inputs, gradients)
                     for leaf in _matched(name, x, gradient))
    return _flat, _flat_backward, arrays, [name for name, _ in named]


def _fits(x, gradient):
    """Whether a gradient has the form of its input."""
    if isinstance(x, dict):
        return isinstance(gradient, dict)
    if isinstance(x, (tuple, list)):
        return isinstance(gradient, (tuple, list)) and len(gradient) == len(x)
    return not isinstance(gradient, (dict, tuple, list))


def _completed(gradients, inputs, names):
    """One gradient for each input, None for those that have none."""
    gradients = list(gradients) if isinstance(gradients, (tuple, list)) else [gradients]
    if len(gradients) == len(inputs):
        return gradients
    able = [any(is_float(leaf) for _, leaf in leaves(x, "")) for x in inputs]
    if len(gradients) != sum(able):
        raise GradientError(f"f_backward: found {len(gradients)} gradients, needed one for each of "
                            f"{', '.join(names)}")
    left = iter(gradients)
    return [next(left) if has else None for has in able]


def _matched(name, x, gradient):
    """The gradients of one input's arrays, in their order."""
    if gradient is None:
        return [None for _ in leaves(x, name)]
    if not _fits(x, gradient):
        raise GradientError(f"{name}: found a gradient that is a {type(gradient).__name__}, needed "
                            f"the form of its input, a {type(x).__name__}")
    if isinstance(x, dict):
        if set(gradient) - set(x) or set(x) - set(gradient):
            raise GradientError(f"{name}: found gradients of {', '.join(map(repr, gradient))}, "
                                f"needed those of {', '.join(map(repr, x))}")
        return [leaf for key in x for leaf in _matched(f"{name}[{key!r}]", x[key], gradient[key])]
    if isinstance(x, (tuple, list)):
        return [leaf for i, (part, given) in enumerate(zip(x, gradient))
                for leaf in _matched(f"{name}[{i}]", part, given)]
    return [gradient]
