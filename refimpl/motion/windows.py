r"""What training needs beside the 66 numbers: windows of equal length and a normaliser."""

from dataclasses import dataclass

import numpy as np

from .features import FEATURES, POSITIONS, TRANSLATION, TURN, VELOCITIES
from .joints import FEET, JOINTS

# frames at 60 a second (section 3.1: 240, overlapping)
WINDOW, HOP = 240, 120


def windows(features, contacts, length=WINDOW, step=HOP):
    """Cut a clip into windows of one length; pad a shorter one with its first and last frame,
    standing still.

    features : (T, 66), contacts : (T, 4)  ->  (N, length, 66), (N, length, 4)
    Windows begin every `step` frames; what is left at the end gets one more window that ends with
    the clip. In the padding the three velocities are zero (**not** repeated: a padded figure stands
    still).
    """
    frames = len(features)
    if frames < length:
        before = (length - frames) // 2
        pad = (before, length - frames - before)
        padded = np.pad(features, (pad, (0, 0)), mode="edge")
        padded[:pad[0], VELOCITIES] = 0.0
        # from the clip's last frame on, which leads into the padding
        padded[frames + pad[0] - 1:, VELOCITIES] = 0.0
        return padded[None], np.pad(contacts, (pad, (0, 0)), mode="edge")[None]
    starts = list(range(0, frames - length + 1, step))
    if starts[-1] + length < frames:
        starts.append(frames - length)
    return (np.stack([features[s:s + length]
                      for s in starts]), np.stack([contacts[s:s + length] for s in starts]))


@dataclass(frozen=True)
class Normaliser:
    """Mean and deviation of each of the 66 numbers, and the name of the data they were measured on.

    mean, deviation : (66,);  form : how they were measured, of FORMS
    """

    mean: np.ndarray
    deviation: np.ndarray
    source: str
    form: str = "groups"

    def apply(self, features):
        """(features - mean) / deviation.   (..., 66)  ->  (..., 66), in the features' own precision
        """
        return ((features - self.mean) / self.deviation).astype(features.dtype)

    def undo(self, normalised):
        """normalised * deviation + mean.   (..., 66)  ->  (..., 66)"""
        return (normalised * self.deviation + self.mean).astype(normalised.dtype)


FORMS = ("groups", "2016")


def fit_normaliser(features, source, *, contacts=None, form="groups"):
    r"""Mean and deviation over the training frames. Velocities keep a mean of zero, so that
    standing still stays zero.

    form "groups" : one common deviation for all positions, one for the two translational
    velocities, one for the turning velocity, so that no joint that hardly moves is blown up. A
    choice, the paper is silent. form "2016" : the 2016 code's. Positions take the deviation of *all
    numbers together*, in which the distances between the joints count (with them the reference
    joint's three zeros, velocities and contacts, 73 rows; feet 0.9 of it); velocities and turning
    take 0.9 of their own. On the clips at hand 44 cm where "groups" finds 10, so that hidden units
    are 2.4 times smaller.

    features : (T, 66), all training frames together;  source : a name for them;  contacts : (T, 4),
    for "2016"   ->  Normaliser
    """
    features = np.asarray(features, dtype=float)
    if features.ndim != 2 or features.shape[1] != FEATURES or len(features) < 2:
        raise ValueError(
            f"features: found shape {features.shape}, needed (frames, {FEATURES}) with at least "
            "two frames")
    if form not in FORMS:
        raise ValueError(f"form: found {form!r}, needed one of {', '.join(FORMS)}")
    if form == "2016" and np.shape(contacts) != (len(features), len(FEET)):
        raise ValueError(
            f"contacts: found shape {np.shape(contacts)}, needed ({len(features)}, {len(FEET)}) "
            "for the form 2016, one row a frame")
    mean, deviation = features.mean(axis=0), features.std(axis=0)
    mean[VELOCITIES] = 0.0
    turn, usual = slice(TURN, TURN + 1), float(deviation.max()) or 1.0
    if form == "groups":
        common = [
            (part, np.sqrt(np.mean(deviation[part]**2))) for part in (POSITIONS, TRANSLATION, turn)]
    else:
        rows = np.concatenate(
            [np.zeros((len(features), 3)), features,
             np.asarray(contacts, dtype=float)], axis=1)
        common = [(POSITIONS, rows.std()), (TRANSLATION, 0.9 * features[:, TRANSLATION].std()),
                  (turn, 0.9 * deviation[TURN])]
    for part, value in common:
        # data that never turns (or never moves) has no deviation of its own
        deviation[part] = value if value > 0 else usual
    if form == "2016":
        deviation[POSITIONS].reshape(JOINTS, 3)[list(FEET)] *= 0.9
    return Normaliser(mean, deviation, source, form)
