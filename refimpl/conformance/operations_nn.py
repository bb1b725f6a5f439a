"""The specifications of the operations of `nn`."""

from typing import Any

import numpy as np

from .. import nn
from ..nn.adam import LARGEST_COUNT
from ..nn.arguments import check_whole
from . import definitions_nn as definitions, ground_nn as ground
from .specification import called, operation, refused, ruled

# Shapes that fit, for inputs that do not.
X, W, B = np.zeros((2, 4, 9)), np.zeros((6, 4, 3)), np.zeros(6)


def _convolutions(rng, shapes):
    """Random samples from {label: (input, filters, number of biases or None, attributes)}."""
    n = rng.standard_normal
    return [called(label, n(x), n(w), None if biases is None else n(biases), **attributes)
            for label, (x, w, biases, attributes) in shapes.items()]


def _conv_samples(rng):
    n = rng.standard_normal
    return _convolutions(rng, {
        "plain": ((2, 3, 9), (4, 3, 5), 4, {}), "no bias": ((2, 3, 9), (4, 3, 5), None, {}),
        "valid": ((2, 3, 9), (4, 3, 5), 4, {"padding": "valid"}),
        "even width": ((1, 2, 7), (3, 2, 4), 3, {}), "width one": ((2, 3, 5), (2, 3, 1), 2, {}),
        "one frame": ((2, 3, 1), (4, 3, 5), 4, {}),
        "wider than the clip": ((1, 2, 4), (3, 2, 11), 3, {}),
        "one clip one channel": ((1, 1, 6), (1, 1, 3), 1, {}),
        "asymmetric padding": ((2, 2, 6), (3, 2, 3), 3, {"padding": (0, 3)}),
        "asymmetric the other way": ((2, 2, 6), (3, 2, 3), 3, {"padding": (4, 1)}),
        "stride": ((2, 2, 10), (3, 2, 3), 3, {"stride": 2, "padding": 1}),
        "stride with a rest": ((2, 2, 11), (3, 2, 4), 3, {"stride": 3, "padding": "valid"}),
        "dilation": ((2, 2, 10), (3, 2, 3), 3, {"dilation": 2}),
        "groups": ((2, 6, 7), (4, 3, 3), 4, {"groups": 2}),
        "one group a channel": ((2, 3, 7), (3, 1, 3), 3, {"groups": 3}),
        "everything": ((3, 4, 13), (6, 2, 3), 6, {"stride": 2, "padding": (1, 2), "dilation": 2,
                                                  "groups": 2})}) + [
        called("zeros", np.zeros((1, 2, 5)), n((3, 2, 3)), n(3)),
        called("paper width", n((1, 2, 26)), n((2, 2, 25)), n(2)),
        called("large and small", n((1, 2, 8)) * 1e6, n((2, 2, 3)) * 1e-6, n(2))]


def _bad_conv():
    return [refused("x without batch", "x", X[0], W, B), refused("channels", "x", X, W[:, :3], B),
            refused("bias", "b", X, W, B[:5]), refused("one bias for all", "b", X, W, B[:1]),
            refused("biases in a column", "b", X, W, B[:, None]),
            refused("one channel for all", "x", X[:, :1], W, B),
            refused("filters of width 0", "w", X, W[:, :, :0], B),
            refused("no filters", "w", X, W[:0], None),
            refused("no frames", "x", X[:, :, :0], W, B),
            refused("whole numbers", "x", X.astype(int), W, B),
            refused("mixed precision", "w", X.astype(np.float32), W, B),
            refused("a bias of another precision", "b", X, W, B.astype(np.float32)),
            refused("stride 0", "stride", X, W, B, stride=0),
            refused("same with stride", "padding", X, W, B, stride=2, padding="same"),
            refused("negative padding", "padding", X, W, B, padding=-1),
            refused("three paddings", "padding", X, W, B, padding=(1, 1, 1)),
            refused("unknown padding", "padding", X, W, B, padding="full"),
            refused("dilation 0", "dilation", X, W, B, dilation=0),
            refused("groups that do not divide", "w", X, W, B, groups=4),
            refused("channels that do not divide", "x", X, W[:, :1], B, groups=3),
            refused("filter too wide", "x", X, np.zeros((6, 4, 10)), B, padding="valid")]


def _transpose_samples(rng):
    return _convolutions(rng, {
        "plain": ((2, 4, 9), (4, 3, 5), 3, {}), "no bias": ((2, 4, 9), (4, 3, 5), None, {}),
        "valid": ((2, 4, 6), (4, 3, 5), 3, {"padding": "valid"}),
        "even width": ((1, 3, 7), (3, 2, 4), 2, {}), "one frame": ((2, 4, 1), (4, 3, 5), 3, {}),
        "wider than the clip": ((1, 3, 4), (3, 2, 11), 2, {}),
        "asymmetric padding": ((2, 3, 6), (3, 2, 3), 2, {"padding": (0, 2)}),
        "stride": ((2, 3, 5), (3, 2, 3), 2, {"stride": 2, "padding": 1}),
        "stride and output padding": ((2, 3, 5), (3, 2, 3), 2, {"stride": 3, "padding": 1,
                                                                "output_padding": 2}),
        "dilation": ((2, 3, 6), (3, 2, 3), 2, {"dilation": 2}),
        "groups": ((2, 4, 7), (4, 3, 3), 6, {"groups": 2}),
        "everything": ((2, 6, 5), (6, 2, 3), 4, {"stride": 2, "padding": (1, 2), "dilation": 2,
                                                 "groups": 2, "output_padding": 1})})


def _bad_transpose():
    H = np.zeros((2, 6, 9))
    return [refused("channels", "h", X, W, None),
            refused("bias", "b", H, W, B), refused("h without batch", "h", H[0], W, None),
            refused("output padding", "output_padding", H, W, None, output_padding=1),
            refused("nothing left", "h", H[:, :, :1], W, None, padding=2)]


def distinct(rng: np.random.Generator, *shape: int) -> np.ndarray:
    """Numbers far from each other and from 0, so that no tie or kink is near."""
    return (rng.permutation(np.arange(1, 1 + np.prod(shape))).reshape(shape)
            * rng.choice([-0.5, 0.5], shape) + rng.uniform(-0.1, 0.1, shape))


def _max_pool_samples(rng):
    d, nan, inf = distinct, np.nan, np.inf
    return [called("plain", d(rng, 2, 3, 8)), called("a frame left over", d(rng, 2, 3, 9)),
            called("one window", d(rng, 1, 1, 2)), called("width three", d(rng, 2, 2, 9), 3),
            called("overlapping", d(rng, 2, 2, 9), 3, stride=1),
            called("padding", d(rng, 2, 2, 8), 3, padding=1),
            called("gaps", d(rng, 2, 2, 9), 2, stride=3),
            called("dilation", d(rng, 2, 2, 9), 3, dilation=2, stride=1),
            called("ceil mode", d(rng, 2, 2, 9), 2, ceil_mode=True),
            called("ceil mode whose last window would begin in the padding",
                   d(rng, 1, 2, 5), 2, ceil_mode=True, padding=1, stride=3),
            ruled("tie",
                  (np.full((1, 1, 4), 4.0),), [[[4.0, 4]]], [[[5.0, 7]]], [[[5.0, 0, 7, 0]]]),
            ruled("NaN", (np.array([[[9.0, nan, 1, 2]]]),), [[[nan, 2.0]]], [[[5.0, 7]]],
                  [[[0, 5.0, 0, 7]]]), ruled("minus infinity", (np.array([[[-inf, -inf, 3, 1]]]),),
                                             [[[-inf, 3.0]]], [[[5.0, 7]]], [[[5.0, 0, 7, 0]]])]


def _bad_pools():
    return [refused("two dimensions", "x", X[0]),
            refused("width 0", "width", X, 0), refused("wider than the clip", "x", X, 10),
            refused("padding above half", "padding", X, 2, padding=2),
            refused("stride 0", "stride", X, 2, stride=0),
            refused("no frames", "x", X[:, :, :0]), refused("whole numbers", "x", X.astype(int))]


def _bad_max_pools():
    return [*_bad_pools(), refused("complex numbers", "x", X + 0j)]


def _avg_pool_samples(rng):
    n = rng.standard_normal
    return [called("plain", n((2, 3, 8))), called("a frame left over", n((2, 3, 9)), 4),
            called("overlapping", n((2, 2, 9)), 3, stride=2),
            called("padding counts", n((2, 2, 8)), 3, padding=1),
            called("padding does not count", n((2, 2, 8)), 3, padding=1, count_include_pad=False),
            called("ceil mode", n((2, 2, 8)), 3, ceil_mode=True),
            called("ceil mode and padding", n((2, 2, 9)), 4, ceil_mode=True, padding=2, stride=3),
            called("all of it, padding apart",
                   n((2, 2, 9)), 4, ceil_mode=True, padding=2, stride=3, count_include_pad=False)]


def _unpool_samples(rng):
    indices = [[np.sort(rng.permutation(9)[:4]) for _ in range(3)] for _ in range(2)]
    return [called("plain", rng.standard_normal((2, 3, 4)), np.array(indices), 9),
            ruled("two values for one place", (np.array([[[1.0, 2]]]), np.array([[[2, 2]]]), 3),
                  [[[0, 0, 2.0]]], [[[1.0, 3, 5]]], [[[0.0, 5]]])]


def _random_depool_samples(rng):
    n, nan, inf = rng.standard_normal, np.nan, np.inf
    return [called("plain", n((2, 3, 4)), rng.integers(2, size=(2, 3, 4))),
            called("three", n((2, 3, 4)), rng.integers(3, size=(2, 3, 4)), 3),
            called("width one", n((1, 2, 3)), np.zeros((1, 2, 3), int), 1),
            called("one frame", n((2, 3, 1)), rng.integers(2, size=(2, 3, 1))),
            ruled("NaN and infinity", (np.array([[[nan, inf]]]), np.array([[[1, 0]]])),
                  [[[0.0, nan, inf, 0]]], [[[1.0, 3, 5, 7]]], [[[3.0, 5]]])]


def _bad_random_depool():
    chosen = np.zeros(X.shape, int)
    return [refused("a choice beyond the width", "chosen", X, chosen + 2),
            refused("a negative choice", "chosen", X, chosen - 1),
            refused("choices of another shape", "chosen", X, chosen[:, :, :8]),
            refused("one choice for all units", "chosen", X, chosen[:, :1]),
            refused("choices that are not whole", "chosen", X, chosen + 0.5),
            refused("width 0", "width", X, chosen, 0),
            refused("two dimensions", "h", X[0], chosen[0])]


def _relu_samples(rng):
    x = np.array([[-1.0, 0.0, -0.0, 2.0, np.nan]])
    return [called("plain", distinct(rng, 2, 3, 4)), called("any shape", distinct(rng, 5)),
            ruled("zero and NaN",
                  (x,), [[0.0, 0, 0, 2, np.nan]], [[3.0, 3, 3, 3, 3]], [[0.0, 0, 0, 3, 0]])]


def _clip_samples(rng):
    n = rng.standard_normal
    return [called("plain", n((2, 3, 5))),
            called("one frame", n((2, 3, 1))), called("one clip one channel", n((1, 1, 4))),
            called("large", n((2, 3, 4)) * 1e3), called("many frames", n((1, 4, 60)))]


def _norm_samples(rng):
    zero = np.zeros((2, 3))
    return _clip_samples(rng) + [called("vectors", rng.standard_normal((4, 2))),
                                 ruled("zero", (zero,), [0.0, 0.0], [2.0, 3.0], zero)]


def _l1_samples(rng):
    return [called("plain", distinct(rng, 2, 3, 4)),
            ruled("zero", (np.array([-3.0, 0.0, 5.0]),), 8.0, 2.0, [-2.0, 0.0, 2.0])]


def _error_samples(rng):
    x = distinct(rng, 2, 3, 4)
    y = x + distinct(rng, 2, 3, 4)
    return [called(form, x, y, reduction=form) for form in ("mean", "sum", "none")]


def _error_ground(rng):
    return ground.elements(rng, inputs=2) + [called(f"{s.label}, {form}", *s.inputs, reduction=form,
                                                    large=s.large) for form in ("sum", "none")
                                             for s in ground.elements(rng, inputs=2)[::3]]


def _absolute_error_samples(rng):
    x, y = np.array([1.0, 2.0]), np.array([1.0, 0.0])
    return _error_samples(rng) + [ruled("equal elements", (x, y), 2.0, 1.0,
                                        [0.0, 1.0], [0.0, -1.0], attributes={"reduction": "sum"})]


def _bad_errors():
    return [refused("shapes", "y", X, X[:1]), refused("a mean of nothing", "x", X[:0], X[:0]),
            refused("reduction", "reduction", X, X, reduction="max")]


def adam_of_one_array(p: np.ndarray, g: np.ndarray, m: np.ndarray, v: np.ndarray, *, t: int,
                      **settings: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`nn.adam_step` for one array whose moments before the step are m and v.   ->  p, m, v"""
    before: dict[str, Any] = {"t": t - 1, "m": {"p": m}, "v": {"p": v}}
    new, state = nn.adam_step({"p": p}, {"p": g}, before, **settings)
    return new["p"], state["m"]["p"], state["v"]["p"]


def adam_step(p: np.ndarray, g: np.ndarray, m: np.ndarray, v: np.ndarray, *, t: int,
              rate: float = 1e-3, beta1: float = 0.9, beta2: float = 0.999,
              epsilon: float = 1e-8) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One step of algorithm 1 for one array; t, from 1 to 2^53, counts this step, m and v are the
    moments before it.

        m' = beta1 m + (1 - beta1) g
        v' = beta2 v + (1 - beta2) g^2
        p' = p - rate (m' / (1 - beta1^t)) / (sqrt(v' / (1 - beta2^t)) + epsilon)

    p, g, m, v : one shape  ->  p', m', v' of that shape
    """
    check_whole("t", t, 1, LARGEST_COUNT)
    return adam_of_one_array(p, g, m, v, t=t, rate=rate, beta1=beta1, beta2=beta2, epsilon=epsilon)


def _adam_samples(rng):
    n = rng.standard_normal
    mixed = n(6) * 10.0 ** np.array([-9, -8, -4, 0, 3, 6])
    return [called("first step", n(5), n(5), np.zeros(5), np.zeros(5), t=1),
            called("tenth step", n((2, 3)), n((2, 3)), n((2, 3)), n((2, 3)) ** 2, t=10),
            called("tiny gradients", n(4), np.full(4, 1e-9), np.zeros(4), np.zeros(4), t=1),
            called("zero gradients", n(4), np.zeros(4), np.zeros(4), np.zeros(4), t=1),
            called("mixed sizes", n(6), mixed, 0.1 * mixed, 0.001 * mixed ** 2, t=2),
            called("other settings",
                   n(4), n(4), n(4), n(4) ** 2, t=3, rate=0.1, beta1=0.5, beta2=0.9, epsilon=1e-3)]


def _bad_adam():
    arrays = (np.ones(3), np.ones(3), np.zeros(3), np.zeros(3))
    steps = {"the step before the first": 0, "half a step": 0.5,
             "more steps than can be counted": 10 ** 400}
    return [*(refused(label, "t", *arrays, t=t) for label, t in steps.items()),
            refused("a negative rate", "rate", *arrays, t=1, rate=-1e-3)]


def _one(f, arguments, samples, bad=list, equation="", **rest):
    return operation(f, arguments,
                     definitions, samples, bad, equation, **{"whole_range": True, **rest})


OPERATIONS = (
    _one(nn.conv1d, "x w b", _conv_samples, _bad_conv, "the * of equations 1 and 2",
         ground=ground.convolutions),
    _one(nn.conv_transpose1d, "h w b", _transpose_samples, _bad_transpose, "equation 2",
         ground=lambda rng: ground.convolutions(rng, transposed=True)),
    _one(nn.max_pool1d, "x width", _max_pool_samples, _bad_max_pools, "equation 1",
         ground=ground.pools),
    _one(nn.max_pool1d_indices, "x width", _max_pool_samples, _bad_max_pools, ground=ground.pools),
    _one(nn.max_unpool1d, "h indices length", _unpool_samples,
         lambda: [refused("index too large", "indices", X, np.full(X.shape, 9), 9)],
         batched=(0, 1), ground=ground.unpools),
    _one(nn.avg_pool1d, "x width", _avg_pool_samples, _bad_pools,
         ground=lambda rng: ground.pools(rng, average=True)),
    _one(nn.avg_depool1d, "h width",
         lambda rng: [called("plain", rng.standard_normal((2, 3, 4))),
                      called("three", rng.standard_normal((2, 3, 4)), 3)],
         lambda: [refused("width 0", "width", X, 0), refused("two dimensions", "h", X[0]),
                  refused("no frames", "h", X[:, :, :0])],
         "equation 2", ground=ground.depools),
    _one(nn.random_depool1d, "h chosen width", _random_depool_samples, _bad_random_depool,
         "equation 2, as the 2016 code learns", batched=(0, 1),
         ground=lambda rng: ground.depools(rng, chosen=True)),
    _one(nn.relu, "x", _relu_samples,
         lambda: [refused("whole numbers", "x", np.zeros(3, int))], "equation 1",
         ground=ground.elements),
    _one(nn.gram, "h", _clip_samples, lambda: [refused("two dimensions", "h", X[0])], "equation 6",
         ground=lambda rng: [s for s in ground.measures(rng) if s.inputs[0].ndim == 3]),
    _one(nn.sum_squares, "r", _clip_samples, lambda: [refused("a scalar", "r", np.float64(1))],
         ground=ground.measures),
    _one(nn.mean_squares, "r", _clip_samples,
         lambda: [refused("clips without elements", "r", X[:, :0])], ground=ground.measures),
    _one(nn.norm, "r", _norm_samples, equation="the || || of equations 4 and 5",
         ground=ground.measures),
    _one(nn.l1, "a", _l1_samples, lambda: [
        refused("complex numbers", "a", X + 0j)], "equation 3", batched=(),
         ground=lambda rng: ground.elements(rng, summed=True)),
    _one(nn.squared_error, "x y", _error_samples, _bad_errors, "equation 3", batched=(),
         ground=_error_ground),
    _one(nn.absolute_error, "x y", _absolute_error_samples, _bad_errors, batched=(),
         ground=_error_ground),
    _one(adam_step, "p g m v", _adam_samples, _bad_adam, "Kingma and Ba, algorithm 1", batched=(),
         ground=ground.adam, whole_range=False))
