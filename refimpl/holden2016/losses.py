r"""What the searches of the 2016 code minimise (`constraints.py`, `demo_style_transfer.py`).

All are *means*, where equations 7 to 9 of Holden et al. 2017 have sums. Each gives one number for
each clip, (N,); the code's own number is their mean over the clips. Motion is (N, 73, T),
denormalised, in the code's unit.
"""

import numpy as np

from .. import nn
from ..holden2017 import losses
from ..motion.joints import FEET, SLOT
from .rows import ORDER, POSITIONS, SIGN, TRAJECTORY

# Both arms hang from the neck, where `joints.BONES` has the chest: the code's parents.
NECK = SLOT["Neck"]
BONES = tuple((NECK if joint in (SLOT["LeftArm"], SLOT["RightArm"]) else parent, joint)
              for parent, joint in losses.BONES)
LENGTHS = np.array([2.40, 7.15, 7.49, 2.36, 2.37, 7.43, 7.50, 2.41, 2.04, 2.05,
                    1.75, 1.76, 2.90, 4.98, 3.48, 0.71, 2.73, 5.24, 3.44, 0.62])
SCALE = 10.0                                                     # of the squares of feet and path
HEIGHTS = [POSITIONS.start + 3 * foot + 1 for foot in FEET]      # the rows of the feet's y


def as_66(motion: np.ndarray) -> np.ndarray:
    """The 66 numbers of 2017 among the 73: another order, and the turning with its sign.

    motion : (N, 73, T)  ->  (N, 66, T)

    >>> as_66(np.arange(73.0).reshape(1, 73, 1))[0, -3:, 0].tolist()  # turn, forward, sideways
    [-68.0, 67.0, 66.0]
    """
    return motion[:, ORDER] * SIGN[:, None].astype(motion.real.dtype)


def as_66_backward(dother: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """dother : (N, 66, T)  ->  dmotion (N, 73, T): reference joint and contacts get nothing"""
    dmotion = np.zeros_like(motion)
    dmotion[:, ORDER] = dother * SIGN[:, None].astype(motion.real.dtype)
    return dmotion


def foot_loss(motion: np.ndarray, contacts: np.ndarray) -> np.ndarray:
    r"""Planted feet that slide or rise, and all feet below the floor:

        1/4 [ 10 mean (contact v_x)^2 + 10 mean (contact v_y)^2 + 10 mean (contact v_z)^2
              + 10 mean min(y, 0)^2 ]

    with v of equation 7, means over 4 feet and T - 1 steps, whether planted or not, and heights y
    of frames 1 to T - 1; one frame makes no step and costs nothing. Equation 7 has no floor term.

    motion : (N, 73, T), as `rows` has it: the turning has the other sign than in 2017
    contacts : (N, 4, T) of 0 and 1, constants
    ->  (N,)

    >>> below = np.zeros((1, 73, 5))
    >>> below[:, POSITIONS] = -1.0
    >>> foot_loss(below, np.zeros((1, 4, 5))).tolist()
    [2.5]
    """
    below = np.minimum(_heights(motion), 0)
    return _share(motion) * (losses.foot_loss(as_66(motion), contacts) + nn.sum_squares(below))


def foot_loss_backward(dloss: np.ndarray, motion: np.ndarray, contacts: np.ndarray) -> np.ndarray:
    """dloss : (N,)  ->  dmotion (N, 73, T)"""
    dloss = _share(motion) * dloss
    dmotion = as_66_backward(losses.foot_loss_backward(dloss, as_66(motion), contacts), motion)
    below = np.minimum(_heights(motion), 0)
    dmotion[:, HEIGHTS, 1:] += nn.sum_squares_backward(dloss, below)
    return dmotion


def bone_loss(motion: np.ndarray) -> np.ndarray:
    r"""1 / (20 T) sum over bones and frames of (|p_j1 - p_j2| - length)^2, with the code's own 20
    lengths and both arms at the neck.

    motion : (N, 73, T)  ->  (N,)

    >>> bone_loss(np.zeros((1, 73, 5))).round(3).tolist()            # the mean squared length
    [17.445]
    """
    return losses.bone_loss(as_66(motion), LENGTHS, bones=BONES) / (len(BONES) * motion.shape[2])


def bone_loss_backward(dloss: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """dloss : (N,)  ->  dmotion (N, 73, T)"""
    dloss = dloss / (len(BONES) * motion.shape[2])
    return as_66_backward(losses.bone_loss_backward(dloss, as_66(motion), LENGTHS, bones=BONES),
                          motion)


def trajectory_loss(motion: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    r"""10 mean (rows 66 to 68 - wanted)^2: a squared radian counts one squared unit.

    motion : (N, 73, T), wanted : (N, 3, T)  ->  (N,)

    >>> trajectory_loss(np.zeros((1, 73, 5)), np.ones((1, 3, 5))).tolist()
    [10.0]
    """
    return SCALE * nn.mean_squares(_off_the_path(motion, wanted))


def trajectory_loss_backward(dloss: np.ndarray, motion: np.ndarray,
                             wanted: np.ndarray) -> np.ndarray:
    """dloss : (N,)  ->  dmotion (N, 73, T)"""
    dmotion = np.zeros_like(motion)
    dmotion[:, TRAJECTORY] = nn.mean_squares_backward(SCALE * dloss, _off_the_path(motion, wanted))
    return dmotion


def _off_the_path(motion, wanted):
    return motion[:, TRAJECTORY] - np.asarray(wanted, dtype=motion.real.dtype)


def constraint_loss(motion: np.ndarray, contacts: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """(feet + bones + path) / 3.

    motion : (N, 73, T), contacts : (N, 4, T), wanted : (N, 3, T)  ->  (N,)

    >>> constraint_loss(np.zeros((1, 73, 5)), np.zeros((1, 4, 5)), np.ones((1, 3, 5))).round(3)
    array([9.148])
    """
    return (foot_loss(motion, contacts) + bone_loss(motion) + trajectory_loss(motion, wanted)) / 3


def constraint_loss_backward(dloss: np.ndarray, motion: np.ndarray, contacts: np.ndarray,
                             wanted: np.ndarray) -> np.ndarray:
    """dloss : (N,)  ->  dmotion (N, 73, T)"""
    third = dloss / 3
    return (foot_loss_backward(third, motion, contacts) + bone_loss_backward(third, motion)
            + trajectory_loss_backward(third, motion, wanted))


def search_loss(H: np.ndarray, content: np.ndarray, gram: np.ndarray, *,
                amount: float = 0.1) -> np.ndarray:
    r"""The first search, of hidden units:

        (amount mean (G - H H^T)^2 + mean (L(C) - H)^2) / (1 + amount)

    G is the style's Gram matrix as it is, not scaled to the content's frames: of a style half as
    long it asks for half the energy a frame.

    H, content : (N, m, U), gram : (N, m, m)  ->  (N,)

    >>> H = np.zeros((1, 2, 5))
    >>> search_loss(H, content=H + 1, gram=np.zeros((1, 2, 2)), amount=0.25).tolist()
    [0.8]
    """
    s, c = amount / (1 + amount), 1 / (1 + amount)
    return (losses.style_loss(gram, H, s=s, reading="mean_squares")
            + losses.content_loss(content, H, c=c, reading="mean_squares"))


def search_loss_backward(dloss: np.ndarray, H: np.ndarray, content: np.ndarray, gram: np.ndarray, *,
                         amount: float = 0.1) -> np.ndarray:
    """dloss : (N,)  ->  dH (N, m, U)"""
    s, c = amount / (1 + amount), 1 / (1 + amount)
    return (losses.style_loss_backward(dloss, gram, H, s=s, reading="mean_squares")[1]
            + losses.content_loss_backward(dloss, content, H, c=c, reading="mean_squares")[1])


def _heights(motion):
    """Heights of the four foot joints in frames 1 to T - 1.   ->  (N, 4, T - 1)"""
    return motion[:, HEIGHTS, 1:]


def _share(motion):
    """10 / (4 terms x 4 feet x (T - 1) steps); one frame makes no step and costs nothing."""
    return SCALE / (4 * len(FEET) * max(motion.shape[2] - 1, 1))
