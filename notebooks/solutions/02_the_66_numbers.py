"""Answers to 02_the_66_numbers.ipynb."""

import numpy as np

from refimpl.motion import features as f66
from refimpl.motion.features import FORWARD, POSITIONS, SIDEWAYS, TRANSLATION, TURN, VELOCITIES
from refimpl.motion.joints import FEET
from refimpl.motion.feet import CONTACT_HEIGHTS, CONTACT_SPEED2
from refimpl.motion.rotation import yaw_rotation


def my_encode(P):
    path, forward = f66.root_path(P), f66.facing(P)
    yaw = np.arctan2(forward[:, 0], forward[:, 1])                    # (T,)
    root = np.stack([path[:, 0], np.full(len(P), f66.floor_height(P)), path[:, 1]], axis=1)
    back = yaw_rotation(-yaw)                                         # (T, 3, 3)
    local = (back[:, None] @ (P - root[:, None])[..., None])[..., 0]  # (T, 21, 3)
    velocity = (back[1:] @ np.diff(root, axis=0)[..., None])[..., 0]           # (T - 1, 3)
    X = np.zeros((len(P), 66))
    X[:, POSITIONS] = local.reshape(len(P), 63)
    X[:-1, TURN] = (np.diff(yaw) + np.pi) % (2 * np.pi) - np.pi       # the short way round
    X[:-1, SIDEWAYS], X[:-1, FORWARD] = velocity[:, 0], velocity[:, 2]
    X[-1, VELOCITIES] = X[-2, VELOCITIES]
    return X


def my_root_motion(X, start):
    yaw = start.yaw + np.concatenate([[0.0], np.cumsum(X[:-1, TURN])])
    velocity = np.stack([X[:-1, SIDEWAYS], np.zeros(len(X) - 1), X[:-1, FORWARD]], axis=1)
    steps = (yaw_rotation(yaw[1:]) @ velocity[..., None])[..., 0]    # (T - 1, 3), in the world
    first = np.array([[start.x, start.floor, start.z]])
    return np.cumsum(np.concatenate([first, steps]), axis=0), yaw


def my_foot_contacts(P, floor):
    leg, feet = f66.leg_length(P), P[:, FEET]                         # (T, 4, 3)
    speed2 = np.sum(np.diff(feet, axis=0) ** 2, axis=2)               # (T - 1, 4)
    low = feet[:-1, :, 1] - floor < CONTACT_HEIGHTS * leg
    planted = (speed2 < CONTACT_SPEED2 * leg**2) & low
    return np.concatenate([planted, planted[-1:]])


def my_normaliser(X):
    mean, deviation = X.mean(axis=0), X.std(axis=0)
    mean[VELOCITIES] = 0.0
    for group in (POSITIONS, TRANSLATION, slice(TURN, TURN + 1)):
        deviation[group] = np.sqrt(np.mean(deviation[group] ** 2))
    return mean, deviation
