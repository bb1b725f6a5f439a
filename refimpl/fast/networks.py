"""The functions of `holden2017.networks` to hand in where a program takes `networks`: encode,
decode and its gradient, transformation, project.

`transformation` and `project` keep the spectra of the last few networks they were called with, and
notice when a filter has changed.
"""

import numpy as np

from .. import nn
from ..holden2017.networks import Params
from .conv import conv1d, conv_transpose1d
from .stylist import Stylist

KEPT = 4                                                         # networks
LONG = 1 << 16     # frames: of longer ones nothing is kept, since plans and spectra take 130 MB
_kept: list[tuple[dict[str, np.ndarray], Stylist]] = []


def encode(X: np.ndarray, params: Params) -> np.ndarray:
    """`holden2017.networks.encode`.   (N, 66, T)  ->  (N, m, T // 2)"""
    return nn.relu(nn.max_pool1d(conv1d(X, params["W0"], params["b0"])))


def decode(H: np.ndarray, params: Params) -> np.ndarray:
    """`holden2017.networks.decode` with average-depooling.   (N, m, T)  ->  (N, 66, 2 T)"""
    D = nn.avg_depool1d(H)
    if "V0" in params:
        return conv_transpose1d(D, params["V0"], params["c0"])
    return conv_transpose1d(D - params["b0"][:, None], params["W0"])


def decode_backward_to_input(dX: np.ndarray, H: np.ndarray, params: Params) -> np.ndarray:
    """`holden2017.networks.decode_backward_to_input`.   (N, 66, 2 T), (N, m, T)  ->  (N, m, T)"""
    return nn.avg_depool1d_backward(conv1d(dX, params.get("V0", params["W0"])), H)


def transformation(X: np.ndarray, params: Params) -> np.ndarray:
    """`holden2017.networks.transformation`.   (N, 66, T)  ->  (N, 66, T)"""
    return _finished(X, _stylist(params).transform(X))


def project(X: np.ndarray, params: Params) -> np.ndarray:
    """`holden2017.networks.project`.   (N, 66, T)  ->  (N, 66, T)"""
    return _finished(X, _stylist(params).project(X))


def _finished(X, result):
    if X.shape[2] > LONG:
        _kept.clear()
    return result


def _stylist(params: Params) -> Stylist:
    """The stylist of a network, made at the first call with these very numbers."""
    for copy, stylist in _kept:
        if copy.keys() == params.keys() and all(
                np.array_equal(copy[name], p) and copy[name].dtype == p.dtype
                for name, p in params.items()):
            return stylist
    own = {name: p.copy() for name, p in params.items()}
    stylist = Stylist(own, None) if "W1" in own else Stylist(None, own)
    _kept[:] = [(own, stylist), *_kept[:KEPT - 1]]
    return stylist
