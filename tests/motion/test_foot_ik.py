"""Planted feet stay, legs reach what they can reach, and no bone ever stretches."""

from hypothesis import given, strategies as st
import numpy as np
import pytest

from refimpl.motion import foot_ik
from refimpl.motion.feet import floor_penetration, foot_skate, jerk
from refimpl.motion.joints import BONES, FEET, LEGS, SLOT
from refimpl.embedded.walkers import make_clip
from refimpl.motion.body import make_take


@pytest.fixture(scope="module")
def walk():
    return make_take(make_clip("walk", "normal", seconds=4.0).clip)


def lengths(positions):
    return np.array([np.linalg.norm(positions[:, a] - positions[:, b], axis=1) for a, b in BONES])


def vectors(seed, count):
    return np.random.default_rng(seed).standard_normal((count, 3))


@given(st.integers(0, 2 ** 32 - 1), st.floats(0.1, 10.0), st.floats(0.1, 10.0), st.floats(0.0, 1.0))
def test_a_reachable_target_is_reached_exactly_with_the_knee_on_its_side(seed, thigh, shin, share):
    hip, direction, bend = vectors(seed, 3)
    distance = abs(thigh - shin) + share * (thigh + shin - abs(thigh - shin))
    ankle = hip + distance * direction / np.linalg.norm(direction)
    knee = foot_ik.two_bone(hip[None], ankle[None], np.array([thigh]), np.array([shin]),
                            bend[None])[0]
    size = thigh + shin
    assert abs(np.linalg.norm(knee - hip) - thigh) < 1e-12 * size
    # at the ends of its reach half of the digits
    assert abs(np.linalg.norm(ankle - knee) - shin) < 1e-7 * size
    u = direction / np.linalg.norm(direction)
    assert (knee - hip) @ (bend - bend @ u * u) > -1e-12 * size


@given(st.integers(0, 2 ** 32 - 1), st.integers(1, 40), st.floats(-20.0, 20.0), st.integers(1, 12))
def test_no_bone_ever_stretches(walk, seed, frames, floor, blend):
    """Any labels, any floor, feet pushed out of reach."""
    rng = np.random.default_rng(seed)
    positions = walk.positions[:frames] + rng.normal(0, 3, (frames, 1, 3)).cumsum(axis=0)
    contacts = rng.random((frames, 4)) < rng.random()
    planted = foot_ik.lock_feet(positions, contacts, floor, blend=blend)
    assert np.isfinite(planted).all()
    np.testing.assert_allclose(lengths(planted), lengths(positions), rtol=1e-9)
    above = [j for j in range(21) if j not in np.ravel(LEGS)
             or j in (SLOT["LeftUpLeg"], SLOT["RightUpLeg"])]
    np.testing.assert_array_equal(planted[:, above][..., [0, 2]], positions[:, above][..., [0, 2]])
    assert (planted[:, above, 1] <= positions[:, above, 1]).all()


def sliding(take, speed):
    """The walk on a belt: the root moves on by `speed` a second more than the feet step."""
    positions = take.positions.copy()
    positions[..., 2] += (speed / 60 * np.arange(len(positions)))[:, None]
    return positions


@pytest.mark.parametrize("speed", [0.0, 10.0, -25.0])
def test_planted_feet_do_not_slide_nor_sink_nor_pop(walk, speed):
    positions = sliding(walk, speed)
    positions[:, FEET, 1] -= 1.0
    before = foot_skate(positions, walk.contacts)
    assert before > abs(speed) * 0.7
    planted = foot_ik.lock_feet(positions, walk.contacts, walk.start.floor)
    assert foot_skate(planted, walk.contacts) < 0.35 * before
    assert (floor_penetration(positions, walk.start.floor)[1] > 0.5
            and floor_penetration(planted, walk.start.floor)[1] < 1e-9)
    assert jerk(planted) < 1.1 * jerk(walk.positions)            # locks that begin at once: 3
    again = foot_ik.lock_feet(planted, walk.contacts, walk.start.floor)
    assert np.abs(again - planted).mean() < 0.1


def test_without_labels_and_above_the_floor_nothing_moves(walk):
    planted = foot_ik.lock_feet(walk.positions, np.zeros_like(walk.contacts), -100.0)
    np.testing.assert_allclose(planted, walk.positions, atol=1e-5)


def test_a_toe_that_is_not_planted_is_lifted_out_of_the_floor(walk):
    floor = walk.start.floor + 2.0
    planted = foot_ik.lock_feet(walk.positions, np.zeros_like(walk.contacts), floor)
    assert floor_penetration(planted, floor)[1] < 1e-9 < floor_penetration(walk.positions, floor)[1]


def test_a_body_too_far_away_sinks_smoothly_and_reaches(walk):
    contacts = np.ones((120, 4), bool)
    positions = np.repeat(walk.positions[[20]], 120, axis=0)
    # it jumps, and its feet shall stay
    positions[60:90, :, 1] += 6.0
    planted = foot_ik.lock_feet(positions, contacts, walk.start.floor)
    down = positions[:, 0, 1] - planted[:, 0, 1]
    assert (foot_skate(planted, contacts) < 0.5
            and np.abs(np.diff(planted[:, FEET, 1], axis=0)).max() < 1.2)
    assert down[70] > 3.0 and down[0] < down[70] and np.abs(np.diff(down)).max() < 0.6


@pytest.mark.parametrize("speed, down, hover", [(15.0, (0.0, 0.3), 1.5), (80.0, (2.0, 11.0), 2.5)])
def test_a_body_is_lowered_for_steps_that_are_much_too_long_alone(walk, speed, down, hover):
    """Short steps carried on at another's speed. Where that is a little faster knees stay as
    straight as the style has them."""
    positions = sliding(walk, speed)
    planted = foot_ik.lock_feet(positions, walk.contacts, walk.start.floor)
    assert down[0] <= (positions[:, 0, 1] - planted[:, 0, 1]).max() < down[1]
    assert foot_skate(planted, walk.contacts) < 0.25 * foot_skate(positions, walk.contacts)
    heights = planted[:, FEET[1::2], 1] - walk.start.floor
    assert np.quantile(heights[walk.contacts[:, 1::2].astype(bool)], 0.9) < hover


def test_a_heel_lifts_where_its_leg_is_asked_to_stretch(walk):
    """A body that goes on by half as much again as its feet step, as stylised short steps do."""
    positions, leg = sliding(walk, 60.0), LEGS[0]
    hip, _, ankle, toe = leg
    goal, foot = foot_ik.foot_targets(positions[:, ankle], positions[:, toe],
                                      walk.contacts[:, :2], walk.start.floor)
    held = walk.contacts[:, 0]
    moved, turned = foot_ik.heel_lifted(positions, leg, goal, foot, held)
    np.testing.assert_allclose(moved + turned, goal + foot, atol=1e-9)        # about the toe
    np.testing.assert_allclose(np.linalg.norm(turned, axis=1), np.linalg.norm(foot, axis=1))
    lift = np.linalg.norm(moved - goal, axis=1)
    asked, less = (np.linalg.norm(positions[:, hip] - at, axis=1) for at in (goal, moved))
    assert lift.max() > 3.0 and np.median(lift[held]) < 0.05
    assert (less < asked + 1e-9).all() and (asked - less).max() > 1.5


@pytest.mark.parametrize("frames", [1, 2, 3, 4, 9])
def test_the_smoothest_curve_is_the_one_of_the_full_equations(frames):
    rng = np.random.default_rng(frames)
    values, weight = rng.normal(size=(frames, 2)), rng.random(frames) * (rng.random(frames) < 0.6)
    bends = np.diff(np.eye(frames), n=min(2, frames - 1), axis=0)
    full = 81 * (bends.T @ bends + np.diag(weight)) + np.eye(frames)
    np.testing.assert_allclose(foot_ik.smoothest(values, weight, 3),
                               np.linalg.solve(full, 81 * weight[:, None] * values), atol=1e-12)


def test_a_point_that_no_leg_reaches_is_approached(walk):
    positions = walk.positions.copy()
    positions[..., 2] += np.linspace(0, 3000.0, len(positions))[:, None]
    planted = foot_ik.lock_feet(positions, np.ones_like(walk.contacts), walk.start.floor)
    for hip, knee, ankle, _ in LEGS:
        leg = lengths(positions)[[b == (hip, knee) or b == (knee, ankle)
                                  for b in BONES]].sum(axis=0)
        assert (np.linalg.norm(planted[:, ankle] - planted[:, hip], axis=1)
                <= leg * (1 + 1e-12)).all()


def test_an_ankle_and_a_toe_that_meet_are_one_foot_apart():
    rng = np.random.default_rng(4)
    ankle = rng.normal([0, 10, 0], 1.0, (40, 3))
    toe = ankle + [3.0, -8.0, 12.0] + rng.normal(0, 0.3, (40, 3))
    contacts = np.zeros((40, 2), bool)
    contacts[5:15, 0] = contacts[20:30, 0] = contacts[10:25, 1] = contacts[34:36, 1] = True
    a, b = foot_ik.locks(ankle, toe, contacts, 0.0)
    both = ~np.isnan(a[:, 0]) & ~np.isnan(b[:, 0])
    assert both[10:16].all() and both[20:26].all() and both.sum() > 12
    np.testing.assert_allclose(np.linalg.norm(b - a, axis=1)[both],
                               np.median(np.linalg.norm(toe - ankle, axis=1)), rtol=1e-12)
    assert (np.diff(a[5:16], axis=0) == 0).all() and (np.diff(b[10:26], axis=0) == 0).all()


@pytest.mark.parametrize("blend", [0, 1.5, True, -3])
def test_a_blend_that_cannot_be_is_named(walk, blend):
    with pytest.raises(ValueError,
                       match="blend: found .*, needed a whole number of frames from 1 on"):
        foot_ik.lock_feet(walk.positions, walk.contacts, blend=blend)
