"""`refimpl inspect`: what is in a BVH file, and what the networks would see of it."""

import numpy as np

from ..motion import bvh
from ..motion.features import leg_length
from ..motion.joints import SLOTS, MappingError, map_joints, read_mapping
from ..motion.take import bone_lengths, guess_unit, make_take, standing_height


def add_commands(commands):
    command = commands.add_parser("inspect", help="say what is in a BVH file", description=__doc__)
    command.add_argument("clip", metavar="CLIP.bvh")
    command.add_argument("--mapping", metavar="FILE.csv", help="lines slot,joint for a skeleton with other names")
    command.set_defaults(run=run)


def run(arguments):
    clip = bvh.read_bvh(arguments.clip)
    overrides = read_mapping(arguments.mapping) if arguments.mapping else None
    for line in describe(clip, overrides, arguments.clip):
        print(line)


def describe(clip, overrides, name):
    """The lines that `refimpl inspect` prints.   Clip, {slot: joint}, name  ->  list of str"""
    lines = [f"{name}: {len(clip.joints)} joints, {clip.frames} frames at {clip.fps:g} frames/s, {clip.frames / clip.fps:.2f} s"]
    try:
        mapping = map_joints(clip.joints, overrides, name)
    except MappingError as error:
        feeds, note = {}, [f"missing: {error}"]
    else:
        feeds = {}
        for slot, joint, tip in zip(SLOTS, mapping.joints, mapping.tips):
            feeds.setdefault(int(joint), []).append(f"{slot} (made up: a point beyond it)" if tip.any() else slot)
        note = _body(make_take(clip, overrides, name), mapping)
    width = max(len(joint.name) + 2 * _depth(clip, j) for j, joint in enumerate(clip.joints)) + 2
    lines += note + ["", f"{'joint':{width}}{'channels':14}feeds"]
    for j, joint in enumerate(clip.joints):
        lines.append(f"{'  ' * _depth(clip, j) + joint.name:{width}}{_channels(joint):14}{', '.join(feeds.get(j, ['-']))}")
    return lines


def _body(take, mapping):
    positions = take.positions
    height = standing_height(bone_lengths(positions))
    unit = guess_unit(height)
    up = "z" if not np.allclose(take.upright, np.eye(3)) else "y"
    planted = take.contacts.mean(axis=0)
    return [f"skeleton: {mapping.family} names; all 21 joints found",
            f"size: leg {leg_length(positions):.4g}, head joint at {height:.4g} when standing; probably {unit}",
            f"axes: {up} is up; floor at {take.start.floor:.4g}; faces {np.degrees(take.start.yaw):.0f} degrees from +z at the start",
            f"at 60 frames/s: {len(positions)} frames; feet planted: left heel {planted[0]:.0%}, left toe {planted[1]:.0%}, "
            f"right heel {planted[2]:.0%}, right toe {planted[3]:.0%} of them"]


def _channels(joint):
    """"XYZ pos ZXY" for three positions and rotations in that order; "-" for none."""
    positions = "".join(c[0] for c in joint.channels if c.endswith("position"))
    return " ".join(filter(None, [f"{positions} pos" if positions else "", joint.rotation_order])) or "-"


def _depth(clip, j):
    depth = -1
    while j >= 0:
        j, depth = clip.joints[j].parent, depth + 1
    return depth
