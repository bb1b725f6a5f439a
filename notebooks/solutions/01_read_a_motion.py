"""Answers to 01_read_a_motion.ipynb."""

import numpy as np

from refimpl.motion import rotation


def my_euler_to_matrix(angles, order):
    R = np.zeros(angles.shape[:-1] + (3, 3)) + np.eye(3)
    for n, axis in enumerate(order):
        R = R @ rotation.axis_rotation(axis, angles[..., n])
    return R


def my_forward_kinematics(parents, rotations, translations):
    R, p = rotations.copy(), translations.copy()
    for j, parent in enumerate(parents):
        if parent >= 0:
            R[:, j] = R[:, parent] @ rotations[:, j]
            p[:, j] = p[:, parent] + (R[:, parent] @ translations[:, j, :, None])[..., 0]
    return R, p


def my_slerp(R0, R1, t):
    v = rotation.log_map(np.swapaxes(R0, -1, -2) @ R1)           # (..., 3)
    return R0 @ rotation.exp_map(np.asarray(t)[..., None] * v)


def my_resample(rotations, translations, fps, new_fps):
    T = len(rotations)
    if T == 1:
        return rotations, translations
    new = int(np.floor((T - 1) * new_fps / fps + 1e-6)) + 1
    frame = np.minimum(np.arange(new) * fps / new_fps, T - 1)
    before = np.minimum(frame.astype(int), T - 2)                # so that there is a frame after it
    t = (frame - before)[:, None]                                # (T_new, 1): one for all joints
    moved = translations[before] + t[..., None] * (translations[before + 1] - translations[before])
    return my_slerp(rotations[before], rotations[before + 1], t), moved
