"""PyTorch's functions as a backend of the conformance kit (2.13.0 was used).

    from refimpl.adapters.torch import backend
    BACKEND = backend(conv1d=my_conv1d, gram=MyGram, encode=MyEncoder(), device="cuda")

and `refimpl check mymodule:BACKEND` judges them, values and gradients.
"""

from collections.abc import Callable
import inspect
from typing import Any

import numpy as np
import torch
from torch.func import functional_call

from ..conformance import OPERATIONS
from ..conformance.adapted import adapted


def backend(*, device: Any = "cpu", dtype: torch.dtype | None = None,
            **functions: Any) -> dict[str, Any]:
    """A mapping for `refimpl check`: operations, and their gradients by autograd.

    functions : operation=what computes it on tensors, one of

    - a function of tensors, called with the operation's arguments and options;
    - a `torch.autograd.Function`, the class: options go to its forward by name;
    - a module, whose parameters, in their own order, are set from the operation's last arguments
      (W0 and b0 of `encode`) and have their gradients returned; what stands before them goes in.

    NAME_backward=function takes the upstream gradient and the same arguments, where autograd has
    none; lacks=, tolerances= are declared as they are
    device : where the tensors lie;  dtype : what floating-point arrays are rounded to on their way
    in, for half precision; its results come back in float32
    ->  {name: function of NumPy arrays};  "lacks" has float64 where the device or dtype has none
    Raises ValueError for a name that is no operation.

    >>> made = backend(gram=lambda h: h @ h.mT)
    >>> made["gram_backward"](np.ones((1, 1, 1)), np.full((1, 1, 2), 3.0))
    array([[[6., 6.]]])
    """
    def _enter(value):
        if not isinstance(value, (np.ndarray, np.generic)):
            return value
        tensor = torch.from_numpy(np.array(value, order="C"))    # any strides, read-only or not
        return tensor.to(device, dtype if tensor.is_floating_point() else None)

    def _leave(result):
        if isinstance(result, (tuple, list)):
            return tuple(map(_leave, result))
        if not isinstance(result, torch.Tensor):
            return result
        result = result.detach().cpu()
        return np.array((result.float() if result.dtype == dtype else result).numpy(), order="C")

    def _entered(arguments, attributes):
        return [*map(_enter, arguments)], {k: _enter(v) for k, v in attributes.items()}

    def _tell_changes(arrays, tensors):
        """A tensor is a copy: what was written into it goes back, for the kit to see."""
        for array, tensor in zip(arrays, tensors):
            if isinstance(array, np.ndarray) and not np.array_equal(
                    _leave(_enter(array)), _leave(tensor), equal_nan=True):
                array[...] = _leave(tensor)

    def _forward(name, thing):
        function = _callable(name, thing)

        def _call(*arguments, **attributes):
            tensors, options = _entered(arguments, attributes)
            result = _leave(function(*tensors, **options))
            _tell_changes((*arguments, *attributes.values()), (*tensors, *options.values()))
            return result
        return _call

    def _backward(name, thing, count):
        function = _callable(name, thing)

        def _gradients(*arguments, **attributes):
            (upstream, *tensors), options = _entered(arguments, attributes)
            wanted = {i: t.requires_grad_() for i, t in enumerate(tensors[:count])
                      if isinstance(t, torch.Tensor)}
            with torch.enable_grad():
                tensors = [t.clone() if i in wanted else t for i, t in enumerate(tensors)]
                y = function(*tensors, **options)
            found = dict(zip(wanted, torch.autograd.grad(y, [*wanted.values()], upstream,
                                                         materialize_grads=True)))
            gradients = tuple(_leave(found.get(i)) for i in range(count))
            _tell_changes((*arguments, *attributes.values()),
                          (upstream, *tensors, *options.values()))
            return gradients[0] if count == 1 else gradients
        return _gradients

    return adapted(functions, _forward, _backward, _lacking(device, dtype))


def _lacking(device, dtype):
    """["float64"] where there is none, [] where there is."""
    torch.zeros(1, device=device)                                # raises where there is no device
    try:
        torch.zeros(1, dtype=torch.float64, device=device)
    except (TypeError, RuntimeError):
        return ["float64"]
    return [] if dtype in (None, torch.float64) else ["float64"]


def _callable(name: str, thing: Any) -> Callable:
    """A function of tensors from any of the forms that `backend` takes."""
    if isinstance(thing, torch.nn.Module):
        return _of_module(name, thing)
    if isinstance(thing, type) and issubclass(thing, torch.autograd.Function):
        return _of_autograd(thing)
    if isinstance(thing, type) or not callable(thing):
        raise ValueError(f"{name}: found {thing!r}, needed a function, a torch.autograd.Function "
                         "or a module, made already")
    return thing


def _of_autograd(function):
    """`apply` with options by name, which it takes in their places alone in earlier versions."""
    forward = inspect.signature(function.forward)
    context = () if function.setup_context is not torch.autograd.Function.setup_context else (None,)

    def _apply(*arguments, **attributes):
        bound = forward.bind(*context, *arguments, **attributes)
        bound.apply_defaults()
        return function.apply(*bound.args[len(context):], **bound.kwargs)
    return _apply


def _of_module(name, module):
    """The module as a function of its inputs and parameters; buffers go where the inputs are."""
    parameters = [key for key, _ in module.named_parameters()]
    known = OPERATIONS[name].arguments if name in OPERATIONS else ()
    if len(parameters) > len(known):
        raise ValueError(f"{name}: found a module of {len(parameters)} parameters "
                         f"({', '.join(parameters)}), needed at most those of the operation: "
                         f"{', '.join(known)}")

    def _apply(*arguments, **attributes):
        cut = len(arguments) - len(parameters)
        like = next(t for t in (*arguments, *attributes.values())
                    if isinstance(t, torch.Tensor) and t.is_floating_point())
        buffers = {key: b.to(like if b.is_floating_point() else like.device)
                   for key, b in module.named_buffers()}
        return functional_call(module, {**buffers, **dict(zip(parameters, arguments[cut:]))},
                               arguments[:cut], attributes)
    return _apply
