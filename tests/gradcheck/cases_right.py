"""37 right gradients at awkward points: a checker should accept them, may call some undecided, and
must call none wrong.
"""

import numpy as np

from tests.gradcheck.cases import (Between, Case, draw, powers, relu, slope, softmax,
                                   softmax_truth, square, twice)


def first_of_ties(dy, x):
    pairs = x.reshape(len(x), -1, 2)
    return (dy[..., None] * (pairs.argmax(-1)[..., None] == [0, 1])).reshape(x.shape)


def ties_truth(dy, x):
    other = x.reshape(len(x), -1, 2)[..., ::-1].reshape(x.shape)
    return slope(np.repeat(dy, 2, axis=1), x - other, 0, 1)


def length(x):
    return np.sqrt(np.sum(x * x, axis=1))


def length_truth(dy, x):
    n, dy = np.linalg.norm(x, axis=1)[:, None], dy[:, None] * np.ones_like(x)
    g = dy * x / np.where(n == 0, 1, n)
    return Between(np.where(n == 0, -np.abs(dy), g), np.where(n == 0, np.abs(dy), g))


def gather_truth(dy, table, rows):
    chosen = (np.asarray(rows)[:, None] == np.arange(len(table))).astype(float)
    return 2 * table * (chosen.T @ dy)


def add_at(dy, table, rows):
    g = np.zeros_like(table)
    np.add.at(g, rows, 2 * dy * table[rows])
    return g


def only_if(holds, f):
    """f, refusing other inputs than those that it is meant for."""
    def refusing(x):
        if not holds(np.real(x)):
            raise ValueError("x: found elements outside of what f takes")
        return f(x)
    return refusing


def huber(x):
    return np.where(np.abs(x) <= 1, x * x / 2, np.abs(x) - 0.5)


def cube_root(x):
    y = x
    for _ in range(60):
        y = y - (y - x / y ** 2) / 3
    return y


def cumprod_backward(dy, x):
    g = np.zeros_like(x)
    for t in range(x.shape[1]):
        before = np.prod(x[:, :t], axis=1)
        after = np.cumprod(np.c_[np.ones(len(x)), x[:, t + 1:]], axis=1)
        g[:, t] = before * np.sum(dy[:, t:] * after, axis=1)
    return g


def cumprod_truth(dy, x):
    return np.stack([np.sum(dy * np.cumprod(np.where(np.arange(x.shape[1]) == t, 1, x), axis=1)
                            * (np.arange(x.shape[1]) >= t), axis=1)
                     for t in range(x.shape[1])], axis=1)


def spectrum_truth(dy, x):
    F = np.exp(-2j * np.pi * np.outer(np.arange(x.shape[1]), np.arange(x.shape[1])) / x.shape[1])
    return 2 * (dy * (x @ F.real)) @ F.real + 2 * (dy * (x @ F.imag)) @ F.imag


GRID, HEIGHTS = np.linspace(-9, 9, 7), np.array([0., 1, -1, 3, 2, 2, 5])
SLOPES = np.array([1e-6, 1e-2, 1e2, 1e6])


def close_points(seed):
    x, step = draw((3, 5), (3, 5))(seed)
    return x, x + 1e-7 * step


def near_tie(seed):
    x, = draw((3, 4))(seed)
    x[:, 1] = x.max(axis=1) + 1
    x[:, 2] = x[:, 1] - 1e-7
    return (x,)


def with_mask(seed):
    x, keep = draw((3, 4), (3, 4))(seed)
    return x, keep > 0


def table_and_rows(seed):
    return draw((6, 3))(seed)[0], np.random.default_rng(seed).integers(0, 6, 8)


def hidden(seed):
    x, W, b = draw((5, 4), (4, 3), (3,))(seed)
    return {"W": W, "b": b}, x


def hidden_backward(dy, p, x):
    da = dy * (1 - np.tanh(x @ p["W"] + p["b"]) ** 2)
    return {"W": x.T @ da, "b": da.sum(axis=0)}, da @ p["W"].T


def hidden_truth(dy, p, x):
    da = dy / np.cosh(np.einsum("ni,io->no", x, p["W"]) + p["b"]) ** 2
    return ({"W": sum(np.outer(row, d) for row, d in zip(x, da)), "b": np.ones(len(x)) @ da},
            np.einsum("no,io->ni", da, p["W"]))


RIGHT = [
    Case("relu at 0", "Half of the elements lie on the kink.", relu, lambda dy, x: dy * (x > 0),
         draw((3, 4), put=0), lambda dy, x: slope(dy, x, 0, 1)),
    Case("relu beside 0", "Elements 1e-9 from the kink.", relu, lambda dy, x: dy * (x > 0),
         draw((3, 4), put=1e-9), lambda dy, x: slope(dy, x, 0, 1)),
    Case("relu near 0", "Elements -1e-5 from the kink.", relu, lambda dy, x: dy * (x > 0),
         draw((3, 4), put=-1e-5), lambda dy, x: slope(dy, x, 0, 1)),
    Case("max-pool", "Ties; the first of equals gets it all.",
         lambda x: x.reshape(len(x), -1, 2).max(axis=-1), first_of_ties,
         lambda seed: (np.floor(draw((3, 8), low=0, high=3)(seed)[0]),), ties_truth),
    Case("norm at 0", "One row is 0, and its gradient 0; all from -dy to dy is right.", length,
         lambda dy, x: dy[:, None] * x / np.maximum(length(x), 1e-300)[:, None],
         lambda seed: (draw((4, 3))(seed)[0] * [[1], [0], [1], [2]],), length_truth),
    Case("sum of |x|", "Half of the elements are 0; one output.", lambda x: np.sum(np.abs(x)),
         lambda dy, x: dy * np.sign(x), draw((3, 4), put=0), lambda dy, x: slope(dy, x, -1, 1)),
    Case("|x|, 0.9999 at 0", "Between the derivatives of both sides, near one end.", np.abs,
         lambda dy, x: dy * np.where(x == 0, 0.9999, np.sign(x)), draw((3, 4), put=0),
         lambda dy, x: slope(dy, x, -1, 1)),
    Case("sqrt near 0", "From 1e-13 to 1e-6: every usual step leaves the domain.", np.sqrt,
         lambda dy, x: dy / (2 * np.sqrt(x)), powers((3, 4), -13, -6),
         lambda dy, x: 0.5 * dy * x ** -0.5),
    Case("sin(1e5 x)", "Turns many times within an ordinary step.", lambda x: np.sin(1e5 * x),
         lambda dy, x: 1e5 * dy * np.cos(1e5 * x), draw((3, 4)),
         lambda dy, x: 1e5 * dy * (1 - 2 * np.sin(0.5e5 * x) ** 2)),
    Case("1e12 + x^2", "Most digits are the constant's; takes no complex numbers.",
         lambda x: 1e12 + np.hypot(x, 0) ** 2, twice, draw((3, 4)), lambda dy, x: dy * x + dy * x),
    Case("x^2 at 1e-200", "The result is 0 in float64, the derivative is not.", square, twice,
         lambda seed: (1e-200 * draw((3, 4))(seed)[0],), lambda dy, x: dy * x + dy * x),
    Case("float32 inside f", "f computes in float32; to be accepted or left undecided.",
         lambda x: np.sin(x, dtype=np.float32, casting="same_kind").astype(float),
         lambda dy, x: dy * np.cos(x), draw((3, 4)), lambda dy, x: dy * np.sin(x + np.pi / 2)),
    Case("sizes of x", "sin(a x) with a and 1/x from 1e-6 to 1e6 in one array.",
         lambda x: np.sin(SLOPES * x), lambda dy, x: dy * SLOPES * np.cos(SLOPES * x),
         lambda seed: (draw((3, 4), low=0.2, high=3)(seed)[0] / SLOPES,),
         lambda dy, x: dy * SLOPES * (1 - 2 * np.sin(SLOPES * x / 2) ** 2)),
    Case("sizes of inputs", "One input near 1e-8, the other near 1e8.", lambda x, y: x * y * y,
         lambda dy, x, y: (dy * y * y, 2 * dy * x * y),
         lambda seed: tuple(a * s for a, s in zip(draw((3, 4), (3, 4))(seed), (1e-8, 1e8))),
         lambda dy, x, y: (y ** 2 * dy, y * (x * dy) + (x * dy) * y)),
    Case("5,000 elements", "One sum of them all.", lambda x: np.sum(np.log(1 + x * x)),
         lambda dy, x: dy * 2 * x / (1 + x * x), draw(5000),
         lambda dy, x: dy * np.sin(2 * np.arctan(x))),
    Case("60,000 elements", "One sum of them all; takes no complex numbers.",
         lambda x: np.sum(np.arctan2(x, 1)), lambda dy, x: dy / (1 + x * x), draw((300, 200)),
         lambda dy, x: dy * np.cos(np.arctan(x)) ** 2),
    Case("no elements", "Arrays of shape (0, 3).", square, twice, draw((0, 3)),
         lambda dy, x: np.zeros((0, 3))),
    Case("no axes", "A 0-d array in, a 0-d array out.", lambda x: x * np.sin(x),
         lambda dy, x: dy * (np.sin(x) + x * np.cos(x)), draw(()),
         lambda dy, x: dy * x * np.cos(x) + dy * np.sin(x)),
    Case("mask", "An array of booleans among the inputs.",
         lambda x, keep: np.where(keep, x ** 3, 0), lambda dy, x, keep: 3 * dy * x ** 2 * keep,
         with_mask, lambda dy, x, keep: (np.where(keep, 3 * dy * x * x, 0), None)),
    Case("rows of a table", "Whole numbers among the inputs; rows taken twice add up.",
         lambda table, rows: table[rows] ** 2, add_at, table_and_rows,
         lambda dy, table, rows: (gather_truth(dy, table, rows), None)),
    Case("dict of parameters", "Gradients with the dict's keys.",
         lambda p, x: np.tanh(x @ p["W"] + p["b"]), hidden_backward, hidden, hidden_truth),
    Case("two results", "A tuple out, a tuple of upstream gradients in.",
         lambda x, y: (x * y, x.sum(axis=0)),
         lambda dy, x, y: (dy[0] * y + dy[1], dy[0] * x), draw((3, 4), (3, 4)),
         lambda dy, x, y: (y * dy[0] + np.outer(np.ones(len(x)), dy[1]), x * dy[0])),
    Case("log", "From 1e-9 up; ValueError for what is not above 0.",
         only_if(lambda x: np.all(x > 0), np.log), lambda dy, x: dy / x, powers((3, 4), -9, 0),
         lambda dy, x: dy * np.exp(-np.log(x))),
    Case("arccos near 1", "At 0.999999; NaN from 1 on.", np.arccos,
         lambda dy, x: -dy / np.sqrt(1 - x * x), draw((3, 4), low=0.9999985, high=0.9999995),
         lambda dy, x: -dy / np.sqrt((1 - x) * (1 + x))),
    Case("Huber's loss", "Elements on the joint of its pieces, which have one slope there.", huber,
         lambda dy, x: dy * np.clip(x, -1, 1), draw((3, 4), put=1),
         lambda dy, x: dy * np.where(np.abs(x) <= 1, x, np.sign(x))),
    Case("iterated cube root", "60 steps of Newton's.", cube_root,
         lambda dy, x: dy / (3 * cube_root(x) ** 2), draw((3, 4), low=0.5, high=8),
         lambda dy, x: dy * np.abs(x) ** (-2 / 3) / 3),
    Case("cancelling terms", "Linear, but half of the digits cancel.",
         lambda x: (1e8 * x + x) - 1e8 * x, lambda dy, x: +dy, draw((3, 4)),
         lambda dy, x: 1 * dy),
    Case("distance of near points", "Two points 1e-7 apart: curved within a step.",
         lambda x, y: length(x - y), lambda dy, x, y: (
             dy[:, None] * (x - y) / length(x - y)[:, None],
             dy[:, None] * (y - x) / length(x - y)[:, None]), close_points,
         lambda dy, x, y: (length_truth(dy, x - y), length_truth(dy, y - x))),
    Case("softmax", "Of numbers near 1000.", softmax, lambda dy, x: softmax(x) * (
        dy - np.sum(dy * softmax(x), axis=1, keepdims=True)),
         lambda seed: (1000 + 3 * draw((3, 5))(seed)[0],), softmax_truth),
    Case("cumulative product", "One factor is 0.", lambda x: np.cumprod(x, axis=1),
         cumprod_backward, lambda seed: (draw((3, 5))(seed)[0] * [1, 1, 0, 1, 1],), cumprod_truth),
    Case("power spectrum", "Complex inside, real outside.",
         lambda x: np.abs(np.fft.fft(x, axis=1)) ** 2, lambda dy, x: 2 * x.shape[1] * np.real(
             np.fft.ifft(dy * np.fft.fft(x, axis=1), axis=1)), draw((2, 6)), spectrum_truth),
    Case("probabilities", "ValueError for what is not from 0 to 1.", only_if(
        lambda x: np.all((x >= 0) & (x <= 1)), lambda x: x * np.log(x)),
         lambda dy, x: dy * (np.log(x) + 1), draw((3, 4), low=0.01, high=0.99),
         lambda dy, x: dy * np.log(np.e * x)),
    Case("weights without a gradient", "None for a constant array of float64.",
         lambda x, w: w * x ** 2, lambda dy, x, w: (2 * dy * w * x, None), draw((3, 4), (3, 4)),
         lambda dy, x, w: (dy * w * x + dy * w * x, None)),
    Case("largest of a row", "The two largest are 1e-7 apart.", lambda x: x.max(axis=1),
         lambda dy, x: dy[:, None] * (x == x.max(axis=1, keepdims=True)), near_tie,
         lambda dy, x: np.where(np.arange(x.shape[1]) == x.argmax(axis=1)[:, None],
                                dy[:, None], 0)),
    Case("interpolation", "Pieces of lines; takes no complex numbers.",
         lambda x: np.interp(x, GRID, HEIGHTS), lambda dy, x: dy * np.diff(HEIGHTS)[
             np.searchsorted(GRID, x) - 1] / 3, draw((3, 4), low=-8.9, high=8.9),
         lambda dy, x: dy * np.array([1, -2, 4, -1, 0, 3])[np.floor((x + 9) / 3).astype(int)] / 3),
    Case("saturated tanh", "At 15 to 25 the result is 1, the derivative 1e-13 to 1e-21.", np.tanh,
         lambda dy, x: dy / np.cosh(x) ** 2, draw((3, 4), low=15, high=25),
         lambda dy, x: dy * 4 / (np.exp(x) + np.exp(-x)) ** 2),
    Case("staircase", "floor between its steps: the gradient is 0.", np.floor,
         lambda dy, x: 0 * dy, draw((3, 4)), lambda dy, x: np.zeros_like(x)),
]
RIGHT = [case._replace(right=True) for case in RIGHT]
