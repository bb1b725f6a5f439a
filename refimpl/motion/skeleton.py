r"""Poses of a whole skeleton: local rotations and translations of each joint, where that puts the
joints in the world, and time.

A pose is `rotations (T, J, 3, 3)` and `translations (T, J, 3)`, both relative to the parent joint,
of every joint of the clip.
"""

import numpy as np
from scipy.interpolate import CubicSpline

from . import rotation
from .clip import POSITION_CHANNELS, Clip

SLOWEST, FASTEST = 0.5, 10000.0                                  # frames a second of a recording


def local_pose(clip):
    """The local transform of every joint in every frame.

    Clip  ->  rotations (T, J, 3, 3), translations (T, J, 3) in the file's unit. A position channel
    replaces the joint's OFFSET along its axis; a joint without rotation channels keeps the
    identity.
    """
    rotations, translations = [], []
    column = 0
    for joint in clip.joints:
        values = dict(zip(joint.channels, clip.values[:, column:column + len(joint.channels)].T))
        column += len(joint.channels)
        translations.append(
            np.stack([
                np.broadcast_to(values.get(name, offset), clip.frames)
                for name, offset in zip(POSITION_CHANNELS, joint.offset)], axis=-1))
        order = joint.rotation_order
        angles = np.stack([values[f"{axis}rotation"]
                           for axis in order], axis=-1) if order else np.zeros((clip.frames, 0))
        rotations.append(rotation.euler_to_matrix(np.radians(angles), order))
    return np.stack(rotations, axis=1), np.stack(translations, axis=1)


def with_pose(clip, rotations, translations, frame_time):
    """A clip on the same joints with another pose: the inverse of `local_pose`.

    Euler angles are written in each joint's own order and without jumps of 360 degrees from frame
    to frame. A joint that has some but not all three rotation channels cannot hold every rotation;
    it gets all three (its own first) when its rotation needs them. Translations are written where
    the joint has position channels; elsewhere the OFFSET stands.
    """
    joints, columns = [], []
    for index, joint in enumerate(clip.joints):
        order = joint.rotation_order
        angles = _angles(rotations[:, index], order)
        if angles is None:
            order += "".join(axis for axis in "ZXY" if axis not in order)
            angles = _angles(rotations[:, index], order)
            positions = tuple(c for c in joint.channels if c in POSITION_CHANNELS)
            joint = type(joint)(joint.name, joint.parent, joint.offset,
                                positions + tuple(f"{axis}rotation" for axis in order),
                                joint.end_site)
        values = dict(zip(POSITION_CHANNELS, translations[:, index].T))
        values.update({f"{axis}rotation": column for axis, column in zip(order, angles.T)})
        joints.append(joint)
        columns += [values[channel] for channel in joint.channels]
    return Clip(tuple(joints), frame_time,
                np.stack(columns, axis=1) if columns else np.zeros((len(rotations), 0)))


def _angles(R, order):
    """Degrees (T, len(order)), continuous over time; None when these axes alone cannot make R."""
    full = order + "".join(axis for axis in "ZXY" if axis not in order)
    angles = rotation.matrix_to_euler(R, full)
    if np.abs(angles[:, len(order):]).max(initial=0) > 1e-9:
        return None
    return np.degrees(np.unwrap(angles[:, :len(order)], axis=0))


def forward_kinematics(parents, rotations, translations):
    r"""World transforms from local ones, parents before children:

        R_j = R_parent(j) r_j,    p_j = p_parent(j) + R_parent(j) t_j

    parents : (J,), -1 for the root;  rotations : (T, J, 3, 3);  translations : (T, J, 3)
    ->  world rotations (T, J, 3, 3), world positions (T, J, 3)
    """
    world_rotations, positions = [], []
    for j, parent in enumerate(parents):
        if parent < 0:
            world_rotations.append(rotations[:, j])
            positions.append(translations[:, j])
        else:
            world_rotations.append(world_rotations[parent] @ rotations[:, j])
            positions.append(positions[parent]
                             + (world_rotations[parent] @ translations[:, j, :, None])[..., 0])
    return np.stack(world_rotations, axis=1), np.stack(positions, axis=1)


def resample(rotations, translations, fps, new_fps, *, smooth=True):
    """A pose at another frame rate, first frame on first frame; what stands in both stays as it is.

    To a higher rate along smooth curves through the frames: translations by a cubic spline,
    rotations by one on the sphere (`rotation.smooth_rotations`). Straight lines would leave a
    corner at every frame, whose jerk is several times the motion's own. To a lower rate frames are
    left out, and what falls between two is read by slerp. Never interpolate Euler angles: they wrap
    by 360 degrees and swing near the gimbal pole.

    rotations (T, J, 3, 3), translations (T, J, 3), frames a second;  smooth : False for slerp and
    straight lines to higher rates too  ->  the same at `new_fps`.
    T frames at 30 fps give 2 T - 1 at 60. The same rate gives the same arrays; one frame stays one.
    """
    frames = len(rotations)
    if fps == new_fps or frames == 1:
        return rotations, translations
    if not SLOWEST <= fps <= FASTEST:
        raise ValueError(
            f"frame rate: found {fps:g} frames/s, needed {SLOWEST:g} to {FASTEST:g} to "
            f"make {new_fps:g} of them; is the frame time right?")
    new_frames = int(np.floor((frames - 1) * new_fps / fps + 1e-6)) + 1
    time = np.minimum(np.arange(new_frames) * (fps / new_fps), frames - 1)
    if smooth and new_fps > fps:
        return (rotation.smooth_rotations(rotations, time),
                CubicSpline(np.arange(frames), translations)(time))
    before = np.minimum(time.astype(int), frames - 2)
    t = time - before
    return (rotation.slerp(rotations[before], rotations[before + 1],
                           t[:, None]), translations[before] + t[:, None, None] *
            (translations[before + 1] - translations[before]))


def clip_at(clip, fps=60.0):
    """The pose of a clip at a frame rate, 60 a second unless told.
    Clip  ->  rotations, translations
    """
    return resample(*local_pose(clip), clip.fps, fps)
