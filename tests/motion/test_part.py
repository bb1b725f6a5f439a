"""A part of a result: its frames and rows, and what lies outside of the motion."""

from dataclasses import replace

import numpy as np
import pytest

from refimpl.embedded.walkers import make_clip
from refimpl.motion.body import make_take, seen
from refimpl.motion.part import frames_of, part_of
from refimpl.motion.stylised import onto_skeleton

CLIP = make_clip("walk", "normal", seconds=4.0).clip             # 60 frames a second
SLOW = replace(CLIP, frame_time=1 / 30, values=CLIP.values[::2])
RARE = replace(CLIP, frame_time=1 / 24, values=CLIP.values[:97])


def result_of(take, **back):
    there = seen(take)
    return onto_skeleton(take, there, there.features + 0.5, clean=False, **back)


@pytest.mark.parametrize("fps", [None, 60.0, 25.0])
@pytest.mark.parametrize("clip", [CLIP, SLOW, RARE], ids=["60", "30", "24"])
def test_parts_that_meet_make_the_whole(clip, fps):
    take = make_take(clip)
    whole = result_of(take, fps=fps)
    parts = [part_of(take, whole, 0, 0.7), part_of(take, whole, 0.7, 2.0),
             part_of(take, whole, 2.0)]
    for name in ("positions", "features"):
        np.testing.assert_array_equal(np.concatenate([getattr(p, name) for p in parts]),
                                      getattr(whole, name))
    np.testing.assert_array_equal(np.concatenate([p.clip.values for p in parts]),
                                  whole.clip.values)
    assert abs(parts[1].clip.frames - 1.3 * whole.clip.fps) <= 1
    everything = part_of(take, whole)
    np.testing.assert_array_equal(everything.clip.values, whole.clip.values)


def test_a_rest_pose_is_no_part_of_the_motion():
    rest = np.zeros((30, SLOW.values.shape[1]))
    rest[:, 0] = 240.0
    take = make_take(replace(SLOW, values=np.concatenate([rest, SLOW.values])))
    assert frames_of(take, 1.0, 2.0) == frames_of(take, 0.5, 2.0) == slice(0, 60)
    part = part_of(take, result_of(take), 0.5, 2.0)
    assert part.clip.frames == 15 + 30
    np.testing.assert_allclose(part.clip.values[:15], take.clip.values[15:30], atol=1e-9)


@pytest.mark.parametrize("begin, end", [(2.0, 1.0), (1.0, 1.0), (0.0, 9.0), (5.0, None), (-1, 2),
                                        (np.nan, 2.0)])
def test_a_part_that_cannot_be_is_named(begin, end):
    with pytest.raises(ValueError, match="part: found .* seconds, needed a part of the clip, which "
                                         "lasts from 0 to 4"):
        frames_of(make_take(CLIP), begin, end)


def test_a_part_without_motion_is_named():
    rest = np.zeros((60, CLIP.values.shape[1]))
    rest[:, 0] = 240.0
    take = make_take(replace(CLIP, values=np.concatenate([rest, CLIP.values])))
    with pytest.raises(ValueError, match="found no motion between 0 and 0.5 seconds, needed some "
                                         "of rows 61 to 300"):
        frames_of(take, 0, 0.5)
