"""Answers to 07_motion_constraints.ipynb."""

import numpy as np

from refimpl.holden2017 import losses
from refimpl.motion.features import FORWARD, SIDEWAYS, TURN, VELOCITIES
from refimpl.motion.joints import BONES, FEET


def my_foot_by_hand(x, z, turn, dsx, dsz):
    return {"dx0": -dsx[0] - turn[0] * dsz[0],
            "dx1": dsx[0] - dsx[1] - turn[1] * dsz[1],
            "dx2": dsx[1],
            "dz0": -dsz[0] + turn[0] * dsx[0],
            "dz1": dsz[0] - dsz[1] + turn[1] * dsx[1],
            "dz2": dsz[1],
            "dturn0": z[0] * dsx[0] - x[0] * dsz[0], "dturn1": z[1] * dsx[1] - x[1] * dsz[1],
            "dforward0": dsz[0], "dforward1": dsz[1],
            "dsideways0": dsx[0], "dsideways1": dsx[1]}


def my_trajectory_loss_backward(dloss, motion, wanted, turn_weight):
    worth = np.array([turn_weight, 1.0, 1.0])[:, None]                # turn, forward, sideways
    dmotion = np.zeros_like(motion)
    dmotion[:, VELOCITIES] = 2 * worth * (motion[:, VELOCITIES] - wanted) * dloss[:, None, None]
    return dmotion


def my_bone_loss_backward(dloss, motion, lengths):
    p = losses.joint_positions(motion)                                # (N, 21, 3, T)
    dmotion = np.zeros_like(motion)
    # a view: what is written here stands in dmotion
    dp = losses.joint_positions(dmotion)
    for (j1, j2), wished in zip(BONES, lengths):
        u = p[:, j1] - p[:, j2]                                       # (N, 3, T)
        found = np.sqrt(np.sum(u * u, axis=1))                        # (N, T)
        dfound = 2 * (found - wished) * dloss[:, None]                # (N, T)
        direction = u / np.where(found == 0, 1.0, found)[:, None]     # 0 where the length is 0
        dp[:, j1] += dfound[:, None] * direction
        dp[:, j2] -= dfound[:, None] * direction
    return dmotion


def my_foot_loss_backward(dloss, motion, contacts, target):
    planted = contacts[:, :, None, :-1]                               # (N, 4, 1, T - 1)
    s = planted * (losses.foot_velocities(motion) - target)           # (N, 4, 3, T - 1)
    ds = 2 * planted * s * dloss[:, None, None, None]
    p = losses.joint_positions(motion)[:, FEET]                       # (N, 4, 3, T)
    turn = motion[:, None, TURN, :-1]                                 # (N, 1, T - 1)
    dp = np.zeros_like(p)
    dp[..., 1:] += ds
    dp[..., :-1] -= ds
    dp[:, :, 0, :-1] -= turn * ds[:, :, 2]
    dp[:, :, 2, :-1] += turn * ds[:, :, 0]
    dmotion = np.zeros_like(motion)
    losses.joint_positions(dmotion)[:, FEET] = dp
    dmotion[:, SIDEWAYS, :-1] = ds[:, :, 0].sum(axis=1)               # shared by the four feet
    dmotion[:, FORWARD, :-1] = ds[:, :, 2].sum(axis=1)
    dmotion[:, TURN, :-1] = (p[:, :, 2, :-1] * ds[:, :,
                                                  0] - p[:, :, 0, :-1] * ds[:, :, 2]).sum(axis=1)
    return dmotion
