"""`refimpl inspect`: what is in a BVH file, and what the networks would see of it.

Exit status 2 when a joint that is needed was not found; what was found is printed all the same.
"""

import argparse
from typing import Any

import numpy as np

from ..motion import bvh
from ..motion.features import bone_lengths, leg_length
from ..motion.joints import SLOTS, MappingError, map_joints, read_mapping
from ..motion.body import guess_unit, make_take, standing_height
from ..storage import atomic_write
from .options import InputPath, OutputPath, write_report

DEEPEST = 40                                                     # levels of indentation shown


def add_commands(commands: Any) -> None:
    """Add `refimpl inspect` to the subparsers of the command line."""
    command = commands.add_parser("inspect", help="say what is in a BVH file", description=__doc__)
    command.add_argument("clip", metavar="CLIP.bvh", type=InputPath)
    command.add_argument("--mapping", metavar="FILE.csv", type=InputPath,
                         help="lines slot,joint for a skeleton with other names")
    command.add_argument("--write-mapping", metavar="FILE.csv", type=OutputPath,
                         help="write the joints that were found as such a file, to be changed by "
                              "hand")
    command.add_argument("--json", metavar="FILE", type=OutputPath, help="write the same as JSON")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print what is in the clip and write what was asked for."""
    clip = bvh.read_bvh(arguments.clip)
    overrides = read_mapping(arguments.mapping) if arguments.mapping else None
    try:
        mapping = map_joints(clip.joints, overrides, arguments.clip)
    except MappingError as missing:
        print("\n".join(_lines(clip, arguments.clip, {}, [f"missing: {missing}"])))
        raise
    take = make_take(clip, overrides, arguments.clip)
    facts = _facts(clip, take)
    print("\n".join(_lines(clip, arguments.clip, _feeds(mapping), _body(take, mapping, facts))))
    rows = [{"slot": slot, "joint": clip.joints[int(joint)].name, "made up": bool(tip.any())}
            for slot, joint, tip in zip(SLOTS, mapping.joints, mapping.tips)]
    if arguments.json:
        settings = {"clip": arguments.clip, "mapping": arguments.mapping}
        write_report(arguments.json, "inspect", settings, rows, **facts)
    if arguments.write_mapping:
        with atomic_write(arguments.write_mapping) as file:
            file.write("".join(f"{row['slot']},{row['joint']}\n" for row in rows
                               if not row["made up"]))


def _facts(clip, take):
    """What a program may want to know of the clip."""
    height = standing_height(bone_lengths(take.positions))
    return {"joints": len(clip.joints), "frames": clip.frames, "fps": clip.fps,
            "height": float(height), "up": "y" if np.allclose(take.upright, np.eye(3)) else "z",
            "unit": guess_unit(height)}


def _feeds(mapping):
    """{joint: list of the slots that it feeds, in words}"""
    feeds: dict[int, list[str]] = {}
    for slot, joint, tip in zip(SLOTS, mapping.joints, mapping.tips):
        words = f"{slot} (made up: a point beyond it)" if tip.any() else slot
        feeds.setdefault(int(joint), []).append(words)
    return feeds


def _lines(clip, name, feeds, note):
    """What `refimpl inspect` prints.   ->  list of str"""
    lines = [f"{name}: {len(clip.joints)} joints, {clip.frames} frames at {clip.fps:g} frames/s, "
             f"{clip.frames / clip.fps:.2f} s"]
    depth: list[int] = []
    for joint in clip.joints:                                    # a parent before its children
        depth.append(0 if joint.parent < 0 else min(depth[joint.parent] + 1, DEEPEST))
    shown = [f"{'  ' * d}{joint.name[:60]}" for d, joint in zip(depth, clip.joints)]
    width = max(map(len, shown)) + 2
    lines += note + ["", f"{'joint':{width}}{'channels':14}feeds"]
    return lines + [f"{words:{width}}{_channels(joint):14}{', '.join(feeds.get(j, ['-']))}"
                    for j, (words, joint) in enumerate(zip(shown, clip.joints))]


def _body(take, mapping, facts):
    planted = take.contacts.mean(axis=0)
    return [
        f"skeleton: {mapping.family} names; all 21 joints found",
        f"size: leg {leg_length(take.positions):.4g}, head joint at {facts['height']:.4g} when "
        f"standing; probably {facts['unit']}",
        f"axes: {facts['up']} is up; floor at {take.start.floor:.4g}; faces "
        f"{np.degrees(take.start.yaw):.0f} degrees from +z at the start",
        f"at 60 frames/s: {len(take.positions)} frames; feet planted: "
        f"left heel {planted[0]:.0%}, left toe {planted[1]:.0%}, "
        f"right heel {planted[2]:.0%}, right toe {planted[3]:.0%} of them"]


def _channels(joint):
    """"XYZ pos ZXY" for three positions and rotations in that order; "-" for none."""
    positions = "".join(c[0] for c in joint.channels if c.endswith("position"))
    words = (positions and f"{positions} pos", joint.rotation_order)
    return " ".join(filter(None, words)) or "-"
