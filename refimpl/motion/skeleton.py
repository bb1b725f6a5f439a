r"""Poses of a whole skeleton: local rotations and translations of each joint, where that puts the
joints in the world, and time.

A pose is `rotations (T, J, 3, 3)` and `translations (T, J, 3)`, both relative to the parent joint,
of every joint of the clip.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from . import rotation
from .clip import POSITION_CHANNELS, Clip, Joint
from .features import AT_A_TIME

SLOWEST, FASTEST = 0.5, 10000.0                      # frames a second of a recording


def ancestors(joints: Sequence[Joint], j: int) -> list[int]:
    """A joint and all above it, up to the root.

    joints : those of a clip;  j : index of the joint  ->  indices, j first

    >>> ancestors([Joint("root", -1, (), ()), Joint("a", 0, (), ()), Joint("b", 1, (), ())], 2)
    [2, 1, 0]
    """
    above = []
    while j >= 0:
        above.append(int(j))
        j = joints[j].parent
    return above


def carrier(joints: Sequence[Joint], j: int) -> int:
    """The joint whose position channels carry a joint through the world: itself or the nearest one
    above it that has all three.

    joints : those of a clip;  j : index of the joint  ->  index, or -1 where nothing can carry it

    >>> root, hips = Joint("root", -1, (), POSITION_CHANNELS), Joint("hips", 0, (), ())
    >>> carrier([root, hips], 1), carrier([hips], -1)
    (0, -1)
    """
    free = (k for k in ancestors(joints, j) if set(POSITION_CHANNELS) <= set(joints[k].channels))
    return next(free, -1)


def local_pose(clip: Clip) -> tuple[np.ndarray, np.ndarray]:
    """The local transform of every joint in every frame.

    A position channel replaces the joint's OFFSET along its axis; a joint without rotation channels
    keeps the identity.

    clip : T frames of J joints
    ->  rotations (T, J, 3, 3), translations (T, J, 3) in the file's unit
    """
    J, frames = len(clip.joints), len(clip.values)
    rotations = np.broadcast_to(np.eye(3), (frames, J, 3, 3)).copy()
    translations = np.broadcast_to(np.array([joint.offset for joint in clip.joints], float),
                                   (frames, J, 3)).copy()
    begins = np.cumsum([0, *(len(joint.channels) for joint in clip.joints)])
    for channels, some in _by_channels(clip.joints).items():     # all joints of one kind at once
        values = clip.values[:, begins[some, None] + np.arange(len(channels))]   # (T, n, channels)
        for axis, name in enumerate(POSITION_CHANNELS):
            if name in channels:
                translations[:, some, axis] = values[..., channels.index(name)]
        turns = [n for n, name in enumerate(channels) if name not in POSITION_CHANNELS]
        if turns:
            rotations[:, some] = rotation.euler_to_matrix(
                np.radians(values[..., turns]), "".join(channels[n][0] for n in turns))
    return rotations, translations


def _by_channels(joints):
    """{channels: indices of the joints that have them}"""
    found: dict[tuple[str, ...], list[int]] = {}
    for j, joint in enumerate(joints):
        found.setdefault(joint.channels, []).append(j)
    return {channels: np.array(some) for channels, some in found.items()}


def with_pose(clip: Clip, rotations: np.ndarray, translations: np.ndarray,
              frame_time: float, free: Iterable[int] = ()) -> Clip:
    """A clip on the same joints with another pose: the inverse of `local_pose`.

    Euler angles are written in each joint's own order and without jumps of 360 degrees from frame
    to frame. A joint that has some but not all three rotation channels cannot hold every rotation;
    it gets all three (its own first) when its rotation needs them. Translations are written where
    the joint has position channels; elsewhere the OFFSET stands.

    clip : whose joints these are
    rotations : (T, J, 3, 3);  translations : (T, J, 3) in the file's unit
    frame_time : seconds a frame
    ->  Clip of T frames
    """
    pieces = ((rotations[n:n + AT_A_TIME], translations[n:n + AT_A_TIME])
              for n in range(0, len(rotations), AT_A_TIME))
    return with_poses(clip, len(rotations), pieces, frame_time, free)


def with_poses(clip: Clip, frames: int, poses: Iterable[tuple[np.ndarray, np.ndarray]],
               frame_time: float, free: Iterable[int] = ()) -> Clip:
    """`with_pose` of a pose that comes in pieces, one after another, of so many frames together."""
    joints, kinds, free = list(clip.joints), _by_channels(clip.joints), set(free)
    full = {channels: _whole_order(channels) for channels in kinds}
    # All channels that a joint may get, its own first: what is not needed is left out at the end.
    wide = [(*joint.channels, *(c for c in (*(POSITION_CHANNELS if j in free else ()),
                                            *full[joint.channels]) if c not in joint.channels))
            for j, joint in enumerate(joints)]
    begins = np.cumsum([0, *map(len, wide)])
    at = [{c: begins[j] + n for n, c in enumerate(names)} for j, names in enumerate(wide)]
    table, farthest, begin = np.empty((frames, begins[-1])), np.zeros((2, len(joints))), 0
    for rotations, translations in poses:
        rows = slice(begin, begin := begin + len(rotations))
        for channels, some in kinds.items():
            angles = rotation.matrix_to_euler(rotations[:, some],
                                              "".join(c[0] for c in full[channels]))
            table[rows, [[at[j][c] for c in full[channels]] for j in some]] = angles
            away = translations[:, some] - np.array([joints[j].offset for j in some], float)
            for most, found in zip(farthest, (angles[..., _turns(channels):], away)):
                most[some] = np.maximum(most[some], np.abs(found).max(axis=(0, 2), initial=0))
        for axis, name in enumerate(POSITION_CHANNELS):
            having = [j for j in range(len(joints)) if name in at[j]]
            table[rows, [at[j][name] for j in having]] = translations[:, having, axis]
    for channels, some in kinds.items():
        together = max(1, 64 * AT_A_TIME // max(frames, 1))
        for n in range(0, len(some), together):      # joints whose curves are made at a time
            columns = [[at[j][c] for c in full[channels]] for j in some[n:n + together]]
            angles = table[:, columns]                                           # (T, n, 3)
            if _turns(channels) == 3:
                angles = followed_euler(angles)
            table[:, columns] = np.degrees(np.unwrap(angles, axis=0))
        size = max(abs(x) for j in some for x in joints[j].offset)
        for j in some:
            own = channels
            if farthest[0, j] > 1e-9:                                            # radians
                own = (*(c for c in own if c in POSITION_CHANNELS), *full[channels])
            if farthest[1, j] > 1e-9 * (1e-9 + size) and j in free:
                own = (*POSITION_CHANNELS, *(c for c in own if c not in POSITION_CHANNELS))
            joints[j] = replace(joints[j], channels=own) if own != channels else joints[j]
    keep = [at[j][c] for j, joint in enumerate(joints) for c in joint.channels]
    return Clip(tuple(joints), frame_time,
                table if keep == list(range(begins[-1])) else table[:, keep])


def _turns(channels):
    """How many of the channels are rotations."""
    return sum(c not in POSITION_CHANNELS for c in channels)


def _whole_order(channels):
    """Three rotation channels, those that are there first."""
    own = [c for c in channels if c not in POSITION_CHANNELS]
    return (*own, *(f"{axis}rotation" for axis in "ZXY" if f"{axis}rotation" not in own))


def followed_euler(angles: np.ndarray) -> np.ndarray:
    """Of the two readings of each frame, (a, b, c) and (a + pi, pi - b, c + pi), the one that is
    nearer to the frame before, so that curves do not jump by half a turn.

    angles : (T, ..., 3) radians  ->  the same, the first frame's as it was
    """
    other = angles * [1.0, -1.0, 1.0] + np.pi
    steps = np.stack([other[1:] - angles[:-1], np.diff(angles, axis=0)])
    far = np.abs(rotation.nearest_turn(steps)).sum(axis=-1)
    use = np.logical_xor.accumulate(far[0] < far[1], axis=0)
    return np.concatenate([angles[:1], np.where(use[..., None], other[1:], angles[1:])])


def forward_kinematics(parents: Iterable[int], rotations: np.ndarray,
                       translations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    r"""World transforms from local ones, parents before children:

        R_j = R_parent(j) r_j,    p_j = p_parent(j) + R_parent(j) t_j

    parents : (J,), -1 for the root;  rotations : (T, J, 3, 3);  translations : (T, J, 3)
    ->  world rotations (T, J, 3, 3), world positions (T, J, 3)

    >>> turns = rotation.axis_rotation("Z", [[np.pi / 2, 0.0]])      # one frame, the root turned
    >>> forward_kinematics([-1, 0], turns, np.array([[[0, 5, 0], [2, 0, 0]]]))[1].round(6)
    array([[[0., 5., 0.],
            [0., 7., 0.]]])
    """
    world_rotations: list[np.ndarray] = []
    positions: list[np.ndarray] = []
    for j, parent in enumerate(parents):
        if parent < 0:
            world_rotations.append(rotations[:, j])
            positions.append(translations[:, j])
        else:
            above = world_rotations[parent]
            world_rotations.append(above @ rotations[:, j])
            positions.append(positions[parent] + (above @ translations[:, j, :, None])[..., 0])
    return np.stack(world_rotations, axis=1), np.stack(positions, axis=1)


def resample(rotations: np.ndarray, translations: np.ndarray, fps: float, new_fps: float, *,
             smooth: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """A pose at another frame rate, first frame on first frame; what stands in both stays as it is.

    To a higher rate along smooth curves through the frames: translations by a cubic spline,
    rotations by one on the sphere (`rotation.smooth_rotations`). Straight lines would leave a
    corner at every frame, whose jerk is several times the motion's own. To a lower rate frames are
    left out, and what falls between two is read by slerp. Never interpolate Euler angles: they wrap
    by 360 degrees and swing near the gimbal pole.

    rotations : (T, J, 3, 3);  translations : (T, J, 3)
    fps, new_fps : frames a second, now and wanted
    smooth : False for slerp and straight lines to higher rates too
    ->  the same at `new_fps`; the same arrays where there is nothing to do
    Raises ValueError for a rate that no recording has.

    >>> R, t = np.tile(np.eye(3), (3, 1, 1, 1)), np.array([[[0, 0, 0]], [[2, 0, 0]], [[4, 0, 0]]])
    >>> resample(R, t, 30.0, 60.0)[1][:, 0, 0].round(6)              # 2 T - 1 frames
    array([0., 1., 2., 3., 4.])
    """
    frames = len(rotations)
    if fps == new_fps or frames == 1:
        return rotations, translations
    if not SLOWEST <= fps <= FASTEST:
        raise ValueError(f"frame rate: found {fps:g} frames/s, needed {SLOWEST:g} to {FASTEST:g} "
                         f"to make {new_fps:g} of them; is the frame time right?")
    new_frames = int(np.floor((frames - 1) * new_fps / fps + 1e-6)) + 1
    time = np.minimum(np.arange(new_frames) * (fps / new_fps), frames - 1)
    if smooth and new_fps > fps:
        return (rotation.smooth_rotations(rotations, time),
                CubicSpline(np.arange(frames), translations)(time))
    before = np.minimum(time.astype(int), frames - 2)
    t = (time - before)[:, None]
    a, b = translations[before], translations[before + 1]
    return (rotation.slerp(rotations[before], rotations[before + 1], t),
            a + t[..., None] * (b - a))


def clip_at(clip: Clip, fps: float = 60.0) -> tuple[np.ndarray, np.ndarray]:
    """The pose of a clip at a frame rate, 60 a second unless told, by `resample`.

    clip : J joints  ->  rotations (T, J, 3, 3), translations (T, J, 3)
    """
    return resample(*local_pose(clip), clip.fps, fps)
