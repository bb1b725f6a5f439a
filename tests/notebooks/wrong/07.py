"""What students write in notebook 07 and should not get away with: `exercise__what_is_wrong`."""

import numpy as np

from refimpl.holden2017 import losses
from refimpl.motion.features import FORWARD, SIDEWAYS, TURN, VELOCITIES
from refimpl.motion.joints import BONES, FEET


def _trajectory(dloss, motion, wanted, worth, factor=2):
    dmotion = np.zeros_like(motion)
    dmotion[:, VELOCITIES] = (factor * np.reshape(worth, (3, 1)) * (motion[:, VELOCITIES] - wanted)
                              * dloss[:, None, None])
    return dmotion


def my_trajectory_loss_backward__two_forgotten(dloss, motion, wanted, turn_weight):
    return _trajectory(dloss, motion, wanted, (turn_weight, 1, 1), 1)


def my_trajectory_loss_backward__weight_forgotten(dloss, motion, wanted, turn_weight):
    return _trajectory(dloss, motion, wanted, (1, 1, 1))


def my_trajectory_loss_backward__root_of_the_weight(dloss, motion, wanted, turn_weight):
    return _trajectory(dloss, motion, wanted, (np.sqrt(turn_weight), 1, 1))


def my_trajectory_loss_backward__weight_on_all_three(dloss, motion, wanted, turn_weight):
    return _trajectory(dloss, motion, wanted, (turn_weight,) * 3)


def my_trajectory_loss_backward__upstream_of_the_first_clip(dloss, motion, wanted, turn_weight):
    return _trajectory(np.full(len(motion), dloss[0]), motion, wanted, (turn_weight, 1, 1))


def my_trajectory_loss_backward__only_three_rows(dloss, motion, wanted, turn_weight):
    return _trajectory(dloss, motion, wanted, (turn_weight, 1, 1))[:, VELOCITIES]


def _bones(dloss, motion, lengths, share, ends=(1, -1), add=True):
    p = losses.joint_positions(motion)
    dmotion = np.zeros_like(motion)
    dp = losses.joint_positions(dmotion)
    for (j1, j2), wished in zip(BONES, lengths):
        u = p[:, j1] - p[:, j2]
        found = np.sqrt(np.sum(u * u, axis=1))[:, None]
        du = share(u, found, wished) * dloss[:, None, None]
        for joint, sign in zip((j1, j2), ends):
            dp[:, joint] = dp[:, joint] + sign * du if add else sign * du
    return dmotion


def _right(u, found, wished):
    return 2 * (found - wished) * u / np.where(found == 0, 1, found)


def my_bone_loss_backward__same_sign_at_both_ends(dloss, motion, lengths):
    return _bones(dloss, motion, lengths, _right, ends=(1, 1))


def my_bone_loss_backward__one_end_only(dloss, motion, lengths):
    return _bones(dloss, motion, lengths, _right, ends=(0, -1))


def my_bone_loss_backward__last_bone_overwrites(dloss, motion, lengths):
    return _bones(dloss, motion, lengths, _right, add=False)


def my_bone_loss_backward__not_divided_by_the_length(dloss, motion, lengths):
    return _bones(dloss, motion, lengths, lambda u, found, wished: 2 * (found - wished) * u)


def my_bone_loss_backward__squared_lengths(dloss, motion, lengths):
    return _bones(dloss, motion, lengths, lambda u, found, wished: 4 * (found**2 - wished**2) * u)


def my_bone_loss_backward__two_forgotten(dloss, motion, lengths):
    return _bones(dloss, motion, lengths, lambda u, found, wished: _right(u, found, wished) / 2)


def my_bone_loss_backward__nan_at_length_zero(dloss, motion, lengths):
    with np.errstate(invalid="ignore", divide="ignore"):
        return _bones(dloss, motion, lengths, lambda u, found,
                      wished: 2 * (found - wished) * u / found)


def my_bone_loss_backward__pushed_at_length_zero(dloss, motion, lengths):
    def share(u, found, wished):
        direction = np.where(found == 0, 1 / np.sqrt(3), u / np.where(found == 0, 1, found))
        return 2 * (found - wished) * direction
    return _bones(dloss, motion, lengths, share)


def _feet(dloss, motion, contacts, target, *, masked=True, late=1, early=-1, cross=1, turning=1,
          arms=1, factor=2, joints=FEET, own_target=True):
    planted = contacts[:, :, None, :-1] if masked else np.ones((1, 1, 1, 1))
    s = planted * (losses.foot_velocities(motion) - (target if own_target else 0.0))
    ds = factor * s * dloss[:, None, None, None]
    p = losses.joint_positions(motion)[:, FEET]
    turn = motion[:, None, TURN, :-1]
    dp = np.zeros_like(p)
    dp[..., 1:] += late * ds
    dp[..., :-1] += early * ds
    dp[:, :, 0, :-1] -= cross * turn * ds[:, :, 2]
    dp[:, :, 2, :-1] += cross * turn * ds[:, :, 0]
    dmotion = np.zeros_like(motion)
    losses.joint_positions(dmotion)[:, joints] = dp
    dmotion[:, SIDEWAYS, :-1] = ds[:, :, 0].sum(axis=1)
    dmotion[:, FORWARD, :-1] = ds[:, :, 2].sum(axis=1)
    moment = p[:, :, 2, :-1] * ds[:, :, 0] - arms * p[:, :, 0, :-1] * ds[:, :, 2]
    dmotion[:, TURN, :-1] = turning * moment.sum(axis=1)
    return dmotion


def my_foot_loss_backward__contacts_forgotten(dloss, motion, contacts, target):
    return _feet(dloss, motion, contacts, target, masked=False)


def my_foot_loss_backward__cross_product_left_out_of_the_position(dloss, motion, contacts, target):
    return _feet(dloss, motion, contacts, target, cross=0)


def my_foot_loss_backward__cross_product_turned_round(dloss, motion, contacts, target):
    return _feet(dloss, motion, contacts, target, cross=-1)


def my_foot_loss_backward__turning_gets_nothing(dloss, motion, contacts, target):
    return _feet(dloss, motion, contacts, target, turning=0)


def my_foot_loss_backward__wrong_sign_in_turning(dloss, motion, contacts, target):
    return _feet(dloss, motion, contacts, target, arms=-1)


def my_foot_loss_backward__difference_not_turned_round(dloss, motion, contacts, target):
    return _feet(dloss, motion, contacts, target, late=-1, early=1)


def my_foot_loss_backward__earlier_frame_forgotten(dloss, motion, contacts, target):
    return _feet(dloss, motion, contacts, target, early=0)


def my_foot_loss_backward__toes_and_heels_exchanged(dloss, motion, contacts, target):
    return _feet(dloss, motion, contacts, target, joints=[FEET[1], FEET[0], FEET[3], FEET[2]])


def my_foot_loss_backward__two_forgotten(dloss, motion, contacts, target):
    return _feet(dloss, motion, contacts, target, factor=1)


def my_foot_loss_backward__target_forgotten(dloss, motion, contacts, target):
    return _feet(dloss, motion, contacts, target, own_target=False)


def _foot_by_hand(x, z, turn, dsx, dsz):
    return {"dx0": -dsx[0] - turn[0] * dsz[0], "dx1": dsx[0] - dsx[1] - turn[1] * dsz[1],
            "dx2": dsx[1], "dz0": -dsz[0] + turn[0] * dsx[0],
            "dz1": dsz[0] - dsz[1] + turn[1] * dsx[1], "dz2": dsz[1],
            "dturn0": z[0] * dsx[0] - x[0] * dsz[0], "dturn1": z[1] * dsx[1] - x[1] * dsz[1],
            "dforward0": dsz[0], "dforward1": dsz[1], "dsideways0": dsx[0], "dsideways1": dsx[1]}


def my_foot_by_hand__turning_forgotten(x, z, turn, dsx, dsz):
    return _foot_by_hand(x, z, turn, dsx, dsz) | {"dx1": dsx[0] - dsx[1]}


def my_foot_by_hand__sign_of_the_turning(x, z, turn, dsx, dsz):
    return _foot_by_hand(x, z, -turn, dsx, dsz)


def my_foot_by_hand__forward_for_sideways(x, z, turn, dsx, dsz):
    return _foot_by_hand(x, z, turn, dsx, dsz) | {"dforward0": dsx[0], "dsideways0": dsz[0]}
