r"""The five losses of Holden et al. 2017, each with its gradient.

Content and style compare hidden units `(N, m, T)` and Gram matrices `(N, m, m)`. Foot, bone and
trajectory losses are about real lengths: they take *denormalised* motion `(N, 66, T)`. Every loss
gives one number for each clip, `(N,)`; every backward takes the upstream gradient `(N,)` and the
same arguments.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from .. import nn
from ..motion.features import FORWARD, POSITIONS, SIDEWAYS, TURN, VELOCITIES
from ..motion.joints import BONES, FEET, JOINTS
from ..nn.arguments import check_arrays, check_whole, in_precision
from ..nn.sums import unit_vectors, wide_sum

Bones = Sequence[tuple[int, int]]

# What the bars || . || of equations 4 and 5 may mean, and the gradient of each.
READINGS = {"norm": (nn.norm, nn.norm_backward),
            "mean_squares": (nn.mean_squares, nn.mean_squares_backward),
            "sum_squares": (nn.sum_squares, nn.sum_squares_backward)}


def content_loss(H_input: np.ndarray, H_output: np.ndarray, *, c: float = 1.0,
                 reading: str = "norm") -> np.ndarray:
    r"""The content loss (Holden 2017, Equation 4):   c || L(I) - L(T(I)) ||

    H_input, H_output : (N, m, T);  reading : what stands for the bars, of each clip: "norm" as
    printed, "mean_squares", the mean of the squares, as the 2016 code has it, or "sum_squares"
    ->  (N,)

    >>> content_loss(np.zeros((1, 1, 2)), np.array([[[3.0, 4.0]]]))
    array([5.])
    """
    return in_precision(c, H_output) * _measure(reading)(H_input - H_output)


def content_loss_backward(dloss: np.ndarray, H_input: np.ndarray, H_output: np.ndarray, *,
                          c: float = 1.0, reading: str = "norm") -> tuple[np.ndarray, np.ndarray]:
    """Both gradients are along the difference, equal and opposite.

    dloss : (N,)  ->  dH_input, dH_output (N, m, T)

    >>> content_loss_backward(np.ones(1), np.zeros((1, 1, 2)), np.array([[[3.0, 4.0]]]))[1]
    array([[[0.6, 0.8]]])
    """
    dH = _measure(reading, back=True)(in_precision(c, dloss) * dloss, H_input - H_output)
    return dH, -dH


def style_loss(G_style: np.ndarray, H_output: np.ndarray, *, s: float = 0.01,
               reading: str = "norm") -> np.ndarray:
    r"""The style loss (Holden 2017, Equation 5):   s || Gram(L(S)) - Gram(L(T(I))) ||

    G_style : (N, m, m), scaled to the output's number of frames (see `style_target`);
    H_output : (N, m, T);  reading : of the bars, as in `content_loss`   ->  (N,)

    >>> style_loss(np.zeros((1, 1, 1)), np.array([[[3.0, 4.0]]]))
    array([0.25])
    """
    return in_precision(s, H_output) * _measure(reading)(G_style - nn.gram(H_output))


def style_loss_backward(dloss: np.ndarray, G_style: np.ndarray, H_output: np.ndarray, *,
                        s: float = 0.01, reading: str = "norm") -> tuple[np.ndarray, np.ndarray]:
    """The output's gradient comes back through its Gram matrix.

    dloss : (N,)  ->  dG_style (N, m, m), dH_output (N, m, T)

    >>> style_loss_backward(np.ones(1), np.zeros((1, 1, 1)), np.array([[[3.0, 4.0]]]))[1]
    array([[[0.06, 0.08]]])
    """
    dG = _measure(reading, back=True)(in_precision(s, dloss) * dloss, G_style - nn.gram(H_output))
    return dG, nn.gram_backward(-dG, H_output)


def _measure(name, back=False):
    """A measure, or its backward.   Raises ValueError."""
    if not isinstance(name, str) or name not in READINGS:
        raise ValueError(f"reading: found {name!r}, needed one of {', '.join(READINGS)}")
    return READINGS[name][back]


def style_target(exemplars: list[np.ndarray], frames: int) -> np.ndarray:
    r"""The Gram matrix that an output of `frames` hidden frames should have.

    A Gram matrix sums over time, so each is divided by its own frames and multiplied by the
    output's; several exemplars count as one long one:   G = frames * sum_e Gram(H_e) / sum_e T_e

    exemplars : list of H (m, T_e)  ->  (m, m)

    >>> style_target([np.array([[3.0, 4.0]])], frames=4)
    array([[50.]])
    """
    check_whole("frames", frames, 1)
    total = sum(nn.gram(H[None])[0] for H in exemplars)
    return total * (in_precision(frames, total) / sum(H.shape[1] for H in exemplars))


def joint_positions(motion: np.ndarray) -> np.ndarray:
    """The 21 joints of a denormalised motion, a view.   (N, 66, T)  ->  (N, 21, 3, T)"""
    return motion[:, POSITIONS].reshape(len(motion), JOINTS, 3, motion.shape[2])


def foot_velocities(motion: np.ndarray) -> np.ndarray:
    r"""World velocity of the four foot joints, seen in the character's frame, from each frame to
    the next:

        v_r + omega x p_j + v_j,   v_j[t] = p_j[t+1] - p_j[t],
        omega x p = (turn z, 0, -turn x),   v_r = (sideways, 0, forward)

    motion : (N, 66, T)  ->  (N, 4, 3, T-1)

    >>> bool(foot_velocities(np.ones((1, 66, 2)))[0, 0, 1, 0] == 0)       # up it only has its own
    True
    """
    p = joint_positions(motion)[:, FEET]                         # (N, 4, 3, T)
    turn = motion[:, None, TURN, :-1]                            # (N, 1, T-1)
    v = p[..., 1:] - p[..., :-1]
    v[:, :, 0] += motion[:, None, SIDEWAYS, :-1] + turn * p[:, :, 2, :-1]
    v[:, :, 2] += motion[:, None, FORWARD, :-1] - turn * p[:, :, 0, :-1]
    return v


def foot_velocities_backward(dv: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Feet, turning and the root's velocity each get their share.

    dv : (N, 4, 3, T-1), motion : (N, 66, T)  ->  (N, 66, T)
    """
    p = joint_positions(motion)[:, FEET]
    turn = motion[:, None, TURN, :-1]
    dp = np.zeros_like(p)
    dp[..., 1:] = dv
    dp[..., :-1] -= dv
    dp[:, :, 2, :-1] += turn * dv[:, :, 0]                       # x velocity holds + turn z
    dp[:, :, 0, :-1] -= turn * dv[:, :, 2]                       # z velocity holds - turn x
    dmotion = np.zeros_like(motion)
    dmotion[:, SIDEWAYS, :-1] = dv[:, :, 0].sum(axis=1)
    dmotion[:, FORWARD, :-1] = dv[:, :, 2].sum(axis=1)
    dmotion[:, TURN, :-1] = (p[:, :, 2, :-1] * dv[:, :, 0]
                             - p[:, :, 0, :-1] * dv[:, :, 2]).sum(axis=1)
    joint_positions(dmotion)[:, FEET] = dp
    return dmotion


def foot_loss(motion: np.ndarray, contacts: np.ndarray, *, target: Any = 0.0) -> np.ndarray:
    r"""The foot loss (Holden 2017, Equation 7):

        sum over feet j and frames in contact of || v_r + omega x p_j + v_j - r' ||^2

    motion : (N, 66, T) denormalised;  contacts : (N, 4, T) of 0 and 1, constants;  target : r', the
    velocity that a planted foot should have, a number or (N, 4, 3, T-1), where an axis of 1 is for
    all
    ->  (N,), length^2 / frame^2. A step has the contact, turn and p_j of its first frame.

    >>> still = np.zeros((1, 66, 3))
    >>> foot_loss(still, np.ones((1, 4, 3))), foot_loss(still, np.ones((1, 4, 3)), target=1.0)
    (array([0.]), array([24.]))
    """
    return nn.sum_squares(_slide(motion, contacts, target)[1])


def foot_loss_backward(dloss: np.ndarray, motion: np.ndarray, contacts: np.ndarray, *,
                       target: Any = 0.0) -> np.ndarray:
    """Contacts and target are constants.   dloss : (N,)  ->  dmotion (N, 66, T)"""
    planted, slide = _slide(motion, contacts, target)
    return foot_velocities_backward(planted * nn.sum_squares_backward(dloss, slide), motion)


def _slide(motion, contacts, target):
    """Who is planted (N, 4, 1, T-1), and what is too fast there (N, 4, 3, T-1)."""
    planted = in_precision(contacts[:, :, None, :-1], motion)
    return planted, planted * (foot_velocities(motion) - in_precision(target, motion))


def bone_loss(motion: np.ndarray, lengths: Any, *, bones: Bones = BONES) -> np.ndarray:
    r"""The bone loss (Holden 2017, Equation 8):

        sum over bones b = (j1, j2) and frames of ( || p_j1 - p_j2 || - l_b )^2

    motion : (N, 66, T) denormalised;  lengths : one for each of the bones, pairs of joints, those
    of `joints.BONES` unless others are given   ->  (N,), length^2

    >>> bone_loss(np.zeros((1, 66, 1)), np.full(20, 2.0))                 # each is 2 too short
    array([80.])
    """
    return nn.sum_squares(_bone_errors(motion, lengths, bones)[1])


def bone_loss_backward(dloss: np.ndarray, motion: np.ndarray, lengths: Any, *,
                       bones: Bones = BONES) -> np.ndarray:
    """The length of a bone grows along the bone at one end and against it at the other.

    dloss : (N,)  ->  dmotion (N, 66, T)
    At a bone of length 0 the gradient is 0 (the kink rule of a norm).
    """
    direction, errors = _bone_errors(motion, lengths, bones)
    d_bones = nn.sum_squares_backward(dloss, errors)[:, :, None] * direction      # (N, 20, 3, T)
    dmotion = np.zeros_like(motion)
    dp = joint_positions(dmotion)
    for b, (j1, j2) in enumerate(bones):
        dp[:, j1] += d_bones[:, b]
        dp[:, j2] -= d_bones[:, b]
    return dmotion


def _bone_errors(motion, lengths, bones):
    """Directions of the bones (N, 20, 3, T), 0 for one of length 0, and errors of their lengths
    (N, 20, T)."""
    check_arrays(motion=motion)
    p = joint_positions(motion)
    if np.shape(lengths) != (len(bones),):
        raise ValueError(f"lengths: found shape {np.shape(lengths)}, needed ({len(bones)},)")
    j1, j2 = np.array(bones).T
    direction, found = unit_vectors(p[:, j1] - p[:, j2], 2)
    return direction, found - in_precision(lengths, motion)[:, None]


def trajectory_loss(motion: np.ndarray, wanted: np.ndarray, *,
                    turn_weight: float = 1.0) -> np.ndarray:
    r"""The trajectory loss, with both squares (Holden 2017, Equation 9):

        turn_weight || turn - turn' ||^2 + || v_r - v_r' ||^2

    motion : (N, 66, T) denormalised;  wanted : (N, 3, T) turning, forward and sideways velocity of
    the input  ->  (N,)
    turn_weight : what a squared radian is worth in squared lengths; 1 as printed.

    >>> trajectory_loss(np.zeros((1, 66, 1)), np.array([[[1.0], [2.0], [0.0]]]), turn_weight=10.0)
    array([14.])
    """
    weights, error = _off_the_path(motion, wanted, turn_weight)
    return wide_sum(weights * error * error, (1, 2))


def trajectory_loss_backward(dloss: np.ndarray, motion: np.ndarray, wanted: np.ndarray, *,
                             turn_weight: float = 1.0) -> np.ndarray:
    """Only the three velocities have a part in it.   dloss : (N,)  ->  dmotion (N, 66, T)"""
    weights, error = _off_the_path(motion, wanted, turn_weight)
    dmotion = np.zeros_like(motion)
    dmotion[:, VELOCITIES] = weights * nn.sum_squares_backward(dloss, error)
    return dmotion


def _off_the_path(motion, wanted, turn_weight):
    """Weights of turning, forward and sideways velocity (3, 1), and their errors (N, 3, T)."""
    check_arrays(motion=motion)
    weights = in_precision([[turn_weight], [1], [1]], motion)
    return weights, motion[:, VELOCITIES] - in_precision(wanted, motion)
