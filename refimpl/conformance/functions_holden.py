"""The reference for the networks and the objective of Holden et al. 2017 as functions of arrays
alone: what a backend offers under these names. The losses of `holden2017.losses` are such
functions already.
"""

from collections.abc import Callable
from typing import Any

from ..holden2017 import networks, objective
from .specification import Array

T_NAMES = " ".join(networks.T_NAMES)


def spelled_out(network_backward: Callable[..., Any], names: str, doc: str) -> Callable[..., Any]:
    """A network's backward that takes arrays one after the other in the place of {name: array}, and
    returns dX and the gradients of `names` so.
    """
    def _backward(d, X, *arrays, **attributes):
        dX, gradients = network_backward(d, X, dict(zip(names.split(), arrays)), **attributes)
        return (dX, *(gradients[name] for name in names.split()))
    _backward.__doc__ = doc
    return _backward


def encode(X: Array, W0: Array, b0: Array) -> Array:
    """Equation 1, hidden units of the loss network:   H = relu(max_pool(X * W0 + b0, 2))

    X : (N, C, T) normalised motion, W0 : (m, C, K), b0 : (m,)  ->  (N, m, T // 2)
    """
    return networks.encode(X, {"W0": W0, "b0": b0})


encode_backward = spelled_out(networks.encode_backward, "W0 b0",
                              "dH : (N, m, T // 2)  ->  dX (N, C, T), dW0 (m, C, K), db0 (m,)")


def decode(H: Array, W0: Array, b0: Array, *, chosen: Array | None = None) -> Array:
    """Equation 2, back to motion with the same filters:

        X = conv_transpose1d(avg_depool1d(H, 2) - b0, W0)

    H : (N, m, U), W0 : (m, C, K), b0 : (m,);  chosen : (N, m, U) of 0 and 1, with which
    random_depool1d(H, chosen, 2) stands in the place of avg_depool1d   ->  (N, C, 2 U)
    """
    return networks.decode(H, {"W0": W0, "b0": b0}, chosen=chosen)


decode_backward = spelled_out(networks.decode_backward, "W0 b0",
                              "dX : (N, C, 2 U)  ->  dH (N, m, U), dW0 (m, C, K), db0 (m,)")


def autoencoder_loss(X: Array, W0: Array, b0: Array, *, alpha: float = networks.SPARSE,
                     mean: bool = True, chosen: Array | None = None) -> Any:
    """Equation 3:   || X - decode(encode(X)) ||^2 + alpha || W0, b0 ||_1

    X : (N, C, T), T even, W0 : (m, C, K), b0 : (m,);  mean : both sums divided by their numbers of
    elements (as trained here), False as printed;  chosen : (N, m, T // 2) for `decode`   ->  scalar
    """
    return networks.autoencoder_loss(X, {"W0": W0, "b0": b0}, alpha=alpha, mean=mean, chosen=chosen)


autoencoder_loss_backward = spelled_out(networks.autoencoder_loss_backward, "W0 b0",
                                        "dloss : scalar  ->  dX (N, C, T), dW0 (m, C, K), db0 (m,)")


def transform(X: Array, *arrays: Array) -> Array:
    """The network T:   conv1d(relu(conv1d(relu(conv1d(X, W1, b1)), W2, b2)), W3, b3),
    padding "same"

    X : (N, C, T), W1 : (c1, C, K), b1 : (c1,), W2 : (c2, c1, K), b2 : (c2,), W3 : (C, c2, K),
    b3 : (C,)  ->  (N, C, T)
    """
    return networks.transformation(X, dict(zip(T_NAMES.split(), arrays)))


transform_backward = spelled_out(
    networks.transformation_backward, T_NAMES,
    "dY : (N, C, T)  ->  dX (N, C, T) and a gradient for each of W1, b1, W2, b2, W3, b3")


def total_loss(*arrays: Array, I: Array, hidden: Array, gram: Array,
               contacts: Array, bones: Array, trajectory: Array, W0: Array, b0: Array, mean: Array,
               deviation: Array, reading: str = "norm", foot_velocity: Array | None = None) -> Any:
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
    for equations 7 to 9;  foot_velocity : (N, 4, 3, T - 1), the target of `foot_loss`, 0 unless
    given   ->  scalar
    """
    return objective.total_loss(*_problem(
        arrays, W0, b0, mean, deviation, reading, foot_velocity, I=I, gram=gram, contacts=contacts,
        bones=bones, trajectory=trajectory, hidden=hidden))[0]


def total_loss_backward(dloss: Any, *arrays: Array,
                        W0: Array, b0: Array, mean: Array, deviation: Array, reading: str = "norm",
                        foot_velocity: Array | None = None, **targets: Array) -> tuple[Array, ...]:
    """dloss : scalar  ->  a gradient for each of W1, b1, W2, b2, W3, b3; everything else is a
    constant"""
    gradients = objective.total_loss_backward(dloss, *_problem(
        arrays, W0, b0, mean, deviation, reading, foot_velocity, **targets))
    return tuple(gradients[name] for name in T_NAMES.split())


def _problem(arrays, W0, b0, mean, deviation, reading, foot_velocity, **targets):
    batch = objective.Batch(
        **targets, foot_velocity=0.0 if foot_velocity is None else foot_velocity)
    return (dict(zip(T_NAMES.split(), arrays)), batch, {"W0": W0, "b0": b0}, mean, deviation,
            objective.WEIGHTS[reading])
