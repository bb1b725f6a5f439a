"""What is done with trained networks a second time, out of the definitions of single operations."""

import math
from typing import Any

import numpy as np

from ..holden2017 import losses
from . import (definitions_holden as paper, definitions_nn as plain, definitions_whole as whole,
               functions_holden)


def _normalised(features, mean, deviation):
    return np.array([[(x - m) / d for x, m, d in zip(row, mean, deviation)] for row in features]
                    ).T[None]


def _units(X, mean, deviation):
    return np.array([[x * d + m for x, m, d in zip(column, mean, deviation)] for column in X[0].T])


def stylised_numbers(features: np.ndarray, *arrays: np.ndarray, W0: np.ndarray, b0: np.ndarray,
                     mean: np.ndarray, deviation: np.ndarray, projected: bool = True) -> np.ndarray:
    """One network after the other."""
    O = paper.transform(_normalised(features, mean, deviation), *arrays)
    return _units(whole.project(O, W0, b0) if projected else O, mean, deviation)


def projected_numbers(features: np.ndarray, W0: np.ndarray, b0: np.ndarray, *, mean: np.ndarray,
                      deviation: np.ndarray) -> np.ndarray:
    """The motion, and the motion a frame later."""
    once, again = (_units(whole.project(_normalised(x, mean, deviation), W0, b0), mean, deviation)
                   for x in (features, [features[0], *features]))
    return (once + again[1:]) / 2


def fitted_weights(leg: np.ndarray, *, hidden: int = 256, reading: str = "norm") -> np.ndarray:
    """One weight at a time."""
    content, style, *constraints = {
        "norm": (1, 0.06, 0.01, 0.001, 0.5), "mean_squares": (1, 0.01, 2e-4, 2e-5, 0.01),
        "sum_squares": (1, 0.01, 6, 0.6, 300)}[reading]
    units = 256 / hidden if reading == "mean_squares" else 1
    return np.array([[content, style, *(w * units * (80 / x) ** 2 for w in constraints),
                      1e4 * x * x / 80 ** 2] for x in leg])


def decode_untied(H: np.ndarray, V0: np.ndarray, c0: np.ndarray, *,
                  chosen: np.ndarray | None = None) -> np.ndarray:
    """Depooling, filters, bias."""
    D = plain.avg_depool1d(H) if chosen is None else plain.random_depool1d(H, chosen)
    return plain.conv_transpose1d(D, V0) + c0[:, None]


def hidden_loss(H: np.ndarray, *, content: np.ndarray, gram: np.ndarray,
                style: float) -> np.ndarray:
    """One clip at a time."""
    return np.array([style * ((G - h @ h.T) ** 2).mean() + (1 - style) * ((C - h) ** 2).mean()
                     for h, C, G in zip(H, content, gram)])


def decoded_loss(H: np.ndarray, *, contacts: np.ndarray, bones: np.ndarray, trajectory: np.ndarray,
                 W0: np.ndarray, b0: np.ndarray, mean: np.ndarray, deviation: np.ndarray,
                 weights: tuple[float, ...] = (2e-4, 2e-5, 0.01, 1e4)) -> np.ndarray:
    """The losses of equations 7 to 9, each in its own loops."""
    motion = paper.decode(H, W0, b0) * deviation[:, None] + mean[:, None]
    return (weights[0] * paper.foot_loss(motion, contacts)
            + weights[1] * paper.bone_loss(motion, lengths=bones)
            + weights[2] * paper.trajectory_loss(motion, wanted=trajectory, turn_weight=weights[3]))


def style_search_on_2017(features: np.ndarray, contacts: np.ndarray, exemplar: np.ndarray, *,
                         W0: np.ndarray, b0: np.ndarray, mean: np.ndarray, deviation: np.ndarray,
                         bones: np.ndarray, leg: float, form: str = "groups",
                         style: float | None = None, iterations: int = 250, rate: float = 0.1,
                         constraint_iterations: int = 100,
                         constraint_rate: float = 0.01) -> np.ndarray:
    """Steps 1 to 4 one after the other."""
    T = len(features)
    twice = [*range(T), *[T - 1] * (T % 2)]
    content = features[twice]
    planted = contacts[twice].T[None]
    seen = exemplar[:len(exemplar) // 2 * 2] if len(exemplar) > 1 else exemplar[[0, 0]]
    C, E = (paper.encode(_normalised(x, mean, deviation), W0, b0) for x in (content, seen))
    gram = C.shape[2] * plain.gram(E) / E.shape[2]
    s = {"groups": 0.003, "2016": 1 / 11}[form] if style is None else style
    one = np.ones(1)

    def _down(H, gradient, steps, first):
        m, v = np.zeros(H.shape), np.zeros(H.shape)
        rates = whole.learning_rate(np.arange(1, steps + 1), rate=first, epochs=steps)
        for t in range(1, steps + 1):
            H, m, v = plain.adam_step(H, gradient(H), m, v, t=t, rate=rates[t - 1])
        return H

    def _of_hidden(H):
        return (losses.style_loss_backward(one, gram, H, s=s, reading="mean_squares")[1]
                + losses.content_loss_backward(one, C, H, c=1 - s, reading="mean_squares")[1])
    styled = paper.decode(_down(C, _of_hidden, iterations, rate), W0, b0)
    made = _units(styled, mean, deviation)
    speeds = [sum(math.hypot(*row[64:66]) for row in rows) for rows in (made, content)]
    share = speeds[0] / speeds[1] if speeds[1] else 1.0
    path = np.array([[row[63], *(row[64:66] * share)] for row in content])
    foot, bone, way = (w * (80 / leg) ** 2 for w in (0.001, 0.001, 0.5))
    turn = 1e4 * (leg / 80) ** 2

    def _of_decoded(H):
        motion = paper.decode(H, W0, b0) * deviation[:, None] + mean[:, None]
        slope = (losses.foot_loss_backward(one * foot, motion, planted)
                 + losses.bone_loss_backward(one * bone, motion, bones)
                 + losses.trajectory_loss_backward(one * way, motion, path.T[None],
                                                   turn_weight=turn))
        return functions_holden.decode_backward(slope * deviation[:, None], H, W0, b0)[0]
    H = _down(paper.encode(styled, W0, b0), _of_decoded, constraint_iterations, constraint_rate)
    found: Any = _units(paper.decode(H, W0, b0), mean, deviation)
    found[:, 63:] = path
    return found[:T]
