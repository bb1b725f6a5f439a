"""The five losses: hand-worked values, and every gradient against the instruments of
`nn.check_gradient`.
"""

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
    np.testing.assert_allclose(losses.content_loss(H, np.zeros_like(H), c=2.0,
                                                   reading="mean_squares"), [2 * 25 / 4])


def test_style_loss_by_hand():
    H = np.array([[[1.0, 2], [0, 1]]])                           # Gram matrix [[5, 2], [2, 1]]
    np.testing.assert_allclose(losses.style_loss(np.zeros((1, 2, 2)), H, s=1.0),
                               [np.sqrt(25 + 4 + 4 + 1)])
    np.testing.assert_allclose(losses.style_loss(nn.gram(H), H), [0.0])


def test_style_target_counts_frames(rng):
    a, b = rng.normal(size=(3, 10)), rng.normal(size=(3, 30))
    joined = nn.gram(np.concatenate([a, b], axis=1)[None])[0]
    np.testing.assert_allclose(losses.style_target([a, b], 20), joined * 20 / 40)


def test_foot_loss_of_a_foot_that_slides_by_hand():
    x = np.zeros((1, 66, 3))
    # the body glides forward by 2 a frame, the feet stay below it
    x[0, F.FORWARD] = 2.0
    contacts = np.zeros((1, 4, 3))
    contacts[0, 1] = 1                                           # the left toe should be planted
    np.testing.assert_allclose(losses.foot_loss(x, contacts), [2 * 2.0 ** 2])
    np.testing.assert_allclose(losses.foot_loss(x, contacts, target=np.array([0, 0, 2.0])[:, None]),
                               [0.0])


def test_foot_velocities_are_those_of_the_decoded_motion(rng):
    """To first order in the turning velocity: world velocities of `features.decode`, turned into
    the character's frame.
    """
    from refimpl.motion.rotation import yaw_rotation
    x = motion(rng, 1, 20)
    x[0, F.TURN] *= 1e-3
    world = F.decode(x[0].T)[:, FEET]
    yaw = F.root_motion(x[0].T)[1]
    # (T-1, 4, 3)
    expected = np.diff(world, axis=0) @ yaw_rotation(-yaw[:-1]).swapaxes(1, 2)
    # velocity of the point seen at its new place: p[t+1] - p[t] is turned by the small angle too,
    # hence the tolerance
    np.testing.assert_allclose(losses.foot_velocities(x)[0].transpose(2, 0, 1), expected, atol=5e-3)


def test_bone_loss_by_hand():
    x = np.zeros((1, 66, 2))
    p = losses.joint_positions(x)
    p[:, SLOT["LeftFoot"], 0] = 3.0
    p[:, SLOT["LeftFoot"], 1] = 4.0
    lengths = np.zeros(len(BONES))
    # it is 5 long; the bone below it as well, and should be 0
    lengths[BONES.index((SLOT["LeftLeg"], SLOT["LeftFoot"]))] = 4.0
    np.testing.assert_allclose(losses.bone_loss(x, lengths), [2 * (1.0 + 25.0)])


def test_bone_of_length_zero_has_gradient_zero():
    x = np.zeros((1, 66, 2))
    assert not losses.bone_loss_backward(np.ones(1), x, np.ones(len(BONES))).any()


def test_trajectory_loss_by_hand():
    x, wanted = np.zeros((1, 66, 2)), np.zeros((1, 3, 2))
    x[0, F.TURN], x[0, F.SIDEWAYS] = 0.1, 3.0
    np.testing.assert_allclose(losses.trajectory_loss(x, wanted), [2 * (0.01 + 9)])
    np.testing.assert_allclose(losses.trajectory_loss(x, wanted, turn_weight=100.0), [2 * (1 + 9)])


@pytest.mark.parametrize("reading", losses.READINGS)
def test_content_and_style_gradients(rng, reading):
    A, B = rng.normal(size=(2, 5, 7)), rng.normal(size=(2, 5, 7))
    nn.check_gradient(lambda a, b: losses.content_loss(a, b, c=1.7, reading=reading), lambda d, a,
                      b: losses.content_loss_backward(d, a, b, c=1.7, reading=reading), A, B)
    G = rng.normal(size=(2, 5, 5))
    nn.check_gradient(lambda g, h: losses.style_loss(g, h, s=0.3, reading=reading), lambda d, g,
                      h: losses.style_loss_backward(d, g, h, s=0.3, reading=reading), G, A)


def test_constraint_gradients(rng):
    x = motion(rng)
    contacts = (rng.random((2, 4, 6)) < 0.5).astype(float)
    target = rng.normal(size=(2, 4, 3, 5))
    lengths = rng.uniform(1, 5, len(BONES))
    wanted = rng.normal(size=(2, 3, 6))
    for f, backward in (
            (lambda m: losses.foot_loss(m, contacts), lambda d,
             m: losses.foot_loss_backward(d, m, contacts)),
            (lambda m: losses.foot_loss(m, contacts, target=target), lambda d,
             m: losses.foot_loss_backward(d, m, contacts, target=target)),
            (lambda m: losses.bone_loss(m, lengths), lambda d,
             m: losses.bone_loss_backward(d, m, lengths)),
            (lambda m: losses.trajectory_loss(m, wanted, turn_weight=9.0),
             lambda d, m: losses.trajectory_loss_backward(d, m, wanted, turn_weight=9.0))):
        nn.check_gradient(f, backward, x)
    nn.check_gradient(losses.foot_velocities, losses.foot_velocities_backward, x)


def test_gradients_with_the_weights_of_the_paper(rng):
    """What is not given is the same in a loss and in its gradient: c = 1, s = 0.01, norms, a radian
    worth one length.
    """
    A, B, G, x, wanted = (rng.normal(size=(2, 5, 7)), rng.normal(size=(2, 5, 7)),
                          rng.normal(size=(2, 5, 5)), motion(rng), rng.normal(size=(2, 3, 6)))
    nn.check_gradient(losses.content_loss, losses.content_loss_backward, A, B)
    nn.check_gradient(losses.style_loss, losses.style_loss_backward, G, A)
    nn.check_gradient(lambda m: losses.trajectory_loss(m, wanted), lambda d,
                      m: losses.trajectory_loss_backward(d, m, wanted), x)
    np.testing.assert_allclose(losses.content_loss(A, B), nn.norm(A - B))
    np.testing.assert_allclose(losses.style_loss(G, A), 0.01 * nn.norm(G - nn.gram(A)))


@pytest.mark.parametrize("dtype", [np.float32, np.longdouble])
def test_precision_is_kept(rng, dtype):
    A, B, G, x = (a.astype(dtype) for a in (rng.normal(size=(2, 5, 7)), rng.normal(size=(2, 5, 7)),
                                            rng.normal(size=(2, 5, 5)), motion(rng)))
    # lengths in any precision
    contacts, wanted, lengths = (np.ones((2, 4, 6), dtype), np.zeros((2, 3, 6), dtype),
                                 rng.uniform(1, 5, len(BONES)))
    for f, backward, arguments in ((losses.content_loss, losses.content_loss_backward, (A, B)),
                                   (losses.style_loss, losses.style_loss_backward, (G, A)),
                                   (losses.foot_loss, losses.foot_loss_backward, (x, contacts)),
                                   (losses.bone_loss, losses.bone_loss_backward, (x, lengths)),
                                   (losses.trajectory_loss, losses.trajectory_loss_backward,
                                    (x, wanted))):
        loss = f(*arguments)
        gradients = backward(loss, *arguments)
        assert ({a.dtype for a in (loss,
                                   *(gradients if isinstance(gradients, tuple) else (gradients,)))}
                == {np.dtype(dtype)})


def test_real_planted_feet_cost_nearly_nothing():
    """On motion whose feet truly stand, equation 7 is small; shifting the body's velocity makes it
    large.
    """
    from refimpl.embedded.walkers import make_clip
    from refimpl.motion.body import make_take
    made = make_clip("walk", "normal", seconds=4.0)
    take = make_take(made.clip)
    x, contacts = take.features.T[None], made.contacts.T[None].astype(float)
    planted = losses.foot_loss(x, contacts)[0] / contacts[:, :, :-1].sum()
    x = x.copy()
    x[0, F.FORWARD] += 1.0
    slid = losses.foot_loss(x, contacts)[0] / contacts[:, :, :-1].sum()
    assert planted < 1e-2 and 0.5 < slid < 2.0
