r"""The two networks of Holden et al. 2017, Figure 1: the loss network L (a convolutional
autoencoder) and the transformation network T.

Motions are `(N, 66, T)`, normalised. Parameters are plain dicts of arrays, gradients dicts with the
same keys. Every function is a definition and calls `refimpl.nn` alone; `fast.networks` has the same
functions, sooner.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .. import nn
from ..motion.features import FEATURES
from ..nn.arguments import in_precision
from ..nn.conv import uniform_filters
from ..nn.pool import even
from ..nn.sums import wide_sum

HIDDEN, WIDTH, CHANNELS = 256, 25, 128
SPARSE = 0.01                                                    # alpha of equation 3
DEPOOLING = ("random", "average")                  # while L learns; it runs with averages

Params = Mapping[str, np.ndarray]
Gradients = dict[str, Any]
Found = tuple[dict[str, Any], Gradients]                         # losses by name, gradients
T_NAMES = ("W1", "b1", "W2", "b2", "W3", "b3")                   # parameters of T


def init_loss_network(rng: np.random.Generator, *, hidden: int = HIDDEN, width: int = WIDTH,
                      features: int = FEATURES, dtype: Any = np.float32) -> Gradients:
    """The loss network before training, the paper's theta.

    ->  dict of W0 (hidden, 66, width) and b0 (hidden,)

    >>> {name: p.shape for name, p in init_loss_network(np.random.default_rng(0)).items()}
    {'W0': (256, 66, 25), 'b0': (256,)}
    """
    return {"W0": uniform_filters(rng, hidden, features, width, dtype),
            "b0": np.zeros(hidden, dtype)}


def encode(X: np.ndarray, params: Params) -> np.ndarray:
    r"""Hidden units of the loss network (Holden 2017, Equation 1):

        L(X) = ReLU(Psi(X * W0 + b0)),   Psi = max-pooling over two frames

    X : (N, 66, T)  ->  H (N, 256, T // 2)

    >>> params = {"W0": np.array([[[1.0]]]), "b0": np.array([-1.0])}
    >>> encode(np.array([[[1.0, 5, 0, 0]]]), params)
    array([[[4., 0.]]])
    """
    Z = nn.conv1d(X, params["W0"], params["b0"])                 # (N, 256, T)
    return nn.relu(nn.max_pool1d(Z))                             # (N, 256, T // 2)


def encode_backward(dH: np.ndarray, X: np.ndarray, params: Params) -> tuple[np.ndarray, Gradients]:
    """The chain of `encode` walked backwards.

    dH : (N, 256, T // 2), X : (N, 66, T)  ->  dX, {"W0": dW0, "b0": db0}

    >>> params = {"W0": np.array([[[1.0]]]), "b0": np.array([-1.0])}
    >>> encode_backward(np.array([[[1.0, 1.0]]]), np.array([[[1.0, 5, 0, 0]]]), params)[0]
    array([[[0., 1., 0., 0.]]])
    """
    dZ = _before_pooling(dH, X, params)
    dX, dW0, db0 = nn.conv1d_backward(dZ, X, params["W0"], params["b0"])
    return dX, {"W0": dW0, "b0": db0}


def encode_backward_to_input(dH: np.ndarray, X: np.ndarray, params: Params) -> np.ndarray:
    """Only dX of `encode_backward`, for a loss network that is trained no more:

        dX = conv_transpose1d(dZ, W0)

    dH : (N, 256, T // 2), X : (N, 66, T)  ->  (N, 66, T)
    """
    return nn.conv_transpose1d(_before_pooling(dH, X, params), params["W0"])


def _before_pooling(dH: np.ndarray, X: np.ndarray, params: Params) -> np.ndarray:
    Z = nn.conv1d(X, params["W0"], params["b0"])
    dP = nn.relu_backward(dH, nn.max_pool1d(Z))
    return nn.max_pool1d_backward(dP, Z)                         # dZ (N, 256, T)


def decode(H: np.ndarray, params: Params, *, chosen: np.ndarray | None = None) -> np.ndarray:
    r"""Back to motion with the same filters (Holden 2017, Equation 2):

        L+(H) = (Psi+(H) - b0) * W0~,   Psi+ = average-depooling, * W0~ the transposed convolution

    H : (N, 256, T)  ->  X (N, 66, 2 T)
    chosen : (N, 256, T) of 0 and 1 for `nn.random_depool1d` instead, with which L learns
    A decoder that is not tied, like that of the 2016 code, has filters V0 (256, 66, K) and biases
    c0 (66,) of its own in params:   L+(H) = Psi+(H) * V0~ + c0.

    >>> decode(np.array([[[4.0, 0]]]), {"W0": np.array([[[1.0]]]), "b0": np.array([-1.0])})
    array([[[3., 3., 1., 1.]]])
    """
    D = _before_filters(H, params, chosen)                       # (N, 256, 2 T)
    if "V0" in params:
        return nn.conv_transpose1d(D, params["V0"], params["c0"])
    return nn.conv_transpose1d(D, params["W0"])                  # (N, 66, 2 T)


def decode_backward(dX: np.ndarray, H: np.ndarray, params: Params, *,
                    chosen: np.ndarray | None = None) -> tuple[np.ndarray, Gradients]:
    """The chain of `decode` walked backwards.

    dX : (N, 66, 2 T), H : (N, 256, T)  ->  dH, {"W0": dW0, "b0": db0} (or V0 and c0)
    """
    filters = "V0" if "V0" in params else "W0"
    D = _before_filters(H, params, chosen)
    dD, dfilters, _ = nn.conv_transpose1d_backward(dX, D, params[filters])
    dH = nn.avg_depool1d_backward(dD, H) if chosen is None else nn.random_depool1d_backward(
        dD, H, chosen)
    if filters == "V0":
        return dH, {"V0": dfilters, "c0": wide_sum(dX, (0, 2))}
    return dH, {"W0": dfilters, "b0": -wide_sum(dD, (0, 2))}


def _before_filters(H: np.ndarray, params: Params, chosen: np.ndarray | None) -> np.ndarray:
    D = nn.avg_depool1d(H) if chosen is None else nn.random_depool1d(H, chosen)
    return D if "V0" in params else D - params["b0"][:, None]    # (N, 256, 2 T)


def decode_backward_to_input(dX: np.ndarray, H: np.ndarray, params: Params) -> np.ndarray:
    """Only dH of `decode_backward`: the adjoint of a transposed convolution is the convolution.

    dX : (N, 66, 2 T), H : (N, 256, T)  ->  (N, 256, T)
    """
    return nn.avg_depool1d_backward(nn.conv1d(dX, params.get("V0", params["W0"])), H)


def project(X: np.ndarray, params: Params) -> np.ndarray:
    """Manifold projection, P(X) = L+(L(X)).

    X : (N, 66, T)  ->  (N, 66, T). An odd last frame is doubled for the pooling and dropped again.
    """
    return decode(encode(even(X), params), params)[:, :, :X.shape[2]]


def autoencoder_loss(X: np.ndarray, params: Params, *, alpha: float = SPARSE, mean: bool = True,
                     noisy: np.ndarray | None = None, chosen: np.ndarray | None = None) -> Any:
    r"""What the loss network learns by (Holden 2017, Equation 3):

        || X - L+(L(X)) ||^2 + alpha || theta ||_1

    X : (N, 66, T), T even  ->  scalar
    mean : True divides the two sums by their numbers of elements (as trained here), False is the
    equation as printed;  noisy : what is encoded instead of X, when the network learns to remove
    noise;  chosen : (N, 256, T // 2), as in `decode`
    """
    again = decode(encode(X if noisy is None else noisy, params), params, chosen=chosen)
    sparsity = in_precision(alpha, X) * sum(map(nn.l1, params.values())) / _shared_by(params, mean)
    return nn.squared_error(again, X, reduction="mean" if mean else "sum") + sparsity


def autoencoder_loss_backward(dloss: Any, X: np.ndarray, params: Params, *, alpha: float = SPARSE,
                              mean: bool = True, noisy: np.ndarray | None = None,
                              chosen: np.ndarray | None = None) -> tuple[np.ndarray, Gradients]:
    """The tied filters W0 receive three gradients: from the encoder, from the decoder and from the
    sparsity.

    dloss : scalar  ->  dX (as target and, without `noisy`, as input), {"W0": dW0, "b0": db0}
    """
    source = X if noisy is None else noisy
    H = encode(source, params)
    d_again, dX = nn.squared_error_backward(dloss, decode(H, params, chosen=chosen), X,
                                            reduction="mean" if mean else "sum")
    dH, from_decoder = decode_backward(d_again, H, params, chosen=chosen)
    d_source, from_encoder = encode_backward(dH, source, params)
    d_sparsity = dloss * in_precision(alpha, X) / _shared_by(params, mean)
    gradients = {name: from_encoder[name] + from_decoder[name] + nn.l1_backward(d_sparsity, p)
                 for name, p in params.items()}
    return (dX + d_source if noisy is None else dX), gradients


def _shared_by(params: Params, mean: bool) -> int:
    return sum(p.size for p in params.values()) if mean else 1


@dataclass(frozen=True)
class Reconstruction:
    """Some windows and what the loss network makes them from.

    X : (N, 66, T);  noisy, chosen : of `autoencoder_loss`
    """

    X: np.ndarray
    noisy: np.ndarray | None = None
    chosen: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.X)

    def part(self, rows: Any) -> "Reconstruction":
        """Some of the windows."""
        return replace(self, **{name: value[rows] for name, value in vars(self).items()
                                if value is not None})


def autoencoder_gradients(alpha: float) -> Callable[[Params, Reconstruction], Found]:
    """What training asks for each batch, by the definition.

    ->  (params, Reconstruction) -> {"loss": scalar}, gradients
    """
    def of_batch(params: Params, batch: Reconstruction) -> Found:
        how: dict[str, Any] = {"alpha": alpha, "noisy": batch.noisy, "chosen": batch.chosen}
        loss = autoencoder_loss(batch.X, params, **how)
        return {"loss": loss}, autoencoder_loss_backward(1.0, batch.X, params, **how)[1]

    return of_batch


def init_transformation_network(rng: np.random.Generator, *, channels: int = CHANNELS,
                                width: int = WIDTH, features: int = FEATURES,
                                dtype: Any = np.float32) -> Gradients:
    """The transformation network before training, three layers 66 -> 128 -> 128 -> 66.

    ->  dict of W1, b1, W2, b2, W3, b3
    """
    sizes = [features, channels, channels, features]
    params = {}
    for layer in (1, 2, 3):
        params[f"W{layer}"] = uniform_filters(rng, sizes[layer], sizes[layer - 1], width, dtype)
        params[f"b{layer}"] = np.zeros(sizes[layer], dtype)
    return params


def transformation(X: np.ndarray, params: Params) -> np.ndarray:
    r"""The transformation network:

        T(X) = relu(relu(X * W1 + b1) * W2 + b2) * W3 + b3

    X : (N, 66, T)  ->  (N, 66, T)
    """
    A1 = nn.relu(nn.conv1d(X, params["W1"], params["b1"]))       # (N, 128, T)
    A2 = nn.relu(nn.conv1d(A1, params["W2"], params["b2"]))
    return nn.conv1d(A2, params["W3"], params["b3"])


def transformation_backward(dY: np.ndarray, X: np.ndarray,
                            params: Params) -> tuple[np.ndarray, Gradients]:
    """The chain of `transformation` walked backwards.

    dY : (N, 66, T), X : (N, 66, T)  ->  dX, gradients with the keys of params
    """
    g: dict[str, Any] = {}
    Z1 = nn.conv1d(X, params["W1"], params["b1"])
    A1 = nn.relu(Z1)
    Z2 = nn.conv1d(A1, params["W2"], params["b2"])
    A2 = nn.relu(Z2)
    dA2, g["W3"], g["b3"] = nn.conv1d_backward(dY, A2, params["W3"], params["b3"])
    dZ2 = nn.relu_backward(dA2, Z2)
    dA1, g["W2"], g["b2"] = nn.conv1d_backward(dZ2, A1, params["W2"], params["b2"])
    dZ1 = nn.relu_backward(dA1, Z1)
    dX, g["W1"], g["b1"] = nn.conv1d_backward(dZ1, X, params["W1"], params["b1"])
    return dX, g
