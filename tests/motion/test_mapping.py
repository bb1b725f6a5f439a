"""Which joint is which: on skeletons with the names and trees of many tools, without names, without
toes, with limbs that hang elsewhere, and where nothing fits.
"""

from dataclasses import replace

import numpy as np
import pytest

from refimpl.motion import joints, skeleton
from refimpl.motion.body import make_take
from refimpl.motion.clip import plus_offsets
from refimpl.motion.joints import SLOT, SLOTS, MappingError, read_mapping
from refimpl.motion.mapping import map_clip

from . import bodies

WALK = bodies.walker()


def misread(clip, truth, mapping):
    """The slots that a joint feeds which is not theirs."""
    return [(slot, clip.names[j], truth.get(slot)) for slot, j, tip in zip(
        SLOTS, mapping.joints, mapping.tips) if not tip.any() and clip.names[j] != truth.get(slot)]


@pytest.mark.parametrize("name", bodies.SCHEMES)
def test_every_scheme_is_mapped_and_what_it_lacks_is_made_up_and_said(name):
    clip, truth = bodies.on_scheme(WALK, name)
    mapping = map_clip(clip)
    assert misread(clip, truth, mapping) == []
    assert set(mapping.made_up) == set(SLOTS) - set(truth)
    assert all("made up" in how for how in mapping.made_up.values())


@pytest.mark.parametrize("name", sorted(set(bodies.SCHEMES) - {"Axis Neuron"}))
def test_no_name_is_needed(name):
    """(Of a palm's joint and a finger's the tree cannot tell which is the finger: Axis Neuron.)"""
    clip, truth = bodies.on_scheme(WALK, name)
    rng = np.random.default_rng(sorted(bodies.SCHEMES).index(name))
    new = dict(zip(clip.names, (f"x{n}" for n in rng.permutation(len(clip.names)))))
    clip = bodies.renamed(clip, new.get)
    assert misread(clip, {s: new[j] for s, j in truth.items()}, map_clip(clip)) == []


@pytest.mark.parametrize("change", [
    dict(legs=0.7, arms=1.3), dict(legs=1.4, arms=0.7, hips=1.4), dict(trunk=1.4, shoulders=0.6),
    dict(trunk=0.6, shoulders=1.4, feet=1.4), dict(scale=0.01), dict(content="jog", arms=1.4)])
@pytest.mark.parametrize("name", ["CMU", "Unreal", "Geno", "100STYLE"])
def test_nor_do_proportions_and_rest_poses_matter(name, change):
    clip, truth = bodies.on_scheme(bodies.walker(**change), name)
    turned = bodies.turned_rest(clip, np.random.default_rng(1))
    for made in (clip, turned, bodies.z_up(turned)):
        assert misread(made, truth, map_clip(made)) == []
        bare = bodies.renamed(made, lambda n: f"b{made.names.index(n)}")
        place = {s: f"b{made.names.index(j)}" for s, j in truth.items()}
        assert misread(bare, place, map_clip(bare)) == []


def mutilated(rng):
    """A skeleton with something wrong.   ->  Clip, {slot: joint that truly is there}, what"""
    name = rng.choice(sorted(bodies.SCHEMES))
    clip, truth = bodies.on_scheme(WALK, name)
    clip = replace(clip, values=clip.values[::8])
    what = rng.choice(["gone", "names", "sides", "unknown", "limbs", "zero", "mirrored"])
    a, b = rng.choice([s for s in truth if s != "Hips"], 2, replace=False)
    new = {}
    if what == "gone":
        clip = bodies.without(clip, {truth.pop(a)})
        if a in ("Spine", "Chest", "Neck", "Head"):      # a trunk of fewer joints is another trunk
            truth |= dict.fromkeys(("Spine", "Chest", "Neck", "Head"), "any")
    elif what == "names":
        new = {truth[a]: truth[b], truth[b]: truth[a]}
    elif what in ("sides", "mirrored"):
        for slot in ([a] if what == "sides" else SLOTS):
            other = slot.replace("Left", "?").replace("Right", "Left").replace("?", "Right")
            if slot in truth and other in truth:
                new |= {truth[slot]: truth[other], truth[other]: truth[slot]}
    elif what == "unknown":
        new = {truth[slot]: f"thing{n}" for n, slot in enumerate(
            rng.choice(sorted(truth), 3, replace=False))}
    elif what == "limbs":
        for side in ("Left", "Right"):
            for leg, arm in (("UpLeg", "Arm"), ("Leg", "ForeArm"), ("Foot", "Hand")):
                new |= {truth[side + leg]: truth[side + arm], truth[side + arm]: truth[side + leg]}
    else:
        rotations, translations = skeleton.local_pose(clip)
        j = clip.names.index(truth[a])
        translations[:, j] = 0
        flat = tuple(replace(joint, offset=(0.0, 0.0, 0.0)) if k == j else joint
                     for k, joint in enumerate(clip.joints))
        clip = skeleton.with_pose(replace(clip, joints=flat), rotations, translations,
                                  clip.frame_time)
        truth |= dict.fromkeys(("Spine", "Chest", "Neck", "Head"), "any")
    clip = bodies.renamed(clip, lambda n: new.get(n, n))
    return clip, {s: new.get(j, j) for s, j in truth.items()}, f"{name}: {what} {a} {b}"


def test_of_two_hundred_mutilated_skeletons_none_is_misread():
    """Refused with both readings, or read as it is."""
    rng, wrong, refused = np.random.default_rng(7), [], 0
    for _ in range(200):
        clip, truth, what = mutilated(rng)
        try:
            mapping = map_clip(clip)
        except MappingError as error:
            refused += 1
            assert "By names: " in str(error) and "By the tree: " in str(error)
            continue
        _, world = skeleton.forward_kinematics(clip.parents, *skeleton.local_pose(clip))
        for slot, found, right in misread(clip, truth, mapping):
            place = [world[:, clip.names.index(j)] for j in (found, right) if j in clip.names]
            if right != "any" and (len(place) < 2 or np.abs(place[0] - place[1]).max() > 1e-3):
                wrong.append((what, slot, found, right))
    assert wrong == [] and 80 < refused < 180


def test_a_made_up_fingertip_lies_where_the_arm_points_in_any_rest_pose():
    clip, _ = bodies.on_scheme(WALK, "Unity")
    turned = bodies.turned_rest(clip, np.random.default_rng(0))
    flat = skeleton.with_pose(replace(bodies.free_everywhere(clip), joints=tuple(
        replace(j, offset=(0.0, 0.0, 0.0)) for j in bodies.free_everywhere(clip).joints)),
        *skeleton.local_pose(clip), clip.frame_time)
    points = [make_take(c).positions for c in (clip, turned, flat)]
    for other in points[1:]:
        np.testing.assert_allclose(other, points[0], atol=1e-6)
    hand, tip, elbow = (points[0][:, SLOT[f"Left{part}"]] for part in ("Hand", "Finger", "ForeArm"))
    beyond, along = tip - hand, hand - elbow
    cosine = np.sum(beyond * along, axis=1) / (np.linalg.norm(beyond, axis=1)
                                               * np.linalg.norm(along, axis=1))
    assert cosine.mean() > 0.98


def test_the_hands_own_end_site_is_its_fingertip():
    clip, truth = bodies.on_scheme(WALK, "Unity")
    clip = replace(clip, joints=tuple(replace(j, end_site=(1.0, 2.0, 3.0)) if j.name == "LeftHand"
                                      else j for j in clip.joints))
    with pytest.raises(MappingError, match="joint for only one of LeftFinger"):
        map_clip(bodies.without(bodies.on_scheme(WALK, "Unreal")[0], {"middle_01_l"}))
    mapping = map_clip(clip)
    np.testing.assert_array_equal(mapping.tips[SLOT["LeftFinger"]], [1.0, 2.0, 3.0])
    assert mapping.made_up["LeftFinger"] == "made up: the End Site of the hand"


def test_a_body_without_toes_stands_where_the_one_with_toes_stands():
    clip, _ = bodies.on_scheme(WALK, "Unity")
    bare = bodies.without(clip, {"LeftToes", "RightToes"})
    bare = replace(bare, joints=tuple(replace(j, end_site=None) for j in bare.joints))
    with_toes, without = make_take(clip), make_take(bare)
    assert set(without.mapping.made_up) >= {"LeftToe", "RightToe"}
    ankles = [take.positions[:, SLOT["LeftFoot"], 1].min() - take.start.floor
              for take in (with_toes, without)]
    assert abs(ankles[0] - ankles[1]) < 2.5
    given = make_take(bare, {"LeftToe": "LeftFoot", "RightToe": "RightFoot"})    # as if one joint
    np.testing.assert_array_equal(given.positions, without.positions)


@pytest.mark.parametrize("under", [dict(), dict(thighs_under="Bip01_Pelvis"),
                                   dict(collars_under="Bip01_Spine1")])
def test_limbs_that_hang_elsewhere_are_the_same_body(under):
    usual, truth = bodies.on_scheme(WALK, "Biped, usual tree")
    other = bodies.as_biped(usual, **under)
    assert misread(other, truth, map_clip(other)) == []
    np.testing.assert_allclose(make_take(other).positions, make_take(usual).positions, atol=1e-6)


def test_a_mapping_file_is_believed_but_must_be_a_body(tmp_path):
    path = tmp_path / "mine.csv"
    path.write_text("slot,joint\n# my rig\nNeck,spine.005\nHead,?\n")
    clip, truth = bodies.on_scheme(WALK, "Blender")
    mapping = map_clip(clip, read_mapping(path))
    assert clip.names[mapping.joints[SLOT["Neck"]]] == "spine.005"
    assert mapping.how[SLOT["Neck"]] == "mapping" and mapping.how[SLOT["Head"]] == "tree"
    with pytest.raises(MappingError, match="'tail'"):
        map_clip(clip, {"LeftFoot": "tail"})
    with pytest.raises(MappingError, match="found no joint for RightHand"):
        map_clip(clip, {"LeftFoot": "hand.R"})


@pytest.mark.parametrize("text, line",
                         [("slot,joint\nLeftPaw,thing\n", 2), ("LeftFoot\n", 1),
                          ("LeftFoot,a\nLeftFoot,b\n", 2), ("LeftFoot,\n", 1)])
def test_bad_mapping_lines_are_named(tmp_path, text, line):
    path = tmp_path / "mine.csv"
    path.write_text(text)
    with pytest.raises(joints.MappingError, match=f"mine.csv:{line}: found"):
        joints.read_mapping(path)


def test_position_channels_that_are_differences_from_the_offset():
    clip = bodies.free_everywhere(bodies.on_scheme(WALK, "Unity")[0])
    with pytest.raises(ValueError, match="--positions add"):
        make_take(plus_offsets(clip, -1.0))
    again = plus_offsets(plus_offsets(clip, -1.0))
    np.testing.assert_allclose(make_take(again).positions, make_take(clip).positions, atol=1e-9)
