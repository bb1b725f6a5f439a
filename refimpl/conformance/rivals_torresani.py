"""Conventions of others for the system of 2006, as `rivals` has them for the rest."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..motion import rotation
from . import definitions_learning as learning, functions_torresani as ours
from .specification import Array


def along_p_first(X: Array, Y: Array) -> Array:
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


def exchanged(*arrays: Array, alpha: float, **how: Any) -> tuple[Array, Array]:
    """alpha = 0 gives the second sequence, as section 8 prints it."""
    return ours.space_time_interpolation(*arrays, alpha=1 - alpha, **how)


def width_for_gamma(A: Array, B: Array, *, gamma: float) -> Array:
    """exp( -d^2 / (2 gamma^2) ): gamma taken for the Gaussian's width."""
    return ours.gaussian_kernel(A, B, gamma=1 / (2 * gamma ** 2))


def not_squared(A: Array, B: Array, *, gamma: float) -> Array:
    """exp( -gamma d ), the Laplacian kernel."""
    return np.exp(-gamma * np.linalg.norm(A[:, None] - B, axis=-1))


def ridge_of_the_mean(function: Callable[..., Array]) -> Callable[..., Array]:
    """lambda times the number of examples, where the squared error is a mean."""
    return lambda Z, Y, *, ridge: function(Z, Y, ridge=ridge * len(Z))


def without_offset(*arrays: Array, C: float, epsilon: float) -> tuple[Any, Array]:
    """A machine without the offset b."""
    return learning.support_vector_regression(*arrays, C=C, epsilon=epsilon,
                                              solve=learning.support_vectors_without_bias)


def printed_interpolation(Z: Array, Y: Array, new: Array, *, kind: str, **options: Any) -> Array:
    """alpha e_i + (1 - alpha) e_j, as section 8 prints it."""
    if kind != "linear interpolation":
        return ours.predicted_style(Z, Y, new, kind=kind, **options)
    turned = new.copy()
    turned[:, -1] = 1 - turned[:, -1]
    return ours.predicted_style(Z, Y, turned, kind=kind)


def central_differences(positions: Array, *, fps: float) -> Array:
    """Measures of effort by central differences, as np.gradient takes them."""
    velocity = np.gradient(positions, axis=0) * fps
    acceleration = np.gradient(velocity, axis=0) * fps
    jerk = np.gradient(acceleration, axis=0) * fps
    return np.array([0.5 * np.sum(velocity ** 2, axis=(1, 2)).max(),
                     *(np.linalg.norm(x, axis=-1).mean() for x in (velocity, acceleration, jerk))])


def other_hand(matrices: Array) -> Array:
    """Rotations of the other hand, as of row vectors: the matrices transposed."""
    return np.ascontiguousarray(matrices.swapaxes(-1, -2))


RIVALS: dict[str, list[tuple[str, Callable[..., Any]]]] = {
    "dtw_path": [("of equal ways the step in the first sequence", along_p_first)],
    "space_time_interpolation": [
        ("alpha = 0 giving the second sequence, as section 8 prints", exchanged)],
    "gaussian_kernel": [
        ("gamma taken for the Gaussian's width", width_for_gamma),
        ("the distance not squared", not_squared)],
    "linear_ridge": [
        ("lambda times the number of examples", ridge_of_the_mean(ours.linear_ridge))],
    "kernel_ridge": [
        ("lambda times the number of examples", ridge_of_the_mean(ours.kernel_ridge))],
    "support_vector_regression": [("a machine without the offset b", without_offset)],
    "predicted_style": [
        ("alpha e_i + (1 - alpha) e_j, as section 8 prints", printed_interpolation)],
    "exponential_map": [
        ("rotations of the other hand (row vectors)", lambda v: other_hand(rotation.exp_map(v)))],
    "rotation_vector": [
        ("rotations of the other hand (row vectors)", lambda R: rotation.log_map(other_hand(R)))],
    "effort_measures": [("central differences, as np.gradient takes them", central_differences)]}
