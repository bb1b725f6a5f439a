"""Gradients for judging a checker of gradients: 34 wrong ones, each in a way that backwards written
by hand go wrong, here, and 37 right ones at awkward points, in `cases_right.py`.

`tests/gradcheck/benchmark.py` runs them. Each has an independent derivative, `truth`, so that what
a checker says can be judged as well.
"""

from typing import Any, Callable, NamedTuple

import numpy as np

STATE: dict = {}    # what the backwards with a memory remember; emptied with each draw of inputs


class Between(NamedTuple):
    """The derivative of each element at a kink: all from `low` to `high` is right."""
    low: Any
    high: Any


class Case(NamedTuple):
    """One gradient: `f_backward(dy, *inputs)` is what a checker judges, `truth(dy, *inputs)` the
    derivative in the same form (a `Between` where elements may lie at a kink).

    `inputs` makes them from a seed. `breaks` names the promises beside the derivative that a wrong
    one breaks, so that a message about these is a true one: linear, repeat, changed, memory,
    layout, dtype, shape.
    """
    name: str
    special: str
    f: Callable
    f_backward: Callable
    inputs: Callable
    truth: Callable
    right: bool = False
    breaks: str = ""


def draw(*shapes, low=None, high=1.0, put=None):
    """Inputs of these shapes as a function of a seed: normal, or uniform from low to high; `put`
    replaces every other element, in the array's order."""
    def inputs(seed):
        STATE.clear()
        rng = np.random.default_rng(seed)
        arrays = [np.asarray(rng.normal(size=s) if low is None else rng.uniform(low, high, s))
                  for s in shapes]
        if put is not None:
            for array in arrays:
                array.flat[::2] = put
        return tuple(arrays)
    return inputs


def powers(shape, low, high):
    """Inputs whose logarithm to the base of 10 is uniform from low to high."""
    return lambda seed: (10 ** np.random.default_rng(seed).uniform(low, high, shape),)


def square(x):
    return x ** 2


def energy(x):
    return np.sum(x ** 2)


def twice(dy, x):
    return 2 * dy * x


def relu(x):
    return np.maximum(x, 0)


def slope(dy, x, left, right):
    """Truth of a function of this slope left and right of a kink at 0."""
    one, other = dy * np.where(x > 0, right, left), dy * np.where(x < 0, left, right)
    return Between(np.minimum(one, other), np.maximum(one, other))


def softmax(x):
    e = np.exp(x - np.real(x).max(axis=1, keepdims=True))
    return e / e.sum(axis=1, keepdims=True)


def softmax_truth(dy, x):
    jacobian = [np.diag(y) - np.outer(y, y) for y in softmax(x)]
    return np.array([J @ d for J, d in zip(jacobian, dy)]).reshape(x.shape)


def smooth(x):
    p = np.concatenate([x[:1], x, x[-1:]])
    return (p[:-2] + p[1:-1] + p[2:]) / 3


def smooth_truth(dy, x):
    g = np.zeros_like(x)
    for t in range(len(x)):
        for k in (t - 1, t, t + 1):
            g[min(max(k, 0), len(x) - 1)] += dy[t] / 3
    return g


def affine(p, x):
    return x @ p["W"] + p["b"]


def affine_truth(dy, p, x):
    return ({"W": np.einsum("ni,no->io", x, dy), "b": np.einsum("no->o", dy)},
            np.einsum("no,io->ni", dy, p["W"]))


def layer(seed):
    x, W, b = draw((6, 4), (4, 3), (3,))(seed)
    return {"W": W, "b": b}, x


def accumulated(dy, x):
    STATE["sum"] = STATE.get("sum", 0) + 2 * dy * x
    return STATE["sum"].copy()


def remembering_exp(x):
    STATE["y"] = np.exp(x)
    return STATE["y"]


def in_a_buffer(dy, x):
    buffer = STATE.setdefault(np.shape(x), np.empty(np.shape(x)))
    return np.multiply(2 * dy, x, out=buffer)


def in_place(dy, x):
    dy *= 2 * x
    return dy


SIZES = np.logspace(3, -9, 12)
NOISE = np.random.default_rng(8)

WRONG = [
    Case("square", "Its factor of 2 is missing.",
         square, lambda dy, x: dy * x, draw((3, 4)), twice),
    Case("reciprocal", "Its sign is missing.", lambda x: 1 / x, lambda dy, x: dy / x ** 2,
         draw((3, 4), low=0.5, high=2), lambda dy, x: -dy * x ** -2),
    Case("matrix product", "One factor is not transposed.",
         lambda x, W: x @ W, lambda dy, x, W: (dy @ W, x.T @ dy), draw((3, 4), (4, 4)),
         lambda dy, x, W: (np.einsum("no,io->ni", dy, W), np.einsum("ni,no->io", x, dy))),
    Case("convolution", "The kernel is not flipped.", lambda x: np.convolve(x, [1., 2, 4], "valid"),
         lambda dy, x: np.convolve(dy, [1., 2, 4]), draw(12),
         lambda dy, x: np.convolve(dy, [4., 2, 1])),
    Case("mean of squares", "A sum's gradient for a mean.", lambda x: np.mean(x ** 2, axis=0),
         twice, draw((5, 4)), lambda dy, x: 2 * x * dy / len(x)),
    Case("offset", "Only the last of two broadcast axes is summed.", lambda x, b: x + b,
         lambda dy, x, b: (dy.copy(), dy.sum(1, keepdims=True)[:1]), draw((4, 5, 3), (1, 1, 3)),
         lambda dy, x, b: (+dy, np.einsum("ijk->k", dy)[None, None])),
    Case("softmax's diagonal", "The terms off the diagonal are forgotten.", softmax,
         lambda dy, x: dy * softmax(x) * (1 - softmax(x)), draw((3, 5)), softmax_truth),
    Case("smoothing", "Wrong at both edges: what was padded is forgotten.", smooth,
         lambda dy, x: (np.r_[dy[1:], 0] + dy + np.r_[0, dy[:-1]]) / 3, draw(9), smooth_truth),
    Case("one of 5,000", "One element is off by 1e-7.", lambda x: np.sum(np.sin(x)),
         lambda dy, x: dy * (np.cos(x) + 1e-7 * (x == x.max())), draw(5000),
         lambda dy, x: dy * np.sin(x + np.pi / 2)),
    Case("small beside large", "Elements of 1e-7 and less beside 1e3 are 10 % off.",
         lambda x: np.sum(SIZES * np.exp(x)),
         lambda dy, x: dy * np.where(SIZES < 1e-6, 1.1, 1) * SIZES * np.exp(x), draw((2, 12)),
         lambda dy, x: dy * np.exp(x) * SIZES),
    Case("small beside large, real", "The same of a function that takes no complex numbers.",
         lambda x: SIZES * np.cbrt(x),
         lambda dy, x: dy * np.where(SIZES < 1e-6, 1.1, 1) * SIZES / (3 * np.cbrt(x) ** 2),
         draw((2, 12), low=0.5, high=2), lambda dy, x: dy * SIZES * np.abs(x) ** (-2 / 3) / 3),
    Case("softplus", "Off by 5e-9; takes no complex numbers.", lambda x: np.logaddexp(x, 1),
         lambda dy, x: dy * (1 + 5e-9) / (1 + np.exp(1 - x)), draw((3, 4)),
         lambda dy, x: dy * (1 + np.tanh((x - 1) / 2)) / 2),
    Case("hypot", "One of two inputs is off by 5e-9; takes no complex numbers.", np.hypot,
         lambda dy, x, y: (dy * x / np.hypot(x, y), dy * (y / np.hypot(x, y) + 5e-9)),
         draw((3, 4), (3, 4), low=0.5, high=2), lambda dy, x, y:
         (dy * np.cos(np.arctan2(y, x)), dy * np.sin(np.arctan2(y, x)))),
    Case("exp", "Off by 5e-13 of its size.", np.exp,
         lambda dy, x: dy * np.exp(x) * (1 + 5e-13), draw((3, 4)), lambda dy, x: dy * np.exp(x)),
    Case("tanh", "Off by 5e-13.", np.tanh, lambda dy, x: dy * (1 - np.tanh(x) ** 2 + 5e-13),
         draw((3, 4)), lambda dy, x: dy / np.cosh(x) ** 2),
    Case("energy, |dy|", "Right where dy is positive; one output.", energy,
         lambda dy, x: 2 * np.abs(dy) * x, draw((3, 4)), twice, breaks="linear"),
    Case("energy, clipped dy", "Right where dy is small; one output.", energy,
         lambda dy, x: 2 * np.clip(dy, -3, 3) * x, draw((3, 4)), twice, breaks="linear"),
    Case("energy, dy taken for 1", "Right where dy is 1; one output.", energy,
         lambda dy, x: 2 * x, draw((3, 4)), twice, breaks="linear"),
    Case("accumulated", "Right at the first call, then added to it.", square, accumulated,
         draw((3, 4)), twice, breaks="repeat linear shape layout memory"),
    Case("stale cache", "Takes the result of f's last call, whatever its inputs were.",
         remembering_exp, lambda dy, x: dy * STATE["y"].real, draw((3, 4)),
         lambda dy, x: dy * np.exp(x), breaks="repeat linear shape layout"),
    Case("buffer", "Every call writes into the array that the last one returned.", square,
         in_a_buffer, draw((3, 4)), twice, breaks="memory repeat"),
    Case("a single clip", "Wrong for one clip, drawn with three.", lambda x: x - x.mean(axis=0),
         lambda dy, x: dy - dy.mean(axis=0) if len(x) > 1 else +dy, draw((3, 4)),
         lambda dy, x: dy - np.full((len(x), len(x)), 1 / len(x)) @ dy),
    Case("signed square", "Wrong for negative inputs, drawn positive.", lambda x: x * np.abs(x),
         twice, draw((3, 4), low=0.1, high=2), lambda dy, x: 2 * dy * np.abs(x)),
    Case("relu with a margin", "Wrong only where x lies between 0 and 1e-7.", relu,
         lambda dy, x: dy * (x > 1e-7), draw((3, 4), low=1e-10, high=5e-8, put=0.5),
         lambda dy, x: slope(dy, x, 0, 1)),
    Case("hidden staircase", "f rounds to 4 decimals; the gradient is that of no rounding.",
         lambda x: np.floor(1e4 * x) / 1e4, lambda dy, x: +dy, draw((3, 4)), lambda dy, x: 0 * dy),
    Case("float32 inside", "The backward computes in float32 and returns float64.", square,
         lambda dy, x: np.multiply(2 * dy, x, dtype=np.float32).astype(float), draw((3, 4)), twice,
         breaks="dtype"),
    Case("float32 outside", "The backward returns float32.", square,
         lambda dy, x: (2 * dy * x).astype(np.float32), draw((3, 4)), twice, breaks="dtype"),
    Case("noise", "Another 1e-3 of noise at each call.", square,
         lambda dy, x: 2 * dy * x + 1e-3 * NOISE.normal(size=x.shape), draw((3, 4)), twice,
         breaks="repeat linear layout memory"),
    Case("|x| at 0", "1.5 where all from -1 to 1 is right.", np.abs,
         lambda dy, x: dy * np.where(x == 0, 1.5, np.sign(x)), draw((3, 4), put=0),
         lambda dy, x: slope(dy, x, -1, 1)),
    Case("leaky relu at 0", "0 where all from 0.1 to 1 is right.", lambda x: np.where(
        x > 0, x, 0.1 * x), lambda dy, x: dy * (0.55 + 0.45 * np.sign(x)) * (x != 0),
         draw((3, 4), put=0), lambda dy, x: slope(dy, x, 0.1, 1)),
    Case("layer with a dict", "The offset's gradient is a mean, needed the sum.", affine,
         lambda dy, p, x: ({"W": x.T @ dy, "b": dy.mean(axis=0)}, dy @ p["W"].T), layer,
         affine_truth),
    Case("second result", "The second result's part is forgotten.",
         lambda x: (x ** 2, x.sum(axis=1)), lambda dy, x: 2 * dy[0] * x, draw((3, 4)),
         lambda dy, x: 2 * dy[0] * x + np.outer(dy[1], np.ones(x.shape[1]))),
    Case("in place", "The right numbers, written over the upstream gradient.", square, in_place,
         draw((3, 4)), twice, breaks="changed memory repeat"),
    Case("order of memory", "Reads x as it lies in memory: wrong for Fortran order.", square,
         lambda dy, x: 2 * dy * x.ravel("K").reshape(x.shape), draw((3, 4)), twice,
         breaks="layout"),
]
