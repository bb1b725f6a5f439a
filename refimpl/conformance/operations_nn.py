"""The specifications of the operations of `nn`."""

from typing import Any

import numpy as np

from .. import nn
from ..nn.adam import LARGEST_COUNT
from ..nn.arguments import check_whole
from . import definitions_nn as definitions, ground_nn as ground
from .specification import Bad, Sample, operation, ruled

# Shapes that fit, for inputs that do not.
X, W, B = np.zeros((2, 4, 9)), np.zeros((6, 4, 3)), np.zeros(6)


def _convolutions(rng, shapes):
    """Random samples from {label: (input, filters, number of biases or None, attributes)}."""
    n = rng.standard_normal
    return [Sample(label, (n(x), n(w), None if biases is None else n(biases)), attributes)
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
        Sample("zeros", (np.zeros((1, 2, 5)), n((3, 2, 3)), n(3))),
        Sample("paper width", (n((1, 2, 26)), n((2, 2, 25)), n(2))),
        Sample("large and small", (n((1, 2, 8)) * 1e6, n((2, 2, 3)) * 1e-6, n(2)))]


def _bad_conv():
    return [Bad("x without batch", (X[0], W, B), "x"), Bad("channels", (X, W[:, :3], B), "x"),
            Bad("bias", (X, W, B[:5]), "b"), Bad("one bias for all", (X, W, B[:1]), "b"),
            Bad("biases in a column", (X, W, B[:, None]), "b"),
            Bad("one channel for all", (X[:, :1], W, B), "x"),
            Bad("filters of width 0", (X, W[:, :, :0], B), "w"),
            Bad("no filters", (X, W[:0], None), "w"),
            Bad("no frames", (X[:, :, :0], W, B), "x"),
            Bad("whole numbers", (X.astype(int), W, B), "x"),
            Bad("mixed precision", (X.astype(np.float32), W, B), "w"),
            Bad("a bias of another precision", (X, W, B.astype(np.float32)), "b"),
            Bad("stride 0", (X, W, B), "stride", {"stride": 0}),
            Bad("same with stride", (X, W, B), "padding", {"stride": 2, "padding": "same"}),
            Bad("negative padding", (X, W, B), "padding", {"padding": -1}),
            Bad("three paddings", (X, W, B), "padding", {"padding": (1, 1, 1)}),
            Bad("unknown padding", (X, W, B), "padding", {"padding": "full"}),
            Bad("dilation 0", (X, W, B), "dilation", {"dilation": 0}),
            Bad("groups that do not divide", (X, W, B), "w", {"groups": 4}),
            Bad("channels that do not divide", (X, W[:, :1], B), "x", {"groups": 3}),
            Bad("filter too wide", (X, np.zeros((6, 4, 10)), B), "x", {"padding": "valid"})]


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
    return [Bad("channels", (X, W, None), "h"), Bad("bias", (H, W, B), "b"),
            Bad("h without batch", (H[0], W, None), "h"),
            Bad("output padding", (H, W, None), "output_padding", {"output_padding": 1}),
            Bad("nothing left", (H[:, :, :1], W, None), "h", {"padding": 2})]


def distinct(rng: np.random.Generator, *shape: int) -> np.ndarray:
    """Numbers far from each other and from 0, so that no tie or kink is near."""
    return (rng.permutation(np.arange(1, 1 + np.prod(shape))).reshape(shape)
            * rng.choice([-0.5, 0.5], shape) + rng.uniform(-0.1, 0.1, shape))


def _max_pool_samples(rng):
    d, nan, inf = distinct, np.nan, np.inf
    return [Sample("plain", (d(rng, 2, 3, 8),)), Sample("a frame left over", (d(rng, 2, 3, 9),)),
            Sample("one window", (d(rng, 1, 1, 2),)), Sample("width three", (d(rng, 2, 2, 9), 3)),
            Sample("overlapping", (d(rng, 2, 2, 9), 3), {"stride": 1}),
            Sample("padding", (d(rng, 2, 2, 8), 3), {"padding": 1}),
            Sample("gaps", (d(rng, 2, 2, 9), 2), {"stride": 3}),
            Sample("dilation", (d(rng, 2, 2, 9), 3), {"dilation": 2, "stride": 1}),
            Sample("ceil mode", (d(rng, 2, 2, 9), 2), {"ceil_mode": True}),
            Sample("ceil mode whose last window would begin in the padding", (d(rng, 1, 2, 5), 2),
                   {"ceil_mode": True, "padding": 1, "stride": 3}),
            ruled("tie", (np.full((1, 1, 4), 4.0),), [[[4.0, 4]]], [[[5.0, 7]]],
                  [[[5.0, 0, 7, 0]]]),
            ruled("NaN", (np.array([[[9.0, nan, 1, 2]]]),), [[[nan, 2.0]]], [[[5.0, 7]]],
                  [[[0, 5.0, 0, 7]]]),
            ruled("minus infinity", (np.array([[[-inf, -inf, 3, 1]]]),), [[[-inf, 3.0]]],
                  [[[5.0, 7]]], [[[5.0, 0, 7, 0]]])]


def _bad_pools():
    return [Bad("two dimensions", (X[0],), "x"), Bad("width 0", (X, 0), "width"),
            Bad("wider than the clip", (X, 10), "x"),
            Bad("padding above half", (X, 2), "padding", {"padding": 2}),
            Bad("stride 0", (X, 2), "stride", {"stride": 0}),
            Bad("no frames", (X[:, :, :0],), "x"), Bad("whole numbers", (X.astype(int),), "x")]


def _bad_max_pools():
    return [*_bad_pools(), Bad("complex numbers", (X + 0j,), "x")]


def _avg_pool_samples(rng):
    n = rng.standard_normal
    return [Sample("plain", (n((2, 3, 8)),)), Sample("a frame left over", (n((2, 3, 9)), 4)),
            Sample("overlapping", (n((2, 2, 9)), 3), {"stride": 2}),
            Sample("padding counts", (n((2, 2, 8)), 3), {"padding": 1}),
            Sample("padding does not count", (n((2, 2, 8)), 3),
                   {"padding": 1, "count_include_pad": False}),
            Sample("ceil mode", (n((2, 2, 8)), 3), {"ceil_mode": True}),
            Sample("ceil mode and padding", (n((2, 2, 9)), 4),
                   {"ceil_mode": True, "padding": 2, "stride": 3}),
            Sample("all of it, padding apart", (n((2, 2, 9)), 4),
                   {"ceil_mode": True, "padding": 2, "stride": 3, "count_include_pad": False})]


def _unpool_samples(rng):
    indices = [[np.sort(rng.permutation(9)[:4]) for _ in range(3)] for _ in range(2)]
    return [Sample("plain", (rng.standard_normal((2, 3, 4)), np.array(indices), 9)),
            ruled("two values for one place", (np.array([[[1.0, 2]]]), np.array([[[2, 2]]]), 3),
                  [[[0, 0, 2.0]]], [[[1.0, 3, 5]]], [[[0.0, 5]]])]


def _random_depool_samples(rng):
    n, nan, inf = rng.standard_normal, np.nan, np.inf
    return [Sample("plain", (n((2, 3, 4)), rng.integers(2, size=(2, 3, 4)))),
            Sample("three", (n((2, 3, 4)), rng.integers(3, size=(2, 3, 4)), 3)),
            Sample("width one", (n((1, 2, 3)), np.zeros((1, 2, 3), int), 1)),
            Sample("one frame", (n((2, 3, 1)), rng.integers(2, size=(2, 3, 1)))),
            ruled("NaN and infinity", (np.array([[[nan, inf]]]), np.array([[[1, 0]]])),
                  [[[0.0, nan, inf, 0]]], [[[1.0, 3, 5, 7]]], [[[3.0, 5]]])]


def _bad_random_depool():
    chosen = np.zeros(X.shape, int)
    return [Bad("a choice beyond the width", (X, chosen + 2), "chosen"),
            Bad("a negative choice", (X, chosen - 1), "chosen"),
            Bad("choices of another shape", (X, chosen[:, :, :8]), "chosen"),
            Bad("one choice for all units", (X, chosen[:, :1]), "chosen"),
            Bad("choices that are not whole", (X, chosen + 0.5), "chosen"),
            Bad("width 0", (X, chosen, 0), "width"), Bad("two dimensions", (X[0], chosen[0]), "h")]


def _relu_samples(rng):
    x = np.array([[-1.0, 0.0, -0.0, 2.0, np.nan]])
    return [Sample("plain", (distinct(rng, 2, 3, 4),)), Sample("any shape", (distinct(rng, 5),)),
            ruled("zero and NaN", (x,), [[0.0, 0, 0, 2, np.nan]], [[3.0, 3, 3, 3, 3]],
                  [[0.0, 0, 0, 3, 0]])]


def _clip_samples(rng):
    n = rng.standard_normal
    return [Sample("plain", (n((2, 3, 5)),)), Sample("one frame", (n((2, 3, 1)),)),
            Sample("one clip one channel", (n((1, 1, 4)),)),
            Sample("large", (n((2, 3, 4)) * 1e3,)), Sample("many frames", (n((1, 4, 60)),))]


def _norm_samples(rng):
    zero = np.zeros((2, 3))
    return _clip_samples(rng) + [Sample("vectors", (rng.standard_normal((4, 2)),)),
                                 ruled("zero", (zero,), [0.0, 0.0], [2.0, 3.0], zero)]


def _l1_samples(rng):
    return [Sample("plain", (distinct(rng, 2, 3, 4),)),
            ruled("zero", (np.array([-3.0, 0.0, 5.0]),), 8.0, 2.0, [-2.0, 0.0, 2.0])]


def _error_samples(rng):
    x = distinct(rng, 2, 3, 4)
    y = x + distinct(rng, 2, 3, 4)
    return [Sample(form, (x, y), {"reduction": form}) for form in ("mean", "sum", "none")]


def _error_ground(rng):
    return ground.elements(rng, inputs=2) + [
        Sample(f"{s.label}, {form}", s.inputs, {"reduction": form}, large=s.large)
        for form in ("sum", "none") for s in ground.elements(rng, inputs=2)[::3]]


def _absolute_error_samples(rng):
    x, y = np.array([1.0, 2.0]), np.array([1.0, 0.0])
    return _error_samples(rng) + [ruled("equal elements", (x, y), 2.0, 1.0, [0.0, 1.0],
                                        [0.0, -1.0], attributes={"reduction": "sum"})]


def _bad_errors():
    return [Bad("shapes", (X, X[:1]), "y"), Bad("a mean of nothing", (X[:0], X[:0]), "x"),
            Bad("reduction", (X, X), "reduction", {"reduction": "max"})]


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
    return [Sample("first step", (n(5), n(5), np.zeros(5), np.zeros(5)), {"t": 1}),
            Sample("tenth step", (n((2, 3)), n((2, 3)), n((2, 3)), n((2, 3)) ** 2), {"t": 10}),
            Sample("tiny gradients", (n(4), np.full(4, 1e-9), np.zeros(4), np.zeros(4)), {"t": 1}),
            Sample("zero gradients", (n(4), np.zeros(4), np.zeros(4), np.zeros(4)), {"t": 1}),
            Sample("mixed sizes", (n(6), mixed, 0.1 * mixed, 0.001 * mixed ** 2), {"t": 2}),
            Sample("other settings", (n(4), n(4), n(4), n(4) ** 2),
                   {"t": 3, "rate": 0.1, "beta1": 0.5, "beta2": 0.9, "epsilon": 1e-3})]


def _bad_adam():
    arrays = (np.ones(3), np.ones(3), np.zeros(3), np.zeros(3))
    steps = {"the step before the first": 0, "half a step": 0.5,
             "more steps than can be counted": 10 ** 400}
    return [*(Bad(label, arrays, "t", {"t": t}) for label, t in steps.items()),
            Bad("a negative rate", arrays, "rate", {"t": 1, "rate": -1e-3})]


def _one(f, arguments, samples, bad=list, equation="", **rest):
    return operation(f, arguments, definitions, samples, bad, equation,
                     **{"whole_range": True, **rest})


OPERATIONS = (
    _one(nn.conv1d, "x w b", _conv_samples, _bad_conv, "the * of equations 1 and 2",
         ground=ground.convolutions),
    _one(nn.conv_transpose1d, "h w b", _transpose_samples, _bad_transpose, "equation 2",
         ground=lambda rng: ground.convolutions(rng, transposed=True)),
    _one(nn.max_pool1d, "x width", _max_pool_samples, _bad_max_pools, "equation 1",
         ground=ground.pools),
    _one(nn.max_pool1d_indices, "x width", _max_pool_samples, _bad_max_pools, ground=ground.pools),
    _one(nn.max_unpool1d, "h indices length", _unpool_samples,
         lambda: [Bad("index too large", (X, np.full(X.shape, 9), 9), "indices")],
         batched=(0, 1), ground=ground.unpools),
    _one(nn.avg_pool1d, "x width", _avg_pool_samples, _bad_pools,
         ground=lambda rng: ground.pools(rng, average=True)),
    _one(nn.avg_depool1d, "h width",
         lambda rng: [Sample("plain", (rng.standard_normal((2, 3, 4)),)),
                      Sample("three", (rng.standard_normal((2, 3, 4)), 3))],
         lambda: [Bad("width 0", (X, 0), "width"), Bad("two dimensions", (X[0],), "h"),
                  Bad("no frames", (X[:, :, :0],), "h")],
         "equation 2", ground=ground.depools),
    _one(nn.random_depool1d, "h chosen width", _random_depool_samples, _bad_random_depool,
         "equation 2, as the 2016 code learns", batched=(0, 1),
         ground=lambda rng: ground.depools(rng, chosen=True)),
    _one(nn.relu, "x", _relu_samples,
         lambda: [Bad("whole numbers", (np.zeros(3, int),), "x")], "equation 1",
         ground=ground.elements),
    _one(nn.gram, "h", _clip_samples, lambda: [Bad("two dimensions", (X[0],), "h")], "equation 6",
         ground=lambda rng: [s for s in ground.measures(rng) if s.inputs[0].ndim == 3]),
    _one(nn.sum_squares, "r", _clip_samples, lambda: [Bad("a scalar", (np.float64(1),), "r")],
         ground=ground.measures),
    _one(nn.mean_squares, "r", _clip_samples,
         lambda: [Bad("clips without elements", (X[:, :0],), "r")], ground=ground.measures),
    _one(nn.norm, "r", _norm_samples, equation="the || || of equations 4 and 5",
         ground=ground.measures),
    _one(nn.l1, "a", _l1_samples, lambda: [
        Bad("complex numbers", (X + 0j,), "a")], "equation 3", batched=(),
         ground=lambda rng: ground.elements(rng, summed=True)),
    _one(nn.squared_error, "x y", _error_samples, _bad_errors, "equation 3", batched=(),
         ground=_error_ground),
    _one(nn.absolute_error, "x y", _absolute_error_samples, _bad_errors, batched=(),
         ground=_error_ground),
    _one(adam_step, "p g m v", _adam_samples, _bad_adam, "Kingma and Ba, algorithm 1", batched=(),
         ground=ground.adam, whole_range=False))
