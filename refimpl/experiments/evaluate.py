"""What the paper leaves to the eye: content, the results of 2016 and of 2017, and real takes of
the style, measured side by side.

Everything is measured on the clip that was written and read again, on its own skeleton, after the
clean-up. The classifiers never saw a clip that a transfer learnt on, took its style from or had for
its content; `classifier_clips` makes sure of it.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
import functools
from pathlib import Path
import time
from typing import Any

import numpy as np

from ..fast import networks
from ..holden2016 import bridge, rows, search
from ..holden2016.own import Settings, optimise, pairs, stylised_features
from .classifiers import Classifier, fit_classifier, frechet_distance, gram_vectors, joint_vectors
from .holden import TableRow, bone_errors, own_jerk, with_root
from .measures import content_distance, style_distance
from .score import Track, compare, read_motion, summary
from ..holden2017.trained import Manifold, Style
from ..holden2017.transfer import project_features, stylise, transfer
from ..motion.stylised import Stylised, onto_skeleton
from ..motion.bvh import write_bvh
from ..motion.body import Take, seen, to_scale
from ..motion.clip import Clip
from ..motion.dataset import Dataset, Labelled, features_on
from ..motion.features import POSITIONS, Start, decode, scale

CODED, OWN = "2016, as coded", "2016, own form"
SYSTEMS = ("content", CODED, OWN, "2017 T(I), raw", "2017", "2017, own pace", "real")
TIMED_FRAMES = (240, 480, 960)
_JERK = "jerk (legs/s^3)"


class EvaluationError(ValueError):
    """Clips or models that do not make an evaluation; the message says what is missing."""


def classifier_clips(dataset: Dataset, styles: Sequence[Style],
                     content_style: str = "normal") -> list[Labelled]:
    """Clips for the classifiers: not held out, of these styles or of the contents', and in no
    transfer's hands.   Raises EvaluationError where a style or a content has none left.
    """
    used = {name for style in styles for name in (*style.learned, *style.exemplars)}
    names = {style.name for style in styles} | {content_style}
    contents = {content for style in styles for content in style.pairs}
    found = [c for c in dataset.clips if not c.held_out and c.name not in used
             and c.style in names and c.content in contents]
    for what, wanted, there in (("style", names, {c.style for c in found}),
                                ("content", contents, {c.content for c in found})):
        missing = sorted(wanted - there)
        if missing:
            raise EvaluationError(
                f"judges: found no clip of {what} {', '.join(missing)} that the style networks did "
                "not learn on, needed some to fit the judges on; train with --clips and "
                "--exemplars that leave some")
    return found


def fit_classifiers(clips: Sequence[Labelled], manifold: Manifold,
                    leg: float) -> dict[str, Classifier]:
    """The classifiers "gram", by Gram matrices, and "joints", by joints.   leg : of the clips."""
    labelled = [(to_scale(c.features, leg, manifold.leg), c.style, c.content) for c in clips]
    return {"gram": fit_classifier(labelled, functools.partial(gram_vectors, manifold=manifold)),
            "joints": fit_classifier(labelled, joint_vectors)}


def exemplars_of(dataset: Dataset, style: Style, content: str) -> list[np.ndarray]:
    """The features (T, 66) that a style's network had for this content, on its manifold's scale."""
    wanted = [c for c in dataset.clips
              if c.name in set(style.exemplars) and c.content == style.pairs[content]]
    if not wanted:
        raise EvaluationError(f"style {style.name!r}: found none of its exemplars for {content!r} "
                              "in the dataset, needed those it was trained with")
    return [to_scale(c.features, dataset.leg, style.manifold.leg) for c in wanted]


def carry_out(take: Take, exemplars: Sequence[np.ndarray], style: Style,
              settings: Settings = Settings(), *, network: bridge.Network | None = None,
              seed: int = 0) -> Iterator[tuple[str, Stylised, float]]:
    """Every system on one content.

    settings : of the 2016 system in its own form here, on the style's loss network;
    network : `holden2016.bridge.Network` for that system as coded, with the first exemplar as its
    style
    ->  yields (system, Stylised, seconds that its mathematics took, without reading and writing)
    """
    manifold, there = style.manifold, seen(take, style.manifold.body)
    content = there.features
    stylise(content, style, networks=networks)             # its spectra are kept for all clips
    if network is not None:
        yield CODED, *_timed(lambda: bridge.transfer(
            take, decode(exemplars[0], Start()), network, clean=False, seed=seed))
    moved, seconds = _timed(lambda: stylised_features(
        there, take.contacts, exemplars, manifold, settings, seed=seed, networks=networks))
    yield OWN, onto_skeleton(take, there, moved), seconds
    _, seconds = _timed(lambda: stylise(content, style, networks=networks))
    yield "2017 T(I), raw", transfer(
        take, style, projected=False, clean=False, networks=networks), seconds
    yield "2017", transfer(take, style, networks=networks), seconds
    yield "2017, own pace", transfer(take, style, own_pace=True, networks=networks), seconds


def _timed(work):
    """->  what it makes, and how many seconds it takes"""
    began = time.perf_counter()
    made = work()
    return made, time.perf_counter() - began


def read_back(clip: Clip, path: str | Path) -> Track:
    """Write a clip and read it again."""
    write_bvh(path, clip)
    return read_motion(path)


def measure(result: Track, content: Track, exemplars: Sequence[np.ndarray], manifold: Manifold,
            classifiers: Mapping[str, Classifier]) -> TableRow:
    """What `score` says of a result that was read again, and what networks see of it.

    exemplars : features on the manifold's scale;  classifiers : of `fit_classifiers`
    """
    features, wanted = (seen_by(manifold, m) for m in (result, content))
    return {**_looks(features, exemplars, manifold, classifiers), **compare(result, content),
            "content distance": content_distance(features, wanted, manifold)}


def seen_by(manifold: Manifold, motion: Track) -> np.ndarray:
    """A motion on the body that networks know.   ->  (T, 66)"""
    return features_on(motion.positions, manifold.body, motion.contacts)


def measure_real(clip: Labelled, leg: float, exemplars: Sequence[np.ndarray], manifold: Manifold,
                 classifiers: Mapping[str, Classifier]) -> TableRow:
    """The same of a real take of the style, from its features, where it can be said without a
    content.   leg : of the clip's dataset
    """
    features = to_scale(clip.features, leg, manifold.leg)
    motion = Track(decode(features, Start()), clip.contacts, 0.0, clip.fps)
    own = {key: value for key, value in compare(motion, motion).items()
           if key.startswith(("slide", "jerk", "lowest", "largest")) and "of content" not in key}
    return {**_looks(features, exemplars, manifold, classifiers), **own}


def _looks(features, exemplars, manifold, classifiers):
    found = {name: classifier.classify(features) for name, classifier in classifiers.items()}
    return {"style distance": style_distance(features, exemplars, manifold),
            "frames": len(features),
            **{f"{name} style": style for name, (style, _) in found.items()},
            **{f"{name} content": content for name, (_, content) in found.items()}}


def summarise_systems(rows: Sequence[TableRow],
                      windows: Mapping[tuple[str, str], Sequence[np.ndarray]],
                      reference: Mapping[str, Sequence[np.ndarray]]) -> list[dict[str, Any]]:
    """One line a system: `score.summary`, and what needs other rows.

    rows : of `measure` with style, content and system;  windows : {(style, system): list of
    (n, d)}, reference : {style: list of (n, d)} of real motion, both embedded by the classifier of
    joints
    """
    real = {style: np.mean([r[_JERK] for r in rows if r["style"] == style and r["system"] == "real"]
                           or [np.nan]) for style in {r["style"] for r in rows}}
    of_system = {system: [r for r in rows if r["system"] == system] for system in SYSTEMS}
    lines = []
    for system, of in of_system.items():
        if not of:
            continue
        told = [{**r, **{f"{what} by {name}": r[f"{name} {what}"] == r[what]
                         for name in ("gram", "joints") for what in ("style", "content")},
                 "jerk / real": r[_JERK] / real[r["style"]]} for r in of]
        ours, contents = (np.mean([r["style distance"] for r in rs])
                          for rs in (of, of_system["content"]))
        took = [r for r in of if "seconds" in r]
        distances = [frechet_distance(np.concatenate(points), np.concatenate(reference[style]))
                     for (style, who), points in windows.items()
                     if who == system and style in {r["style"] for r in of}]
        lines.append({"system": system, "clips": len(of), **summary(told, "style"),
                      "style distance left": float(ours / contents) if contents else float("nan"),
                      "Fréchet distance": float(np.mean(distances)) if distances else float("nan"),
                      "frames/s": (sum(r["frames"] for r in took) / sum(r["seconds"] for r in took)
                                   if took else float("nan"))})
    return lines


def timings(features: np.ndarray, contacts: np.ndarray, exemplars: Sequence[np.ndarray],
            style: Style, frames: Sequence[int] = TIMED_FRAMES, repeats: int = 5,
            settings: Settings = Settings(), *,
            network: bridge.Network | None = None) -> list[dict[str, Any]]:
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
        works: dict[str, Any] = {OWN: lambda: optimise(X, planted, exemplars, style.manifold,
                                                       settings=settings, networks=networks),
                                 "2017": lambda: stylise(X, style, networks=networks)}
        if network is not None:
            works = {CODED: coded_search(X, planted, exemplars[0], network, settings), **works}
        seconds: dict[str, list[float]] = {name: [] for name in works}
        works["2017"]()
        for _ in range(repeats):
            for name, work in works.items():
                seconds[name].append(_timed(work)[1])
        medians = {name: float(np.median(s)) for name, s in seconds.items()}
        lines.append({"frames": count, **medians, "ratio": medians[OWN] / medians["2017"]})
    return lines


def coded_search(features: np.ndarray, contacts: np.ndarray, exemplar: np.ndarray,
                 network: bridge.Network, settings: Settings) -> Callable[[], search.Found]:
    """The search of the 2016 code over rows made of features, ready to be called."""
    size = bridge.unit_of(decode(features, Start()))
    content = bridge.to_rows(scale(pairs(features), size), pairs(contacts))
    style = bridge.to_rows(scale(pairs(exemplar), size))[:rows.WINDOW]
    start = search.noise(np.random.default_rng(0), len(content))
    return lambda: search.transfer(content, style, network.params, network.normaliser, start=start,
                                   iterations=settings.iterations,
                                   constraint_iterations=settings.constraint_iterations)


def projection_effect(clips: Sequence[Labelled], style: Style, leg: float, *, noise: float = 0.3,
                      seed: int = 0) -> list[dict[str, Any]]:
    """Figure 2: what projection does to what T makes of contents, and to real motion with noise on
    its joints.

    leg : of the clips' dataset;  noise : in standard deviations of the normaliser
    ->  list of {"what", "bone error" of a bone's length, "error" (of real motion with noise: root
    mean square of a joint, in the unit of the data), "jerk / clean"}
    """
    manifold, rng = style.manifold, np.random.default_rng([seed, 5])
    contents = [to_scale(c.features, leg, manifold.leg) for c in clips]
    corrupted = []
    for features in contents:
        spoilt, deviation = features.copy(), manifold.normaliser.deviation[POSITIONS]
        spoilt[:, POSITIONS] += noise * deviation * rng.standard_normal((len(features),
                                                                         POSITIONS.stop))
        corrupted.append(spoilt)
    lines = []
    for what, motions, clean in (("T(I)", [stylise(f, style, projected=False, networks=networks)
                                           for f in contents], []),
                                 (f"real motion and noise of {noise:g}", corrupted, contents)):
        projected = [project_features(m, manifold, networks=networks) for m in motions]
        for name, versions in ((what, motions), (f"{what}, projected", projected)):
            shown = [with_root(v, m) for v, m in zip(versions, motions)]
            bones = [bone_errors(decode(m, Start()), manifold.bones).ravel() for m in shown]
            errors = [v[:, POSITIONS] - c[:, POSITIONS] for v, c in zip(versions, clean)]
            jerks = [own_jerk(m, c.fps) / own_jerk(f, c.fps)
                     for m, f, c in zip(shown, contents, clips)]
            lines.append({
                "what": name, "bone error": float(np.concatenate(bones).mean()),
                "error": (float(np.sqrt(3 * np.mean(np.concatenate(errors) ** 2)))
                          if errors else float("nan")), "jerk / clean": float(np.mean(jerks))})
    return lines
