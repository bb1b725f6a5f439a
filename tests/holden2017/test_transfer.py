"""A content from another skeleton is mapped in, and the result comes back onto its own skeleton."""

import numpy as np
import pytest

from refimpl.holden2017 import networks
from refimpl.holden2017.trained import Manifold, Style
from refimpl.holden2017.transfer import transfer
from refimpl.motion.stylised import onto_skeleton
from refimpl.motion import bvh, joints
from refimpl.motion.clip import Clip, Joint
from refimpl.motion.feet import floor_penetration, foot_skate, pace
from refimpl.motion.windows import fit_normaliser
from refimpl.embedded.walkers import make_clip
from refimpl.motion.features import bone_lengths
from refimpl.motion.body import make_take, read_take, seen


def foreign(clip, names, scale, arms):
    """The clip as another skeleton's: other names, another size, longer arms, every second frame.
    """
    def offset(joint):
        return tuple(scale * (arms if "Arm" in joint.name or "Hand" in joint.name else 1.0) * x
                     for x in joint.offset)
    made = tuple(Joint(names.get(j.name, j.name), j.parent, offset(j), j.channels, j.end_site)
                 for j in clip.joints)
    values = clip.values[::2].copy()
    values[:, :3] *= scale                                       # the root's position
    return Clip(made, 2 * clip.frame_time, values)


@pytest.fixture(scope="module")
def style():
    take = make_take(make_clip("walk", "zombie", seconds=4.0).clip)
    manifold = Manifold(networks.init_loss_network(np.random.default_rng(0), hidden=16),
                        fit_normaliser(take.features, "test"), take.leg,
                        bone_lengths(take.positions))
    return Style(networks.init_transformation_network(np.random.default_rng(1), channels=8),
                 manifold, "zombie", {"walk": "walk"})


@pytest.mark.parametrize("prefix, scale, arms",
                         [("mixamorig:", 0.01, 1.3), ("", 0.4, 0.8), ("rig:", 1.2, 1.0)])
def test_a_foreign_skeleton_keeps_its_names_sizes_and_place(style, tmp_path, prefix, scale, arms):
    names = {slot: prefix + slot for slot in joints.SLOTS}
    bvh.write_bvh(tmp_path / "content.bvh",
                  foreign(make_clip("walk", "normal", seconds=4.0).clip, names, scale, arms))
    content = read_take(tmp_path / "content.bvh")
    assert (content.clip.fps == pytest.approx(30)
            and len(content.positions) == 2 * content.clip.frames - 1)
    made = transfer(content, style)
    bvh.write_bvh(tmp_path / "made.bvh", made.clip)
    again = read_take(tmp_path / "made.bvh")
    assert [j.name for j in again.clip.joints] == [j.name for j in content.clip.joints]
    assert [j.offset for j in again.clip.joints] == [j.offset for j in content.clip.joints]
    np.testing.assert_allclose(bone_lengths(again.positions), bone_lengths(content.positions),
                               rtol=1e-5)
    size = content.leg
    np.testing.assert_allclose(again.positions[::2], made.positions[::2], atol=1e-4 * size)
    assert np.linalg.norm(again.positions[0, 0] - content.positions[0, 0]) < size
    # An untrained network shakes feet out of reach for moments.
    assert (foot_skate(again.positions, content.contacts) < 0.12 * size
            and floor_penetration(again.positions, content.start.floor)[1] < 0.2 * size)


def test_the_scale_of_a_content_does_not_matter(style):
    """The same walk in centimetres and in metres: the same result but for the unit."""
    clip = make_clip("walk", "normal", seconds=2.0).clip
    results = [transfer(make_take(foreign(clip, {}, scale, 1.0)), style) for scale in (1.0, 0.01)]
    np.testing.assert_allclose(results[1].positions, 0.01 * results[0].positions, atol=2e-3)


def test_the_clean_up_of_motion_that_needs_none_is_small_and_raw_is_the_motion():
    take = make_take(make_clip("walk", "normal", seconds=3.0).clip)
    raw, clean = (onto_skeleton(take, seen(take), take.features, clean=c) for c in (False, True))
    np.testing.assert_allclose(raw.positions, take.positions, atol=1e-6)
    moved = np.linalg.norm(clean.positions - take.positions, axis=-1)
    assert 0.01 < moved.max() < 12 and moved.mean() < 1.5
    assert (foot_skate(clean.positions, take.contacts)
            < 0.35 * foot_skate(take.positions, take.contacts))


def test_at_its_own_pace_the_path_is_walked_by_the_factor_of_the_feet(style):
    take = make_take(make_clip("walk", "normal", seconds=3.0).clip)
    usual, own = transfer(take, style), transfer(take, style, own_pace=True)
    factor = pace(usual.features, take.contacts)
    np.testing.assert_allclose(own.features[:, -2:], factor * usual.features[:, -2:], rtol=1e-9,
                               atol=1e-12)
    np.testing.assert_array_equal(own.features[:, :-2], usual.features[:, :-2])
