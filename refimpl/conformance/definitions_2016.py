"""The 2016 code's network and losses a second time: loops over frames, feet and bones of its 73
rows, on top of `definitions_nn`.
"""

import numpy as np

from ..holden2016 import losses
from ..holden2016.rows import POSITIONS, TRAJECTORY, TURN
from ..motion.joints import FEET
from . import definitions_nn as plain

KEPT_SHARE = 0.75
PARENTS = (0, 1, 2, 3, 0, 5, 6, 7, 0, 9, 10, 11, 11, 13, 14, 15, 11, 17, 18, 19)   # of joints 1 ...


def dropped(x: np.ndarray, kept: np.ndarray | None) -> np.ndarray:
    """Dropout: what is kept, divided by the share that is kept on average."""
    return x if kept is None else np.where(np.asarray(kept) == 1, x / KEPT_SHARE, 0)


def encode(X: np.ndarray, We: np.ndarray, be: np.ndarray, *,
           kept: np.ndarray | None = None) -> np.ndarray:
    """Dropout, filters, bias, relu, the larger of two frames."""
    return plain.max_pool1d(plain.relu(plain.conv1d(dropped(X, kept), We, be)))


def decode(H: np.ndarray, Wd: np.ndarray, bd: np.ndarray, *, chosen: np.ndarray | None = None,
           kept: np.ndarray | None = None) -> np.ndarray:
    """Depooling, dropout, filters of its own, bias."""
    D = plain.avg_depool1d(H) if chosen is None else plain.random_depool1d(H, chosen)
    return plain.conv1d(dropped(D, kept), Wd, bd)


def autoencoder_loss(X: np.ndarray, We: np.ndarray, be: np.ndarray, Wd: np.ndarray, bd: np.ndarray,
                     *, kept: np.ndarray | None = None, chosen: np.ndarray | None = None,
                     kept_hidden: np.ndarray | None = None) -> np.ndarray:
    """The mean squared error, and a share of the mean size of both filters, element by element."""
    again = decode(encode(X, We, be, kept=kept), Wd, bd, chosen=chosen, kept=kept_hidden)
    squares = ((again - X) ** 2).ravel()
    filters = [(0.01 / 5 / 2, We), (0.01 / 4 / 2, Wd)]
    return np.asarray(sum(squares) / len(squares)
                      + sum(share * sum(abs(w) for w in W.ravel()) / W.size
                            for share, W in filters))


def foot_loss(motion: np.ndarray, contacts: np.ndarray) -> np.ndarray:
    """One foot and one step at a time, with the turning's sign as row 68 has it."""
    N, _, T = motion.shape
    result, count = np.zeros(N, motion.dtype), 4 * max(T - 1, 1)
    for n, i, t in np.ndindex(N, 4, T - 1):
        row = POSITIONS.start + 3 * FEET[i]
        here, there = motion[n, row:row + 3, t], motion[n, row:row + 3, t + 1]
        if contacts[n, i, t]:
            about = np.array([0, -motion[n, TURN, t], 0])
            root = np.array([motion[n, TRAJECTORY.start, t], 0, motion[n, TRAJECTORY.start + 1, t]])
            v = root + np.cross(about, here) + there - here
            result[n] += 10 * np.sum(v * v) / count / 4
        if there[1].real < 0:
            result[n] += 10 * there[1] ** 2 / count / 4
    return result


def bone_loss(motion: np.ndarray) -> np.ndarray:
    """The mean squared error of length, one bone and one frame at a time."""
    N, _, T = motion.shape
    result = np.zeros(N, motion.dtype)
    for n, t in np.ndindex(N, T):
        points = motion[n, POSITIONS, t].reshape(-1, 3)
        for joint, (parent, length) in enumerate(zip(PARENTS, losses.LENGTHS), start=1):
            bone = points[joint] - points[parent]
            result[n] += (np.sqrt(np.sum(bone * bone)) - length) ** 2 / (20 * T)
    return result


def trajectory_loss(motion: np.ndarray, *, wanted: np.ndarray) -> np.ndarray:
    """Ten times the mean squared error of three rows, one element at a time."""
    return np.array([10 * sum((m[TRAJECTORY.start + i, t] - w[i, t]) ** 2
                              for i, t in np.ndindex(w.shape)) / w.size
                     for m, w in zip(motion, wanted)])


def search_loss(H: np.ndarray, *, content: np.ndarray, gram: np.ndarray,
                amount: float = 0.1) -> np.ndarray:
    """The weighted mean of two mean squared errors, one clip at a time."""
    return np.array([(amount * ((G - plain.gram(h[None])[0]) ** 2).mean() + ((C - h) ** 2).mean())
                     / (amount + 1) for h, C, G in zip(H, content, gram)])
