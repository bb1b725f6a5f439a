"""The 2016 code's network and losses a second time: loops over frames, feet and bones of its 73
rows, on top of `definitions_nn`.
"""

import math
import numpy as np

from ..holden2016 import losses
from ..holden2016.rows import POSITIONS, TRAJECTORY, TURN
from ..motion.joints import FEET
from . import definitions_nn as plain, definitions_smooth as smooth, functions_2016
from .specification import Array

KEPT_SHARE = 0.75
PARENTS = (0, 1, 2, 3, 0, 5, 6, 7, 0, 9, 10, 11, 11, 13, 14, 15, 11, 17, 18, 19)   # of joints 1 ...


def dropped(x: Array, kept: Array | None) -> Array:
    """Dropout: what is kept, divided by the share that is kept on average."""
    return x if kept is None else np.where(np.asarray(kept) == 1, x / KEPT_SHARE, 0)


def encode(X: Array, We: Array, be: Array, *, kept: Array | None = None) -> Array:
    """Dropout, filters, bias, relu, the larger of two frames."""
    return plain.max_pool1d(plain.relu(plain.conv1d(dropped(X, kept), We, be)))


def decode(H: Array, Wd: Array, bd: Array, *, chosen: Array | None = None,
           kept: Array | None = None) -> Array:
    """Depooling, dropout, filters of its own, bias."""
    D = plain.avg_depool1d(H) if chosen is None else plain.random_depool1d(H, chosen)
    return plain.conv1d(dropped(D, kept), Wd, bd)


def autoencoder_loss(X: Array, We: Array, be: Array, Wd: Array, bd: Array,
                     *, kept: Array | None = None, chosen: Array | None = None,
                     kept_hidden: Array | None = None) -> Array:
    """The mean squared error, and a share of the mean size of both filters, element by element."""
    again = decode(encode(X, We, be, kept=kept), Wd, bd, chosen=chosen, kept=kept_hidden)
    squares = ((again - X) ** 2).ravel()
    filters = [(0.01 / 5 / 2, We), (0.01 / 4 / 2, Wd)]
    return np.asarray(sum(squares) / len(squares)
                      + sum(share * sum(plain.size_of(w) for w in W.ravel()) / W.size
                            for share, W in filters))


def foot_loss(motion: Array, contacts: Array) -> Array:
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


def bone_loss(motion: Array) -> Array:
    """The mean squared error of length, one bone and one frame at a time."""
    N, _, T = motion.shape
    result = np.zeros(N, motion.dtype)
    for n, t in np.ndindex(N, T):
        points = motion[n, POSITIONS, t].reshape(-1, 3)
        for joint, (parent, length) in enumerate(zip(PARENTS, losses.LENGTHS), start=1):
            bone = points[joint] - points[parent]
            result[n] += (np.sqrt(np.sum(bone * bone)) - length) ** 2 / (20 * T)
    return result


def trajectory_loss(motion: Array, *, wanted: Array) -> Array:
    """Ten times the mean squared error of three rows, one element at a time."""
    return np.array([10 * sum((m[TRAJECTORY.start + i, t] - w[i, t]) ** 2
                              for i, t in np.ndindex(w.shape)) / w.size
                     for m, w in zip(motion, wanted)])


def search_loss(H: Array, *, content: Array, gram: Array, amount: float = 0.1) -> Array:
    """The weighted mean of two mean squared errors, one clip at a time."""
    return np.array([(amount * ((G - plain.gram(h[None])[0]) ** 2).mean() + ((C - h) ** 2).mean())
                     / (amount + 1) for h, C, G in zip(H, content, gram)])


def constraint_loss(motion: Array, *, contacts: Array, wanted: Array) -> Array:
    """The mean of the three, each in its own loops."""
    return (foot_loss(motion, contacts) + bone_loss(motion)
            + trajectory_loss(motion, wanted=wanted)) / 3


def motion_to_rows(positions: Array) -> Array:
    """One joint of one frame at a time."""
    T = len(positions)
    lowest = [min(frame[FEET[1]][1], frame[FEET[3]][1]) for frame in positions]
    floor = min(lowest) - math.log(0.5 + math.exp(min(lowest) - max(lowest)))
    ahead = []
    for frame in positions:
        across = smooth.across(frame)
        ahead.append(np.cross(across / math.hypot(*across), [0.0, 1.0, 0.0])[[0, 2]])
    yaw = [math.atan2(x, z) for x, z in smooth.smoothed(np.array(ahead), 20.0)]
    root = [np.array([x, floor, z]) for x, _, z in smooth.smoothed(positions[:, 0], 3.0)]
    found = np.zeros((T - 1, 73))
    for t in range(T - 1):
        here = [smooth.turned(p - root[t], -yaw[t]) for p in positions[t]]
        sideways, _, forward = smooth.turned(root[t + 1] - root[t], -yaw[t + 1])
        turn = math.remainder(yaw[t] - yaw[t + 1], 2 * math.pi)
        planted = [math.dist(positions[t, foot], positions[t + 1, foot]) ** 2 < 0.05
                   and positions[t, foot, 1] - floor < (3, 2)[number % 2]
                   for number, foot in enumerate(FEET)]
        found[t] = [0, 0, 0, *np.concatenate(here), sideways, forward, turn, *planted]
    return found


def rows_to_motion(motion: Array) -> Array:
    """One frame after the other."""
    root, yaw, found = np.zeros(3), 0.0, []
    for row in motion:
        found.append([root + smooth.turned(row[3 * j:3 * j + 3], yaw) for j in range(22)])
        yaw = yaw - row[68]
        root = root + smooth.turned([row[66], 0.0, row[67]], yaw)
    return np.array(found)


def row_windows(motion: Array, *, length: int = 240, step: int = 120) -> Array:
    """One row of one window at a time."""
    T, found = len(motion), []
    for begin in (t for t in range(T) if t % step == 0 and T - t > 30):
        last = min(begin + length, T) - 1
        before = math.ceil((length - (last + 1 - begin)) / 2)
        window = []
        for t in range(begin - before, begin - before + length):
            row = motion[min(max(t, begin), last)].copy()
            if not begin <= t <= last:
                row[66:69] = 0.0
            window.append(row)
        found.append(window)
    return np.array(found).reshape(-1, length, 73)


def row_normaliser(windows: Array) -> tuple[Array, Array]:
    """Sums over all rows, number by number."""
    rows = [row for window in windows for row in window]

    mean = [sum(row[i] for row in rows) / len(rows) for i in range(66)]
    whole = smooth.deviation_of(v for row in rows for v in row)
    feet = {3 + 3 * foot + axis for foot in FEET for axis in range(3)}
    deviation = [whole * (0.9 if i in feet else 1.0) for i in range(66)]
    deviation += [0.9 * smooth.deviation_of(v for row in rows for v in row[66:68])] * 2
    deviation += [0.9 * smooth.deviation_of(row[68] for row in rows)] + [0.5] * 4
    return (np.array([*mean, 0, 0, 0, 0.5, 0.5, 0.5, 0.5]),
            np.array([d or max(deviation) for d in deviation]))


def train_network(We: Array, be: Array, Wd: Array, bd: Array, *, X: Array,
                  order: Array, batch: int, rate: float, **chances: Array) -> tuple[Array, ...]:
    """The loss and its gradient, of each batch."""
    def _of(arrays, indices, epoch):
        own = {name: given[epoch, indices] for name, given in chances.items()}
        return (autoencoder_loss(X[indices], *arrays, **own),
                functions_2016.autoencoder_loss_backward(1.0, X[indices], *arrays, **own)[1:])
    return smooth.trained((We, be, Wd, bd), order, batch, [rate] * len(order), _of, lambda _: 1)


def project(X: Array, We: Array, be: Array, Wd: Array, bd: Array) -> Array:
    """There and back."""
    return decode(encode(X, We, be), Wd, bd)


def joined_windows(windows: Array) -> Array:
    """One row after the other."""
    return np.array([window[t] for window in windows for t in range(60, 180)])


def constrained_loss(H: Array, Wd: Array, bd: Array, *, mean: Array,
                     deviation: Array, **targets: Array) -> Array:
    """The decoded motion's."""
    return constraint_loss(decode(H, Wd, bd) * deviation[:, None] + mean[:, None], **targets)
