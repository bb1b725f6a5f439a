"""The made walkers: feet that rest, bones that keep their length, joints that do not jump, styles
that are what they say.
"""

from dataclasses import fields

from hypothesis import given, strategies as st
import numpy as np
import pytest

from refimpl.motion import bvh, joints, skeleton
from refimpl.embedded import gait, walkers as synthetic
from refimpl.motion.joints import FEET, HEELS, SLOT, TOES
from refimpl.motion.mapping import map_clip
from refimpl.embedded.walkers import CONTENTS, FPS, STYLES, make_clip, make_database
from refimpl.embedded.manner import Manner, Person, blend, person

ALL = [(content, style) for content in CONTENTS for style in STYLES]
MOVING = ("walk", "jog", "turn-left", "turn-right")


def world(motion):
    """(T, 21, 3)"""
    return skeleton.forward_kinematics(motion.clip.parents, *skeleton.local_pose(motion.clip))[1]


def made(*arguments, **options):
    motion = make_clip(*arguments, **options)
    return motion, world(motion)


def channel(motion, joint, name):
    names = [(j.name, c) for j in motion.clip.joints for c in j.channels]
    return motion.clip.values[:, names.index((joint, name))]


def largest_slip(motion, positions):
    """The largest distance, cm, between any two places of a joint within one labelled contact."""
    worst = 0.0
    for foot, joint in enumerate(FEET):
        label = motion.contacts[:, foot]
        starts = np.flatnonzero(np.diff(np.concatenate([[0], label, [0]])) == 1)
        ends = np.flatnonzero(np.diff(np.concatenate([[0], label, [0]])) == -1)
        for start, end in zip(starts, ends):
            worst = max(worst, np.ptp(positions[start:end, joint], axis=0).max())
    return worst


@pytest.mark.parametrize("content, style", ALL)
def test_a_body_that_could_exist(content, style):
    motion, positions = made(content, style, seconds=5.0, seed=3)
    assert (motion.clip.values.shape == (300, 66) and motion.contacts.shape == (300, 4)
            and motion.contacts.dtype == bool)
    assert np.isfinite(motion.clip.values).all() and motion.clip.fps == FPS
    assert largest_slip(motion, positions) < 1e-6
    assert positions[:, TOES, 1].min() > 4.2 and positions[:, HEELS, 1].min() > 9.0
    rotations, world_positions = skeleton.forward_kinematics(motion.clip.parents,
                                                             *skeleton.local_pose(motion.clip))
    for toe in TOES:
        tip = (world_positions[:, toe] + rotations[:,
                                                   toe]
               @ np.array(motion.clip.joints[toe].end_site))
        assert tip[:, 1].min() > 1.0
    acceleration = np.diff(positions, n=2, axis=0) * FPS ** 2
    # a foot that lands; no joint jumps
    assert np.linalg.norm(acceleration, axis=-1).max() < 16 * 981.0
    assert np.linalg.norm(acceleration[:, SLOT["Hips"]], axis=-1).max() < 2.5 * 981.0
    # degrees a frame: no Euler angle flips
    assert np.abs(np.diff(motion.clip.values[:, 3:], axis=0)).max() < 25.0
    for side in ("Left", "Right"):
        knee = channel(motion, side + "Leg", "Xrotation")
        # never straight, never the wrong way
        assert 5.0 < knee.min() and knee.max() < 140.0
        assert np.abs(channel(motion, side + "Leg", "Zrotation")).max() == 0.0


@pytest.mark.parametrize("content, style", ALL)
def test_the_labels_say_when_the_feet_rest(content, style):
    motion, positions = made(content, style, seconds=5.0, seed=3)
    speed = np.linalg.norm(np.diff(positions[:, FEET], axis=0), axis=-1)
    rests = motion.contacts[1:] & motion.contacts[:-1]
    apart = ~motion.contacts[1:] & ~motion.contacts[:-1]
    assert speed[rests].max() < 1e-6
    assert (positions[:, HEELS, 1][motion.contacts[:, [0, 2]]]
            == pytest.approx(gait.ANKLE_HEIGHT, abs=1e-9))
    assert (positions[:, TOES, 1][motion.contacts[:, [1, 3]]]
            == pytest.approx(gait.TOE_HEIGHT, abs=1e-9))
    if apart.any():
        assert np.median(speed[apart]) > 1.0
    flight = (~motion.contacts.any(axis=1)).mean()
    if content == "jog":
        assert flight > 0.1
    elif content == "stand":
        assert motion.contacts.all()
    else:
        # the landing toe is still up when the other foot leaves
        assert flight < 0.03


def test_bones_have_the_skeletons_lengths():
    motion, positions = made("jog", "childlike", person(4), seconds=3.0)
    for parent, joint in joints.BONES:
        length = np.linalg.norm(positions[:, joint] - positions[:, parent], axis=-1)
        assert length == pytest.approx(np.linalg.norm(motion.clip.joints[joint].offset), abs=1e-9)


def test_the_skeleton_is_an_adult_with_the_papers_joints():
    motion, positions = made("stand", seconds=1.0)
    height = positions[..., 1].mean(axis=0)
    assert (height[SLOT["Hips"]] == pytest.approx(93.0, abs=1.5)
            and height[SLOT["Head"]] == pytest.approx(141.0, abs=2.0))
    assert np.linalg.norm(gait.ANKLE_TO_BALL) == pytest.approx(11.8, abs=0.1)
    mapping = map_clip(motion.clip)
    assert set(mapping.how) == {"name"} and np.array_equal(mapping.joints, np.arange(21))
    assert np.array_equal(motion.clip.parents, joints.PARENTS)


def test_it_walks_where_it_faces():
    motion, positions = made("walk", seconds=6.0)
    way = positions[-1, 0] - positions[0, 0]
    assert way[2] == pytest.approx(6.0 * gait.WALK.speed, rel=0.03) and abs(way[0]) < 0.15 * way[2]
    across = positions[:, SLOT["LeftUpLeg"]] - positions[:, SLOT["RightUpLeg"]]
    # the left side is +x
    assert (across[:, 0] > 10.0).all()
    for heel, toe, flat in zip(HEELS, TOES, motion.contacts[:, [0, 2]].T):
        assert ((positions[:, toe] - positions[:, heel])[flat, 2] > 5.0).all()
    # knees point forward
    for hip, knee, ankle, _ in joints.LEGS:
        middle = 0.5 * (positions[:, hip] + positions[:, ankle])
        assert (positions[:, knee, 2] > middle[:, 2]).all()


def test_arms_swing_against_the_legs():
    _, positions = made("walk", seconds=6.0)
    for side in ("Left", "Right"):
        hand = positions[:, SLOT[side + "Hand"], 2] - positions[:, SLOT["Chest"], 2]
        foot = positions[:, SLOT[side + "Foot"], 2] - positions[:, SLOT["Hips"], 2]
        assert np.corrcoef(hand, foot)[0, 1] < -0.6


@pytest.mark.parametrize("turn", [-1.0, -0.3, 0.0, 0.5, 1.0])
def test_turn_and_speed_are_as_asked(turn):
    motion, positions = made("walk", seconds=6.0, speed=90.0, turn=turn)
    yaw = np.unwrap(np.radians(channel(motion, "Hips", "Yrotation")))
    assert yaw[-60:].mean() - yaw[60:120].mean() == pytest.approx(4.0 * turn, abs=0.25)
    cycle = np.abs(np.diff(positions[:, 0, [0, 2]], axis=0))
    assert FPS * np.hypot(*cycle.T).mean() == pytest.approx(90.0, rel=0.05)
    assert largest_slip(motion, positions) < 1e-6


def test_phase_counts_steps():
    motion, positions = made("walk", seconds=6.0, seed=5)
    assert (motion.phase >= 0).all() and (motion.phase < 1).all()
    lands = np.flatnonzero(motion.contacts[1:, 0] & ~motion.contacts[:-1, 0]) + 1
    assert len(lands) >= 4 and (motion.phase[lands] < 0.05).all()


def test_styles_are_what_they_say():
    seen = {style: world(make_clip("walk", style, seconds=6.0)) for style in STYLES}
    clips = {style: make_clip("walk", style, seconds=6.0) for style in STYLES}

    def mean(style, joint, axis=1):
        return seen[style][:, SLOT[joint], axis].mean()

    def ahead(style, joint, of):
        return (seen[style][:, SLOT[joint], 2] - seen[style][:, SLOT[of], 2]).mean()

    def speed(style):
        return FPS * np.diff(seen[style][:, 0, 2]).mean()

    def swing(style):
        return np.std(seen[style][:, SLOT["LeftHand"], 2] - seen[style][:, SLOT["Chest"], 2])

    def knee(style, side):
        return channel(clips[style], side + "Leg", "Xrotation").max()

    assert (mean("old", "Head") < mean("normal", "Head") - 6 and ahead("old", "Head", "Hips")
            > ahead("normal", "Head", "Hips") + 10)
    assert mean("old", "Hips") < mean("normal", "Hips") - 2 and speed("old") < 0.6 * speed("normal")
    assert swing("old") < 0.5 * swing("normal")
    assert (mean("zombie", "LeftHand") > mean("zombie", "Chest")
            and ahead("zombie", "RightHand", "RightArm") > 40)
    assert knee("zombie", "Left") < knee("normal", "Left") - 15
    assert (ahead("depressed", "Head", "Neck") > ahead("normal", "Head", "Neck") + 2
            and swing("depressed") < 0.5 * swing("normal"))
    stance = clips["injured"].contacts.mean(axis=0)
    # the good left leg carries longer
    assert stance[0] > stance[2] + 0.08 and stance[1] > stance[3] + 0.08
    stance = clips["normal"].contacts.mean(axis=0)
    assert stance[0] == pytest.approx(stance[2], abs=0.04)
    assert knee("injured", "Right") < knee("injured", "Left") - 8
    tilt = seen["injured"][:, SLOT["Neck"], 0] - seen["injured"][:, SLOT["Hips"], 0]
    assert (tilt.mean() > 2 and np.ptp(tilt)
            > 2 * np.ptp(seen["normal"][:, SLOT["Neck"], 0] - seen["normal"][:, SLOT["Hips"], 0]))
    assert (swing("proud") > 1.15 * swing("normal") and ahead("proud", "Neck", "Hips")
            < ahead("normal", "Neck", "Hips") - 2)
    assert (np.std(seen["childlike"][:, 0, 1]) > np.std(seen["normal"][:, 0, 1])
            and speed("angry") > 1.2 * speed("normal"))


def test_every_style_differs_from_every_other():
    hands = {style: made("walk", style, seconds=4.0)[1] for style in STYLES}
    shapes = {style: (p - p[:, :1]).mean(axis=0) for style, p in hands.items()}
    for a in STYLES:
        for b in STYLES:
            if a < b:
                assert np.linalg.norm(shapes[a] - shapes[b], axis=-1).max() > 3.0, (a, b)


def test_blend_goes_from_one_style_to_the_other():
    old, proud = STYLES["old"], STYLES["proud"]
    assert blend(old, proud, 0.0) == old and blend(old, proud, 1.0) == proud
    leans = [blend(old, proud, alpha).lean for alpha in (-0.25, 0.0, 0.5, 1.0, 1.25)]
    assert leans == sorted(leans, reverse=True)
    bodies = [world(make_clip("walk", blend(old, proud, alpha), seconds=3.0))
              for alpha in np.linspace(0, 1, 5)]
    ahead = [(body[:, SLOT["Neck"], 2] - body[:, SLOT["Hips"], 2]).mean() for body in bodies]
    assert ahead == sorted(ahead, reverse=True)
    assert make_clip("walk", blend(old, proud, 0.3), seconds=0.1).style == "custom"


@given(a=st.sampled_from(sorted(STYLES)), b=st.sampled_from(sorted(STYLES)),
       alpha=st.floats(-0.25, 1.25),
       content=st.sampled_from(sorted(CONTENTS)), who=st.integers(0, 1000),
       seed=st.integers(0, 1000))
def test_any_blend_of_anybody_walks(a, b, alpha, content, who, seed):
    motion, positions = made(content, blend(STYLES[a], STYLES[b], alpha), person(who), seconds=2.5,
                             seed=seed)
    assert np.isfinite(motion.clip.values).all() and largest_slip(motion, positions) < 1e-6
    size = motion.clip.joints[SLOT["LeftLeg"]].offset[1] / -gait.THIGH
    assert positions[:, TOES, 1].min() > 4.2 * size and positions[:, HEELS, 1].min() > 9.0 * size
    acceleration = np.diff(positions, n=2, axis=0) * FPS ** 2
    assert np.linalg.norm(acceleration, axis=-1).max() < 30 * 981.0


@given(speed=st.floats(gait.WALK.slowest, gait.WALK.fastest), turn=st.floats(-1.5, 1.5),
       style=st.sampled_from(sorted(STYLES)))
def test_any_speed_and_turn_in_the_range(speed, turn, style):
    motion, positions = made("walk", style, seconds=2.0, speed=speed, turn=turn)
    assert largest_slip(motion, positions) < 1e-6 and positions[:, TOES, 1].min() > 4.2


def test_the_same_arguments_make_the_same_bits():
    a, b = (make_clip("turn-left", "zombie", person(2), seconds=3.0, seed=9) for _ in range(2))
    for one, other in ((a.clip.values, b.clip.values), (a.contacts, b.contacts),
                       (a.phase, b.phase)):
        assert one.tobytes() == other.tobytes()
    c = make_clip("turn-left", "zombie", person(2), seconds=3.0, seed=10)
    assert not np.array_equal(a.clip.values, c.clip.values)
    assert person(1) == person(1) != person(2) and person(0) != Person()


def test_a_persons_habits_are_seen():
    base = made("walk", seconds=3.0)[1]
    habits = dict(lean=8.0, head=20.0, arm_out=15.0, elbow=30.0, arm_swing=2.0, width=2.0, sway=3.0,
                  toe_out=20.0, stride=1.1, cadence=1.1, scale=1.1)
    assert set(habits) == {f.name for f in fields(Person)}
    for habit in (Person(**{name: value}) for name, value in habits.items()):
        assert np.abs(made("walk", person=habit, seconds=3.0)[1] - base).max() > 1.0, habit


def test_a_database_is_every_content_in_every_style():
    motions = make_database(2.0, people=2, styles=("normal", "old"), contents=("walk", "jog"),
                            seed=1)
    assert ([m.name for m in motions[:4]] == ["walk_normal_000", "jog_normal_000", "walk_old_000",
                                              "jog_old_000"] and len(motions) == 8)
    assert len({m.name for m in motions}) == 8
    assert ({(m.content, m.style) for m in motions}
            == {(c, s) for c in ("walk", "jog") for s in ("normal", "old")})
    again = make_database(2.0, people=2, styles=("normal", "old"), contents=("walk", "jog"), seed=1)
    assert all(np.array_equal(a.clip.values, b.clip.values) for a, b in zip(motions, again))


def test_survives_a_bvh_file(tmp_path):
    motion = make_clip("jog", "childlike", person(7), seconds=1.0)
    bvh.write_bvh(tmp_path / "jog.bvh", motion.clip)
    back = bvh.read_bvh(tmp_path / "jog.bvh")
    assert (np.array_equal(back.values, motion.clip.values) and back.joints == motion.clip.joints
            and back.fps == 60.0)


@pytest.mark.parametrize("arguments, says", [
    (dict(content="swim"), "content.*walk"), (dict(style="sleepy"), "style.*zombie"),
    (dict(seconds=0.0), "seconds"),
    (dict(seconds=float("nan")), "seconds"), (dict(speed=900.0), "speed.*900.*15 to 190"),
    (dict(speed=float("nan")), "speed"),
    (dict(turn=float("inf")), "turn"), (dict(style=Manner(stride=2.5)), "shorter stride")])
def test_refuses_what_cannot_be(arguments, says):
    with pytest.raises(ValueError, match=says):
        make_clip(**arguments)


def test_one_frame_is_a_clip():
    assert make_clip(seconds=1 / 60).clip.frames == 1


def test_hips_never_out_of_reach():
    """The height stays below a limit that jumps."""
    rng = np.random.default_rng(0)
    limit = 80.0 + rng.uniform(0, 8, 200)
    ankle = np.stack([np.zeros(200), limit - gait.LEG_REACH, np.zeros(200)], axis=1)
    foot = gait.FootPlan(ankle, *[np.zeros(200)] * 3, *[np.ones(200, bool)] * 2, np.zeros(200))
    for frames in (1, 5, 12):
        height = gait.hip_height(np.full(200, 90.0), np.zeros((200, 3)), [np.zeros((200, 3))],
                                 [foot], frames)
        assert (height <= limit + 1e-9).all() and np.abs(np.diff(height)).max() <= np.ptp(limit)


def test_synthetic_names_its_parts():
    assert (synthetic.skeleton_joints()[0].channels == ("Xposition", "Yposition", "Zposition",
                                                        "Zrotation", "Xrotation", "Yrotation"))
    assert [j.name for j in synthetic.skeleton_joints()] == list(joints.SLOTS)
    assert ({j.name for j in synthetic.skeleton_joints() if j.end_site}
            == {"Head", "LeftFinger", "RightFinger", "LeftToe", "RightToe"})
