"""`refimpl inspect`: what is in a BVH file, or in a file of points, and what networks see of it.

Exit status 2 when a joint that is needed was not found; what was found is printed, and written as a
mapping file to complete, all the same.
"""

import argparse
import sys
from typing import Any

import numpy as np

from ..motion.body import guess_unit, make_take, metres, read_clip, standing_height
from ..motion.features import FPS, bone_lengths, leg_length, path_length
from ..motion.ground import stretches
from ..motion.joints import SLOTS, MappingError
from ..motion.mapping import map_clip
from ..motion.points import is_points
from ..storage import atomic_write
from .options import InputPath, OutputPath, add_reading, reading, write_report

DEEPEST, MOST_JOINTS = 40, 1000                  # levels of indentation, joints shown


def add_commands(commands: Any) -> None:
    """Add `refimpl inspect` to the subparsers of the command line."""
    command = commands.add_parser("inspect", description=__doc__)
    command.add_argument("clip", metavar="CLIP.bvh", type=InputPath)
    add_reading(command)
    command.add_argument("--write-mapping", metavar="FILE.csv", type=OutputPath,
                         help="write the joints that were found as such a file, `?` where none "
                              "was, to be changed by hand")
    command.add_argument("--json", metavar="FILE", type=OutputPath, help="write the same as JSON")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print what is in the clip and write what was asked for."""
    overrides, how = reading(arguments)
    clip = read_clip(arguments.clip, overrides, **how)
    overrides = None if is_points(arguments.clip) else overrides
    try:
        mapping = map_clip(clip, overrides, arguments.clip)
    except MappingError as missing:
        feeds = {clip.names.index(joint): [slot] for slot, joint in missing.guesses.items()}
        print("\n".join(_lines(clip, arguments.clip, feeds, [f"missing: {missing}"])))
        _write_mapping(arguments.write_mapping,
                       {slot: missing.guesses.get(slot, "?") for slot in SLOTS})
        raise
    take = make_take(clip, overrides, arguments.clip)
    facts = _facts(clip, take)
    print("\n".join(_lines(clip, arguments.clip, _feeds(mapping), _body(take, mapping, facts))))
    for doubt in take.doubts:
        print(f"refimpl: warning: {arguments.clip}: {doubt}", file=sys.stderr)
    rows = [{"slot": slot, "joint": clip.joints[int(joint)].name, "made up": bool(tip.any()),
             "how": how}
            for slot, joint, tip, how in zip(SLOTS, mapping.joints, mapping.tips, mapping.how)]
    if arguments.json:
        settings = {key: value for key, value in vars(arguments).items() if key != "run"}
        write_report(arguments.json, "inspect", settings, rows, **facts)
    _write_mapping(arguments.write_mapping,
                   {row["slot"]: row["joint"] for row in rows if not row["made up"]})


def _write_mapping(path, joints):
    if path:
        with atomic_write(path) as file:
            file.write("".join(f"{slot},{joint}\n" for slot, joint in joints.items()))


def _facts(clip, take):
    """What a program may want to know of the clip."""
    height = standing_height(bone_lengths(take.positions))
    seconds = len(take.positions) / FPS
    steps = sum(begin > 0 for foot in (take.contacts[:, :2], take.contacts[:, 2:])
                for begin, _ in stretches(foot.any(axis=1)))
    return {"joints": len(clip.joints), "frames": clip.frames, "fps": clip.fps,
            "height": float(height), "up": take.up,
            "unit": guess_unit(height),
            "speed, m/s": path_length(take.features) * metres(height) / seconds,
            "steps a minute": 60 * steps / seconds}


def _feeds(mapping):
    """{joint: list of the slots that it feeds, in words}"""
    feeds: dict[int, list[str]] = {}
    for slot, joint, how in zip(SLOTS, mapping.joints, mapping.how):
        feeds.setdefault(int(joint), []).append(
            slot if how == "name" else f"{slot} ({'by the tree' if how == 'tree' else how})")
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
    lines += [f"{words:{width}}{_channels(joint):14}{', '.join(feeds.get(j, ['-']))}"
              for j, (words, joint) in enumerate(zip(shown[:MOST_JOINTS], clip.joints))]
    return lines + [f"and {len(shown) - MOST_JOINTS} more"][:len(shown) > MOST_JOINTS]


def _body(take, mapping, facts):
    planted = take.contacts.mean(axis=0)
    counts = {words: mapping.how.count(how) for how, words in (
        ("name", "by name"), ("tree", "by the tree"), ("mapping", "by the mapping file"))}
    counts["made up"] = len(mapping.made_up)
    found = ", ".join(f"{count} {words}" for words, count in counts.items() if count)
    made = "".join(f"; {slot} is {how}" for slot, how in mapping.made_up.items())
    return [
        f"skeleton: all 21 joints, {found}{made}",
        f"size: leg {leg_length(take.positions):.4g}, head joint at {facts['height']:.4g} when "
        f"standing; probably {facts['unit']}",
        f"axes: {facts['up']} is up; floor at {take.start.floor:.4g}; faces "
        f"{np.degrees(take.start.yaw):.0f} degrees from +z at the start",
        f"pace: {facts['speed, m/s']:.2f} m/s on average, {facts['steps a minute']:.0f} steps a "
        "minute; if no body moves so, the Frame Time is wrong: --rate sets it right",
        f"at 60 frames/s: {len(take.positions)} frames; feet planted: "
        f"left heel {planted[0]:.0%}, left toe {planted[1]:.0%}, "
        f"right heel {planted[2]:.0%}, right toe {planted[3]:.0%} of them"]


def _channels(joint):
    """"XYZ pos ZXY" for three positions and rotations in that order; "-" for none."""
    positions = "".join(c[0] for c in joint.channels if c.endswith("position"))
    words = (positions and f"{positions} pos", joint.rotation_order)
    return " ".join(filter(None, words)) or "-"
