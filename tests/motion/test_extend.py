"""A clip goes on beyond its ends, in phase where it is like itself, and what is made at its ends
does not depend on where it was cut.
"""

from dataclasses import replace
import os
from pathlib import Path

import numpy as np
import pytest

from refimpl.embedded import walkers
from refimpl.motion import features
from refimpl.motion.body import MARGIN, make_take, read_take
from refimpl.motion.extend import extended
from refimpl.motion.rotation import yaw_rotation

WALK = walkers.make_clip("walk", "normal", seconds=4.0)


def off(found, true):
    return np.linalg.norm(found - true, axis=-1).mean() / features.leg_length(true)


def test_a_walk_goes_on_in_phase():
    positions = make_take(WALK.clip).positions
    for at_end, true, rest in ((True, positions[-40:], positions[:-40]),
                               (False, positions[:40], positions[40:])):
        more = extended(rest, 40)
        found = more[-40:] if at_end else more[:40]
        frozen = np.repeat(rest[-1:] if at_end else rest[:1], 40, axis=0)
        assert off(found, true) < 0.08 < 0.25 < off(frozen, true)
        np.testing.assert_array_equal(more[40:-40], rest)


def test_it_goes_on_wherever_it_is_and_whichever_way_it_faces():
    positions = make_take(WALK.clip).positions[:150]
    turn, shift = yaw_rotation(2.0), np.array([300.0, 0.0, -50.0])
    np.testing.assert_allclose(extended(positions @ turn.T + shift, 30),
                               extended(positions, 30) @ turn.T + shift, atol=1e-7)


@pytest.mark.parametrize("frames", [1, 2, 3, 30])
def test_a_short_clip_comes_to_rest(frames):
    positions = make_take(WALK.clip).positions[:frames]
    more = extended(positions, 40)
    assert more.shape == (frames + 80, 21, 3) and np.isfinite(more).all()
    np.testing.assert_array_equal(more[40:-40], positions)
    steps = np.linalg.norm(np.diff(more, axis=0), axis=-1)
    assert steps[-10:].max() < 1e-9 and steps[:10].max() < 1e-9


def test_the_66_numbers_hardly_know_where_a_clip_was_cut():
    take = make_take(WALK.clip)
    cut = make_take(replace(WALK.clip, values=WALK.clip.values[40:]))
    frames = len(cut.positions)
    alone, _ = features.encode(cut.positions)
    here, unread = (np.abs(take.features[-frames:, :63] - f[:, :63])[:20].max()
                    for f in (cut.features, alone))
    assert here < 0.3 * unread


@pytest.mark.mocap
def test_real_clips_go_on_in_phase():
    folder = os.environ.get("REFIMPL_MOCAP")
    if not folder:
        pytest.skip("REFIMPL_MOCAP is not set")
    found, frozen = [], []
    for path in sorted(Path(folder).rglob("*walk*normal*.bvh"))[::6]:
        positions = read_take(path).positions
        if len(positions) > 200:
            rest, true = positions[:-40], positions[-40:]
            found.append(off(extended(rest, 40)[-40:], true))
            frozen.append(off(np.repeat(rest[-1:], 40, axis=0), true))
    assert len(found) >= 3 and np.mean(found) < 0.15 < 0.4 < np.mean(frozen)
    assert MARGIN >= 36 + 12
