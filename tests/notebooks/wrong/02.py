"""What students write in notebook 02 and should not get away with: `exercise__what_is_wrong`. Names
of the notebook are known.
"""

import numpy as np

from refimpl.motion import features as f66
from refimpl.motion.features import FORWARD, POSITIONS, SIDEWAYS, TRANSLATION, TURN, VELOCITIES
from refimpl.motion.joints import FEET
from refimpl.motion.feet import CONTACT_HEIGHTS, CONTACT_SPEED2
from refimpl.motion.rotation import yaw_rotation


def _encode(P, *, sense=-1, wrap=True, floor=None, seen_from=1, last=True, swap=False, hips=False,
            atan=False, swapped_axes=False):
    path, forward = f66.root_path(P), f66.facing(P)
    if hips:
        path = P[:, 0][:, [0, 2]]
    yaw = (np.arctan2(forward[:, 1], forward[:, 0]) if atan
           else np.arctan2(forward[:, 0], forward[:, 1]))
    root = np.stack([path[:, 0], np.full(len(P), f66.floor_height(P) if floor is None else floor),
                     path[:, 1]], axis=1)
    back = yaw_rotation(sense * yaw)
    step = np.diff(root, axis=0)
    velocity = (step if seen_from is None
                else (back[seen_from:len(P) - 1 + seen_from] @ step[..., None])[..., 0])
    X = np.zeros((len(P), 66))
    local = (back[:, None] @ (P - root[:, None])[..., None])[..., 0]
    X[:, POSITIONS] = (local.swapaxes(1, 2) if swapped_axes else local).reshape(len(P), 63)
    turn = np.diff(yaw)
    X[:-1, TURN] = (turn + np.pi) % (2 * np.pi) - np.pi if wrap else turn
    X[:-1, FORWARD], X[:-1, SIDEWAYS] = ((velocity[:, 0], velocity[:, 2]) if swap
                                         else (velocity[:, 2], velocity[:, 0]))
    if last:
        X[-1, VELOCITIES] = X[-2, VELOCITIES]
    return X


def my_encode__turned_the_wrong_way(P):
    return _encode(P, sense=1)


def my_encode__yaw_jumps(P):
    return _encode(P, wrap=False)


def my_encode__floor_forgotten(P):
    return _encode(P, floor=0.0)


def my_encode__velocity_seen_from_the_frame_before(P):
    return _encode(P, seen_from=0)


def my_encode__velocity_in_the_world(P):
    return _encode(P, seen_from=None)


def my_encode__last_row_stands_still(P):
    return _encode(P, last=False)


def my_encode__forward_and_sideways_exchanged(P):
    return _encode(P, swap=True)


def my_encode__path_not_smoothed(P):
    return _encode(P, hips=True)


def my_encode__arguments_of_atan2_exchanged(P):
    return _encode(P, atan=True)


def my_encode__all_x_then_all_y(P):
    return _encode(P, swapped_axes=True)


def _root(X, start, yaw=None, sense=1, first=1):
    yaw = start.yaw + np.concatenate([[0.0], np.cumsum(X[:-1, TURN])]) if yaw is None else yaw
    velocity = np.stack([X[:-1, SIDEWAYS], np.zeros(len(X) - 1), X[:-1, FORWARD]], axis=1)
    steps = (yaw_rotation(sense * yaw[first:len(X) - 1 + first]) @ velocity[..., None])[..., 0]
    return np.cumsum(np.concatenate([[[start.x, start.floor, start.z]], steps]), axis=0), yaw


def my_root_motion__steps_before_it_turns(X, start):
    return _root(X, start, first=0)


def my_root_motion__turned_the_wrong_way(X, start):
    return _root(X, start, sense=-1)


def my_root_motion__never_turned(X, start):
    root, yaw = _root(X, start)
    return _root(X, start, yaw=np.zeros(len(X)))[0], yaw


def my_root_motion__start_forgotten(X, start):
    return _root(X, type(start)())


def my_root_motion__heading_at_the_start_forgotten(X, start):
    return _root(X, type(start)(start.x, start.z, 0.0, start.floor))


def my_root_motion__last_velocity_used(X, start):
    root, yaw = _root(np.concatenate([X[:1], X]), start)
    return root[1:], yaw[1:]


def my_root_motion__floor_added_up(X, start):
    root, yaw = _root(X, start)
    root[:, 1] = start.floor * np.arange(1, len(X) + 1)
    return root, yaw


def my_root_motion__rows_instead_of_columns(X, start):
    yaw = start.yaw + np.concatenate([[0.0], np.cumsum(X[:-1, TURN])])
    velocity = np.stack([X[:-1, SIDEWAYS], np.zeros(len(X) - 1), X[:-1, FORWARD]], axis=1)
    steps = (velocity[:, None] @ yaw_rotation(yaw[1:]))[:, 0]
    return np.cumsum(np.concatenate([[[start.x, start.floor, start.z]], steps]), axis=0), yaw


def _contacts(P, floor, *, axes=(0, 1, 2), speed_bound=None, heights=CONTACT_HEIGHTS, leg=None,
              late=False, last="repeat"):
    leg, feet = f66.leg_length(P) if leg is None else leg, P[:, FEET]
    speed2 = np.sum(np.diff(feet, axis=0)[..., list(axes)] ** 2, axis=2)
    planted = (speed2 < (CONTACT_SPEED2 * leg**2 if speed_bound is None else speed_bound * leg))
    planted &= (feet[1:, :, 1] - floor < heights * leg if late else feet[:-1, :, 1] - floor
                < heights * leg)
    if late:
        return np.concatenate([planted[:1], planted])
    return np.concatenate([planted, planted[-1:] if last == "repeat" else np.zeros((1, 4), bool)])


def my_foot_contacts__speed_over_the_floor_only(P, floor):
    return _contacts(P, floor, axes=(0, 2))


def my_foot_contacts__speed_not_squared(P, floor):
    feet, leg = P[:, FEET], f66.leg_length(P)
    speed = np.linalg.norm(np.diff(feet, axis=0), axis=2)
    planted = (speed < CONTACT_SPEED2 * leg**2) & (feet[:-1, :, 1] - floor < CONTACT_HEIGHTS * leg)
    return np.concatenate([planted, planted[-1:]])


def my_foot_contacts__floor_forgotten(P, floor):
    return _contacts(P, 0.0)


def my_foot_contacts__slow_or_low(P, floor):
    feet, leg = P[:, FEET], f66.leg_length(P)
    planted = ((np.sum(np.diff(feet, axis=0) ** 2, axis=2) < CONTACT_SPEED2 * leg**2)
               | (feet[:-1, :, 1] - floor < CONTACT_HEIGHTS * leg))
    return np.concatenate([planted, planted[-1:]])


def my_foot_contacts__last_frame_in_the_air(P, floor):
    return _contacts(P, floor, last="none")


def my_foot_contacts__one_frame_late(P, floor):
    return _contacts(P, floor, late=True)


def my_foot_contacts__leg_not_squared(P, floor):
    return _contacts(P, floor, speed_bound=CONTACT_SPEED2 * 80.0)


def my_foot_contacts__made_for_one_size(P, floor):
    return _contacts(P, floor, leg=80.0)


def my_foot_contacts__slow_is_enough(P, floor):
    return _contacts(P, floor, heights=np.full(4, 100.0))


def my_foot_contacts__heels_and_toes_one_bound(P, floor):
    return _contacts(P, floor, heights=np.full(4, CONTACT_HEIGHTS[1]))


def _normalise(X, groups=(POSITIONS, TRANSLATION, slice(TURN, TURN + 1)), standing=True,
               share=lambda s: np.sqrt(np.mean(s**2))):
    mean, deviation = X.mean(axis=0), X.std(axis=0)
    if standing:
        mean[VELOCITIES] = 0.0
    for group in groups:
        deviation[group] = share(deviation[group])
    return mean, deviation


def my_normaliser__each_its_own(X):
    return _normalise(X, groups=())


def my_normaliser__standing_still_moved(X):
    return _normalise(X, standing=False)


def my_normaliser__one_for_all(X):
    return _normalise(X, groups=(slice(0, 66),))


def my_normaliser__turning_among_the_velocities(X):
    return _normalise(X, groups=(POSITIONS, VELOCITIES))


def my_normaliser__mean_of_the_deviations(X):
    return _normalise(X, share=np.mean)


def my_normaliser__deviation_of_all_numbers_together(X):
    mean, deviation = _normalise(X)
    deviation[POSITIONS] = X[:, POSITIONS].std()
    return mean, deviation


def my_normaliser__divided_by_one_less(X):
    mean, deviation = _normalise(X)
    return mean, deviation * np.sqrt(len(X) / (len(X) - 1))
