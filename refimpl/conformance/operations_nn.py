"""Records of the operations of `nn`."""

from typing import Any

import numpy as np

from .. import nn
from ..nn.adam import STEPS
from ..nn.arguments import check_whole
from . import definitions_nn as by_definition
from .specification import Bad, Operation, Sample

# Shapes that fit, for inputs that do not.
X, W, B = np.zeros((2, 4, 9)), np.zeros((6, 4, 3)), np.zeros(6)


def conv_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    return [
        Sample("plain", (n((2, 3, 9)), n((4, 3, 5)), n(4))),
        Sample("no bias", (n((2, 3, 9)), n((4, 3, 5)), None)),
        Sample("valid", (n((2, 3, 9)), n((4, 3, 5)), n(4)), {"padding": "valid"}),
        Sample("even width", (n((1, 2, 7)), n((3, 2, 4)), n(3))),
        Sample("width one", (n((2, 3, 5)), n((2, 3, 1)), n(2))),
        Sample("one frame", (n((2, 3, 1)), n((4, 3, 5)), n(4))),
        Sample("wider than the clip", (n((1, 2, 4)), n((3, 2, 11)), n(3))),
        Sample("one clip one channel", (n((1, 1, 6)), n((1, 1, 3)), n(1))),
        Sample("asymmetric padding", (n((2, 2, 6)), n((3, 2, 3)), n(3)), {"padding": (0, 3)}),
        Sample("asymmetric the other way", (n((2, 2, 6)), n((3, 2, 3)), n(3)),
               {"padding": (4, 1)}),
        Sample("stride", (n((2, 2, 10)), n((3, 2, 3)), n(3)), {"stride": 2, "padding": 1}),
        Sample("stride with a rest", (n((2, 2, 11)), n((3, 2, 4)), n(3)),
               {"stride": 3, "padding": "valid"}),
        Sample("dilation", (n((2, 2, 10)), n((3, 2, 3)), n(3)), {"dilation": 2}),
        Sample("groups", (n((2, 6, 7)), n((4, 3, 3)), n(4)), {"groups": 2}),
        Sample("one group a channel", (n((2, 3, 7)), n((3, 1, 3)), n(3)), {"groups": 3}),
        Sample("everything", (n((3, 4, 13)), n((6, 2, 3)), n(6)),
               {"stride": 2, "padding": (1, 2), "dilation": 2, "groups": 2}),
        Sample("zeros", (np.zeros((1, 2, 5)), n((3, 2, 3)), n(3))),
        Sample("paper width", (n((1, 2, 26)), n((2, 2, 25)), n(2))),
        Sample("large and small", (n((1, 2, 8)) * 1e6, n((2, 2, 3)) * 1e-6, n(2))),
    ]


def conv_bad() -> list[Bad]:
    return [
        Bad("x without batch", (X[0], W, B), {}, "x"), Bad("channels", (X, W[:, :3], B), {}, "x"),
        Bad("bias", (X, W, B[:5]), {}, "b"),
        Bad("filters of width 0", (X, W[:, :, :0], B), {}, "w"),
        Bad("no frames", (X[:, :, :0], W, B), {}, "x"),
        Bad("whole numbers", (X.astype(int), W, B), {}, "x"),
        Bad("mixed precision", (X.astype(np.float32), W, B), {}, "w"),
        Bad("stride 0", (X, W, B), {"stride": 0}, "stride"),
        Bad("same with stride", (X, W, B), {"stride": 2, "padding": "same"}, "padding"),
        Bad("negative padding", (X, W, B), {"padding": -1}, "padding"),
        Bad("three paddings", (X, W, B), {"padding": (1, 1, 1)}, "padding"),
        Bad("unknown padding", (X, W, B), {"padding": "full"}, "padding"),
        Bad("dilation 0", (X, W, B), {"dilation": 0}, "dilation"),
        Bad("groups that do not divide", (X, W, B), {"groups": 4}, "w"),
        Bad("filter too wide", (X, np.zeros((6, 4, 10)), B), {"padding": "valid"}, "x"),
    ]


def transpose_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    return [
        Sample("plain", (n((2, 4, 9)), n((4, 3, 5)), n(3))),
        Sample("no bias", (n((2, 4, 9)), n((4, 3, 5)), None)),
        Sample("valid", (n((2, 4, 6)), n((4, 3, 5)), n(3)), {"padding": "valid"}),
        Sample("even width", (n((1, 3, 7)), n((3, 2, 4)), n(2))),
        Sample("one frame", (n((2, 4, 1)), n((4, 3, 5)), n(3))),
        Sample("wider than the clip", (n((1, 3, 4)), n((3, 2, 11)), n(2))),
        Sample("asymmetric padding", (n((2, 3, 6)), n((3, 2, 3)), n(2)), {"padding": (0, 2)}),
        Sample("stride", (n((2, 3, 5)), n((3, 2, 3)), n(2)), {"stride": 2, "padding": 1}),
        Sample("stride and output padding", (n((2, 3, 5)), n((3, 2, 3)), n(2)),
               {"stride": 3, "padding": 1, "output_padding": 2}),
        Sample("dilation", (n((2, 3, 6)), n((3, 2, 3)), n(2)), {"dilation": 2}),
        Sample("groups", (n((2, 4, 7)), n((4, 3, 3)), n(6)), {"groups": 2}),
        Sample("everything", (n((2, 6, 5)), n((6, 2, 3)), n(4)),
               {"stride": 2, "padding": (1, 2), "dilation": 2, "groups": 2, "output_padding": 1}),
    ]


def transpose_bad() -> list[Bad]:
    H = np.zeros((2, 6, 9))
    return [Bad("channels", (X, W, None), {}, "h"), Bad("bias", (H, W, B), {}, "b"),
            Bad("h without batch", (H[0], W, None), {}, "h"),
            Bad("output padding", (H, W, None), {"output_padding": 1}, "output_padding"),
            Bad("nothing left", (H[:, :, :1], W, None), {"padding": 2}, "h")]


def distinct(rng: np.random.Generator, *shape: int) -> np.ndarray:
    """Numbers far from each other and from 0, so that no tie or kink is near."""
    return (rng.permutation(np.arange(1, 1 + np.prod(shape))).reshape(shape)
            * rng.choice([-0.5, 0.5], shape) + rng.uniform(-0.1, 0.1, shape))


def max_pool_samples(rng: np.random.Generator) -> list[Sample]:
    tie = {"outputs": (np.array([[[4.0, 4]]]),), "upstream": np.array([[[5.0, 7]]]),
           "gradients": (np.array([[[5.0, 0, 7, 0]]]),)}
    nan = {"outputs": (np.array([[[np.nan, 2.0]]]),), "upstream": np.array([[[5.0, 7]]]),
           "gradients": (np.array([[[0, 5.0, 0, 7]]]),)}
    lowest = {"outputs": (np.array([[[-np.inf, 3.0]]]),), "upstream": np.array([[[5.0, 7]]]),
              "gradients": (np.array([[[5.0, 0, 7, 0]]]),)}
    return [Sample("plain", (distinct(rng, 2, 3, 8),)),
            Sample("a frame left over", (distinct(rng, 2, 3, 9),)),
            Sample("one window", (distinct(rng, 1, 1, 2),)),
            Sample("width three", (distinct(rng, 2, 2, 9), 3)),
            Sample("overlapping", (distinct(rng, 2, 2, 9), 3), {"stride": 1}),
            Sample("padding", (distinct(rng, 2, 2, 8), 3), {"padding": 1}),
            Sample("gaps", (distinct(rng, 2, 2, 9), 2), {"stride": 3}),
            Sample("dilation", (distinct(rng, 2, 2, 9), 3), {"dilation": 2, "stride": 1}),
            Sample("ceil mode", (distinct(rng, 2, 2, 9), 2), {"ceil_mode": True}),
            Sample("ceil mode whose last window would begin in the padding",
                   (distinct(rng, 1, 2, 5), 2), {"ceil_mode": True, "padding": 1, "stride": 3}),
            Sample("tie", (np.full((1, 1, 4), 4.0),), smooth=False, known=tie),
            Sample("NaN", (np.array([[[9.0, np.nan, 1, 2]]]),), smooth=False, known=nan),
            Sample("minus infinity", (np.array([[[-np.inf, -np.inf, 3, 1]]]),), smooth=False,
                   known=lowest)]


def pool_bad() -> list[Bad]:
    return [Bad("two dimensions", (X[0],), {}, "x"), Bad("width 0", (X, 0), {}, "width"),
            Bad("wider than the clip", (X, 10), {}, "x"),
            Bad("padding above half", (X, 2), {"padding": 2}, "padding"),
            Bad("stride 0", (X, 2), {"stride": 0}, "stride"),
            Bad("no frames", (X[:, :, :0],), {}, "x"),
            Bad("whole numbers", (X.astype(int),), {}, "x")]


def avg_pool_samples(rng: np.random.Generator) -> list[Sample]:
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


def unpool_samples(rng: np.random.Generator) -> list[Sample]:
    indices = np.stack([np.stack([np.sort(rng.permutation(9)[:4]) for _ in range(3)])
                        for _ in range(2)])
    twice = {"outputs": (np.array([[[0, 0, 2.0]]]),), "upstream": np.array([[[1.0, 3, 5]]]),
             "gradients": (np.array([[[0.0, 5]]]),)}
    return [Sample("plain", (rng.standard_normal((2, 3, 4)), indices, 9)),
            Sample("two values for one place", (np.array([[[1.0, 2]]]), np.array([[[2, 2]]]), 3),
                   smooth=False, known=twice)]


def random_depool_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    strange = {"outputs": (np.array([[[0.0, np.nan, np.inf, 0]]]),),
               "upstream": np.array([[[1.0, 3, 5, 7]]]), "gradients": (np.array([[[3.0, 5]]]),)}
    return [Sample("plain", (n((2, 3, 4)), rng.integers(2, size=(2, 3, 4)))),
            Sample("three", (n((2, 3, 4)), rng.integers(3, size=(2, 3, 4)), 3)),
            Sample("width one", (n((1, 2, 3)), np.zeros((1, 2, 3), int), 1)),
            Sample("one frame", (n((2, 3, 1)), rng.integers(2, size=(2, 3, 1)))),
            Sample("NaN and infinity", (np.array([[[np.nan, np.inf]]]), np.array([[[1, 0]]])),
                   smooth=False, known=strange)]


def random_depool_bad() -> list[Bad]:
    chosen = np.zeros(X.shape, int)
    return [Bad("a choice beyond the width", (X, chosen + 2), {}, "chosen"),
            Bad("a negative choice", (X, chosen - 1), {}, "chosen"),
            Bad("choices of another shape", (X, chosen[:, :, :8]), {}, "chosen"),
            Bad("one choice for all units", (X, chosen[:, :1]), {}, "chosen"),
            Bad("choices that are not whole", (X, chosen + 0.5), {}, "chosen"),
            Bad("width 0", (X, chosen, 0), {}, "width"),
            Bad("two dimensions", (X[0], chosen[0]), {}, "h")]


def kink(x: np.ndarray, outputs: Any, upstream: Any, *gradients: Any) -> dict[str, Any]:
    """A known answer at a kink."""
    return {"outputs": (np.array(outputs),), "upstream": np.array(upstream),
            "gradients": tuple(map(np.array, gradients))}


def relu_samples(rng: np.random.Generator) -> list[Sample]:
    x = np.array([[-1.0, 0.0, -0.0, 2.0, np.nan]])
    return [Sample("plain", (distinct(rng, 2, 3, 4),)), Sample("any shape", (distinct(rng, 5),)),
            Sample("zero and NaN", (x,), smooth=False, known=kink(
                x, [[0.0, 0, 0, 2, np.nan]], [[3.0, 3, 3, 3, 3]], [[0.0, 0, 0, 3, 0]]))]


def clip_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    return [Sample("plain", (n((2, 3, 5)),)), Sample("one frame", (n((2, 3, 1)),)),
            Sample("one clip one channel", (n((1, 1, 4)),)),
            Sample("large", (n((2, 3, 4)) * 1e3,)), Sample("many frames", (n((1, 4, 60)),))]


def norm_samples(rng: np.random.Generator) -> list[Sample]:
    r = np.zeros((2, 3))
    return clip_samples(rng) + [Sample("vectors", (rng.standard_normal((4, 2)),)),
                                Sample("zero", (r,), smooth=False,
                                       known=kink(r, [0.0, 0.0], [2.0, 3.0], r))]


def l1_samples(rng: np.random.Generator) -> list[Sample]:
    a = np.array([-3.0, 0.0, 5.0])
    return [Sample("plain", (distinct(rng, 2, 3, 4),)),
            Sample("zero", (a,), smooth=False, known=kink(a, 8.0, 2.0, [-2.0, 0.0, 2.0]))]


def error_samples(rng: np.random.Generator) -> list[Sample]:
    x = distinct(rng, 2, 3, 4)
    y = x + distinct(rng, 2, 3, 4)
    return [Sample("mean", (x, y), {"reduction": "mean"}),
            Sample("sum", (x, y), {"reduction": "sum"}),
            Sample("none", (x, y), {"reduction": "none"})]


def absolute_error_samples(rng: np.random.Generator) -> list[Sample]:
    x = np.array([1.0, 2.0])
    zero = kink(x, 2.0, 1.0, [0.0, 1.0], [0.0, -1.0])
    return error_samples(rng) + [Sample("equal elements", (x, np.array([1.0, 0.0])),
                                        {"reduction": "sum"}, smooth=False, known=zero)]


def error_bad() -> list[Bad]:
    return [Bad("shapes", (X, X[:1]), {}, "y"),
            Bad("reduction", (X, X), {"reduction": "max"}, "reduction")]


def adam_step(p: np.ndarray, g: np.ndarray, m: np.ndarray, v: np.ndarray, *, t: int,
              rate: float = 1e-3, beta1: float = 0.9, beta2: float = 0.999,
              epsilon: float = 1e-8) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One step of algorithm 1 for one array; t, from 1 on, counts this step, m and v are the
    moments before it.

    p, g, m, v : one shape  ->  p, m, v of that shape
    """
    check_whole("t", t, 1, STEPS)
    new, state = nn.adam_step({"p": p}, {"p": g}, {"t": t - 1, "m": {"p": m}, "v": {"p": v}},
                              rate=rate, beta1=beta1, beta2=beta2, epsilon=epsilon)
    return new["p"], state["m"]["p"], state["v"]["p"]


def adam_definition(p: np.ndarray, g: np.ndarray, m: np.ndarray, v: np.ndarray, *, t: int,
                    rate: float = 1e-3, beta1: float = 0.9, beta2: float = 0.999,
                    epsilon: float = 1e-8) -> tuple[np.ndarray, ...]:
    return by_definition.adam(p, g, m, v, t=t, rate=rate, beta1=beta1, beta2=beta2,
                              epsilon=epsilon)


def adam_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    mixed = n(6) * 10.0 ** np.array([-9, -8, -4, 0, 3, 6])
    return [Sample("first step", (n(5), n(5), np.zeros(5), np.zeros(5)), {"t": 1}),
            Sample("tenth step", (n((2, 3)), n((2, 3)), n((2, 3)), n((2, 3)) ** 2), {"t": 10}),
            Sample("tiny gradients", (n(4), np.full(4, 1e-9), np.zeros(4), np.zeros(4)), {"t": 1}),
            Sample("zero gradients", (n(4), np.zeros(4), np.zeros(4), np.zeros(4)), {"t": 1}),
            Sample("mixed sizes", (n(6), mixed, 0.1 * mixed, 0.001 * mixed ** 2), {"t": 2}),
            Sample("other settings", (n(4), n(4), n(4), n(4) ** 2),
                   {"t": 3, "rate": 0.1, "beta1": 0.5, "beta2": 0.9, "epsilon": 1e-3})]


def adam_bad() -> list[Bad]:
    arrays = (np.ones(3), np.ones(3), np.zeros(3), np.zeros(3))
    return [Bad(label, arrays, {"t": t}, "t") for label, t in (
        ("the step before the first", 0), ("half a step", 0.5),
        ("more steps than can be counted", 10 ** 400))]


def _simple(name, arguments, samples, bad=list, equation="", batched=(0,)):
    return Operation(name, arguments, getattr(nn, name), getattr(nn, f"{name}_backward", None),
                     getattr(by_definition, name), samples, bad, batched, equation=equation)


OPERATIONS = (
    _simple("conv1d", ("x", "w", "b"), conv_samples, conv_bad, "the * of equations 1 and 2"),
    _simple("conv_transpose1d", ("h", "w", "b"), transpose_samples, transpose_bad, "equation 2"),
    _simple("max_pool1d", ("x", "width"), max_pool_samples, pool_bad, "equation 1"),
    _simple("max_pool1d_indices", ("x", "width"), max_pool_samples, pool_bad),
    _simple("max_unpool1d", ("h", "indices", "length"), unpool_samples,
            lambda: [Bad("index too large", (X, np.full(X.shape, 9), 9), {}, "indices")],
            batched=(0, 1)),
    _simple("avg_pool1d", ("x", "width"), avg_pool_samples, pool_bad),
    _simple("avg_depool1d", ("h", "width"),
            lambda rng: [Sample("plain", (rng.standard_normal((2, 3, 4)),)),
                         Sample("three", (rng.standard_normal((2, 3, 4)), 3))],
            lambda: [Bad("width 0", (X, 0), {}, "width"), Bad("two dimensions", (X[0],), {}, "h")],
            "equation 2"),
    _simple("random_depool1d", ("h", "chosen", "width"), random_depool_samples, random_depool_bad,
            "equation 2, as the 2016 code learns", (0, 1)),
    _simple("relu", ("x",), relu_samples,
            lambda: [Bad("whole numbers", (np.zeros(3, int),), {}, "x")], "equation 1"),
    _simple("gram", ("h",), clip_samples, lambda: [Bad("two dimensions", (X[0],), {}, "h")],
            "equation 6"),
    _simple("sum_squares", ("r",), clip_samples,
            lambda: [Bad("a scalar", (np.float64(1),), {}, "r")]),
    _simple("mean_squares", ("r",), clip_samples),
    _simple("norm", ("r",), norm_samples, equation="the || || of equations 4 and 5"),
    _simple("l1", ("a",), l1_samples, equation="equation 3", batched=()),
    _simple("squared_error", ("x", "y"), error_samples, error_bad, "equation 3", ()),
    _simple("absolute_error", ("x", "y"), absolute_error_samples, error_bad, batched=()),
    Operation("adam_step", ("p", "g", "m", "v"), adam_step, None, adam_definition, adam_samples,
              adam_bad, (), equation="Kingma and Ba, algorithm 1"),
)
