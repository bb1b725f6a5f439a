"""What a transfer does to a body: widths, feet, height, floor, suddenness, both ends, beside the
content's own; and clips brought to other proportions, to try it on.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ..fast import networks
from ..holden2017.trained import Manifold, Style
from ..holden2017.transfer import project_features, transfer
from ..motion.body import MARGIN, Take, make_take, seen
from ..motion.canonical import measured
from ..motion.clip import Clip
from ..motion.feet import foot_skate
from ..motion.features import FPS, VELOCITIES
from ..motion.joints import FEET, SLOT
from ..motion.moved import rig
from ..motion.skeleton import local_pose, resample, with_pose
from ..motion.stylised import Stylised, onto_skeleton

ACROSS = {"hips": ("LeftUpLeg", "RightUpLeg"), "shoulders": ("LeftArm", "RightArm")}
SWINGING = [SLOT[side + part] for side in ("Left", "Right")
            for part in ("Leg", "ForeArm", "Foot", "Toe")]
ENDS = 12                        # frames at each end that are compared with the middle
# Proportions: how much longer the bones to these slots are, by parts of the slots' names.
BODIES: dict[str, dict[str, float]] = {
    "as recorded": {}, "short legs": {"Leg": 0.7, "Foot": 0.7},
    "long legs": {"Leg": 1.3, "Foot": 1.3}, "long arms": {"ForeArm": 1.4, "Hand": 1.4},
    "short arms": {"ForeArm": 0.6, "Hand": 0.6}, "wide hips": {"UpLeg": 1.4},
    "narrow hips": {"UpLeg": 0.6}, "long trunk": {"Spine": 1.4, "Chest": 1.4},
    "broad shoulders": {"Arm": 1.4}, "narrow shoulders": {"Arm": 0.6}, "long feet": {"Toe": 1.4},
    "short feet": {"Toe": 0.7}}
OTHER_FORMS: dict[str, Callable[[Clip], Clip]] = {
    "120 frames/s": lambda clip: _at_rate(clip, 120.0),
    "24 frames/s": lambda clip: _at_rate(clip, 24.0),
    "5 frames": lambda clip: replace(clip, values=clip.values[:5]),
    "no names": lambda clip: replace(clip, joints=tuple(
        replace(j, name=f"b{n}") for n, j in enumerate(clip.joints)))}


def _at_rate(clip, fps):
    return with_pose(clip, *resample(*local_pose(clip), clip.fps, fps), 1.0 / fps)


def proportioned(take: Take, factors: Mapping[str, float]) -> Clip:
    """A take's clip with bones as many times as long, its way with its legs.

    factors : {part of a slot's name: factor}, "Arm" for the bones to the shoulders
    """
    rotations, translations = (part.copy() for part in local_pose(take.clip))
    joints, owners = list(take.clip.joints), rig(take.clip.joints, take.mapping).owner
    own = {int(j): name for name, j in ((n, take.mapping.joints[s]) for n, s in SLOT.items())}
    legs = factors.get("Leg", 1.0)
    for j in range(len(joints)):
        part = own.get(j, "").replace("Left", "").replace("Right", "")
        if part == "Hips" or owners[j] < 0:
            translations[:, j] *= legs
        elif part in factors:
            translations[:, j] *= factors[part]
            joints[j] = replace(joints[j], offset=tuple(
                factors[part] * np.array(joints[j].offset)))
    return with_pose(replace(take.clip, joints=tuple(joints)), rotations, translations,
                     take.clip.frame_time)


def body_numbers(result: np.ndarray, content: Take) -> dict[str, float]:
    """What became of a content's body.

    result : (T, 21, 3), 60 frames a second, y up   ->  {what: number}; lengths in legs
    """
    was, contacts, leg = content.positions, content.contacts, content.leg
    found = {}
    for name, (a, b) in ACROSS.items():
        wide, before = (np.linalg.norm(p[:, SLOT[a]] - p[:, SLOT[b]], axis=1)
                        for p in (result, was))
        found[f"{name} off"] = float(np.abs(wide / before - 1).max())
    flat = contacts[:, :2].all(axis=1) | contacts[:, 2:].all(axis=1)
    pitches = [np.degrees(measured(p, contacts).pitch) for p in (result, was)]
    found["foot pitch off"] = float(pitches[0] - pitches[1]) if flat.any() else float("nan")
    floor = content.start.floor
    heights = [np.median(p[:, SLOT["Hips"], 1]) - floor for p in (result, was)]
    found["hip height off"] = float(heights[0] / heights[1] - 1)
    for name, p in (("", result), (" of content", was)):
        found[f"slide{name}"] = foot_skate(p, contacts) / leg
        found[f"lowest{name}"] = float((p[:, FEET, 1].min(axis=1).min() - floor) / leg)
        found[f"acceleration{name}"], found[f"acceleration p99.9{name}"] = _sudden(p, leg)
        found[f"ends{name}"] = _ends(p)
    return found


def _sudden(positions, leg):
    """Largest acceleration of knees, elbows and feet, and its 99.9th percentile, legs / s^2."""
    if len(positions) < 3:
        return float("nan"), float("nan")
    second = np.linalg.norm(np.diff(positions[:, SWINGING], n=2, axis=0), axis=-1) * FPS ** 2 / leg
    return float(second.max()), float(np.quantile(second, 0.999))


def _ends(positions):
    """How fast joints move against the hips at both ends, beside the middle."""
    if len(positions) < 4 * ENDS:
        return float("nan")
    speed = np.linalg.norm(np.diff(positions - positions[:, :1], axis=0), axis=-1).mean(axis=1)
    ends = np.concatenate([speed[:ENDS], speed[-ENDS:]]).mean()
    return float(ends / max(speed[ENDS:-ENDS].mean(), 1e-12))


def systems(take: Take, manifold: Manifold,
            styles: Mapping[str, Style]) -> Iterator[tuple[str, Stylised]]:
    """Nothing, P(content) and each style, on one take.   ->  yields (system, Stylised)"""
    there = seen(take, manifold.body)
    yield "nothing", onto_skeleton(take, there, there.features.copy(), clean=False)
    projected = project_features(there.around, manifold, networks=networks)[MARGIN:-MARGIN]
    projected[:, VELOCITIES] = there.features[:, VELOCITIES]
    yield "P(content)", onto_skeleton(take, there, projected, clean=False)
    for name, style in styles.items():
        yield name, transfer(take, style, networks=networks)


def matrix(takes: Mapping[str, Take], manifold: Manifold,
           styles: Mapping[str, Style]) -> Iterator[dict[str, Any]]:
    """Every clip on every body, and on the first of them in every form, by every system.

    ->  yields rows
    """
    for name, take in takes.items():
        made = {body: proportioned(take, factors) for body, factors in BODIES.items()}
        made |= {form: change(take.clip) for form, change in OTHER_FORMS.items()}
        for body, clip in made.items():
            other = make_take(clip, name=f"{name}, {body}")
            for system, result in systems(other, manifold, styles):
                kept = result.clip.frames == clip.frames and result.clip.joints == clip.joints
                yield {"clip": name, "body": body, "system": system,
                       **body_numbers(result.positions, other), "frames and joints kept": kept}
