"""The 66 numbers and back, and what they must not depend on."""

from hypothesis import given, strategies as st
import numpy as np
import pytest

from refimpl.holden2017 import losses
from refimpl.motion import features as F, rotation
from refimpl.motion.joints import FEET, SLOT


def random_motion(rng, frames=60):
    """A smooth wandering cloud of 21 points that looks enough like a body: hips apart, shoulders
    apart, legs of some length.
    """
    rest = rng.normal(size=(21, 3)) * 10 + [0, 90, 0]
    for name, x, y in (("LeftUpLeg", 10, 90), ("RightUpLeg", -10, 90), ("LeftArm", 20, 140),
                       ("RightArm", -20, 140), ("LeftLeg", 10, 50), ("RightLeg", -10, 50),
                       ("LeftFoot", 10, 12), ("RightFoot", -10, 12)):
        rest[SLOT[name]] = [x, y, 0]
    t = np.arange(frames)[:, None, None]
    wobble = np.sin(t * rng.uniform(0.02, 0.2, (21, 3)) + rng.uniform(0, 6, (21, 3)))
    yaw = np.cumsum(rng.normal(0, 0.02, frames))
    path = np.cumsum(rng.normal(0, 1, (frames, 1, 3)) * [1, 0, 1], axis=0)
    return (rest + wobble) @ rotation.yaw_rotation(yaw).swapaxes(1, 2) + path


@given(st.integers(0, 10_000), st.integers(1, 80))
def test_round_trip(seed, frames):
    motion = random_motion(np.random.default_rng(seed), frames)
    x, start = F.encode(motion)
    np.testing.assert_allclose(F.decode(x, start), motion, atol=1e-9 * 80)


@given(st.integers(0, 10_000), st.floats(-3, 3), st.floats(-500, 500), st.floats(-500, 500),
       st.floats(-50, 50))
def test_features_do_not_depend_on_where_and_which_way_it_starts(seed, yaw, dx, dz, dy):
    motion = random_motion(np.random.default_rng(seed))
    moved = motion @ rotation.yaw_rotation(yaw).T + [dx, dy, dz]
    np.testing.assert_allclose(F.encode(moved)[0], F.encode(motion)[0], atol=1e-9)


@given(st.integers(0, 10_000), st.floats(0.01, 100))
def test_features_scale_with_the_unit(seed, factor):
    motion = random_motion(np.random.default_rng(seed))
    np.testing.assert_allclose(F.encode(motion * factor)[0], F.scale(F.encode(motion)[0], factor),
                               rtol=1e-7, atol=1e-9 * factor)


def test_walking_forward_and_turning_left_have_positive_numbers():
    motion = random_motion(np.random.default_rng(1), 100)
    still = np.broadcast_to(motion[:1], motion.shape)
    forward = np.arange(100)[:, None, None] * np.array([0, 0, 2.0])
    x, start = F.encode(still @ rotation.yaw_rotation(-F.encode(still)[1].yaw).T + forward)
    np.testing.assert_allclose(x[30:70, F.FORWARD], 2.0, atol=1e-9)
    np.testing.assert_allclose(x[30:70, F.SIDEWAYS], 0.0, atol=1e-9)
    turns = rotation.yaw_rotation(0.01 * np.arange(400)).swapaxes(1, 2)
    turning = np.broadcast_to(motion[:1], (400, 21, 3)) @ turns
    np.testing.assert_allclose(F.encode(turning)[0][100:300, F.TURN], 0.01, atol=1e-6)


def test_a_step_is_seen_from_where_it_leads():
    """A quarter turn to the left and a step along the new heading: forward, not sideways."""
    x = np.zeros((3, 66))
    x[0, F.TURN], x[0, F.FORWARD] = np.pi / 2, 1.0
    root, yaw = F.root_motion(x)
    # +x is to the left of +z
    np.testing.assert_allclose(root, [[0, 0, 0], [1, 0, 0], [1, 0, 0]], atol=1e-15)
    np.testing.assert_allclose(yaw, [0, np.pi / 2, np.pi / 2])


@given(st.integers(0, 10_000), st.floats(0.002, 0.03), st.floats(1.0, 4.0))
def test_a_foot_that_stands_still_is_still_to_second_order(seed, turn, speed):
    """Equation 7 and the velocity's frame fit each other: at most turn^2 / 2 of a foot's distance
    is left.
    """
    rng = np.random.default_rng(seed)
    yaw = turn * np.arange(120)
    ahead = np.stack([np.sin(yaw), 0 * yaw, np.cos(yaw)], axis=1)
    pose = random_motion(rng, 1)[0]
    motion = (pose @ rotation.yaw_rotation(yaw).swapaxes(1, 2)
              + np.cumsum(speed * ahead, axis=0)[:, None])
    motion[:, FEET] = motion[60, FEET]
    x, _ = F.encode(motion, floor=0.0)
    left = np.linalg.norm(losses.foot_velocities(x.T[None])[0, :, :, 30:90], axis=1)
    reach = np.linalg.norm(x[30:90, F.POSITIONS].reshape(60, 21, 3)[:, FEET][..., [0, 2]],
                           axis=-1).T
    assert (left <= 0.51 * x[30:90, F.TURN] ** 2 * reach + 1e-9).all()


def test_path_error_and_length_by_hand():
    x, y = np.zeros((2, 5, 66))
    x[:, F.FORWARD], y[:, F.FORWARD] = 2.0, 1.0
    assert F.path_length(x) == 8.0 and F.path_error(x, y) == (2.0, 4.0)


def test_last_row_repeats_the_velocities_and_one_frame_stands_still():
    x, _ = F.encode(random_motion(np.random.default_rng(2)))
    np.testing.assert_array_equal(x[-1, F.VELOCITIES], x[-2, F.VELOCITIES])
    one, start = F.encode(random_motion(np.random.default_rng(2), 1))
    assert one.shape == (1, 66) and not one[0, F.VELOCITIES].any()


@pytest.mark.parametrize("bad, words",
                         [(np.zeros((3, 20, 3)), "needed \\(frames, 21, 3\\)"),
                          (np.zeros((0, 21, 3)), "at least one"),
                                        (np.full((2, 21, 3), np.nan), "frame 0")])
def test_bad_positions_are_refused(bad, words):
    with pytest.raises(ValueError, match=words):
        F.encode(bad)


def test_bad_features_are_refused():
    with pytest.raises(ValueError, match="needed \\(frames, 66\\)"):
        F.decode(np.zeros((3, 65)))


def test_floor_is_the_resting_height_of_the_lowest_foot():
    motion = np.broadcast_to(random_motion(np.random.default_rng(3), 1), (200, 21, 3)).copy()
    motion[:, FEET, 1] = np.array([12.0, 4.25, 12, 4.25])
    # one frame below: a stumble of the capture
    motion[50, FEET[1], 1] = 3.5
    assert abs(F.floor_height(motion) - 4.25) < 0.03
