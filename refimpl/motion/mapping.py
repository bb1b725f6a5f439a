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
from .made_up import with_made_up
from .sides import leftness, read_tree, upward
from .skeleton import ancestors, forward_kinematics, local_pose
from .tree import Tree, Unclear

LOOKED_AT = 48                      # of a clip that are looked at
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
    words = names.words_of(clip.names)
    named = _named(clip, tree, words)
    try:
        read, unclear = read_tree(tree), ""
    except Unclear as why:
        read, unclear = {}, str(why)
    found = {slot: (every[joint], "mapping") for slot, joint in overrides.items()}
    for slot, other in {**TIPS, "Spine": "Chest", "Neck": "Head"}.items():
        taken = every.get(overrides.get(other, ""), named.get(other, read.get(other)))
        if slot in found and found[slot][0] == taken:
            del found[slot]                          # one joint for two slots is none for this one
    for reading, how in ((named, "name"), (read, "tree")):
        for slot, j in reading.items():
            if how == "tree" and slot == "Head" and names.TRUNK.get(words[j][1]) == "Neck":
                continue                             # a body without a head
            if j not in {k for k, _ in found.values()}:
                found.setdefault(slot, (j, how))
    for tip, base in TIPS.items():                   # a finger without a name on one hand alone
        other = _other(tip)
        if tip in found and other not in found and found[tip][1] == "tree" and all(
                found.get(s, (0, ""))[1] == "name" for s in (base, _other(base))):
            del found[tip]
    mapping = with_made_up(clip, {s: j for s, (j, _) in found.items()},
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


def _other(slot):
    """The same slot on the other side."""
    return ("Right" + slot[4:]) if slot.startswith("Left") else ("Left" + slot[5:])


def _sampled(clip):
    """World rotations and positions in some frames."""
    rows = np.unique(np.linspace(0, clip.frames - 1, min(LOOKED_AT, clip.frames)).astype(int))
    with np.errstate(over="ignore", invalid="ignore"):
        return forward_kinematics(clip.parents,
                                  *local_pose(replace(clip, values=clip.values[rows])))


def _tree(clip, rotations, positions):
    ends = {j: positions[:, j] + rotations[:, j] @ np.array(joint.end_site)
            for j, joint in enumerate(clip.joints) if np.any(joint.end_site or 0)}
    local = np.stack([R if joint.parent < 0 else rotations[:, joint.parent].swapaxes(1, 2) @ R
                      for joint, R in zip(clip.joints, np.moveaxis(rotations, 1, 0))])
    still = frozenset(np.flatnonzero(np.ptp(local, axis=1).max(axis=(1, 2)) < 1e-6).tolist())
    return Tree(clip.parents.tolist(), positions, ends, still)


def _named(clip, tree, words):
    """The reading by names: limbs by their words, the trunk by where limbs branch.   ->  {slot: j}
    """
    depth, found = names.depths(clip.parents), {}
    for limb, slots in LIMB_SLOTS.items():
        for (side, place), j in names.limb_joints(words, depth, limb).items():
            if place > 0:
                found[side + slots[place - 1]] = j
    for tip, base in TIPS.items():                   # a tip in the place of its base is none
        if tip in found and base in found and tree.apart(found[tip], found[base]) <= 1e-3 * sum(
                map(tree.bone, tree.above(found[base])[:2])):
            del found[tip]
    tops = [found.get(slot, -1) for slot in ("LeftUpLeg", "RightUpLeg", "LeftArm", "RightArm")]
    heads, necks = (names.trunk_joints(words, part) for part in ("Head", "Neck"))
    if min(tops) < 0 or not (heads or necks):
        return found
    head = min(heads, key=lambda j: depth[j]) if heads else max(necks, key=lambda j: depth[j])
    crotch, branch = tree.meet(tops), tree.meet(tops[2:])
    if crotch < 0 or branch < 0 or branch not in tree.above(head):
        return found
    called = [j for j in names.trunk_joints(words, "Hips") if j in tree.above(crotch)]
    hips = crotch if words[crotch][1] in ("hip", "hips", "pelvis") or not called else called[-1]
    feet = [found.get("LeftFoot", tops[0]), found.get("RightFoot", tops[1])]
    up = upward(tree, head, feet)
    kind = names.TRUNK.get(words[branch][1], "")
    size = sum(tree.bone(j) for j in tree.way(hips, head))
    if hips != branch and size > 0:
        found |= by_tree.trunk(tree, hips, branch, head, tops[2:], up,
                               at_neck=kind == "Neck" if kind else None)
        found["Head"] = head
        if not heads:                                # the last neck is no head
            found["Neck"] = min(necks, key=lambda j: depth[j])
            del found["Head"]
    return found


def _lacking(mapping):
    missing = [slot for slot, j in zip(SLOTS, mapping[0]) if j < 0]
    return [f"found no joint for {', '.join(missing)}, needed all 21 slots"] if missing else []


def _contradictions(clip, tree, named, read, overrides):
    """Where names and tree say what cannot both be.   ->  list of str"""
    said, words = [], names.words_of(clip.names)
    places = {slot: named.get(slot, read.get(slot, -1)) for slot in ("Head", "Chest")}
    for parts, slot in ((("Hips", "Spine", "Neck"), "Head"), (("Hips",), "Chest")):
        for j in (j for part in parts for j in names.trunk_joints(words, part)):
            if slot not in overrides and places[slot] in tree.above(j)[slot == "Head":]:
                said.append(f"found {clip.names[j]} beyond {clip.names[places[slot]]}, which feeds "
                            f"{slot}, needed it before")
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
        if SLOTS[child] == "Spine" and clip.parents[joints[0]] in above[1:]:
            continue                                 # the upper body beside the lower one
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
            ways = [tree.above(joints[s]).index(tree.meet([joints[0], joints[s]])) for s in pair]
            if max(sizes) > LIKE * min(sizes) or ways[0] != ways[1] or not min(sizes) > 0:
                said.append(f"found bones to Left{slot} and Right{slot} of {sizes[0]:.3g} and "
                            f"{sizes[1]:.3g}, {ways[0]} and {ways[1]} joints below the hips, "
                            "needed two that are alike")
    if not said and not set(overrides) & {"LeftUpLeg", "LeftArm"}:
        said = _mirrored(clip, tree, joints, own) or _on_all_fours(tree, joints)
    return said


def _on_all_fours(tree, joints):
    """A trunk that lies level over hands as low as feet all the time is an animal's."""
    P = tree.positions
    hips, chest, feet, hands = (P[:, joints[[SLOT[s] for s in slots]]] for slots in (
        ["Hips"], ["Chest"], ["LeftFoot", "RightFoot"], ["LeftHand", "RightHand"]))
    down = hips[:, 0] - feet.mean(axis=1)
    axis = 2 if abs(down[:, 2].mean()) > abs(down[:, 1].mean()) else 1
    trunk = (chest - hips)[:, 0]
    level = np.abs(trunk[:, axis]) < 0.6 * np.linalg.norm(trunk, axis=-1)
    low = np.abs(hands[..., axis].mean(axis=1) - feet[..., axis].mean(axis=1)) < 0.35 * np.abs(
        down[:, axis])
    return ["found a trunk that lies level and hands as low as the feet, needed a body on two legs"
            ] if (level & low).mean() > 0.9 else []


def _mirrored(clip, tree, joints, own):
    legs = [[joints[SLOT[side + part]] for part in ("UpLeg", "Leg", "Foot")]
            for side in ("Left", "Right")]
    toes = [tree.positions[:, joints[SLOT[side + "Toe"]]] if own[SLOT[side + "Toe"]]
            else tree.ends.get(joints[SLOT[side + "Foot"]]) for side in ("Left", "Right")]
    up = upward(tree, joints[SLOT["Head"]], [leg[2] for leg in legs])
    sure = leftness(tree, legs, toes, up)
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
