"""A part of a clip: its frames, its place, and the clip around it still known."""

from dataclasses import replace

import numpy as np
import pytest

from refimpl.embedded.walkers import make_clip
from refimpl.holden2017 import networks
from refimpl.holden2017.trained import Manifold, Style
from refimpl.holden2017.transfer import transfer
from refimpl.motion.body import MARGIN, make_take
from refimpl.motion.features import bone_lengths, decode
from refimpl.motion.part import part_of
from refimpl.motion.skeleton import local_pose
from refimpl.motion.stylised import onto_skeleton
from refimpl.motion.windows import fit_normaliser

CLIP = make_clip("walk", "normal", seconds=4.0).clip             # 60 frames a second
SLOW = replace(CLIP, frame_time=1 / 30, values=CLIP.values[::2])
RARE = replace(CLIP, frame_time=1 / 24, values=CLIP.values[:97])


@pytest.mark.parametrize("clip", [CLIP, SLOW, RARE], ids=["60", "30", "24"])
def test_parts_that_meet_make_the_whole(clip):
    take = make_take(clip)
    parts = [part_of(take, 0, 0.7), part_of(take, 0.7, 2.0), part_of(take, 2.0)]
    for name in ("positions", "features", "contacts", "rotations"):
        np.testing.assert_array_equal(np.concatenate([getattr(p, name) for p in parts]),
                                      getattr(take, name))
    assert sum(p.clip.frames for p in parts) == clip.frames
    for p in parts:
        np.testing.assert_allclose(decode(p.features, p.start), p.positions, atol=1e-9)
        np.testing.assert_array_equal(p.around[MARGIN:-MARGIN], p.features)
        np.testing.assert_array_equal(p.toes, take.toes)


def test_what_networks_make_of_a_part_is_what_they_make_of_it_within_the_clip():
    take = make_take(CLIP)
    manifold = Manifold(networks.init_loss_network(np.random.default_rng(0), hidden=16),
                        fit_normaliser(take.features, "test"), take.leg,
                        bone_lengths(take.positions))
    style = Style(networks.init_transformation_network(np.random.default_rng(1), channels=8),
                  manifold, "zombie", {"walk": "walk"})
    whole, part = (transfer(t, style, clean=False) for t in (take, part_of(take, 1.0, 3.0)))
    off = np.abs(part.features - whole.features[60:180])
    assert off.max() < 0.1 and off[24:-24].max() < 1e-9
    assert np.abs(part.positions[0, 0] - take.positions[60, 0]).max() < 15.0
    cut = make_take(replace(CLIP, values=CLIP.values[60:180]))
    alone = transfer(cut, style, clean=False).features
    assert np.abs(alone - whole.features[60:180]).max() > 1.5 * off.max()


def test_a_rest_pose_stays_outside_and_is_written_back_where_it_is_within():
    rest = np.zeros((30, SLOW.values.shape[1]))
    rest[:, 0] = 240.0
    take = make_take(replace(SLOW, values=np.concatenate([rest, SLOW.values])))
    after, across = part_of(take, 1.0, 2.0), part_of(take, 0.5, 2.0)
    assert after.strays.said() == "" and "rows 1 to 15 lie apart" in across.strays.said()
    np.testing.assert_array_equal(after.positions, across.positions)
    result = onto_skeleton(across, across.features, clean=False).clip
    assert result.frames == 30 + 60
    for new, old in zip(local_pose(result), local_pose(across.clip)):
        np.testing.assert_allclose(new[::2], old, atol=1e-6)


@pytest.mark.parametrize("begin, end", [(2.0, 1.0), (1.0, 1.0), (0.0, 9.0), (5.0, None), (-1, 2),
                                        (np.nan, 2.0)])
def test_a_part_that_cannot_be_is_named(begin, end):
    with pytest.raises(ValueError, match="part: found .* seconds, needed a part of the clip, which "
                                         "lasts from 0 to 4"):
        part_of(make_take(CLIP), begin, end)


def test_a_part_without_motion_is_named():
    rest = np.zeros((60, CLIP.values.shape[1]))
    rest[:, 0] = 240.0
    take = make_take(replace(CLIP, values=np.concatenate([rest, CLIP.values])))
    with pytest.raises(ValueError, match="found no motion between 0 and 0.5 seconds, needed some "
                                         "of rows 61 to 300"):
        part_of(take, 0, 0.5)
