r"""The 2016 code's autoencoder (`network.py` and the layers under `nn/`), each gradient by hand.

    L(X)  = Psi(ReLU((X . kept) * We + be))          Psi: max-pooling over two frames
    L+(H) = (Psi+(H) . kept) * Wd + bd               Psi+: half of each value to both frames

While it learns, both dropouts keep each number with probability 3/4 and divide it by 0.75, and Psi+
gives one of the two frames, by chance, the whole value. The decoder has filters and biases of its
own: nothing is tied, unlike equation 2 of Holden et al. 2017.

Motions are (N, 73, T), normalised. Parameters are a dict: We (m, 73, K), be (m,), Wd (73, m, K),
bd (73,). The code's own filters are these reversed in time, since Theano flips them (`files` does
it). At kinks it differs: Theano's ReLU has the gradient 1 at 0, this one 0; Theano gives every one
of equal largest elements the gradient, this one the first.
"""

from typing import Any

import numpy as np

from .. import nn
from ..nn.conv import uniform_filters
from .rows import NUMBERS

DROPOUT = 0.25
SPARSITY = {"We": 0.001, "Wd": 0.00125}

Params = dict[str, np.ndarray]


def init_network(rng: np.random.Generator, *, hidden: int = 256, width: int = 25,
                 numbers: int = NUMBERS, dtype: Any = np.float64) -> Params:
    """Initial filters uniform within sqrt(6 / ((C_in + C_out) K)), biases 0.

    >>> params = init_network(np.random.default_rng(0), hidden=4, width=3)
    >>> {name: array.shape for name, array in params.items()}
    {'We': (4, 73, 3), 'be': (4,), 'Wd': (73, 4, 3), 'bd': (73,)}
    """
    return {"We": uniform_filters(rng, hidden, numbers, width, dtype),
            "be": np.zeros(hidden, dtype),
            "Wd": uniform_filters(rng, numbers, hidden, width, dtype),
            "bd": np.zeros(numbers, dtype)}


def drop(x: np.ndarray, kept: np.ndarray | None) -> np.ndarray:
    """Dropout: x where it is kept, divided by 0.75, else 0.

    kept : of 0 and 1, or None for all of x

    >>> drop(np.array([3.0, 3.0]), np.array([0, 1])).tolist()
    [0.0, 4.0]
    """
    return x if kept is None else x * (kept / (1 - DROPOUT)).astype(x.dtype)


def encode(X: np.ndarray, params: Params, *, kept: np.ndarray | None = None) -> np.ndarray:
    """L(X) of equation 1, with a dropout before the convolution.

    X : (N, 73, T)
    kept : (N, 73, T) of 0 and 1, while learning
    ->  H (N, m, T // 2)

    >>> params = init_network(np.random.default_rng(0), hidden=4, width=3)
    >>> encode(np.ones((1, 73, 8)), params).shape
    (1, 4, 4)
    """
    Z = nn.conv1d(drop(X, kept), params["We"], params["be"])     # (N, m, T)
    return nn.max_pool1d(nn.relu(Z))


def encode_backward(dH: np.ndarray, X: np.ndarray, params: Params, *,
                    kept: np.ndarray | None = None) -> tuple[np.ndarray, dict[str, Any]]:
    """dH : (N, m, T // 2)  ->  dX (N, 73, T), {"We": ..., "be": ...}"""
    D = drop(X, kept)
    Z = nn.conv1d(D, params["We"], params["be"])
    dZ = nn.relu_backward(nn.max_pool1d_backward(dH, nn.relu(Z)), Z)
    dD, dWe, dbe = nn.conv1d_backward(dZ, D, params["We"], params["be"])
    return drop(dD, kept), {"We": dWe, "be": dbe}


def decode(H: np.ndarray, params: Params, *, chosen: np.ndarray | None = None,
           kept: np.ndarray | None = None) -> np.ndarray:
    """L+(H), with a dropout between depooling and convolution.

    H : (N, m, U)
    chosen : (N, m, U) of 0 and 1, while learning: which frame of a pair gets the whole value
    kept : (N, m, 2 U) of 0 and 1, while learning
    ->  (N, 73, 2 U)

    >>> params = init_network(np.random.default_rng(0), hidden=4, width=3)
    >>> decode(np.ones((1, 4, 4)), params).shape
    (1, 73, 8)
    """
    return nn.conv1d(_before_filters(H, chosen, kept), params["Wd"], params["bd"])


def decode_backward(dX: np.ndarray, H: np.ndarray, params: Params, *,
                    chosen: np.ndarray | None = None,
                    kept: np.ndarray | None = None) -> tuple[np.ndarray, dict[str, Any]]:
    """dX : (N, 73, 2 U), H : (N, m, U)  ->  dH, {"Wd": ..., "bd": ...}"""
    D = _before_filters(H, chosen, kept)
    dD, dWd, dbd = nn.conv1d_backward(dX, D, params["Wd"], params["bd"])
    dD = drop(dD, kept)
    dH = (nn.avg_depool1d_backward(dD, H) if chosen is None
          else nn.random_depool1d_backward(dD, H, chosen))
    return dH, {"Wd": dWd, "bd": dbd}


def _before_filters(H, chosen, kept):
    return drop(nn.avg_depool1d(H) if chosen is None else nn.random_depool1d(H, chosen), kept)


def project(X: np.ndarray, params: Params) -> np.ndarray:
    """P(X) = L+(L(X)).   X : (N, 73, T), T even  ->  (N, 73, T)

    >>> params = init_network(np.random.default_rng(0), hidden=4, width=3)
    >>> project(np.ones((1, 73, 8)), params).shape
    (1, 73, 8)
    """
    return decode(encode(X, params), params)


def autoencoder_loss(X: np.ndarray, params: Params, *, kept: np.ndarray | None = None,
                     chosen: np.ndarray | None = None,
                     kept_hidden: np.ndarray | None = None) -> Any:
    r"""What the trainer minimises:

        mean_squares(L+(L(X)) - X) + 0.001 mean|We| + 0.00125 mean|Wd|

    Each part of the network divides 0.01 mean|W| by its number of layers, five and four, and the
    two together are halved; no bias counts. Equation 3 of the papers has one sum and one weight.

    X : (N, 73, T), T even
    kept, chosen, kept_hidden : the chances of `encode` and `decode`
    ->  scalar

    >>> params = init_network(np.random.default_rng(0), hidden=4, width=3)
    >>> nothing = {name: 0 * array for name, array in params.items()}
    >>> float(autoencoder_loss(np.full((1, 73, 8), 2.0), nothing))
    4.0
    """
    again = decode(encode(X, params, kept=kept), params, chosen=chosen, kept=kept_hidden)
    sparsity = sum(weight * nn.l1(params[name]) / params[name].size
                   for name, weight in SPARSITY.items())
    return nn.squared_error(again, X, reduction="mean") + sparsity


def autoencoder_loss_backward(dloss: Any, X: np.ndarray, params: Params, *,
                              kept: np.ndarray | None = None, chosen: np.ndarray | None = None,
                              kept_hidden: np.ndarray | None = None) -> tuple[np.ndarray, Params]:
    """dloss : scalar  ->  dX (as input and as what is wanted), gradients with the keys of params"""
    H = encode(X, params, kept=kept)
    again = decode(H, params, chosen=chosen, kept=kept_hidden)
    d_again, dX = nn.squared_error_backward(dloss, again, X, reduction="mean")
    dH, gradients = decode_backward(d_again, H, params, chosen=chosen, kept=kept_hidden)
    d_input, of_encoder = encode_backward(dH, X, params, kept=kept)
    gradients = {**of_encoder, **gradients}
    for name, weight in SPARSITY.items():
        W = params[name]
        gradients[name] = gradients[name] + nn.l1_backward(dloss * W.dtype.type(weight / W.size), W)
    return dX + d_input, gradients
