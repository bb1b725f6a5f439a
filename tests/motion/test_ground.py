"""Floor and planted feet: not moved by bad rows, noise, rows that stand twice, or another body."""

import numpy as np
import pytest

from refimpl.embedded.walkers import make_clip
from refimpl.motion import foot_ik
from refimpl.motion.body import make_take
from refimpl.motion.features import leg_length
from refimpl.motion.ground import planted_feet, resting_heights
from refimpl.motion.joints import FEET, LEGS, SLOT
from refimpl.motion.rotation import yaw_rotation

CLIPS = {what: make_take(make_clip(*what, seconds=4.0).clip).positions
         for what in (("walk", "normal"), ("walk", "old"), ("jog", "normal"))}


def shares(contacts):
    return 100 * contacts.mean(axis=0)


def raised(positions, joints, height):
    """The joints higher, each foot's bones as they come."""
    moved = positions.copy()
    moved[:, joints, 1] += height
    return moved


@pytest.mark.parametrize("what", CLIPS, ids="-".join)
@pytest.mark.parametrize("rows", [1, 4])
@pytest.mark.parametrize("depth", [-20.0, -10.0, -5.0, -2.0, 5.0, 20.0])
def test_a_few_bad_rows_move_nothing(what, rows, depth):
    positions = CLIPS[what]
    floor, contacts = planted_feet(positions)
    bad = positions.copy()
    bad[np.random.default_rng(rows).choice(np.arange(5, 235, 5), rows, False), :, 1] += depth
    found, labels = planted_feet(bad)
    assert abs(found - floor) < 1.0
    assert np.abs(shares(labels) - shares(contacts)).max() <= 2.0


@pytest.mark.parametrize("what", CLIPS, ids="-".join)
@pytest.mark.parametrize("height", [2.0, 4.0, 6.0])
def test_feet_are_planted_at_the_heights_of_their_own_body(what, height):
    positions = CLIPS[what]
    floor, contacts = planted_feet(positions)
    heels, toes = FEET[::2], FEET[1::2]
    for joints, lifted in ((heels, 0.0), (toes, height)):
        found, labels = planted_feet(raised(positions, joints, height))
        assert abs(found - floor - lifted) < 1e-6
        assert np.abs(shares(labels) - shares(contacts)).max() <= 3.0     # the leg is shorter


def test_it_knows_no_unit_place_or_direction():
    positions = CLIPS["walk", "normal"]
    floor, contacts = planted_feet(positions)
    turned = 0.01 * (positions @ yaw_rotation(1.0).T + [50.0, 100.0, -70.0])
    found, labels = planted_feet(turned)
    assert found == pytest.approx(0.01 * (floor + 100.0))
    np.testing.assert_array_equal(labels, contacts)


@pytest.mark.parametrize("what", CLIPS, ids="-".join)
@pytest.mark.parametrize("noise", [0.1, 0.25, 0.5])
def test_noise_of_a_capture_takes_no_labels_away(what, noise):
    """Half a degree at a leg of 80 cm is 0.7 cm at its foot."""
    positions = CLIPS[what]
    size = np.radians(noise) * leg_length(positions)
    shaken = positions + np.random.default_rng(3).normal(0, size / 2, positions.shape)
    assert np.abs(shares(planted_feet(shaken)[1])
                  - shares(planted_feet(positions)[1])).max() <= 8.0


@pytest.mark.parametrize("what", CLIPS, ids="-".join)
def test_rows_that_stand_twice_change_little(what):
    positions = CLIPS[what]
    held = positions[2 * (np.arange(len(positions)) // 2)]
    assert np.abs(shares(planted_feet(held)[1]) - shares(planted_feet(positions)[1])).max() <= 5.0


def test_a_foot_that_is_held_up_is_not_planted():
    positions = np.repeat(CLIPS["walk", "normal"][[20]], 200, axis=0)
    positions[:, list(LEGS[0][2:]), 1] += 30.0                   # the left foot
    floor, contacts = planted_feet(positions)
    assert contacts[:, 2:].all() and not contacts[:, :2].any()
    assert floor == resting_heights(positions)[3]


def plant(labels):
    """A standing figure whose right foot glides from -15 to 15 cm in 60 frames."""
    positions = np.repeat(CLIPS["walk", "normal"][[20]], 60, axis=0)
    _, knee, ankle, toe = LEGS[1]
    for joint in (ankle, toe):
        positions[:, joint, 2] += np.linspace(-15, 15, 60) - 5
    contacts = np.zeros((60, 4), bool)
    contacts[:, :2] = True
    contacts[10:50, 2:] = True
    contacts[labels, 2:] = False
    locked = foot_ik.lock_feet(positions, contacts, resting_heights(positions)[1::2])
    return np.diff(locked[:, SLOT["RightFoot"]], axis=0)


@pytest.mark.parametrize("gap", [[30], [30, 31], range(30, 34), range(30, 38), [12], [20, 30, 40],
                                 range(15, 45, 2)], ids=str)
def test_a_gap_in_a_label_does_not_make_a_foot_jump(gap):
    whole, broken = plant([]), plant(list(gap))
    for order in (0, 1):
        sizes = [np.linalg.norm(np.diff(steps, n=order, axis=0), axis=1).max()
                 for steps in (broken, whole)]
        assert sizes[0] <= 1.2 * sizes[1]


@pytest.mark.parametrize("held", [[], [0], [1], [0, 1]], ids=["none", "heel", "toe", "both"])
def test_no_toe_goes_through_the_floor_whatever_is_locked(held):
    positions = np.repeat(CLIPS["walk", "normal"][[20]], 60, axis=0)
    toe, floor = SLOT["LeftToe"], resting_heights(positions)[1]
    positions[20:40, toe, 1] = floor - 5.0
    contacts = np.zeros((60, 4), bool)
    contacts[:, held] = True
    locked = foot_ik.lock_feet(positions, contacts, floor)
    assert locked[:, toe, 1].min() > floor - 0.05
