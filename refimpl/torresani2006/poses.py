r"""Poses as exponential maps, for any skeleton: joint angles that can be subtracted, averaged and
compared.

A joint's rotation is written as the rotation vector that leads to it from a reference pose. The
reference is the mean pose of the database: a file's own zero need not be near any pose (some have
thighs a half turn away from it, where the vector jumps to its opposite).

The root's motion (where the body is and which way it faces) is kept apart from the angles, so that
the same action done elsewhere is the same.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from ..motion import rotation
from ..motion.bvh import POSITION_CHANNELS, Clip
from ..motion.skeleton import forward_kinematics, local_pose, resample, with_pose

FPS = 30.0
POSITION, HEADING = slice(0, 3), 3                           # the columns of a root (T, 4)


class PoseError(ValueError):
    """Clips that do not share a skeleton, or frames that are not there."""


@dataclass(frozen=True)
class Body:
    """The skeleton that all fragments of a database share.

    joints : tuple of bvh.Joint;  carrier : the joint that carries the body through the world,
    usually the hips;  bones : (J, 3) local translations;  reference : (J, 3, 3) the pose where all
    angles are 0;  up : "y" or "z".
    """

    joints: tuple
    carrier: int
    bones: np.ndarray = field(repr=False)
    reference: np.ndarray = field(repr=False)
    up: str

    @property
    def parents(self):
        return np.array([joint.parent for joint in self.joints])

    @property
    def floor(self):
        """The two horizontal columns of a position."""
        return [0, 2] if self.up == "y" else [0, 1]

    @property
    def size(self):
        """The sum of all bones below the carrier, to compare bodies by."""
        above = [self.carrier, *_ancestors(self.joints, self.carrier)]
        return float(np.delete(np.linalg.norm(self.bones, axis=1), above).sum())


@dataclass(frozen=True)
class Fragment:
    """One action of one performer.

    content : its label or None;  style : (3,) flow, weight, time, or None;  angles : (T, 3 J)
    radians, joint after joint;
    root : (T, 4) position in the file's unit and heading in radians;  fps : frames a second.
    """

    name: str
    content: str
    style: np.ndarray
    angles: np.ndarray = field(repr=False)
    root: np.ndarray = field(repr=False)
    fps: float = FPS

    @property
    def frames(self):
        return len(self.angles)


def exponential_maps(rotations, reference):
    r"""Rotation vectors seen from a reference, continuous over time:   v = log(reference^T R)

    rotations : (T, J, 3, 3), reference : (J, 3, 3)  ->  (T, 3 J) radians.
    `rotation_matrices` is the exact inverse. A joint that turns through more than half a turn gets
    vectors longer than pi rather than a jump.
    """
    shortest = rotation.log_map(reference.swapaxes(-1, -2) @ rotations)
    smooth = _continuous(shortest, shortest[0])
    other = _continuous(shortest, shortest[0] - 2 * np.pi * _direction(shortest[0], shortest[0]))
    nearer = np.linalg.norm(
        other, axis=-1).mean(axis=0) < np.linalg.norm(smooth, axis=-1).mean(axis=0) - 1e-9
    return np.where(nearer[:, None], other, smooth).reshape(len(rotations), -1)


def rotation_matrices(angles, reference):
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


def fit_body(clips):
    """The common skeleton of some clips, and their mean pose as the reference.

    clips : bvh.Clip, at least one   ->  Body.   Raises PoseError when names or parents differ.
    """
    clips = list(clips)
    if not clips:
        raise PoseError("clips: found none, needed at least one to know the skeleton from")
    first = clips[0]
    for number, clip in enumerate(clips):
        if clip.names != first.names or not np.array_equal(clip.parents, first.parents):
            odd = sorted(set(clip.names) ^ set(first.names))[:4] or [
                "the same names in another order"]
            raise PoseError(
                f"clip {number}: found a skeleton that differs from clip 0's ({', '.join(odd)}), "
                "needed the same joints in "
                "all clips of a database; keep one skeleton to a folder")
    carrier = _carrier(first.joints)
    worlds = [_world(clip, carrier) for clip in clips]
    bones = np.median([translations[0] for _, translations, _, _ in worlds], axis=0)
    above = _ancestors(first.joints, carrier)
    for j in above:
        bones[j] = first.joints[j].offset
    reference = np.stack([
        _mean_rotation(sum(rotations[:, j].mean(axis=0) for rotations, _, _, _ in worlds))
        for j in range(len(first.joints))])
    reference[above] = np.eye(3)
    up = _up_axis(worlds)
    start = worlds[0][2][0]
    reference[carrier] = _mean_rotation(
        sum((rotation.axis_rotation(up.upper(), -heading(R, start, up)) @ R).mean(axis=0)
            for _, _, R, _ in worlds))
    return Body(first.joints, carrier, bones, reference, up)


def _carrier(joints):
    """Down the chain from the root as long as it does not branch: the last joint that can be moved
    freely, else the root.
    """
    chain = [0]
    children = [[j for j, joint in enumerate(joints) if joint.parent == parent]
                for parent in range(len(joints))]
    while len(children[chain[-1]]) == 1:
        chain.append(children[chain[-1]][0])
    free = [j for j in chain if set(POSITION_CHANNELS) <= set(joints[j].channels)]
    return free[-1] if free else 0


def _ancestors(joints, j):
    above = []
    while joints[j].parent >= 0:
        j = joints[j].parent
        above.append(j)
    return above


def _world(clip, carrier):
    """->  local rotations, local translations, the carrier's rotation (T, 3, 3) in the world and
    all positions (T, J, 3) there
    """
    rotations, translations = local_pose(clip)
    R, p = forward_kinematics(clip.parents, rotations, translations)
    return rotations, translations, R[:, carrier], p


def _up_axis(worlds):
    """A body is taller than deep: "y" or "z", whichever its joints spread along more."""
    spread = np.mean([np.ptp(p, axis=1).mean(axis=0) for _, _, _, p in worlds], axis=0)
    return "z" if spread[2] > spread[1] else "y"


def _mean_rotation(M):
    r"""The rotation nearest to a mean of matrices: `U diag(1, 1, det(U V^T)) V^T` for M = U S V^T.
    (3, 3)  ->  (3, 3)
    """
    U, _, Vt = np.linalg.svd(M)
    U[:, 2] *= np.sign(np.linalg.det(U @ Vt))
    return U @ Vt


def heading(R, reference, up):
    r"""The turn about the vertical in R reference^T: of its quaternion the part (w, up), hence 2
    atan2(q_up, q_w), without jumps.

    R : (T, 3, 3), reference : (3, 3)  ->  (T,) radians. Turning R about the vertical by a adds
    exactly a.
    """
    q = rotation.matrix_to_quaternion(R @ reference.T)
    return np.unwrap(2 * np.arctan2(q[..., 1 + "xyz".index(up)], q[..., 0]))


def fragment_of(clip, body, name, content=None, style=None, *, start=0, end=None, fps=FPS):
    """A stretch of a clip as a fragment at a frame rate, 30 a second unless told, its path scaled
    to the body's size.

    start, end : frames of the clip, from 0, the end not included.   ->  Fragment
    Raises PoseError for another skeleton than the body's, or a stretch of fewer than two frames.
    """
    check_skeleton(clip, body, name)
    end = clip.frames if end is None else end
    if not 0 <= start < end - 1 <= clip.frames - 1:
        raise PoseError(
            f"{name}: found frames {start} to {end}, needed at least two within 0 to {clip.frames}")
    clip = replace(clip, values=clip.values[start:end])
    rotations, translations = resample(*local_pose(clip), clip.fps, fps)
    if len(rotations) < 2:
        raise PoseError(
            f"{name}: found {len(rotations)} frame at {fps:g} frames/s, needed at least two; is "
            "the stretch too short?")
    world, positions = forward_kinematics(body.parents, rotations, translations)
    R = world[:, body.carrier]
    turn = heading(R, body.reference[body.carrier], body.up)
    local = rotations.copy()
    local[:, _ancestors(body.joints, body.carrier)] = np.eye(3)
    local[:, body.carrier] = rotation.axis_rotation(body.up.upper(), -turn) @ R
    scale = size_ratio(body, replace(body, bones=translations[0]))
    root = np.concatenate([scale * positions[:, body.carrier], turn[:, None]], axis=1)
    return Fragment(name, content, style, exponential_maps(local, body.reference), root, float(fps))


def size_ratio(body, other):
    """How much larger a body is than another; 1 within 0.1 %, the noise of a capture, and for
    bodies without bones.
    """
    ratio = body.size / other.size if other.size > 0 else 1.0
    return 1.0 if abs(ratio - 1) < 1e-3 else ratio


def check_skeleton(clip, body, name):
    """Raise PoseError unless a clip has the body's joints."""
    names = tuple(joint.name for joint in body.joints)
    if clip.names != names or not np.array_equal(clip.parents, body.parents):
        odd = ", ".join(
            sorted(set(names) ^ set(clip.names))[:4]) or "the same names in another order"
        raise PoseError(
            f"{name}: found a skeleton that differs from the database's ({odd}), needed the same "
            "joints; "
            "give a database on this clip's skeleton")


def local_transforms(angles, root, body):
    """The pose of a fragment, the inverse of `fragment_of`: joints above the carrier stand still,
    the carrier has their motion.

    angles : (T, 3 J), root : (T, 4)  ->  rotations (T, J, 3, 3), translations (T, J, 3) as
    `motion.skeleton` has them
    """
    rotations = rotation_matrices(angles, body.reference)
    rotations[:, body.carrier] = rotation.axis_rotation(
        body.up.upper(), root[:, HEADING]) @ rotations[:, body.carrier]
    translations = np.broadcast_to(body.bones, (len(angles),) + body.bones.shape).copy()
    above = sum((body.bones[j] for j in _ancestors(body.joints, body.carrier)), np.zeros(3))
    translations[:, body.carrier] = root[:, POSITION] - above
    return rotations, translations


def joint_positions(fragment, body):
    """Where the joints are in the world.   Fragment  ->  (T, J, 3) in the file's unit"""
    return forward_kinematics(body.parents, *local_transforms(fragment.angles, fragment.root,
                                                              body))[1]


def clip_of(fragment, body, fps=None):
    """A fragment as a BVH clip, at another frame rate if one is given.   ->  bvh.Clip"""
    fps = fragment.fps if fps is None else fps
    rotations, translations = resample(*local_transforms(fragment.angles, fragment.root, body),
                                       fragment.fps, fps)
    rest = Clip(body.joints, 1.0 / fps, np.zeros((1, 0)))
    return with_pose(rest, rotations, translations, 1.0 / fps)
