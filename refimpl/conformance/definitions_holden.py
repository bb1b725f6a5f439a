"""The networks and losses of Holden et al. 2017 a second time: the equations in loops over frames,
joints and bones, on top of `definitions_nn`.
"""

from typing import Any

import numpy as np

from ..holden2017 import objective
from ..motion.features import FORWARD, SIDEWAYS, TURN
from ..motion.joints import BONES, FEET
from . import definitions_nn as plain
from .specification import Array

READINGS = {"norm": plain.norm, "mean_squares": plain.mean_squares,
            "sum_squares": plain.sum_squares}


def encode(X: Array, W0: Array, b0: Array) -> Array:
    """Equation 1 of Holden et al.: filters, bias, the larger of two frames, relu."""
    return plain.relu(plain.max_pool1d(plain.conv1d(X, W0, b0)))


def decode(H: Array, W0: Array, b0: Array, *, chosen: Array | None = None) -> Array:
    """Equation 2 of Holden et al., with the same filters as `encode`."""
    D = plain.avg_depool1d(H) if chosen is None else plain.random_depool1d(H, chosen)
    return plain.conv_transpose1d(D - b0[None, :, None], W0)


def autoencoder_loss(X: Array, W0: Array, b0: Array, *, alpha: float = 0.01,
                     mean: bool = True, chosen: Array | None = None) -> Array:
    """Equation 3 of Holden et al., with sums or means."""
    again = decode(encode(X, W0, b0), W0, b0, chosen=chosen)
    squares = ((X - again) ** 2).ravel()
    absolute = [plain.size_of(v) for v in (*W0.ravel(), *b0)]
    return np.asarray(sum(squares) / (len(squares) if mean else 1)
                      + alpha * sum(absolute) / (len(absolute) if mean else 1))


def transform(X: Array, W1: Array, b1: Array, W2: Array, b2: Array, W3: Array, b3: Array) -> Array:
    """The network T: three convolutions with relu between them."""
    hidden = plain.relu(plain.conv1d(plain.relu(plain.conv1d(X, W1, b1)), W2, b2))
    return plain.conv1d(hidden, W3, b3)


def content_loss(H_input: Array, H_output: Array, *, c: float = 1.0,
                 reading: str = "norm") -> Array:
    """Equation 4 of Holden et al., one number a clip."""
    return c * READINGS[reading](H_input - H_output)


def style_loss(G_style: Array, H_output: Array, *, s: float = 0.01, reading: str = "norm") -> Array:
    """Equation 5 of Holden et al., one number a clip."""
    return s * READINGS[reading](G_style - plain.gram(H_output))


def foot_loss(motion: Array, contacts: Array, *, target: Any = 0.0) -> Array:
    """World velocity of each planted foot by the cross product, one frame at a time."""
    target = np.broadcast_to(target, (len(motion), 4, 3, motion.shape[2] - 1))
    result = np.zeros(len(motion), motion.dtype)
    for n, i, t in np.ndindex(len(motion), 4, motion.shape[2] - 1):
        if contacts[n, i, t]:
            here, there = (motion[n, 3 * FEET[i]:3 * FEET[i] + 3, u] for u in (t, t + 1))
            root = np.array([motion[n, SIDEWAYS, t], 0, motion[n, FORWARD, t]])
            slide = (root + np.cross(np.array([0, motion[n, TURN, t], 0]), here) + there - here
                     - target[n, i, :, t])
            result[n] += np.sum(slide * slide)
    return result


def bone_loss(motion: Array, *, lengths: Array) -> Array:
    """Squared errors of length, one bone and one frame at a time."""
    result = np.zeros(len(motion), motion.dtype)
    for n, t in np.ndindex(len(motion), motion.shape[2]):
        for (j1, j2), length in zip(BONES, lengths):
            bone = motion[n, 3 * j1:3 * j1 + 3, t] - motion[n, 3 * j2:3 * j2 + 3, t]
            result[n] += (np.sqrt(np.sum(bone * bone)) - length) ** 2
    return result


def trajectory_loss(motion: Array, *, wanted: Array, turn_weight: float = 1.0) -> Array:
    """Squared errors of turning, forward and sideways velocity, one frame at a time."""
    return np.array([sum(turn_weight * (m[TURN, t] - v[0, t]) ** 2 + (m[FORWARD, t] - v[1, t]) ** 2
                         + (m[SIDEWAYS, t] - v[2, t]) ** 2 for t in range(m.shape[1]))
                     for m, v in zip(motion, wanted)])


def total_loss(*arrays: Array, I: Array, hidden: Array, gram: Array, contacts: Array,
               bones: Array, trajectory: Array, W0: Array, b0: Array, mean: Array, deviation: Array,
               reading: str = "norm", foot_velocity: Array | None = None) -> Array:
    """Equation 10 of Holden et al.: the mean over the clips of the weighted losses above."""
    w = objective.WEIGHTS[reading]
    O = transform(I, *arrays)
    H, motion = encode(O, W0, b0), O * deviation[:, None] + mean[:, None]
    per_clip = (content_loss(hidden, H, c=w.content,
                             reading=reading) + style_loss(gram, H, s=w.style, reading=reading) +
                w.foot * foot_loss(motion, contacts, target=0.0 if foot_velocity is None
                                   else foot_velocity) + w.bone * bone_loss(motion, lengths=bones) +
                w.trajectory * trajectory_loss(motion, wanted=trajectory, turn_weight=w.turn))
    return np.asarray(sum(per_clip) / len(per_clip))
