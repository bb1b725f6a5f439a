"""PyTorch's functions as a backend of the conformance kit (2.13.0 was used).

    from refimpl.adapters.torch import backend
    BACKEND = backend(conv1d=my_conv1d, gram=MyGram, encode=MyEncoder(), device="cuda")

and `refimpl check mymodule:BACKEND` judges them, values and gradients.
"""

from collections.abc import Callable
from contextlib import contextmanager
import inspect
from typing import Any

import numpy as np
import torch
from torch.func import functional_call

from ..conformance import OPERATIONS
from ..conformance.adapted import adapted, example


def backend(*, device: Any = "cpu", dtype: torch.dtype | str | None = None,
            **functions: Any) -> dict[str, Any]:
    """A mapping for `refimpl check`: operations, and their gradients by autograd.

    functions : operation=what computes it on tensors, one of

    - a function of tensors, called with the operation's arguments and options;
    - a `torch.autograd.Function`, the class: options go to its forward by name;
    - a module, whose parameters, in their own order, are set from the operation's last arguments
      (W0 and b0 of `encode`) and have their gradients returned; what stands before them goes in.

    Tensors lie in memory as the arrays do, where PyTorch can have them so.
    NAME_backward=function takes the upstream gradient and the same arguments, where autograd has
    none; lacks=, tolerances= are declared as they are
    device : where the tensors lie;  dtype : what floating-point arrays are rounded to on their way
    in, for half precision; its results come back in float32
    ->  {name: function of NumPy arrays};  "lacks" has float64 where the device or dtype has none
    Raises ValueError for a name that is no operation, a device that is not there, and a module
    whose parameters cannot stand for the arguments or that answers by chance.

    >>> made = backend(gram=lambda h: h @ h.mT)
    >>> made["gram_backward"](np.ones((1, 1, 1)), np.full((1, 1, 2), 3.0))
    array([[[6., 6.]]])
    """
    dtype = getattr(torch, dtype) if isinstance(dtype, str) else dtype

    def _enter(value):
        if not isinstance(value, (np.ndarray, np.generic)):
            return value
        tensor = torch.from_numpy(np.array(value, order="C"))
        tensor = tensor.to(device, dtype if tensor.is_floating_point() else None)
        return _copied(tensor, [step // value.itemsize for step in value.strides])

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
            with _refusing_layouts(*tensors, *options.values()):
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
            with torch.enable_grad(), _refusing_layouts(upstream, *tensors, *options.values()):
                tensors = [_Handed.apply(t) if i in wanted else t for i, t in enumerate(tensors)]
                y = function(*tensors, **options)
                if not (isinstance(y, torch.Tensor) and y.requires_grad):
                    raise ValueError(f"{name}: found an answer that autograd cannot follow, needed "
                                     "a tensor with no torch.no_grad, detach or NumPy on its way; "
                                     f"or give a gradient of your own, {name}_backward=")
                found = dict(zip(wanted, torch.autograd.grad(y, [*wanted.values()], upstream,
                                                             materialize_grads=True)))
            gradients = tuple(_leave(found.get(i)) for i in range(count))
            _tell_changes((*arguments, *attributes.values()),
                          (upstream, *tensors, *options.values()))
            return gradients[0] if count == 1 else gradients
        return _gradients

    return adapted(functions, _forward, _backward, _lacking(device, dtype))


def _copied(tensor, strides):
    """A copy that lies in memory by these strides; packed, or one element for many, where PyTorch
    cannot write by them.
    """
    if any(step < 0 for step in strides):
        return tensor.clone(memory_format=torch.contiguous_format)
    one = tuple(slice(0, 1) if step == 0 else slice(None) for step in strides)
    if tensor[one].shape != tensor.shape:
        return tensor[one].clone().expand(tensor.shape)
    return torch.empty_strided(tensor.shape, strides, dtype=tensor.dtype,
                               device=tensor.device).copy_(tensor)


@contextmanager
def _refusing_layouts(*given):
    """Whatever PyTorch does not take it calls a RuntimeError: a layout that a function refuses is
    a ValueError here, as for any backend.
    """
    try:
        yield
    except RuntimeError as error:
        if type(error) is not RuntimeError or all(       # NotImplementedError is one as well
                t.is_contiguous() for t in given if isinstance(t, torch.Tensor)):
            raise
        raise ValueError(f"refused tensors that are not contiguous: {error}") from error


class _Handed(torch.autograd.Function):
    """A copy that may be written into: a leaf may not."""

    @staticmethod
    def forward(ctx: Any, tensor: torch.Tensor) -> torch.Tensor:
        return _copied(tensor, tensor.stride())

    @staticmethod
    def backward(ctx: Any, upstream: torch.Tensor) -> torch.Tensor:
        return upstream


def _lacking(device, dtype):
    """["float64"] where there is none, [] where there is."""
    try:
        torch.zeros(1, device=device)
    except (RuntimeError, AssertionError) as error:
        raise ValueError(f"device: found {device!r}, needed one that PyTorch has here; it says: "
                         f"{error}") from error
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
    parameters = dict(module.named_parameters())
    inputs = example(OPERATIONS[name]) if name in OPERATIONS else ()
    try:
        inspect.signature(module.forward).bind(*inputs[:len(inputs) - len(parameters)])
        fits = [p.ndim for p in parameters.values()] == [
            np.ndim(x) for x in inputs[len(inputs) - len(parameters):]]
    except TypeError:
        fits = False
    if not fits:
        raise ValueError(f"{name}: found a module of {len(parameters)} parameters ("
                         + ", ".join(f"{key} {(*p.shape,)}" for key, p in parameters.items())
                         + "), needed those that stand for the last of "
                         f"{', '.join(OPERATIONS[name].arguments)}, in this order, and a forward "
                         "of what stands before them; or give a function that calls the module")
    chance = [key for key, m in module.named_modules()
              if m.training and isinstance(m, torch.nn.modules.dropout._DropoutNd)]
    if chance:
        raise ValueError(f"{name}: found dropout in training mode ({', '.join(chance)}), needed "
                         "a module that answers alike twice; call its eval()")

    def _apply(*arguments, **attributes):
        cut = len(arguments) - len(parameters)
        like = next(t for t in (*arguments, *attributes.values())
                    if isinstance(t, torch.Tensor) and t.is_floating_point())
        buffers = {key: b.to(like if b.is_floating_point() else like.device)
                   for key, b in module.named_buffers()}
        return functional_call(module, {**buffers, **dict(zip(parameters, arguments[cut:]))},
                               arguments[:cut], attributes)
    return _apply
