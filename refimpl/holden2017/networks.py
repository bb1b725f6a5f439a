r"""The two networks of Holden et al. 2017, Figure 1: the loss network L (a convolutional
autoencoder) and the transformation network T.

Motions are `(N, 66, T)`, normalised. Parameters are plain dicts of arrays, gradients dicts with the
same keys. `kernels` is whoever provides the convolutions: `nn.tiled` (fast) unless told,
`refimpl.nn` for the direct ones, which are the definition, or another module with the same
functions.
"""

import numpy as np

from .. import nn
from ..motion.features import FEATURES
from ..nn import tiled
from ..nn.sums import wide_sum

HIDDEN, WIDTH, CHANNELS = 256, 25, 128


def uniform_filters(rng, c_out, c_in, width, dtype=np.float32):
    r"""Initial filters: uniform in +-sqrt(6 / (fan_in + fan_out)), fan_in = C_in K, fan_out = C_out
    K.   ->  (C_out, C_in, K)
    """
    bound = np.sqrt(6.0 / ((c_in + c_out) * width))
    return rng.uniform(-bound, bound, size=(c_out, c_in, width)).astype(dtype)


def init_loss_network(rng, *, hidden=HIDDEN, width=WIDTH, features=FEATURES, dtype=np.float32):
    """W0 (hidden, 66, width) and b0 (hidden,), the paper's theta.   ->  dict"""
    return {
        "W0": uniform_filters(rng, hidden, features, width, dtype), "b0": np.zeros(hidden, dtype)}


def encode(X, params, *, kernels=tiled):
    r"""Equation 1:   L(X) = ReLU(Psi(X * W0 + b0)),   Psi = max-pooling over two frames.

    X : (N, 66, T)  ->  H (N, 256, T // 2)
    """
    Z = kernels.conv1d(X, params["W0"], params["b0"])            # (N, 256, T)
    return nn.relu(nn.max_pool1d(Z))                             # (N, 256, T // 2)


def encode_backward(dH, X, params, *, kernels=tiled):
    """The chain of equation 1 walked backwards.
    dH : (N, 256, T // 2), X : (N, 66, T)  ->  dX, {"W0": dW0, "b0": db0}
    """
    dZ = _before_pooling(dH, X, params, kernels)
    dX, dW0, db0 = kernels.conv1d_backward(dZ, X, params["W0"], params["b0"])
    return dX, {"W0": dW0, "b0": db0}


def encode_backward_to_input(dH, X, params, *, kernels=tiled):
    """Only dX of `encode_backward`, for a loss network that is trained no more: dX =
    conv_transpose1d(dZ, W0).
    """
    return kernels.conv_transpose1d(_before_pooling(dH, X, params, kernels), params["W0"])


def _before_pooling(dH, X, params, kernels):
    Z = kernels.conv1d(X, params["W0"], params["b0"])
    P = nn.max_pool1d(Z)
    dP = nn.relu_backward(dH, P)
    return nn.max_pool1d_backward(dP, Z)                         # dZ (N, 256, T)


def decode(H, params, *, chosen=None, kernels=tiled):
    r"""Equation 2:   L+(H) = (Psi+(H) - b0) * W0~,
    Psi+ = average-depooling, W0~ the transposed convolution with the same filters.

    chosen : (N, 256, T) of 0 and 1 for depooling by chance instead, as L learns
    (`nn.random_depool1d`)
    A decoder that is not tied, like that of the 2016 code's network, has filters V0 (256, 66, K)
    and biases c0 (66,) of its own in params: L+(H) = Psi+(H) * V0~ + c0.
    H : (N, 256, T)  ->  X (N, 66, 2 T)
    """
    D = _before_filters(H, params, chosen)                       # (N, 256, 2 T)
    if "V0" in params:
        return kernels.conv_transpose1d(D, params["V0"]) + params["c0"][:, None]
    return kernels.conv_transpose1d(D, params["W0"])             # (N, 66, 2 T)


def decode_backward(dX, H, params, *, chosen=None, kernels=tiled):
    """dX : (N, 66, 2 T), H : (N, 256, T)  ->  dH, {"W0": dW0, "b0": db0}, or V0 and c0 of an untied
    decoder
    """
    filters = "V0" if "V0" in params else "W0"
    dD, dfilters, _ = kernels.conv_transpose1d_backward(dX, _before_filters(H, params, chosen),
                                                        params[filters])
    dH = nn.avg_depool1d_backward(dD, H) if chosen is None else nn.random_depool1d_backward(
        dD, H, chosen)
    if filters == "V0":
        return dH, {"V0": dfilters, "c0": wide_sum(dX, (0, 2))}
    return dH, {"W0": dfilters, "b0": -wide_sum(dD, (0, 2))}


def _before_filters(H, params, chosen):
    depooled = nn.avg_depool1d(H) if chosen is None else nn.random_depool1d(H, chosen)
    # D (N, 256, 2 T)
    return depooled if "V0" in params else depooled - params["b0"][:, None]


def decode_backward_to_input(dX, H, params, *, kernels=tiled):
    """Only dH of `decode_backward`: the adjoint of a transposed convolution is the convolution,
    without bias.
    """
    return nn.avg_depool1d_backward(kernels.conv1d(dX, params.get("V0", params["W0"])), H)


def project(X, params, *, kernels=tiled):
    """Manifold projection: P(X) = L+(L(X)). An odd last frame is doubled for the pooling and
    dropped again.

    X : (N, 66, T)  ->  (N, 66, T)
    """
    frames = X.shape[2]
    if frames % 2:
        X = np.concatenate([X, X[:, :, -1:]], axis=2)
    return decode(encode(X, params, kernels=kernels), params, kernels=kernels)[:, :, :frames]


def autoencoder_loss(X, params, *, alpha=0.01, mean=True, noisy=None, chosen=None, kernels=tiled):
    r"""Equation 3:   || X - L+(L(X)) ||^2 + alpha || theta ||_1

    mean=True divides the two sums by their numbers of elements (as trained here); mean=False is the
    equation as printed.
    noisy : what is encoded instead of X, when the network learns to remove noise;  chosen : (N,
    256, T // 2) for depooling by chance, as in `decode`
    X : (N, 66, T), T even  ->  scalar
    """
    H = encode(X if noisy is None else noisy, params, kernels=kernels)
    reconstruction = decode(H, params, chosen=chosen, kernels=kernels)
    size = sum(p.size for p in params.values())
    sparsity = sum(nn.l1(p) for p in params.values()) / (size if mean else 1)
    return nn.squared_error(reconstruction, X,
                            reduction="mean" if mean else "sum") + alpha * sparsity


def autoencoder_loss_backward(dloss, X, params, *, alpha=0.01, mean=True, noisy=None, chosen=None,
                              kernels=tiled):
    """The tied filters W0 receive three gradients: from the encoder, from the decoder and from the
    sparsity.

    dloss : scalar  ->  dX (as target and, without `noisy`, as input), {"W0": dW0, "b0": db0}
    """
    source = X if noisy is None else noisy
    H = encode(source, params, kernels=kernels)
    reconstruction = decode(H, params, chosen=chosen, kernels=kernels)
    d_reconstruction, dX = nn.squared_error_backward(dloss, reconstruction, X,
                                                     reduction="mean" if mean else "sum")
    dH, from_decoder = decode_backward(d_reconstruction, H, params, chosen=chosen, kernels=kernels)
    d_source, from_encoder = encode_backward(dH, source, params, kernels=kernels)
    size = sum(p.size for p in params.values())
    d_sparsity = dloss * alpha / (size if mean else 1)
    gradients = {
        name: from_encoder[name] + from_decoder[name] + nn.l1_backward(d_sparsity, p)
        for name, p in params.items()}
    return (dX + d_source if noisy is None else dX), gradients


def init_transformation_network(rng, *, channels=CHANNELS, width=WIDTH, features=FEATURES,
                                dtype=np.float32):
    """Three layers 66 -> 128 -> 128 -> 66.   ->  dict of W1, b1, W2, b2, W3, b3"""
    sizes = [features, channels, channels, features]
    params = {}
    for layer in (1, 2, 3):
        params[f"W{layer}"] = uniform_filters(rng, sizes[layer], sizes[layer - 1], width, dtype)
        params[f"b{layer}"] = np.zeros(sizes[layer], dtype)
    return params


def transform(X, params, *, kernels=tiled):
    r"""The transformation network:   T(X) = relu(relu(X * W1 + b1) * W2 + b2) * W3 + b3.
    X : (N, 66, T)  ->  (N, 66, T)
    """
    A1 = nn.relu(kernels.conv1d(X, params["W1"], params["b1"]))  # (N, 128, T)
    A2 = nn.relu(kernels.conv1d(A1, params["W2"], params["b2"]))
    return kernels.conv1d(A2, params["W3"], params["b3"])


def transform_backward(dY, X, params, *, kernels=tiled):
    """dY : (N, 66, T), X : (N, 66, T)  ->  dX, gradients with the keys of params"""
    Z1 = kernels.conv1d(X, params["W1"], params["b1"])
    A1 = nn.relu(Z1)
    Z2 = kernels.conv1d(A1, params["W2"], params["b2"])
    A2 = nn.relu(Z2)
    gradients = {}
    dA2, gradients["W3"], gradients["b3"] = kernels.conv1d_backward(dY, A2, params["W3"],
                                                                    params["b3"])
    dZ2 = nn.relu_backward(dA2, Z2)
    dA1, gradients["W2"], gradients["b2"] = kernels.conv1d_backward(dZ2, A1, params["W2"],
                                                                    params["b2"])
    dZ1 = nn.relu_backward(dA1, Z1)
    dX, gradients["W1"], gradients["b1"] = kernels.conv1d_backward(dZ1, X, params["W1"],
                                                                   params["b1"])
    return dX, gradients
