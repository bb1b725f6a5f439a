"""The specifications of the networks and losses of Holden et al. 2017."""

import numpy as np

from ..holden2017 import losses, objective
from ..motion.features import FEATURES
from ..motion.joints import BONES
from . import (definitions_holden as definitions, functions_holden as functions,
               ground_holden as ground, ground_total)
from .operations_nn import distinct
from .specification import Sample, called, operation, refused, ruled


def _network_samples(rng):
    n = rng.standard_normal
    return [called("plain", n((2, 4, 8)), n((5, 4, 3)), n(5)),
            called("a frame left over", n((1, 3, 7)), n((4, 3, 5)), n(4)),
            called("one clip two frames", n((1, 3, 2)), n((4, 3, 5)), n(4)),
            called("filters of even width", n((2, 3, 6)), n((4, 3, 4)), n(4))]


def _decode_samples(rng):
    n = rng.standard_normal
    return [called("plain", n((2, 5, 4)), n((5, 4, 3)), n(5)),
            called("one hidden frame", n((1, 4, 1)), n((4, 3, 5)), n(4)),
            called("filters of even width", n((1, 4, 3)), n((4, 3, 4)), n(4)),
            called("depooling by chance",
                   n((2, 5, 4)), n((5, 4, 3)), n(5), chosen=rng.integers(2, size=(2, 5, 4)))]


def _autoencoder_samples(rng):
    n = rng.standard_normal
    arrays = (n((2, 4, 8)), distinct(rng, 5, 4, 3) / 60, distinct(rng, 5) / 5)
    return [called("means", *arrays), called("as printed", *arrays, mean=False, alpha=0.3),
            called("depooling by chance", *arrays, chosen=rng.integers(2, size=(2, 5, 4))),
            called("filters of even width", n((1, 3, 6)), distinct(rng, 4, 3, 4) / 48,
                   distinct(rng, 4) / 4),
            # One filter reads one of two rows, where both frames are 1:   Z = 3 + 1 twice, a tie.
            # H = 4,  D = H / 2 - 1 = 1,  errors 3 - 1 twice, -1 and -5,  dH = dZ = 3 for frame 0.
            ruled("a tie between frames", (np.array([[[1.0, 1], [1, 5]]]),
                                           np.array([[[3.0], [0]]]), np.ones(1)), 8.9, 1.0,
                  [[[8.0, -1], [0.5, 2.5]]], [[[5.1], [0.0]]], [-2.9], attributes={"alpha": 0.3})]


def _transform_samples(rng):
    shapes = ((2, 4, 7), (3, 4, 3), (3,), (5, 3, 3), (5,), (4, 5, 3), (4,))
    widths = ((2, 3, 9), (4, 3, 5), (4,), (2, 4, 3), (2,), (3, 2, 4), (3,))
    return [called("plain", *tuple(map(rng.standard_normal, shapes))),
            called("three widths", *tuple(map(rng.standard_normal, widths)))]


def _content_samples(rng):
    n = rng.standard_normal
    A = n((2, 3, 4))
    return [called("as printed", A, n((2, 3, 4)), c=1.7),
            called("means of squares", A, n((2, 3, 4)), reading="mean_squares"),
            called("sums of squares", A, n((2, 3, 4)), reading="sum_squares"),
            ruled("equal",
                  (A, A.copy()), np.zeros(2), [1.0, 2], np.zeros_like(A), np.zeros_like(A))]


def _style_samples(rng):
    n = rng.standard_normal
    return [called("as printed", n((2, 3, 3)), n((2, 3, 4)), s=0.3),
            called("means of squares", n((2, 3, 3)), n((2, 3, 4)), reading="mean_squares"),
            called("sums of squares", n((2, 3, 3)), n((2, 3, 4)), reading="sum_squares")]


def _foot_samples(rng):
    contacts = rng.random((2, 4, 4)) < 0.6
    return [called("plain", ground.moving(rng), contacts),
            called("no contact", ground.moving(rng), np.zeros((2, 4, 4), bool)),
            called("one frame", ground.moving(rng, frames=1), np.ones((2, 4, 1), bool)),
            called("with a target",
                   ground.moving(rng), contacts, target=rng.standard_normal((2, 4, 3, 3)))]


def _bone_samples(rng):
    lengths, still = rng.uniform(1, 9, len(BONES)), np.zeros((1, FEATURES, 2))
    return [called("plain", ground.moving(rng), lengths=lengths),
            ruled("bones of length 0", (still,),
                  [2 * np.sum(lengths ** 2)], [3.0], still, attributes={"lengths": lengths})]


def _trajectory_samples(rng):
    return [called("plain", ground.moving(rng), wanted=rng.standard_normal((2, 3, 4))),
            called("turn weight",
                   ground.moving(rng), wanted=rng.standard_normal((2, 3, 4)), turn_weight=100.0)]


def _total_samples(rng):
    alike = {term.name: 2.0 for term in objective.EQUATION_10}
    found = [Sample(label, *ground_total.balanced(rng, reading, alike, frames=4)) for label,
             reading in (("plain", "norm"), ("means of squares", "mean_squares"))]
    arrays, constants = found[0].inputs, dict(found[0].attributes)
    constants["foot_velocity"] = 0.3 * rng.standard_normal((2, 4, 3, 3))
    return [*found, called("feet that have to move", *arrays, **constants)]


def _bad_readings(shape):
    return [refused("a reading that is none",
                    "reading", np.ones((1, *shape)), np.ones((1, 3, 4)), reading="squares")]


def _one(f, arguments, samples, equation, bad=list, **rest):
    return operation(f, arguments, definitions, samples, bad, equation, **rest)


OPERATIONS = (
    _one(functions.encode, "X W0 b0", _network_samples, "equation 1",
         ground=ground.encoders),
    _one(functions.decode, "H W0 b0", _decode_samples, "equation 2",
         ground=ground.decoders),
    _one(functions.autoencoder_loss, "X W0 b0", _autoencoder_samples, "equation 3", batched=(),
         ground=ground.autoencoders),
    _one(functions.transform, f"X {functions.T_NAMES}", _transform_samples, "the network T",
         ground=ground.transformers),
    _one(losses.content_loss, "H_input H_output", _content_samples, "equation 4",
         lambda: _bad_readings((3, 4)), batched=(0, 1),
         ground=ground.contents),
    _one(losses.style_loss, "G_style H_output", _style_samples, "equation 5",
         lambda: _bad_readings((3, 3)), batched=(0, 1),
         ground=ground.styles),
    _one(losses.foot_loss, "motion contacts", _foot_samples, "equation 7", batched=(0, 1),
         ground=lambda rng: ground.feet(rng) + ground.feet_with_targets(rng)),
    _one(losses.bone_loss, "motion", _bone_samples, "equation 8",
         lambda: [refused("a length too few", "lengths", np.ones((1, FEATURES, 2)),
                          lengths=np.ones(len(BONES) - 1))], ground=ground.bones),
    _one(losses.trajectory_loss, "motion", _trajectory_samples, "equation 9", batched=(),
         ground=ground.paths),
    _one(functions.total_loss, functions.T_NAMES, _total_samples, "equation 10", batched=(),
         ground=ground_total.totals, terms=ground_total.shares))
