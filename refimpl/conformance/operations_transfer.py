"""The specifications of what is done with trained networks."""

import numpy as np

from ..motion.features import FEATURES, TURN
from . import definitions_transfer as definitions, functions_transfer as functions
from .ground_holden import moving
from .specification import called, operation


def _scale(rng):
    deviation = rng.uniform(0.5, 3, FEATURES)
    deviation[TURN] *= 0.05
    return {"mean": rng.standard_normal(FEATURES), "deviation": deviation}


def _loss_network(rng, units=3):
    n = rng.standard_normal
    return {"W0": n((units, FEATURES, 3)) / 8, "b0": n(units) / 8}


def _features(rng, frames):
    return moving(rng, frames=frames)[0].T.copy()


def _stylised_samples(rng):
    n = rng.standard_normal
    arrays = (n((2, FEATURES, 3)) / 9, n(2), n((2, 2, 3)), n(2), n((FEATURES, 2, 3)), n(FEATURES))
    return [called(label, _features(rng, frames), *arrays, **_loss_network(rng), **_scale(rng),
                   **how) for label, frames, how in (("plain", 6, {}), ("an odd frame", 5, {}),
                                                     ("not projected", 4, {"projected": False}))]


def _projected_samples(rng):
    return [called(label, _features(rng, frames), *_loss_network(rng).values(), **_scale(rng))
            for label, frames in (("plain", 6), ("an odd frame", 5), ("one frame", 1))]


def _weight_samples(rng):
    legs = np.array([80, 0.9, 35.4])
    return [called(f"{reading}, {hidden} units", legs, reading=reading, hidden=hidden)
            for reading, hidden in (("norm", 256), ("norm", 8), ("mean_squares", 256),
                                    ("mean_squares", 60), ("sum_squares", 8))]


def _decode_samples(rng):
    n = rng.standard_normal
    return [called("plain", n((2, 5, 4)), n((5, 4, 3)), n(4)),
            called("filters of even width", n((1, 4, 3)), n((4, 3, 4)), n(3)),
            called("depooling by chance",
                   n((2, 5, 4)), n((5, 4, 3)), n(4), chosen=rng.integers(2, size=(2, 5, 4)))]


def _one(f, arguments, samples, equation, **rest):
    return operation(f,
                     arguments, definitions, samples, equation=equation, **{"batched": (), **rest})


ALONE = {"precisions": ("float64",)}
OPERATIONS = (_one(functions.stylised_numbers,
                   f"features {functions.T_NAMES}", _stylised_samples, "2017, section 6", **ALONE),
              _one(functions.projected_numbers,
                   "features W0 b0", _projected_samples, "2017, section 6", **ALONE),
              _one(functions.fitted_weights, "leg", _weight_samples, "equation 10", **ALONE),
              _one(functions.decode_untied, "H V0 c0", _decode_samples, "equation 2", batched=(0,)))
