"""The reference for the 2016 code's network and losses as functions of arrays alone: what a backend
offers under these names, with "_2016" behind each.
"""

from typing import Any

from .. import nn
from ..holden2016 import losses, network, rows, search, train
from ..holden2017.train import State
from .dealt import draws_of, said, trained
from .functions_holden import spelled_out
from .specification import Array


def encode(X: Array, We: Array, be: Array, *, kept: Array | None = None) -> Array:
    """The encoder of the 2016 code:   H = max_pool1d(relu(conv1d(X kept / 0.75, We, be)), 2)

    X : (N, C, T), We : (m, C, K), be : (m,);  kept : (N, C, T) of 0 and 1; without it X goes in as
    it is   ->  (N, m, T // 2)
    """
    return network.encode(X, {"We": We, "be": be}, kept=kept)


encode_backward = spelled_out(network.encode_backward, "We be",
                              "dH : (N, m, T // 2)  ->  dX (N, C, T), dWe (m, C, K), dbe (m,)")


def decode(H: Array, Wd: Array, bd: Array, *, chosen: Array | None = None,
           kept: Array | None = None) -> Array:
    """The decoder of the 2016 code, whose filters are its own:

        X = conv1d(avg_depool1d(H, 2) kept / 0.75, Wd, bd)

    H : (N, m, U), Wd : (C, m, K), bd : (C,);  chosen : (N, m, U) of 0 and 1, with which
    random_depool1d(H, chosen, 2) stands in the place of avg_depool1d;  kept : (N, m, 2 U) of 0 and
    1, without it nothing is dropped   ->  (N, C, 2 U)
    """
    return network.decode(H, {"Wd": Wd, "bd": bd}, chosen=chosen, kept=kept)


decode_backward = spelled_out(network.decode_backward, "Wd bd",
                              "dX : (N, C, 2 U)  ->  dH (N, m, U), dWd (C, m, K), dbd (C,)")


def autoencoder_loss(X: Array, We: Array, be: Array, Wd: Array, bd: Array,
                     *, kept: Array | None = None, chosen: Array | None = None,
                     kept_hidden: Array | None = None) -> Any:
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


def trajectory_loss(motion: Array, *, wanted: Array) -> Array:
    """Ten times the mean of the squares of rows 66 to 68 minus `wanted`.

    motion : (N, 73, T), wanted : (N, 3, T)   ->  (N,)
    """
    return losses.trajectory_loss(motion, wanted)


trajectory_loss_backward = losses.trajectory_loss_backward


def search_loss(H: Array, *, content: Array, gram: Array, amount: float = 0.1) -> Array:
    """The first search of the 2016 code, which is about hidden units:

        (amount mean_squares(gram - H H^T) + mean_squares(content - H)) / (1 + amount)

    H, content : (N, m, U), gram : (N, m, m)   ->  (N,)
    """
    return losses.search_loss(H, content, gram, amount=amount)


search_loss_backward = losses.search_loss_backward


def constraint_loss(motion: Array, *, contacts: Array, wanted: Array) -> Array:
    """(foot_loss_2016 + bone_loss_2016 + trajectory_loss_2016) / 3.

    motion : (N, 73, T), contacts : (N, 4, T) of 0 and 1, wanted : (N, 3, T)   ->  (N,)
    """
    return losses.constraint_loss(motion, contacts, wanted)


def constraint_loss_backward(dloss: Array, motion: Array, *, contacts: Array,
                             wanted: Array) -> Array:
    """dloss : (N,)  ->  dmotion (N, 73, T)"""
    return losses.constraint_loss_backward(dloss, motion, contacts, wanted)


def motion_to_rows(positions: Array) -> Array:
    """The 73 numbers of the 2016 code, of all frames but the last: three zeros, 21 joints x, y, z,
    sideways and forward velocity, turning, contacts. As `motion_to_numbers` has them, but

        floor = h - ln(1/2 + exp(h - H)),   h, H the least and the largest height of the lower toe

    across is of length 1 in space before it is turned into forward and smoothed; turning has the
    other sign; a foot is planted where |p[t+1] - p[t]|^2 < 0.05 and y[t] - floor < 3 (heels) or 2
    (toes).

    positions : (T, 21, 3), y up, in the code's unit, 60 frames a second   ->  (T - 1, 73)
    """
    return rows.encode(positions)


def rows_to_motion(motion: Array) -> Array:
    """The way back, from place and heading 0:

        yaw[t+1] = yaw[t] - turn[t],   root[t+1] = root[t] + Y(yaw[t+1]) v[t]

    motion : (T, 73)   ->  (T, 22, 3), the first three numbers as a joint in front of the 21
    """
    return rows.decode(motion)


def row_windows(motion: Array, *, length: int | None = None, step: int | None = None) -> Array:
    """One window begins every `step` rows while more than 30 are left. What is missing of its
    length is made up by the first and the last row of what there is, the odd one in front, with
    velocities and turning 0.

    motion : (T, 73);  length, step : 240 and 120 unless given   ->  (N, length, 73)
    """
    return rows.windows(motion, **said(length=length, step=step))


def row_normaliser(windows: Array) -> tuple[Array, Array]:
    """Mean of each number, 0 for velocities and turning and 1/2 for contacts. Deviation (of the
    population): of all numbers of all rows together, 0.9 of it for the twelve numbers of the foot
    joints, 0.9 of that of both velocities together, 0.9 of that of the turning, 1/2 for contacts;
    the largest of these where one is 0.

    windows : (N, T, 73)   ->  (73,), (73,)
    """
    found = rows.fit_normaliser(windows)
    return found.mean, found.deviation


def train_network(We: Array, be: Array, Wd: Array, bd: Array, *, X: Array, order: Array,
                  batch: int, rate: float, kept: Array | None = None, chosen: Array | None = None,
                  kept_hidden: Array | None = None) -> tuple[Array, ...]:
    """Training on autoencoder_loss_2016 by Adam (0.9, 0.999, 1e-8) at one rate. Epoch e visits the
    windows in the order order[e], `batch` at a time, the last batch as small as it comes.

    We ... bd : as for autoencoder_loss_2016;  X : (N, C, T), T even;  order : (epochs, N) whole
    numbers;  kept (epochs, N, C, T), chosen (epochs, N, m, T // 2), kept_hidden (epochs, N, m, T)
    of 0 and 1, by epoch and number of the window, all or none
    ->  We, be, Wd, bd, and the mean of each epoch's losses of its batches, as the parameters were
    when they were computed
    """
    params = {"We": We, "be": be, "Wd": Wd, "bd": bd}
    parts = [] if kept is None or chosen is None or kept_hidden is None else [
        kept, chosen, kept_hidden]
    return trained(train.train(
        X, epochs=len(order), batch=batch, rate=rate, width=We.shape[2], chance=bool(parts),
        state=State(params, nn.adam_start(params), 0), draws=draws_of(order, *parts)), We.dtype)


def project(X: Array, We: Array, be: Array, Wd: Array, bd: Array) -> Array:
    """decode_2016(encode_2016(X)).   X : (N, C, T), T even   ->  (N, C, T)"""
    return network.project(X, {"We": We, "be": be, "Wd": Wd, "bd": bd})


def joined_windows(windows: Array) -> Array:
    """Rows 60 to 179 of each window, one after the other.

    windows : (N, 240, 73)   ->  (120 N, 73)
    """
    return search.join(windows)


def constrained_loss(H: Array, Wd: Array, bd: Array, *, contacts: Array,
                     wanted: Array, mean: Array, deviation: Array) -> Array:
    """constraint_loss_2016 of decode_2016(H) deviation + mean.

    H : (N, m, U), Wd : (73, m, K), bd : (73,);  contacts : (N, 4, 2 U), wanted : (N, 3, 2 U);
    mean, deviation : (73,)   ->  (N,)
    """
    return search.constrained_loss(H, {"Wd": Wd, "bd": bd}, rows.Normaliser(mean, deviation),
                                   contacts, wanted)
