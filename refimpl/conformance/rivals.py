"""Conventions that others follow: when a backend disagrees, it may agree with one of these, and
then the report says so.

Each rival is a function with the arguments of the operation (or of its backward) that it stands
for.
"""

import numpy as np

from .. import nn
from ..holden2017 import losses
from ..motion.joints import FEET
from . import definitions_nn as definitions, rivals_2016, rivals_torresani


def _window(x, width, stride, padding, dilation, ceil_mode):
    """Windows as an array (N, C, T_out, width), NaN outside, and their positions."""
    positions = np.array(
        definitions.window_positions(x.shape[2], width, stride, padding, dilation, ceil_mode))
    inside = (positions >= 0) & (positions < x.shape[2])
    return np.where(inside, x[:, :, np.clip(positions, 0, x.shape[2] - 1)],
                    -np.inf), positions, inside


def _spread(share, positions, inside, x):
    dx = np.zeros_like(x)
    for t, k in zip(*np.nonzero(inside)):
        dx[:, :, positions[t, k]] += share[:, :, t, k]
    return dx


def tie_to_the_last(dy, x, width=2, *, stride=None, padding=0, dilation=1, ceil_mode=False):
    values, positions, inside = _window(x, width, stride, padding, dilation, ceil_mode)
    last = values.shape[3] - 1 - np.argmax(values[..., ::-1], axis=-1)
    return _spread(dy[..., None] * (np.arange(values.shape[3]) == last[..., None]), positions,
                   inside, x)


def tie_to_all(dy, x, width=2, *, stride=None, padding=0, dilation=1, ceil_mode=False):
    values, positions, inside = _window(x, width, stride, padding, dilation, ceil_mode)
    return _spread(dy[..., None] * (values == values.max(axis=-1, keepdims=True)), positions,
                   inside, x)


def tie_split_equally(dy, x, width=2, *, stride=None, padding=0, dilation=1, ceil_mode=False):
    values, positions, inside = _window(x, width, stride, padding, dilation, ceil_mode)
    ties = values == values.max(axis=-1, keepdims=True)
    return _spread(dy[..., None] * ties / np.maximum(ties.sum(axis=-1, keepdims=True), 1),
                   positions, inside, x)


def nan_ignored(x, width=2, *, stride=None, padding=0, dilation=1, ceil_mode=False):
    return nn.max_pool1d(np.where(np.isnan(x), -np.inf, x), width, stride=stride, padding=padding,
                         dilation=dilation, ceil_mode=ceil_mode)


def larger_half_left(x, w, b=None, *, stride=1, padding="same", dilation=1, groups=1):
    if padding == "same":
        zeros = dilation * (w.shape[2] - 1)
        padding = (zeros - zeros // 2, zeros // 2)
    return nn.conv1d(x, w, b, stride=stride, padding=padding, dilation=dilation, groups=groups)


def flipped(function):
    """A convolution proper: the filters reversed in time."""
    return lambda first, w, *rest, **attributes: function(first, np.ascontiguousarray(
        w[:, :, ::-1]), *rest, **attributes)


def flipped_backward(function):
    def backward(d, first, w, *rest, **attributes):
        d_first, dw, db = function(d, first, np.ascontiguousarray(w[:, :, ::-1]), *rest,
                                   **attributes)
        return d_first, dw[:, :, ::-1], db
    return backward


def mean_over(axes, index, function):
    """A backward whose gradient number `index` is a mean over some axes of the upstream gradient
    instead of a sum.
    """
    def backward(d, *arguments, **attributes):
        gradients = list(function(d, *arguments, **attributes))
        if gradients[index] is not None:
            gradients[index] = gradients[index] / np.prod([d.shape[a] for a in axes])
        return tuple(gradients)
    return backward


def adam_variant(variant):
    def step(p, g, m, v, *, t, rate=1e-3, beta1=0.9, beta2=0.999, epsilon=1e-8):
        new, state = nn.adam_step({"p": p}, {"p": g}, {"t": t - 1, "m": {"p": m}, "v": {"p": v}},
                                  rate=rate, beta1=beta1, beta2=beta2, epsilon=epsilon,
                                  variant=variant)
        return new["p"], state["m"]["p"], state["v"]["p"]
    return step


def epsilon_inside_the_root(p, g, m, v, *, t, rate=1e-3, beta1=0.9, beta2=0.999, epsilon=1e-8):
    m, v = beta1 * m + (1 - beta1) * g, beta2 * v + (1 - beta2) * g * g
    return p - rate * (m / (1 - beta1 ** t)) / np.sqrt(v / (1 - beta2 ** t) + epsilon), m, v


def foot_without_rotation(motion, contacts, *, target=0.0):
    p = losses.joint_positions(motion)[:, FEET]
    v = p[..., 1:] - p[..., :-1]
    v[:, :, 0] += motion[:, None, losses.SIDEWAYS, :-1]
    v[:, :, 2] += motion[:, None, losses.FORWARD, :-1]
    return nn.sum_squares(contacts[:, :, None, :-1] * (v - target))


def journal_trajectory(motion, *, wanted, turn_weight=1.0):
    """The journal's equation 9 as printed: the turning error without its square."""
    error = motion[:, losses.VELOCITIES] - wanted
    return np.sqrt(turn_weight) * nn.norm(error[:, 0]) + nn.sum_squares(error[:, 1:])


def read_as(loss, other):
    """The bars of equations 4 and 5 read otherwise than asked: as `other`, or as norms where that
    was asked for.
    """
    return lambda a, b, *, reading="norm", **weight: loss(
        a, b, **weight, reading=other if reading != other else "norm")


RIVALS = {
    "conv1d": [
        ("a flipped filter, as Theano convolves", flipped(nn.conv1d)),
        ("the larger half of 'same' zeros on the left", larger_half_left)], "conv1d_backward": [
            ("a flipped filter, as Theano convolves", flipped_backward(nn.conv1d_backward)),
            ("the bias gradient as a mean over clips and frames",
             mean_over((0, 2), 2, nn.conv1d_backward)),
            ("the bias gradient as a mean over clips", mean_over((0,), 2, nn.conv1d_backward)),
            ("the filter gradient as a mean over clips", mean_over((0,), 1, nn.conv1d_backward))],
    "conv_transpose1d": [
        ("a flipped filter", flipped(nn.conv_transpose1d))], "conv_transpose1d_backward": [
            ("a flipped filter", flipped_backward(nn.conv_transpose1d_backward))], "max_pool1d": [
                ("NaN ignored in a pool", nan_ignored)], "max_pool1d_backward": [
                    ("ties to the last", tie_to_the_last),
                    ("ties to all, as Theano does", tie_to_all),
                    ("ties split equally, as jnp.max does", tie_split_equally)], "avg_depool1d": [
                        ("repetition without the division by the width",
                         lambda h, width=2: np.repeat(h, width, axis=2))],
    "avg_pool1d": [
        ("padding counted the other way", lambda x, width=2, *, count_include_pad=True, **rest: nn.
         avg_pool1d(x, width, count_include_pad=not count_include_pad, **rest))], "relu_backward": [
             ("relu'(0) = 0.5, as jnp.maximum has it",
              lambda d, x: np.where(x > 0, d, np.where(x == 0, d / 2, 0))),
             ("relu'(0) = 1", lambda d, x: np.where(x >= 0, d, 0))], "gram": [
                 ("a Gram matrix divided by the frames", lambda h: nn.gram(h) / h.shape[2]),
                 ("a Gram matrix divided by channels times frames", lambda h: nn.gram(h) /
                  (h.shape[1] * h.shape[2]))],
    "gram_backward": [
        ("a Gram matrix divided by the frames", lambda d, h: nn.gram_backward(d, h) / h.shape[2]),
        ("half the gradient: one of its two terms", lambda d, h: d @ h),
        ("the other one of its two terms", lambda d, h: d.swapaxes(1, 2) @ h)], "norm": [
            ("the norm squared", nn.sum_squares)], "l1_backward": [
                ("d|x| = 1 at 0, as JAX has it", lambda d, a: np.where(a >= 0, 1.0, -1.0) * d)],
    "squared_error": [("half the squares", lambda x, y, **k: nn.squared_error(x, y, **k) / 2)],
    "random_depool1d": [
        ("half of each value in the chosen frame",
         lambda h, chosen, width=2: nn.random_depool1d(h / width, chosen, width)),
        ("average-depooling whatever was chosen",
         lambda h, chosen, width=2: nn.avg_depool1d(h, width))], "random_depool1d_backward": [
             ("the gradient of average-depooling",
              lambda d, h, chosen, width=2: nn.avg_depool1d_backward(d, h, width)),
             ("the gradient of both frames together",
              lambda d, h, chosen, width=2: nn.avg_depool1d_backward(d, h, width) * width)
         ], "content_loss": [
             ("means of squares for norms and back, the 2016 code's",
              read_as(losses.content_loss, "mean_squares")),
             ("sums of squares for norms and back", read_as(losses.content_loss, "sum_squares"))],
    "style_loss": [
        ("means of squares for norms and back, the 2016 code's",
         read_as(losses.style_loss,
                 "mean_squares")),
        ("sums of squares for norms and back", read_as(losses.style_loss, "sum_squares")),
        ("Gram matrices divided by the frames",
         lambda g, h, **how: losses.style_loss(g, h / np.sqrt(h.shape[2]), **how))], "foot_loss": [
             ("equation 7 without its rotation term", foot_without_rotation)], "trajectory_loss": [
                 ("the journal's equation 9, turning error not squared", journal_trajectory)
             ], "adam_step": [
                 ("Adam epsilon-hat (Keras, old PyTorch)", adam_variant("epsilon-hat")),
                 ("Adam without bias correction (ONNX, T = 0)", adam_variant("no-bias-correction")),
                 ("epsilon inside the root",
                  epsilon_inside_the_root)], **rivals_2016.RIVALS, **rivals_torresani.RIVALS, }
