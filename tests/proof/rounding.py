"""How far rounding takes the text from the exact answer, and how far it may.

With one relative error of at most u (2^-53 in float64, 2^-24 in float32) in each sum, difference,
product and quotient, a result on whose way lie at most n of them is off by no more than

    |found - exact| <= n u / (1 - n u) times the sum of the absolute values of its terms,

in whatever order the terms are added (Higham 2002, section 3.1). Both sides are fractions, computed
exactly. `python -m tests.proof.rounding` prints the share of the bound that each operation takes.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from refimpl import nn
from refimpl.conformance.functions_holden import decode, decode_backward, encode, transform
from refimpl.conformance.specification import as_tuple
from refimpl.holden2017 import losses
from refimpl.motion.features import FORWARD, SIDEWAYS, TURN
from refimpl.motion.joints import FEET
from tests.proof.exactly import exactly

UNIT = {"float64": Fraction(1, 2 ** 53), "float32": Fraction(1, 2 ** 24)}
CONTACTS = np.array([[[1, 0, 1, 1], [0, 1, 0, 1], [1, 1, 1, 1], [0, 0, 1, 0]]])


@dataclass(frozen=True)
class Row:
    """shapes : of the arrays;  roundings : n for each result;  options : keyword arguments;
    terms : of the same arrays, the sum of the terms' absolute values, where it is not what the text
    itself gives for absolute values
    """

    f: Callable
    shapes: tuple
    roundings: tuple
    options: dict = field(default_factory=dict)
    terms: Callable | None = None

    def __str__(self):
        return f"{self.f.__name__.strip('_')} {' '.join(map(str, self.shapes))}"


def measured(row, precision, f=None):
    """The largest error of each result, in u times the sum of its terms' absolute values.

    f : in the place of the text, where it computes with floating-point numbers
    """
    rng = np.random.default_rng(0)
    inputs = [np.asarray(rng.standard_normal(shape)).astype(precision) for shape in row.shapes]
    fractions = [exactly(x) for x in inputs]
    options = {name: exactly(value) for name, value in row.options.items()}
    found = as_tuple((f or row.f)(*inputs, **row.options))
    exact = as_tuple(row.f(*fractions, **options))
    sizes = as_tuple(row.terms(*fractions, **options) if row.terms
                     else row.f(*map(np.abs, fractions), **options))
    return [max(_error(*numbers) / UNIT[precision] for numbers in zip(*map(np.ravel, results)))
            for results in zip(found, exact, sizes) if results[0] is not None]


def _error(found, exact, size):
    off = abs(Fraction(float(found)) - exact)
    return off / abs(size) if off else 0                         # a division by 0 is a fault


def allowed(n, precision):
    """n / (1 - n u), the bound in the same measure."""
    return n / (1 - n * UNIT[precision])


def itself(f):
    """For a sum of squares of differences, each of which has a small relative error: the exact sum
    is the sum of the terms' absolute values."""
    return lambda *inputs, **options: tuple(map(np.abs, as_tuple(f(*inputs, **options))))


def _decode_backward(*arrays):
    return decode_backward(*arrays)


def _decode_backward_terms(dX, H, W0, b0):
    return decode_backward(abs(dX), abs(H), abs(W0), -abs(b0))


def _decode_terms(H, W0, b0):
    return decode(abs(H), abs(W0), -abs(b0))


def _style_terms(G, H, **options):
    return losses.style_loss(-abs(G), abs(H), **options)


def _foot_loss(motion):
    return losses.foot_loss(motion, CONTACTS)


def _foot_terms(motion):
    """|v_r| + |omega x p| + |p[t+1]| + |p[t]|, squared and added up where a foot stands."""
    m = abs(motion)
    p = losses.joint_positions(m)[:, FEET]
    v = p[..., 1:] + p[..., :-1]
    v[:, :, 0] += m[:, None, SIDEWAYS, :-1] + m[:, None, TURN, :-1] * p[:, :, 2, :-1]
    v[:, :, 2] += m[:, None, FORWARD, :-1] + m[:, None, TURN, :-1] * p[:, :, 0, :-1]
    return np.sum(CONTACTS[:, :, None, :-1] * v * v, axis=(1, 2, 3))


# Of a sum of m products m roundings lie on the way of each; a difference that is squared counts
# twice; halves and powers of two are exact; a constant is rounded once to float32.
EVERYTHING = {"stride": 2, "padding": (1, 2), "dilation": 2, "groups": 2}
SQUARES = {"reading": "mean_squares", "c": 0.7}
ROWS = [
    Row(nn.conv1d, ((1, 4, 20), (3, 4, 9), (3,)), (4 * 9 + 1,)),
    Row(nn.conv1d, ((1, 16, 8), (3, 16, 25), (3,)), (16 * 25 + 1,)),
    Row(nn.conv1d, ((2, 4, 21), (6, 2, 4), (6,)), (2 * 4 + 1,), EVERYTHING),
    Row(nn.conv1d_backward, ((2, 3, 20), (2, 4, 20), (3, 4, 9), (3,)), (3 * 9, 40, 40)),
    Row(nn.conv1d_backward, ((2, 6, 9), (2, 4, 21), (6, 2, 4), (6,)), (3 * 4, 18, 18), EVERYTHING),
    Row(nn.conv_transpose1d, ((1, 3, 20), (3, 4, 9), (4,)), (3 * 9 + 1,)),
    Row(nn.conv_transpose1d, ((2, 6, 9), (6, 2, 4), (4,)), (3 * 4 + 1,), EVERYTHING),
    Row(nn.conv_transpose1d_backward, ((2, 4, 20), (2, 3, 20), (3, 4, 9), (4,)), (4 * 9, 40, 40)),
    Row(nn.max_pool1d, ((2, 3, 20),), (0,)),
    Row(nn.max_pool1d_backward, ((2, 3, 10), (2, 3, 20)), (0,)),
    Row(nn.avg_pool1d, ((2, 3, 20),), (5,), {"width": 5, "stride": 2, "padding": 2}),
    Row(nn.avg_pool1d, ((1, 2, 100),), (100,), {"width": 100}),
    Row(nn.avg_pool1d_backward, ((2, 3, 10), (2, 3, 20)), (1 + 2 + 1,),
        {"width": 5, "stride": 2, "padding": 2}),
    Row(nn.avg_depool1d, ((2, 3, 10),), (1,), {"width": 3}),
    Row(nn.avg_depool1d_backward, ((2, 3, 30), (2, 3, 10)), (3,), {"width": 3}),
    Row(nn.gram, ((2, 5, 20),), (20,)), Row(nn.gram, ((1, 3, 200),), (200,)),
    Row(nn.gram_backward, ((2, 5, 5), (2, 5, 20)), (1 + 5,)),
    Row(nn.sum_squares, ((2, 50),), (50,)), Row(nn.sum_squares, ((1, 20, 20),), (400,)),
    Row(nn.sum_squares_backward, ((2,), (2, 50)), (1,)),
    Row(nn.mean_squares, ((2, 50),), (50 + 1,)),
    Row(nn.mean_squares_backward, ((2,), (2, 50)), (2,)),
    Row(nn.l1, ((4, 10),), (40,)),
    Row(nn.squared_error, ((4, 10), (4, 10)), (2 + 40 + 1,), {}, itself(nn.squared_error)),
    Row(nn.squared_error_backward, ((), (4, 10), (4, 10)), (3, 3), {},
        itself(nn.squared_error_backward)),
    Row(nn.absolute_error, ((4, 10), (4, 10)), (1 + 40 + 1,), {}, itself(nn.absolute_error)),
    Row(encode, ((1, 4, 20), (5, 4, 9), (5,)), (4 * 9 + 1,)),
    Row(decode, ((1, 3, 10), (3, 4, 9), (3,)), (1 + 3 * 9,), {}, _decode_terms),
    Row(decode, ((2, 5, 4), (5, 2, 25), (5,)), (1 + 5 * 25,), {}, _decode_terms),
    Row(_decode_backward, ((1, 4, 20), (1, 3, 10), (3, 4, 9), (3,)),
        (4 * 9 + 1, 1 + 20, 4 * 9 + 20), {}, _decode_backward_terms),
    Row(transform, ((1, 4, 10), (3, 4, 5), (3,), (3, 3, 5), (3,), (4, 3, 5), (4,)),
        (4 * 5 + 1 + 2 * (3 * 5 + 1),)),
    Row(losses.content_loss, ((1, 4, 10), (1, 4, 10)), (2 + 40 + 1 + 2,), SQUARES,
        itself(losses.content_loss)),
    Row(losses.style_loss, ((1, 4, 4), (1, 4, 10)), (2 * (10 + 1) + 16 + 2,),
        {"reading": "sum_squares", "s": 0.3}, _style_terms),
    Row(_foot_loss, ((1, 66, 4),), (2 * 5 + 36,), {}, _foot_terms),
    Row(losses.trajectory_loss, ((1, 66, 10), (1, 3, 10)), (2 + 3 + 29,), {"turn_weight": 0.3},
        itself(losses.trajectory_loss)),
    Row(losses.trajectory_loss_backward, ((2,), (2, 66, 10), (2, 3, 10)), (4,),
        {"turn_weight": 0.3}, itself(losses.trajectory_loss_backward))]


def table(rows=ROWS):
    """->  lines of text: the operation, n, and in each precision the largest error in u and its
    share of the bound"""
    yield f"{'operation':70} {'n':>4} {'float64':>9} {'share':>6} {'float32':>9} {'share':>6}"
    for row in rows:
        columns = [measured(row, precision) for precision in UNIT]
        for number, n in enumerate(row.roundings):
            text = f"{str(row) if not number else f'    gradient {number + 1}':70} {n:4}"
            for precision, errors in zip(UNIT, columns):
                share = errors[number] / allowed(n, precision) if n else 0
                text += f" {float(errors[number]):9.3f} {float(share):6.3f}"
            yield text


if __name__ == "__main__":
    for line in table():
        print(line)
