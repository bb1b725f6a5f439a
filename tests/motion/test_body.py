"""Takes, mapping and the way back to a skeleton: on a small made skeleton and on the real clips."""

import numpy as np
import pytest

from refimpl.motion import body, bvh, features, joints, skeleton
from refimpl.embedded import walkers as synthetic
from refimpl.motion.clip import Clip, Joint
from refimpl.motion.features import bone_lengths
from refimpl.motion.body import guess_unit, make_take, read_take, standing_height
from refimpl.motion.stylised import onto_skeleton

MADE = synthetic.make_clip("walk", "normal", seconds=2.0)


def renamed(clip, names):
    return Clip(tuple(Joint(names.get(j.name, j.name), j.parent, j.offset, j.channels, j.end_site)
                      for j in clip.joints), clip.frame_time, clip.values)


@pytest.mark.parametrize("family, prefix", [("CMU", ""), ("Mixamo", "mixamorig:"), ("papers", "")])
def test_names_of_several_families_are_found(family, prefix):
    wanted = [prefix + name for name in joints.FAMILIES[family].split()]
    clip = renamed(MADE.clip, dict(zip(joints.SLOTS, wanted)))
    mapping = joints.map_joints(clip.joints)
    assert [clip.joints[j].name for j in mapping.joints] == wanted
    assert not mapping.tips.any()


def test_a_missing_foot_is_named():
    clip = renamed(MADE.clip, {"LeftFoot": "thing"})
    with pytest.raises(joints.MappingError, match="found no joint for LeftFoot"):
        joints.map_joints(clip.joints)


def test_a_users_mapping_file(tmp_path):
    path = tmp_path / "mine.csv"
    path.write_text("slot,joint\n# my rig\nLeftFoot,thing\n")
    clip = renamed(MADE.clip, {"LeftFoot": "thing"})
    assert (joints.map_joints(clip.joints,
                              joints.read_mapping(path)).joints[joints.SLOT["LeftFoot"]] == 3)


@pytest.mark.parametrize("text, line",
                         [("slot,joint\nLeftPaw,thing\n", 2), ("LeftFoot\n", 1),
                          ("LeftFoot,a\nLeftFoot,b\n", 2), ("LeftFoot,\n", 1)])
def test_bad_mapping_lines_are_named(tmp_path, text, line):
    path = tmp_path / "mine.csv"
    path.write_text(text)
    with pytest.raises(joints.MappingError, match=f"mine.csv:{line}: found"):
        joints.read_mapping(path)


def test_whose_names_were_found_is_told():
    other = renamed(MADE.clip, {name: name[::-1] for name in MADE.clip.names})
    given = {slot: slot[::-1] for slot in joints.SLOTS}
    assert joints.map_joints(other.joints, given).family == "the mapping's"
    del given["RightFinger"]                                     # the last joint: made up
    assert joints.map_joints(other.joints[:-1], given).family == "the mapping's"
    mixed = renamed(MADE.clip, {"LeftFoot": "thing"})
    assert (joints.map_joints(mixed.joints, {"LeftFoot": "thing"}).family
            == joints.map_joints(MADE.clip.joints).family + " and the mapping's")


def test_a_hinge_that_does_not_stay_one_is_named():
    columns, made, at = [], [], 0
    for j in MADE.clip.joints:
        kept = ("Xrotation",) if j.name == "LeftLeg" else j.channels
        columns += [at + n for n, name in enumerate(j.channels) if name in kept]
        at += len(j.channels)
        made.append(Joint(j.name, j.parent, j.offset, kept, j.end_site))
    take = make_take(Clip(tuple(made), MADE.clip.frame_time, MADE.clip.values[:, columns]))
    moved = take.features.copy()
    moved[:, 3 * joints.SLOT["LeftFoot"]] += 5.0                 # sideways
    result = onto_skeleton(take, moved)
    assert len(result.clip.joints[take.clip.names.index("LeftLeg")].channels) == 3
    assert result.hinges == ("LeftLeg",)
    assert "LeftLeg: found fewer than three rotation channels" in result.warnings[0]
    assert make_take(MADE.clip).strays.said() == "" == "".join(
        onto_skeleton(make_take(MADE.clip), moved).warnings)


def test_a_mapping_to_a_joint_that_is_not_there():
    with pytest.raises(joints.MappingError, match="'tail'"):
        joints.map_joints(MADE.clip.joints, {"LeftFoot": "tail"})


def test_joints_in_the_wrong_limb_are_refused():
    with pytest.raises(joints.MappingError, match="needed a joint below"):
        joints.map_joints(MADE.clip.joints, {"LeftFoot": "RightHand"})


def z_up(clip):
    """The same motion in a world whose z points up."""
    rotations, translations = skeleton.local_pose(clip)
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    rotations[:, 0], translations[:, 0] = turn @ rotations[:, 0], translations[:, 0] @ turn.T
    return skeleton.with_pose(clip, rotations, translations, clip.frame_time)


def test_z_up_is_noticed_and_written_back_z_up():
    take, turned = make_take(MADE.clip), make_take(z_up(MADE.clip))
    np.testing.assert_allclose(turned.features, take.features, atol=1e-8)
    again = body.to_clip(turned, turned.positions)
    np.testing.assert_allclose(make_take(again).positions, turned.positions, atol=1e-8)
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


def test_bones_keep_their_length_and_directions_follow_the_targets():
    take = make_take(MADE.clip)
    targets = random_targets(take, np.random.default_rng(0))
    rotations, translations = body.fit_pose(take, targets)
    np.testing.assert_array_equal(translations[:, 1:], take.translations[:, 1:])
    _, world = skeleton.forward_kinematics(take.clip.parents, rotations, translations)
    np.testing.assert_allclose(world[:, 0], targets[:, 0], atol=1e-9)
    for parent, child in joints.BONES:
        if list(joints.PARENTS).count(parent) == 1:
            bone, wanted = (world[:, child] - world[:, parent],
                            targets[:, child] - targets[:, parent])
            cosine = (np.sum(bone * wanted, axis=1) / np.linalg.norm(bone, axis=1)
                      / np.linalg.norm(wanted, axis=1))
            np.testing.assert_allclose(cosine, 1, atol=1e-9)


def test_unmoved_targets_give_the_content_back():
    take = make_take(MADE.clip)
    rotations, translations = body.fit_pose(take, take.positions)
    np.testing.assert_allclose(rotations, take.rotations, atol=1e-9)
    np.testing.assert_allclose(translations, take.translations, atol=1e-9)


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
        written = body.to_clip(take, random_targets(take, np.random.default_rng(1)))
        assert written.names == take.clip.names and written.fps == 60.0
        old, new = skeleton.local_pose(take.clip)[1], skeleton.local_pose(written)[1]
        np.testing.assert_allclose(new[:, 2:], np.broadcast_to(old[:1, 2:], new[:, 2:].shape),
                                   atol=1e-4)


@pytest.mark.mocap
def test_contacts_of_real_walks_match_what_was_measured(mocap):
    either = [take.contacts[:, :2].any(axis=1).mean()
              for take in (read_take(path) for path in sorted(mocap.glob("bandai1/*_walk_*.bvh")))]
    assert 0.5 < np.mean(either) < 0.7
