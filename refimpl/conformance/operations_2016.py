"""The specifications of the 2016 code's network and losses."""

import numpy as np

from ..holden2016 import losses
from ..holden2016.rows import NUMBERS, TURN
from . import definitions_2016 as definitions, functions_2016 as functions, ground_holden as ground
from .specification import Sample, operation, ruled


def _encode_samples(rng):
    n = rng.standard_normal
    return [Sample("plain", (n((2, 4, 8)), n((5, 4, 3)), n(5))),
            Sample("a frame left over", (n((1, 3, 7)), n((4, 3, 5)), n(4))),
            Sample("with dropout", (n((2, 4, 8)), n((5, 4, 3)), n(5)),
                   {"kept": rng.integers(2, size=(2, 4, 8))}),
            Sample("with dropout by numbers", (n((2, 4, 8)), n((5, 4, 3)), n(5)),
                   {"kept": 1.0 * rng.integers(2, size=(2, 4, 8))}),
            ruled("all units at their kink", (np.zeros((1, 3, 4)), n((4, 3, 5)), np.zeros(4)),
                  np.zeros((1, 4, 2)), n((1, 4, 2)), np.zeros((1, 3, 4)), np.zeros((4, 3, 5)),
                  np.zeros(4))]


def _decode_samples(rng):
    n = rng.standard_normal
    arrays = n((2, 5, 4)), n((4, 5, 3))
    return [Sample("plain", (*arrays, n(4))),
            Sample("one hidden frame", (n((1, 4, 1)), n((3, 4, 5)), n(3))),
            Sample("by chance", (*arrays, n(4)), {"chosen": rng.integers(2, size=(2, 5, 4)),
                                                  "kept": rng.integers(2, size=(2, 5, 8))}),
            Sample("with dropout by numbers", (*arrays, n(4)),
                   {"kept": 1.0 * rng.integers(2, size=(2, 5, 8))})]


def _autoencoder_samples(rng):
    n = rng.standard_normal
    arrays = (n((2, 4, 8)), n((5, 4, 3)), n(5), n((4, 5, 3)), n(4))
    return [Sample("plain", arrays),
            Sample("by chance", arrays, {"kept": rng.integers(2, size=(2, 4, 8)),
                                         "chosen": rng.integers(2, size=(2, 5, 4)),
                                         "kept_hidden": rng.integers(2, size=(2, 5, 8))})]


def _motion(rng, frames=4):
    motion = rng.standard_normal((2, NUMBERS, frames)) * 5
    motion[:, TURN] *= 0.1
    return motion


def _foot_samples(rng):
    return [Sample("plain", (_motion(rng), rng.random((2, 4, 4)) < 0.6)),
            Sample("no contact, the floor alone", (_motion(rng), np.zeros((2, 4, 4), bool))),
            Sample("one frame", (_motion(rng, frames=1), np.ones((2, 4, 1), bool)))]


def _bone_samples(rng):
    still = np.zeros((1, NUMBERS, 2))
    return [Sample("plain", (_motion(rng),)),
            ruled("bones of length 0", (still,), [np.mean(losses.LENGTHS ** 2)], [3.0], still)]


def _trajectory_samples(rng):
    return [Sample("plain", (_motion(rng),), {"wanted": rng.standard_normal((2, 3, 4))})]


def _search_samples(rng):
    n = rng.standard_normal
    root = n((2, 3, 6))
    constants = {"content": n((2, 3, 4)), "gram": root @ root.swapaxes(1, 2)}
    return [Sample("as in the code", (n((2, 3, 4)),), constants),
            Sample("more style", (n((2, 3, 4)),), {**constants, "amount": 3.0})]


def _one(f, arguments, samples, part, **rest):
    return operation(f, arguments, definitions, samples, equation=f"the 2016 code, {part}",
                     suffix="_2016", **rest)


OPERATIONS = (
    _one(functions.encode, "X We be", _encode_samples, "encoder", ground=ground.encoders),
    _one(functions.decode, "H Wd bd", _decode_samples, "decoder", ground=ground.decoders_2016),
    _one(functions.autoencoder_loss, "X We be Wd bd", _autoencoder_samples, "training", batched=(),
         ground=ground.autoencoders_2016),
    _one(losses.foot_loss, "motion contacts", _foot_samples, "feet", batched=(0, 1),
         ground=ground.feet_2016),
    _one(losses.bone_loss, "motion", _bone_samples, "bones",
         ground=lambda rng: ground.bones(rng, given=False, numbers=NUMBERS)),
    _one(functions.trajectory_loss, "motion", _trajectory_samples, "path", batched=(),
         ground=lambda rng: ground.paths(rng, form="2016")),
    _one(functions.search_loss, "H", _search_samples, "search", batched=(),
         ground=ground.searches))
