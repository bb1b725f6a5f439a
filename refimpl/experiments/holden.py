r"""What the recipe of training does: how P mends motion, what each reading of equations 4 and 5
leaves of a style, and how path and style are traded.

Everything is measured before any clean-up, on takes that nothing learnt on, jerk at the clip's own
rate (brought to 60 frames a second from 30, a clip has no jerk of its own above 15 Hz). A style is
measured by a *referee*, a loss network that no transfer saw, and beside each share stand its nulls:
the content itself, other real takes of the style.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
import re
from typing import Any

import numpy as np

from ..fast import networks
from ..fast.autoencoder import autoencoder_gradients
from ..fast.gradients import style_gradients
from .classifiers import Classifier, fit_classifier, joint_vectors
from ..holden2017.pairing import TrainingSet, make_training_set
from ..motion.windows import clean_windows
from .measures import style_distance
from ..holden2017.trained import Manifold, Style
from ..holden2017.objective import LEG, Weights
from ..holden2017.train import train_autoencoder, train_style
from ..holden2017.transfer import project_features, stylise
from ..motion.dataset import Dataset, Labelled, assemble
from ..motion.body import to_scale
from ..motion.features import (POSITIONS, TRANSLATION, VELOCITIES, Start, bone_lengths_by_frame,
                               decode, path_error, path_length)
from ..motion.feet import foot_skate, jerk
from ..motion.joints import JOINTS
from ..motion.body import Take

# All lengths are told for a body with legs of LEG centimetres.
NOISE = 3.0                                      # centimetres an axis
TableRow = dict[str, Any]


@dataclass(frozen=True)
class Ground:
    """Clips and what each is for.

    dataset : the test's contents and styles held out;  learn, classify : regular expressions: on
    the names that fit T learns and the classifier is fitted.
    """

    dataset: Dataset
    learn: str
    classify: str

    def kept_out(self, style: str) -> tuple[Labelled, ...]:
        """The clips of a style to measure on."""
        return self.dataset.select(style=style, held_out=True)

    def features(self, clip: Labelled, manifold: Manifold) -> np.ndarray:
        """On the scale of a loss network.   ->  (T, 66)"""
        return to_scale(clip.features, self.dataset.leg, manifold.leg)


def ground(takes: Mapping[str, Take], labels: Mapping[str, tuple[str, str]], source: str, *,
           kept_out: str, learn: str, classify: str) -> Ground:
    """The clips of some takes, those held out whose name fits the regular expression `kept_out`.

    labels : {name: (content, style)};  source : where they are from;  learn, classify : see Ground.
    """
    dataset = assemble(takes.items(), dict(labels), source, 0.0)
    clips = tuple(replace(c, held_out=bool(re.search(kept_out, c.name))) for c in dataset.clips)
    return Ground(replace(dataset, clips=clips), learn, classify)


def learn_manifold(ground: Ground, *, depooling: str = "random", form: str = "groups",
                   seed: int = 0, hidden: int = 256, epochs: int = 80) -> Manifold:
    """A loss network of all clips that are not held out."""
    clips = ground.dataset.select(held_out=False)
    X, normaliser = clean_windows(clips, ground.dataset.source, form=form)
    params = _last(train_autoencoder(X, epochs=epochs, depooling=depooling, hidden=hidden,
                                     seed=seed, gradients=autoencoder_gradients))
    return Manifold(params, normaliser, ground.dataset.leg, ground.dataset.bones, depooling,
                    ground.dataset.rest)


def lesson_of(ground: Ground, manifold: Manifold,
              style: str) -> tuple[TrainingSet, dict[str, list]]:
    """What T learns this style on: contents of all styles.

    ->  TrainingSet, {content: exemplars}
    """
    everyone = ",".join(ground.dataset.styles)
    lesson, _, exemplars = make_training_set(
        ground.dataset, manifold, style, content_style=everyone, clips=ground.learn,
        exemplars=ground.learn, networks=networks)
    return lesson, exemplars


def learn_style(lesson: TrainingSet, manifold: Manifold, name: str, weights: Weights, *,
                channels: int = 128, epochs: int = 100, seed: int = 0) -> Style:
    """A style network.   weights : for centimetres and 256 hidden units."""
    weights = weights.fitted(manifold.leg, len(manifold.params["b0"]))
    params = _last(train_style(lesson, manifold, epochs=epochs, weights=weights, channels=channels,
                               seed=seed, gradients=style_gradients))
    return lesson.style(params, manifold, name, weights)


def _last(epochs: Iterator[Any]) -> dict[str, np.ndarray]:
    *_, (_, state) = epochs
    return state.params


def projection(ground: Ground, manifold: Manifold, clips: Sequence[Labelled], *,
               seed: int = 0) -> dict[str, float]:
    """P of real motion and of real motion with noise: means over the clips, of the path the median.

    ->  error and noisy error (mean distance of a joint from where it was, cm), jerk, noisy jerk and
    noise jerk (before P), in units of the clip's own, path (mean distance of a clip's, cm)
    """
    rng, rows = np.random.default_rng([seed, 6]), []
    for clip in clips:
        X, cm = ground.features(clip, manifold), LEG / manifold.leg
        noisy = X.copy()
        noisy[:, POSITIONS] += NOISE / cm * rng.standard_normal((len(X), POSITIONS.stop))
        PX, PN = (project_features(x, manifold, networks=networks) for x in (X, noisy))
        own = own_jerk(X, clip.fps)
        rows.append({"error": cm * _off(PX, X), "jerk": own_jerk(with_root(PX, X), clip.fps) / own,
                     "path": cm * path_error(PX, X)[0], "noisy error": cm * _off(PN, X),
                     "noisy jerk": own_jerk(with_root(PN, X), clip.fps) / own,
                     "noise jerk": own_jerk(noisy, clip.fps) / own})
    paths = [row["path"] for row in rows]
    return {**{key: float(np.mean([row[key] for row in rows])) for key in rows[0]},
            "path": float(np.median(paths)), "path at most": float(np.max(paths))}


def style_row(ground: Ground, manifold: Manifold, style: str, weights: Weights, share: float,
              referee: Manifold, *, contents: str = "normal", channels: int = 128,
              epochs: int = 100, seed: int = 0) -> dict[str, float]:
    """Learn a style with these weights, its constraints times `share`, and measure it on held-out
    contents: medians over the clips, and shares of them for what is seen and met."""
    weights = replace(weights, foot=share * weights.foot, bone=share * weights.bone,
                      trajectory=share * weights.trajectory)
    lesson, exemplars = lesson_of(ground, manifold, style)
    made = learn_style(lesson, manifold, style, weights, channels=channels, epochs=epochs,
                       seed=seed)
    rows = transfers(ground, made, exemplars, ground.kept_out(contents), referee,
                     fit_joint_classifier(ground, manifold))
    shares = {key: float(np.mean([row[key] for row in rows]))
              for key in ("seen", "content seen", "met")}
    medians = {key: float(np.median([row[key] for row in rows])) for key in rows[0]
               if key != "content"}
    return medians | shares


def nulls(ground: Ground, style: str, contents: str,
          referee: Manifold) -> list[tuple[str, TableRow]]:
    """What the content itself, and real takes of the style that nobody learnt on, would get.

    ->  list of (who, numbers)
    """
    classifier = fit_joint_classifier(ground, referee)
    _, exemplars = lesson_of(ground, referee, style)
    real, own = ground.kept_out(style), ground.kept_out(contents)

    def _distance(clips):
        """Median style distance a frame: clips differ in length."""
        return np.median([style_distance(ground.features(c, referee), exemplars[c.content], referee)
                          / len(c.features) for c in clips])
    return [("content itself", {"left": 1.0, "seen": _seen(own, style, classifier), "path": 0.0,
                                "met": 1.0}),
            ("real takes", {"left": float(_distance(real) / _distance(own)),
                            "seen": _seen(real, style, classifier), "jerk": 1.0})]


def _seen(clips: Sequence[Labelled], style: str, classifier: Classifier) -> float:
    return float(np.mean([classifier.classify(clip.features)[0] == style for clip in clips]))


def transfers(ground: Ground, style: Style, exemplars: dict[str, list],
              contents: Sequence[Labelled], referee: Manifold,
              classifier: Classifier) -> list[TableRow]:
    """What a style makes of held-out contents, P(T(I)) with the root of T(I), one row a content."""
    rows = []
    for clip in contents:
        X = ground.features(clip, style.manifold)
        T = stylise(X, style, projected=False, networks=networks)
        O = with_root(project_features(T, style.manifold, networks=networks), T)
        rows.append({"content": clip.content,
                     **look(ground, O, clip, style.name, exemplars, referee, classifier),
                     **_compared(O, X, clip, style.manifold)})
    return rows


def look(ground: Ground, O: np.ndarray, clip: Labelled, style: str, exemplars: dict[str, list],
         referee: Manifold, classifier: Classifier) -> TableRow:
    """Style distance by the referee, what the classifier sees, jerk beside real takes of it."""
    shown = exemplars[clip.content]
    real = [own_jerk(ground.features(c, referee), c.fps) for c in ground.dataset.clips
            if (c.style, c.content) == (style, clip.content)]
    content = style_distance(ground.features(clip, referee), shown, referee)
    seen = classifier.classify(O)
    return {"left": style_distance(O, shown, referee) / content, "seen": seen[0] == style,
            "content seen": seen[1] == clip.content,
            "jerk": own_jerk(O, clip.fps) / np.median(real)}


def _compared(O: np.ndarray, X: np.ndarray, clip: Labelled, manifold: Manifold) -> TableRow:
    """Beside the content: path (met within 5 % of the way and 0.1 leg), speed, bones, feet."""
    cm, positions = LEG / manifold.leg, decode(O, Start())
    path, way = cm * path_error(O, X)[0], cm * path_length(X)
    speeds = [np.linalg.norm(f[:, TRANSLATION], axis=1).mean() for f in (O, X)]
    return {"path": path, "path / way": path / way, "met": path <= 0.05 * way + 0.1 * LEG,
            "speed": float(speeds[0] / speeds[1]),
            "skate": cm * foot_skate(positions, clip.contacts),
            "bones": float(bone_errors(positions, manifold.bones).mean())}


def fit_joint_classifier(ground: Ground, manifold: Manifold) -> Classifier:
    """The classifier by joints, on clips that T does not learn on and that are not held out."""
    return fit_classifier([(ground.features(c, manifold), c.style, c.content)
                           for c in ground.dataset.select(held_out=False)
                           if re.search(ground.classify, c.name)], joint_vectors)


def bone_errors(positions: np.ndarray, bones: np.ndarray) -> np.ndarray:
    """How far each bone is from its length, relative to it.   (T, 21, 3), (20,)  ->  (T, 20)

    >>> bone_errors(np.zeros((1, JOINTS, 3)), np.ones(20)).shape
    (1, 20)
    """
    return np.abs(bone_lengths_by_frame(positions) / bones - 1)


def own_jerk(features: np.ndarray, fps: float) -> float:
    """Jerk at the clip's own rate, of all joints in the world."""
    return jerk(decode(features, Start()), range(JOINTS), recorded=fps)


def _off(found: np.ndarray, wanted: np.ndarray) -> float:
    apart = (found - wanted)[:, POSITIONS].reshape(len(found), JOINTS, 3)
    return float(np.linalg.norm(apart, axis=-1).mean())


def with_root(moved: np.ndarray, root: np.ndarray) -> np.ndarray:
    """A motion with the root velocities of another, as `transfer` has it.   (T, 66) both

    >>> float(with_root(np.zeros((1, 66)), np.ones((1, 66))).sum())
    3.0
    """
    return np.concatenate([moved[:, POSITIONS], root[:, VELOCITIES]], axis=1)
