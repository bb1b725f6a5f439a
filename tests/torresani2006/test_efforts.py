"""The two observers: performers by three formulas, noise, and what must not matter."""

from dataclasses import replace

import numpy as np
import pytest

from refimpl.embedded import performers
from refimpl.motion import rotation
from refimpl.motion.skeleton import local_pose, resample, with_pose
from refimpl.torresani2006 import efforts, observe, poses

SIGHTS = (efforts.BY_SWINGS, efforts.BY_PATHS)


def seen(clip, alone=True, fps=None):
    """(2, 3) as the two observers have it, or their measures."""
    body = poses.fit_body([clip])
    fragment = poses.fragment_of(clip, body, "clip", fps=fps or clip.fps)
    return np.array([efforts.seen_alone(fragment, body, sight) if alone else
                     sight.measure(fragment, body) for sight in SIGHTS])


@pytest.fixture(scope="module")
def known():
    """By formula: measures (N, 2, 3), efforts (N, 3), each content's mean taken out."""
    rng, found = np.random.default_rng(5), {}
    for formula in performers.FORMULAS:
        X, Y = [], []
        for content in performers.ACTIONS:
            asked = rng.uniform(-2.9, 2.9, (14, 3))
            x = np.array([seen(performers.perform(content, 300 + n, e, formula).clip, alone=False)
                          for n, e in enumerate(asked)])
            X.append(x - x.mean(axis=0))
            Y.append(asked - asked.mean(axis=0))
        found[formula] = np.concatenate(X), np.concatenate(Y)
    return found


def correlations(known, formula, sight):
    x, y = known[formula]
    return np.corrcoef(x[:, sight].T, y.T)[:3, 3:]


@pytest.mark.parametrize("formula", performers.FORMULAS)
@pytest.mark.parametrize("sight", (0, 1))
def test_weight_and_time_are_seen_whoever_made_them(known, formula, sight):
    r = correlations(known, formula, sight)
    assert r[1, 1] > 0.8 and r[2, 2] > 0.8, r
    assert np.abs([r[1, 0], r[1, 2], r[2, 0], r[2, 1]]).max() < 0.45, r


@pytest.mark.parametrize("formula", ("passing", "submovements"))
@pytest.mark.parametrize("sight", (0, 1))
def test_flow_is_seen_where_its_fits_are_slow_enough(known, formula, sight):
    r = correlations(known, formula, sight)
    assert r[0, 0] > 0.55 and r[0, 0] > np.abs(r[0, 1:]).max(), r


def test_gains_are_the_best_linear_guess(known):
    for n, sight in enumerate(SIGHTS):
        x, y = (np.concatenate([known[formula][k] for formula in performers.FORMULAS])
                for k in (0, 1))
        fitted = (x[:, n] * y).sum(axis=0) / (x[:, n] ** 2).sum(axis=0)
        np.testing.assert_allclose(sight.gain, fitted, rtol=0.25)


def noisy(clip, size, rng):
    rotations, translations = local_pose(clip)
    turned = rotations @ rotation.exp_map(size * rng.normal(size=rotations.shape[:2] + (3,)))
    return with_pose(clip, turned, translations, clip.frame_time)


def test_noise_of_a_capture_moves_little():
    rng, moved = np.random.default_rng(3), []
    for n, content in enumerate(performers.ACTIONS):
        clip = performers.perform(content, 40 + n).clip
        moved += [seen(noisy(clip, 0.005, rng)) - seen(clip) for _ in range(2)]
    assert np.abs(np.array(moved)[:, 0]).max() < 0.3
    assert np.quantile(np.abs(np.array(moved)[:, 1]), 0.9) < 0.3


def test_what_must_not_matter():
    clip = performers.perform("wave", 7).clip
    rotations, translations = local_pose(clip)
    turned = rotations.copy()
    turned[:, 0] = rotation.axis_rotation("Y", np.full(len(turned), 1.1)) @ turned[:, 0]
    away = translations.copy()
    away[:, 0] += [400.0, 0.0, -900.0]
    for other in (with_pose(clip, turned, away, clip.frame_time),
                  replace(clip, joints=tuple(replace(joint, offset=tuple(
                      0.01 * x for x in joint.offset)) for joint in clip.joints),
                      values=clip.values * np.array(
                          [0.01 if "position" in channel else 1.0 for joint in clip.joints
                           for channel in joint.channels]))):
        np.testing.assert_allclose(seen(other), seen(clip), atol=1e-6)
    for fps in (24.0, 30.0, 120.0):
        pose = resample(rotations, translations, clip.fps, fps)
        assert np.abs(seen(with_pose(clip, *pose, 1 / fps)) - seen(clip)).max() < 0.7


def test_too_short_or_without_a_bone():
    made = performers.perform("bow", 1).clip
    body = poses.fit_body([made])
    fragment = poses.fragment_of(made, body, "bow")
    for sight in SIGHTS:
        with pytest.raises(observe.ObserveError, match="found 3 frames"):
            sight.measure(replace(fragment, angles=fragment.angles[:3], root=fragment.root[:3]),
                          body)
        with pytest.raises(observe.ObserveError, match="no bone"):
            sight.measure(fragment, replace(body, bones=np.zeros_like(body.bones)))
        still = replace(fragment, angles=np.tile(fragment.angles[:1], (9, 1)),
                        root=np.tile(fragment.root[:1], (9, 1)))
        assert np.isfinite(sight.measure(still, body)).all()
