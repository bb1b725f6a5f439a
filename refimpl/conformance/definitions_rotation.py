"""Rotations and measures of the 66 numbers a second time: one after the other, by way of SciPy's
rotations where these know the same.
"""

import math

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from ..motion.joints import BONES
from .definitions_learning import exponential_map, rotation_vector
from .definitions_whole import numbers_to_motion
from .specification import Array


def _each(f, *arrays):
    """f of each index of the leading axes, whose elements have so many axes of their own."""
    (first, axes), *_ = arrays
    shape = first.shape[:first.ndim - axes]
    found = [f(*(x[index] for x, _ in arrays)) for index in np.ndindex(shape)]
    return np.array(found).reshape(shape + np.shape(found[0]))


def euler_to_matrix(angles: Array, *, order: str) -> Array:
    """One axis at a time."""
    def _turned(row):
        R = np.eye(3)
        for axis, angle in zip(order, row):
            R = R @ exponential_map(angle * np.eye(3)["XYZ".index(axis)])
        return R
    return _each(_turned, (angles, 1))


def matrix_to_euler(R: Array, *, order: str) -> Array:
    """As SciPy has them, intrinsic."""
    return _each(lambda M: Rotation.from_matrix(M).as_euler(order), (R, 2))


def _quaternion(M):
    x, y, z, w = Rotation.from_matrix(M).as_quat()
    return np.array([w, x, y, z]) * (1 if w >= 0 else -1)


def matrix_to_quaternion(R: Array) -> Array:
    """As SciPy has it, w first and not negative."""
    return _each(_quaternion, (R, 2))


def quaternion_to_matrix(q: Array) -> Array:
    """As SciPy has it."""
    return _each(lambda p: Rotation.from_quat([*p[1:], p[0]]).as_matrix(), (q, 1))


def slerp(R0: Array, R1: Array, t: Array) -> Array:
    """A share of the turn from one to the other."""
    return _each(lambda A, B, u: A @ exponential_map(u * rotation_vector(A.T @ B)), (R0, 2),
                 (R1, 2), (t, 0))


def smooth_rotations(R: Array, time: Array) -> Array:
    """One joint at a time."""
    found = np.zeros((len(time), *R.shape[1:]))
    for index in np.ndindex(R.shape[1:-2]):
        q = [_quaternion(M) for M in R[(slice(None),) + index]]
        for before, after in zip(q, q[1:]):
            after *= 1 if sum(before * after) >= 0 else -1
        spline = CubicSpline(range(len(q)), q)
        found[(slice(None),) + index] = quaternion_to_matrix(np.array([spline(u) for u in time]))
    return found


def shortest_rotation(a: Array, b: Array) -> Array:
    """By the angle between both about their normal; of opposite ones half a turn about x x a, or
    y x a where a is nearly along x."""
    def _turn(u, v):
        if math.hypot(*u) < 1e-12 or math.hypot(*v) < 1e-12:
            return np.eye(3)
        u, v = u / math.hypot(*u), v / math.hypot(*v)
        c = np.cross(u, v)
        if u @ v < -1 + 1e-12:
            c = np.cross(u, [1.0, 0, 0] if abs(u[0]) < 0.9 else [0, 1.0, 0])
            return exponential_map(math.pi * c / math.hypot(*c))
        size = math.hypot(*c)
        return exponential_map(c * (math.atan2(size, u @ v) / size if size else 1.0))
    return _each(_turn, (a, 1), (b, 1))


def orthogonal(M: Array) -> Array:
    """The mean of a matrix and its inverse's transpose, again and again, comes to the orthogonal
    matrix nearest to it."""
    for _ in range(60):
        M = 0.5 * (M + np.linalg.inv(M).T)
    return M


def nearest_rotation(M: Array) -> Array:
    """The orthogonal factor; where that is a reflection, the axis along which the other factor
    stretches least is turned round."""
    def _near(A):
        R = orthogonal(A)
        if np.linalg.det(R) > 0:
            return R
        sizes, axes = np.linalg.eigh(0.5 * (R.T @ A + A.T @ R))
        u = axes[:, np.argmin(sizes)]
        return R - 2 * np.outer(R @ u, u)
    return _each(_near, (M, 2))


def best_rotation(a: Array, b: Array) -> Array:
    """As SciPy aligns vectors."""
    return _each(lambda x, y: Rotation.align_vectors(y, x)[0].as_matrix(), (a, 2), (b, 2))


def bone_lengths(positions: Array) -> Array:
    """The median of each bone's."""
    return np.array([np.median([math.dist(p[i], p[j]) for p in positions]) for i, j in BONES])


def scaled_numbers(features: Array, *, factor: float) -> Array:
    """Of the motion that is so much larger."""
    return np.array([[x if n == 63 else x * factor for n, x in enumerate(row)] for row in features])


def path_error(features: Array, content: Array) -> tuple[float, float]:
    """Frame by frame, from one beginning."""
    ways = [numbers_to_motion(np.concatenate([np.zeros((len(f), 63)), f[:, 63:]], axis=1),
                              np.zeros(4))[:, 0] for f in (features, content)]
    apart = [math.dist(p, q) for p, q in zip(*ways)]
    return sum(apart) / len(apart), max(apart)


def path_length(features: Array) -> float:
    """Step by step; the last row has no step."""
    return math.fsum(math.hypot(*row[64:66]) for row in features[:-1])
