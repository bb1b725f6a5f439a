r"""The canonical body, there and back: what lets networks that know one skeleton move any other.

There, bone by bone: the clip's directions, the canonical body's lengths. Pelvis and chest are rigid
(hips, both hip joints, base of the spine; where the arms branch, both shoulders, neck): they turn
as the clip's do and carry the canonical offsets. The foot keeps a constant angle to the clip's, so
that a planted foot lies flat on both bodies. The way is scaled by the legs, and the body set so
that what is planted moves as it does in the clip.

Back, not the points come back but the change: for each slot the rotation D that leads from the
bone of the content to that of the result,

    D_pelvis = R(result) R(content)^T,   D_chest alike,
    D_bone = shortest_rotation(D_above a, b) D_above,    a, b the bone in content and result

and the clip's own joint turns by D from where it was. Nothing changes where nothing was changed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
import functools
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d

from .features import FLOOR, bone_lengths, leg_length
from .ground import resting_heights
from .joints import BONES, FEET, HEELS, JOINTS, LEGS, PARENTS, SLOT, SLOTS, TOES
from .names import depths
from .rotation import exp_map, shortest_rotation

PELVIS = [SLOT[name] for name in ("LeftUpLeg", "RightUpLeg", "Spine")]   # carried by the hips
CHEST = [SLOT[name] for name in ("LeftArm", "RightArm", "Neck")]         # ... by the chest
# The slot at the end of each slot's bone, and the slots by depth but hips and chest, which are
# frames.
_NEXT = {int(parent): slot for parent, slot in reversed(BONES)}
_LEVELS = [[s for s, depth in enumerate(depths(PARENTS)) if depth == level
            and s != SLOT["Chest"]] for level in range(1, max(depths(PARENTS)) + 1)]
FLAT = 5                         # frames with heel and toe planted that tell a foot's pitch
SET_SIGMA = 4.0                  # frames: how smoothly the body is set on its feet
# What `only` may name: slots whose own change is kept.
PARTS = {"hips": ("Hips",), "spine": ("Spine", "Chest"), "head": ("Neck", "Head"),
         "arms": tuple(s for s in SLOTS if "Arm" in s or "Hand" in s or "Finger" in s),
         "legs": tuple(s for s in SLOTS if "Leg" in s or "Foot" in s or "Toe" in s)}


@dataclass(frozen=True)
class Physique:
    """A body's proportions.

    rest : (21, 3) its points when it stands straight in a T-pose, y up, facing +z, toes at 0
    """

    rest: np.ndarray = field(repr=False)

    @functools.cached_property
    def leg(self) -> float:
        """The leg's length."""
        return leg_length(self.rest[None])

    @functools.cached_property
    def bones(self) -> np.ndarray:
        """Lengths in the order of `joints.BONES`.   ->  (20,)"""
        return bone_lengths(self.rest[None])

    @property
    def pitch(self) -> float:
        """How far a planted foot points down from ankle to toe, radians."""
        drop = self.rest[list(HEELS), 1] - self.rest[list(TOES), 1]
        foot = np.linalg.norm(self.rest[list(TOES)] - self.rest[list(HEELS)], axis=-1)
        return float(np.arcsin(np.clip(drop / foot, -1.0, 1.0)).mean())


def rigid_frames(positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How pelvis and chest stand: columns to the left, up and forward.

    positions : (T, 21, 3)  ->  two of (T, 3, 3)
    """
    hips, arms = (positions[:, a] - positions[:, b] for a, b in (PELVIS[:2], CHEST[:2]))
    middle = positions[:, PELVIS[:2]].mean(axis=1)
    return (_frame(hips, positions[:, SLOT["Spine"]] - middle),
            _frame(arms, positions[:, SLOT["Neck"]] - positions[:, SLOT["Chest"]]))


def _frame(x, y):
    z = np.cross(x, y)
    z = z / np.maximum(np.linalg.norm(z, axis=-1, keepdims=True), 1e-300)
    x = x / np.maximum(np.linalg.norm(x, axis=-1, keepdims=True), 1e-300)
    return np.stack([x, np.cross(z, x), z], axis=-1)


def measured(positions: np.ndarray, contacts: np.ndarray | None = None) -> Physique:
    """The body of a clip: medians over its frames, of its feet's pitch over those in which heel and
    toe are planted, or what the heights tell at which they rest.

    positions : (T, 21, 3), y up;  contacts : (T, 4)  ->  Physique
    """
    pelvis, chest = rigid_frames(positions)
    lengths, rests = bone_lengths(positions), resting_heights(positions)
    rest, by_child = np.zeros((JOINTS, 3)), dict(zip((c for _, c in BONES), lengths))
    along = np.zeros((JOINTS, 3))
    for slots, frame, base in ((PELVIS, pelvis, 0), (CHEST, chest, SLOT["Chest"])):
        offsets = (positions[:, slots] - positions[:, [base]]) @ frame
        along[slots] = np.median(offsets, axis=0)
    drop = np.clip((rests[[0, 2]] - rests[[1, 3]]) / lengths[[HEELS[0], HEELS[1]]], -0.99, 0.99)
    if contacts is not None:
        for n, (heel, toe) in enumerate(zip(HEELS, TOES)):
            flat = np.asarray(contacts[:, 2 * n] & contacts[:, 2 * n + 1], bool)
            if flat.sum() >= FLAT:
                bone = positions[flat, toe] - positions[flat, heel]
                drop[n] = -np.median(bone[:, 1] / np.linalg.norm(bone, axis=-1))
    for slot, name in enumerate(SLOTS):
        if slot in (0, *PELVIS, *CHEST):
            continue
        side = 1.0 if name.startswith("Left") else -1.0
        direction = (np.array([0.0, 1.0, 0.0]) if name in ("Chest", "Head") else
                     np.array([0.0, -1.0, 0.0]) if "Leg" in name or "Foot" in name else
                     np.array([side, 0.0, 0.0]))
        if slot in TOES:
            n = TOES.index(slot)
            direction = np.array([0.0, -drop[n], np.sqrt(1 - drop[n] ** 2)])
        along[slot] = by_child[slot] * direction
    for slot, parent in enumerate(PARENTS):
        rest[slot] = along[slot] + (rest[parent] if parent >= 0 else 0.0)
    rest[:, 1] -= rest[list(TOES), 1].mean()
    return Physique(rest)


def mean_body(bodies: Sequence[Physique], leg: float | None = None) -> Physique:
    """The median of several bodies, brought to one leg.

    leg : its length, the median of theirs unless given
    """
    leg = float(np.median([body.leg for body in bodies])) if leg is None else leg
    rest = np.median([body.rest * (leg / body.leg) for body in bodies], axis=0)
    return Physique(rest * (leg / leg_length(rest[None])))


def body_of_mean(mean: np.ndarray, bones: np.ndarray) -> Physique:
    """A body from the mean pose of the features it was measured on, where nothing better is known.

    mean : (63,) or more numbers of a normaliser;  bones : (20,)   ->  Physique
    """
    pose = mean[:3 * JOINTS].reshape(JOINTS, 3)
    stretched = np.zeros_like(pose)
    for (parent, slot), length in zip(BONES, bones):
        bone = pose[slot] - pose[parent]
        stretched[slot] = stretched[parent] + bone * (length / max(np.linalg.norm(bone), 1e-300))
    return measured(stretched[None])


def to_body(positions: np.ndarray, body: Physique, contacts: np.ndarray) -> np.ndarray:
    """The same motion on another body, its floor at height 0.

    positions : (T, 21, 3), y up;  contacts : (T, 4) of planted feet   ->  (T, 21, 3)
    """
    own = measured(positions, contacts)
    pelvis, chest = rigid_frames(positions)
    out, ratio = np.zeros_like(positions), body.leg / own.leg
    rests, rest = resting_heights(positions), body.rest
    tilt = body.pitch - own.pitch
    lengths = dict(zip((c for _, c in BONES), body.bones))
    for parent, slot in BONES:
        if slot in PELVIS or slot in CHEST:
            frame = pelvis if slot in PELVIS else chest
            bone = frame @ (rest[slot] - rest[parent])
        else:
            bone = positions[:, slot] - positions[:, parent]
            if slot in TOES:
                bone = _tilted(bone, pelvis[..., 0], tilt)
            bone = bone * (lengths[slot] / np.maximum(
                np.linalg.norm(bone, axis=-1, keepdims=True), 1e-300))
        out[:, slot] = out[:, parent] + bone
    floor = rests[[1, 3]].min()
    out += (ratio * (positions[:, [0]] - [0.0, floor, 0.0]))
    out += _set_down(out, positions, ratio, rests, rest, contacts)[:, None]
    return out


def _tilted(bones, left, angle):
    """Bones turned down by an angle about what of the left is square to them."""
    u = bones / np.maximum(np.linalg.norm(bones, axis=-1, keepdims=True), 1e-300)
    axis = left - np.sum(left * u, axis=-1, keepdims=True) * u
    size = np.linalg.norm(axis, axis=-1, keepdims=True)
    return (exp_map(angle * axis / np.maximum(size, 1e-300)) @ bones[..., None])[..., 0]


def _set_down(out, positions, ratio, rests, rest, contacts):
    """How the whole body moves so that what is planted stands as high above the floor, and moves as
    much, as it does in the clip.   ->  (T, 3)
    """
    feet = list(FEET)
    planted = np.asarray(contacts, bool)
    weight = planted.sum(axis=1)
    if not weight.any():
        return np.zeros((len(out), 3))
    high = out[:, feet, 1] - ratio * (positions[:, feet, 1] - rests) - rest[feet, 1]
    steps = np.diff(out[:, feet], axis=0) - ratio * np.diff(positions[:, feet], axis=0)
    moved = np.zeros((len(out), 3))
    for values, axes, at in ((high[..., None], [1], weight),
                             (steps[..., FLOOR["y"]], FLOOR["y"], weight[:-1])):
        known = np.flatnonzero(at)
        if not len(known):
            continue
        mean = (values * planted[:len(at), :, None]).sum(axis=1)[known] / at[known, None]
        for column, axis in enumerate(axes):
            curve = gaussian_filter1d(np.interp(np.arange(len(at)), known, mean[:, column]),
                                      SET_SIGMA, mode="nearest")
            moved[:, axis] = -curve if axis == 1 else -np.concatenate([[0.0], np.cumsum(curve)])
    return moved


@dataclass(frozen=True)
class Change:
    """What leads from one motion of a body to another.

    turns : (T, 21, 3, 3) of each slot, in the world;  shift : (T, 3) of the hips
    """

    turns: np.ndarray = field(repr=False)
    shift: np.ndarray = field(repr=False)

    def __len__(self) -> int:
        """How many frames it has."""
        return len(self.shift)

    def at(self, frames: Any) -> "Change":
        """Some of its frames.   frames : a slice or indices"""
        return Change(self.turns[frames], self.shift[frames])

    def then(self, other: "Change") -> "Change":
        """This change and then another one."""
        return Change(other.turns @ self.turns, self.shift + other.shift)


@dataclass(frozen=True)
class LongChange:
    """A `Change` whose frames are made when they are asked for: that of an hour would take three
    times the memory of the motion.

    at : as that of `Change`;  frames : how many there are
    """

    at: Callable[[Any], Change]
    frames: int

    def __len__(self) -> int:
        """How many frames it has."""
        return self.frames


def change(before: np.ndarray, after: np.ndarray) -> Change:
    """What leads from one motion to another of the same body.   two of (T, 21, 3)"""
    turns = np.empty((*before.shape[:2], 3, 3))
    for slot, (a, b) in zip((0, SLOT["Chest"]), zip(rigid_frames(before), rigid_frames(after))):
        turns[:, slot] = b @ a.swapaxes(1, 2)
    for level in _LEVELS:                            # slots of one depth together
        tips = [slot for slot in level if slot not in _NEXT]
        slots = [slot for slot in level if slot in _NEXT]
        turns[:, tips] = turns[:, PARENTS[tips]]
        if slots:
            above, ends = turns[:, PARENTS[slots]], [_NEXT[slot] for slot in slots]
            a, b = (p[:, ends] - p[:, slots] for p in (before, after))
            bone = (above @ a[..., None])[..., 0]
            turns[:, slots] = shortest_rotation(bone, b) @ above
    return Change(turns, after[:, 0] - before[:, 0])


def restricted(whole: Change, only: Sequence[str]) -> Change:
    """A change of some parts alone: each of their slots keeps its own turn, against that of the
    slot above it, and the others follow.

    only : some of `PARTS`
    """
    kept = {SLOT[name] for part in only for name in PARTS[part]}
    turns = np.empty_like(whole.turns)
    for slot, parent in enumerate(PARENTS):
        above = whole.turns[:, parent] if parent >= 0 else np.eye(3)
        new = turns[:, parent] if parent >= 0 else np.eye(3)
        own = np.swapaxes(above, -1, -2) @ whole.turns[:, slot]
        turns[:, slot] = new @ own if slot in kept else new
    return Change(turns, whole.shift if 0 in kept else 0 * whole.shift)


def applied(positions: np.ndarray, found: Change, carries: Sequence[int]) -> np.ndarray:
    """Points of a body after a change, every bone as long as it was.

    positions : (T, 21, 3);  carries : (21,) the slot with which the bone to each slot turns
    ->  (T, 21, 3)
    """
    out = np.empty_like(positions)
    out[:, 0] = positions[:, 0] + found.shift
    for parent, slot in BONES:
        bone = positions[:, slot] - positions[:, parent]
        out[:, slot] = out[:, parent] + (found.turns[:, carries[slot]] @ bone[..., None])[..., 0]
    return out


CARRIES = tuple(int(max(parent, 0)) for parent in PARENTS)   # of a body whose limbs hang as usual
assert len(LEGS) == 2
