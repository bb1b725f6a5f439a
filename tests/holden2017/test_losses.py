"""The five losses: hand-worked values, and every gradient against the instruments of `nn.check_gradient`."""

import numpy as np
import pytest

from refimpl import nn
from refimpl.holden2017 import losses
from refimpl.motion import features as F
from refimpl.motion.joints import BONES, FEET, SLOT


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def motion(rng, clips=2, frames=6):
    x = rng.normal(size=(clips, 66, frames)) * 5
    x[:, F.TURN] *= 0.02
    return x


def test_content_loss_by_hand():
    H = np.array([[[3.0, 0], [0, 4]]])
    np.testing.assert_allclose(losses.content_loss(H, np.zeros_like(H)), [5.0])
    np.testing.assert_allclose(losses.content_loss(H, np.zeros_like(H), c=2.0, squared=True), [2 * 25 / 4])


def test_style_loss_by_hand():
    H = np.array([[[1.0, 2], [0, 1]]])                           # Gram matrix [[5, 2], [2, 1]]
    np.testing.assert_allclose(losses.style_loss(np.zeros((1, 2, 2)), H, s=1.0), [np.sqrt(25 + 4 + 4 + 1)])
    np.testing.assert_allclose(losses.style_loss(nn.gram(H), H), [0.0])


def test_style_target_counts_frames(rng):
    a, b = rng.normal(size=(3, 10)), rng.normal(size=(3, 30))
    joined = nn.gram(np.concatenate([a, b], axis=1)[None])[0]
    np.testing.assert_allclose(losses.style_target([a, b], 20), joined * 20 / 40)


def test_foot_loss_of_a_foot_that_slides_by_hand():
    x = np.zeros((1, 66, 3))
    x[0, F.FORWARD] = 2.0                                        # the body glides forward by 2 a frame, the feet stay below it
    contacts = np.zeros((1, 4, 3))
    contacts[0, 1] = 1                                           # the left toe should be planted
    np.testing.assert_allclose(losses.foot_loss(x, contacts), [2 * 2.0 ** 2])
    np.testing.assert_allclose(losses.foot_loss(x, contacts, target=np.array([0, 0, 2.0])[:, None]), [0.0])


def test_foot_velocities_are_those_of_the_decoded_motion(rng):
    """To first order in the turning velocity: world velocities of `features.decode`, turned into the character's frame."""
    from refimpl.motion.rotation import yaw_rotation
    x = motion(rng, 1, 20)
    x[0, F.TURN] *= 1e-3
    world = F.decode(x[0].T)[:, FEET]
    yaw = F.root_motion(x[0].T)[1]
    expected = np.diff(world, axis=0) @ yaw_rotation(-yaw[:-1]).swapaxes(1, 2)           # (T-1, 4, 3)
    # velocity of the point seen at its new place: p[t+1] - p[t] is turned by the small angle too, hence the tolerance
    np.testing.assert_allclose(losses.foot_velocities(x)[0].transpose(2, 0, 1), expected, atol=5e-3)


def test_bone_loss_by_hand():
    x = np.zeros((1, 66, 2))
    p = losses.joint_positions(x)
    p[:, SLOT["LeftFoot"], 0] = 3.0
    p[:, SLOT["LeftFoot"], 1] = 4.0
    lengths = np.zeros(len(BONES))
    lengths[BONES.index((SLOT["LeftLeg"], SLOT["LeftFoot"]))] = 4.0          # it is 5 long; the bone below it as well, and should be 0
    np.testing.assert_allclose(losses.bone_loss(x, lengths), [2 * (1.0 + 25.0)])


def test_bone_of_length_zero_has_gradient_zero():
    x = np.zeros((1, 66, 2))
    assert not losses.bone_loss_backward(np.ones(1), x, np.ones(len(BONES))).any()


def test_trajectory_loss_by_hand():
    x, wanted = np.zeros((1, 66, 2)), np.zeros((1, 3, 2))
    x[0, F.TURN], x[0, F.SIDEWAYS] = 0.1, 3.0
    np.testing.assert_allclose(losses.trajectory_loss(x, wanted), [2 * (0.01 + 9)])
    np.testing.assert_allclose(losses.trajectory_loss(x, wanted, turn_weight=100.0), [2 * (1 + 9)])


@pytest.mark.parametrize("squared", [False, True])
def test_content_and_style_gradients(rng, squared):
    A, B = rng.normal(size=(2, 5, 7)), rng.normal(size=(2, 5, 7))
    nn.check_gradient(lambda a, b: losses.content_loss(a, b, c=1.7, squared=squared),
                      lambda d, a, b: losses.content_loss_backward(d, a, b, c=1.7, squared=squared), A, B)
    G = rng.normal(size=(2, 5, 5))
    nn.check_gradient(lambda g, h: losses.style_loss(g, h, s=0.3, squared=squared),
                      lambda d, g, h: losses.style_loss_backward(d, g, h, s=0.3, squared=squared), G, A)


def test_constraint_gradients(rng):
    x = motion(rng)
    contacts = (rng.random((2, 4, 6)) < 0.5).astype(float)
    target = rng.normal(size=(2, 4, 3, 5))
    lengths = rng.uniform(1, 5, len(BONES))
    wanted = rng.normal(size=(2, 3, 6))
    for f, backward in (
            (lambda m: losses.foot_loss(m, contacts), lambda d, m: losses.foot_loss_backward(d, m, contacts)),
            (lambda m: losses.foot_loss(m, contacts, target=target), lambda d, m: losses.foot_loss_backward(d, m, contacts, target=target)),
            (lambda m: losses.bone_loss(m, lengths), lambda d, m: losses.bone_loss_backward(d, m, lengths)),
            (lambda m: losses.trajectory_loss(m, wanted, turn_weight=9.0),
             lambda d, m: losses.trajectory_loss_backward(d, m, wanted, turn_weight=9.0))):
        nn.check_gradient(f, backward, x)
    nn.check_gradient(losses.foot_velocities, losses.foot_velocities_backward, x)


def test_real_planted_feet_cost_nearly_nothing():
    """On motion whose feet truly stand, equation 7 is small; shifting the body's velocity makes it large."""
    from refimpl.motion.synthetic import make_clip
    from refimpl.motion.take import make_take
    made = make_clip("walk", "normal", seconds=4.0)
    take = make_take(made.clip)
    x, contacts = take.features.T[None], made.contacts.T[None].astype(float)
    planted = losses.foot_loss(x, contacts)[0] / contacts[:, :, :-1].sum()
    x = x.copy()
    x[0, F.FORWARD] += 1.0
    slid = losses.foot_loss(x, contacts)[0] / contacts[:, :, :-1].sum()
    assert planted < 1e-2 and 0.5 < slid < 2.0
