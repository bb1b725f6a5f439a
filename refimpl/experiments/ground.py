r"""How well a result stands: do its knees, ankles and elbows move like real ones, do its feet stay,
is the style still seen, and are both ends as true as the middle?

Beside each number stand its nulls: the content itself, the result without a clean-up, real takes of
the style, convolutions that see zeros beyond a clip. Lengths are told for legs of `LEG`
centimetres, accelerations and jerks are taken at the clips' own rate.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..fast import networks
from ..holden2017.objective import LEG
from ..holden2017.trained import Style
from ..holden2017.transfer import project_features, stylise, transfer
from ..motion.body import Take, features_on, make_take, seen
from ..motion.features import FPS, POSITIONS, bone_lengths, encode, path_error
from ..motion.feet import foot_skate, jerk
from ..motion.joints import LEGS, SLOT
from ..motion.stylised import onto_skeleton
from .classifiers import Classifier
from .holden import Ground, TableRow, bone_errors, fit_joint_classifier
from .score import seen_from_within

WATCHED = {"knee": [leg[1] for leg in LEGS], "ankle": [leg[2] for leg in LEGS],
           "elbow": [SLOT["LeftForeArm"], SLOT["RightForeArm"]]}
BELOW_HIPS = [joint for leg in LEGS for joint in leg[1:]]
CUT, SECOND, END, LAST = 40, 60, 12, 5           # frames


def result_rows(ground: Ground, takes: Mapping[str, Take], style: Style,
                contents: str = "normal") -> list[TableRow]:
    """Largest accelerations and the legs' jerk (real takes of style and content have 1), slide and
    path in centimetres, style seen: medians over the clips kept out, shares of what is seen.
    """
    judge = fit_joint_classifier(ground, style.manifold)
    usual: dict[str, TableRow] = {}

    def _measured(positions, take, content):
        if content not in usual:
            found = [_sudden(takes[c.name].positions, takes[c.name]) for c in ground.dataset.clips
                     if (c.style, c.content) == (style.name, content)]
            usual[content] = {key: float(np.median([f[key] for f in found])) for key in found[0]}
        row = _sudden(positions, take)
        return ({key: row[key] / usual[content][key] for key in row}
                | _standing(positions, take, style, judge))
    rows: dict[str, list[TableRow]] = {"content itself": [], "no clean-up": [], "result": [],
                                       "real takes": []}
    for clip in ground.kept_out(contents):
        take = takes[clip.name]
        ways = {"content itself": take.positions, **{
            name: transfer(take, style, clean=clean, networks=networks).positions
            for name, clean in (("no clean-up", False), ("result", True))}}
        for name, positions in ways.items():
            rows[name].append(_measured(positions, take, clip.content))
    for clip in ground.kept_out(style.name):
        take = takes[clip.name]
        rows["real takes"].append(_measured(take.positions, take, clip.content))
    return [{"table": "results", "style": style.name, "what": name, **_summary(of)}
            for name, of in rows.items()]


def _sudden(positions, take):
    """Largest accelerations and jerk of the legs, in legs."""
    every = max(1, round(FPS / take.clip.fps))
    sizes = np.linalg.norm(np.diff(positions[::every], n=2, axis=0), axis=-1) / take.leg
    return {**{name: float(sizes[:, joints].max()) for name, joints in WATCHED.items()},
            "legs' jerk": jerk(positions, BELOW_HIPS, recorded=take.clip.fps) / take.leg}


def _standing(positions, take, style: Style, judge: Classifier):
    features, cm = encode(positions, take.start.floor)[0], LEG / take.leg
    told = judge.classify(features_on(positions, style.manifold.body, take.contacts))
    return {"slide": cm * foot_skate(positions, take.contacts), "seen": told[0] == style.name,
            "path": cm * path_error(features, take.features)[0]}


def end_rows(ground: Ground, takes: Mapping[str, Take], style: Style,
             contents: str = "normal") -> list[TableRow]:
    """Whether both ends are as true as the middle, before the clean-up and with zeros beyond: how
    far joints lie from those of the clip cut `CUT` frames later (centimetres, in the first four
    frames, the first second, and after), errors of bones in the first and last `END` frames over
    the middle's, size of the pose in the first and last `LAST` over the middle's (the content's
    is 1). Medians over the clips.
    """
    rows: dict[str, list[TableRow]] = {"goes on": [], "after clean-up": [], "zeros": []}
    for clip in ground.kept_out(contents):
        take, cm = takes[clip.name], LEG / takes[clip.name].leg
        cut = make_take(replace(take.clip, values=take.clip.values[
            round(CUT * take.clip.fps / FPS):]))
        if len(cut.positions) < 2 * SECOND:
            continue
        ways: dict[str, Callable[[Take], np.ndarray]] = {
            "goes on": lambda t: _raw(t, style, True), "zeros": lambda t: _raw(t, style, False),
            "after clean-up": lambda t: transfer(t, style, networks=networks).positions}
        for name, way in ways.items():
            whole, part = way(take), way(cut)
            apart = cm * np.linalg.norm(seen_from_within(whole[-len(part):])
                                        - seen_from_within(part), axis=-1).mean(axis=1)
            own = _ends("pose", _size(take.positions, style, take), LAST)
            rows[name].append({
                "4 frames": apart[:4].mean(), "a second": apart[:SECOND].mean(),
                "after": apart[SECOND:].mean(), **{key: value / own[key] for key, value in _ends(
                    "pose", _size(whole, style, take), LAST).items()}})
            if name != "after clean-up":                         # which leaves no error
                rows[name][-1] |= _ends("bones", bone_errors(whole, bone_lengths(whole)).mean(
                    axis=1), END)
    return [{"table": "ends", "style": style.name, "what": name, **_summary(of)}
            for name, of in rows.items()]


def _raw(take, style, goes_on):
    """P(T(I)) with the content's path, in the take's unit.   ->  (T, 21, 3)"""
    if goes_on:
        return transfer(take, style, clean=False, networks=networks).positions
    there = seen(take, style.manifold.body)
    moved = stylise(there.features, style, projected=False, networks=networks)
    moved = project_features(moved, style.manifold, networks=networks)
    return onto_skeleton(take, there, moved, clean=False).positions


def _size(positions, style, take):
    """Root mean square of the normalised pose in each frame.   ->  (T,)"""
    normaliser = style.manifold.normaliser
    local = seen_from_within(positions) - [0.0, take.start.floor, 0.0]
    pose = local.reshape(len(positions), -1) * (style.manifold.leg / take.leg)
    X = (pose - normaliser.mean[POSITIONS]) / normaliser.deviation[POSITIONS]
    return np.sqrt(np.mean(X ** 2, axis=1))


def _ends(name, values, frames):
    middle = values[2 * END:-2 * END].mean()
    return {f"{name}, first": values[:frames].mean() / middle,
            f"{name}, last": values[-frames:].mean() / middle}


def leg_rows(ground: Ground, takes: Mapping[str, Take]) -> list[TableRow]:
    """What the clean-up does to real motion kept out, which needs none: the legs' jerk and their
    largest acceleration over their own, how far planted feet slide before and after, how far
    joints are moved (centimetres).   Means over the clips.
    """
    rows = []
    for clip in ground.dataset.select(held_out=True):
        take, cm = takes[clip.name], LEG / takes[clip.name].leg
        moved = onto_skeleton(take, seen(take), take.features).positions
        before, after = (_sudden(p, take) for p in (take.positions, moved))
        apart = np.linalg.norm(moved - take.positions, axis=-1)
        rows.append({**{key: after[key] / before[key] for key in ("knee", "ankle", "legs' jerk")},
                     "slide before": cm * foot_skate(take.positions, take.contacts),
                     "slide": cm * foot_skate(moved, take.contacts), "moved": cm * apart.mean()})
    return [{"table": "legs", "style": "all", "what": "real takes", **_summary(rows, np.nanmean)}]


def _summary(rows: Sequence[TableRow], usual: Any = np.nanmedian) -> TableRow:
    """->  {number: over the rows}, shares of what is seen; nothing without rows"""
    keys = rows[0] if rows else ()
    return {key: float(np.mean([row[key] for row in rows]) if key == "seen" else
                       usual([row[key] for row in rows])) for key in keys} | {"clips": len(rows)}
