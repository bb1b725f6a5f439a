"""One motion on many bodies: skeletons with the names and trees of several tools and data sets, in
any proportions, rest poses, units, axes and rates. Made for tests; what a joint's slot truly is
stands beside it.
"""

from dataclasses import replace

import numpy as np

from refimpl.embedded.walkers import make_clip
from refimpl.motion import rotation, skeleton
from refimpl.motion.clip import POSITION_CHANNELS, Clip, Joint
from refimpl.motion.joints import PARENTS, SLOT, SLOTS

TURNS = ("Zrotation", "Yrotation", "Xrotation")
# Trunk from the hips to where the arms branch; neck to head, "+" a joint beyond the head; a leg
# with a spacer before it or "-"; an arm with a collar bone before it or "-"; what comes after the
# fourth is beyond. @ is the side, in the two spellings given first. "?" the tool has no such joint.
SCHEMES = {
    "CMU": ("Left Right L R", "Hips LowerBack Spine Spine1", "Neck Neck1 Head",
            "#HipJoint @UpLeg @Leg @Foot @ToeBase",
            "@Shoulder @Arm @ForeArm @Hand @FingerBase @HandIndex1"),
    "Mixamo": ("Left Right", "mixamorig:Hips mixamorig:Spine mixamorig:Spine1 mixamorig:Spine2",
               "mixamorig:Neck mixamorig:Head +mixamorig:HeadTop_End",
               "- mixamorig:@UpLeg mixamorig:@Leg mixamorig:@Foot mixamorig:@ToeBase",
               "mixamorig:@Shoulder mixamorig:@Arm mixamorig:@ForeArm mixamorig:@Hand "
               "mixamorig:@HandMiddle1 mixamorig:@HandMiddle2"),
    "Bandai": ("L R", "Hips Spine Chest", "Neck Head",
               "- UpperLeg_@ LowerLeg_@ Foot_@ Toes_@", "Shoulder_@ UpperArm_@ LowerArm_@ Hand_@"),
    "Axis Neuron": ("Left Right", "Hips Spine Spine1 Spine2 Spine3", "Neck Head",
                    "- @UpLeg @Leg @Foot ?",
                    "@Shoulder @Arm @ForeArm @Hand @InHandMiddle @HandMiddle1"),
    "LAFAN1": ("Left Right", "Hips Spine Spine1 Spine2", "Neck Head",
               "- @UpLeg @Leg @Foot @Toe", "@Shoulder @Arm @ForeArm @Hand"),
    "LAFAN1 Model:": ("Left Right", "Model:Hips Model:Spine Model:Spine1 Model:Spine2",
                      "Model:Neck Model:Head", "- Model:@UpLeg Model:@Leg Model:@Foot Model:@Toe",
                      "Model:@Shoulder Model:@Arm Model:@ForeArm Model:@Hand"),
    "100STYLE": ("Left Right", "Hips Chest Chest2 Chest3 Chest4", "Neck Head",
                 "- @Hip @Knee @Ankle @Toe", "@Collar @Shoulder @Elbow @Wrist"),
    "Motorica": ("Left Right", "Hips Spine Spine1", "Neck Head",
                 "- @UpLeg @Leg @Foot @ToeBase", "@Shoulder @Arm @ForeArm @Hand @HandMiddle1"),
    "SMPL L_Hip": ("L R", "Pelvis Spine1 Spine2 Spine3", "Neck Head",
                   "- @_Hip @_Knee @_Ankle @_Foot", "@_Collar @_Shoulder @_Elbow @_Wrist @_Hand"),
    "SMPL left_hip": ("left right", "pelvis spine1 spine2 spine3", "neck head",
                      "- @_hip @_knee @_ankle @_foot",
                      "@_collar @_shoulder @_elbow @_wrist @_hand"),
    "Rokoko": ("Left Right", "Hips Spine1 Spine2 Spine3 Spine4", "Neck Head",
               "- @Thigh @Shin @Foot @Toe", "@Shoulder @Arm @ForeArm @Hand @Finger3Metacarpal"),
    "Blender": ("L R", "spine spine.001 spine.002 spine.003", "spine.004 spine.005 spine.006",
                "- thigh.@ shin.@ foot.@ toe.@",
                "shoulder.@ upper_arm.@ forearm.@ hand.@ f_middle.01.@"),
    "Unreal": ("l r", "pelvis spine_01 spine_02 spine_03", "neck_01 head",
               "- thigh_@ calf_@ foot_@ ball_@",
               "clavicle_@ upperarm_@ lowerarm_@ hand_@ middle_01_@ middle_02_@"),
    "VRM": ("L R", "J_Bip_C_Hips J_Bip_C_Spine J_Bip_C_Chest J_Bip_C_UpperChest",
            "J_Bip_C_Neck J_Bip_C_Head",
            "- J_Bip_@_UpperLeg J_Bip_@_LowerLeg J_Bip_@_Foot J_Bip_@_ToeBase",
            "J_Bip_@_Shoulder J_Bip_@_UpperArm J_Bip_@_LowerArm J_Bip_@_Hand J_Bip_@_Middle1"),
    "Unity": ("Left Right", "Hips Spine Chest UpperChest", "Neck Head",
              "- @UpperLeg @LowerLeg @Foot @Toes", "@Shoulder @UpperArm @LowerArm @Hand"),
    "Biped, usual tree": ("L R", "Bip01_Pelvis Bip01_Spine Bip01_Spine1", "Bip01_Neck Bip01_Head",
                          "- Bip01_@_Thigh Bip01_@_Calf Bip01_@_Foot Bip01_@_Toe0",
                          "Bip01_@_Clavicle Bip01_@_UpperArm Bip01_@_Forearm Bip01_@_Hand"),
    "Geno": ("Left Right", "Hips Spine Spine1 Spine2 Spine3", "Neck Neck1 Head",
             "- @UpLeg @Leg @Foot @ToeBase",
             "@Shoulder @Arm @ForeArm @Hand @HandIndex1 @HandIndex2"),
    "Kinect": ("Left Right", "SpineBase SpineMid SpineShoulder", "Neck Head",
               "- Hip@ Knee@ Ankle@ Foot@", "- Shoulder@ Elbow@ Wrist@ Hand@"),
    "DAZ": ("l r", "hip abdomenLower abdomenUpper chestLower", "neckLower head",
            "- @Thigh @Shin @Foot @Toe", "@Collar @Shldr @ForeArm @Hand @Mid1"),
    "Biovision": ("Left Right", "Hips Chest", "Neck Head",
                  "- @Hip @Knee @Ankle ?", "@Collar @Shoulder @Elbow @Wrist"),
    "MVN": ("Left Right", "Pelvis L5 L3 T12 T8", "Neck Head",
            "- @UpperLeg @LowerLeg @Foot @Toe", "@Shoulder @UpperArm @ForeArm @Hand"),
    "AMC": ("l r", "root lowerback upperback thorax", "lowerneck upperneck head",
            "- @femur @tibia @foot @toes", "@clavicle @humerus @radius @wrist @hand"),
    "mocopi": ("l r", "root torso_1 torso_2 torso_3 torso_7", "neck_1 neck_2 head",
               "- @_up_leg @_low_leg @_foot @_toes", "@_shoulder @_up_arm @_low_arm @_hand"),
    "OpenNI": ("Left Right", "Hips Spine Chest", "Neck Head",
               "- @Hip @Knee @Ankle @ForeFoot", "@Collar @Shoulder @Elbow @Wrist @FingerBase"),
}


def walker(content="walk", style="normal", seconds=2.0, *, legs=1.0, arms=1.0, trunk=1.0,
           hips=1.0, shoulders=1.0, feet=1.0, scale=1.0, turn=None, seed=0):
    """A clip of the 21 joints in other proportions: the feet stand where they stood."""
    clip = make_clip(content, style, seconds=seconds, turn=turn, seed=seed).clip
    by = {"UpLeg": hips, "Leg": legs, "Foot": legs, "Toe": feet, "ForeArm": arms, "Hand": arms,
          "Finger": arms, "Spine": trunk, "Chest": trunk, "Neck": trunk, "Head": trunk}
    joints = []
    for joint in clip.joints:
        part = joint.name.replace("Left", "").replace("Right", "")
        factor = by.get(part, 1.0) if part != "Arm" else np.array([shoulders, trunk, 1.0])
        joints.append(replace(joint, offset=tuple(scale * factor * np.array(joint.offset)),
                              end_site=joint.end_site and tuple(
                                  scale * np.array(joint.end_site))))
    made = replace(clip, joints=tuple(joints), values=clip.values.copy())
    made.values[:, :3] *= scale * legs
    lowest = [np.quantile(skeleton.forward_kinematics(c.parents, *skeleton.local_pose(c))[1][
        :, [SLOT["LeftToe"], SLOT["RightToe"]], 1].min(axis=1), 0.2) for c in (clip, made)]
    made.values[:, 1] += scale * lowest[0] - lowest[1]
    return made


def on_scheme(clip, name):
    """A clip of the 21 joints as one of a scheme.   ->  Clip, {slot: joint name}"""
    sides, trunk, neck, leg, arm = (part.split() for part in SCHEMES[name])
    rows, truth = [], {}                     # name, parent's name, slot that carries, share, to

    def _add(joint, parent, slot, carries=None, share=0.0, to=None):
        rows.append((joint, parent, carries or slot, share, to or slot))
        if slot:
            truth[slot] = joint
    _add(trunk[0], None, "Hips")
    for n, joint in enumerate(trunk[1:], start=1):
        last, spine = n == len(trunk) - 1, 2 if name == "CMU" else 1
        if last:
            _add(joint, trunk[n - 1], "Chest")
        elif n < spine:
            _add(joint, trunk[n - 1], None, "Hips", 0.0, "Hips")
        else:
            share = (n - spine) / (len(trunk) - 1 - spine)
            _add(joint, trunk[n - 1], "Spine" if n == spine else None, "Spine", share, "Chest")
    above, heads = trunk[-1], [joint for joint in neck if joint[0] != "+"]
    if name == "CMU":
        _add(heads[0], above, None, "Chest", 0.0, "Chest")
        above, heads = heads[0], heads[1:]
    for n, joint in enumerate(heads):
        slot = "Neck" if n == 0 else "Head" if n == len(heads) - 1 else None
        _add(joint, above, slot, slot or "Neck", 0.0 if slot else 0.5, slot or "Head")
        above = joint
    for joint in neck:
        if joint[0] == "+":
            _add(joint[1:], above, None, "Head", 2.2, "Neck")
    for n, side in enumerate(("Left", "Right")):
        for limb, top, slots in ((leg, trunk[0], ("UpLeg", "Leg", "Foot", "Toe")),
                                 (arm, trunk[-1], ("Arm", "ForeArm", "Hand", "Finger"))):
            own = [joint.replace("@", sides[n]).replace("#", sides[-2:][n]) for joint in limb]
            parent = top
            if own[0] != "-":
                carries = "Hips" if limb is leg else "Chest"
                _add(own[0], parent, None, carries, 0.0 if limb is leg else 0.3,
                     side + slots[0])
                parent = own[0]
            ahead = own[1:]
            if limb is arm and len(ahead) == 5:          # a joint of the palm before the finger
                palm = "Base" in ahead[3] or "InHand" in ahead[3]
                share = 0.0 if "Base" in ahead[3] else 0.5
                if palm:
                    _add(ahead[3], ahead[2], None, side + "Hand", share, side + "Finger")
                    ahead = [*ahead[:3], ahead[4]]
                else:
                    ahead = ahead[:4]
                if palm:
                    rows_parent = own[4]
            for slot, joint in zip(slots, ahead):
                if joint == "?":
                    continue
                before = rows_parent if slot == "Finger" and len(own) == 6 and palm else parent
                _add(joint, before, side + slot)
                parent = joint
    return _built(clip, rows), truth


def _depth_first(parents):
    """The joints in the order of a BVH file."""
    order, stack = [], [j for j, parent in enumerate(parents) if parent < 0]
    while stack:
        j = stack.pop()
        order.append(j)
        stack += [k for k in reversed(range(len(parents))) if parents[k] == j]
    return order


def _built(clip, rows):
    """The skeleton of these rows in the clip's motion."""
    R, P = skeleton.forward_kinematics(clip.parents, *skeleton.local_pose(clip))
    name = {row[0]: n for n, row in enumerate(rows)}
    order = [rows[n] for n in _depth_first([name.get(row[1], -1) for row in rows])]
    done = {row[0]: n for n, row in enumerate(order)}
    world_R, world_P, made, parents = [], [], [], []
    for joint, parent, carries, share, to in order:
        a, b = SLOT[carries], SLOT[to]
        world_R.append(R[:, a])
        world_P.append(P[:, a] + share * (P[:, b] - P[:, a]))
        parents.append(-1 if parent is None else done[parent])
    for n, (joint, *_) in enumerate(order):
        k = parents[n]
        offset = world_P[n] if k < 0 else np.einsum("tij,ti->tj", world_R[k],
                                                    world_P[n] - world_P[k])
        free = k < 0 or np.ptp(offset, axis=0).max() > 1e-6
        made.append(Joint(joint, k, tuple(offset[0]), (POSITION_CHANNELS if free else ()) + TURNS,
                          None if n in parents else (0.0, 0.0, 0.0)))
    local_R = [world_R[n] if k < 0 else world_R[k].swapaxes(1, 2) @ world_R[n]
               for n, k in enumerate(parents)]
    local_t = [world_P[n] if k < 0 else np.einsum("tij,ti->tj", world_R[k], world_P[n] - world_P[k])
               for n, k in enumerate(parents)]
    empty = Clip(tuple(made), clip.frame_time, np.zeros((clip.frames, 0)))
    return skeleton.with_pose(empty, np.stack(local_R, 1), np.stack(local_t, 1), clip.frame_time)


def renamed(clip, rename):
    """The same clip with `rename(name)` for every name."""
    return replace(clip, joints=tuple(replace(j, name=rename(j.name)) for j in clip.joints))


def turned_rest(clip, rng, size=3.0):
    """The same motion with every joint's rest pose turned at random."""
    rotations, translations = skeleton.local_pose(clip)
    turns = rotation.exp_map(rng.normal(size=(len(clip.joints), 3)) * size)
    joints, new = [], rotations.copy()
    moved = translations.copy()
    for j, joint in enumerate(clip.joints):
        above = turns[joint.parent] if joint.parent >= 0 else np.eye(3)
        new[:, j] = above.T @ rotations[:, j] @ turns[j]
        moved[:, j] = translations[:, j] @ above
        end = joint.end_site and tuple(np.array(joint.end_site) @ turns[j])
        joints.append(replace(joint, offset=tuple(np.array(joint.offset) @ above), end_site=end))
    return skeleton.with_pose(replace(clip, joints=tuple(joints)), new, moved, clip.frame_time)


def free_everywhere(clip):
    """The same motion with position channels on every joint."""
    pose = skeleton.local_pose(clip)
    joints = tuple(replace(j, channels=POSITION_CHANNELS + tuple(
        c for c in j.channels if c not in POSITION_CHANNELS)) for j in clip.joints)
    return skeleton.with_pose(replace(clip, joints=joints), *pose, clip.frame_time)


def as_biped(clip, thighs_under="Bip01_Spine", collars_under="Bip01_Neck"):
    """The clip of "Biped, usual tree" with limbs that hang elsewhere, position channels where that
    needs them."""
    R, P = skeleton.forward_kinematics(clip.parents, *skeleton.local_pose(clip))
    names = list(clip.names)
    parents = clip.parents.copy()
    for j, name in enumerate(names):
        if name.endswith("_Thigh"):
            parents[j] = names.index(thighs_under)
        if name.endswith("_Clavicle"):
            parents[j] = names.index(collars_under)
    order = _depth_first(parents)
    place = {j: n for n, j in enumerate(order)}
    joints, local_R, local_t = [], [], []
    for j in order:
        k = parents[j]
        local_R.append(R[:, j] if k < 0 else R[:, k].swapaxes(1, 2) @ R[:, j])
        offset = P[:, j] if k < 0 else np.einsum("tij,ti->tj", R[:, k], P[:, j] - P[:, k])
        local_t.append(offset)
        free = k < 0 or np.ptp(offset, axis=0).max() > 1e-6
        joints.append(Joint(names[j], place[k] if k >= 0 else -1, tuple(offset[0]),
                            (POSITION_CHANNELS if free else ()) + TURNS, clip.joints[j].end_site))
    empty = Clip(tuple(joints), clip.frame_time, np.zeros((clip.frames, 0)))
    return skeleton.with_pose(empty, np.stack(local_R, 1), np.stack(local_t, 1), clip.frame_time)


def stiff(clip):
    """Another motion, of the Biped's names: the spine does not turn against the hips, nor the neck
    against the chest."""
    rotations, translations = skeleton.local_pose(clip)
    for name in ("Bip01_Spine", "Bip01_Neck"):
        rotations[:, clip.names.index(name)] = np.eye(3)
    return skeleton.with_pose(clip, rotations, translations, clip.frame_time)


def without(clip, gone):
    """The clip without some joints; what hung on them hangs on their parents, where it was."""
    R, P = skeleton.forward_kinematics(clip.parents, *skeleton.local_pose(clip))
    kept = [j for j in range(len(clip.joints)) if clip.names[j] not in gone]
    place = {j: n for n, j in enumerate(kept)}
    joints, local_R, local_t = [], [], []
    for j in kept:
        k = clip.joints[j].parent
        while k >= 0 and k not in place:
            k = clip.joints[k].parent
        local_R.append(R[:, j] if k < 0 else R[:, k].swapaxes(1, 2) @ R[:, j])
        offset = P[:, j] if k < 0 else np.einsum("tij,ti->tj", R[:, k], P[:, j] - P[:, k])
        local_t.append(offset)
        joints.append(replace(clip.joints[j], parent=place.get(k, -1), offset=tuple(offset[0])))
    return skeleton.with_pose(replace(clip, joints=tuple(joints)), np.stack(local_R, 1),
                              np.stack(local_t, 1), clip.frame_time)


def z_up(clip):
    """The same motion in a world whose z points up."""
    rotations, translations = skeleton.local_pose(clip)
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    rotations[:, 0], translations[:, 0] = turn @ rotations[:, 0], translations[:, 0] @ turn.T
    return skeleton.with_pose(clip, rotations, translations, clip.frame_time)


def scaled(clip, factor):
    """The same motion in another unit."""
    values, column = clip.values.copy(), 0
    for joint in clip.joints:
        for channel in joint.channels:
            if channel in POSITION_CHANNELS:
                values[:, column] *= factor
            column += 1
    joints = tuple(replace(j, offset=tuple(factor * np.array(j.offset)), end_site=j.end_site and
                           tuple(factor * np.array(j.end_site))) for j in clip.joints)
    return replace(clip, joints=joints, values=values)


def at_rate(clip, fps):
    """The same motion at another rate."""
    return skeleton.with_pose(clip, *skeleton.resample(*skeleton.local_pose(clip), clip.fps, fps),
                              1.0 / fps)


assert set(SLOTS) == set(SLOT) and len(PARENTS) == len(SLOTS)
