"""Forms that others give whole families of operations: one number for the batch, means for sums,
filters as Theano has them."""

from collections.abc import Callable
from typing import Any

import numpy as np

from .. import nn
from ..holden2016 import losses as losses_2016
from ..holden2017 import losses
from . import functions_2016, functions_holden

Function = Callable[..., Any]
FLIPPED = "the filters as Theano has them, not reversed"
LOSSES: dict[str, Function] = {
    "norm": nn.norm, "sum_squares": nn.sum_squares,
    "mean_squares": nn.mean_squares, "content_loss": losses.content_loss,
    "style_loss": losses.style_loss, "foot_loss": losses.foot_loss, "bone_loss": losses.bone_loss,
    "trajectory_loss": losses.trajectory_loss, "foot_loss_2016": losses_2016.foot_loss,
    "bone_loss_2016": losses_2016.bone_loss, "trajectory_loss_2016": functions_2016.trajectory_loss,
    "search_loss_2016": functions_2016.search_loss}


def over_clips(function: Function, what: Callable[[np.ndarray], Any]) -> Function:
    """A loss that comes to one number for all clips."""
    return lambda *arrays, **attributes: np.asarray(what(function(*arrays, **attributes)))


def flipped(function: Function) -> Function:
    """A convolution proper, or a network of such: the filters reversed in time."""
    return lambda x, *arrays, **attributes: function(x, *map(_reversed, arrays), **attributes)


def flipped_backward(function: Function) -> Function:
    """The gradient of `flipped`."""
    def _backward(d, x, *arrays, **attributes):
        dx, *gradients = function(d, x, *map(_reversed, arrays), **attributes)
        return dx, *map(_reversed, gradients)
    return _backward


def _reversed(x):
    return np.ascontiguousarray(x[:, :, ::-1]) if np.ndim(x) == 3 else x


RIVALS: dict[str, list[tuple[str, Function]]] = {name: [("one number, summed over the clips",
                                                         over_clips(loss, np.sum)),
                                                        ("one number, averaged over the clips",
                                                         over_clips(loss, lambda y: y.sum()
                                                                    / np.float64(y.size)))]
                                                 for name, loss in LOSSES.items()}
RIVALS["sum_squares"].append(("the mean of the squares", nn.mean_squares))
RIVALS["mean_squares"].append(("the sum of the squares", nn.sum_squares))
RIVALS["l1"] = [("the mean of the absolute values", lambda a: nn.l1(a) / a.size)]
RIVALS["relu_backward"] = [("the gradient passes at NaN, as PyTorch has it",
                            lambda d, x: np.where((x > 0) | np.isnan(x), d, 0).astype(d.dtype))]
for _name, _forward, _backward in (
        ("encode", functions_holden.encode, functions_holden.encode_backward),
        ("decode", functions_holden.decode, functions_holden.decode_backward),
        ("transform", functions_holden.transform, functions_holden.transform_backward)):
    RIVALS[_name] = [(FLIPPED, flipped(_forward))]
    RIVALS[f"{_name}_backward"] = [(FLIPPED, flipped_backward(_backward))]
RIVALS["encode_2016_backward"] = [(FLIPPED, flipped_backward(functions_2016.encode_backward))]
RIVALS["decode_2016_backward"] = [(FLIPPED, flipped_backward(functions_2016.decode_backward))]
