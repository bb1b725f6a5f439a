"""This room as the conformance kit asks for it: functions of arrays alone, under the names of the
operations. What comes back is a copy, since the fast forms answer in arrays that they keep.

Every filter goes by tiles here, also those that are faster directly. What a fast form does not
serve (strides, dilation, groups, sums for means, depooling by choice in `decode`) is the
definition's.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from .. import nn
from ..holden2017 import networks as text
from ..holden2017.networks import T_NAMES
from ..holden2017.objective import WEIGHTS, Batch
from . import autoencoder, conv, gradients
from .decoder import half_filters, taps
from .spectral import Plan
from .stylist import Stylist

Constants = dict[str, Any]

conv1d = partial(conv.conv1d, narrowest=1)
conv1d_backward = partial(conv.conv1d_backward, narrowest=1)
conv_transpose1d = partial(conv.conv_transpose1d, narrowest=1)
conv_transpose1d_backward = partial(conv.conv_transpose1d_backward, narrowest=1)


def encode(X: np.ndarray, W0: np.ndarray, b0: np.ndarray) -> np.ndarray:
    """Hidden units by tiles."""
    return nn.relu(nn.max_pool1d(conv1d(X, W0, b0)))


def encode_backward(dH: np.ndarray, X: np.ndarray, W0: np.ndarray,
                    b0: np.ndarray) -> tuple[np.ndarray | None, ...]:
    """The gradient of `encode` by tiles."""
    Z = conv1d(X, W0, b0)
    dZ = nn.max_pool1d_backward(nn.relu_backward(dH, nn.max_pool1d(Z)), Z)
    return conv1d_backward(dZ, X, W0, b0)


def decode(H: np.ndarray, W0: np.ndarray, b0: np.ndarray, *,
           chosen: np.ndarray | None = None) -> np.ndarray:
    """Back to motion at half resolution, as `stylist` and `gradients` do it."""
    if chosen is not None or not np.isfinite(H).all():
        return text.decode(H, {"W0": W0, "b0": b0}, chosen=chosen)
    (N, m, T), (_, C, K) = H.shape, W0.shape
    V, (_, count, left) = half_filters(W0), taps(K)
    plan = Plan(N, T, m, 2 * C, count, W0.dtype, left=left)
    plan.input[:] = (H / H.dtype.type(2) - b0[:, None]).swapaxes(1, 2)
    return plan.forward(plan.spectra(V)).reshape(N, 2 * T, C).swapaxes(1, 2).copy()


def transform(X: np.ndarray, *arrays: np.ndarray) -> np.ndarray:
    """T(X) by a stylist of its own."""
    return Stylist(dict(zip(T_NAMES, arrays)), None).transform(X)


def autoencoder_loss(X: np.ndarray, W0: np.ndarray, b0: np.ndarray, *, alpha: float = 0.01,
                     mean: bool = True, chosen: np.ndarray | None = None) -> Any:
    """The loss of one step of training."""
    params = {"W0": W0, "b0": b0}
    if not mean:
        return text.autoencoder_loss(X, params, alpha=alpha, mean=mean, chosen=chosen)
    loss, _ = autoencoder.autoencoder_gradients(alpha)(params, text.Reconstruction(X, None, chosen))
    return X.dtype.type(loss["loss"])


def autoencoder_loss_backward(
        dloss: Any, X: np.ndarray, W0: np.ndarray, b0: np.ndarray, *, alpha: float = 0.01,
        mean: bool = True, chosen: np.ndarray | None = None) -> tuple[np.ndarray, ...]:
    """The gradients of one step of training; dX, which no training asks for, by the definition."""
    params = {"W0": W0, "b0": b0}
    dX, g = text.autoencoder_loss_backward(dloss, X, params, alpha=alpha, mean=mean, chosen=chosen)
    if mean:
        batch = text.Reconstruction(X, None, chosen)
        g = {name: W0.dtype.type(dloss) * gradient for name, gradient
             in autoencoder.autoencoder_gradients(alpha)(params, batch)[1].items()}
    return dX, g["W0"], g["b0"]


def total_loss(*arrays: np.ndarray, reading: str = "norm", **constants: Any) -> Any:
    """The loss of one step of training."""
    step, params, batch = _problem(arrays, reading, constants)
    return sum(step(params, batch)[0].values())


def total_loss_backward(dloss: Any, *arrays: np.ndarray, reading: str = "norm",
                        **constants: Any) -> tuple[np.ndarray, ...]:
    """The gradients of one step of training."""
    step, params, batch = _problem(arrays, reading, constants)
    found = step(params, batch)[1]
    return tuple(found[name].dtype.type(dloss) * found[name] for name in T_NAMES)


def _problem(arrays, reading, c):
    step = gradients.style_gradients({"W0": c["W0"], "b0": c["b0"]}, c["mean"], c["deviation"],
                                     WEIGHTS[reading])
    target = c.get("foot_velocity")
    batch = Batch(c["I"], c["gram"], c["contacts"], c["bones"], c["trajectory"], c["hidden"],
                  foot_velocity=0.0 if target is None else target)
    return step, dict(zip(T_NAMES, arrays)), batch


BACKEND: dict[str, Callable] = {
    "conv1d": conv1d, "conv1d_backward": conv1d_backward, "conv_transpose1d": conv_transpose1d,
    "conv_transpose1d_backward": conv_transpose1d_backward,
    **{f.__name__: f for f in (encode, encode_backward, decode, transform, autoencoder_loss,
                               autoencoder_loss_backward, total_loss, total_loss_backward)}}
