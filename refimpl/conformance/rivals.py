"""Conventions that others follow: when a backend disagrees, it may agree with one of these, and
then the report says so.

Each rival is a function with the arguments of the operation (or of its backward) that it stands
for.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .. import nn
from ..holden2017 import losses
from ..motion.joints import FEET
from . import definitions_nn as definitions, rivals_2016, rivals_forms, rivals_torresani
from .operations_nn import adam_of_one_array
from .rivals_forms import flipped, flipped_backward
from .specification import Array

Function = Callable[..., Any]


def _pool_backward(share):
    """A gradient of max-pooling that divides the upstream gradient (N, C, windows, 1) by a rule of
    its own: share(upstream, elements of the windows)  ->  (N, C, windows, width).
    """
    def _backward(dy, x, width=2, **windows):
        positions = np.array(definitions.window_positions(x.shape[2], width, **windows))
        inside = (positions >= 0) & (positions < x.shape[2])
        elements = np.where(inside, x[:, :, np.clip(positions, 0, x.shape[2] - 1)], -np.inf)
        shares, dx = share(dy[..., None], elements), np.zeros_like(x)
        for t, k in zip(*np.nonzero(inside)):
            dx[:, :, positions[t, k]] += shares[:, :, t, k]
        return dx
    return _backward


def _last(elements):
    width = elements.shape[3]
    last = width - 1 - np.argmax(elements[..., ::-1], axis=-1)
    return np.arange(width) == last[..., None]


def _largest(elements):
    return elements == elements.max(axis=-1, keepdims=True)


tie_to_the_last = _pool_backward(lambda dy, elements: dy * _last(elements))
tie_to_all = _pool_backward(lambda dy, elements: dy * _largest(elements))
tie_split_equally = _pool_backward(lambda dy, elements: dy * _largest(elements) / np.maximum(
    _largest(elements).sum(axis=-1, keepdims=True), 1))


def nan_ignored(x: Array, width: int = 2, **windows: Any) -> Array:
    """Max-pooling that passes over NaN."""
    return nn.max_pool1d(np.where(np.isnan(x), -np.inf, x), width, **windows)


def last_nan(function: Function) -> Function:
    """Max-pooling that takes the last of several NaN in a window: what comes before it counts as
    nothing."""
    def _with_one(x, width=2, **windows):
        nn.max_pool1d_indices(x, width, **windows)               # refuses what is to be refused
        positions = np.array(definitions.window_positions(x.shape[2], width, **windows))
        marked = x.copy()
        for n, c in zip(*np.nonzero(np.isnan(x).any(axis=2))):
            for window in positions:
                inside = [p for p in window if 0 <= p < x.shape[2] and np.isnan(x[n, c, p])]
                marked[n, c, inside[:-1]] = -np.inf
        return marked
    if function is nn.max_pool1d_indices:
        return lambda x, *rest, **windows: function(_with_one(x, *rest, **windows), *rest,
                                                    **windows)
    return lambda dy, x, *rest, **windows: function(dy, _with_one(x, *rest, **windows), *rest,
                                                    **windows)


def larger_half_left(x: Array, w: Array, b: Array | None = None, *,
                     padding: Any = "same", dilation: int = 1, **attributes: int) -> Array:
    """A convolution that puts the larger half of an odd number of zeros on the left."""
    if padding == "same":
        zeros = dilation * (w.shape[2] - 1)
        padding = (zeros - zeros // 2, zeros // 2)
    return nn.conv1d(x, w, b, padding=padding, dilation=dilation, **attributes)


def mean_over(axes: Sequence[int], index: int, function: Function) -> Function:
    """A backward whose gradient number `index` is a mean over some axes of the upstream gradient
    instead of a sum.
    """
    def _backward(d, *arguments, **attributes):
        gradients = list(function(d, *arguments, **attributes))
        if gradients[index] is not None:
            gradients[index] = gradients[index] / np.prod([d.shape[a] for a in axes])
        return tuple(gradients)
    return _backward


def adam_variant(variant: str) -> Function:
    """A variant of `nn.adam_step`, for one array."""
    return lambda *arrays, **settings: adam_of_one_array(*arrays, variant=variant, **settings)


def epsilon_inside_the_root(p: Array, g: Array, m: Array, v: Array, *, t: int,
                            rate: float = 1e-3, beta1: float = 0.9, beta2: float = 0.999,
                            epsilon: float = 1e-8) -> tuple[Array, ...]:
    """Adam whose epsilon is added before the root is taken."""
    m, v = beta1 * m + (1 - beta1) * g, beta2 * v + (1 - beta2) * g * g
    return p - rate * (m / (1 - beta1 ** t)) / np.sqrt(v / (1 - beta2 ** t) + epsilon), m, v


def foot_without_rotation(motion: Array, contacts: Array, *, target: Any = 0.0) -> Array:
    """A foot loss that leaves out what the body's turning adds to a foot's velocity."""
    p = losses.joint_positions(motion)[:, FEET]
    v = p[..., 1:] - p[..., :-1]
    v[:, :, 0] += motion[:, None, losses.SIDEWAYS, :-1]
    v[:, :, 2] += motion[:, None, losses.FORWARD, :-1]
    return nn.sum_squares(contacts[:, :, None, :-1] * (v - target))


def journal_trajectory(motion: Array, *, wanted: Array, turn_weight: float = 1.0) -> Array:
    """The journal's equation 9 as printed: the turning error without its square."""
    error = motion[:, losses.VELOCITIES] - wanted
    return np.sqrt(turn_weight) * nn.norm(error[:, 0]) + nn.sum_squares(error[:, 1:])


def read_as(loss: Function, other: str) -> Function:
    """The bars of equations 4 and 5 read otherwise than asked: as `other`, or as norms where that
    was asked for.
    """
    return lambda a, b, *, reading="norm", **weight: loss(
        a, b, **weight, reading=other if reading != other else "norm")


def readings(loss: Function) -> list[tuple[str, Function]]:
    """The bars of equation 4 or 5 read otherwise."""
    return [("means of squares for norms and back, the 2016 code's", read_as(loss, "mean_squares")),
            ("sums of squares for norms and back", read_as(loss, "sum_squares"))]


RIVALS: dict[str, list[tuple[str, Function]]] = {
    "conv1d": [
        ("a flipped filter, as Theano convolves", flipped(nn.conv1d)),
        ("the larger half of 'same' zeros on the left", larger_half_left)],
    "conv1d_backward": [
        ("a flipped filter, as Theano convolves", flipped_backward(nn.conv1d_backward)),
        ("the bias gradient as a mean over clips and frames",
         mean_over((0, 2), 2, nn.conv1d_backward)),
        ("the bias gradient as a mean over clips", mean_over((0,), 2, nn.conv1d_backward)),
        ("the filter gradient as a mean over clips", mean_over((0,), 1, nn.conv1d_backward))],
    "conv_transpose1d": [("a flipped filter", flipped(nn.conv_transpose1d))],
    "conv_transpose1d_backward": [
        ("a flipped filter", flipped_backward(nn.conv_transpose1d_backward))],
    "max_pool1d": [("NaN ignored in a pool", nan_ignored)],
    "max_pool1d_indices": [("the last of several NaN, as PyTorch has it",
                            last_nan(nn.max_pool1d_indices))],
    "max_pool1d_backward": [
        ("the last of several NaN, as PyTorch has it", last_nan(nn.max_pool1d_backward)),
        ("ties to the last", tie_to_the_last), ("ties to all, as Theano does", tie_to_all),
        ("ties split equally, as jnp.max does", tie_split_equally)],
    "avg_depool1d": [
        ("repetition without the division by the width",
         lambda h, width=2: np.repeat(h, width, axis=2))],
    "avg_pool1d": [
        ("padding counted the other way", lambda x, width=2, *, count_include_pad=True, **rest:
         nn.avg_pool1d(x, width, count_include_pad=not count_include_pad, **rest))],
    "relu_backward": [
        ("relu'(0) = 0.5, as jnp.maximum has it",
         lambda d, x: np.where(x > 0, d, np.where(x == 0, d / 2, 0))),
        ("relu'(0) = 1", lambda d, x: np.where(x >= 0, d, 0))],
    "gram": [
        ("a Gram matrix divided by the frames", lambda h: nn.gram(h) / h.shape[2]),
        ("a Gram matrix divided by channels times frames",
         lambda h: nn.gram(h) / (h.shape[1] * h.shape[2]))],
    "gram_backward": [
        ("a Gram matrix divided by the frames", lambda d, h: nn.gram_backward(d, h) / h.shape[2]),
        ("half the gradient: one of its two terms", lambda d, h: d @ h),
        ("the other one of its two terms", lambda d, h: d.swapaxes(1, 2) @ h)],
    "norm": [("the norm squared", nn.sum_squares)],
    "l1_backward": [
        ("d|x| = 1 at 0, as JAX has it", lambda d, a: np.where(a >= 0, 1.0, -1.0) * d),
        ("d|x| = 0 at NaN, as PyTorch has it", lambda d, a: np.where(
            np.isnan(a), 0.0, np.sign(a)) * d)],
    "squared_error": [("half the squares", lambda x, y, **k: nn.squared_error(x, y, **k) / 2)],
    "random_depool1d": [
        ("half of each value in the chosen frame",
         lambda h, chosen, width=2: nn.random_depool1d(h / width, chosen, width)),
        ("average-depooling whatever was chosen",
         lambda h, chosen, width=2: nn.avg_depool1d(h, width))],
    "random_depool1d_backward": [
        ("the gradient of average-depooling",
         lambda d, h, chosen, width=2: nn.avg_depool1d_backward(d, h, width)),
        ("the gradient of both frames together",
         lambda d, h, chosen, width=2: nn.avg_depool1d_backward(d, h, width) * width)],
    "content_loss": readings(losses.content_loss),
    "style_loss": [
        *readings(losses.style_loss),
        ("Gram matrices divided by the frames",
         lambda g, h, **how: losses.style_loss(g, h / np.sqrt(h.shape[2]), **how))],
    "foot_loss": [("equation 7 without its rotation term", foot_without_rotation)],
    "trajectory_loss": [
        ("the journal's equation 9, turning error not squared", journal_trajectory)],
    "adam_step": [
        ("Adam epsilon-hat (Keras, old PyTorch)", adam_variant("epsilon-hat")),
        ("Adam without bias correction (ONNX, T = 0)", adam_variant("no-bias-correction")),
        ("epsilon inside the root", epsilon_inside_the_root)],
    **rivals_torresani.RIVALS}
for _more in (rivals_2016.RIVALS, rivals_forms.RIVALS):
    for _name, _pairs in _more.items():
        RIVALS[_name] = RIVALS.get(_name, []) + _pairs
