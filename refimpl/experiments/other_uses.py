"""Where the paper is of two minds, or looks ahead: gestures instead of locomotion (the accepted
manuscript denies and the journal text asserts good results), and, its last paragraph, another
transformation than style learnt from one exemplar: another body.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..fast import networks
from ..holden2017.objective import WEIGHTS
from ..holden2017.pairing import make_training_set
from ..holden2017.trained import Manifold
from ..holden2017.transfer import stylise
from ..motion.body import Take, make_take, to_scale
from ..motion.dataset import Dataset, Labelled
from ..motion.features import (POSITIONS, SIDEWAYS, TURN, VELOCITIES, Start,
                               bone_lengths, decode, encode, leg_length)
from ..motion.joints import BONES, JOINTS, SLOT, SLOTS
from .bodies import BODIES, proportioned
from .holden import Ground, learn_manifold, learn_style
from .measures import style_distance
from .problem import Split, lesson_of_one
from .score import correlation

REACHING = [SLOT[name] for name in ("Head", "LeftHand", "RightHand")]
_OTHER_SIDE = [SLOTS.index(name.replace("Left", "*").replace("Right", "Left").replace("*", "Right"))
               for name in SLOTS]
FASTER = 1.25
BODY, CHANGED = "long arms", 0.1          # of a bone's length, beyond which it counts


def mirrored(features: np.ndarray) -> np.ndarray:
    """The same motion with left and right exchanged.   (T, 66)  ->  (T, 66)

    >>> X = np.random.default_rng(0).normal(size=(4, 66))
    >>> bool((mirrored(mirrored(X)) == X).all() and (mirrored(X) != X).any())
    True
    """
    O = features.copy()
    joints = features[:, POSITIONS].reshape(len(features), JOINTS, 3)[:, _OTHER_SIDE]
    O[:, POSITIONS] = (joints * [-1.0, 1.0, 1.0]).reshape(len(features), -1)
    O[:, [TURN, SIDEWAYS]] *= -1
    return O


def _faster(clip):
    at = np.arange(0, len(clip.features) - 1, FASTER)
    features = np.stack([np.interp(at, np.arange(len(clip.features)), column)
                         for column in clip.features.T], axis=1)
    features[:, VELOCITIES] *= FASTER
    return replace(clip, name=clip.name + " faster", features=features,
                   contacts=clip.contacts[at.astype(int)])


def varied(clips: Sequence[Labelled]) -> tuple[Labelled, ...]:
    """Clips, the same mirrored, and both faster."""
    both = [*clips, *(replace(c, name=c.name + " mirrored", features=mirrored(c.features),
                              contacts=c.contacts[:, [2, 3, 0, 1]]) for c in clips)]
    return (*both, *map(_faster, both))


def gestures(dataset: Dataset, style: str, contents: str, ways: Sequence[tuple[float, int]], *,
             hidden: int, epochs: int, channels: int) -> Iterator[dict[str, Any]]:
    """A style of gestures, learnt from one exemplar a gesture on all other styles, mirrored and at
    two speeds, on windows in which more moves than in half of them; tried on the style `contents`,
    which nothing learnt on.

    ways : (s of equation 5, steps) each
    ->  yields rows: the exemplar itself as the control, then each way. Excursion: how far head and
    hands move about their mean place, the content's = 1; kept: their correlation with the content;
    left: style distance by the loss network, the content's = 1
    """
    learn = varied([c for c in dataset.clips if c.style not in (style, contents)])
    shown = tuple(c for c in dataset.clips if c.style == style)
    manifold = learn_manifold(Ground(replace(dataset, clips=learn), "", ""), hidden=hidden,
                              epochs=epochs)
    lesson, _, _ = make_training_set(
        replace(dataset, clips=learn + shown), manifold, style, networks=networks,
        content_style=",".join(sorted({c.style for c in learn})))
    moves = np.abs(np.diff(lesson.X, axis=2)).mean(axis=(1, 2))
    chosen = np.flatnonzero(moves >= np.median(moves))
    lesson = replace(lesson, X=lesson.X[chosen], contacts=lesson.contacts[chosen],
                     trajectory=lesson.trajectory[chosen],
                     contents=tuple(lesson.contents[n] for n in chosen))
    exemplar = {c.content: to_scale(c.features, dataset.leg, manifold.leg) for c in shown}
    tried = {c.content: to_scale(c.features, dataset.leg, manifold.leg) for c in dataset.clips
             if c.style == contents and c.content in exemplar}

    def _rows(what, made):
        for content, X in tried.items():
            O = made(content, X)
            far = [_reaching(f).std(axis=0) for f in (O, X)]
            here, there = (style_distance(f, [exemplar[content]], manifold) / len(f)
                           for f in (O, X))
            yield {"gesture": content, "what": what, "excursion (content = 1)":
                   float(np.sqrt(np.mean(far[0] ** 2) / np.mean(far[1] ** 2))),
                   "kept (correlation)": (correlation(_reaching(O), _reaching(X))
                                          if len(O) == len(X) else float("nan")),
                   "style left (content = 1)": here / there}
    yield from _rows("the exemplar itself", lambda content, X: exemplar[content])
    for s, steps in ways:
        rounds = max(1, round(steps * 10 / len(lesson.X)))
        made = learn_style(lesson, manifold, style, replace(WEIGHTS["mean_squares"], style=s),
                           channels=channels, epochs=rounds)
        yield from _rows(f"s = {s:g}, {steps} steps", lambda content, X: stylise(
            X, made, networks=networks))


def _reaching(features):
    joints = features[:, POSITIONS].reshape(len(features), JOINTS, 3)
    return joints[:, REACHING] - joints[:, [SLOT["Hips"]]]


def another_body(split: Split, manifold: Manifold, take: Take, *, channels: int,
                 epochs: int) -> list[dict[str, Any]]:
    """One clip of a body with longer arms as the exemplar of equation 5, once with the content's
    bones in equation 8 and once with the exemplar's: how much of the change of the bones
    that are longer arrives in T(I), how much others change that should not, and what is left of the
    distance of Gram matrices.
    """
    other = make_take(proportioned(take, BODIES[BODY]))
    E = to_scale(encode(other.positions)[0], leg_length(other.positions), manifold.leg)
    lengths = bone_lengths(decode(E, Start()))
    first = next(iter({split.labels[n][1] for n in split.parts["exemplars"]}))
    plain = lesson_of_one(split, manifold, first)
    H = networks.encode(manifold.network_input(E), manifold.params)[0]
    gram = H @ H.T * (plain.X.shape[2] // 2 / H.shape[1])
    lesson = replace(plain, grams={content: gram for content in plain.grams})
    arms = np.flatnonzero(np.abs(lengths / manifold.bones - 1) > CHANGED)
    others = np.setdiff1d(np.arange(len(BONES)), arms)
    rows = []
    for what, bones in (("the content's", manifold.bones), ("the exemplar's", lengths)):
        made = learn_style(replace(lesson, bones=bones), manifold, BODY,
                           WEIGHTS["mean_squares"], channels=channels, epochs=epochs)
        arrived, spoilt, left = [], [], []
        for content in split.parts["contents"]:
            X = next(c.features for c in split.dataset.clips if c.name == content)
            O = stylise(X, made, projected=False, networks=networks)
            now, before = (bone_lengths(decode(f, Start())) for f in (O, X))
            arrived.append(np.mean((now - before)[arms] / (lengths - before)[arms]))
            spoilt.append(np.abs(now / before - 1)[others].mean())
            left.append(style_distance(O, [E], manifold) / style_distance(X, [E], manifold))
        rows.append({"body": BODY, "bones of equation 8": what,
                     "arms' change arrived (share)": float(np.median(arrived)),
                     "other bones off (share)": float(np.median(spoilt)),
                     "Gram distance left (content = 1)": float(np.median(left))})
    return rows
