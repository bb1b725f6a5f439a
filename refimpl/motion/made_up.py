"""Slots that a skeleton has no joint for, made up from their neighbours as a point in a joint's own
frame: where the limb itself points while it moves, so that no rest pose and no OFFSET matters.
"""

from collections.abc import Mapping

import numpy as np

from .clip import Clip
from .joints import JOINTS, SLOT, SLOTS
from .sides import upward
from .tree import Tree

FINGER, TOE, HEAD = 0.175, 0.17, 0.15    # made up: of a forearm; of a leg; of a leg
TOE_DROP = 0.09                  # of a leg: how much lower than the ankle a made-up toe lies
BETWEEN = {"Spine": 0.45, "Neck": 0.55}  # made up: so far from the joint below to the one above


def with_made_up(clip: Clip, found: Mapping[str, int], how: Mapping[str, str], tree: Tree,
                 rotations: np.ndarray) -> tuple[np.ndarray, np.ndarray, tuple[str, ...]]:
    """Make up what can be made up.

    found : {slot: joint};  how : {slot: how it was found};  rotations (T, J, 3, 3) of the joints in
    the tree's frames
    ->  joints (21,), -1 where there is none, tips (21, 3), how (21,)
    """
    joints = np.array([found.get(slot, -1) for slot in SLOTS])
    tips, told = np.zeros((JOINTS, 3)), [how.get(slot, "") for slot in SLOTS]
    P, leg = tree.positions, 0.0
    if (joints[[SLOT[s] for s in ("LeftUpLeg", "LeftLeg", "LeftFoot")]] >= 0).all():
        hip, knee, ankle = (found[f"Left{part}"] for part in ("UpLeg", "Leg", "Foot"))
        leg = tree.apart(hip, knee) + tree.apart(knee, ankle)

    def _put(slot, base, vectors, why, length=None):
        """A point in the base joint's frame, the mean over the frames of where it should be."""
        local = np.mean((rotations[:, base].swapaxes(1, 2) @ vectors[..., None])[..., 0], axis=0)
        size = np.linalg.norm(local)
        if size > 1e-9 * max(leg, 1e-300):
            tips[SLOT[slot]] = local if length is None else local * (length / size)
            joints[SLOT[slot]], told[SLOT[slot]] = base, why

    def _has(*slots):
        return all(joints[SLOT[slot]] >= 0 for slot in slots)

    def _end(slot, base_slot, why):
        base = found.get(base_slot, -1)
        end = np.array(clip.joints[base].end_site or (0.0, 0.0, 0.0))
        if not _has(slot) and base >= 0 and np.linalg.norm(end) > 0.01 * leg:
            joints[SLOT[slot]], tips[SLOT[slot]] = base, end
            told[SLOT[slot]] = why
    for slot, low, high in (("Spine", "Hips", "Chest"), ("Neck", "Chest", "Head")):
        if not _has(slot) and _has(low, high):
            base = found[low]
            _put(slot, base, BETWEEN[slot] * (P[:, found[high]] - P[:, base]),
                 f"made up between {low} and {high}")
    _end("Head", "Neck", "made up: the End Site of the neck")
    if not _has("Head") and _has("Neck", "Chest"):
        base = found["Neck"]
        _put("Head", base, P[:, base] - P[:, found["Chest"]], "made up beyond the neck", HEAD * leg)
    for side in ("Left", "Right"):
        hand, foot, elbow = side + "Hand", side + "Foot", side + "ForeArm"
        _end(hand, elbow, "made up: the End Site of the forearm")
        _end(side + "Finger", hand, "made up: the End Site of the hand")
        _end(side + "Toe", foot, "made up: the End Site of the foot")
        if not _has(side + "Finger") and _has(elbow) and hand in found:
            _put(side + "Finger", found[hand], P[:, found[hand]] - P[:, found[elbow]],
                 "made up beyond the hand", FINGER * tree.apart(found[elbow], found[hand]))
        if not _has(side + "Toe") and _has("LeftUpLeg", "RightUpLeg", "Head") and foot in found:
            _put(side + "Toe", found[foot], _toe_directions(tree, found, joints, foot, leg),
                 "made up before the foot", TOE * leg)
        base = found.get(elbow, -1)
        if not _has(side + "Finger") and _has(hand) and base >= 0:
            end = tips[SLOT[hand]]
            joints[SLOT[side + "Finger"]], tips[SLOT[side + "Finger"]] = base, (1 + FINGER) * end
            told[SLOT[side + "Finger"]] = "made up beyond the hand"
    return joints, tips, tuple(told)


def _toe_directions(tree, found, joints, foot, leg):
    """From an ankle forwards and down a little, where it stands lowest; 0 elsewhere.   (T, 3)"""
    P = tree.positions
    up = upward(tree, joints[SLOT["Head"]], [found[foot]])
    across = P[:, found["LeftUpLeg"]] - P[:, found["RightUpLeg"]]
    forward = np.cross(across, up)
    forward /= np.maximum(np.linalg.norm(forward, axis=-1, keepdims=True), 1e-12)
    height = P[:, found[foot]] @ up
    low = height <= np.quantile(height, 0.3)
    level = np.sqrt(TOE ** 2 - TOE_DROP ** 2) * leg
    return low[:, None] * (level * forward - TOE_DROP * leg * up)
