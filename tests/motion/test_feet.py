"""Known answers of the measures of feet on doctored motion."""

import numpy as np
import pytest

from refimpl.motion import feet
from refimpl.motion.features import TRANSLATION
from refimpl.motion.joints import FEET, JOINTS
from refimpl.embedded.walkers import make_clip
from refimpl.motion.body import make_take
from .test_features import random_motion


def standing(frames=60):
    return np.tile(np.random.default_rng(0).uniform(0, 100, (JOINTS, 3)), (frames, 1, 1))


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_a_skate_of_ten_centimetres_a_second_measures_ten(fps):
    positions, contacts = standing(), np.zeros((60, 4), bool)
    contacts[10:40, 1] = True
    positions[:, FEET[1], 0] += 0.06 * np.arange(60) * 100 / fps
    positions[:, FEET[1], 2] += 0.08 * np.arange(60) * 100 / fps
    positions[:, FEET[1], 1] += 3.0 * np.arange(60)                      # up and down is no skate
    positions[:, FEET[2]] += 7.0 * np.arange(60)[:, None]                # nor what is not planted
    assert feet.foot_skate(positions, contacts, fps=fps) == pytest.approx(10.0)


def test_skate_is_the_mean_over_planted_steps_of_all_feet_and_a_label_covers_the_step_that_follows(
    ):
    positions, contacts = standing(4), np.zeros((4, 4), bool)
    positions[2:, FEET[0], 0] += 1.0                                     # between frames 1 and 2
    contacts[1, 0] = contacts[1, 3] = True
    assert feet.foot_skate(positions, contacts, fps=60.0) == pytest.approx(30.0)
    contacts[:] = False
    contacts[2:, 0] = True
    assert feet.foot_skate(positions, contacts) == 0.0
    contacts[:] = False
    # no step follows the last frame
    contacts[3] = True
    assert np.isnan(feet.foot_skate(positions, contacts))


def test_penetration_is_the_deepest_foot_of_each_frame():
    positions = standing(4)
    positions[:, FEET, 1] = 5.0
    positions[1, FEET[2], 1], positions[1, FEET[3], 1], positions[3, FEET[0], 1] = 3.0, 4.0, 1.0
    assert feet.floor_penetration(positions, 5.0) == pytest.approx((1.5, 4.0))
    assert feet.floor_penetration(positions, 0.0) == (0.0, 0.0)
    assert feet.floor_penetration(positions, 0.0, heel_height=2.0,
                                  toe_height=4.5) == pytest.approx(((0.5 + 0.0) / 4 + 0.25, 1.0))


def test_jerk_of_a_cubic_is_its_third_derivative():
    positions = standing(30)
    t = np.arange(30) / 60.0
    positions[:, :, 1] = (t ** 3 / 6 * 250.0)[:, None]
    assert feet.jerk(positions) == pytest.approx(250.0, rel=1e-6)
    assert np.isnan(feet.jerk(positions[:3]))


@pytest.mark.parametrize("call, message", [
    (lambda: feet.foot_skate(np.zeros((5, 20, 3)), np.zeros((5, 4))),
     r"positions: found shape \(5, 20, 3\), needed \(frames, 21, 3\)"),
    (lambda: feet.foot_skate(standing(5) * np.nan, np.zeros((5, 4))),
     "positions: found .*nan.* in frame 0, joint 0"),
    (lambda: feet.foot_skate(standing(5), np.zeros((4, 4))),
     r"contacts: found shape \(4, 4\), needed \(5, 4\)"),
    (lambda: feet.foot_skate(standing(5), np.full((5, 4), 0.5)),
     "contacts: found 0.5, needed labels 0 and 1")])
def test_what_cannot_be_measured_is_named(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_the_pace_is_that_of_the_feet():
    """A walk whose root moves on too fast by a factor wants the inverse."""
    walk = make_take(make_clip("turn-left", "normal", seconds=4.0).clip)
    own = feet.pace(walk.features, walk.contacts)
    assert own == pytest.approx(1.0, abs=0.05)
    fast = walk.features.copy()
    fast[:, TRANSLATION] *= 1.6
    assert feet.pace(fast, walk.contacts) == pytest.approx(own / 1.6)
    assert feet.pace(walk.features, np.zeros_like(walk.contacts)) == 1.0
    still = walk.features.copy()
    still[:, TRANSLATION] = 0.0
    assert feet.pace(still, walk.contacts) == 1.0
    with pytest.raises(ValueError, match=r"features: found shape \(240, 65\)"):
        feet.pace(walk.features[:, 1:], walk.contacts)


def test_contacts_need_slowness_and_lowness():
    motion = np.broadcast_to(random_motion(np.random.default_rng(3), 1), (10, 21, 3)).copy()
    motion[:, FEET, 1] = np.array([11.0, 4.0, 11, 4.0])
    assert feet.foot_contacts(motion).all()
    fast = motion.copy()
    fast[:, FEET[0], 0] += np.arange(10) * 5.0
    assert not feet.foot_contacts(fast)[:, 0].any() and feet.foot_contacts(fast)[:, 1:].all()
    high = motion.copy()
    high[:, FEET[3], 1] += 8.0
    assert not feet.foot_contacts(high)[:, 3].any()
    # the thresholds scale with the character
    for unit in (0.01, 5.4, 100):
        np.testing.assert_array_equal(feet.foot_contacts(fast * unit), feet.foot_contacts(fast))
