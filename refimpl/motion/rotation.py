r"""Rotations as free functions on arrays `[..., 3, 3]` that turn column vectors: `y = R @ x`.

Angles are radians everywhere except inside BVH files. The axes are right-handed.
"""

from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

AXES = "XYZ"


def axis_rotation(axis: str, angle: Any) -> np.ndarray:
    r"""Rotation about one coordinate axis.

    axis : "X", "Y" or "Z";  angle : [...] radians  ->  [..., 3, 3]

        Rx = [1 0 0; 0 c -s; 0 s c]   Ry = [c 0 s; 0 1 0; -s 0 c]   Rz = [c -s 0; s c 0; 0 0 1]

    >>> axis_rotation("Z", np.pi / 2).round(6) @ [1, 0, 0]
    array([0., 1., 0.])
    """
    if not isinstance(axis, str) or len(axis) != 1 or axis not in AXES:
        raise ValueError(f"axis: found {axis!r}, needed one of X, Y, Z")
    angle = np.asarray(angle, dtype=float)
    i = AXES.index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    R = np.zeros(angle.shape + (3, 3))
    c, s = np.cos(angle), np.sin(angle)
    R[..., i, i] = 1.0
    R[..., j, j], R[..., j, k] = c, -s
    R[..., k, j], R[..., k, k] = s, c
    return R


def euler_to_matrix(angles: Any, order: str) -> np.ndarray:
    r"""Intrinsic rotations in the order in which they are listed:
    `R = R_order[0](a0) @ R_order[1](a1) @ ...`

    angles : [..., n] radians, order : a word of n axes such as "ZXY"  ->  [..., 3, 3]

    >>> Z, X = axis_rotation("Z", 0.3), axis_rotation("X", 0.2)
    >>> bool((euler_to_matrix([0.3, 0.2], "ZX") == Z @ X).all())
    True
    """
    angles = np.asarray(angles, dtype=float)
    if not isinstance(order, str) or set(order) - set(AXES) or angles.shape[-1:] != (len(order),):
        raise ValueError(f"order: found {order!r} for {angles.shape[-1:]} angles, needed a word of "
                         "as many of the axes X, Y, Z")
    R = np.broadcast_to(np.eye(3), angles.shape[:-1] + (3, 3))
    for n, axis in enumerate(order):
        R = R @ axis_rotation(axis, angles[..., n])
    return R


def matrix_to_euler(R: np.ndarray, order: str) -> np.ndarray:
    r"""Angles (a, b, c) with `R = R_i(a) @ R_j(b) @ R_k(c)`, the inverse of `euler_to_matrix` for
    three different axes.

    With s = +1 for XYZ, YZX, ZXY and s = -1 for the others, multiplying out gives

        R[i,k] = s sin b,   R[j,k] = -s sin a cos b,   R[k,k] = cos a cos b,
        R[i,j] = -s cos b sin c,   R[i,i] = cos b cos c.

    R : [..., 3, 3], order : three different axes  ->  [..., 3] radians, b in [-pi/2, pi/2].
    At the gimbal pole (cos b = 0) only a +- c is determined; c = 0 is taken.
    Raises ValueError when the order repeats an axis.

    >>> matrix_to_euler(euler_to_matrix([0.3, -0.2, 0.1], "ZXY"), "ZXY").round(6)
    array([ 0.3, -0.2,  0.1])
    """
    if sorted(order) != list(AXES):
        raise ValueError(f"order {order!r}: three different axes are needed to write any rotation "
                         "as Euler angles")
    i, j, k = (AXES.index(axis) for axis in order)
    s = 1.0 if (j - i) % 3 == 1 else -1.0
    R = R if R.dtype.kind in "fc" else R.astype(float)
    cos_b = np.hypot(R[..., j, k], R[..., k, k])
    b = np.arctan2(s * R[..., i, k], cos_b)
    pole = cos_b < 1e-9
    a = np.where(pole, np.arctan2(s * R[..., k, j], R[..., j, j]),
                 np.arctan2(-s * R[..., j, k], R[..., k, k]))
    c = np.where(pole, 0.0, np.arctan2(-s * R[..., i, j], R[..., i, i]))
    return np.stack([a, b, c], axis=-1)


def hat(v: Any) -> np.ndarray:
    r"""The matrix of the cross product: `hat(v) @ x = v x x`.   v : [..., 3]  ->  [..., 3, 3]

    >>> hat([1, 2, 3]) @ [4, 5, 6], np.cross([1, 2, 3], [4, 5, 6])
    (array([-3.,  6., -3.]), array([-3,  6, -3]))
    """
    v = np.asarray(v, dtype=float)
    K = np.zeros(v.shape + (3,))
    K[..., 0, 1], K[..., 0, 2], K[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    return K - K.swapaxes(-1, -2)


def exp_map(v: Any) -> np.ndarray:
    r"""Rodrigues' formula, from a rotation vector (axis times angle) to its matrix:

        R = I + sin t hat(u) + (1 - cos t) hat(u)^2,
        t = |v|,   u = v / t,   1 - cos t = 2 sin^2(t/2)

    v : [..., 3] radians  ->  [..., 3, 3].   Raises ValueError for numbers that are not finite.

    >>> exp_map([0, 0, np.pi / 2]).round(6)
    array([[ 0., -1.,  0.],
           [ 1.,  0.,  0.],
           [ 0.,  0.,  1.]])
    """
    v = np.asarray(v, dtype=float)
    with np.errstate(over="ignore"):
        t = np.hypot(np.hypot(v[..., 0], v[..., 1]), v[..., 2])[..., None]  # squares would overflow
    if not np.isfinite(t).all():
        raise ValueError("v: found a rotation vector whose length is no finite number, needed one "
                         "in radians")
    K = hat(v / np.where(t > 0, t, 1.0))
    t = t[..., None]
    return np.eye(3) + np.sin(t) * K + 2 * np.sin(t / 2) ** 2 * (K @ K)


def log_map(R: Any) -> np.ndarray:
    r"""The shortest rotation vector of a matrix, |v| <= pi, the inverse of `exp_map`.

    By way of the unit quaternion (w, x, y, z), whose largest component is found first so that
    nothing is lost near a half turn:

        v = 2 atan2(|xyz|, w) xyz / |xyz|

    Of exactly half a turn v and -v are one rotation: the one whose largest element is positive.

    R : [..., 3, 3]  ->  [..., 3] radians

    >>> float(log_map(axis_rotation("Y", 1.5 * np.pi))[1].round(4))     # a quarter turn back
    -1.5708
    """
    q = matrix_to_quaternion(R)
    w, xyz = q[..., :1], q[..., 1:]
    s = np.linalg.norm(xyz, axis=-1, keepdims=True)
    factor = np.where(s > 1e-12, 2 * np.arctan2(s, w) / np.where(s > 1e-12, s, 1.0), 2.0)
    return factor * xyz


def matrix_to_quaternion(R: Any) -> np.ndarray:
    r"""Unit quaternion (w, x, y, z), w >= 0, of a rotation.

    4 q q^T is linear in R, so each of its rows is a multiple of q; the row with the largest
    diagonal is the exact one.

    R : [..., 3, 3]  ->  [..., 4]

    >>> matrix_to_quaternion(axis_rotation("Z", np.pi / 3)).round(4)
    array([0.866, 0.   , 0.   , 0.5  ])
    """
    R = np.asarray(R, dtype=float)
    xx, yy, zz = R[..., 0, 0], R[..., 1, 1], R[..., 2, 2]
    wx, wy, wz = (R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0],
                  R[..., 1, 0] - R[..., 0, 1])
    xy, xz, yz = (R[..., 1, 0] + R[..., 0, 1], R[..., 0, 2] + R[..., 2, 0],
                  R[..., 2, 1] + R[..., 1, 2])
    Q = np.stack([1 + xx + yy + zz, wx, wy, wz,
                  wx, 1 + xx - yy - zz, xy, xz,
                  wy, xy, 1 - xx + yy - zz, yz,
                  wz, xz, yz, 1 - xx - yy + zz], axis=-1).reshape(R.shape[:-2] + (4, 4))
    largest = np.argmax(np.diagonal(Q, axis1=-2, axis2=-1), axis=-1)
    q = np.take_along_axis(Q, largest[..., None, None], axis=-2)[..., 0, :]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return np.where(q[..., :1] < 0, -q, q)


def quaternion_to_matrix(q: Any) -> np.ndarray:
    r"""The rotation of a quaternion (w, x, y, z), which need not be of length 1, the inverse of
    `matrix_to_quaternion`:

        R = I + 2 w hat(u) + 2 hat(u)^2,   (w, u) = q / |q|

    q : [..., 4], not 0  ->  [..., 3, 3]

    >>> quaternion_to_matrix([2, 0, 0, 2]).round(6) @ [1, 0, 0]
    array([0., 1., 0.])
    """
    q = np.asarray(q, dtype=float)
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    K = hat(q[..., 1:])
    return np.eye(3) + 2 * q[..., 0, None, None] * K + 2 * K @ K


def slerp(R0: np.ndarray, R1: np.ndarray, t: Any) -> np.ndarray:
    r"""Spherical interpolation along the shortest turn: `R0 exp(t log(R0^T R1))`.

    R0, R1 : [..., 3, 3], t : broadcastable to [...], 0 gives R0 and 1 gives R1  ->  [..., 3, 3]

    >>> log_map(slerp(axis_rotation("X", 0.2), axis_rotation("X", 1.0), 0.25)).round(6)
    array([0.4, 0. , 0. ])
    """
    return R0 @ exp_map(np.asarray(t)[..., None] * log_map(R0.swapaxes(-1, -2) @ R1))


def smooth_rotations(R: np.ndarray, time: np.ndarray) -> np.ndarray:
    r"""A smooth way through rotations, read at any times: a cubic spline through their unit
    quaternions, brought back to length 1.

        R(t) = matrix of s(t) / |s(t)|,   s the spline with s(n) = +-q_n,   q_n . q_{n+1} >= 0

    Of the two quaternions of each rotation the one nearer to the rotation before is taken. Turning
    the world or the body turns the whole way (multiplying by a quaternion is linear).

    R : (T, ..., 3, 3), given at times 0 .. T - 1;  time : (U,) within them  ->  (U, ..., 3, 3)

    >>> R = axis_rotation("X", [0, 1, 2, 3])
    >>> log_map(smooth_rotations(R, np.array([0, 1.5])))[:, 0].round(2)
    array([0. , 1.5])
    """
    q = matrix_to_quaternion(R)
    turns = np.sign(np.sum(q[1:] * q[:-1], axis=-1, keepdims=True))
    q[1:] *= np.cumprod(np.where(turns == 0, 1.0, turns), axis=0)
    return quaternion_to_matrix(CubicSpline(np.arange(len(q)), q)(time))


def shortest_rotation(a: Any, b: Any) -> np.ndarray:
    r"""The smallest rotation that turns the direction of a into that of b (no twist about either).

        R = I + hat(c) + hat(c)^2 / (1 + a.b),   c = a x b,  for unit a, b

    a, b : [..., 3]  ->  [..., 3, 3]. A zero vector gives the identity; opposite vectors a half turn
    about some normal.

    >>> (shortest_rotation([2, 0, 0], [0, 3, 0]) @ [2, 0, 0]).round(6)
    array([0., 2., 0.])
    """
    a, b = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    na, nb = np.linalg.norm(a, axis=-1, keepdims=True), np.linalg.norm(b, axis=-1, keepdims=True)
    zero = (na < 1e-12) | (nb < 1e-12)
    a, b = (np.where(zero, [1.0, 0, 0], a / np.where(zero, 1, na)),
            np.where(zero, [1.0, 0, 0], b / np.where(zero, 1, nb)))
    dot = np.sum(a * b, axis=-1)[..., None, None]
    K = hat(np.cross(a, b))
    opposite = dot < -1 + 1e-12
    normal = np.cross(a, np.where(np.abs(a[..., :1]) < 0.9, [1.0, 0, 0], [0, 1.0, 0]))
    normal = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    return np.where(opposite, exp_map(np.pi * normal),
                    np.eye(3) + K + K @ K / np.where(opposite, 1.0, 1 + dot))


def nearest_rotation(M: np.ndarray) -> np.ndarray:
    r"""The rotation nearest to a matrix, in the sum of squared differences of their entries:

        R = U diag(1, 1, det(U V^T)) V^T,   M = U S V^T

    M : [..., 3, 3], for example a mean of rotations  ->  [..., 3, 3]

    >>> float(log_map(nearest_rotation(axis_rotation("X", [0.1, 0.3]).mean(axis=0)))[0].round(6))
    0.2
    """
    U, _, Vt = np.linalg.svd(M)
    U[..., :, 2] *= np.sign(np.linalg.det(U @ Vt))[..., None]
    return U @ Vt


def best_rotation(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    r"""The rotation that brings several vectors a_n nearest to b_n in the least-squares sense
    (Kabsch): `nearest_rotation` of sum_n b_n a_n^T.

    a, b : [..., n, 3]  ->  [..., 3, 3]

    >>> a, R = np.eye(3)[:2], axis_rotation("Y", 0.5)
    >>> float(np.abs(best_rotation(a, 7 * a @ R.T) - R).max().round(6))
    0.0
    """
    return nearest_rotation(b.swapaxes(-1, -2) @ a)


def nearest_turn(angle: Any) -> np.ndarray:
    """The same angle within half a turn of zero, radians.

    >>> float(nearest_turn(1.5 * np.pi) / np.pi)
    -0.5
    """
    return (angle + np.pi) % (2 * np.pi) - np.pi


def yaw_rotation(yaw: Any) -> np.ndarray:
    r"""Turn about the vertical y axis: a figure that faces +z at yaw 0 faces (sin yaw, 0, cos yaw),
    the last column; positive is to its left.

    >>> yaw_rotation(np.pi / 2).round(6) @ [0, 0, 1]
    array([1., 0., 0.])
    """
    return axis_rotation("Y", yaw)
