"""Exponential maps: there and back exactly, without jumps, on skeletons of several kinds."""

from dataclasses import replace

import numpy as np
import pytest

from refimpl.motion import bvh, rotation
from refimpl.embedded import walkers as synthetic
from refimpl.motion.clip import Clip, Joint
from refimpl.motion.skeleton import forward_kinematics, local_pose
from refimpl.embedded import performers
from refimpl.torresani2006 import poses

TURN = ("Zrotation", "Xrotation", "Yrotation")
PLACE = ("Xposition", "Yposition", "Zposition")


def world(clip):
    return forward_kinematics(clip.parents, *local_pose(clip))


def random_chain(rng, frames=30, root_joint=True):
    """A clip of a body that tumbles: every joint turns many times over, some orders differ, one
    root joint above the hips may travel.
    """
    joints = [Joint("Root", -1, (0, 0, 0), PLACE + TURN)] if root_joint else []
    joints += [Joint("Hips", len(joints) - 1, (0, 90, 0),
                     PLACE + ("Xrotation", "Yrotation", "Zrotation"))]
    hips = len(joints) - 1
    joints += [Joint("Spine", hips, (0, 12, 0), TURN),
               Joint("Leg", hips, (5, -40, 0), ("Yrotation", "Zrotation", "Xrotation"))]
    width = sum(len(joint.channels) for joint in joints)
    values = np.cumsum(rng.normal(0, 14, (frames, width)), axis=0)
    values[:, -7:] *= 0.5
    return Clip(tuple(joints), 1 / 30, values)


@pytest.mark.parametrize("root_joint", [True, False])
@pytest.mark.parametrize("seed", range(4))
def test_world_pose_comes_back(seed, root_joint):
    clip = random_chain(np.random.default_rng(seed), root_joint=root_joint)
    body = poses.fit_body([clip])
    fragment = poses.fragment_of(clip, body, "tumble")
    assert fragment.angles.shape == (30, 3 * len(clip.joints)) and fragment.root.shape == (30, 4)
    back = poses.clip_of(fragment, body)
    for found, needed in zip(world(back), world(clip)):
        # the joint above the hips stands still, the hips have its motion
        joints = slice(1, None) if root_joint else slice(None)
        np.testing.assert_allclose(found[:, joints], needed[:, joints], atol=1e-9)


def test_euler_angles_come_back_exactly():
    clip = performers.perform(("reach", "step"), 3).clip
    body = poses.fit_body([clip])
    back = poses.clip_of(poses.fragment_of(clip, body, "x", fps=60.0), body)
    np.testing.assert_allclose(back.values, clip.values, atol=1e-9)
    assert back.joints == clip.joints


def test_no_jumps_where_a_joint_turns_round_and_round():
    turns = np.linspace(0, 6 * np.pi, 400)
    axis = np.array([0.6, 0.0, 0.8])
    R = rotation.exp_map(turns[:, None, None] * axis)
    v = poses.exponential_maps(R, np.eye(3)[None])
    assert np.abs(np.diff(v, axis=0)).max() < 0.1
    np.testing.assert_allclose(poses.rotation_matrices(v, np.eye(3)[None]), R, atol=1e-12)


def test_a_joint_a_half_turn_from_zero_does_not_flip():
    """Around the half turn the shortest vector flips its sign from frame to frame; seen from the
    mean pose it is small.
    """
    swing = np.pi + 0.2 * np.sin(np.linspace(0, 20, 300))
    R = rotation.exp_map(swing[:, None, None] * np.array([1.0, 0, 0]))
    shortest = rotation.log_map(R)
    assert np.abs(np.diff(shortest, axis=0)).max() > 6
    v = poses.exponential_maps(R, rotation.nearest_rotation(R[:, 0].mean(axis=0))[None])
    assert np.linalg.norm(v, axis=-1).max() < 0.3


def test_angles_do_not_depend_on_place_and_facing():
    clip = synthetic.make_clip("walk", "old", seconds=2.0).clip
    body = poses.fit_body([clip])
    rotations, translations = local_pose(clip)
    turned = rotation.yaw_rotation(1.1)
    rotations[:, 0], translations[:, 0] = (turned @ rotations[:, 0],
                                           translations[:, 0] @ turned.T + [30, 0, -70])
    from refimpl.motion.skeleton import with_pose
    a, b = (poses.fragment_of(c, body, "x")
            for c in (clip, with_pose(clip, rotations, translations, clip.frame_time)))
    np.testing.assert_allclose(a.angles, b.angles, atol=1e-9)
    np.testing.assert_allclose(b.root[:, 3] - a.root[:, 3], 1.1, atol=1e-9)


def test_z_up_files():
    clip = performers.perform("step", 1).clip
    body = poses.fit_body([clip])
    rotations, translations = local_pose(clip)
    up = rotation.axis_rotation("X", np.pi / 2)                          # y up to z up
    rotations[:, 0], translations[:, 0] = up @ rotations[:, 0], translations[:, 0] @ up.T
    from refimpl.motion.skeleton import with_pose
    lying = with_pose(clip, rotations, translations, clip.frame_time)
    other = poses.fit_body([lying])
    assert (body.up, other.up) == ("y", "z")
    a, b = poses.fragment_of(clip, body, "x"), poses.fragment_of(lying, other, "x")
    np.testing.assert_allclose(np.diff(b.root[:, 3]), np.diff(a.root[:, 3]), atol=1e-9)
    np.testing.assert_allclose(poses.fragment_positions(b, other), world(lying)[1][::2], atol=1e-9)


def test_errors():
    clip = performers.perform("bow", 0).clip
    body = poses.fit_body([clip])
    other = replace(clip, joints=tuple(replace(j, name="Pelvis" if j.name == "Hips" else j.name)
                                       for j in clip.joints))
    with pytest.raises(poses.PoseError, match="Hips, Pelvis"):
        poses.fragment_of(other, body, "walk.bvh")
    with pytest.raises(poses.PoseError, match="clips: found none"):
        poses.fit_body([])
    with pytest.raises(poses.PoseError, match="clip 1"):
        poses.fit_body([clip, other])
    with pytest.raises(poses.PoseError, match="frames 5 to 6"):
        poses.fragment_of(clip, body, "walk.bvh", start=5, end=6)
    with pytest.raises(poses.PoseError, match="at least two"):
        # 60 to 30 frames a second leaves one
        poses.fragment_of(clip, body, "walk.bvh", start=5, end=7)


@pytest.mark.mocap
def test_real_clips_come_back(mocap):
    clips = [bvh.read_bvh(mocap / "bandai1" / f"dataset-1_{name}_001.bvh")
             for name in ("bow_old", "dash_angry", "byebye_active")]
    body = poses.fit_body(clips)
    assert body.joints[body.carrier].name == "Hips" and body.up == "y"
    for clip in clips:
        fragment = poses.fragment_of(clip, body, "x")
        needed, found = world(clip), world(poses.clip_of(fragment, body))
        np.testing.assert_allclose(found[0], needed[0], atol=1e-11)
        # the files' bones differ by this much
        np.testing.assert_allclose(found[1], needed[1], atol=1e-3)
        assert np.abs(np.diff(fragment.angles, axis=0)).max() < 2
