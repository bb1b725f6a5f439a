"""Motion that no body makes is told, turned or mended where it is broken; motion that bodies make
is not.
"""

from dataclasses import replace

import numpy as np
import pytest

from refimpl.cli import main
from refimpl.embedded import walkers
from refimpl.motion import bvh
from refimpl.motion.body import make_take
from refimpl.motion.rotation import axis_rotation
from refimpl.motion.skeleton import local_pose, with_pose
from refimpl.motion.joints import SLOT

CLIP = walkers.make_clip("walk", "normal", seconds=4.0).clip
GOOD = make_take(CLIP)


def turned(axis, degrees):
    """The whole clip turned about an axis of the world."""
    turn = axis_rotation(axis, np.radians(degrees))
    rotations, translations = local_pose(CLIP)
    rotations[:, 0], translations[:, 0] = turn @ rotations[:, 0], translations[:, 0] @ turn.T
    return with_pose(CLIP, rotations, translations, CLIP.frame_time)


def changed(rows, columns, function):
    values = CLIP.values.copy()
    values[rows, columns] = function(values[rows, columns])
    return replace(CLIP, values=values)


def test_what_bodies_do_is_not_told():
    assert GOOD.doubts == ()
    for content in ("jog", "walk"):
        for style in ("old", "zombie", "proud"):
            assert make_take(walkers.make_clip(content, style, seconds=3.0).clip).doubts == ()


@pytest.mark.parametrize("axis, degrees, up", [("X", 180, "-y"), ("Z", 180, "-y"), ("X", 90, "z"),
                                               ("X", -90, "-z")])
def test_a_clip_on_its_head_or_back_is_the_same_motion(axis, degrees, up):
    take = make_take(turned(axis, degrees))
    assert take.up == up and (up == "z" or "head is below" in take.doubts[0])
    np.testing.assert_allclose(take.features, GOOD.features, atol=1e-6)


@pytest.mark.parametrize("clip, words", [
    (turned("Z", 90), "degrees from straight above"), (turned("X", 45), "degrees from straight"),
    (changed(slice(None), slice(0, 3), lambda v: v + 1e3 * (np.arange(len(v)) % 2)[:, None]),
     "leap by"),
    (changed(slice(None), slice(None), lambda v: v[:1] + 0 * v), "no joint moves"),
    (changed(slice(None), 1, lambda v: v + 3e3 * np.linspace(0, 1, len(v))), "climb"),
    (replace(CLIP, frame_time=1 / 600), "Frame Time"),
    (replace(CLIP, frame_time=1.0), "Frame Time"),
    (changed(5, slice(3, 4), lambda v: v + 1e15), "rounding")])
def test_what_no_body_does_is_told(clip, words):
    take = make_take(clip)
    assert any(words in doubt for doubt in take.doubts), take.doubts


def test_a_frame_that_faces_nowhere_takes_what_its_neighbours_say():
    """Shoulders exactly opposite to the hips in one frame: NaN in every frame was what came of it.
    """
    positions = GOOD.positions.copy()
    hips = positions[100, SLOT["LeftUpLeg"]] - positions[100, SLOT["RightUpLeg"]]
    positions[100, SLOT["LeftArm"]] = positions[100, SLOT["RightArm"]] - hips
    from refimpl.motion.features import encode
    features = encode(positions)[0]
    assert np.isfinite(features).all()
    assert np.abs(features[:, 63] - GOOD.features[:, 63]).max() < 0.02


def test_commands_tell_it(tmp_path, capsys):
    (tmp_path / "clips").mkdir()
    bvh.write_bvh(tmp_path / "clips" / "walk_old_0.bvh", turned("Z", 180))
    assert main(["inspect", str(tmp_path / "clips" / "walk_old_0.bvh")]) == 0
    said = capsys.readouterr()
    assert "-y is up" in said.out and "warning" in said.err and "head is below" in said.err
    assert main(["prepare", str(tmp_path / "clips"), "-o", str(tmp_path / "m.npz")]) == 0
    assert "walk_old_0.bvh: its head is below its feet" in capsys.readouterr().err


def test_a_long_clip_is_read_some_rows_at_a_time(monkeypatch):
    from refimpl.motion import body, extend, ground, moved, skeleton
    from refimpl.motion.moved import moved_clip, rig
    from refimpl.motion.canonical import change
    found = change(GOOD.positions, GOOD.positions + [1.0, 0, 0])
    whole = moved_clip(GOOD, rig(CLIP.joints, GOOD.mapping), found)
    for room in (body, extend, ground, moved, skeleton):
        monkeypatch.setattr(room, "AT_A_TIME", 50)
    take = make_take(CLIP)
    np.testing.assert_array_equal(take.positions, GOOD.positions)
    np.testing.assert_array_equal(take.contacts, GOOD.contacts)
    np.testing.assert_allclose(take.features, GOOD.features, rtol=0, atol=1e-9)
    parts = moved_clip(take, rig(CLIP.joints, take.mapping), found)
    np.testing.assert_array_equal(parts.values, whole.values)
