"""What is proved: operations at shapes, with a symbol in every entry of every array."""

from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
import sympy

from refimpl.conformance.backend import OPERATIONS
from refimpl.conformance.specification import as_tuple
from tests.proof.symbolic import Germ, derivatives, exact_definitions, germs, symbols

# that this foot stands in this frame, a constant
CONTACTS = np.array([[[1, 0, 1], [0, 1, 0], [1, 1, 1], [0, 0, 1]]])


def number(name):
    """One symbol, for an option that is a number."""
    return sympy.Symbol(name)


@dataclass(frozen=True)
class Claim:
    """inputs : shapes of the arrays that are symbols, and constants as they are;  options : keyword
    arguments;  point : None where the text compares no numbers, else which random point it is near
    """

    operation: str
    inputs: tuple
    options: dict = field(default_factory=dict)
    point: int | None = None

    def __str__(self):
        shapes = "-".join("x".join(map(str, s)) for s in self.inputs if isinstance(s, tuple))
        options = (f"{name}={value if isinstance(value, (int, str, tuple)) else '...'}"
                   for name, value in self.options.items())
        return " ".join([self.operation, shapes, *options]
                        + [f"near point {self.point}"] * (self.point is not None))


def drawn(claim):
    """Its inputs, with symbols or with germs in the arrays."""
    return [_numbers(claim, name, given) if isinstance(given, tuple) else given for name, given
            in zip(OPERATIONS[claim.operation].arguments, claim.inputs)]


def _numbers(claim, name, shape):
    if claim.point is None:
        return symbols(name, shape)
    return germs(name, shape, np.random.default_rng([claim.point, *name.encode()]))


def evaluated(claim, backward=None):
    """->  the outputs of the text, those of the definition, its gradients, and the derivatives

    backward : in the place of the operation's own
    """
    operation, inputs = OPERATIONS[claim.operation], drawn(claim)
    y = operation.f(*inputs, **claim.options)
    with exact_definitions():
        again = operation.definition(*inputs, **claim.options)
    dy = _numbers(claim, "dy", np.shape(y))
    found = as_tuple((backward or operation.backward)(dy[()], *inputs, **claim.options))
    arrays = [x for x, given in zip(inputs, claim.inputs) if isinstance(given, tuple)]
    return y, again, [g for g in found if g is not None], [derivatives(y, dy, x) for x in arrays]


def _all(operation, *rows, point=None):
    return [Claim(operation, tuple(inputs), options, point) for *inputs, options in rows]


def _near(points, *rows):
    return [claim for point in points for claim in _all(*rows, point=point)]


SMOOTH = [
    *_all("conv1d",
          ((2, 2, 4), (2, 2, 3), (2,), {}), ((1, 2, 5), (2, 2, 4), {}),
          ((1, 2, 5), (3, 2, 3), (3,), {"padding": "valid"}),
          ((1, 1, 4), (2, 1, 3), (2,), {"padding": (0, 3)}), ((1, 1, 2), (2, 1, 5), (2,), {}),
          ((1, 2, 6), (2, 2, 3), (2,), {"stride": 2, "padding": 1}),
          ((1, 2, 6), (2, 2, 2), (2,), {"stride": 3, "padding": 1}),
          ((1, 2, 6), (2, 2, 3), (2,), {"dilation": 2}),
          ((1, 4, 4), (4, 2, 2), (4,), {"groups": 2}), ((1, 3, 4), (3, 1, 3), (3,), {"groups": 3}),
          ((2, 4, 5), (4, 2, 2), (4,), {"stride": 2, "padding": (1, 2), "dilation": 2,
                                        "groups": 2})),
    *_all("conv_transpose1d",
          ((2, 2, 4), (2, 2, 3), (2,), {}), ((1, 2, 3), (2, 2, 4), {"padding": "valid"}),
          ((1, 2, 3), (2, 2, 3), (2,), {"stride": 3, "padding": 1, "output_padding": 2}),
          ((1, 2, 4), (2, 2, 2), (2,), {"dilation": 2}),
          ((1, 4, 3), (4, 2, 2), (4,), {"groups": 2}),
          ((2, 4, 2), (4, 2, 2), (4,), {"stride": 2, "padding": (1, 0), "dilation": 2, "groups": 2,
                                        "output_padding": 1})),
    *_all("avg_pool1d",
          ((2, 2, 6), 2, {}), ((1, 2, 7), 3, {"stride": 1, "padding": 1}),
          ((1, 2, 7), 2, {"ceil_mode": True}),
          ((1, 2, 8), 3, {"padding": 1, "stride": 2, "ceil_mode": True,
                          "count_include_pad": False})),
    *_all("avg_depool1d", ((2, 2, 3), 2, {}), ((1, 2, 3), 3, {})),
    *_all("random_depool1d", ((1, 2, 3), np.array([[[0, 1, 1], [1, 0, 0]]]), 2, {}),
          ((1, 1, 4), np.array([[[2, 0, 1, 1]]]), 3, {})),
    *_all("max_unpool1d", ((1, 2, 3), np.array([[[0, 3, 4], [1, 2, 5]]]), 6, {}),
          ((1, 1, 4), np.array([[[0, 2, 2, 0]]]), 3, {})),
    *_all("gram", ((1, 1, 3), {}), ((2, 3, 3), {}), ((1, 4, 2), {})),
    *_all("sum_squares", ((3, 1), {}), ((2, 3, 2), {})),
    *_all("mean_squares", ((3, 4), {}), ((2, 3, 2), {})),
    *_all("norm", ((3, 4), {}), ((2, 3, 2), {})),
    *_all("squared_error", ((2, 3), (2, 3), {}), ((5,), (5,), {"reduction": "sum"}),
          ((2, 1, 2), (2, 1, 2), {"reduction": "none"})),
    *_all("decode", ((1, 2, 2), (2, 2, 3), (2,), {}), ((2, 2, 2), (2, 1, 4), (2,), {}),
          ((1, 2, 2), (2, 2, 3), (2,), {"chosen": np.array([[[0, 1], [1, 1]]])})),
    *[claim for reading in ("norm", "mean_squares", "sum_squares") for claim in (
        *_all("content_loss", ((1, 2, 2), (1, 2, 2), {"c": number("c"), "reading": reading}),
              ((2, 1, 3), (2, 1, 3), {"c": number("c"), "reading": reading})),
        *_all("style_loss", ((1, 2, 2), (1, 2, 3), {"s": number("s"), "reading": reading}),
              ((2, 2, 2), (2, 2, 1), {"s": number("s"), "reading": reading})))],
    *_all("foot_loss", ((1, 66, 3), CONTACTS, {"target": symbols("v", (1, 4, 3, 2))}),
          ((2, 66, 2), np.ones((2, 4, 2), bool), {"target": number("v")})),
    *_all("bone_loss", ((1, 66, 1), {"lengths": symbols("l", (20,))}),
          ((2, 66, 1), {"lengths": symbols("l", (20,))})),
    *_all("trajectory_loss",
          ((1, 66, 3), {"wanted": symbols("v", (1, 3, 3)), "turn_weight": number("q")}),
          ((2, 66, 1), {"wanted": symbols("v", (2, 3, 1)), "turn_weight": number("q")})),
    *_all("decode_2016", ((1, 2, 2), (3, 2, 3), (3,), {}), ((2, 1, 2), (2, 1, 4), (2,), {})),
    *_all("search_loss_2016",
          ((1, 2, 3), {"content": symbols("C", (1, 2, 3)), "gram": symbols("G", (1, 2, 2)),
                       "amount": Fraction(1, 10)}),
          ((2, 1, 2), {"content": symbols("C", (2, 1, 2)), "gram": symbols("G", (2, 1, 1)),
                       "amount": Fraction(1, 4)})),
]

# Each near some points, where other elements are the largest and other units are at work.
PIECEWISE = [
    *_near((0, 1), "max_pool1d", ((1, 2, 6), 2, {}), ((1, 2, 7), 3, {"stride": 2, "padding": 1}),
           ((1, 1, 7), 2, {"dilation": 3, "stride": 1}), ((1, 1, 7), 2, {"ceil_mode": True})),
    *_near((0,), "relu", ((2, 3), {}), ((1, 2, 4), {})),
    *_near((0,), "l1", ((2, 3), {}), ((5,), {})),
    *_near((0,), "absolute_error", ((2, 3), (2, 3), {}), ((4,), (4,), {"reduction": "sum"}),
           ((2, 2), (2, 2), {"reduction": "none"})),
    *_near((0, 1), "encode", ((1, 2, 4), (2, 2, 3), (2,), {}), ((2, 1, 5), (2, 1, 2), (2,), {})),
    *_near((0,), "encode_2016", ((1, 2, 4), (2, 2, 3), (2,), {}), ((2, 1, 5), (2, 1, 2), (2,), {})),
    *_near((0, 1), "transform", ((1, 2, 3), (2, 2, 2), (2,), (2, 2, 2), (2,), (2, 2, 2), (2,), {}),
           ((2, 1, 2), (3, 1, 1), (3,), (1, 3, 3), (1,), (2, 1, 2), (2,), {})),
    *_near((0, 1), "autoencoder_loss",
           ((1, 1, 4), (2, 1, 2), (2,), {"alpha": Germ(number("alpha"), Fraction(1, 9))}),
           ((1, 2, 2), (2, 2, 2), (2,), {"alpha": Germ(number("alpha"), Fraction(1, 9)),
                                         "mean": False})),
]
CLAIMS = SMOOTH + PIECEWISE
