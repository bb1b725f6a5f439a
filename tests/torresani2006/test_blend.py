"""Blends: their ends, their mirror, the limit of slope, the guard, feet and the command."""

from dataclasses import replace

import numpy as np
import pytest

from refimpl.embedded import manner, performers, walkers
from refimpl.motion import bvh
from refimpl.motion.body import make_take
from refimpl.torresani2006 import align, blend, poses


@pytest.fixture(scope="module")
def pair():
    made = [performers.perform("wave", n).clip for n in (3, 8)]
    body = poses.fit_body(made)
    return [poses.fragment_of(clip, body, str(n)) for n, clip in enumerate(made)], body


def test_limited_path_is_the_cheapest_of_its_steps():
    """Against every path of small grids."""
    rng = np.random.default_rng(0)

    def cheapest(d, p, q):
        if p == q == 0:
            return d[0, 0]
        found = [np.inf]
        for i, j in ((1, 1), (1, 2), (1, 3), (2, 1), (3, 1)):
            if i <= p and j <= q:
                entered = d[p, q - j + 1:q + 1] if i == 1 else d[p - i + 1:p + 1, q]
                found.append(cheapest(d, p - i, q - j) + entered.sum())
        return min(found)
    for P, Q in ((4, 4), (5, 7), (6, 3), (2, 4), (2, 5), (1, 1)):
        X, Y = rng.normal(size=(P, 2)), rng.normal(size=(Q, 2))
        d, path = align.distances(X, Y), blend.limited_path(X, Y)
        least = cheapest(d, P - 1, Q - 1)
        assert (path is None) == np.isinf(least)
        if path is not None:
            assert d[tuple(path.T)].sum() == pytest.approx(least)
            align.time_curve(path)                           # one that equations 4 and 5 allow


def test_ends_and_mirror(pair):
    (a, b), body = pair
    for alpha, whole in ((0.0, a), (1.0, b)):
        np.testing.assert_allclose(blend.smooth(a, b, alpha, body).angles, whole.angles, atol=1e-12)
    for alpha in (-0.25, 0.3, 1.1):
        one, other = blend.smooth(a, b, alpha, body), blend.smooth(b, a, 1 - alpha, body)
        np.testing.assert_allclose(one.angles, other.angles, atol=1e-9)
        np.testing.assert_allclose(one.root, other.root, atol=1e-6)


@pytest.mark.parametrize("rows", [37, 38, 39, 40])
def test_any_number_of_rows_at_any_rate_is_blended(rows):
    """A rate whose frame time was rounded, and every remainder of rows: frames at 60 a second are
    counted as `make_take` counts them."""
    A, B = (replace(c, values=c.values[:rows], frame_time=0.00833333333)
            for c in (performers.perform("step", n).clip for n in (3, 8)))
    assert blend.blend_clips(A, B, 1.0)[0].frames == rows


def test_guard_draws_straight_and_slows(pair):
    (a, b), body = pair
    made = blend.steady_blend(a, b, 0.5, body)
    assert made.limited and (made.straight, made.slower) == (0.0, 1.0) and made.peak <= 2
    tight = blend.steady_blend(a, b, 0.5, body, peak=0.3)
    assert tight.straight == 1.0 and tight.slower > 1 and tight.peak <= 0.3
    assert tight.fragment.frames > made.fragment.frames
    short = poses.Fragment("short", None, None, a.angles[::9], a.root[::9])
    assert not blend.steady_blend(a, short, 0.5, body).limited
    with pytest.raises(align.AlignError, match="one skeleton"):
        blend.steady_blend(a, poses.Fragment("x", None, None, a.angles[:, :6], a.root), 0.5, body)


def test_feet_are_held_and_nothing_pops(tmp_path):
    A, B = (performers.perform("step", n).clip for n in (3, 8))
    clip, made, before, after = blend.blend_clips(A, B, 0.5)
    assert after <= before and clip.fps == 60 and made.peak <= 2
    same, *_ = blend.blend_clips(A, B, 0.0)
    np.testing.assert_allclose(same.values, A.values, atol=1e-4)
    bvh.write_bvh(tmp_path / "x.bvh", clip)
    assert bvh.read_bvh(tmp_path / "x.bvh").frames == clip.frames


def test_walks_of_different_numbers_of_steps_stand():
    A, B = (walkers.make_clip("walk", manner.Manner(speed=speed), manner.person(n), seconds=seconds)
            .clip for n, speed, seconds in ((1, 1.2, 3.0), (2, 0.8, 5.0)))
    steps = [int((np.diff(make_take(clip).contacts[:, [1, 3]].astype(int), axis=0) == 1).sum())
             for clip in (A, B)]
    assert steps[0] != steps[1]
    clip, made, before, after = blend.blend_clips(A, B, 0.3)
    assert after < 0.4 * before and made.peak <= 2, (before, after, made.peak)
    mirrored, *_ = blend.blend_clips(B, A, 0.7)
    np.testing.assert_allclose(mirrored.values, clip.values, atol=1e-4)
