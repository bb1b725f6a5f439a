"""Conventions of others for the system of 2006, as `rivals` has them for the rest."""

import numpy as np

from . import definitions_learning as models, operations_torresani as ours


def along_p_first(X, Y):
    """Of equal ways the step in the first sequence before the diagonal one, as many a textbook has
    it.
    """
    d = np.array([[np.sum((x - y) ** 2) for y in Y] for x in X])
    C = np.full((len(X) + 1, len(Y) + 1), np.inf)
    C[0, 0] = 0.0
    for p, q in np.ndindex(d.shape):
        C[p + 1, q + 1] = d[p, q] + min(C[p, q + 1], C[p, q], C[p + 1, q])
    cell, path = (len(X), len(Y)), []
    while cell != (0, 0):
        path.append((cell[0] - 1, cell[1] - 1))
        p, q = cell
        cell = min(((p - 1, q), (p - 1, q - 1), (p, q - 1)), key=lambda c: C[c])
    return np.array(path[::-1])


def exchanged(X, Y, root_X, root_Y, path, *, alpha, smooth=6.0, up="y"):
    """alpha = 0 gives the second sequence, as section 8 prints it."""
    return ours.space_time_interpolation(X, Y, root_X, root_Y, path, alpha=1 - alpha, smooth=smooth,
                                         up=up)


def width_for_gamma(A, B, *, gamma):
    """exp( -d^2 / (2 gamma^2) ): gamma taken for the Gaussian's width."""
    return ours.gaussian_kernel(A, B, gamma=1 / (2 * gamma ** 2))


def not_squared(A, B, *, gamma):
    """exp( -gamma d ), the Laplacian kernel."""
    return np.exp(-gamma * np.linalg.norm(A[:, None] - B, axis=-1))


def ridge_of_the_mean(function):
    """lambda times the number of examples, where the squared error is a mean."""
    return lambda Z, Y, *, ridge: function(Z, Y, ridge=ridge * len(Z))


def without_offset(K, y, K_new, *, C, epsilon):
    return models.support_vector_regression(K, y, K_new, C=C, epsilon=epsilon,
                                            solve=models.support_vectors_without_bias)


def printed_interpolation(Z, Y, new, *, kind, **options):
    """alpha e_i + (1 - alpha) e_j, as section 8 prints it."""
    if kind != "linear interpolation":
        return ours.predicted_style(Z, Y, new, kind=kind, **options)
    turned = new.copy()
    turned[:, -1] = 1 - turned[:, -1]
    return ours.predicted_style(Z, Y, turned, kind=kind)


def central_differences(positions, *, fps):
    velocity = np.gradient(positions, axis=0) * fps
    acceleration = np.gradient(velocity, axis=0) * fps
    jerk = np.gradient(acceleration, axis=0) * fps
    return np.array([
        0.5 * np.sum(velocity**2, axis=(1, 2)).max(),
        *(np.linalg.norm(x, axis=-1).mean() for x in (velocity, acceleration, jerk))])


RIVALS = {
    "dtw_path": [("of equal ways the step in the first sequence", along_p_first)],
    "space_time_interpolation": [
        ("alpha = 0 giving the second sequence, as section 8 prints", exchanged)],
    "gaussian_kernel": [
        ("gamma taken for the Gaussian's width", width_for_gamma),
        ("the distance not squared", not_squared)], "linear_ridge": [
            ("lambda times the number of examples", ridge_of_the_mean(ours.linear_ridge))],
    "kernel_ridge": [("lambda times the number of examples", ridge_of_the_mean(ours.kernel_ridge))],
    "support_vector_regression": [
        ("a machine without the offset b", without_offset)], "predicted_style": [
            ("alpha e_i + (1 - alpha) e_j, as section 8 prints",
             printed_interpolation)], "exponential_map": [
                 ("rotations of the other hand (row vectors)",
                  lambda v: np.ascontiguousarray(ours.rotation.exp_map(v).swapaxes(-1, -2)))
             ], "rotation_vector": [
                 ("rotations of the other hand (row vectors)",
                  lambda R: ours.rotation.log_map(np.ascontiguousarray(R.swapaxes(-1, -2))))],
    "effort_measures": [("central differences, as np.gradient takes them", central_differences)], }
