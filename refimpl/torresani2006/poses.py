r"""Poses as exponential maps, for any skeleton: joint angles that can be subtracted, averaged and
compared.

A joint's rotation is written as the rotation vector that leads to it from a reference pose. The
reference is the mean pose of the database: a file's own zero need not be near any pose (some have
thighs a half turn away from it, where the vector jumps to its opposite).

The root's motion (where the body is and which way it faces) is kept apart from the angles, so that
the same action done elsewhere is the same.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from ..motion import rotation
from ..motion.body import relative_size
from ..motion.clip import Clip, Joint
from ..motion.features import FLOOR
from ..motion.skeleton import (ancestors, carrier, forward_kinematics, local_pose, resample,
                               with_pose)

POSE_FPS = 30.0
POSITION, HEADING = slice(0, 3), 3           # the columns of a root (T, 4)


class PoseError(ValueError):
    """Clips that do not share a skeleton, or frames that are not there."""


@dataclass(frozen=True)
class Body:
    """The skeleton that all fragments of a database share.

    carrier : the joint that carries the body through the world, usually the hips
    bones : (J, 3) local translations;  reference : (J, 3, 3) the pose where all angles are 0
    up : "y" or "z"
    """

    joints: tuple[Joint, ...]
    carrier: int
    bones: np.ndarray = field(repr=False)
    reference: np.ndarray = field(repr=False)
    up: str

    @property
    def parents(self) -> np.ndarray:
        """The index of each joint's parent, -1 for the root.   ->  (J,)"""
        return np.array([joint.parent for joint in self.joints])

    @property
    def floor(self) -> list[int]:
        """The two horizontal columns of a position."""
        return FLOOR[self.up]

    @property
    def above(self) -> list[int]:
        """The joints above the carrier, which stand still; the nearest first."""
        return ancestors(self.joints, self.carrier)[1:]

    @property
    def size(self) -> float:
        """The sum of all bones below the carrier, to compare bodies by."""
        lengths = np.linalg.norm(self.bones, axis=1)
        return float(np.delete(lengths, [self.carrier, *self.above]).sum())


@dataclass(frozen=True)
class Fragment:
    """One action of one performer.

    content : its label or None;  style : (3,) flow, weight, time, or None
    angles : (T, 3 J) radians, joint after joint
    root : (T, 4) position in the file's unit and heading in radians;  fps : frames a second
    """

    name: str
    content: str | None
    style: np.ndarray | None
    angles: np.ndarray = field(repr=False)
    root: np.ndarray = field(repr=False)
    fps: float = POSE_FPS

    @property
    def frames(self) -> int:
        """How many frames there are."""
        return len(self.angles)


def exponential_maps(rotations: np.ndarray, reference: np.ndarray) -> np.ndarray:
    r"""Rotation vectors seen from a reference, continuous over time:   v = log(reference^T R)

    `rotation_matrices` is the exact inverse. Each frame has, of the vectors v + 2 pi k u of its
    rotation, u = v / |v|, the one nearest to the frame before: a joint that turns through more
    than half a turn gets vectors longer than pi rather than a jump. The first frame has the
    shortest vector, or that one turn less, if the whole track is then shorter in the mean and has
    no longer step.

    rotations : (T, J, 3, 3), reference : (J, 3, 3)  ->  (T, 3 J) radians

    >>> turning = rotation.axis_rotation("X", [[0.0], [2.0], [4.0]])         # beyond half a turn
    >>> exponential_maps(turning, np.eye(3)[None])[:, 0].round(6)
    array([0., 2., 4.])
    """
    shortest = rotation.log_map(reference.swapaxes(-1, -2) @ rotations)
    smooth = _continuous(shortest, shortest[0])
    other = _continuous(shortest, shortest[0] - 2 * np.pi * _direction(shortest[0], shortest[0]))
    lengths = [np.linalg.norm(vectors, axis=-1).mean(axis=0) for vectors in (other, smooth)]
    steps = [np.linalg.norm(np.diff(vectors, axis=0), axis=-1).max(axis=0, initial=0)
             for vectors in (other, smooth)]
    nearer = (lengths[0] < lengths[1] - 1e-9) & (steps[0] < steps[1] + 1e-9)
    return np.where(nearer[:, None], other, smooth).reshape(len(rotations), -1)


def rotation_matrices(angles: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """R = reference exp(v).   angles : (T, 3 J), reference : (J, 3, 3)  ->  (T, J, 3, 3)"""
    return reference @ rotation.exp_map(angles.reshape(len(angles), -1, 3))


def _continuous(vectors, first):
    r"""The equivalent of each vector nearest to the one before.

    v and v + 2 pi k u are one rotation for u = v / |v| and any whole k; k = round((u . before -
    |v|) / 2 pi) is the nearest.

    vectors : (T, J, 3), first : (J, 3) where to begin  ->  (T, J, 3)
    """
    out, before = np.empty_like(vectors), first
    for t, v in enumerate(vectors):
        u = _direction(v, before)
        turns = np.round((np.sum(u * before, axis=-1) - np.sum(u * v, axis=-1)) / (2 * np.pi))
        before = out[t] = v + 2 * np.pi * turns[:, None] * u
    return out


def _direction(v, before):
    """v / |v|; where v is 0 every direction is right, and that of the vector before is taken."""
    v = np.where(np.linalg.norm(v, axis=-1, keepdims=True) < 1e-9, before, v)
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    return v / np.where(length == 0, 1, length)


def _odd_names(clip, joints):
    """Some names that tell two skeletons apart; nothing where they are the same."""
    here, there = ([(joint.name, joint.parent) for joint in of] for of in (clip.joints, joints))
    odd = sorted({name for name, _ in here} ^ {name for name, _ in there})[:4]
    return "" if here == there else ", ".join(odd) or "the same names in another order"


def fit_body(clips: Iterable[Clip]) -> Body:
    """The common skeleton of some clips, and their mean pose as the reference.

    clips : at least one   ->  Body.   Raises PoseError when names or parents differ.
    """
    clips = list(clips)
    if not clips:
        raise PoseError("clips: found none, needed at least one to know the skeleton from")
    joints = clips[0].joints
    for number, clip in enumerate(clips):
        if odd := _odd_names(clip, joints):
            raise PoseError(f"clip {number}: found a skeleton that differs from clip 0's ({odd}), "
                            "needed the same joints in all clips of a database; keep one skeleton "
                            "to a folder")
    carrying = _carrier(joints)
    above = ancestors(joints, carrying)[1:]
    poses = [local_pose(clip) for clip in clips]
    worlds = [forward_kinematics(clip.parents, *pose) for clip, pose in zip(clips, poses)]
    bones = np.median([translations[0] for _, translations in poses], axis=0)
    for j in above:
        bones[j] = joints[j].offset
    reference = rotation.nearest_rotation(sum(rotations.mean(axis=0) for rotations, _ in poses))
    reference[above] = np.eye(3)
    # A body is taller than deep: up is the axis that its joints spread along more. (Which of them
    # is the head, as `body.up_axis` wants to know, nobody has said.)
    # A root that stays behind while the body walks away from it says nothing.
    spread = np.mean([np.ptp(np.delete(p, above, axis=1), axis=1).mean(axis=0) for _, p in worlds],
                     axis=0)
    up = "z" if spread[2] > spread[1] else "y"
    carried = [world[:, carrying] for world, _ in worlds]
    ahead = [rotation.axis_rotation(up.upper(), -heading(R, carried[0][0], up)) @ R
             for R in carried]
    reference[carrying] = rotation.nearest_rotation(sum(R.mean(axis=0) for R in ahead))
    return Body(joints, carrying, bones, reference, up)


def _carrier(joints):
    """Down the chain from the root as long as it does not branch: the last joint that can be moved
    freely, else the root.
    """
    last, children = 0, [0]
    while len(children) == 1:
        last = children[0]
        children = [j for j, joint in enumerate(joints) if joint.parent == last]
    return max(carrier(joints, last), 0)


def heading(R: np.ndarray, reference: np.ndarray, up: str) -> np.ndarray:
    r"""The turn about the vertical in R reference^T: of its quaternion the part (w, up), hence
    2 atan2(q_up, q_w), without jumps. Turning R about the vertical by a adds exactly a.

    R : (T, 3, 3), reference : (3, 3), up : "y" or "z"  ->  (T,) radians

    >>> heading(rotation.axis_rotation("Y", [0.0, 3.0, 6.0]), np.eye(3), "y").round(6)
    array([0., 3., 6.])
    """
    q = rotation.matrix_to_quaternion(R @ reference.T)
    return np.unwrap(2 * np.arctan2(q[..., 1 + "xyz".index(up)], q[..., 0]))


def fragment_of(clip: Clip, body: Body, name: str, content: str | None = None,
                style: np.ndarray | None = None, *, start: int = 0, end: int | None = None,
                fps: float = POSE_FPS) -> Fragment:
    """A stretch of a clip as a fragment at a frame rate, 30 a second unless told, its path scaled
    to the body's size.

    content, style : its labels, where they are known
    start, end : frames of the clip, from 0, the end not included   ->  Fragment
    Raises PoseError for another skeleton than the body's, or a stretch of fewer than two frames.
    """
    check_skeleton(clip, body, name)
    end = clip.frames if end is None else end
    if not 0 <= start < end - 1 <= clip.frames - 1:
        raise PoseError(f"{name}: found frames {start} to {end}, needed at least two within 0 to "
                        f"{clip.frames}")
    clip = replace(clip, values=clip.values[start:end])
    local, translations = resample(*local_pose(clip), clip.fps, fps)
    if len(local) < 2:
        raise PoseError(f"{name}: found {len(local)} frame at {fps:g} frames/s, needed at least "
                        "two; is the stretch too short?")
    world, positions = forward_kinematics(body.parents, local, translations)
    R = world[:, body.carrier]
    turn = heading(R, body.reference[body.carrier], body.up)
    local[:, body.above] = np.eye(3)
    local[:, body.carrier] = rotation.axis_rotation(body.up.upper(), -turn) @ R
    scale = size_ratio(body, replace(body, bones=translations[0]))
    root = np.concatenate([scale * positions[:, body.carrier], turn[:, None]], axis=1)
    return Fragment(name, content, style, exponential_maps(local, body.reference), root, float(fps))


def size_ratio(body: Body, other: Body) -> float:
    """How much larger a body is than another, see `motion.body.relative_size`."""
    return relative_size(body.size, other.size)


def check_skeleton(clip: Clip, body: Body, name: str) -> None:
    """Raise PoseError unless a clip has the body's joints.   name : the clip's, for the message"""
    if odd := _odd_names(clip, body.joints):
        raise PoseError(f"{name}: found a skeleton that differs from the database's ({odd}), "
                        "needed the same joints; give a database on this clip's skeleton")


def local_transforms(angles: np.ndarray, root: np.ndarray,
                     body: Body) -> tuple[np.ndarray, np.ndarray]:
    """The pose of a fragment, the inverse of `fragment_of`: joints above the carrier stand still,
    the carrier has their motion.

    angles : (T, 3 J), root : (T, 4)
    ->  rotations (T, J, 3, 3), translations (T, J, 3) as `motion.skeleton` has them
    """
    rotations = rotation_matrices(angles, body.reference)
    turn = rotation.axis_rotation(body.up.upper(), root[:, HEADING])
    rotations[:, body.carrier] = turn @ rotations[:, body.carrier]
    translations = np.broadcast_to(body.bones, (len(angles),) + body.bones.shape).copy()
    origin = sum((body.bones[j] for j in body.above), np.zeros(3))
    translations[:, body.carrier] = root[:, POSITION] - origin
    return rotations, translations


def fragment_positions(fragment: Fragment, body: Body) -> np.ndarray:
    """Where the joints are in the world.   ->  (T, J, 3) in the file's unit"""
    pose = local_transforms(fragment.angles, fragment.root, body)
    return forward_kinematics(body.parents, *pose)[1]


def clip_of(fragment: Fragment, body: Body, fps: float | None = None) -> Clip:
    """A fragment as a BVH clip, at another frame rate if one is given."""
    fps = fragment.fps if fps is None else fps
    pose = resample(*local_transforms(fragment.angles, fragment.root, body), fragment.fps, fps)
    rest = Clip(body.joints, 1.0 / fps, np.zeros((1, 0)))
    return with_pose(rest, *pose, 1.0 / fps)
