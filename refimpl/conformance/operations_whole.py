"""The specifications of the ways from one end to the other: motion to numbers and back, training,
the search of 2016, and equation 12 over all pairs.
"""

from typing import Any

import numpy as np

from ..holden2016.rows import CONTACTS, NUMBERS
from ..motion.features import FEATURES, TURN
from ..motion.joints import FEET, JOINTS, SLOT
from ..motion.rotation import yaw_rotation
from . import (definitions_ends, definitions_phrases, definitions_whole as definitions,
               functions_transfer, functions_whole as functions, ground_total)
from .specification import Bad, called, operation, refused

HEIGHTS = {"Hips": 0.95, "UpLeg": 0.9, "Leg": 0.5, "Foot": 0.1, "Toe": 0.03, "Spine": 1.1,
           "Chest": 1.25, "Neck": 1.4, "Head": 1.6, "Arm": 1.35, "ForeArm": 1.1, "Hand": 0.85,
           "Finger": 0.75}


def walker(rng: np.random.Generator, frames: int, unit: float = 1.0, turns: float = 1.0,
           ) -> np.ndarray:
    """Positions (T, 21, 3) of a body that goes about, stands and sways; not a way to walk, but one
    in which feet are planted at times.   turns : how far it turns, in radians"""
    place = np.zeros((JOINTS, 3))
    for name, slot in SLOT.items():
        side = 1.0 if name.startswith("Left") else -1.0 if name.startswith("Right") else 0.0
        part = name.removeprefix("Left").removeprefix("Right")
        place[slot] = side * (0.2 if "Arm" in part or part in ("Hand", "Finger") else 0.1), (
            HEIGHTS[part]), 0.12 * (part == "Toe")
    going = np.clip(np.sin(np.linspace(0, 7, frames)), 0, None)
    sway = rng.standard_normal((4, JOINTS, 3)) * 0.02
    wave = np.sin(np.outer(going.cumsum() / 5, [1.0, 2, 3, 4]) + rng.uniform(0, 6, 4))
    body = place + np.einsum("tk,kjc->tjc", wave, sway)
    yaw = turns * going.cumsum() / max(going.sum(), 1e-9)
    c, s = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
    x, y, z = np.moveaxis(body, -1, 0)
    path = 0.02 * np.cumsum(going[:, None] * np.stack([np.sin(yaw), 0 * yaw, np.cos(yaw)], 1), 0)
    return unit * (np.stack([c * x + s * z, y, c * z - s * x], axis=-1) + path[:, None])


def _positions(rng, **floor):
    heels = walker(rng, 30)
    heels[:, FEET[1::2], 1] += 0.1
    return [called("plain", walker(rng, 40), **floor),
            called("centimetres, turning on and on", walker(rng, 300, 100.0, 9.0),
                   **{name: 100 * value for name, value in floor.items()}, large=True),
            called("on its heels", heels, **floor), called("two frames", walker(rng, 2), **floor),
            called("one frame", walker(rng, 1), **floor)]


def _ground_samples(rng):
    bad, held, noisy = (walker(rng, 80) for _ in range(3))
    bad[[10, 40]] -= [0.0, 0.3, 0.0]
    held[:, FEET[2:], 1] += 0.4
    noisy += rng.standard_normal(noisy.shape) * 0.002
    return [*_positions(rng), called("two bad rows", bad), called("a foot held up", held),
            called("noise", noisy), called("long", walker(rng, 200))]


def _extension_samples(rng):
    def _noisy(points):
        return points + rng.standard_normal(points.shape) * 0.002
    t = np.arange(90)
    swinging = walker(rng, 1)[0] + 0.04 * np.sin(t[:, None, None] / 4 + rng.uniform(0, 6, (21, 3)))
    swinging = (swinging + np.outer(t, [0, 0, 0.02])[:, None]) @ yaw_rotation(0.01 * t).swapaxes(
        1, 2)
    rising = walker(rng, 40)
    rising[:, SLOT["LeftArm"]:, 1] += 0.05 * t[:40, None]
    return [called("goes on", swinging, frames=25),
            called("goes on in centimetres", 100 * _noisy(swinging), frames=30, large=True),
            called("stands at times", _noisy(walker(rng, 40, turns=6.0)), frames=10),
            called("comes to rest", rising, frames=10),
            called("one frame to go on from", swinging[:28], frames=25),
            called("as long as the clip", swinging[:25], frames=25),
            called("three frames", walker(rng, 3), frames=16),
            called("one frame", walker(rng, 1), frames=3)]


def bad_positions(*, fewest: int = 1, **floor: float) -> list[Bad]:
    """What is no motion of 21 joints.   fewest : frames that there have to be"""
    good = walker(np.random.default_rng(0), 5)
    hole = good.copy()
    hole[2, 3, 1] = np.nan
    return [refused("another count of joints", "positions", good[:, :20], **floor),
            refused("a hole", "positions", hole, **floor),
            refused("two axes", "positions", good[0], **floor),
            refused("too few frames", "positions", good[:fewest - 1], **floor)]


def _number_samples(rng):
    sizes = {"plain": (20, 1.0), "turning on and on": (60, -12.0), "one frame": (1, 0.0)}
    return [called(label, definitions.motion_to_numbers(walker(rng, frames, 1.0, turns),
                                                        floor=0.02)[0], rng.standard_normal(4))
            for label, (frames, turns) in sizes.items()]


def _window_samples(rng):
    def _clip(frames):
        return rng.standard_normal((frames, FEATURES)), (rng.random((frames, 4)) < 0.5).astype(int)
    sizes = {"one left over": (11, 4, 3), "as it fits": (10, 4, 3), "one window": (6, 6, 2),
             "shorter": (5, 9, 4), "shorter by an odd number": (5, 8, 4), "one frame": (1, 4, 2)}
    return [*(called(label, *_clip(frames), length=length, step=step)
              for label, (frames, length, step) in sizes.items()),
            called("the papers'", *_clip(500))]


def _normaliser_samples(rng):
    features = rng.standard_normal((30, FEATURES)) * rng.uniform(0.1, 9, FEATURES) + (
        rng.standard_normal(FEATURES) * 5)
    contacts, still = (rng.random((30, 4)) < 0.5).astype(float), features.copy()
    still[:, TURN] = 0.1
    return [called(f"{label}, {form}", array, contacts[:len(array)], form=form)
            for label, array in (("plain", features), ("never turning", still),
                                 ("two frames", features[:2])) for form in ("groups", "2016")]


def _project_samples(rng):
    n = rng.standard_normal
    return [called(f"{frames} frames", n((2, 4, frames)), n((5, 4, 3)), n(5))
            for frames in (8, 9, 1)]


def _target_samples(rng):
    n = rng.standard_normal
    return [called("plain", n((3, 12)), lengths=(5, 3, 4), frames=7),
            called("one exemplar", n((4, 6)), lengths=(6,), frames=120)]


def _filter_samples(rng):
    return [called("plain", rng.random((5, 4, 3))), called("one", rng.random((1, 1, 1)))]


def _network_samples(rng):
    return [called("plain", rng.random(600), hidden=4, channels=2, features=5, width=3)]


def _noise_samples(rng):
    return [called("plain", rng.random((5, 8))), called("the code's", rng.random((73, 240)))]


def _rate_samples(rng):
    return [called(f"{epochs} epochs", np.arange(1, epochs + 1), rate=1e-3, epochs=epochs)
            for epochs in (1, 2, 7, 100)]


def _orders(rng, epochs, count):
    return np.array([rng.permutation(count) for _ in range(epochs)])


def _loss_network_samples(rng):
    n = rng.standard_normal
    W0, b0, X = n((3, 4, 3)) / 3, n(3) / 3, n((5, 4, 6))

    def _chances(epochs):
        return {"kept": (rng.random((epochs, *X.shape)) < 0.8).astype(int),
                "dropout": 0.2, "chosen": rng.integers(2, size=(epochs, 5, 3, 3))}
    return [called("one step", W0, b0, X=X[:2], order=_orders(rng, 1, 2), batch=2, rate=0.01),
            called("an epoch, its last batch small",
                   W0, b0, X=X, order=_orders(rng, 1, 5), batch=2, rate=0.01, **_chances(1)),
            called("ten steps in five epochs",
                   W0, b0, X=X, order=_orders(rng, 5, 5), batch=3, rate=0.01, alpha=0.2),
            called("a hundred steps", W0, b0,
                   X=X, order=_orders(rng, 20, 5), batch=1, rate=3e-3, **_chances(20), large=True),
            called("two steps in one order",
                   W0, b0, X=X[:3], order=np.array([[2, 0, 1]]), batch=2, rate=0.01)]


def _transformation_samples(rng):
    def _problem(clips, reading="mean_squares", frames=4):
        alike = dict.fromkeys(("content", "style", "foot", "bone", "trajectory"), 2.0)
        arrays, made = ground_total.balanced(rng, reading, alike, clips, frames, units=3)
        del made["hidden"]
        return arrays, made

    def _sample(label, clips, epochs, batch, reading="mean_squares", large=False, moving=False):
        arrays, made = _problem(clips, reading)
        if moving:
            made["foot_velocity"] = rng.standard_normal((clips, 4, 3, 3))
        return called(label, *arrays, **made | {"order": _orders(rng, epochs, clips),
                                                "batch": batch, "rate": 0.003}, large=large)
    return [_sample("one step", 2, 1, 2), _sample("one step of norms", 2, 1, 2, "norm", True),
            _sample("an epoch, its last batch small", 3, 1, 2, large=True),
            _sample("ten steps in five epochs", 4, 5, 2, large=True),
            _sample("feet that have to move", 3, 1, 2, moving=True),
            _sample("one window, one step", 1, 1, 1)]


def _search_samples(rng):
    n = rng.standard_normal

    def _rows(frames):
        rows = n((frames, NUMBERS)).cumsum(axis=0)
        rows[:, CONTACTS] = rng.integers(2, size=(frames, 4))
        rows[:, [3 + 3 * foot + 1 for foot in FEET]] -= 1.0     # some below the floor
        return rows
    params = n((3, NUMBERS, 3)) * 0.1, n(3) * 0.1, n((NUMBERS, 3, 3)) * 0.1, n(NUMBERS)
    scale: dict[str, Any] = {"mean": n(NUMBERS), "deviation": rng.uniform(0.5, 2, NUMBERS)}
    steps = {"one step of each": (1, 1), "as many as the code's": (), "some steps": (6, 4),
             "the style alone": (2, 0)}
    return [called(label, _rows(8), _rows(6), 0.3 * n((1, NUMBERS, 8)), *params, **scale,
                   **dict(zip(("iterations", "constraint_iterations"), counts)), large=not counts)
            for label, counts in steps.items()]


def _bad_searches():
    good, *_ = _search_samples(np.random.default_rng(0))
    content, style, start, *params = good.inputs
    return [refused("an odd number of rows",
                    "content", content[1:], style, start[:, :, 1:], *params, **good.attributes),
            refused("an odd number of rows of the style",
                    "style", content, style[1:], start, *params, **good.attributes),
            refused("a start of other frames",
                    "start", content, style, start[:, :, 2:], *params, **good.attributes)]


def _bad_trainings():
    good, *_ = _loss_network_samples(np.random.default_rng(0))
    nowhere = np.full_like(good.attributes["X"], np.nan)
    return [refused("not a number",
                    "epoch 1, batch 1 of 1", *good.inputs, **good.attributes | {"X": nowhere})]


def _threshold_samples(rng):
    points = rng.standard_normal((9, 2)) * 3
    ssd = ((points[:, None] - points) ** 2).sum(axis=2)
    return [called(f"{count} contents", ssd, count=count) for count in (1, 2, 4, 8, 9)]


def _pair_samples(rng):
    n = rng.standard_normal
    c, e = n((4, 2)), rng.uniform(-2, 2, (4, 3))
    found = []
    for label, given in (("kernel ridge", {"kind": "kernel ridge", "ridge": 0.2, "gamma": 0.05}),
                         ("linear ridge", {"kind": "linear ridge", "ridge": 0.4})):
        for target in (np.array([1.0, -0.5, 0.3]), np.array([-2.5, 2.0, 2.9])):
            found.append(called(f"{label}, {target[0]:g}",
                                c, e, n((12, 11)), n((12, 3)), **given | {"target": target}))
    return found


def _one(f, arguments, samples, equation, bad=list, **rest):
    return operation(f, arguments,
                     definitions if hasattr(definitions, f.__name__) else definitions_phrases,
                     samples, bad, equation, **{"batched": (), "precisions": ("float64",), **rest})


TRAINED = {"grows": True, "precisions": ("float64", "float32")}
OPERATIONS = (
    _one(functions.facing_direction, "positions", _positions, "2017, section 3.1"),
    _one(functions.floor_height, "positions", _positions, "2017, section 3.1"),
    _one(functions.foot_contacts, "positions", lambda rng: _positions(rng, floor=0.02),
         "2017, section 3.1"),
    _one(functions.planted_feet, "positions", _ground_samples, "2017, section 3.1"),
    operation(functions_transfer.extended, "positions", definitions_ends, _extension_samples, list,
              "2017, section 3.1", batched=(), precisions=("float64",)),
    _one(functions.ground_height, "positions", _ground_samples, "2017, section 3.1"),
    _one(functions.motion_to_numbers, "positions", lambda rng: _positions(rng, floor=0.02),
         "2017, section 3.1", lambda: bad_positions(floor=0.0)),
    _one(functions.numbers_to_motion, "features start", _number_samples, "2017, section 3.1",
         lambda: [refused("another count of numbers", "features", np.zeros((3, 65)), np.zeros(4))]),
    _one(functions.motion_windows, "features contacts", _window_samples, "2017, section 3.1"),
    _one(functions.normaliser, "features contacts", _normaliser_samples, "2017, section 3.1",
         lambda: [refused("another form", "form", np.ones((3, 66)), np.ones((3, 4)), form="2017"),
                  refused("one frame", "features", np.ones((1, 66)), np.ones((1, 4)))]),
    _one(functions.project, "X W0 b0", _project_samples, "equations 1 and 2", batched=(0,),
         precisions=("float64", "float32")),
    _one(functions.style_target, "hidden", _target_samples, "equation 6",
         lambda: [refused("no frames", "frames", np.ones((2, 3)), lengths=(3,), frames=0),
                  refused("frames left over", "lengths", np.ones((2, 3)), lengths=(2,), frames=4)]),
    _one(functions.initial_filters, "uniform", _filter_samples, "2017, section 4",
         precisions=("float64", "float32")),
    _one(functions.initial_networks, "uniform", _network_samples, "2017, section 4",
         precisions=("float64", "float32")),
    _one(functions.initial_noise, "uniform", _noise_samples, "the 2016 code, search"),
    _one(functions.learning_rate, "epoch", _rate_samples, "2017, section 4"),
    _one(functions.train_loss_network, "W0 b0", _loss_network_samples, "equation 3", _bad_trainings,
         **TRAINED),
    _one(functions.train_transformation_network, functions.T_NAMES, _transformation_samples,
         "equation 10", **TRAINED),
    _one(functions.style_search, "content style start We be Wd bd", _search_samples,
         "the 2016 code", _bad_searches, suffix="_2016", **TRAINED),
    _one(functions.cluster_threshold, "ssd", _threshold_samples, "2006, section 4",
         lambda: [refused("more contents than fragments", "count", np.zeros((3, 3)), count=4),
                  refused("complex numbers", "ssd", np.zeros((3, 3)) + 0j, count=2)]),
    _one(functions.best_pair, "coefficients styles Z Y", _pair_samples, "2006, equation 12",
         tolerance=1e7))
