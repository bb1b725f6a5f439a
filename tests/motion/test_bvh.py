"""BVH files: read exactly what is written, refuse what cannot be read exactly."""

from hypothesis import given, strategies as st
import numpy as np
import pytest

from refimpl.motion import bvh
from refimpl.embedded import walkers as synthetic
from refimpl.motion.clip import BVHError, Clip, Joint

SMALL = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Left Arm
  {
    OFFSET 1 2.5 -3e-1
    CHANNELS 3 Yrotation Xrotation Zrotation
    End Site
    {
      OFFSET 0 1 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.0333333
0 90 0 1 2 3 4 5 6
1 91 0 -1 -2 -3 1e1 -.5 5.
"""


def test_a_small_file():
    clip = bvh.parse_bvh(SMALL)
    assert clip.names == ("Hips", "Left Arm")
    assert (clip.joints[1] == Joint("Left Arm", 0, (1.0, 2.5, -0.3),
                                    ("Yrotation", "Xrotation", "Zrotation"), (0.0, 1.0, 0.0)))
    assert clip.joints[1].rotation_order == "YXZ"
    assert clip.fps == 30.0
    np.testing.assert_array_equal(clip.values[1], [1, 91, 0, -1, -2, -3, 10, -0.5, 5])


@pytest.mark.parametrize("change", [
    lambda s: s.replace("\n", "\r\n"), lambda s: s.replace("  ", "\t"), lambda s: s.rstrip("\n"),
    lambda s: "\ufeff" + s,
    lambda s: s.replace("Frames: 2", "Frames:\t2"),
    lambda s: s.replace("MOTION", "Motion").replace("ROOT", "root"),
    lambda s: "# a comment\n" + s.replace("MOTION", "# another\nMOTION") + "\n\n",
    lambda s: s.replace("Hips\n{", "Hips {"),
    lambda s: s.replace("0 90 0", " 0   90\t0"), lambda s: s.replace("Xposition", "XPOSITION")])
def test_oddities_are_read_right(tmp_path, change):
    path = tmp_path / "a clip.bvh"
    path.write_bytes(change(SMALL).encode())
    clip = bvh.read_bvh(path)
    assert clip.joints == bvh.parse_bvh(SMALL).joints
    np.testing.assert_array_equal(clip.values, bvh.parse_bvh(SMALL).values)


@pytest.mark.parametrize("old, new, line, needed", [
    ("HIERARCHY", "HIERACHY", 1, "HIERARCHY"),
    ("ROOT Hips", "ROOT", 3, "a name"),
    ("OFFSET 0 0 0", "OFFSET 0 0", 5, "a finite number"),
    ("OFFSET 1 2.5 -3e-1", "OFFSET 1 nan 0", 8, "a finite number"),
    ("CHANNELS 3 Yrotation", "CHANNELS 3 Wrotation", 9, "a channel"),
    ("CHANNELS 3 Yrotation Xrotation", "CHANNELS 3 Yrotation Yrotation", 9,
     "a channel not listed before"),
    ("CHANNELS 3", "CHANNELS three", 9, "a number of channels"),
    ("JOINT Left Arm", "BONE Left Arm", 6, "JOINT, End Site or }"),
    ("JOINT Left Arm", "JOINT Hips", 6, "a name of its own"),
    ("}\nMOTION", "MOTION", 15, "JOINT, End Site or }"),
    ("MOTION\n", "", 16, "MOTION after"),
    ("Frames: 2", "Frames: two", 17, "a whole number of frames"),
    ("Frames: 2", "Frames: 0", 17, "from 1 on"),
    ("Frames: 2", "Frames: 3", 20, "3 as Frames: says"),
    ("Frames: 2", "Frames: 1", 20, "1 as Frames: says"),
    ("Frame Time: 0.0333333", "Frame Time: 0", 18, "above 0"),
    ("Frame Time: 0.0333333", "Frame Time: -1", 18, "above 0"),
    ("Frame Time: 0.0333333", "", 19, "Frame Time:"),
    ("0 90 0 1", "0 90 0", 19, "9, one for each channel"),
    ("0 90 0 1", "0 90 0 1 7", 19, "9, one for each channel"),
    ("0 90 0 1", "0 nan 0 1", 19, "a finite number"),
    ("0 90 0 1", "0 1_0 0 1", 19, "a finite number"),
    ("0 90 0 1", "0 x 0 1", 19, "a finite number"),
])
def test_malformed_files_are_refused_with_file_and_line(tmp_path, old, new, line, needed):
    path = tmp_path / "bad.bvh"
    path.write_text(SMALL.replace(old, new, 1))
    with pytest.raises(BVHError) as caught:
        bvh.read_bvh(path)
    assert str(caught.value).startswith(f"{path}:{line}: found ")
    assert needed in str(caught.value)


@pytest.mark.parametrize("content",
                         [b"", b"  \n", bytes(range(256)), b"\x89PNG\r\n\x1a\n",
                          SMALL.encode("utf-16")])
def test_what_is_no_bvh_is_refused(tmp_path, content):
    path = tmp_path / "no.bvh"
    path.write_bytes(content)
    with pytest.raises(BVHError, match="no.bvh:[12]: found"):
        bvh.read_bvh(path)


@pytest.mark.parametrize("at", range(0, len(SMALL) - 2, 7))
def test_a_truncated_file_is_refused(at):
    """Cut anywhere before the last number, except where only digits of it are lost."""
    with pytest.raises(BVHError):
        bvh.parse_bvh(SMALL[:at])


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "out.bvh"
    path.write_text("old")
    clip = bvh.parse_bvh(SMALL)
    broken = Clip(clip.joints, clip.frame_time, np.full_like(clip.values, np.nan))
    with pytest.raises(BVHError, match="frame 0"):
        bvh.write_bvh(path, broken)
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


names = st.lists(st.text("abc_ :-é", min_size=1,
                         max_size=8).map(lambda s: " ".join(s.split())).filter(bool), min_size=1,
                 max_size=6, unique=True)
finite = st.floats(allow_nan=False, allow_infinity=False, width=64)
channel_lists = st.lists(st.sampled_from(bvh.POSITION_CHANNELS + bvh.ROTATION_CHANNELS),
                         unique=True, max_size=6).map(tuple)


@st.composite
def clips(draw):
    joints = []
    for j, name in enumerate(draw(names)):
        ancestors = [-1] if j == 0 else [j - 1]
        while j and joints[ancestors[-1]].parent >= 0:
            ancestors.append(joints[ancestors[-1]].parent)
        offset = st.tuples(finite, finite, finite)
        joints.append(Joint(name, draw(st.sampled_from(ancestors)), draw(offset),
                            draw(channel_lists), draw(st.none() | offset)))
    width = sum(len(joint.channels) for joint in joints)
    frames = draw(st.integers(1, 4))
    values = draw(st.lists(finite, min_size=frames * width, max_size=frames * width))
    return Clip(tuple(joints), draw(st.floats(1e-4, 10)),
                np.array(values, dtype=float).reshape(frames, width))


@given(clips().filter(lambda clip: any(joint.channels for joint in clip.joints)))
def test_write_then_read_gives_the_same_clip(clip):
    again = bvh.parse_bvh(bvh.format_bvh(clip))
    assert again.joints == clip.joints and again.frame_time == clip.frame_time
    np.testing.assert_array_equal(again.values, clip.values)


def test_ten_thousand_nested_joints():
    clip = bvh.parse_bvh(SMALL)
    joints = tuple(Joint(f"j{i}", i - 1, (0.0, 1.0, 0.0), ("Xrotation",)) for i in range(10_000))
    deep = Clip(joints, clip.frame_time, np.zeros((1, 10_000)))
    assert bvh.parse_bvh(bvh.format_bvh(deep)).joints == joints


def test_no_exponent_is_written():
    clip = bvh.parse_bvh(SMALL)
    tiny = Clip(clip.joints, clip.frame_time, np.full_like(clip.values, 5.1e-17))
    numbers = bvh.format_bvh(tiny).split("MOTION")[1]
    assert "e" not in numbers.replace("Frame Time", "").replace("Frames", "")


@pytest.mark.parametrize("change",
                         [{"name": "a  b"}, {"name": " a"}, {"name": "a\tb"}, {"name": "a\nb"},
                          {"name": ""}, {"name": "a{b"}, {"name": "a}"},
                                    {"name": "Hips"}, {"offset": (np.nan, 0, 0)},
                          {"offset": (np.inf, 0, 0)}, {"channels": ("Xrotation",) * 3},
                                    {"channels": ("Wrotation", "Xrotation", "Yrotation")}], ids=str)
def test_a_clip_that_would_be_read_back_as_another_is_not_written(change, tmp_path):
    from dataclasses import replace
    clip = synthetic.make_clip(seconds=0.1).clip
    odd = replace(clip, joints=(*clip.joints[:1], replace(clip.joints[1], **change),
                                *clip.joints[2:]))
    (tmp_path / "a.bvh").write_text("old")
    with pytest.raises(bvh.BVHError, match="^clip"):
        bvh.write_bvh(tmp_path / "a.bvh", odd)
    assert (tmp_path / "a.bvh").read_text() == "old"


@pytest.mark.parametrize("time", [0.0, np.nan, -1.0, np.inf])
def test_a_frame_time_that_no_reader_takes_is_not_written(time, tmp_path):
    from dataclasses import replace
    with pytest.raises(bvh.BVHError, match="^clip"):
        bvh.write_bvh(tmp_path / "a.bvh",
                      replace(synthetic.make_clip(seconds=0.1).clip, frame_time=time))


@pytest.mark.parametrize("said, found", [(3, 2), (2, 5)])
def test_a_wrong_number_of_rows_is_told_with_the_line_that_mends_it(said, found):
    head = "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n}\n"
    text = head + f"MOTION\nFrames: {said}\nFrame Time: 0.1\n" + "1.0\n" * found
    with pytest.raises(BVHError, match=f"found {found} rows of motion, needed {said} as "
                       f"Frames: says.* write Frames: {found} in line 8"):
        bvh.parse_bvh(text)
