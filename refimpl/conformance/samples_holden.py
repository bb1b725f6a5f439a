"""Inputs for the losses and networks of Holden et al. 2017."""

import numpy as np

from ..motion.features import FEATURES, TURN
from ..motion.joints import BONES
from . import definitions_nn as plain
from .operations_nn import distinct
from .specification import Sample


def network_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    return [Sample("plain", (n((2, 4, 8)), n((5, 4, 3)), n(5))),
            Sample("a frame left over", (n((1, 3, 7)), n((4, 3, 5)), n(4))),
            Sample("one clip two frames", (n((1, 3, 2)), n((4, 3, 5)), n(4)))]


def decode_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    return [Sample("plain", (n((2, 5, 4)), n((5, 4, 3)), n(5))),
            Sample("one hidden frame", (n((1, 4, 1)), n((4, 3, 5)), n(4))),
            Sample("depooling by chance", (n((2, 5, 4)), n((5, 4, 3)), n(5)),
                   {"chosen": rng.integers(2, size=(2, 5, 4))})]


def autoencoder_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    arrays = (n((2, 4, 8)), distinct(rng, 5, 4, 3) / 60, distinct(rng, 5) / 5)
    return [Sample("means", arrays), Sample("as printed", arrays, {"mean": False, "alpha": 0.3}),
            Sample("depooling by chance", arrays, {"chosen": rng.integers(2, size=(2, 5, 4))})]


def transform_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    return [Sample("plain", (n((2, 4, 7)), n((3, 4, 3)), n(3), n((5, 3, 3)), n(5), n((4, 5, 3)),
                             n(4)))]


def pair_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    A = n((2, 3, 4))
    zero = {"outputs": (np.zeros(2),), "upstream": np.array([1.0, 2]),
            "gradients": (np.zeros_like(A), np.zeros_like(A))}
    return [Sample("as printed", (A, n((2, 3, 4))), {"c": 1.7}),
            Sample("means of squares", (A, n((2, 3, 4))), {"reading": "mean_squares"}),
            Sample("sums of squares", (A, n((2, 3, 4))), {"reading": "sum_squares"}),
            Sample("equal", (A, A.copy()), smooth=False, known=zero)]


def style_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    return [Sample("as printed", (n((2, 3, 3)), n((2, 3, 4))), {"s": 0.3}),
            Sample("means of squares", (n((2, 3, 3)), n((2, 3, 4))), {"reading": "mean_squares"}),
            Sample("sums of squares", (n((2, 3, 3)), n((2, 3, 4))), {"reading": "sum_squares"})]


def some_motion(rng: np.random.Generator, clips: int = 2, frames: int = 4) -> np.ndarray:
    motion = rng.standard_normal((clips, FEATURES, frames)) * 5
    motion[:, TURN] *= 0.1
    return motion


def foot_samples(rng: np.random.Generator) -> list[Sample]:
    contacts = rng.random((2, 4, 4)) < 0.6
    return [Sample("plain", (some_motion(rng), contacts)),
            Sample("no contact", (some_motion(rng), np.zeros((2, 4, 4), bool))),
            Sample("one frame", (some_motion(rng, frames=1), np.ones((2, 4, 1), bool))),
            Sample("with a target", (some_motion(rng), contacts),
                   {"target": rng.standard_normal((2, 4, 3, 3))})]


def bone_samples(rng: np.random.Generator) -> list[Sample]:
    lengths = rng.uniform(1, 9, len(BONES))
    still = np.zeros((1, FEATURES, 2))
    zero = {"outputs": (np.array([2 * np.sum(lengths ** 2)]),), "upstream": np.array([3.0]),
            "gradients": (still,)}
    return [Sample("plain", (some_motion(rng),), {"lengths": lengths}),
            Sample("bones of length 0", (still,), {"lengths": lengths}, smooth=False, known=zero)]


def trajectory_samples(rng: np.random.Generator) -> list[Sample]:
    return [Sample("plain", (some_motion(rng),), {"wanted": rng.standard_normal((2, 3, 4))}),
            Sample("turn weight", (some_motion(rng),),
                   {"wanted": rng.standard_normal((2, 3, 4)), "turn_weight": 100.0})]


def total_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    W0, b0, I = n((6, FEATURES, 3)) * 0.1, n(6) * 0.1, n((2, FEATURES, 6))
    root = n((2, 6, 6))
    constants = {
        "I": I, "W0": W0, "b0": b0, "hidden": plain.relu(plain.max_pool1d(plain.conv1d(I, W0, b0))),
        "gram": root @ root.swapaxes(1, 2), "contacts": rng.random(
            (2, 4, 6)) < 0.6, "bones": rng.uniform(1, 4, len(BONES)), "trajectory": n(
                (2, 3, 6)), "mean": n(FEATURES), "deviation": rng.uniform(0.5, 3, FEATURES)}
    arrays = (n((3, FEATURES, 3)) * 0.1, n(3), n((2, 3, 3)), n(2), n((FEATURES, 2, 3)),
              n(FEATURES))
    return [Sample("plain", arrays, constants),
            Sample("means of squares", arrays, {**constants, "reading": "mean_squares"})]
