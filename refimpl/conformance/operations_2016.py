"""Records of the 2016 code's network and losses, as functions of arrays alone, and their second
derivation."""

from typing import Any

import numpy as np

from ..holden2016 import losses, network
from ..holden2016.rows import NUMBERS, POSITIONS, TRAJECTORY, TURN
from ..motion.joints import FEET
from . import definitions_nn as plain
from .specification import Operation, Sample

KEPT_SHARE = 0.75


# The reference, with dicts of parameters spelled out.

def encode(X: np.ndarray, We: np.ndarray, be: np.ndarray, *,
           kept: np.ndarray | None = None) -> np.ndarray:
    """The encoder of the 2016 code:   H = max_pool1d(relu(conv1d(X kept / 0.75, We, be)), 2)

    X : (N, C, T), We : (m, C, K), be : (m,);  kept : (N, C, T) of 0 and 1; without it X goes in as
    it is   ->  (N, m, T // 2)
    """
    return network.encode(X, {"We": We, "be": be}, kept=kept)


def encode_backward(dH: np.ndarray, X: np.ndarray, We: np.ndarray, be: np.ndarray, *,
                    kept: np.ndarray | None = None) -> tuple[np.ndarray, ...]:
    """dH : (N, m, T // 2)  ->  dX (N, C, T), dWe (m, C, K), dbe (m,)"""
    dX, g = network.encode_backward(dH, X, {"We": We, "be": be}, kept=kept)
    return dX, g["We"], g["be"]


def decode(H: np.ndarray, Wd: np.ndarray, bd: np.ndarray, *, chosen: np.ndarray | None = None,
           kept: np.ndarray | None = None) -> np.ndarray:
    """The decoder of the 2016 code, whose filters are its own:

        X = conv1d(avg_depool1d(H, 2) kept / 0.75, Wd, bd)

    H : (N, m, U), Wd : (C, m, K), bd : (C,);  chosen : (N, m, U) of 0 and 1, with which
    random_depool1d(H, chosen, 2) stands in the place of avg_depool1d;  kept : (N, m, 2 U) of 0 and
    1, without it nothing is dropped   ->  (N, C, 2 U)
    """
    return network.decode(H, {"Wd": Wd, "bd": bd}, chosen=chosen, kept=kept)


def decode_backward(dX: np.ndarray, H: np.ndarray, Wd: np.ndarray, bd: np.ndarray, *,
                    chosen: np.ndarray | None = None,
                    kept: np.ndarray | None = None) -> tuple[np.ndarray, ...]:
    """dX : (N, C, 2 U)  ->  dH (N, m, U), dWd (C, m, K), dbd (C,)"""
    dH, g = network.decode_backward(dX, H, {"Wd": Wd, "bd": bd}, chosen=chosen, kept=kept)
    return dH, g["Wd"], g["bd"]


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


def autoencoder_loss_backward(dloss: Any, X: np.ndarray, We: np.ndarray, be: np.ndarray,
                              Wd: np.ndarray, bd: np.ndarray, *, kept: np.ndarray | None = None,
                              chosen: np.ndarray | None = None,
                              kept_hidden: np.ndarray | None = None) -> tuple[np.ndarray, ...]:
    """dloss : scalar  ->  dX (N, C, T), as input and as what is wanted, dWe, dbe, dWd, dbd"""
    params = {"We": We, "be": be, "Wd": Wd, "bd": bd}
    dX, g = network.autoencoder_loss_backward(dloss, X, params, kept=kept, chosen=chosen,
                                              kept_hidden=kept_hidden)
    return (dX, *(g[name] for name in params))


# The second derivation: loops over frames, feet and bones of the 73 rows.

def dropped(x: np.ndarray, kept: np.ndarray | None) -> np.ndarray:
    return x if kept is None else np.where(np.asarray(kept) == 1, x / KEPT_SHARE, 0)


def encode_definition(X: np.ndarray, We: np.ndarray, be: np.ndarray, *,
                      kept: np.ndarray | None = None) -> np.ndarray:
    return plain.max_pool1d(plain.relu(plain.conv1d(dropped(X, kept), We, be)))


def decode_definition(H: np.ndarray, Wd: np.ndarray, bd: np.ndarray, *,
                      chosen: np.ndarray | None = None,
                      kept: np.ndarray | None = None) -> np.ndarray:
    D = plain.avg_depool1d(H) if chosen is None else plain.random_depool1d(H, chosen)
    return plain.conv1d(dropped(D, kept), Wd, bd)


def autoencoder_loss_definition(
        X: np.ndarray, We: np.ndarray, be: np.ndarray, Wd: np.ndarray, bd: np.ndarray, *,
        kept: np.ndarray | None = None, chosen: np.ndarray | None = None,
        kept_hidden: np.ndarray | None = None) -> np.ndarray:
    again = decode_definition(encode_definition(X, We, be, kept=kept), Wd, bd, chosen=chosen,
                              kept=kept_hidden)
    squares = ((again - X) ** 2).ravel()
    filters = [(0.01 / 5 / 2, We), (0.01 / 4 / 2, Wd)]
    return np.asarray(
        sum(squares) / len(squares) + sum(share * sum(abs(w) for w in W.ravel()) / W.size
                                          for share, W in filters))


def foot_loss_definition(motion: np.ndarray, contacts: np.ndarray) -> np.ndarray:
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


def bone_loss_definition(motion: np.ndarray) -> np.ndarray:
    parents = [0, 1, 2, 3, 0, 5, 6, 7, 0, 9, 10, 11, 11, 13, 14, 15, 11, 17, 18, 19]
    N, _, T = motion.shape
    result = np.zeros(N, motion.dtype)
    for n, t in np.ndindex(N, T):
        points = [motion[n, 3 + 3 * j:6 + 3 * j, t] for j in range(21)]
        for joint, (parent, length) in enumerate(zip(parents, losses.LENGTHS), start=1):
            bone = points[joint] - points[parent]
            result[n] += (np.sqrt(np.sum(bone * bone)) - length) ** 2 / (20 * T)
    return result


def trajectory_loss_definition(motion: np.ndarray, *, wanted: np.ndarray) -> np.ndarray:
    return np.array([
        10 * sum((m[66 + i, t] - w[i, t])**2 for i in range(3)
                 for t in range(w.shape[1])) / (3 * w.shape[1]) for m, w in zip(motion, wanted)])


def search_loss_definition(H: np.ndarray, *, content: np.ndarray, gram: np.ndarray,
                           amount: float = 0.1) -> np.ndarray:
    return np.array([(amount * ((G - plain.gram(h[None])[0]) ** 2).mean() + ((C - h) ** 2).mean())
                     / (amount + 1) for h, C, G in zip(H, content, gram)])


def search_loss(H: np.ndarray, *, content: np.ndarray, gram: np.ndarray,
                amount: float = 0.1) -> np.ndarray:
    """The first search of the 2016 code, which is about hidden units:

        (amount mean_squares(gram - H H^T) + mean_squares(content - H)) / (1 + amount)

    H, content : (N, m, U), gram : (N, m, m)   ->  (N,)
    """
    return losses.search_loss(H, content, gram, amount=amount)


def search_loss_backward(dloss: np.ndarray, H: np.ndarray, *, content: np.ndarray, gram: np.ndarray,
                         amount: float = 0.1) -> np.ndarray:
    """dloss : (N,)  ->  dH (N, m, U)"""
    return losses.search_loss_backward(dloss, H, content, gram, amount=amount)


def trajectory_loss(motion: np.ndarray, *, wanted: np.ndarray) -> np.ndarray:
    """Ten times the mean of the squares of rows 66 to 68 minus `wanted`.

    motion : (N, 73, T), wanted : (N, 3, T)   ->  (N,)
    """
    return losses.trajectory_loss(motion, wanted)


def trajectory_loss_backward(dloss: np.ndarray, motion: np.ndarray, *,
                             wanted: np.ndarray) -> np.ndarray:
    """dloss : (N,)  ->  dmotion (N, 73, T)"""
    return losses.trajectory_loss_backward(dloss, motion, wanted)


# Inputs.

def encode_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    return [
        Sample("plain", (n((2, 4, 8)), n((5, 4, 3)), n(5))),
        Sample("a frame left over", (n((1, 3, 7)), n((4, 3, 5)), n(4))),
        Sample("with dropout", (n((2, 4, 8)), n((5, 4, 3)), n(5)),
               {"kept": rng.integers(2, size=(2, 4, 8))}),
        Sample(
            "all units at their kink", (np.zeros((1, 3, 4)), n((4, 3, 5)), np.zeros(4)),
            smooth=False, known={
                "outputs": (np.zeros((1, 4, 2)),), "upstream": n((1, 4, 2)),
                "gradients": (np.zeros((1, 3, 4)), np.zeros((4, 3, 5)), np.zeros(4))})]


def decode_samples(rng: np.random.Generator) -> list[Sample]:
    n, arrays = rng.standard_normal, (rng.standard_normal((2, 5, 4)), rng.standard_normal(
        (4, 5, 3)))
    return [Sample("plain", (*arrays, n(4))),
            Sample("one hidden frame", (n((1, 4, 1)), n((3, 4, 5)), n(3))),
            Sample("by chance", (*arrays, n(4)), {"chosen": rng.integers(2, size=(2, 5, 4)),
                                                  "kept": rng.integers(2, size=(2, 5, 8))})]


def autoencoder_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    arrays = (n((2, 4, 8)), n((5, 4, 3)), n(5), n((4, 5, 3)), n(4))
    return [Sample("plain", arrays),
            Sample("by chance", arrays, {"kept": rng.integers(2, size=(2, 4, 8)),
                                         "chosen": rng.integers(2, size=(2, 5, 4)),
                                         "kept_hidden": rng.integers(2, size=(2, 5, 8))})]


def rows_of_motion(rng: np.random.Generator, clips: int = 2, frames: int = 4) -> np.ndarray:
    motion = rng.standard_normal((clips, NUMBERS, frames)) * 5
    motion[:, TURN] *= 0.1
    return motion


def foot_samples(rng: np.random.Generator) -> list[Sample]:
    return [Sample("plain", (rows_of_motion(rng), rng.random((2, 4, 4)) < 0.6)),
            Sample("no contact, the floor alone", (rows_of_motion(rng), np.zeros((2, 4, 4), bool))),
            Sample("one frame", (rows_of_motion(rng, frames=1), np.ones((2, 4, 1), bool)))]


def bone_samples(rng: np.random.Generator) -> list[Sample]:
    still = np.zeros((1, NUMBERS, 2))
    zero = {"outputs": (np.array([np.mean(losses.LENGTHS ** 2)]),), "upstream": np.array([3.0]),
            "gradients": (still,)}
    return [Sample("plain", (rows_of_motion(rng),)),
            Sample("bones of length 0", (still,), smooth=False, known=zero)]


def trajectory_samples(rng: np.random.Generator) -> list[Sample]:
    return [Sample("plain", (rows_of_motion(rng),), {"wanted": rng.standard_normal((2, 3, 4))})]


def search_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    root = n((2, 3, 6))
    constants = {"content": n((2, 3, 4)), "gram": root @ root.swapaxes(1, 2)}
    return [Sample("as in the code", (n((2, 3, 4)),), constants),
            Sample("more style", (n((2, 3, 4)),), {**constants, "amount": 3.0})]


OPERATIONS = (Operation("encode_2016", ("X", "We", "be"), encode, encode_backward,
                        encode_definition, encode_samples, equation="the 2016 code, encoder"),
              Operation("decode_2016", ("H", "Wd", "bd"), decode, decode_backward,
                        decode_definition, decode_samples, equation="the 2016 code, decoder"),
              Operation("autoencoder_loss_2016", ("X", "We", "be", "Wd", "bd"), autoencoder_loss,
                        autoencoder_loss_backward, autoencoder_loss_definition, autoencoder_samples,
                        batched=(), equation="the 2016 code, training"),
              Operation("foot_loss_2016", ("motion", "contacts"), losses.foot_loss,
                        losses.foot_loss_backward, foot_loss_definition, foot_samples,
                        batched=(0, 1), equation="the 2016 code, feet"),
              Operation("bone_loss_2016", ("motion",), losses.bone_loss, losses.bone_loss_backward,
                        bone_loss_definition, bone_samples, equation="the 2016 code, bones"),
              Operation("trajectory_loss_2016", ("motion",), trajectory_loss,
                        trajectory_loss_backward, trajectory_loss_definition, trajectory_samples,
                        batched=(), equation="the 2016 code, path"),
              Operation("search_loss_2016", ("H",), search_loss, search_loss_backward,
                        search_loss_definition, search_samples, batched=(),
                        equation="the 2016 code, search"),
              )
