"""What is done with trained networks a second time, out of the definitions of single operations."""

import numpy as np

from . import definitions_holden as paper, definitions_nn as plain, definitions_whole as whole
from .specification import Array


def _normalised(features, mean, deviation):
    return np.array([[(x - m) / d for x, m, d in zip(row, mean, deviation)] for row in features]
                    ).T[None]


def _units(X, mean, deviation):
    return np.array([[x * d + m for x, m, d in zip(column, mean, deviation)] for column in X[0].T])


def stylised_numbers(features: Array, *arrays: Array, W0: Array, b0: Array,
                     mean: Array, deviation: Array, projected: bool = True) -> Array:
    """One network after the other."""
    O = paper.transform(_normalised(features, mean, deviation), *arrays)
    return _units(whole.project(O, W0, b0) if projected else O, mean, deviation)


def projected_numbers(features: Array, W0: Array, b0: Array, *, mean: Array,
                      deviation: Array) -> Array:
    """The motion, and the motion a frame later."""
    once, again = (_units(whole.project(_normalised(x, mean, deviation), W0, b0), mean, deviation)
                   for x in (features, [features[0], *features]))
    return (once + again[1:]) / 2


def fitted_weights(leg: Array, *, hidden: int = 256, reading: str = "norm") -> Array:
    """One weight at a time."""
    content, style, *constraints = {
        "norm": (1, 0.06, 0.01, 0.001, 0.5), "mean_squares": (1, 0.01, 2e-4, 2e-5, 0.01),
        "sum_squares": (1, 0.01, 6, 0.6, 300)}[reading]
    units = 256 / hidden if reading == "mean_squares" else 1
    return np.array([[content, style, *(w * units * (80 / x) ** 2 for w in constraints),
                      1e4 * x * x / 80 ** 2] for x in leg])


def decode_untied(H: Array, V0: Array, c0: Array, *, chosen: Array | None = None) -> Array:
    """Depooling, filters, bias."""
    D = plain.avg_depool1d(H) if chosen is None else plain.random_depool1d(H, chosen)
    return plain.conv_transpose1d(D, V0) + c0[:, None]
