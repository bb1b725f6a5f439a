r"""The paper's own problem: one exemplar a content, a style that the loss network never saw, takes
that nothing learnt on.

Clips are for one thing only, and where a style has a single take of a content it is cut in time:
its first `SHARE` is the exemplar, the rest is for the judges; of another take the first part is for
the judges, and the rest is the level to reach. Results are written as BVH, and `refimpl score`
tells them from those files alone. Beside the networks stand two cheap baselines:

    posture     the mean pose and the mean speed of the exemplar
    spectra     the exemplar's mean pose and smoothed magnitude spectra with the content's phases,
                after the spectral transfer of the papers' related work
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
import re
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d

from .. import nn
from ..fast import networks
from ..holden2017.objective import WEIGHTS
from ..holden2017.pairing import TrainingSet, make_training_set, pair_contents
from ..holden2017.trained import Manifold, Style
from ..holden2017.transfer import transfer
from ..motion.body import Take, make_take, seen
from ..motion.bvh import write_bvh
from ..motion.clip import Clip
from ..motion.dataset import Dataset, assemble
from ..motion.features import POSITIONS, TRANSLATION
from ..motion.stylised import onto_skeleton
from .holden import Ground, learn_manifold, learn_style
from .measures import style_distance

SHARE = 0.6                      # of a take's frames
SAME_FOR_JUDGES = {"dash": "run"}          # contents that tell the judges of another: a faster run
LARGEST_GAIN, SMOOTHED_BY = 4.0, 0.5      # of a magnitude, either way; Hz of the Gaussian
AS_IT_IS, OWN_PACE, RAW = "2017", "2017, own pace", "2017, no clean-up"
POSTURE, SPECTRA, OTHER_TAKE = "posture and speed moved", "spectra moved", "another real take"


@dataclass(frozen=True)
class Roles:
    """Regular expressions on the names of clips: what each is for. Loss networks learn on `learn`
    and `judge`, styles on `learn`, contents to try are in `test`.
    """

    learn: str
    judge: str
    test: str
    exemplar: str
    other: str


@dataclass(frozen=True)
class Split:
    """Takes by what they are for, {part: {name: Take}}, and {name: (content, style)} of all."""

    parts: Mapping[str, Mapping[str, Take]]
    labels: Mapping[str, tuple[str, str]]
    dataset: Dataset

    def names(self) -> dict[str, list[str]]:
        """Which clips are in which part."""
        return {part: sorted(takes) for part, takes in self.parts.items()}

    def exemplars(self, style: str) -> dict[str, str]:
        """The names of a style's exemplars, by content."""
        return {self.labels[name][0]: name for name in self.parts["exemplars"]
                if self.labels[name][1] == style}


def split(takes: Mapping[str, Take], labels: Mapping[str, tuple[str, str]], roles: Roles,
          styles: Sequence[str], contents: str, each: int = 2) -> Split:
    """Share the clips out.   each : contents to try of each label, the first by name"""
    parts: dict[str, dict[str, Take]] = {part: {} for part in (
        "learn", "loss", "judges", "exemplars", "real", "contents")}
    told = dict(labels)
    for name, take in sorted(takes.items()):
        content, style = labels[name]
        if style in styles:
            for role, *into in ((roles.exemplar, "exemplars", "judges"),
                                (roles.other, "judges", "real")):
                if re.search(role, name):
                    cut = round(SHARE * take.clip.frames)
                    for part, tag, rows in zip(into, "ab", (slice(None, cut), slice(cut, None))):
                        parts[part][name + tag] = make_take(replace(
                            take.clip, values=take.clip.values[rows]), name=name)
                        told[name + tag] = labels[name]
            if content in SAME_FOR_JUDGES and re.search(roles.judge, name):
                parts["judges"][name], told[name] = take, (SAME_FOR_JUDGES[content], style)
        elif re.search(roles.learn, name):
            parts["learn"][name] = parts["loss"][name] = take
        elif re.search(roles.judge, name):
            parts["judges"][name] = parts["loss"][name] = take
        elif re.search(roles.test, name) and style == contents and sum(
                labels[other][0] == content for other in parts["contents"]) < each:
            parts["contents"][name] = take
    every = {name: take for of in parts.values() for name, take in of.items()}
    return Split(parts, told, assemble(every.items(), {n: told[n] for n in every}, "split", 0.0))


def loss_network(split: Split, seed: int, **sizes: Any) -> Manifold:
    """A loss network that never saw the styles.   sizes : as in `holden.learn_manifold`"""
    clips = tuple(c for c in split.dataset.clips if c.name in split.parts["loss"])
    return learn_manifold(Ground(replace(split.dataset, clips=clips), "", ""), seed=seed, **sizes)


def style_network(split: Split, manifold: Manifold, style: str, seed: int, **sizes: Any) -> Style:
    """A style learnt from one exemplar a content.   sizes : as in `holden.learn_style`"""
    lesson = lesson_of_one(split, manifold, style)
    return learn_style(lesson, manifold, style, WEIGHTS["mean_squares"], seed=seed, **sizes)


def lesson_of_one(split: Split, manifold: Manifold, style: str) -> TrainingSet:
    """What T learns a style on."""
    shown = split.exemplars(style).values()
    clips = tuple(c for c in split.dataset.clips
                  if c.name in split.parts["learn"] or c.name in shown)
    learnt = sorted({c.style for c in clips if c.name in split.parts["learn"]} - {style})
    return make_training_set(replace(split.dataset, clips=clips), manifold, style,
                             content_style=",".join(learnt), networks=networks)[0]


def results(split: Split, styles: Mapping[int, Style], name: str
            ) -> Iterator[tuple[str, str, str, Callable[[], Clip]]]:
    """What is made of each content: by each seed's network, and by the first in other ways and by
    the baselines.

    styles : {seed: Style} of the style `name`
    ->  yields (content's name, system, what tells results of a system apart, who makes the clip)
    """
    shown, body = split.exemplars(name), next(iter(styles.values())).manifold.body
    pairs = pair_contents({split.labels[c][0] for c in split.parts["contents"]}, shown)
    for content, take in split.parts["contents"].items():
        def _by(seed, **how):
            return lambda: transfer(take, styles[seed], networks=networks, **how).clip

        def _baseline(way):
            there = seen(take, body)
            exemplar = split.parts["exemplars"][shown[pairs[split.labels[content][0]]]]
            return onto_skeleton(take, there, way(there.features, seen(exemplar, body).features))
        for seed in styles:
            yield content, AS_IT_IS, f" {seed}", _by(seed)
        first = next(iter(styles))
        yield content, OWN_PACE, "", _by(first, own_pace=True)
        yield content, RAW, "", _by(first, clean=False)
        yield content, POSTURE, "", lambda: _baseline(moved_posture).clip
        yield content, SPECTRA, "", lambda: _baseline(moved_spectra).clip


def flow(features: np.ndarray, style: Style) -> tuple[list[tuple[str, np.ndarray, str]],
                                                      list[tuple[str, np.ndarray]]]:
    """What flows through T and then L, and by which filters: signals and filters of
    `pictures.figures.networks`.   features : (T, 66)
    """
    manifold, p = style.manifold, style.params
    X = [manifold.network_input(features)]
    for layer in (1, 2, 3):
        Z = nn.conv1d(X[-1], p[f"W{layer}"], p[f"b{layer}"])
        X.append(nn.relu(Z) if layer < 3 else Z)
    X += [networks.encode(X[3], manifold.params), networks.project(X[3], manifold.params)]
    names = ("I", "layer 1", "layer 2", "T(I)", "L(T(I))", "P(T(I))")
    signals = [(name, x[0], "#D55E00" if n < 4 else "#009E73")
               for n, (name, x) in enumerate(zip(names, X))]
    W = manifold.params["W0"]
    decoder = manifold.params.get("V0", W.swapaxes(0, 1))
    return signals, [*((f"W{layer}", p[f"W{layer}"]) for layer in (1, 2, 3)), ("W0, max-pooling",
                     W), ("decoder", decoder)]


def moved_posture(X: np.ndarray, S: np.ndarray) -> np.ndarray:
    """A content with the mean pose and the mean speed of an exemplar.   (T, 66), (T_s, 66)

    >>> moved_posture(np.full((4, 66), 2.0), np.full((9, 66), 3.0))[0, [0, 63, 64]]
    array([3., 2., 3.])
    """
    O = X.copy()
    O[:, POSITIONS] += S[:, POSITIONS].mean(axis=0) - X[:, POSITIONS].mean(axis=0)
    speeds = [np.linalg.norm(f[:, TRANSLATION], axis=1).mean() for f in (S, X)]
    O[:, TRANSLATION] *= speeds[0] / max(speeds[1], 1e-9)
    return O


def moved_spectra(X: np.ndarray, S: np.ndarray) -> np.ndarray:
    """A content's phases with an exemplar's mean pose and smoothed magnitudes.
    (T, 66), (T_s, 66)  ->  (T, 66)
    """
    count = 2 ** int(np.ceil(np.log2(max(len(X), len(S)))) + 1)
    means = [f[:, POSITIONS].mean(axis=0) for f in (X, S)]
    spectra = [np.fft.rfft(f[:, POSITIONS] - m, count, axis=0) for f, m in zip((X, S), means)]
    smooth = SMOOTHED_BY * count / 60.0
    power = [gaussian_filter1d(np.abs(s) ** 2, smooth, axis=0) / len(f)
             for s, f in zip(spectra, (X, S))]
    gain = np.sqrt((power[1] + 1e-9) / (power[0] + 1e-9)).clip(1 / LARGEST_GAIN, LARGEST_GAIN)
    O = X.copy()
    O[:, POSITIONS] = np.fft.irfft(gain * spectra[0], count, axis=0)[:len(X)] + means[1]
    return O


def left(result: np.ndarray, content: np.ndarray, exemplar: np.ndarray, referee: Manifold) -> float:
    """Style distance to an exemplar by a loss network that nothing used, per frame, the content's
    own = 1.   result, content, exemplar : features (T, 66) on its body
    """
    here, there = (style_distance(f, [exemplar], referee) / len(f) for f in (result, content))
    return here / there


def write_clips(split: Split, out: Path) -> dict[str, Path]:
    """Write the clips of the judges, exemplars, contents and real takes, each under a name that
    tells its labels.   ->  {name: file}
    """
    files = {}
    for part in ("judges", "exemplars", "real", "contents"):
        (out / part).mkdir(parents=True, exist_ok=True)
        for name, take in split.parts[part].items():
            words = re.sub(r"\W", "-", name).split("_")
            files[name] = out / part / "_".join(
                [*words[:-3], *split.labels[name], f"{words[-1]}.bvh"])
            if not files[name].exists():
                write_bvh(files[name], take.clip)
    return files
