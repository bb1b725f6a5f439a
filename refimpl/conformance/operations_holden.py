"""Records of the losses and networks of Holden et al. 2017, as functions of arrays alone, and their
second derivation."""

from typing import Any

import numpy as np

from ..holden2017 import losses, networks, objective
from ..motion.features import FORWARD, SIDEWAYS, TURN
from ..motion.joints import BONES, FEET
from . import definitions_nn as plain
from .specification import Operation
from .samples_holden import (autoencoder_samples, bone_samples, decode_samples, foot_samples,
                             network_samples, pair_samples, style_samples, total_samples,
                             trajectory_samples, transform_samples)

T_NAMES = ("W1", "b1", "W2", "b2", "W3", "b3")


# The reference, with dicts of parameters spelled out.

def encode(X: np.ndarray, W0: np.ndarray, b0: np.ndarray) -> np.ndarray:
    """Equation 1, hidden units of the loss network:   H = relu(max_pool(X * W0 + b0, 2))

    X : (N, C, T) normalised motion, W0 : (m, C, K), b0 : (m,)  ->  (N, m, T // 2)
    """
    return networks.encode(X, {"W0": W0, "b0": b0})


def encode_backward(dH: np.ndarray, X: np.ndarray, W0: np.ndarray,
                    b0: np.ndarray) -> tuple[np.ndarray, ...]:
    """dH : (N, m, T // 2)  ->  dX (N, C, T), dW0 (m, C, K), db0 (m,)"""
    dX, g = networks.encode_backward(dH, X, {"W0": W0, "b0": b0})
    return dX, g["W0"], g["b0"]


def decode(H: np.ndarray, W0: np.ndarray, b0: np.ndarray, *,
           chosen: np.ndarray | None = None) -> np.ndarray:
    """Equation 2, back to motion with the same filters:

        X = conv_transpose1d(avg_depool1d(H, 2) - b0, W0)

    H : (N, m, U), W0 : (m, C, K), b0 : (m,);  chosen : (N, m, U) of 0 and 1, with which
    random_depool1d(H, chosen, 2) stands in the place of avg_depool1d   ->  (N, C, 2 U)
    """
    return networks.decode(H, {"W0": W0, "b0": b0}, chosen=chosen)


def decode_backward(dX: np.ndarray, H: np.ndarray, W0: np.ndarray, b0: np.ndarray, *,
                    chosen: np.ndarray | None = None) -> tuple[np.ndarray, ...]:
    """dX : (N, C, 2 U)  ->  dH (N, m, U), dW0 (m, C, K), db0 (m,)"""
    dH, g = networks.decode_backward(dX, H, {"W0": W0, "b0": b0}, chosen=chosen)
    return dH, g["W0"], g["b0"]


def autoencoder_loss(X: np.ndarray, W0: np.ndarray, b0: np.ndarray, *, alpha: float = 0.01,
                     mean: bool = True, chosen: np.ndarray | None = None) -> Any:
    """Equation 3:   || X - decode(encode(X)) ||^2 + alpha || W0, b0 ||_1

    X : (N, C, T), T even, W0 : (m, C, K), b0 : (m,);  mean : both sums divided by their numbers of
    elements (as trained here), False as printed;  chosen : (N, m, T // 2) for `decode`   ->  scalar
    """
    return networks.autoencoder_loss(X, {"W0": W0, "b0": b0}, alpha=alpha, mean=mean, chosen=chosen)


def autoencoder_loss_backward(
        dloss: Any, X: np.ndarray, W0: np.ndarray, b0: np.ndarray, *, alpha: float = 0.01,
        mean: bool = True, chosen: np.ndarray | None = None) -> tuple[np.ndarray, ...]:
    """dloss : scalar  ->  dX (N, C, T), dW0 (m, C, K), db0 (m,)"""
    dX, g = networks.autoencoder_loss_backward(dloss, X, {"W0": W0, "b0": b0}, alpha=alpha,
                                               mean=mean, chosen=chosen)
    return dX, g["W0"], g["b0"]


def transform(X: np.ndarray, *arrays: np.ndarray) -> np.ndarray:
    """The network T:   conv1d(relu(conv1d(relu(conv1d(X, W1, b1)), W2, b2)), W3, b3),
    padding "same"

    X : (N, C, T), W1 : (c1, C, K), b1 : (c1,), W2 : (c2, c1, K), b2 : (c2,), W3 : (C, c2, K),
    b3 : (C,)  ->  (N, C, T)
    """
    return networks.transform(X, dict(zip(T_NAMES, arrays)))


def transform_backward(dY: np.ndarray, X: np.ndarray,
                       *arrays: np.ndarray) -> tuple[np.ndarray, ...]:
    """dY : (N, C, T)  ->  dX (N, C, T) and a gradient for each of W1, b1, W2, b2, W3, b3"""
    dX, g = networks.transform_backward(dY, X, dict(zip(T_NAMES, arrays)))
    return (dX, *(g[name] for name in T_NAMES))


def total_loss(*arrays: np.ndarray, I: np.ndarray, hidden: np.ndarray, gram: np.ndarray,
               contacts: np.ndarray, bones: np.ndarray, trajectory: np.ndarray, W0: np.ndarray,
               b0: np.ndarray, mean: np.ndarray, deviation: np.ndarray,
               reading: str = "norm") -> Any:
    """Equation 10 of T(I): the mean over the clips of content + style + foot + bone + trajectory,
    with 10,000 squared lengths for a squared radian of turning, and the weights

        norm           1, 0.06, 0.01, 0.001, 0.5
        mean_squares   1, 0.01, 2e-4, 2e-5, 0.01
        sum_squares    1, 0.01, 6, 0.6, 300

    for each reading of the bars of equations 4 and 5.

    W1 ... b3 : of T, as for `transform`;  I : (N, 66, T) normalised motion;
    hidden : (N, m, T // 2), encode(I) as equation 4 compares it;  gram : (N, m, m), the style's
    Gram matrices;  contacts : (N, 4, T) of 0 and 1;  bones : (20,) lengths;
    trajectory : (N, 3, T) turning (radians a frame), forward and sideways velocity (length a
    frame);  W0, b0 : of the loss network;  mean, deviation : (66,), motion = T(I) deviation + mean
    for equations 7 to 9   ->  scalar
    """
    batch = objective.Batch(I, gram, contacts, bones, trajectory, hidden)
    return objective.total_loss(dict(zip(T_NAMES, arrays)), batch, {"W0": W0, "b0": b0}, mean,
                                deviation, objective.WEIGHTS[reading])[0]


def total_loss_backward(
        dloss: Any, *arrays: np.ndarray, I: np.ndarray, hidden: np.ndarray, gram: np.ndarray,
        contacts: np.ndarray, bones: np.ndarray, trajectory: np.ndarray, W0: np.ndarray,
        b0: np.ndarray, mean: np.ndarray, deviation: np.ndarray,
        reading: str = "norm") -> tuple[np.ndarray, ...]:
    """dloss : scalar  ->  a gradient for each of W1, b1, W2, b2, W3, b3; everything else is a
    constant"""
    batch = objective.Batch(I, gram, contacts, bones, trajectory, hidden)
    g = objective.total_loss_backward(dloss, dict(zip(T_NAMES,
                                                      arrays)), batch, {"W0": W0, "b0": b0}, mean,
                                      deviation, objective.WEIGHTS[reading])
    return tuple(g[name] for name in T_NAMES)


# The second derivation: the equations in loops over frames, joints and bones.

def encode_definition(X: np.ndarray, W0: np.ndarray, b0: np.ndarray) -> np.ndarray:
    return plain.relu(plain.max_pool1d(plain.conv1d(X, W0, b0)))


def decode_definition(H: np.ndarray, W0: np.ndarray, b0: np.ndarray, *,
                      chosen: np.ndarray | None = None) -> np.ndarray:
    D = plain.avg_depool1d(H) if chosen is None else plain.random_depool1d(H, chosen)
    return plain.conv_transpose1d(D - b0[None, :, None], W0)


def autoencoder_loss_definition(X: np.ndarray, W0: np.ndarray, b0: np.ndarray, *,
                                alpha: float = 0.01, mean: bool = True,
                                chosen: np.ndarray | None = None) -> np.ndarray:
    again = decode_definition(encode_definition(X, W0, b0), W0, b0, chosen=chosen)
    squares = ((X - again) ** 2).ravel()
    absolute = [abs(v) for v in W0.ravel()] + [abs(v) for v in b0]
    return np.asarray(sum(squares) / (len(squares) if mean else 1)
                      + alpha * sum(absolute) / (len(absolute) if mean else 1))


def transform_definition(X: np.ndarray, W1: np.ndarray, b1: np.ndarray, W2: np.ndarray,
                         b2: np.ndarray, W3: np.ndarray, b3: np.ndarray) -> np.ndarray:
    return plain.conv1d(
        plain.relu(plain.conv1d(plain.relu(plain.conv1d(X, W1, b1)), W2, b2)), W3, b3)


READINGS = {"norm": plain.norm, "mean_squares": plain.mean_squares,
            "sum_squares": plain.sum_squares}


def content_loss_definition(H_input: np.ndarray, H_output: np.ndarray, *, c: float = 1.0,
                            reading: str = "norm") -> np.ndarray:
    return c * READINGS[reading](H_input - H_output)


def style_loss_definition(G_style: np.ndarray, H_output: np.ndarray, *, s: float = 0.01,
                          reading: str = "norm") -> np.ndarray:
    return s * READINGS[reading](G_style - plain.gram(H_output))


def foot_loss_definition(motion: np.ndarray, contacts: np.ndarray, *,
                         target: Any = 0.0) -> np.ndarray:
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


def bone_loss_definition(motion: np.ndarray, *, lengths: np.ndarray) -> np.ndarray:
    result = np.zeros(len(motion), motion.dtype)
    for n, t in np.ndindex(len(motion), motion.shape[2]):
        for (j1, j2), length in zip(BONES, lengths):
            bone = motion[n, 3 * j1:3 * j1 + 3, t] - motion[n, 3 * j2:3 * j2 + 3, t]
            result[n] += (np.sqrt(np.sum(bone * bone)) - length) ** 2
    return result


def trajectory_loss_definition(motion: np.ndarray, *, wanted: np.ndarray,
                               turn_weight: float = 1.0) -> np.ndarray:
    return np.array([sum(turn_weight * (m[TURN, t] - v[0, t]) ** 2 + (m[FORWARD, t] - v[1, t]) ** 2
                         + (m[SIDEWAYS, t] - v[2, t]) ** 2 for t in range(m.shape[1]))
                     for m, v in zip(motion, wanted)])


def total_loss_definition(
        *arrays: np.ndarray, I: np.ndarray, hidden: np.ndarray, gram: np.ndarray,
        contacts: np.ndarray, bones: np.ndarray, trajectory: np.ndarray, W0: np.ndarray,
        b0: np.ndarray, mean: np.ndarray, deviation: np.ndarray,
        reading: str = "norm") -> np.ndarray:
    w = objective.WEIGHTS[reading]
    O = transform_definition(I, *arrays)
    H, motion = encode_definition(O, W0, b0), O * deviation[:, None] + mean[:, None]
    per_clip = (content_loss_definition(hidden, H, c=w.content, reading=reading)
                + style_loss_definition(gram, H, s=w.style, reading=reading)
                + w.foot * foot_loss_definition(motion, contacts)
                + w.bone * bone_loss_definition(motion, lengths=bones)
                + w.trajectory * trajectory_loss_definition(motion, wanted=trajectory,
                                                            turn_weight=w.turn))
    return np.asarray(sum(per_clip) / len(per_clip))


OPERATIONS = (
    Operation("encode", ("X", "W0", "b0"), encode, encode_backward, encode_definition,
              network_samples, equation="equation 1"),
    Operation("decode", ("H", "W0", "b0"), decode, decode_backward, decode_definition,
              decode_samples, equation="equation 2"),
    Operation("autoencoder_loss", ("X", "W0", "b0"), autoencoder_loss, autoencoder_loss_backward,
              autoencoder_loss_definition, autoencoder_samples, batched=(), equation="equation 3"),
    Operation("transform", ("X", *T_NAMES), transform, transform_backward, transform_definition,
              transform_samples, equation="the network T"),
    Operation("content_loss", ("H_input", "H_output"), losses.content_loss,
              losses.content_loss_backward, content_loss_definition, pair_samples, batched=(0, 1),
              equation="equation 4"),
    Operation("style_loss", ("G_style", "H_output"), losses.style_loss, losses.style_loss_backward,
              style_loss_definition, style_samples, batched=(0, 1), equation="equation 5"),
    Operation("foot_loss", ("motion", "contacts"), losses.foot_loss, losses.foot_loss_backward,
              foot_loss_definition, foot_samples, batched=(0, 1), equation="equation 7"),
    Operation("bone_loss", ("motion",), losses.bone_loss, losses.bone_loss_backward,
              bone_loss_definition, bone_samples, equation="equation 8"),
    Operation("trajectory_loss", ("motion",), losses.trajectory_loss,
              losses.trajectory_loss_backward, trajectory_loss_definition, trajectory_samples,
              batched=(), equation="equation 9"),
    Operation("total_loss", T_NAMES, total_loss, total_loss_backward, total_loss_definition,
              total_samples, batched=(), tolerance=10.0, equation="equation 10"),
)
