"""Judges that see no network: which style and which content does a motion have?

Two ways of seeing, two linear discriminants each (`classifiers`): one whose classes are styles of
whatever content, one whose classes are contents in whatever style, so that a style is known again
in a content in which no real clip shows it.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..motion.canonical import Physique
from ..motion.dataset import Dataset, Labelled, features_on
from ..motion.features import POSITIONS, decode
from ..motion.joints import BONES, JOINTS
from .classifiers import (Classifier, fit_classifier, frechet_distance, joint_vectors,
                          sliding_windows)
from .score import Track, ScoreError

PRINCIPAL = 100
QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)


def bone_vectors(features: np.ndarray) -> np.ndarray:
    """Where bones point: for each window quantiles of their directions, and logarithms of their
    mean speeds.   (T, 66), T >= 2  ->  (windows, 360)

    >>> bone_vectors(np.random.default_rng(0).normal(size=(200, 66))).shape
    (4, 360)
    """
    parents, children = np.array(BONES).T
    rows = []
    for window in sliding_windows(features):
        joints = window[:, POSITIONS].reshape(len(window), JOINTS, 3)
        bones = joints[:, children] - joints[:, parents]
        bones /= np.maximum(np.linalg.norm(bones, axis=-1, keepdims=True), 1e-12)
        flat = bones.reshape(len(window), -1)
        rows.append(np.concatenate([np.quantile(flat, QUANTILES, axis=0).ravel(),
                                    np.log(np.abs(np.diff(flat, axis=0)).mean(axis=0) + 1e-3)]))
    return np.array(rows)


SEES = {"joints": joint_vectors, "directions": bone_vectors}


@dataclass(frozen=True)
class Judges:
    """Who says what a motion looks like: for each way of seeing a classifier of styles, and one of
    contents.

    style, content : {way: Classifier};  body : on which motions are seen
    fitted, kept_back : labelled clips that the judges were fitted on, and that they did not see
    facts : what they were fitted on, with its hash
    """

    style: Mapping[str, Classifier]
    content: Mapping[str, Classifier]
    body: Physique
    fitted: tuple[Labelled, ...] = field(repr=False)
    kept_back: tuple[Labelled, ...] = field(repr=False)
    facts: dict[str, Any]
    _looked: dict[int, tuple[Track, Any]] = field(default_factory=dict, repr=False)

    def look(self, motion: Track) -> tuple[dict[str, str], np.ndarray]:
        """What `told` and `windows` say of a motion; once for each, since nulls show it again."""
        if id(motion) not in self._looked:
            features = features_on(motion.positions, self.body, motion.contacts)
            self._looked[id(motion)] = motion, (self.told(features), self.windows(features))
        return self._looked[id(motion)][1]

    def motion(self, clip: Labelled) -> Track:
        """One of the labelled clips as a motion, on the judges' body."""
        return Track(decode(clip.features), clip.contacts, 0.0, clip.fps)

    def told(self, features: np.ndarray) -> dict[str, str]:
        """Which style and content each judge sees.   (T, 66)  ->  {"style by joints": name, ...}"""
        return {f"{what} by {way}": judge.classify(features)[which]
                for which, what, judges in ((0, "style", self.style), (1, "content", self.content))
                for way, judge in judges.items()}

    def windows(self, features: np.ndarray) -> np.ndarray:
        """Where the judge of joints sees its windows, for Fréchet distances.   ->  (n, d)"""
        return self.style["joints"].embed(features)


def fit_judges(dataset: Dataset, **facts: Any) -> Judges:
    """Judges of labelled clips; those held out are kept back.

    facts : to be told of them: where they came from, their hash
    Raises ScoreError where there are fewer than two styles.
    """
    fitted, kept_back = (dataset.select(held_out=out) for out in (False, True))
    styles, contents = (sorted({getattr(clip, what) for clip in fitted})
                        for what in ("style", "content"))
    if len(styles) < 2:
        raise ScoreError(f"{dataset.source}: found clips of {len(styles)} style "
                         f"({', '.join(styles)}), needed at least two to tell apart")
    if dataset.rest is None:
        raise ScoreError(f"{dataset.source}: found clips without their body, needed those of this "
                         "version's `refimpl prepare`")

    def _fit(of, vectors):
        return fit_classifier([(c.features, *of(c)) for c in fitted], vectors, components=PRINCIPAL)
    style = {way: _fit(lambda c: (c.style, ""), see) for way, see in SEES.items()}
    content = ({way: _fit(lambda c: ("", c.content), see) for way, see in SEES.items()}
               if len(contents) > 1 else {})
    judges = Judges(style, content, Physique(dataset.rest), fitted, kept_back, {})
    right: dict[str, list[bool]] = {}
    for clip in kept_back:
        for what, name in judges.told(clip.features).items():
            right.setdefault(what, []).append(name == getattr(clip, what.split()[0]))
    judges.facts.update(
        facts, clips=len(fitted), styles=styles, contents=contents, kept_back=len(kept_back),
        right_on_kept_back={what: float(np.mean(of)) for what, of in right.items()})
    return judges


def frechet(judges: Judges, style: str, windows: Iterable[np.ndarray]) -> float:
    """Fréchet distance of motions to the real clips of a style that the judges were fitted on.
    windows : of `Judges.windows`
    """
    real = [judges.windows(c.features) for c in judges.fitted if c.style == style]
    return frechet_distance(np.concatenate(list(windows)), np.concatenate(real))
