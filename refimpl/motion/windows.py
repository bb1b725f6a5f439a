r"""What training needs beside the 66 numbers: windows of equal length and a normaliser."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .dataset import Labelled
from .features import FEATURES, POSITIONS, TRANSLATION, TURN, VELOCITIES
from .joints import FEET, JOINTS

WINDOW, HOP = 240, 120           # frames at 60 a second (section 3.1: 240, overlapping)
FORMS = ("groups", "2016")       # of a normaliser
ROUNDED = 1e-12                  # share of a number below which its deviation is mere rounding


def windows(features: np.ndarray, contacts: np.ndarray, length: int = WINDOW,
            step: int = HOP) -> tuple[np.ndarray, np.ndarray]:
    """Cut a clip into windows of one length; pad a shorter one with its first and last frame,
    standing still.

    Windows begin every `step` frames; what is left at the end gets one more window that ends with
    the clip. In the padding the three velocities are zero (**not** repeated: a padded figure stands
    still).

    features : (T, 66), contacts : (T, 4)  ->  (N, length, 66), (N, length, 4)

    >>> cut, labels = windows(np.ones((10, 66)), np.ones((10, 4)), length=4, step=3)
    >>> cut.shape, labels.shape
    ((3, 4, 66), (3, 4, 4))
    >>> windows(np.ones((2, 66)), np.ones((2, 4)), length=4)[0][0, :, -1]
    array([0., 1., 0., 0.])
    """
    frames = len(features)
    if frames < length:
        before = (length - frames) // 2
        pad = (before, length - frames - before), (0, 0)
        padded = np.pad(features, pad, mode="edge")
        padded[:before, VELOCITIES] = 0.0
        padded[before + frames - 1:, VELOCITIES] = 0.0   # the last row leads into it
        return padded[None], np.pad(contacts, pad, mode="edge")[None]
    starts = list(range(0, frames - length + 1, step))
    if starts[-1] + length < frames:
        starts.append(frames - length)
    return (np.stack([features[s:s + length] for s in starts]),
            np.stack([contacts[s:s + length] for s in starts]))


@dataclass(frozen=True)
class Normaliser:
    """Mean and standard deviation of each of the 66 numbers, and the name of the data that they
    were measured on.

    mean, deviation : (66,);  source : the data's name;  form : how they were measured, of FORMS

    >>> Normaliser(np.full(66, 1.0), np.full(66, 2.0), "made up").apply(np.full(66, 5.0))[:2]
    array([2., 2.])
    """

    mean: np.ndarray
    deviation: np.ndarray
    source: str
    form: str = "groups"

    def apply(self, features: np.ndarray) -> np.ndarray:
        """(features - mean) / deviation, in the features' own precision.

        features : (..., 66)  ->  (..., 66)
        """
        return ((features - self.mean) / self.deviation).astype(features.dtype)

    def channels_first(self, cut: np.ndarray, dtype: Any) -> np.ndarray:
        """`apply` to windows, as networks take them.   (N, T, 66)  ->  (N, 66, T)"""
        return np.ascontiguousarray(self.apply(cut).swapaxes(1, 2), dtype=dtype)

    def undo(self, normalised: np.ndarray) -> np.ndarray:
        """normalised * deviation + mean, the inverse of `apply`.

        normalised : (..., 66)  ->  (..., 66)
        """
        return (normalised * self.deviation + self.mean).astype(normalised.dtype)


def fit_normaliser(features: np.ndarray, source: str, *, contacts: np.ndarray | None = None,
                   form: str = "groups") -> Normaliser:
    r"""Mean and standard deviation over the training frames. Velocities keep a mean of zero, so
    that standing still stays zero.

    form "groups" : one common deviation for all positions, one for the two translational
    velocities, one for the turning velocity, so that no joint that hardly moves is blown up. A
    choice, the paper is silent.

    form "2016" : the 2016 code's. Positions take the deviation of *all numbers together*, in which
    the distances between the joints count (with them the reference joint's three zeros, velocities
    and contacts, 73 rows; feet 0.9 of it); velocities and turning take 0.9 of their own. On the
    clips at hand 44 cm where "groups" finds 10, so that hidden units are 2.4 times smaller.

    features : (T, 66), all training frames together;  source : a name for them
    contacts : (T, 4), for the form "2016"
    ->  Normaliser.   Raises ValueError for a wrong shape or an unknown form.
    """
    features, contacts = np.asarray(features, float), np.asarray(contacts, float)
    if features.ndim != 2 or features.shape[1] != FEATURES or len(features) < 2:
        raise ValueError(f"features: found shape {features.shape}, needed (frames, {FEATURES}) "
                         "with at least two frames")
    if form not in FORMS:
        raise ValueError(f"form: found {form!r}, needed one of {', '.join(FORMS)}")
    if form == "2016" and contacts.shape != (len(features), len(FEET)):
        raise ValueError(f"contacts: found shape {contacts.shape}, needed ({len(features)}, "
                         f"{len(FEET)}) for the form 2016, one row a frame")
    mean, deviation = features.mean(axis=0), features.std(axis=0)
    mean[VELOCITIES] = 0.0
    turn, usual = slice(TURN, TURN + 1), float(deviation.max()) or 1.0
    if form == "groups":
        common = [(part, np.sqrt(np.mean(deviation[part] ** 2)))
                  for part in (POSITIONS, TRANSLATION, turn)]
    else:
        rows = np.concatenate([np.zeros((len(features), 3)), features, contacts], axis=1)
        common = [(POSITIONS, rows.std()), (TRANSLATION, 0.9 * features[:, TRANSLATION].std()),
                  (turn, 0.9 * deviation[TURN])]
    for part, value in common:       # data that never turns (or never moves) has no deviation
        size = float(np.abs(features[:, part]).max())
        deviation[part] = value if value > ROUNDED * size else usual
    if form == "2016":
        deviation[POSITIONS].reshape(JOINTS, 3)[list(FEET)] *= 0.9
    return Normaliser(mean, deviation, source, form)


def clean_windows(clips: Sequence[Labelled], source: str, *, form: str = "groups",
                  dtype: Any = np.float32) -> tuple[np.ndarray, Normaliser]:
    """What the loss network is trained on.

    clips : at least one;  source : of their dataset;  form : of the normaliser, of FORMS
    ->  windows (N, 66, T), the normaliser of these clips
    """
    frames, contacts = (np.concatenate([getattr(clip, part) for clip in clips])
                        for part in ("features", "contacts"))
    normaliser = fit_normaliser(frames, source, contacts=contacts, form=form)
    cut = np.concatenate([windows(clip.features, clip.contacts)[0] for clip in clips])
    return normaliser.channels_first(cut, dtype), normaliser
