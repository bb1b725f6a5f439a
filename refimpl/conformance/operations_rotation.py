"""The specifications of rotations, and of measures of the 66 numbers."""

import numpy as np

from ..motion import features, rotation
from ..motion.features import FEATURES, TURN
from . import definitions_learning as learning, definitions_rotation as definitions
from .specification import called, operation, refused


def _rotations(rng, *shape):
    return learning.exponential_map(rng.standard_normal((*shape, 3)) * 1.5)


def _angle_samples(rng):
    n = rng.standard_normal
    return [called(order, n((2, 4, len(order))) * 2, order=order)
            for order in ("ZXY", "XYZ", "YX", "Z", "XYX")]


def _euler_samples(rng):
    R = _rotations(rng, 2, 5)
    return [called(order, R, order=order) for order in ("ZXY", "XYZ", "YZX", "ZYX", "XZY", "YXZ")]


def _pole_samples(rng):
    """Of the middle angle a quarter turn, where the last angle is 0."""
    def _pole(order, sign):
        angles = np.array([[0.7, sign * np.pi / 2, 0.0], [-2.5, sign * np.pi / 2, 0.0]])
        return called(f"{order}, {sign:g} of a quarter turn",
                      definitions.euler_to_matrix(angles, order=order), order=order, firm=True)
    return [_pole(order, sign) for order in ("ZXY", "XYZ") for sign in (1.0, -1.0)]


def _quaternion_samples(rng):
    q = rng.standard_normal((3, 4, 4))
    return [called("plain", q / np.linalg.norm(q, axis=-1, keepdims=True)),
            called("of any length", q * 7.0),
            called("one", q[0, 0]), called("no turn and half turns", np.eye(4))]


def _matrix_samples(rng):
    steps = [learning.exponential_map(angle * np.eye(3)) for angle in (3.1, 2.9, -3.0)]
    return [called("plain", _rotations(rng, 3, 4)), called("one", _rotations(rng)),
            called("nearly half a turn about each axis", np.array(steps)),
            called("no turn", np.eye(3)[None])]


def _slerp_samples(rng):
    A = _rotations(rng, 5)
    B = A @ learning.exponential_map(rng.uniform(-1, 1, (5, 3)) * 1.5)
    return [called("plain", A, B, rng.uniform(0, 1, 5)),
            called("ends", A, B, np.array([0.0, 1.0, 0.5, 1.5, -0.5])),
            called("one", A[0], B[0], np.array(0.3)),
            called("the same", A, A.copy(), rng.uniform(0, 1, 5))]


def _smooth_samples(rng):
    turning = learning.exponential_map(rng.uniform(-1, 1, (9, 2, 3)).cumsum(axis=0))
    return [called("plain", turning, rng.uniform(0, 8, 7)),
            called("at the frames", turning, np.arange(9.0)),
            called("four frames", turning[:4], np.array([0.5, 2.75]))]


def _vector_samples(rng):
    a = rng.standard_normal((6, 3))
    b = rng.standard_normal((6, 3)) * 4
    axes = np.eye(3)
    return [called("plain", a, b), called("the same direction", a, 3 * a),
            called("opposite", np.concatenate([axes, [[3.0, 4.0, 0.0]]]),
                   -2 * np.concatenate([axes, [[3.0, 4.0, 0.0]]])),
            called("nothing", np.zeros((2, 3)), b[:2]), called("to nothing", a[:2], 0 * a[:2]),
            called("nearly opposite", a, -a + 1e-3 * b), called("one", a[0], b[0])]


def _near_samples(rng):
    n = rng.standard_normal
    return [called("plain", _rotations(rng, 4) + 0.2 * n((4, 3, 3))),
            called("a mean", _rotations(rng, 3).mean(axis=0)),
            called("reflections", -_rotations(rng, 3) + 0.3 * n((3, 3, 3))),
            called("large", 1e5 * (_rotations(rng, 2) + 0.1 * n((2, 3, 3))))]


def _best_samples(rng):
    n = rng.standard_normal
    a, R = n((3, 5, 3)), _rotations(rng, 3)
    return [called("plain", a, a @ R.swapaxes(1, 2) + 0.1 * n((3, 5, 3))),
            called("two vectors", a[:, :2], a[:, :2] @ R.swapaxes(1, 2))]


def _number_samples(rng):
    def _numbers(frames):
        found = rng.standard_normal((frames, FEATURES))
        found[:, TURN] *= 0.2
        return found
    return [(label, _numbers(frames), _numbers(frames))
            for label, frames in (("plain", 7), ("two frames", 2), ("one frame", 1))]


def _one(f, arguments, samples, bad=list, **rest):
    return operation(f, arguments, definitions,
                     samples, bad, "motion", **{"batched": (), "precisions": ("float64",), **rest})


OPERATIONS = (
    _one(rotation.euler_to_matrix, "angles", _angle_samples,
         lambda: [refused("another count of angles", "order", np.zeros((2, 3)), order="ZX"),
                  refused("no axis", "order", np.zeros((2, 3)), order="ZXW")], tolerance=10.0),
    _one(rotation.matrix_to_euler, "R", _euler_samples,
         lambda: [refused("one axis twice", "order 'ZXZ'", np.eye(3), order="ZXZ")],
         tolerance=1e2, ground=_pole_samples),
    _one(rotation.matrix_to_quaternion, "R", _matrix_samples, tolerance=10.0),
    _one(rotation.quaternion_to_matrix, "q", _quaternion_samples, tolerance=10.0),
    _one(rotation.slerp, "R0 R1 t", _slerp_samples, tolerance=1e2),
    _one(rotation.smooth_rotations, "R time", _smooth_samples, tolerance=1e3),
    _one(rotation.shortest_rotation, "a b", _vector_samples, tolerance=1e3),
    _one(rotation.nearest_rotation, "M", _near_samples, tolerance=1e3),
    _one(rotation.best_rotation, "a b", _best_samples, tolerance=1e3),
    _one(features.bone_lengths, "positions", lambda rng: [
        called(f"{frames} frames", rng.standard_normal((frames, 21, 3)))
        for frames in (6, 7, 1)]),
    _one(features.scale, "features", lambda rng: [
        called(label, here, factor=2.7) for label, here, _ in _number_samples(rng)],
        name="scaled_numbers"),
    _one(features.path_error, "features content", lambda rng: [
        called(label, here, there) for label, here, there in _number_samples(rng)]),
    _one(features.path_length, "features", lambda rng: [
        called(label, here) for label, here, _ in _number_samples(rng)]))
