"""Rows that are not part of the motion: found, left out, written back as they were."""

from dataclasses import replace
import os
from pathlib import Path

import numpy as np
import pytest

from refimpl.embedded.walkers import make_clip
from refimpl.motion.body import make_take, read_take, seen
from refimpl.motion.skeleton import local_pose
from refimpl.motion.stylised import onto_skeleton

CLIP = make_clip("walk", "normal", seconds=4.0).clip             # 60 frames a second
SLOW = replace(CLIP, frame_time=1 / 30, values=CLIP.values[::2])
ROOT = slice(0, 3)                                               # Xposition Yposition Zposition


def with_rest_pose(rows, clip=CLIP):
    """A T-pose some metres from where the walk begins."""
    rest = np.zeros((rows, clip.values.shape[1]))
    rest[:, ROOT] = clip.values[0, ROOT] + [240.0, 0.0, 0.0]
    return replace(clip, values=np.concatenate([rest, clip.values]))


@pytest.mark.parametrize("rows", [1, 2, 60])
def test_what_follows_a_rest_pose_is_as_without_it(rows):
    alone, take = make_take(CLIP), make_take(with_rest_pose(rows))
    assert (take.strays.begin, take.strays.end) == (rows, rows + CLIP.frames)
    np.testing.assert_array_equal(take.positions, alone.positions)
    np.testing.assert_array_equal(take.features, alone.features)
    np.testing.assert_array_equal(take.contacts, alone.contacts)
    assert f"rows 1 to {rows} lie apart" in take.strays.said()


@pytest.mark.parametrize("rows", [1, 60])
def test_it_is_written_back_as_it_was(rows):
    clip = with_rest_pose(rows, SLOW)
    take = make_take(clip)
    result = onto_skeleton(take, seen(take), seen(take).features, clean=False)
    assert result.clip.frames == clip.frames and result.clip.frame_time == clip.frame_time
    for new, old in zip(local_pose(result.clip), local_pose(clip)):
        np.testing.assert_allclose(new, old, atol=1e-9)
    other = onto_skeleton(take, seen(take), seen(take).features, clean=False, fps=60.0)
    assert other.clip.frames == 2 * rows + 2 * SLOW.frames - 1
    for new, old in zip(local_pose(other.clip), local_pose(clip)):
        np.testing.assert_allclose(new[:2 * rows:2], old[:rows], atol=1e-9)
        np.testing.assert_allclose(new[2 * rows::2], old[rows:], atol=1e-6)
    assert result.warnings and "lie apart" in result.warnings[0]


def test_rows_in_which_the_body_was_lost_are_bridged_and_written_back():
    values = CLIP.values.copy()
    values[50, ROOT] += [60.0, 0.0, 0.0]
    values[90:92, ROOT] -= [0.0, 70.0, 0.0]
    clip = replace(CLIP, values=values)
    take, alone = make_take(clip), make_take(CLIP)
    assert np.flatnonzero(take.strays.lost).tolist() == [50, 90, 91]
    assert "rows 51, 91 to 92 lie apart" in take.strays.said()
    assert np.linalg.norm(take.positions - alone.positions, axis=-1).max() < 4.0
    result = onto_skeleton(take, seen(take), seen(take).features, clean=False)
    np.testing.assert_allclose(local_pose(result.clip)[1][[50, 90, 91]],
                               local_pose(clip)[1][[50, 90, 91]], atol=1e-9)


@pytest.mark.parametrize("content, style", [("walk", "normal"), ("walk", "zombie"), ("jog", "old"),
                                            ("stand", "normal"), ("turn-left", "proud")])
def test_motion_itself_is_left_alone(content, style):
    strays = make_take(make_clip(content, style, seconds=3.0).clip).strays
    assert strays.said() == "" and not strays.lost.any()


@pytest.mark.mocap
def test_no_row_of_a_clean_recording_is_left_out():
    folder = os.environ.get("REFIMPL_MOCAP")
    if not folder:
        pytest.skip("REFIMPL_MOCAP is not set")
    assert [str(path) for path in sorted(Path(folder).rglob("*.bvh"))[::20]
            if read_take(path).strays.said()] == []
