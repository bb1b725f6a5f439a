"""JAX's functions as a backend of the conformance kit (0.10.2 was used).

    from refimpl.adapters.jax import backend
    BACKEND = backend(gram=lambda h: h @ h.mT, conv1d=my_conv1d)

and `refimpl check mymodule:BACKEND` judges them, values and gradients. A network whose parameters
are a tree takes them as arguments: encode=lambda X, W0, b0: model.apply({"W0": W0, "b0": b0}, X).
"""

from typing import Any

import jax
import numpy as np

from ..conformance.adapted import adapted

try:
    from jax import enable_x64
except ImportError:                                              # where it stood before
    from jax.experimental import enable_x64


def backend(*, device: Any = None, dtype: Any = None, **functions: Any) -> dict[str, Any]:
    """A mapping for `refimpl check`: operations, and their gradients by `jax.vjp`.

    functions : operation=function of JAX's arrays, called as it is, so compiled where it is made by
    `jax.jit` and with the gradient of its `jax.custom_vjp` where it has one;
    NAME_backward=function takes the upstream gradient and the same arguments, where JAX has no
    gradient; lacks=, tolerances= are declared as they are
    device : "gpu" or one of `jax.devices()`;  dtype : what floating-point arrays are rounded to on
    their way in, for half precision; its results come back in float32
    ->  {name: function of NumPy arrays};  "lacks" has float64 where the device or dtype has none

    float64 is switched on for calls in float64 alone, so that those in float32 run as they do in a
    program that never heard of it.   Raises ValueError for a name that is no operation.

    >>> made = backend(gram=lambda h: h @ h.mT)
    >>> made["gram_backward"](np.ones((1, 1, 1)), np.full((1, 1, 2), 3.0))
    array([[[6., 6.]]])
    """
    place = jax.devices(device)[0] if isinstance(device, str) else device

    def _enter(value):
        if not isinstance(value, (np.ndarray, np.generic)):
            return value
        value = np.array(value, order="C")                       # any strides, memory of its own
        return jax.device_put(value.astype(dtype) if dtype and value.dtype.kind == "f" else value,
                              place)

    def _leave(result):
        if isinstance(result, (tuple, list)):
            return tuple(map(_leave, result))
        if not isinstance(result, jax.Array):
            return result
        return np.array(result, "float32" if dtype and result.dtype == dtype else None, order="C")

    def _forward(name, function):
        def _call(*arguments, **attributes):
            with _precision(arguments, attributes):
                return _leave(function(*map(_enter, arguments),
                                       **{k: _enter(v) for k, v in attributes.items()}))
        return _call

    def _backward(name, function, count):
        def _gradients(dy, *arguments, **attributes):
            with _precision((dy, *arguments), attributes):
                inputs = [*map(_enter, arguments)]
                options = {k: _enter(v) for k, v in attributes.items()}
                _, pull = jax.vjp(lambda *given: function(*given, *inputs[count:], **options),
                                  *inputs[:count])
                found = _leave(pull(_enter(dy)))
                return found[0] if count == 1 else found + (None,) * (count - len(found))
        return _gradients

    return adapted(functions, _forward, _backward, _lacking(place, dtype))


def _precision(arguments, attributes):
    """float64 switched on where there is some."""
    return enable_x64(any(getattr(x, "dtype", None) == np.float64
                          for x in (*arguments, *attributes.values())))


def _lacking(place, dtype):
    """["float64"] where there is none, [] where there is."""
    with enable_x64(True):
        try:
            jax.device_put(np.zeros(1), place).block_until_ready()
        except (TypeError, RuntimeError, NotImplementedError):
            return ["float64"]
    return [] if dtype is None or np.dtype(dtype) == np.float64 else ["float64"]
