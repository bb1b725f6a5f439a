r"""What the networks are trained on: windows of the dataset, and for each window the style it
should take (section "Style": pairing).

Each style is a set of exemplar clips labelled by content; a training window of a walk is paired
with the walk in that style.
"""

from dataclasses import dataclass, field
import re

import numpy as np

from ..motion.body import to_scale
from ..motion.features import VELOCITIES
from ..motion.windows import windows
from ..nn import tiled
from .known import Known, known
from .losses import style_target
from .networks import encode
from .objective import Batch


class LessonError(ValueError):
    """The dataset holds no such clips; the message says which were looked for and what there is."""


def normalised_windows(clips, normaliser, dtype=np.float32):
    """All windows of some clips, as the networks take them.   clips : of Labelled  ->  (N, 66, T)
    """
    cut = np.concatenate([windows(clip.features, clip.contacts)[0] for clip in clips])
    return np.ascontiguousarray(normaliser.apply(cut).swapaxes(1, 2), dtype=dtype)


@dataclass(frozen=True)
class Lesson:
    """The training data of a style network: N windows and, for each, the style it should take.

    X : (N, 66, T) normalised;  contacts : (N, 4, T);  trajectory : (N, 3, T) denormalised
    velocities of the input;
    grams : {content: style target (m, m) for T // 2 hidden frames};  contents : N labels, keys of
    grams;  bones : (20,);
    learned, exemplars : names of the clips it is made of;  pairs : {content: content of its
    exemplars};  known : what the style will have seen.
    """

    X: np.ndarray
    contacts: np.ndarray
    trajectory: np.ndarray
    grams: dict
    contents: tuple
    bones: np.ndarray
    learned: tuple = ()
    exemplars: tuple = ()
    pairs: dict = field(default_factory=dict)
    known: Known | None = None


def batch_of(lesson, indices):
    """Some windows of a lesson with all that their result is compared with.
    indices : (B,)  ->  Batch
    """
    return Batch(lesson.X[indices], tuple(lesson.grams[lesson.contents[i]] for i in indices),
                 lesson.contacts[indices], lesson.bones, lesson.trajectory[indices])


def gram_targets(exemplars, manifold, frames, *, kernels=tiled):
    """Style targets by content.
    exemplars : {content: list of features (T, 66)}, frames : of a window  ->  {content: (m, m)}
    """
    return {
        content: style_target(
            [encode(manifold.network_input(f), manifold.params, kernels=kernels)[0]
             for f in clips], frames // 2) for content, clips in exemplars.items()}


def pair_contents(contents, exemplar_contents):
    """Which exemplar each content is paired with: the one of the same name, or of its beginning
    ("walk-turn-left" with "walk").

    ->  {content: exemplar content}.
    Raises LessonError that names the contents without an exemplar.
    """
    pairs = {}
    for content in sorted(set(contents)):
        words = content.split("-")
        candidates = ["-".join(words[:n]) for n in range(len(words), 0, -1)]
        match = next((name for name in candidates if name in exemplar_contents), None)
        if match is None:
            raise LessonError(
                f"found no style exemplar for content {content!r} among "
                f"{', '.join(sorted(exemplar_contents)) or 'none'}, "
                "needed one of that content or of the beginning of its name; pair it by hand or "
                "leave that content out")
        pairs[content] = match
    return pairs


def choose(clips, pattern):
    """The clips in whose name the regular expression is found; all without one.
    Raises LessonError on a bad expression.
    """
    try:
        return tuple(clip for clip in clips if pattern is None or re.search(pattern, clip.name))
    except re.error as error:
        raise LessonError(
            f"pattern {pattern!r}: found {error}, needed a regular expression") from None


def make_lesson(dataset, manifold, style, *, content_style="normal", clips=None, exemplars=None,
                contents=None, pairs=None, kernels=tiled):
    """Everything that training one style needs.

    dataset : Dataset;  style : a label of it;  content_style : one or several labels, joined by
    commas, of the clips to learn on;
    clips, exemplars : regular expressions that choose among the names;
    contents : labels to train for (all);  pairs : {content: exemplar content} where names alone do
    not pair them
    ->  Lesson, held-out content clips, {content: list of exemplar features (T, 66)} for each
    content of the lesson
    Raises LessonError when no exemplar or no content clip is left.
    """
    shown = choose(dataset.select(style=style, held_out=False), exemplars)
    if not shown:
        raise LessonError(
            f"found no exemplar of style {style!r}{_by(exemplars)}, needed at least one; "
            f"the styles of this dataset are {', '.join(dataset.styles)}")
    sources = content_style.split(",")
    for name in sources:
        if name not in dataset.styles:
            raise LessonError(
                f"found no clip of style {name!r} to train on, needed one of the styles of this "
                f"dataset: {', '.join(dataset.styles)}")
    chosen = [
        c for c in choose([c for c in dataset.clips if c.style in sources], clips)
        if contents is None or c.content in contents]
    learned = [c for c in chosen if not c.held_out]
    if not learned:
        raise LessonError(
            f"found no clip of style {content_style!r}{_by(clips)} to train on, needed at least "
            "one; "
            f"the styles of this dataset are {', '.join(dataset.styles)}")
    by_content = {}
    for clip in shown:
        by_content.setdefault(clip.content,
                              []).append(to_scale(clip.features, dataset.leg, manifold.leg))
    pairs = pairs or {}
    for content, exemplar in pairs.items():
        if exemplar not in by_content:
            raise LessonError(
                f"pair {content}={exemplar}: found no exemplar of content {exemplar!r}, needed one "
                f"of {', '.join(sorted(by_content))}")
    found = {
        **pair_contents({c.content for c in chosen if c.content not in pairs}, by_content), **pairs}
    paired = {
        content: by_content[found[content]] for content in sorted({c.content for c in chosen})}

    features, contacts, labels = [], [], []
    seen = [to_scale(clip.features, dataset.leg, manifold.leg) for clip in learned]
    for clip, scaled in zip(learned, seen):
        cut, planted = windows(scaled, clip.contacts)
        features.append(cut)
        contacts.append(planted)
        labels += [clip.content] * len(cut)
    # (N, 66, T)
    motion = np.concatenate(features).swapaxes(1, 2)
    dtype = manifold.params["W0"].dtype
    X = np.ascontiguousarray(
        manifold.normaliser.apply(motion.swapaxes(1, 2)).swapaxes(1, 2), dtype=dtype)
    lesson = Lesson(X,
                    np.concatenate(contacts).swapaxes(1, 2).astype(dtype),
                    motion[:, VELOCITIES].astype(dtype),
                    gram_targets(paired, manifold, X.shape[2],
                                 kernels=kernels), tuple(labels), manifold.bones,
                    tuple(c.name for c in learned),
                    tuple(c.name for c in shown if c.content in found.values()), found, known(seen))
    return lesson, tuple(c for c in chosen if c.held_out), paired


def _by(pattern):
    return "" if pattern is None else f" with {pattern!r} in its name"
