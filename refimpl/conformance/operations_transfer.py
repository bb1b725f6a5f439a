"""The specifications of what is done with trained networks."""

import numpy as np

from ..motion.features import FEATURES, TURN
from ..motion.joints import BONES
from . import definitions_transfer as definitions, functions_transfer as functions
from .operations_holden import _motion
from .specification import Bad, Sample, operation


def _scale(rng):
    deviation = rng.uniform(0.5, 3, FEATURES)
    deviation[TURN] *= 0.05
    return {"mean": rng.standard_normal(FEATURES), "deviation": deviation}


def _loss_network(rng, units=3):
    n = rng.standard_normal
    return {"W0": n((units, FEATURES, 3)) / 8, "b0": n(units) / 8}


def _features(rng, frames):
    return _motion(rng, frames)[0].T.copy()


def _stylised_samples(rng):
    n = rng.standard_normal
    arrays = (n((2, FEATURES, 3)) / 9, n(2), n((2, 2, 3)), n(2), n((FEATURES, 2, 3)), n(FEATURES))
    return [Sample(label, (_features(rng, frames), *arrays),
                   {**_loss_network(rng), **_scale(rng), **how})
            for label, frames, how in (("plain", 6, {}), ("an odd frame", 5, {}),
                                       ("not projected", 4, {"projected": False}))]


def _projected_samples(rng):
    return [Sample(label, (_features(rng, frames), *_loss_network(rng).values()), _scale(rng))
            for label, frames in (("plain", 6), ("an odd frame", 5), ("one frame", 1))]


def _weight_samples(rng):
    legs = np.array([80, 0.9, 35.4])
    return [Sample(f"{reading}, {hidden} units", (legs,), {"reading": reading, "hidden": hidden})
            for reading, hidden in (("norm", 256), ("norm", 8), ("mean_squares", 256),
                                    ("mean_squares", 60), ("sum_squares", 8))]


def _decode_samples(rng):
    n = rng.standard_normal
    return [Sample("plain", (n((2, 5, 4)), n((5, 4, 3)), n(4))),
            Sample("filters of even width", (n((1, 4, 3)), n((4, 3, 4)), n(3))),
            Sample("depooling by chance", (n((2, 5, 4)), n((5, 4, 3)), n(4)),
                   {"chosen": rng.integers(2, size=(2, 5, 4))})]


def _hidden_samples(rng):
    n = rng.standard_normal
    constants = {"content": n((2, 3, 4)), "gram": n((2, 3, 3))}
    return [Sample(f"a share of {style:g}", (n((2, 3, 4)),), {**constants, "style": style})
            for style in (0.25, 0.0, 1.0)]


def _decoded_samples(rng):
    n = rng.standard_normal
    return [Sample("plain", (n((2, 3, 2)),), {
        "contacts": rng.random((2, 4, 4)) < 0.6, "bones": rng.uniform(1, 9, len(BONES)),
        "trajectory": n((2, 3, 4)), **_loss_network(rng), **_scale(rng)})]


def _search_samples(rng):
    def _sample(label, frames, of_exemplar, large=False, still=False, **how):
        features = _features(rng, frames)
        if still:
            features[:, TURN + 1:] = 0.0
        return Sample(label, (features, rng.integers(2, size=(frames, 4)),
                              _features(rng, of_exemplar)), {
            **_loss_network(rng), **_scale(rng), "bones": rng.uniform(1, 9, len(BONES)),
            "leg": 40.0, "iterations": 4, "constraint_iterations": 3, **how}, large=large)
    return [_sample("plain", 6, 4), _sample("odd frames, one of the style", 5, 1, form="2016"),
            _sample("a share of its own, two odd lengths", 7, 5, style=0.4, rate=0.02),
            _sample("standing", 4, 3, still=True),
            _sample("many steps", 4, 4, True, iterations=60, constraint_iterations=30)]


def _bad_searches():
    good, *_ = _search_samples(np.random.default_rng(0))
    return [Bad(label, good.inputs, argument, {**good.attributes, argument: value})
            for label, argument, value in (
                ("a share above 1", "style", 1.5), ("a negative share", "style", -0.1),
                ("half a step", "iterations", 2.5), ("steps below none", "iterations", -1),
                ("steps below none, second", "constraint_iterations", -1),
                ("no rate", "rate", 0.0), ("an infinite rate", "constraint_rate", np.inf))]


def _one(f, arguments, samples, equation, bad=list, **rest):
    return operation(f, arguments, definitions, samples, bad, equation, **{"batched": (), **rest})


ALONE = {"precisions": ("float64",)}
OPERATIONS = (
    _one(functions.stylised_numbers, f"features {functions.T_NAMES}", _stylised_samples,
         "2017, section 6", **ALONE),
    _one(functions.projected_numbers, "features W0 b0", _projected_samples, "2017, section 6",
         **ALONE),
    _one(functions.fitted_weights, "leg", _weight_samples, "equation 10", **ALONE),
    _one(functions.decode_untied, "H V0 c0", _decode_samples, "equation 2", batched=(0,)),
    _one(functions.hidden_loss, "H", _hidden_samples, "2016, on the network of 2017"),
    _one(functions.decoded_loss, "H", _decoded_samples, "2016, on the network of 2017"),
    _one(functions.style_search_on_2017, "features contacts exemplar", _search_samples,
         "2016, on the network of 2017", _bad_searches, grows=True, **ALONE))
