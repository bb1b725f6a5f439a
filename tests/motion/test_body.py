"""Takes, mapping and the way back to a skeleton: on a small made skeleton and on the real clips."""

import numpy as np
import pytest

from refimpl.motion import bvh, canonical, features, moved, skeleton
from refimpl.embedded import walkers as synthetic
from refimpl.motion.features import bone_lengths
from refimpl.motion.body import guess_unit, make_take, read_take, seen, standing_height
from refimpl.motion.clip import Clip, Joint
from refimpl.motion.joints import SLOT
from refimpl.motion.stylised import onto_skeleton
from .bodies import z_up

MADE = synthetic.make_clip("walk", "normal", seconds=2.0)


def test_z_up_is_noticed_and_written_back_z_up():
    take, turned = make_take(MADE.clip), make_take(z_up(MADE.clip))
    np.testing.assert_allclose(turned.features, take.features, atol=1e-8)
    found = canonical.change(turned.positions, random_targets(turned, np.random.default_rng(0)))
    again = moved.moved_clip(turned, moved.rig(turned.clip.joints, turned.mapping), found)
    np.testing.assert_allclose(make_take(again).positions, canonical.applied(
        turned.positions, found, canonical.CARRIES), atol=1e-6)
    rotations, translations = skeleton.local_pose(again)
    assert translations[:, 0, 2].mean() > 50                     # the hips' height stands in z


@pytest.mark.parametrize("height, unit",
                         [(1.4, "metres"), (140, "centimetres"), (55, "inches"),
                          (1400, "millimetres"), (25, "units of about 5.6 cm")])
def test_units(height, unit):
    assert guess_unit(height) == unit


def test_the_made_walker_is_an_adult_in_centimetres():
    assert 130 < standing_height(bone_lengths(make_take(MADE.clip).positions)) < 150


def random_targets(take, rng, size=6.0):
    t = np.arange(len(take.positions))[:, None, None]
    return take.positions + size * np.sin(t * 0.1 + rng.uniform(0, 6, (1, 21, 3)))


@pytest.mark.mocap
@pytest.mark.parametrize("name, frame, joint, xyz", [
    ("bandai1/dataset-1_walk_normal_001", 0, "Hips", (-1.714, 90.270, -407.123)),
    ("bandai1/dataset-1_walk_normal_001", 100, "Hand_L", (18.214, 83.595, 11.781)),
    ("bandai1/dataset-1_walk_normal_002", 15, "Toes_R", (0.496, 3.869, 85.471)),
    ("bandai2/dataset-2_walk-turn-left_elderly_001", 50, "Head", (41.324, 135.911, 188.824))])
def test_world_positions_of_real_clips(mocap, name, frame, joint, xyz):
    clip = bvh.read_bvh(mocap / f"{name}.bvh")
    _, world = skeleton.forward_kinematics(clip.parents, *skeleton.local_pose(clip))
    np.testing.assert_allclose(world[frame, clip.names.index(joint)], xyz, atol=1e-3)


@pytest.mark.mocap
def test_real_clips_there_and_back(mocap):
    for path in sorted(mocap.glob("*/*walk*_00[14].bvh"))[::7]:
        take = read_take(path)
        assert len(take.positions) == 2 * take.clip.frames - 1
        np.testing.assert_allclose(features.decode(take.features, take.start), take.positions,
                                   atol=1e-9 * 160)
        assert bvh.parse_bvh(bvh.format_bvh(take.clip)).joints == take.clip.joints
        found = canonical.change(take.positions, random_targets(take, np.random.default_rng(1)))
        written = moved.moved_clip(take, moved.rig(take.clip.joints, take.mapping), found)
        assert written.names == take.clip.names and written.fps == take.clip.fps
        old, new = skeleton.local_pose(take.clip)[1], skeleton.local_pose(written)[1]
        np.testing.assert_allclose(new[:, 2:], np.broadcast_to(old[:1, 2:], new[:, 2:].shape),
                                   atol=1e-4)


@pytest.mark.mocap
def test_contacts_of_real_walks_match_what_was_measured(mocap):
    either = [take.contacts[:, :2].any(axis=1).mean()
              for take in (read_take(path) for path in sorted(mocap.glob("bandai1/*_walk_*.bvh")))]
    assert 0.5 < np.mean(either) < 0.7


def test_a_hinge_that_does_not_stay_one_is_named():
    columns, made, at = [], [], 0
    for j in MADE.clip.joints:
        kept = ("Xrotation",) if j.name == "LeftLeg" else j.channels
        columns += [at + n for n, name in enumerate(j.channels) if name in kept]
        at += len(j.channels)
        made.append(Joint(j.name, j.parent, j.offset, kept, j.end_site))
    take = make_take(Clip(tuple(made), MADE.clip.frame_time, MADE.clip.values[:, columns]))
    moved = take.features.copy()
    moved[:, 3 * SLOT["LeftFoot"]] += 5.0                        # sideways
    result = onto_skeleton(take, seen(take), moved)
    assert len(result.clip.joints[take.clip.names.index("LeftLeg")].channels) == 3
    assert result.hinges == ("LeftLeg",)
    assert "LeftLeg: found fewer than three rotation channels" in result.warnings[0]
    whole = make_take(MADE.clip)
    assert onto_skeleton(whole, seen(whole), moved).warnings == ()
