"""What students write in notebook 01 and should not get away with: `exercise__what_is_wrong`."""

import numpy as np

from refimpl.motion import rotation


def _euler(angles, order, axis_rotation=rotation.axis_rotation, left=False):
    R = np.zeros(angles.shape[:-1] + (3, 3)) + np.eye(3)
    for n, axis in enumerate(order):
        turn = axis_rotation(axis, angles[..., n])
        R = turn @ R if left else R @ turn
    return R


def my_euler_to_matrix__last_channel_first(angles, order):
    return _euler(angles, order, left=True)


def my_euler_to_matrix__always_zxy(angles, order):
    return _euler(angles, "ZXY"[:len(order)])


def my_euler_to_matrix__in_degrees(angles, order):
    return _euler(np.radians(angles), order)


def my_euler_to_matrix__for_row_vectors(angles, order):
    return _euler(angles, order).swapaxes(-1, -2)


def my_euler_to_matrix__y_with_the_sign_of_x_and_z(angles, order):
    return _euler(angles, order, lambda axis,
                  angle: rotation.axis_rotation(axis, -angle if axis == "Y" else angle))


def my_euler_to_matrix__turns_the_other_way(angles, order):
    return _euler(-angles, order)


def my_euler_to_matrix__each_axis_at_most_once(angles, order):
    R = np.zeros(angles.shape[:-1] + (3, 3)) + np.eye(3)
    for axis in dict.fromkeys(order):
        R = R @ rotation.axis_rotation(axis, angles[..., order.index(axis)])
    return R


def _kinematics(parents, rotations, translations, *, offset="parent", left=False, parent_of=None,
                root=True):
    R, p = rotations.copy(), translations.copy()
    if not root:
        p[:, 0] = 0.0
    for j, parent in enumerate(parents):
        if parent < 0:
            continue
        parent = parent_of(j) if parent_of else parent
        R[:, j] = rotations[:, j] @ R[:, parent] if left else R[:, parent] @ rotations[:, j]
        turn = {"parent": R[:, parent], "own": R[:, j], "local": rotations[:, parent],
                "none": np.broadcast_to(np.eye(3), R[:, j].shape)}[offset]
        p[:, j] = p[:, parent] + (turn @ translations[:, j, :, None])[..., 0]
    return R, p


def my_forward_kinematics__own_rotation_moves_the_joint(parents, rotations, translations):
    return _kinematics(parents, rotations, translations, offset="own")


def my_forward_kinematics__local_rotation_of_the_parent(parents, rotations, translations):
    return _kinematics(parents, rotations, translations, offset="local")


def my_forward_kinematics__offsets_never_turned(parents, rotations, translations):
    return _kinematics(parents, rotations, translations, offset="none")


def my_forward_kinematics__child_times_parent(parents, rotations, translations):
    return _kinematics(parents, rotations, translations, left=True)


def my_forward_kinematics__everything_one_chain(parents, rotations, translations):
    return _kinematics(parents, rotations, translations, parent_of=lambda j: j - 1)


def my_forward_kinematics__root_at_the_origin(parents, rotations, translations):
    return _kinematics(parents, rotations, translations, root=False)


def my_forward_kinematics__rows_instead_of_columns(parents, rotations, translations):
    R, p = _kinematics(parents, rotations, translations)
    for j, parent in enumerate(parents):
        if parent >= 0:
            p[:, j] = p[:, parent] + (translations[:, j, None] @ R[:, parent])[:, 0]
    return R, p


def my_forward_kinematics__written_into_the_input(parents, rotations, translations):
    R, p = _kinematics(parents, rotations, translations)
    translations[:] = p
    return R, p


def my_slerp__mean_of_matrices(R0, R1, t):
    return R0 + np.asarray(t)[..., None, None] * (R1 - R0)


def my_slerp__euler_angles(R0, R1, t):
    a, b = rotation.matrix_to_euler(R0, "ZXY"), rotation.matrix_to_euler(R1, "ZXY")
    return rotation.euler_to_matrix(a + np.asarray(t)[..., None] * (b - a), "ZXY")


def my_slerp__turn_in_the_wrong_frame(R0, R1, t):
    v = rotation.log_map(np.swapaxes(R0, -1, -2) @ R1)
    return rotation.exp_map(np.asarray(t)[..., None] * v) @ R0


def my_slerp__from_the_other_end(R0, R1, t):
    v = rotation.log_map(np.swapaxes(R1, -1, -2) @ R0)
    return R1 @ rotation.exp_map(np.asarray(t)[..., None] * v)


def my_slerp__rotation_vectors_one_by_one(R0, R1, t):
    a, b = rotation.log_map(R0), rotation.log_map(R1)
    return rotation.exp_map(a + np.asarray(t)[..., None] * (b - a))


def my_slerp__never_beyond_the_end(R0, R1, t):
    v = rotation.log_map(np.swapaxes(R0, -1, -2) @ R1)
    return R0 @ rotation.exp_map(np.clip(t, 0, 1)[..., None] * v)


def _frames(rotations, translations, frame, slerp=rotation.slerp):
    before = np.clip(frame.astype(int), 0, max(len(rotations) - 2, 0))
    after = np.minimum(before + 1, len(rotations) - 1)
    t = (frame - before)[:, None]
    return (slerp(rotations[before], rotations[after], t),
            translations[before] + t[..., None] * (translations[after] - translations[before]))


def _count(T, fps, new_fps):
    return int(np.floor((T - 1) * new_fps / fps + 1e-6)) + 1


def my_resample__a_frame_too_many(rotations, translations, fps, new_fps):
    new = int(round(len(rotations) * new_fps / fps))
    return _frames(rotations, translations,
                   np.minimum(np.arange(new) * fps / new_fps, len(rotations) - 1))


def my_resample__stretched_to_the_last_frame(rotations, translations, fps, new_fps):
    T = len(rotations)
    return _frames(rotations, translations, np.linspace(0, T - 1, _count(T, fps, new_fps)))


def my_resample__nearest_frame(rotations, translations, fps, new_fps):
    frame = np.round(np.arange(_count(len(rotations), fps, new_fps)) * fps / new_fps).astype(int)
    return rotations[frame], translations[frame]


def my_resample__mean_of_matrices(rotations, translations, fps, new_fps):
    return _frames(rotations, translations,
                   np.arange(_count(len(rotations), fps, new_fps)) * fps / new_fps,
                   my_slerp__mean_of_matrices)


def my_resample__whole_ratios_only(rotations, translations, fps, new_fps):
    step = max(1, round(new_fps / fps))
    return _frames(rotations, translations, np.arange((len(rotations) - 1) * step + 1) / step)


def my_resample__translations_held(rotations, translations, fps, new_fps):
    frame = np.arange(_count(len(rotations), fps, new_fps)) * fps / new_fps
    return (_frames(rotations, translations, frame)[0],
            translations[np.minimum(frame.astype(int), len(translations) - 1)])


def my_resample__rates_exchanged(rotations, translations, fps, new_fps):
    return _frames(rotations, translations,
                   np.arange(_count(len(rotations), new_fps, fps)) * new_fps / fps)


def my_resample__half_a_frame_late(rotations, translations, fps, new_fps):
    frame = (np.arange(_count(len(rotations), fps, new_fps)) + 0.5) * fps / new_fps - 0.5
    return _frames(rotations, translations, np.clip(frame, 0, len(rotations) - 1))
