r"""The style transfer of the 2016 code (`demo_style_transfer.py`, `constrain`), statement by
statement.

1. The content is rows 60 to 179 of four successive windows, 480 frames; the style one window of
   240.
2. G = Gram(L(S)), not scaled to the content's frames.
3. H begins as L of noise, uniform within sqrt(6 / (73 + T)) of normalised units.
4. 250 steps of Adam on H, rate 0.01, epsilon 1e-5, down `losses.search_loss`. H may become
   negative.
5. L+(H), in units. The tail: the content's velocities, times the mean speed of the result over that
   of the content, the content's turning and contacts.
6. H = L(L+(H)): encoded again, which projects it. 100 steps down `losses.constraint_loss`, with the
   content's contacts and the tail's path.
7. L+(H); the last seven rows become the tail. There is no clean-up of the feet.

The paper of 2017 tells none of these numbers and steps; `docs/code_of_2016.md` has what each is
worth.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from .. import nn
from . import losses
from .network import Params, decode, encode
from .rows import CONTACTS, NUMBERS, TRAJECTORY, VELOCITY, Normaliser

AMOUNT = 0.1
ITERATIONS, CONSTRAINT_ITERATIONS = 250, 100
RATE, EPSILON = 0.01, 1e-5
KEPT = slice(60, 180)                                            # of each window that is joined

Watch = Callable[[str, int, float], None]


@dataclass(frozen=True)
class Found:
    """What a transfer went through, rows (T, 73) in units.

    result : with the tail
    after_style, before_tail : decoded after the first and after the second search
    """

    result: np.ndarray = field(repr=False)
    after_style: np.ndarray = field(repr=False)
    before_tail: np.ndarray = field(repr=False)


def join(windows: np.ndarray) -> np.ndarray:
    """The middles of successive windows, one after the other: since a window begins every 120 rows,
    the clip goes on without a gap.

    windows : (N, 240, 73)  ->  (120 N, 73)

    >>> join(np.zeros((4, 240, 73))).shape
    (480, 73)
    """
    return np.concatenate(list(windows[:, KEPT]))


def noise(rng: np.random.Generator, frames: int, numbers: int = NUMBERS) -> np.ndarray:
    """What the search begins at: uniform within sqrt(6 / (73 + frames)).   ->  (1, 73, frames)

    >>> noise(np.random.default_rng(0), 240).shape
    (1, 73, 240)
    """
    bound = np.sqrt(6 / (numbers + frames))
    return rng.uniform(-bound, bound, (1, numbers, frames))


def tail(content: np.ndarray, found: np.ndarray) -> np.ndarray:
    """The content's last seven rows, walked as fast as the result walks.

    content, found : (T, 73)  ->  (T, 7)

    >>> content, found = np.zeros((2, 4, 73))
    >>> content[:, VELOCITY], found[:, VELOCITY] = [0.0, 2.0], [3.0, 0.0]
    >>> tail(content, found)[0].tolist()
    [0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    """
    wanted, speed = (float(np.linalg.norm(rows[:, VELOCITY], axis=1).mean())
                     for rows in (found, content))
    rows = content[:, TRAJECTORY.start:].copy()
    rows[:, :2] *= wanted / speed if speed > 0 else 1.0          # a content may stand (a choice)
    return rows


def minimise(H: np.ndarray, loss: Callable | None, backward: Callable, iterations: int, *,
             rate: float | Callable[[int], float] = RATE, epsilon: float = EPSILON,
             watch: Watch | None = None, name: str = "search") -> np.ndarray:
    """Adam on hidden units (`constrain`, with an epsilon of its own).

    H : (1, m, U)
    loss : H -> (1,), for `watch` only
    backward : H -> dH
    rate : a number, or what gives one for a step from 1 on
    watch : called with the name, the iteration and its loss
    ->  H

    >>> round(float(minimise(np.ones((1, 1, 1)), None, lambda H: H, 1)[0, 0, 0]), 4)
    0.99
    """
    params, state = {"H": H}, nn.adam_start({"H": H})
    for iteration in range(iterations):
        if watch and loss:
            watch(name, iteration, float(loss(params["H"])[0]))
        params, state = nn.adam_step(params, {"H": backward(params["H"])}, state, epsilon=epsilon,
                                     rate=rate(iteration + 1) if callable(rate) else rate)
    return params["H"]


def decoded_motion(H: np.ndarray, params: Params, normaliser: Normaliser) -> np.ndarray:
    """L+(H) in units.   H : (N, m, U)  ->  (N, 73, 2 U)"""
    X = decode(H, params)
    mean, deviation = (a[:, None].astype(X.dtype) for a in (normaliser.mean, normaliser.deviation))
    return X * deviation + mean


def decoded_motion_backward(dmotion: np.ndarray, H: np.ndarray, params: Params,
                            normaliser: Normaliser) -> np.ndarray:
    """dmotion : (N, 73, 2 U)  ->  dH (N, m, U)"""
    dD = nn.conv_transpose1d(dmotion * normaliser.deviation[:, None].astype(H.dtype), params["Wd"])
    return nn.avg_depool1d_backward(dD, H)


def constrained_loss(H: np.ndarray, params: Params, normaliser: Normaliser, contacts: np.ndarray,
                     wanted: np.ndarray) -> np.ndarray:
    """`losses.constraint_loss` of the decoded motion, in units.

    H : (N, m, U), contacts : (N, 4, 2 U), wanted : (N, 3, 2 U)  ->  (N,)
    """
    return losses.constraint_loss(decoded_motion(H, params, normaliser), contacts, wanted)


def constrained_loss_backward(dloss: np.ndarray, H: np.ndarray, params: Params,
                              normaliser: Normaliser, contacts: np.ndarray,
                              wanted: np.ndarray) -> np.ndarray:
    """dloss : (N,)  ->  dH (N, m, U)"""
    motion = decoded_motion(H, params, normaliser)
    dmotion = losses.constraint_loss_backward(dloss, motion, contacts, wanted)
    return decoded_motion_backward(dmotion, H, params, normaliser)


def transfer(content: np.ndarray, style: np.ndarray, params: Params, normaliser: Normaliser, *,
             start: np.ndarray, amount: float = AMOUNT, iterations: int = ITERATIONS,
             constraint_iterations: int = CONSTRAINT_ITERATIONS,
             watch: Watch | None = None) -> Found:
    """The whole script.

    content : (T, 73), T even, rows in units
    style : (T_s, 73), T_s even, rows in units
    params : of `network`
    start : (1, 73, T) of `noise`
    watch : called with the search's name, the iteration and its loss
    Raises ValueError.
    """
    if start.shape != (1, NUMBERS, len(content)):
        raise ValueError(f"start: found shape {start.shape}, needed (1, {NUMBERS}, {len(content)})")
    for name, rows in (("content", content), ("style", style)):
        if rows.ndim != 2 or rows.shape[1] != NUMBERS or not len(rows) or len(rows) % 2:
            raise ValueError(f"{name}: found shape {rows.shape}, needed an even number of rows of "
                             f"{NUMBERS} numbers, for the pooling")
    dtype = params["We"].dtype
    C, S = (normaliser.apply(rows)[None].astype(dtype) for rows in (content, style))
    H_content, gram, one = encode(C, params), nn.gram(encode(S, params)), np.ones(1, dtype)
    H = minimise(encode(start.astype(dtype), params),
                 lambda H: losses.search_loss(H, H_content, gram, amount=amount),
                 lambda H: losses.search_loss_backward(one, H, H_content, gram, amount=amount),
                 iterations, watch=watch, name="style")
    X = decode(H, params)
    after_style = normaliser.undo(X[0])
    last = tail(content, after_style)
    contacts = content[:, CONTACTS].T[None].astype(dtype)
    wanted = last[:, :CONTACTS.start - TRAJECTORY.start].T[None].astype(dtype)
    H = minimise(encode(X, params),
                 lambda H: constrained_loss(H, params, normaliser, contacts, wanted),
                 lambda H: constrained_loss_backward(one, H, params, normaliser, contacts, wanted),
                 constraint_iterations, watch=watch, name="constraints")
    before_tail = normaliser.undo(decode(H, params)[0])
    result = before_tail.copy()
    result[:, TRAJECTORY.start:] = last
    return Found(result, after_style, before_tail)
