"""Where real code breaks: samples of equation 10 whose terms all weigh."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..holden2017 import losses, networks, objective
from ..motion.features import (FEATURES, POSITIONS, TRANSLATION, TURN, VELOCITIES,
                               bone_lengths_by_frame)
from ..motion.joints import BONES, JOINTS
from .specification import Sample, called


def totals(rng: np.random.Generator) -> list[Sample]:
    """Samples in which each term of equation 10 weighs: all within a factor of ten, and each in
    turn the heaviest."""
    found = []
    for reading in losses.READINGS:
        for heaviest in ("none", *(term.name for term in objective.EQUATION_10)):
            wished = {term.name: 10.0 if term.name == heaviest else 2.0
                      for term in objective.EQUATION_10}
            found.append(Sample(f"{reading}, heaviest: {heaviest}",
                                *balanced(rng, reading, wished)))
    arrays, constants = balanced(rng, "mean_squares", wished)
    constants["deviation"] = constants["deviation"] * (np.arange(FEATURES) % 7 > 0)
    found.append(called("numbers without deviation", *arrays, **constants))
    more = balanced(rng, "mean_squares", wished, clips=9, frames=17)
    return found + [Sample("nine clips of odd frames", *more)]


def balanced(rng: np.random.Generator, reading: str, wished: dict[str, float], clips: int = 2,
             frames: int = 6, units: int = 5) -> tuple[tuple, dict[str, Any]]:
    """Arrays and constants of a total loss whose terms come to what is wished."""
    n = rng.standard_normal
    w = objective.WEIGHTS[reading]
    W0, b0, I = n((units, FEATURES, 3)) * 0.1, n(units) * 0.1, n((clips, FEATURES, frames))
    arrays = (n((3, FEATURES, 3)) * 0.1, n(3), n((2, 3, 3)), n(2), n((FEATURES, 2, 3)), n(FEATURES))
    mean, deviation = n(FEATURES), rng.uniform(0.5, 3, FEATURES)
    deviation[TURN] *= 0.05
    mean[TURN] *= 0.01
    contacts = rng.random((clips, 4, frames)) < 0.6
    O = networks.transformation(I, dict(zip(networks.T_NAMES, arrays)))
    H = networks.encode(O, {"W0": W0, "b0": b0})
    feet_now = w.foot * float(np.mean(losses.foot_loss(_motion(O, mean, deviation), contacts)))
    size = np.sqrt(wished["foot"] / feet_now)
    for numbers in (mean, deviation):
        numbers[POSITIONS] *= size
        numbers[TRANSLATION] *= size
    motion = _motion(O, mean, deviation)
    steps = {"content": n(H.shape), "style": n((clips, units, units)),
             "bone": rng.uniform(-1, 1, len(BONES)), "trajectory": n((clips, 3, frames))}
    steps["trajectory"][:, 0] *= 0.01
    steps["style"] += steps["style"].swapaxes(1, 2)
    frames_of_all = losses.joint_positions(motion).transpose(0, 3, 1, 2).reshape(-1, JOINTS, 3)
    reached = {"content": H, "style": H @ H.swapaxes(1, 2), "trajectory": motion[:, VELOCITIES],
               "bone": bone_lengths_by_frame(frames_of_all).mean(axis=0)}
    loss_of: dict[str, Callable[[Any], Any]] = {
        "content": lambda target: losses.content_loss(target, H, reading=reading),
        "style": lambda target: losses.style_loss(target, H, s=1.0, reading=reading),
        "bone": lambda target: losses.bone_loss(motion, target),
        "trajectory": lambda target: losses.trajectory_loss(motion, target, turn_weight=w.turn)}
    made = {}
    for name, loss in loss_of.items():
        factor, power = 1.0, 0.5 if reading != "norm" or name in ("bone", "trajectory") else 1.0
        for _ in range(40):                                      # to within a tenth
            made[name] = reached[name] + factor * steps[name]
            found = getattr(w, name) * float(np.mean(loss(made[name])))
            if abs(found / wished[name] - 1) < 0.1:
                break
            factor *= (wished[name] / found) ** power
    return arrays, {"I": I, "W0": W0, "b0": b0, "hidden": made["content"], "gram": made["style"],
                    "bones": made["bone"], "trajectory": made["trajectory"], "contacts": contacts,
                    "mean": mean, "deviation": deviation, "reading": reading}


def _motion(O, mean, deviation):
    return O * deviation[:, None] + mean[:, None]


def shares(sample: Sample) -> dict[str, float]:
    """What each term of a total loss's sample comes to.   ->  {term: mean over the clips}"""
    given = dict(sample.attributes)
    reading = given.pop("reading", "norm")
    loss_network = {name: given.pop(name) for name in ("W0", "b0")}
    mean, deviation = given.pop("mean"), given.pop("deviation")
    return objective.total_loss(dict(zip(networks.T_NAMES, sample.inputs)),
                                objective.Batch(**given),
                                loss_network, mean, deviation, objective.WEIGHTS[reading])[1]
