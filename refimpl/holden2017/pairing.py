r"""What the networks are trained on: windows of the dataset, and for each window the style it
should take (section "Style").

Each style is a set of exemplar clips labelled by content; a training window of a walk is paired
with the walk in that style.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..motion.dataset import Dataset, Labelled
from ..motion.body import to_scale
from ..motion.features import VELOCITIES
from ..motion.windows import windows
from . import networks as text
from .trained import Manifold, Style
from ..motion.known import Known, known
from .losses import style_target
from .networks import Params
from .objective import Batch, Weights

Exemplars = dict[str, list[np.ndarray]]


class PairingError(ValueError):
    """The dataset holds no such clips; the message says which were looked for and what there is."""


@dataclass(frozen=True)
class TrainingSet:
    """What a style network is trained on: N windows and, for each, the style it should take.

    X : (N, 66, T) normalised;  contacts : (N, 4, T);  trajectory : (N, 3, T) denormalised
    velocities of the input
    grams : {content: style target (m, m) for T // 2 hidden frames};  contents : N of its keys
    bones : (20,);  learned, exemplars : names of the clips it is made of
    pairs : {content: content of its exemplars};  known : what the style will have seen
    """

    X: np.ndarray
    contacts: np.ndarray
    trajectory: np.ndarray
    grams: Mapping[str, np.ndarray]
    contents: tuple[str, ...]
    bones: np.ndarray
    learned: tuple[str, ...] = ()
    exemplars: tuple[str, ...] = ()
    pairs: Mapping[str, str] = field(default_factory=dict)
    known: Known | None = None

    def style(self, params: Params, manifold: Manifold, name: str,
              weights: Weights = Weights()) -> Style:
        """What was learnt on this set."""
        return Style(params, manifold, name, self.pairs, self.learned, self.exemplars, weights,
                     self.known)

    def batch(self, indices: np.ndarray) -> Batch:
        """Some windows with all that their result is compared with."""
        return Batch(self.X[indices], np.stack([self.grams[self.contents[i]] for i in indices]),
                     self.contacts[indices], self.bones, self.trajectory[indices],
                     rows=np.asarray(indices))


def gram_targets(exemplars: Exemplars, manifold: Manifold, frames: int, *,
                 networks: Any = text) -> dict[str, np.ndarray]:
    """Style targets by content.

    exemplars : {content: list of features (T, 66)};  frames : of a window;  networks : who
    computes `encode`   ->  {content: (m, m)}
    """
    return {content: style_target(
        [networks.encode(manifold.network_input(f), manifold.params)[0] for f in clips],
        frames // 2) for content, clips in exemplars.items()}


def pair_contents(contents: Iterable[str], exemplar_contents: Iterable[str]) -> dict[str, str]:
    """Which exemplar each content is paired with: the one of the same name, or of its beginning.

    ->  {content: exemplar content}.
    Raises PairingError that names a content without an exemplar.

    >>> pair_contents(["walk-turn-left", "jump"], ["walk", "jump"])
    {'jump': 'jump', 'walk-turn-left': 'walk'}
    """
    pairs, there = {}, set(exemplar_contents)
    for content in sorted(set(contents)):
        words = content.split("-")
        beginnings = ("-".join(words[:n]) for n in range(len(words), 0, -1))
        match = next((name for name in beginnings if name in there), None)
        if match is None:
            raise PairingError(
                f"found no style exemplar for content {content!r} among "
                f"{', '.join(sorted(there)) or 'none'}, needed one of that content or of the "
                "beginning of its name; pair it by hand or leave that content out")
        pairs[content] = match
    return pairs


def make_training_set(dataset: Dataset, manifold: Manifold, style: str, *,
                      content_style: str = "normal", clips: str | None = None,
                      exemplars: str | None = None, contents: Sequence[str] | None = None,
                      pairs: Mapping[str, str] | None = None, networks: Any = text,
                      ) -> tuple[TrainingSet, tuple[Labelled, ...], Exemplars]:
    """Everything that training one style needs.

    style : a label of the dataset;  content_style : one or several labels, joined by commas, of the
    clips to learn on;  clips, exemplars : regular expressions that choose among the names
    contents : labels to train for (all);  pairs : {content: exemplar content} where names alone do
    not pair them;  networks : as in `gram_targets`
    ->  TrainingSet, held-out content clips, {content: list of exemplar features (T, 66)}
    Raises PairingError when no exemplar or no content clip is left, LabelError for a pattern that
    is no regular expression.
    """
    shown = dataset.select(style=style, held_out=False, name=exemplars)
    if not shown:
        raise PairingError(
            f"found no exemplar of style {style!r}{_by(exemplars)}, needed at least one; "
            f"the styles of this dataset are {', '.join(dataset.styles)}")
    sources = content_style.split(",")
    unknown = [name for name in sources if name not in dataset.styles]
    chosen = [clip for clip in dataset.select(name=clips) if clip.style in sources
              and (contents is None or clip.content in contents)]
    learned = [clip for clip in chosen if not clip.held_out]
    if unknown or not learned:
        raise PairingError(
            f"found no clip of style {(unknown or [content_style])[0]!r}{_by(clips)} to train on, "
            f"needed at least one; the styles of this dataset are {', '.join(dataset.styles)}")
    by_content: Exemplars = {}
    for clip in shown:
        by_content.setdefault(clip.content, []).append(
            to_scale(clip.features, dataset.leg, manifold.leg))
    there, pairs = {clip.content for clip in chosen}, pairs or {}
    for content, exemplar in pairs.items():
        for what, name, names in ((f"clip of content {content!r} to train on", content, there),
                                  (f"exemplar of content {exemplar!r}", exemplar, by_content)):
            if name not in names:
                raise PairingError(f"pair {content}={exemplar}: found no {what}, needed one of "
                                   + ", ".join(sorted(names)))
    found = {**pair_contents(there - set(pairs), by_content), **pairs}
    paired = {content: by_content[found[content]] for content in sorted(there)}

    seen = [to_scale(clip.features, dataset.leg, manifold.leg) for clip in learned]
    cut = [windows(scaled, clip.contacts) for clip, scaled in zip(learned, seen)]
    motion, contacts_of = (np.concatenate(arrays) for arrays in zip(*cut))
    dtype = manifold.params["W0"].dtype
    X = manifold.normaliser.channels_first(motion, dtype)
    training_set = TrainingSet(
        X, contacts_of.swapaxes(1, 2).astype(dtype),
        motion[:, :, VELOCITIES].swapaxes(1, 2).astype(dtype),
        gram_targets(paired, manifold, X.shape[2], networks=networks),
        tuple(clip.content for clip, (some, _) in zip(learned, cut) for _ in some), manifold.bones,
        tuple(c.name for c in learned), tuple(c.name for c in shown if c.content in found.values()),
        found, known(seen, manifold.leg))
    return training_set, tuple(c for c in chosen if c.held_out), paired


def _by(pattern: str | None) -> str:
    return "" if pattern is None else f" with {pattern!r} in its name"
