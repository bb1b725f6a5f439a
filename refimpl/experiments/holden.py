r"""What the recipe of training does: how P mends motion, what each reading of equations 4 and 5 leaves of a style, and how path and
style are traded.

Everything is measured before any clean-up, on takes that nothing learnt on, jerk at the clip's own rate (brought to 60 frames a second
from 30, a clip has no jerk of its own above 15 Hz). A style is measured by a *referee*, a loss network that no transfer saw, and beside
each share stand its nulls: the content itself, another real take of the style.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
import re
from typing import Any

import numpy as np

from ..holden2017.judges import Judge, fit_judge, joint_vectors
from ..holden2017.lesson import Lesson, make_lesson, normalised_windows
from ..holden2017.measure import style_distance
from ..holden2017.model import Manifold, Style
from ..holden2017.total import Weights
from ..holden2017.train import train_autoencoder, train_style
from ..holden2017.transfer import project_features, stylise
from ..motion.dataset import Dataset, Labelled, assemble, to_scale
from ..motion.features import POSITIONS, TRANSLATION, VELOCITIES, Start, decode, path_error, path_length
from ..motion.footing import foot_skate, jerk
from ..motion.joints import BONES, JOINTS
from ..motion.prepare import fit_normaliser
from ..motion.take import Take

NOISE = 3.0                                           # centimetres an axis, on a body with a leg of 80


@dataclass(frozen=True)
class Ground:
    """Clips and what each is for.

    dataset : Dataset, the test's contents and styles held out;
    learn, judge : regular expressions: whose names T learns on, and whose the judge
    """

    dataset: Dataset
    learn: str
    judge: str

    def kept_out(self, style: str) -> tuple[Labelled, ...]:
        return self.dataset.select(style=style, held_out=True)


def ground(takes: Mapping[str, Take], labels: Mapping[str, tuple[str, str]], source: str, *,
           kept_out: str, learn: str, judge: str) -> Ground:
    """takes : {name: Take};  labels : {name: (content, style)};  kept_out : a regular expression"""
    dataset = assemble(takes.items(), labels, source, 0.0)
    clips = tuple(replace(c, held_out=bool(re.search(kept_out, c.name))) for c in dataset.clips)
    return Ground(replace(dataset, clips=clips), learn, judge)


def learn_manifold(ground: Ground, *, depooling: str = "random", form: str = "groups", seed: int = 0,
                   hidden: int = 256, epochs: int = 80, dropout: float = 0.02,
                   report: Callable[[str], None] = lambda line: None) -> Manifold:
    """A loss network of all clips that are not held out."""
    clips = ground.dataset.select(held_out=False)
    frames, contacts = (np.concatenate([getattr(c, part) for c in clips])
                        for part in ("features", "contacts"))
    normaliser = fit_normaliser(frames, ground.dataset.source, contacts=contacts, form=form)
    X = normalised_windows(clips, normaliser)
    params = _last(train_autoencoder(X, epochs=epochs, depooling=depooling, dropout=dropout,
                                     hidden=hidden, seed=seed), report)
    return Manifold(params, normaliser, ground.dataset.leg, ground.dataset.bones, depooling)


def lesson_of(ground: Ground, manifold: Manifold, style: str) -> tuple[Lesson, dict[str, list]]:
    """What T learns this style on: contents of all styles.   ->  Lesson, {content: exemplars}"""
    everyone = ",".join(ground.dataset.styles)
    lesson, _, exemplars = make_lesson(ground.dataset, manifold, style, content_style=everyone,
                                       clips=ground.learn, exemplars=ground.learn)
    return lesson, exemplars


def learn_style(lesson: Lesson, manifold: Manifold, name: str, weights: Weights, *,
                channels: int = 128, epochs: int = 100, seed: int = 0,
                report: Callable[[str], None] = lambda line: None) -> Style:
    """weights : for centimetres"""
    weights = weights.fitted(manifold.leg, len(manifold.params["b0"]))
    params = _last(train_style(lesson, manifold, epochs=epochs, weights=weights, channels=channels,
                               seed=seed), report)
    return Style(params, manifold, name, lesson.pairs, lesson.learned, lesson.exemplars, weights,
                 lesson.known)


def _last(epochs: Iterator[Any], report: Callable[[str], None]) -> dict[str, np.ndarray]:
    for record, state in epochs:
        report(f"epoch {record.epoch}: loss {record.losses['loss']:.4g}")
    return state.params


def projection(ground: Ground, manifold: Manifold, clips: Sequence[Labelled], *,
               seed: int = 0) -> dict[str, float]:
    """P of real motion and of real motion with noise: means over the clips.

    ->  error and noisy error (mean distance of a joint from where it was, in a body with a leg of 80),
    jerk and noisy jerk (of the clip's own), path (mean distance, in such a body), noise jerk (before)
    """
    rng, rows = np.random.default_rng([seed, 6]), []
    for clip in clips:
        X = to_scale(clip.features, ground.dataset.leg, manifold.leg)
        cm = 80.0 / manifold.leg
        noisy = X.copy()
        noisy[:, POSITIONS] += NOISE / cm * rng.standard_normal((len(X), POSITIONS.stop))
        PX, PN = project_features(X, manifold), project_features(noisy, manifold)
        own = own_jerk(X, clip.fps)
        rows.append({"error": cm * _off(PX, X), "jerk": own_jerk(_with_root(PX, X), clip.fps) / own,
                     "path": cm * path_error(PX, X)[0], "noisy error": cm * _off(PN, X),
                     "noisy jerk": own_jerk(_with_root(PN, X), clip.fps) / own,
                     "noise jerk": own_jerk(noisy, clip.fps) / own})
    return {key: float(np.mean([row[key] for row in rows])) for key in rows[0]}


def transfers(ground: Ground, style: Style, exemplars: dict[str, list], contents: Sequence[Labelled],
              referee: Manifold, judge: Judge) -> list[dict[str, Any]]:
    """What a style makes of held-out contents, P(T(I)) with the root of T(I), one row a content."""
    rows = []
    for clip in contents:
        X = to_scale(clip.features, ground.dataset.leg, style.manifold.leg)
        T = stylise(X, style, projected=False)
        O = _with_root(project_features(T, style.manifold), T)
        rows.append({"content": clip.content, **look(ground, O, clip, style.name, exemplars, referee, judge),
                     **_compared(ground, O, X, clip, style.manifold)})
    return rows


def look(ground: Ground, O: np.ndarray, clip: Labelled, style: str, exemplars: dict[str, list],
         referee: Manifold, judge: Judge) -> dict[str, Any]:
    """Style distance by the referee, what the judge sees, jerk beside real takes of the style."""
    shown = exemplars[clip.content]
    real = [(to_scale(c.features, ground.dataset.leg, referee.leg), c.fps) for c in ground.dataset.clips
            if (c.style, c.content) == (style, clip.content)]
    content = style_distance(to_scale(clip.features, ground.dataset.leg, referee.leg), shown, referee)
    seen = judge.verdict(O)
    return {"left": style_distance(O, shown, referee) / content, "seen": seen[0] == style,
            "content seen": seen[1] == clip.content,
            "jerk": own_jerk(O, clip.fps) / np.median([own_jerk(f, fps) for f, fps in real])}


def _compared(ground: Ground, O: np.ndarray, X: np.ndarray, clip: Labelled,
              manifold: Manifold) -> dict[str, Any]:
    """Beside the content: path, speed, bones, feet."""
    cm, positions = 80.0 / manifold.leg, decode(O, Start())
    path = cm * path_error(O, X)[0]
    way = cm * path_length(X)
    j1, j2 = np.array(BONES).T
    bones = np.linalg.norm(positions[:, j1] - positions[:, j2], axis=-1)
    speeds = [np.linalg.norm(f[:, TRANSLATION], axis=1).mean() for f in (O, X)]
    return {"path": path, "way": way, "met": path <= 0.05 * way + 8.0,
            "speed": float(speeds[0] / speeds[1]), "skate": cm * foot_skate(positions, clip.contacts),
            "bones": float(np.abs(bones / manifold.bones - 1).mean())}


def fit_referee_judge(ground: Ground, manifold: Manifold) -> Judge:
    """The judge of joints, on clips that T does not learn on and that are not held out."""
    clips = [c for c in ground.dataset.select(held_out=False) if re.search(ground.judge, c.name)]
    return fit_judge([(to_scale(c.features, ground.dataset.leg, manifold.leg), c.style, c.content)
                      for c in clips], joint_vectors)


def own_jerk(features: np.ndarray, fps: float) -> float:
    """Jerk at the clip's own rate, of all joints in the character's frame and of its path."""
    return jerk(decode(features, Start()), range(JOINTS), recorded=fps)


def _off(found: np.ndarray, wanted: np.ndarray) -> float:
    apart = (found - wanted)[:, POSITIONS].reshape(len(found), JOINTS, 3)
    return float(np.linalg.norm(apart, axis=-1).mean())


def _with_root(moved: np.ndarray, root: np.ndarray) -> np.ndarray:
    result = moved.copy()
    result[:, VELOCITIES] = root[:, VELOCITIES]
    return result
