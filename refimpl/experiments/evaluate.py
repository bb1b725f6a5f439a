r"""What the paper leaves to the eye: content, the results of 2016 and of 2017, and real takes of
the style, measured side by side.

Everything is measured on the clip that was written and read again, on its own skeleton, after the
clean-up. The judges never saw a clip that a transfer learnt on, took its style from or had for its
content; `judges_clips` makes sure of it.
"""

import time

import numpy as np

from ..fast import networks
from ..holden2016 import bridge, rows, search
from ..holden2016.own import Settings, optimise, pairs
from ..motion.body import read_take, to_scale
from .classifiers import fit_judge, frechet_distance, gram_vectors, joint_vectors
from .measures import content_distance, style_distance
from ..holden2017.transfer import onto_skeleton, project_features, stylise, transfer
from ..motion.bvh import write_bvh
from ..motion.features import POSITIONS, VELOCITIES, Start, decode, scale
from ..motion.feet import floor_penetration, foot_skate, jerk
from ..motion.joints import BONES, JOINTS

CODED, OWN = "2016, as coded", "2016, own form"
SYSTEMS = ("content", CODED, OWN, "2017 T(I), raw", "2017", "2017, own pace", "real")
FRAMES = (240, 480, 960)


class EvaluationError(ValueError):
    """Clips or models that do not make an evaluation; the message says what is missing."""


def judges_clips(dataset, styles, content_style="normal"):
    """Clips for the judges: not held out, of these styles or of the contents', and in no transfer's
    hands.

    dataset : Dataset;  styles : of Style   ->  list of Labelled.
    Raises EvaluationError where a style or a content has none left.
    """
    used = {name for style in styles for name in (*style.learned, *style.exemplars)}
    names = {style.name for style in styles} | {content_style}
    contents = {content for style in styles for content in style.contents}
    found = [
        c for c in dataset.clips
        if not c.held_out and c.name not in used and c.style in names and c.content in contents]
    for what, wanted, there in (("style", names, {c.style for c in found}),
                                ("content", contents, {c.content for c in found})):
        missing = sorted(wanted - there)
        if missing:
            raise EvaluationError(
                f"judges: found no clip of {what} {', '.join(missing)} that the style networks did "
                "not learn on, needed some to fit the "
                "judges on; train with --clips and --exemplars that leave some")
    return found


def fit_judges(clips, manifold, leg):
    """The judge of Gram matrices and the judge of joints.
    clips : of Labelled, leg : of their dataset   ->  {"gram": Judge, "joints": Judge}
    """
    labelled = [(to_scale(c.features, leg, manifold.leg), c.style, c.content) for c in clips]
    return {
        "gram": fit_judge(labelled, lambda features: gram_vectors(features, manifold)),
        "joints": fit_judge(labelled, joint_vectors)}


def exemplars_of(dataset, style, content):
    """The features that a style's network had for this content, on its manifold's scale.
    ->  list of (T, 66)
    """
    wanted = [
        c for c in dataset.clips
        if c.name in set(style.exemplars) and c.content == style.pairs[content]]
    if not wanted:
        raise EvaluationError(
            f"style {style.name!r}: found none of its exemplars for {content!r} in the dataset, "
            "needed those it was trained with")
    return [to_scale(c.features, dataset.leg, style.manifold.leg) for c in wanted]


def carry_out(take, exemplars, style, settings=Settings(), *, network=None, seed=0):
    """Every system on one content.

    settings : of the 2016 system in its own form here, on the style's loss network;
    network : `holden2016.bridge.Network` for that system as coded, with the first exemplar as its
    style
    ->  yields (system, Stylised, seconds that its mathematics took, without reading and writing)
    """
    manifold, content = style.manifold, to_scale(take.features, take.leg, style.manifold.leg)
    stylise(content, style, networks=networks)                   # its spectra are kept for all clips
    if network is not None:
        began = time.perf_counter()
        result = bridge.transfer(take, decode(exemplars[0], Start()), network, clean=False,
                                 seed=seed)
        yield CODED, result, time.perf_counter() - began
    began = time.perf_counter()
    moved = optimise(content, take.contacts, exemplars, manifold, settings=settings, seed=seed,
                     networks=networks)
    seconds = time.perf_counter() - began
    yield OWN, onto_skeleton(take, to_scale(moved, manifold.leg, take.leg)), seconds
    began = time.perf_counter()
    stylise(content, style, networks=networks)
    seconds = time.perf_counter() - began
    yield "2017 T(I), raw", transfer(
        take, style, projected=False, clean=False, networks=networks), seconds
    yield "2017", transfer(take, style, networks=networks), seconds
    yield "2017, own pace", transfer(take, style, own_pace=True,
                                     networks=networks), seconds


def read_back(clip, path):
    """Write a clip and read it again.   ->  Take"""
    write_bvh(path, clip)
    return read_take(path)


def measure(result, content, exemplars, manifold, judges):
    """What there is to know about a result that was read again.

    result, content : Take;  exemplars : list of features on the manifold's scale   ->  dict
    """
    features, wanted = (to_scale(t.features, content.leg, manifold.leg) for t in (result, content))
    depth = floor_penetration(result.positions, content.start.floor)
    own, path = _path(result), _path(content)
    return {
        **_looks(features, exemplars, manifold, judges), "content distance": content_distance(
            features, wanted, manifold), "skate": foot_skate(result.positions, content.contacts),
        "sinks": depth[0], "sinks at most": depth[1], "bone error": bone_error(result, content),
        "path error": float(np.linalg.norm(own - path, axis=1).mean()),
        "jerk": jerk(result.positions, range(JOINTS),
                     recorded=content.clip.fps), "frames": len(features)}


def bone_error(result, content):
    """The largest relative difference of a bone's length, over all bones of the file's own skeleton
    but those that carry the hips.   ->  float
    """
    parents, carries = content.clip.parents, set()
    j = int(content.mapping.joints[0])
    while j >= 0:
        carries.add(j)
        j = parents[j]
    bones = [j for j in range(len(parents)) if j not in carries]
    here, there = (np.linalg.norm(t.translations[:, bones], axis=-1) for t in (result, content))
    return float(np.max(np.abs(here - there) / np.where(there > 0, there, 1.0), initial=0.0))


def measure_real(clip, leg, exemplars, manifold, judges):
    """The same of a real take of the style, from its features, where it can be said.
    clip : Labelled, leg : of its dataset   ->  dict
    """
    features = to_scale(clip.features, leg, manifold.leg)
    positions = decode(features, Start())
    depth = floor_penetration(positions)
    return {
        **_looks(features, exemplars, manifold, judges), "skate": foot_skate(
            positions, clip.contacts), "sinks": depth[0], "sinks at most": depth[1],
        "jerk": jerk(positions, range(JOINTS), recorded=clip.fps), "frames": len(features)}


def _looks(features, exemplars, manifold, judges):
    verdicts = {name: judge.verdict(features) for name, judge in judges.items()}
    return {
        "style distance": style_distance(features, exemplars, manifold),
        **{f"{name} style": v[0] for name, v in verdicts.items()},
        **{f"{name} content": v[1] for name, v in verdicts.items()}}


def _lengths(positions):
    j1, j2 = np.array(BONES).T
    return np.linalg.norm(positions[:, j1] - positions[:, j2], axis=-1)


def _path(take):
    return take.positions[:, 0][:, [0, 2]]


def summary(rows, distances):
    """One line a system.

    rows : dicts of `measure` with style, content and system;  distances : {(style, system): Fréchet
    distance}   ->  list of dicts
    """
    real = {
        style: np.mean([r["jerk"]
                        for r in rows if r["style"] == style and r["system"] == "real"] or [np.nan])
        for style in {r["style"] for r in rows}}
    lines = []
    for system in SYSTEMS:
        of = [r for r in rows if r["system"] == system]
        if not of:
            continue
        line = {"system": system, "clips": len(of)}
        for judge in ("gram", "joints"):
            line[f"style by {judge}"] = float(
                np.mean([r[f"{judge} style"] == r["style"] for r in of]))
            line[f"content by {judge}"] = float(
                np.mean([r[f"{judge} content"] == r["content"] for r in of]))
        ours, contents = (sum(r["style distance"] for r in rows if r["system"] == s)
                          for s in (system, "content"))
        count = sum(r["system"] == "content" for r in rows)
        line["style distance left"] = float(
            (ours / len(of)) / (contents / count)) if count and contents else float("nan")
        line["Fréchet distance"] = float(
            np.mean([d for (_, s), d in distances.items() if s == system]))
        for key in ("content distance", "skate", "sinks", "path error"):
            line[key] = float(np.nanmean([r[key] for r in of])) if key in of[0] else float("nan")
        for key in ("sinks at most", "bone error"):
            line[key] = float(np.max([r[key] for r in of])) if key in of[0] else float("nan")
        line["jerk / real"] = float(np.mean([r["jerk"] / real[r["style"]] for r in of]))
        took = [r for r in of if "seconds" in r]
        line["frames/s"] = sum(r["frames"]
                               for r in took) / sum(r["seconds"]
                                                    for r in took) if took else float("nan")
        lines.append(line)
    return lines


def frechet_distances(windows, reference):
    """windows : {(style, system): list of (n, d)}, reference : {style: list of (n, d)}, both
    embedded by the judge of joints   ->  {(style, system): float}
    """
    return {(style, system): frechet_distance(np.concatenate(points),
                                              np.concatenate(reference[style]))
            for (style, system), points in windows.items()}


def table_1(features, contacts, exemplars, style, frames=FRAMES, repeats=5, settings=Settings(), *,
            network=None):
    """Table 1: seconds at several lengths in one run, medians, the clip repeated or cut to length.
    What is timed, always from features to features:

    - "2016, as coded": `holden2016.search.transfer` with all 350 iterations, encoding of content,
      style and noise included, on `network`, in plain text;
    - "2016, own form": `holden2016.own.optimise` with as many, on the style's loss network, with
      the fast convolutions;
    - "2017": P(T(I)), `transfer.stylise`, with the fast convolutions.

    None reads, writes or cleans up.
    ->  list of {"frames", a system: seconds, "ratio": 2016 in its own form over 2017}
    """
    lines = []
    for count in frames:
        times = -(-count // len(features))
        X, planted = (np.tile(a, (times, 1))[:count] for a in (features, contacts))
        works = {
            OWN: lambda: optimise(X, planted, exemplars, style.manifold, settings=settings,
                                  networks=networks),
            "2017": lambda: stylise(X, style, networks=networks)}
        if network is not None:
            works = {CODED: coded_search(X, planted, exemplars[0], network, settings), **works}
        seconds = {name: [] for name in works}
        works["2017"]()
        for _ in range(repeats):
            for name, work in works.items():
                began = time.perf_counter()
                work()
                seconds[name].append(time.perf_counter() - began)
        medians = {name: float(np.median(s)) for name, s in seconds.items()}
        lines.append({"frames": count, **medians, "ratio": medians[OWN] / medians["2017"]})
    return lines


def coded_search(features, contacts, exemplar, network, settings):
    """The search of the 2016 code over rows made of features, ready to be called."""
    size = bridge.unit_of(decode(features, Start()))
    content = bridge.to_rows(scale(pairs(features), size), pairs(contacts))
    style = bridge.to_rows(scale(pairs(exemplar), size))[:rows.WINDOW]
    start = search.noise(np.random.default_rng(0), len(content))
    return lambda: search.transfer(content, style, network.params, network.normaliser, start=start,
                                   iterations=settings.iterations,
                                   constraint_iterations=settings.constraint_iterations)


def projection_effect(clips, style, leg, *, noise=0.3, seed=0):
    """Figure 2: what projection does to what T makes of contents, and to real motion with noise on
    its joints.

    clips : of Labelled, leg : of their dataset;  noise : in deviations of the normaliser
    ->  list of {"what", "bone error" of a bone's length, "error" (of real motion with noise: root
    mean square of a joint, in the unit of the data), "jerk / clean"}
    """
    manifold, rng = style.manifold, np.random.default_rng([seed, 5])
    contents = [to_scale(c.features, leg, manifold.leg) for c in clips]
    corrupted = []
    for features in contents:
        spoilt = features.copy()
        spoilt[:, POSITIONS] += (noise * manifold.normaliser.deviation[POSITIONS]
                                 * rng.standard_normal((len(features), POSITIONS.stop)))
        corrupted.append(spoilt)
    lines = []
    for what, motions, clean in (("T(I)", [stylise(f, style, projected=False, networks=networks)
                                           for f in contents], None),
                                 (f"real motion and noise of {noise:g}", corrupted, contents)):
        for name, versions in ((what, motions), (f"{what}, projected",
                                                 [project_features(m, manifold, networks=networks)
                                                  for m in motions])):
            positions = [decode(m, Start()) for m in _with_root(versions, motions)]
            real = [decode(f, Start()) for f in contents]
            bones = np.concatenate([
                np.abs(_lengths(p) / manifold.bones - 1).ravel() for p in positions])
            errors = [v[:, POSITIONS] - c[:, POSITIONS]
                      for v, c in zip(versions, clean)] if clean else []
            lines.append({
                "what": name, "bone error": float(bones.mean()), "error": float(
                    np.sqrt(3 * np.mean(np.concatenate(errors)**2))) if errors else float("nan"),
                "jerk / clean": float(
                    np.mean([
                        jerk(p, range(JOINTS), recorded=c.fps)
                        / jerk(r, range(JOINTS), recorded=c.fps)
                        for p, r, c in zip(positions, real, clips)]))})
    return lines


def _with_root(versions, motions):
    """Each version with the root velocities of its motion, as `transfer` has it."""
    return [np.concatenate([v[:, POSITIONS], m[:, VELOCITIES]], axis=1)
            for v, m in zip(versions, motions)]
