"""Frame rates: up along smooth curves, down by leaving out."""

from hypothesis import given, strategies as st
import numpy as np
import pytest

from refimpl.motion import rotation, skeleton
from refimpl.motion.feet import jerk
from refimpl.embedded.walkers import make_clip
from refimpl.motion.body import make_take


def swing(rng, joints=3):
    """A smooth motion of a few slow waves, as a function of seconds.
    ->  f(time) ->  rotations, translations
    """
    speeds, shifts = rng.uniform(2, 9, (4, joints, 3)), rng.uniform(0, 6, (4, joints, 3))
    sizes, base = (rng.normal(size=(4, joints, 3)) / 6,
                   rotation.exp_map(rng.normal(size=(joints, 3))))

    def at(time):
        waves = np.sin(time[:, None, None, None] * speeds + shifts)
        v = (sizes * waves).sum(axis=1)
        return base @ rotation.exp_map(v), 20 * v[..., ::-1]
    return at


def turned_by(R, S):
    """The largest angle between two poses, radians."""
    return np.linalg.norm(rotation.log_map(R.swapaxes(-1, -2) @ S), axis=-1).max()


def third(x):
    return np.sqrt(np.mean(np.diff(x, n=3, axis=0) ** 2))


@pytest.mark.parametrize("rate, new", [(30, 60), (24, 60), (30, 120), (25, 60)])
def test_a_smooth_motion_comes_back_smooth(rate, new):
    at = swing(np.random.default_rng(rate))
    R, t = at(np.arange(3 * rate + 1) / rate)
    truth = at(np.arange(3 * new + 1) / new)
    found, straight = (skeleton.resample(R, t, rate, new, smooth=s) for s in (True, False))
    inner = slice(new // 4, -new // 4)
    error, of_slerp = (turned_by(truth[0][inner], r[0][inner]) for r in (found, straight))
    assert error < 0.1 * of_slerp
    assert (np.abs(truth[1] - found[1])[inner].max()
            < 0.1 * np.abs(truth[1] - straight[1])[inner].max())
    # no corners ...
    assert third(found[1][inner]) == pytest.approx(third(truth[1][inner]), rel=0.2)
    # ... which straight lines have
    assert third(straight[1][inner]) > 1.5 * third(truth[1][inner])


@given(st.integers(0, 10_000), st.integers(2, 9),
       st.sampled_from([(30.0, 60.0), (24.0, 60.0), (15.0, 60.0), (29.97, 60.0), (30.0, 120.0)]))
def test_given_frames_stay_and_the_world_may_be_turned(seed, frames, rates):
    rng = np.random.default_rng(seed)
    R, t = rotation.exp_map(rng.normal(size=(frames, 2, 3))), rng.normal(size=(frames, 2, 3))
    found, moved = skeleton.resample(R, t, *rates)
    np.testing.assert_allclose(found @ found.swapaxes(-1, -2),
                               np.broadcast_to(np.eye(3), found.shape), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(found), 1.0)
    if rates[1] % rates[0] == 0:
        step = round(rates[1] / rates[0])
        assert len(found) == step * (frames - 1) + 1
        np.testing.assert_allclose(found[::step], R, atol=1e-12)
        np.testing.assert_allclose(moved[::step], t, atol=1e-12)
    world, body = rotation.exp_map(rng.normal(size=(2, 3)))
    np.testing.assert_allclose(skeleton.resample(world @ R @ body, t, *rates)[0],
                               world @ found @ body, atol=1e-9)


def test_constant_turning_stays_constant_and_a_pose_stays_a_pose():
    R = rotation.yaw_rotation(0.3 * np.arange(30))[:, None]
    found = skeleton.resample(R, np.zeros((30, 1, 3)), 30, 60)[0][10:-10, 0]
    np.testing.assert_allclose(rotation.log_map(found[:-1].swapaxes(-1, -2) @ found[1:])[:, 1],
                               0.15, atol=1e-3)
    still = np.repeat(rotation.exp_map([[[0.4, 2.0, -1.0]]]), 7, axis=0)
    np.testing.assert_allclose(skeleton.resample(still, np.ones((7, 1, 3)), 24, 60)[0],
                               np.repeat(still[:1], 16, axis=0), atol=1e-12)


@pytest.mark.parametrize("degrees", [60, 170, 180])
def test_a_glitch_stays_near(degrees):
    R = np.repeat(np.eye(3)[None, None], 40, axis=0)
    R[20:] = rotation.yaw_rotation(np.radians(degrees))
    t = np.zeros((40, 1, 3))
    t[20:] = 100.0
    found, moved = skeleton.resample(R, t, 30, 60)
    angle = np.linalg.norm(rotation.log_map(R[0].swapaxes(-1, -2) @ found), axis=-1)
    assert (np.isfinite(found).all() and angle[:26].max() < np.radians(1)
            and np.abs(moved[:26]).max() < 1)
    assert -15 < moved.min() and moved.max() < 115


def test_down_it_leaves_frames_out():
    at = swing(np.random.default_rng(5))
    R, t = at(np.arange(121) / 120)
    found, moved = skeleton.resample(R, t, 120, 60)
    np.testing.assert_allclose(found, R[::2], atol=1e-12)
    np.testing.assert_array_equal(moved, t[::2])
    one = skeleton.resample(R[:1], t[:1], 30, 60)
    assert one[0] is not None and len(one[0]) == 1


@pytest.mark.parametrize("content", ["walk", "jog", "turn-left"])
def test_walks_thinned_and_brought_back(content):
    """Whole figures from 60 frames a second to 30 and back. (On recordings from 30 to 15 and back:
    errors 0.15 cm by the curve and 0.43 by slerp, jerk 0.8 and 2.3 times the recording's; what a
    clip holds above 15 Hz, as the capture's noise, nothing brings back.)"""
    clip = make_clip(content, "normal").clip
    mapping, pose = make_take(clip).mapping, skeleton.local_pose(clip)

    def points(R, t):
        return mapping.positions(*skeleton.forward_kinematics(clip.parents, R, t))
    ways = [points(*skeleton.resample(*(x[::2] for x in pose), 30, 60, smooth=s))
            for s in (True, False)]
    truth = points(*pose)[:len(ways[0])]
    errors = [np.linalg.norm(p - truth, axis=-1)[1::2].mean() for p in ways]
    jerks = [jerk(p, range(21)) / jerk(truth, range(21)) for p in ways]
    assert errors[0] < 0.2 * errors[1] and 0.6 < jerks[0] < 1.2 and jerks[1] > 2.5
