"""A long clip takes little more memory than what is read of it and what is made."""

from dataclasses import replace
import tracemalloc

import numpy as np
import pytest

from refimpl.embedded import walkers
from refimpl.fast import networks
from refimpl.holden2017.transfer import transfer
from refimpl.motion import body, features, moved, skeleton, stylised
from refimpl.motion.body import make_take
from refimpl.motion.bvh import write_bvh
from refimpl.motion.skeleton import local_pose, with_pose, with_poses
from refimpl.styles.box import find_style

ROOMS = (body, features, moved, skeleton, stylised)
WALK = walkers.make_clip("walk", "normal", seconds=20.0).clip


def lasting(seconds, frame_time=1 / 60):
    """The walk again and again, its path going on."""
    times = int(np.ceil(seconds / 20.0))
    way = np.zeros_like(WALK.values[0])
    way[[0, 2]] = (WALK.values[-1] - WALK.values[0])[[0, 2]]
    rows = np.concatenate([WALK.values + k * way for k in range(times)])
    return replace(WALK, values=rows[:round(seconds / frame_time)], frame_time=frame_time)


def peak(work, seconds, frame_time):
    clip = lasting(seconds, frame_time)
    tracemalloc.start()
    try:
        work(clip)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("frame_time", [1 / 60, 1 / 30])
def test_what_a_transfer_takes_grows_with_the_clip_by_eight_tables(frame_time, tmp_path,
                                                                            monkeypatch):
    """Tables of 66 numbers a sixtieth of a second: read, made, and the points between. (It was
    twenty-six.) Pieces are smaller here, so that two minutes are a long clip."""
    for room in ROOMS:
        monkeypatch.setattr(room, "AT_A_TIME", 256)
    style = find_style("old")

    def _work(clip):
        result = transfer(make_take(clip), style, networks=networks)
        write_bvh(tmp_path / "out.bvh", replace(result.clip, values=result.clip.values[-9:]))
    _work(lasting(2.0))                              # what is kept for every clip
    first, second = (peak(_work, seconds, frame_time) for seconds in (80.0, 120.0))
    assert (second - first) / (40 * 60 * 66 * 8) < 8.5


def test_a_pose_in_pieces_is_the_pose(tmp_path):
    clip = replace(WALK, values=WALK.values[:100])
    rotations, translations = local_pose(clip)
    whole = with_pose(clip, rotations, translations, clip.frame_time)
    parts = with_poses(clip, 100, [(rotations[a:b], translations[a:b])
                                   for a, b in ((0, 1), (1, 1), (1, 40), (40, 100))],
                       clip.frame_time)
    assert whole.joints == parts.joints and np.array_equal(whole.values, parts.values)
    assert np.abs(whole.values - clip.values).max() < 1e-9


def test_joints_some_at_a_time_are_where_all_together_are(monkeypatch):
    """In pieces of one joint and of three frames: the same bits."""
    clip, style = lasting(3.0, 1 / 30), find_style("old")
    whole = transfer(make_take(clip), style, networks=networks)
    for room in ROOMS:
        monkeypatch.setattr(room, "AT_A_TIME", 3)
    assert 64 * 3 // clip.frames < len(clip.joints)
    parts = transfer(make_take(clip), style, networks=networks)
    for name in ("positions", "made"):
        assert np.array_equal(getattr(whole, name), getattr(parts, name)), name
    assert np.array_equal(whole.clip.values, parts.clip.values)
