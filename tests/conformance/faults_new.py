"""Faults of rows, poses, phrases, rotations and of what is done with trained networks: (what is
wrong, function, what stands in its place).
"""

import numpy as np

from refimpl.conformance import reference
from tests.conformance.faults_whole import given, last_batch_dropped, of

GOOD = reference().functions


def scaled(name, factor, number=None):
    """An answer, or one of several, times a number."""
    if number is not None:
        return of(GOOD[name], number, lambda y, *a, **k: y * factor)
    return lambda *a, **k: GOOD[name](*a, **k) * y_type(a, factor)


def y_type(arguments, factor):
    """The factor in the precision of the first argument."""
    return np.asarray(arguments[0]).dtype.type(factor)


def asked(name, **changes):
    """The good function asked something else."""
    return given(GOOD[name], **changes)


def turn_of_2017(positions):
    rows = GOOD["motion_to_rows_2016"](positions)
    rows[:, 68] *= -1
    return rows


def step_before_the_turn(motion):
    moved = motion.copy()
    moved[1:, 68], moved[0, 68] = motion[:-1, 68], 0.0
    return GOOD["rows_to_motion_2016"](moved)


def odd_row_behind(motion, **sizes):
    windows = GOOD["row_windows_2016"](motion, **sizes)
    return np.roll(windows, -1, axis=1) if len(motion) < windows.shape[1] else windows


def same_sign_of_heights(angles, root, **how):
    return GOOD["joined_motions"](angles, root * np.array([1.0, 1.0, 1.0, 0.999]), **how)


def spread_of_all(angles, root, *, contents, **how):
    return GOOD["observed_styles"](angles, root, contents=(0,) * len(contents), **how)


def no_pole(R, *, order):
    found = GOOD["matrix_to_euler"](R, order=order)
    return found + 1e-9


def long_way(R0, R1, t):
    return GOOD["slerp"](R0, R1, -t)


def twist(a, b):
    R = GOOD["shortest_rotation"](a, b)
    return R.swapaxes(-1, -2)


def reflections_kept(M):
    U, _, Vt = np.linalg.svd(M)
    return U @ Vt


FAULTS = (
    ("new: the terms of the second search not divided by 3", "constraint_loss_2016",
     scaled("constraint_loss_2016", 3.0)),
    ("new: half the gradient of the second search", "constraint_loss_2016_backward",
     scaled("constraint_loss_2016_backward", 0.5)),
    ("new: rows that turn as in 2017", "motion_to_rows_2016", turn_of_2017),
    ("new: rows walked before they turn", "rows_to_motion_2016", step_before_the_turn),
    ("new: the odd row of a window behind", "row_windows_2016", odd_row_behind),
    ("new: feet as far as the rest", "row_normaliser_2016",
     of(GOOD["row_normaliser_2016"], 1, lambda d, *a: np.where(d == 0.9 * d[3], d[3], d))),
    ("new: 2016 without its last batch", "train_network_2016",
     last_batch_dropped(GOOD["train_network_2016"])),
    ("new: no dropout of hidden units", "train_network_2016",
     asked("train_network_2016", kept_hidden=np.ones_like)),
    ("new: a projection without its decoder's bias", "project_2016",
     lambda X, We, be, Wd, bd: GOOD["project_2016"](X, We, be, Wd, 0 * bd)),
    ("new: middles a row early", "joined_windows_2016",
     lambda w: GOOD["joined_windows_2016"](np.roll(w, 1, axis=1))),
    ("new: constraints of what is normalised", "constrained_loss_2016",
     asked("constrained_loss_2016", mean=np.zeros_like)),
    ("new: an angle from another reference", "motion_to_poses", scaled("motion_to_poses", 1.01, 4)),
    ("new: a heading of its own sign", "posed_joints",
     lambda a, root, **k: GOOD["posed_joints"](a, root * np.array([1.0, 1, 1, -1]), **k)),
    ("new: one content for all", "observed_styles", spread_of_all),
    ("new: costs of one direction", "all_dtw_costs",
     lambda f, **k: np.triu(GOOD["all_dtw_costs"](f, **k))),
    ("new: errors of one fold", "ridge_errors", asked("ridge_errors", folds=lambda f: f // 2)),
    ("new: sums of errors", "machine_errors", scaled("machine_errors", 8.0)),
    ("new: a violation without its box", "machine_violation",
     asked("machine_violation", C=lambda C: C + 0.2)),
    ("new: folds in order", "fitted_style", asked("fitted_style", dealt=np.sort)),
    ("new: a narrow seam", "joined_motions", asked("joined_motions", fps=lambda f: f / 4)),
    ("new: headings that slip", "joined_motions", same_sign_of_heights),
    ("new: the first look", "styled_phrase", lambda Y, *, looks=None,
     **k: GOOD["styled_phrase"](Y, looks=1, **k)),
    ("new: the output of T not projected", "stylised_numbers",
     lambda *a, projected=True, **k: GOOD["stylised_numbers"](*a, projected=False, **k)),
    ("new: pairs of frames one way alone", "projected_numbers",
     lambda f, W, b, *, mean, deviation: (GOOD["project"](
         ((f - mean) / deviation).T[None], W, b)[0].T * deviation + mean)),
    ("new: weights that grow with the leg", "fitted_weights",
     lambda leg, **k: GOOD["fitted_weights"](80.0 ** 2 / leg, **k)),
    ("new: an untied decoder without its bias", "decode_untied",
     lambda H, V, c, **k: GOOD["decode_untied"](H, V, 0 * c, **k)),
    ("new: its bias's gradient a mean", "decode_untied_backward",
     of(GOOD["decode_untied_backward"], 2, lambda g, d, *a, **k: g / d.dtype.type(d.shape[2]))),
    ("new: one bound for all layers", "initial_networks", scaled("initial_networks", 1.5, 2)),
    ("new: noise of both signs doubled", "initial_noise", scaled("initial_noise", 2.0)),
    ("new: the ground under heels", "ground_height",
     lambda p: float(GOOD["planted_feet"](p)[0][[0, 2]].min())),
    ("new: axes in the other order", "euler_to_matrix", lambda a, *, order:
     GOOD["euler_to_matrix"](a[..., ::-1], order=order[::-1])),
    ("new: angles a hair off", "matrix_to_euler", no_pole),
    ("new: a conjugate", "matrix_to_quaternion",
     lambda R: GOOD["matrix_to_quaternion"](R.swapaxes(-1, -2))),
    ("new: quaternions taken to be units", "quaternion_to_matrix",
     lambda q: np.eye(3) + np.sum(q * q, axis=-1)[..., None, None] * (
         GOOD["quaternion_to_matrix"](q) - np.eye(3))),
    ("new: slerp the other way", "slerp", long_way),
    ("new: quaternions that jump", "smooth_rotations",
     lambda R, time: GOOD["smooth_rotations"](R, np.round(time))),
    ("new: from b to a", "shortest_rotation", twist),
    ("new: reflections kept", "nearest_rotation", reflections_kept),
    ("new: from b to a, of many", "best_rotation", lambda a, b: GOOD["best_rotation"](b, a)),
    ("new: means of lengths", "bone_lengths",
     lambda p: np.mean([GOOD["bone_lengths"](frame[None]) for frame in p], axis=0)),
    ("new: turning scaled too", "scaled_numbers", lambda f, *, factor: f * factor),
    ("new: the end's error", "path_error", lambda f, c: (GOOD["path_error"](f[-1:], c[-1:])[0],
                                                         GOOD["path_error"](f, c)[1])),
    ("new: a step of the last row", "path_length",
     lambda f: GOOD["path_length"](np.concatenate([f, f[-1:]]))),
)
