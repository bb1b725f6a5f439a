"""Which joint of a file feeds each of the 21 slots: by names, by the tree, by the way it moves.

A slot means the same on all skeletons, whatever its joint is called: the chest is where the arms
branch. Names (`names`) and tree (`tree`) read a skeleton each by itself. What only one of them
knows is taken from it; where they contradict each other neither is believed, and both readings are
told. A slot without a joint that can be made up from its neighbours (a finger, a toe, a second
neck) is made up, in a joint's own frame, so that no rest pose matters.
"""

from dataclasses import replace

import numpy as np

from . import names, tree as by_tree
from .clip import Clip
from .joints import BONES, JOINTS, PARENTS, SLOT, SLOTS, Mapping, MappingError
from .skeleton import ancestors, forward_kinematics, local_pose
from .tree import Tree, Unclear

LOOKED_AT = 48                      # of a clip that are looked at
FINGER, TOE, HEAD = 0.175, 0.17, 0.15    # made up: of a forearm; of a leg; of a leg
TOE_DROP = 0.09                  # of a leg: how much lower than the ankle a made-up toe lies
BETWEEN = {"Spine": 0.45, "Neck": 0.55}  # made up: so far from the joint below to the one above
LIMB_SLOTS = {"Leg": ("UpLeg", "Leg", "Foot", "Toe"), "Arm": ("Arm", "ForeArm", "Hand", "Finger")}
TIPS = {side + tip: side + base for side in ("Left", "Right")
        for tip, base in (("Toe", "Foot"), ("Finger", "Hand"))}
LIKE = 1.35                      # how much longer a bone may be than the other side's
MIRRORED = 0.5                   # how surely the sides must be exchanged to contradict their names


def map_clip(clip: Clip, overrides: dict[str, str] | None = None,
             name: str = "the clip") -> Mapping:
    """Find the 21 slots among a clip's joints.

    overrides : {slot: joint name} as `joints.read_mapping` gives it;  name : the clip's, for
    messages   ->  Mapping
    Raises MappingError that tells both readings.

    >>> from refimpl.embedded.walkers import make_clip
    >>> mapping = map_clip(make_clip(seconds=0.5).clip)
    >>> mapping.joints[:4], set(mapping.how)
    (array([0, 1, 2, 3]), {'name'})
    """
    overrides, every = overrides or {}, {joint.name: j for j, joint in enumerate(clip.joints)}
    for slot, joint in overrides.items():
        if joint not in every:
            raise MappingError(f"mapping: found joint {joint!r} for slot {slot}, needed one of "
                               f"{', '.join(every)}")
    rotations, positions = _sampled(clip)
    tree = _tree(clip, rotations, positions)
    named = _named(clip, tree)
    try:
        read, unclear = by_tree.read_tree(tree), ""
    except Unclear as why:
        read, unclear = {}, str(why)
    found = {slot: (every[joint], "mapping") for slot, joint in overrides.items()}
    for slot, other in {**TIPS, "Spine": "Chest", "Neck": "Head"}.items():
        taken = every.get(overrides.get(other, ""), named.get(other, read.get(other)))
        if slot in found and found[slot][0] == taken:
            del found[slot]                          # one joint for two slots is none for this one
    for reading, how in ((named, "name"), (read, "tree")):
        for slot, j in reading.items():
            if j not in {k for k, _ in found.values()}:
                found.setdefault(slot, (j, how))
    mapping = _complete(clip, {s: j for s, (j, _) in found.items()},
                        {s: how for s, (_, how) in found.items()}, tree, rotations)
    faults = (_lacking(mapping) or _contradictions(clip, tree, named, read, overrides)
              or _misplaced(clip, tree, mapping, overrides))
    if faults:
        raise MappingError(f"{name}: {'; '.join(faults)}. {_told(clip, named, read, unclear)}; "
                           "give a mapping file with lines slot,joint (inspect --write-mapping "
                           "begins one)",
                           {slot: clip.names[j] for slot, j, told in zip(SLOTS, *mapping[::2])
                            if j >= 0 and "made" not in told})
    return Mapping(*mapping)


def _sampled(clip):
    """World rotations and positions in some frames."""
    rows = np.unique(np.linspace(0, clip.frames - 1, min(LOOKED_AT, clip.frames)).astype(int))
    with np.errstate(over="ignore", invalid="ignore"):
        return forward_kinematics(clip.parents,
                                  *local_pose(replace(clip, values=clip.values[rows])))


def _tree(clip, rotations, positions):
    ends = {j: positions[:, j] + rotations[:, j] @ np.array(joint.end_site)
            for j, joint in enumerate(clip.joints) if np.any(joint.end_site or 0)}
    return Tree(clip.parents.tolist(), positions, ends)


def _named(clip, tree):
    """The reading by names: limbs by their words, the trunk by where limbs branch.   ->  {slot: j}
    """
    words, depth = names.words_of(clip.names), names.depths(clip.parents)
    found = {}
    for limb, slots in LIMB_SLOTS.items():
        for (side, place), j in names.limb_joints(words, depth, limb).items():
            if place > 0:
                found[side + slots[place - 1]] = j
    for tip, base in TIPS.items():                   # a tip in the place of its base is none
        if tip in found and base in found and tree.apart(found[tip], found[base]) <= 1e-3 * sum(
                map(tree.bone, tree.above(found[base])[:2])):
            del found[tip]
    tops = [found.get(slot, -1) for slot in ("LeftUpLeg", "RightUpLeg", "LeftArm", "RightArm")]
    heads = names.trunk_joints(words, "Head")
    if min(tops) < 0 or not heads:
        return found
    head = min(heads, key=lambda j: depth[j])
    crotch, branch = tree.meet(tops), tree.meet(tops[2:])
    if crotch < 0 or branch < 0 or branch not in tree.above(head):
        return found
    called = [j for j in names.trunk_joints(words, "Hips") if j in tree.above(crotch)]
    hips = crotch if words[crotch][1] in ("hip", "hips", "pelvis") or not called else called[-1]
    feet = [found.get("LeftFoot", tops[0]), found.get("RightFoot", tops[1])]
    up = by_tree.upward(tree, head, feet)
    kind = names.TRUNK.get(words[branch][1], "")
    size = sum(tree.bone(j) for j in tree.way(hips, head))
    if hips != branch and size > 0:
        found |= by_tree.trunk(tree, hips, branch, head, tops[2:], up,
                               at_neck=kind == "Neck" if kind else None)
        found["Head"] = head
    return found


def _complete(clip, found, how, tree, rotations):
    """Make up what can be made up.   ->  joints (21,), -1 where none, tips (21, 3), how (21,)"""
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
        if not _has(slot) and base in tree.ends and np.linalg.norm(
                clip.joints[base].end_site) > 0.01 * leg:
            joints[SLOT[slot]], tips[SLOT[slot]] = base, clip.joints[base].end_site
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
    up = by_tree.upward(tree, joints[SLOT["Head"]], [found[foot]])
    across = P[:, found["LeftUpLeg"]] - P[:, found["RightUpLeg"]]
    forward = np.cross(across, up)
    forward /= np.maximum(np.linalg.norm(forward, axis=-1, keepdims=True), 1e-12)
    height = P[:, found[foot]] @ up
    low = height <= np.quantile(height, 0.3)
    level = np.sqrt(TOE ** 2 - TOE_DROP ** 2) * leg
    return low[:, None] * (level * forward - TOE_DROP * leg * up)


def _lacking(mapping):
    missing = [slot for slot, j in zip(SLOTS, mapping[0]) if j < 0]
    return [f"found no joint for {', '.join(missing)}, needed all 21 slots"] if missing else []


def _contradictions(clip, tree, named, read, overrides):
    """Where names and tree say what cannot both be.   ->  list of str"""
    said, words, head = [], names.words_of(clip.names), named.get("Head", read.get("Head", -1))
    lower = {j for part in ("Hips", "Spine", "Neck") for j in names.trunk_joints(words, part)}
    if "Head" not in overrides and (below := [j for j in sorted(lower)
                                              if head in tree.above(j)[1:]]):
        said.append(f"found {clip.names[below[0]]} above {clip.names[head]}, which feeds Head, "
                    "needed it below")
    for side in ("Left", "Right"):
        for parts in (("UpLeg", "Leg", "Foot"), ("Arm", "ForeArm", "Hand")):
            slots = [side + part for part in parts]
            if set(slots) & set(overrides) or not all(s in named and s in read for s in slots):
                continue
            ours, theirs = ([r[s] for s in slots] for r in (named, read))
            bones = [[tree.apart(a, b) for a, b in zip(r, r[1:])] for r in (ours, theirs)]
            line = set(tree.above(theirs[2])) | {j for j in range(len(clip.joints))
                                                 if theirs[0] in tree.above(j)}
            if not set(ours) <= line or min(bones[0]) < 0.5 * min(bones[1]):
                said.append(f"found {', '.join(clip.names[j] for j in ours)} by names for "
                            f"{', '.join(slots)} but {', '.join(clip.names[j] for j in theirs)} "
                            "by the tree")
    return said


def _misplaced(clip, tree, mapping, overrides):
    """What cannot be a body.   ->  list of str"""
    joints, tips, _ = mapping
    said, own = [], ~tips.any(axis=1)
    for parent, child in BONES:
        above = ancestors(clip.joints, joints[child])
        if joints[parent] not in (above[1:] if own[child] and own[parent] else above):
            said.append(f"found {clip.names[joints[child]]} for {SLOTS[child]}, needed a joint "
                        f"below {clip.names[joints[parent]]}, which feeds {SLOTS[parent]}")
        between = set(above[1:above.index(joints[parent])] if joints[parent] in above else [])
        allowed = {"Hips": ["Spine"], "Chest": ["Neck"]}.get(SLOTS[parent], [])
        between &= {int(joints[s]) for s in range(JOINTS) if own[s] and SLOTS[s] not in allowed}
        if between and own[child]:
            said.append(f"found {clip.names[between.pop()]} between {SLOTS[parent]} and "
                        f"{SLOTS[child]}, needed no joint of another limb there")
    twice = {int(j) for j in joints[own] if (joints[own] == j).sum() > 1}
    said += [f"found {clip.names[j]} for two slots, needed one joint each" for j in sorted(twice)]
    if said or set(overrides) >= set(SLOTS):
        return said
    for slot in ("UpLeg", "Leg", "Foot", "Toe", "Arm", "ForeArm", "Hand", "Finger"):
        pair = [SLOT["Left" + slot], SLOT["Right" + slot]]
        if {SLOTS[s] for s in pair} & set(overrides):
            continue
        if own[pair[0]] != own[pair[1]]:
            said.append(f"found a joint for only one of Left{slot} and Right{slot}, needed both or "
                        "neither")
        elif own[pair[0]]:
            sizes = [tree.apart(joints[PARENTS[s]], joints[s]) for s in pair]
            ways = [len(tree.way(joints[0], joints[s])) for s in pair]
            if max(sizes) > LIKE * min(sizes) or ways[0] != ways[1]:
                said.append(f"found bones to Left{slot} and Right{slot} of {sizes[0]:.3g} and "
                            f"{sizes[1]:.3g}, {ways[0]} and {ways[1]} joints below the hips, "
                            "needed two that are alike")
    if not said and not set(overrides) & {"LeftUpLeg", "LeftArm"}:
        said = _mirrored(clip, tree, joints, own)
    return said


def _mirrored(clip, tree, joints, own):
    legs = [[joints[SLOT[side + part]] for part in ("UpLeg", "Leg", "Foot")]
            for side in ("Left", "Right")]
    toes = [tree.positions[:, joints[SLOT[side + "Toe"]]] if own[SLOT[side + "Toe"]]
            else tree.ends.get(joints[SLOT[side + "Foot"]]) for side in ("Left", "Right")]
    up = by_tree.upward(tree, joints[SLOT["Head"]], [leg[2] for leg in legs])
    sure = by_tree.leftness(tree, legs, toes, up)
    lines = [tree.positions[:, joints[SLOT[f"Left{part}"]]]
             - tree.positions[:, joints[SLOT[f"Right{part}"]]] for part in ("UpLeg", "Arm")]
    together = np.mean(np.sum(lines[0] * lines[1], axis=-1)) / (
        np.mean([np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1)
                 for a, b in [lines]]) + 1e-300)
    if sure < -MIRRORED:
        return [f"found {clip.names[legs[0][0]]} on the right by where toes and knees point, "
                "needed the left leg there"]
    if together < -MIRRORED:
        return ["found the left arm on the side of the right leg, needed both left"]
    return []


def _told(clip, named, read, unclear):
    """Both readings, where they differ."""
    def _say(reading, slots):
        return ", ".join(f"{s} = {clip.names[reading[s]]}" for s in slots) or "nothing"
    lack = [s for s in SLOTS if s not in named]
    differ = [s for s in SLOTS if s in named and s in read and named[s] != read[s]]
    by_names = f"By names: {_say(named, differ) if differ else f'{len(named)} slots'}"
    if lack:
        by_names += f", nothing for {', '.join(lack)}"
    tree_says = unclear or _say(read, [s for s in SLOTS if s in differ or (
        s in lack and s in read)] if differ or lack else list(read)[:3])
    return f"{by_names}. By the tree: {tree_says}"
