"""To the canonical body and back: nothing changes where nothing was changed, on any body; the same
motion on two bodies is one motion there; a change is carried over, weighed, and read back.
"""

from dataclasses import replace

import numpy as np
import pytest

from refimpl.motion import bvh, canonical, skeleton
from refimpl.motion.body import make_take, seen
from refimpl.motion.features import decode, encode, leg_length
from refimpl.motion.foot_ik import lock_feet
from refimpl.motion.joints import BONES, SLOT
from refimpl.motion.moved import moved_clip, rig
from refimpl.motion.rotation import log_map
from refimpl.motion.stylised import onto_skeleton

from . import bodies

BODY = canonical.measured(make_take(bodies.walker()).positions)
# Twelve skeletons: scheme, proportions, what else.
MATRIX = [("CMU", dict(legs=0.7, arms=1.3), ()), ("Mixamo", dict(shoulders=1.4), ("metres",)),
          ("Bandai", {}, ()), ("100STYLE", dict(hips=1.4, trunk=0.7), ("z up",)),
          ("SMPL L_Hip", dict(legs=1.3, feet=0.7), ("turned",)), ("Blender", dict(feet=1.4), ()),
          ("Unreal", dict(arms=0.6, shoulders=0.6), ("turned", "z up")),
          ("VRM", dict(trunk=1.4), ("rate 24",)), ("Geno", dict(legs=1.4), ("rate 120", "turned")),
          ("Biovision", dict(hips=0.7), ("rate 30",)), ("MVN", dict(scale=0.4), ()),
          ("Biped, usual tree", dict(arms=1.4), ("biped",)), ("Kinect", {}, ("five frames",))]


def made(name, change, extra, content="walk", style="normal", seconds=2.0):
    clip, _ = bodies.on_scheme(bodies.walker(content, style, seconds, **change), name)
    for what in extra:
        clip = {"metres": lambda: bodies.scaled(clip, 0.01), "z up": lambda: bodies.z_up(clip),
                "turned": lambda: bodies.turned_rest(clip, np.random.default_rng(3)),
                "biped": lambda: bodies.as_biped(clip),
                "five frames": lambda: replace(clip, values=clip.values[:5]),
                **{f"rate {n}": (lambda n=n: bodies.at_rate(clip, n)) for n in (24, 30, 120)}
                }[what]()
    return clip


def styled_numbers(take, body, *, strange=0.5):
    """What a network might make of a take: a bow, raised arms, a lower body and another way."""
    there = seen(take, body)
    points = decode(there.features, there.start)
    bent = points.copy()
    spine = [SLOT[s] for s in ("Chest", "Neck", "Head", "LeftArm", "RightArm")]
    arms = [SLOT[side + s] for side in ("Left", "Right") for s in ("ForeArm", "Hand", "Finger")]
    forward = np.array([0.0, -0.05, 0.15]) * strange * body.leg
    bent[:, spine + arms] += forward
    bent[:, arms] += [0.0, 0.1 * strange * body.leg, 0.0]
    bent[:, :, 1] -= 0.03 * strange * body.leg
    return there, encode(bent, 0.0)[0]


@pytest.mark.parametrize("name, change, extra", MATRIX)
def test_the_identity_gives_the_clip_back(name, change, extra):
    """To 1e-6 of its height and 1e-4 degrees, at its own rate, before the feet are planted; with
    feet planted hips and shoulders keep their width."""
    clip = made(name, change, extra)
    take = make_take(clip)
    there = seen(take, BODY)
    result = onto_skeleton(take, there, there.features.copy(), clean=False)
    assert (result.clip.joints == clip.joints and result.clip.frames == clip.frames
            and result.clip.frame_time == clip.frame_time)
    old, new = (skeleton.forward_kinematics(c.parents, *skeleton.local_pose(c))
                for c in (clip, bvh.parse_bvh(bvh.format_bvh(result.clip))))
    assert np.abs(new[1] - old[1]).max() < 1e-6 * 1.75 * take.leg
    turned = np.linalg.norm(log_map(old[0].swapaxes(-1, -2) @ new[0]), axis=-1)
    assert turned.max() < np.radians(1e-4)
    planted = onto_skeleton(take, there, there.features.copy()).positions
    for a, b in (("LeftUpLeg", "RightUpLeg"), ("LeftArm", "RightArm")):
        widths = [np.linalg.norm(p[:, SLOT[a]] - p[:, SLOT[b]], axis=1)
                  for p in (take.positions, planted)]
        np.testing.assert_allclose(widths[1], widths[0], rtol=1e-9)


@pytest.mark.parametrize("name, change, extra", MATRIX)
def test_a_change_comes_back_to_the_same_motion(name, change, extra):
    """Stylised on any body, written, read, and brought to the canonical body again: what was meant,
    as far as the body has the joints for it; every bone as long as it was, feet where they were."""
    take = make_take(made(name, change, extra))
    there, features = styled_numbers(take, BODY)
    result = onto_skeleton(take, there, features, clean=False)
    again = make_take(bvh.parse_bvh(bvh.format_bvh(result.clip)), name=name)
    lengths = [np.linalg.norm(skeleton.local_pose(c)[1][:, j], axis=-1)
               for c in (take.clip, result.clip) for j in range(1, len(take.clip.joints))
               if j not in rig(take.clip.joints, take.mapping).placed]
    half = len(lengths) // 2
    for before, after in zip(lengths[:half], lengths[half:]):
        np.testing.assert_allclose(after, before, rtol=1e-6, atol=1e-9 * take.leg)
    assert {k: v for k, v in again.mapping.made_up.items()} == dict(take.mapping.made_up)
    wanted = canonical.change(*(decode(f, there.start) for f in (there.features, features)))
    found = canonical.change(take.positions, again.positions)
    compared = [SLOT[s] for s in ("Hips", "Chest", "LeftUpLeg", "RightLeg", "LeftArm",
                                  "RightForeArm", "Neck", "LeftFoot", "RightHand")]
    off = np.degrees(np.linalg.norm(log_map(
        found.turns[:, compared].swapaxes(-1, -2) @ wanted.turns[:, compared]), axis=-1))
    rate = take.clip.fps
    assert np.median(off[:: max(1, round(60 / rate))]) < (0.01 if "five frames" not in extra else 1)


def test_one_take_on_two_bodies_is_one_motion():
    """(What is not: other thighs to shins, other feet.)"""
    base = seen(make_take(made("Bandai", {}, ())), BODY).features
    for name, change, extra in MATRIX[:7]:
        if "feet" in change:
            continue
        features = seen(make_take(made(name, change, extra)), BODY).features
        error = np.sqrt(np.mean((features - base)[:, :63] ** 2))
        still = np.sqrt(np.mean((base - base.mean(axis=0))[:, :63] ** 2))
        assert error < 0.08 * still


def test_limbs_hung_elsewhere_get_the_same_result_with_rigid_sockets():
    usual, _ = bodies.on_scheme(bodies.walker(), "Biped, usual tree")
    results = []
    bare = bodies.as_biped(bodies.stiff(usual))      # no position channels, thighs as still as hips
    assert not any("position" in c for j in bare.joints[1:] for c in j.channels)
    assert np.abs(_result(bare) - _result(bodies.stiff(usual))).max() < 1e-6
    for clip in (usual, bodies.as_biped(usual)):
        take = make_take(clip)
        there, features = styled_numbers(take, BODY)
        result = onto_skeleton(take, there, features)
        again = make_take(result.clip)
        results.append(again.positions)
        pelvis = canonical.rigid_frames(again.positions)[0]
        sockets = (again.positions[:, canonical.PELVIS[:2]] - again.positions[:, [0]]) @ pelvis
        assert np.ptp(sockets, axis=0).max() < 1e-6
    np.testing.assert_allclose(results[1], results[0], atol=1e-6)


def _result(clip):
    take = make_take(clip)
    there, features = styled_numbers(take, BODY)
    return make_take(onto_skeleton(take, there, features).clip).positions


def test_one_motion_written_in_many_ways_gives_one_result():
    """Rotation orders, position channels, OFFSETs of 0, rest poses, roots above the hips, another
    place: to 1e-9 legs."""
    clip, _ = bodies.on_scheme(bodies.walker(seconds=1.0), "Unity")
    rng = np.random.default_rng(5)
    free = bodies.free_everywhere(clip)
    pose = skeleton.local_pose(clip)
    ways = [clip, free, bodies.turned_rest(clip, rng), bodies.turned_rest(free, rng)]
    for order in ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"):
        joints = tuple(replace(j, channels=tuple(c for c in j.channels if "pos" in c) + tuple(
            f"{axis}rotation" for axis in order)) for j in clip.joints)
        ways.append(skeleton.with_pose(replace(clip, joints=joints), *pose, clip.frame_time))
    flat = replace(free, joints=tuple(replace(j, offset=(0.0, 0.0, 0.0)) for j in free.joints))
    ways.append(flat)
    ways.append(replace(free, joints=tuple(replace(j, channels=j.channels[3:] + j.channels[:3])
                                           for j in free.joints)))
    ways[-1] = skeleton.with_pose(ways[-1], *pose, clip.frame_time)
    results = []
    for way in ways:
        take = make_take(way)
        there, features = styled_numbers(take, BODY)
        results.append(onto_skeleton(take, there, features).positions)
    for other in results[1:]:
        assert np.abs(other - results[0]).max() < 1e-9 * leg_length(results[0])


def test_strength_and_parts():
    take = make_take(made("Mixamo", {}, ()))
    there, features = styled_numbers(take, BODY)
    whole = onto_skeleton(take, there, features, clean=False)
    none, half, more = (onto_skeleton(take, there, features, clean=False, strength=s)
                        for s in (0.0, 0.5, 1.3))
    np.testing.assert_allclose(none.positions, take.positions, atol=1e-9)
    moved = [np.linalg.norm(r.positions - take.positions, axis=-1).mean()
             for r in (half, whole, more)]
    assert 0.4 * moved[1] < moved[0] < 0.6 * moved[1] and 1.2 * moved[1] < moved[2]
    arms = onto_skeleton(take, there, features, clean=False, only=("arms",)).positions
    still = [SLOT[s] for s in ("Hips", "LeftToe", "Head", "LeftArm")]
    np.testing.assert_allclose(arms[:, still], take.positions[:, still], atol=1e-9)
    assert np.abs(arms[:, SLOT["LeftHand"]] - take.positions[:, SLOT["LeftHand"]]).max() > 1
    for parent, slot in BONES:
        np.testing.assert_allclose(*(np.linalg.norm(p[:, slot] - p[:, parent], axis=1)
                                     for p in (arms, take.positions)), rtol=1e-9)


@pytest.mark.parametrize("fps", [None, 24.0, 60.0, 100.0])
def test_the_rate_is_the_clips_own_or_the_one_asked_for(fps):
    take = make_take(made("Unity", {}, ("rate 30",)))
    there, features = styled_numbers(take, BODY)
    result = onto_skeleton(take, there, features, fps=fps)
    rate = fps or 30.0
    assert result.clip.fps == pytest.approx(rate)
    assert result.clip.frames == int((take.clip.frames - 1) * rate / 30 + 1e-6) + 1
    again = make_take(result.clip)
    count = min(len(again.positions), len(result.positions))
    off = np.linalg.norm(again.positions[:count] - result.positions[:count], axis=-1)
    assert np.median(off) < 2e-3 * take.leg


def test_planting_changes_legs_and_height_alone():
    take = make_take(made("CMU", dict(legs=0.8), ()))
    planted = lock_feet(take.positions, take.contacts, take.rests[1::2])
    turns = canonical.change(take.positions, planted).turns
    still = [SLOT[s] for s in ("Hips", "Spine", "Chest", "Neck", "LeftArm", "RightHand")]
    np.testing.assert_allclose(turns[:, still], np.broadcast_to(np.eye(3), turns[:, still].shape),
                               atol=1e-9)
    made_clip = moved_clip(take, rig(take.clip.joints, take.mapping),
                           canonical.change(take.positions, planted))
    assert made_clip.frames == take.clip.frames and made_clip.joints == take.clip.joints
