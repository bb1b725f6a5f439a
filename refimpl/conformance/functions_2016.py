"""The reference for the 2016 code's network and losses as functions of arrays alone: what a backend
offers under these names, with "_2016" behind each.
"""

from typing import Any

import numpy as np

from ..holden2016 import losses, network
from .functions_holden import spelled_out


def encode(X: np.ndarray, We: np.ndarray, be: np.ndarray, *,
           kept: np.ndarray | None = None) -> np.ndarray:
    """The encoder of the 2016 code:   H = max_pool1d(relu(conv1d(X kept / 0.75, We, be)), 2)

    X : (N, C, T), We : (m, C, K), be : (m,);  kept : (N, C, T) of 0 and 1; without it X goes in as
    it is   ->  (N, m, T // 2)
    """
    return network.encode(X, {"We": We, "be": be}, kept=kept)


encode_backward = spelled_out(
    network.encode_backward, "We be",
    "dH : (N, m, T // 2)  ->  dX (N, C, T), dWe (m, C, K), dbe (m,)")


def decode(H: np.ndarray, Wd: np.ndarray, bd: np.ndarray, *, chosen: np.ndarray | None = None,
           kept: np.ndarray | None = None) -> np.ndarray:
    """The decoder of the 2016 code, whose filters are its own:

        X = conv1d(avg_depool1d(H, 2) kept / 0.75, Wd, bd)

    H : (N, m, U), Wd : (C, m, K), bd : (C,);  chosen : (N, m, U) of 0 and 1, with which
    random_depool1d(H, chosen, 2) stands in the place of avg_depool1d;  kept : (N, m, 2 U) of 0 and
    1, without it nothing is dropped   ->  (N, C, 2 U)
    """
    return network.decode(H, {"Wd": Wd, "bd": bd}, chosen=chosen, kept=kept)


decode_backward = spelled_out(
    network.decode_backward, "Wd bd",
    "dX : (N, C, 2 U)  ->  dH (N, m, U), dWd (C, m, K), dbd (C,)")


def autoencoder_loss(X: np.ndarray, We: np.ndarray, be: np.ndarray, Wd: np.ndarray, bd: np.ndarray,
                     *, kept: np.ndarray | None = None, chosen: np.ndarray | None = None,
                     kept_hidden: np.ndarray | None = None) -> Any:
    """What the 2016 code's network learns by, of X encoded with `kept` and decoded with `chosen`
    and `kept_hidden`:

        mean_squares(decode_2016(encode_2016(X)) - X) + 0.001 mean |We| + 0.00125 mean |Wd|

    X : (N, C, T), T even, We : (m, C, K), be : (m,), Wd : (C, m, K), bd : (C,)   ->  scalar
    """
    params = {"We": We, "be": be, "Wd": Wd, "bd": bd}
    return network.autoencoder_loss(X, params, kept=kept, chosen=chosen, kept_hidden=kept_hidden)


autoencoder_loss_backward = spelled_out(
    network.autoencoder_loss_backward, "We be Wd bd",
    "dloss : scalar  ->  dX (N, C, T), as input and as what is wanted, dWe, dbe, dWd, dbd")


def trajectory_loss(motion: np.ndarray, *, wanted: np.ndarray) -> np.ndarray:
    """Ten times the mean of the squares of rows 66 to 68 minus `wanted`.

    motion : (N, 73, T), wanted : (N, 3, T)   ->  (N,)
    """
    return losses.trajectory_loss(motion, wanted)


trajectory_loss_backward = losses.trajectory_loss_backward


def search_loss(H: np.ndarray, *, content: np.ndarray, gram: np.ndarray,
                amount: float = 0.1) -> np.ndarray:
    """The first search of the 2016 code, which is about hidden units:

        (amount mean_squares(gram - H H^T) + mean_squares(content - H)) / (1 + amount)

    H, content : (N, m, U), gram : (N, m, m)   ->  (N,)
    """
    return losses.search_loss(H, content, gram, amount=amount)


search_loss_backward = losses.search_loss_backward
