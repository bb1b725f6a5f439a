"""Rotations against scipy's and against their own inverses."""

import itertools

from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from refimpl.motion import rotation

angles = arrays(float, (4, 3), elements=st.floats(-7, 7))
vectors = arrays(float, (5, 3), elements=st.floats(-3, 3))
ORDERS = ["".join(p) for p in itertools.permutations("XYZ")]


@pytest.mark.parametrize("order", ORDERS + ["X", "ZX", "XYX"])
@given(angles)
def test_euler_agrees_with_scipy(order, values):
    values = values[:, :len(order)]
    expected = Rotation.from_euler(order, values).as_matrix()
    np.testing.assert_allclose(rotation.euler_to_matrix(values, order), expected, atol=1e-13)


@pytest.mark.parametrize("order", ORDERS)
@given(angles)
def test_euler_round_trip(order, values):
    R = rotation.euler_to_matrix(values, order)
    np.testing.assert_allclose(rotation.euler_to_matrix(rotation.matrix_to_euler(R, order), order),
                               R, atol=1e-8)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("pole", [np.pi / 2, -np.pi / 2])
def test_euler_at_the_gimbal_pole(order, pole):
    R = rotation.euler_to_matrix([0.3, pole, -1.1], order)
    np.testing.assert_allclose(rotation.euler_to_matrix(rotation.matrix_to_euler(R, order), order),
                               R, atol=1e-12)


def test_repeated_axes_are_refused():
    with pytest.raises(ValueError, match="three different axes"):
        rotation.matrix_to_euler(np.eye(3), "XYX")


@given(vectors)
def test_exponential_map_agrees_with_scipy(v):
    np.testing.assert_allclose(rotation.exp_map(v), Rotation.from_rotvec(v).as_matrix(), atol=1e-13)


@given(vectors)
def test_logarithm_inverts_the_exponential(v):
    R = rotation.exp_map(v)
    np.testing.assert_allclose(rotation.exp_map(rotation.log_map(R)), R, atol=1e-13)
    short = v * (np.pi * 0.99 / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), np.pi))
    np.testing.assert_allclose(rotation.log_map(rotation.exp_map(short)), short, atol=1e-10)


def test_logarithm_of_a_half_turn():
    for axis in np.eye(3):
        v = rotation.log_map(rotation.exp_map(np.pi * axis))
        np.testing.assert_allclose(np.abs(v), np.pi * axis, atol=1e-12)


@given(vectors, vectors)
def test_shortest_rotation(a, b):
    R = rotation.shortest_rotation(a, b)
    np.testing.assert_allclose(R @ R.swapaxes(1, 2), np.broadcast_to(np.eye(3), R.shape), atol=1e-9)
    np.testing.assert_allclose(np.linalg.det(R), 1, atol=1e-9)
    big = (np.linalg.norm(a, axis=1) > 1e-6) & (np.linalg.norm(b, axis=1) > 1e-6)
    turned = (R @ a[..., None])[..., 0]
    cosine = (np.sum(turned * b, axis=1)[big] / np.linalg.norm(a, axis=1)[big]
              / np.linalg.norm(b, axis=1)[big])
    np.testing.assert_allclose(cosine, 1, atol=1e-9)


def test_shortest_rotation_of_opposite_vectors_is_a_half_turn():
    R = rotation.shortest_rotation(np.array([[0, 0, 2.0]]), np.array([[0, 0, -1.0]]))
    np.testing.assert_allclose(R[0] @ [0, 0, 1], [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(R), 1)


@given(arrays(float, (3,), elements=st.floats(-3, 3)))
def test_best_rotation_finds_the_rotation_that_was_applied(v):
    a = np.array([[1.0, 0, 0], [0.3, 2, 0], [-1, 0.2, 0.7]])
    R = rotation.exp_map(v)
    np.testing.assert_allclose(rotation.best_rotation(a, a @ R.T), R, atol=1e-12)


def test_best_rotation_never_mirrors():
    a = np.eye(3)
    np.testing.assert_allclose(np.linalg.det(rotation.best_rotation(a, -a)), 1)


def test_slerp_is_halfway_at_one_half():
    R0, R1 = rotation.exp_map([0, 0.2, 0]), rotation.exp_map([0, 1.0, 0])
    np.testing.assert_allclose(rotation.slerp(R0, R1, 0.5), rotation.exp_map([0, 0.6, 0]),
                               atol=1e-14)
    np.testing.assert_allclose(rotation.slerp(R0, R1, 0.0), R0, atol=1e-14)
    np.testing.assert_allclose(rotation.slerp(R0, R1, 1.0), R1, atol=1e-14)


def test_positive_yaw_turns_forward_to_the_left():
    np.testing.assert_allclose(rotation.yaw_rotation(np.pi / 2) @ [0, 0, 1], [1, 0, 0], atol=1e-15)
