r"""Does a clip lie within what a style has learnt?

A second of motion is told by the means and deviations of its joints in the character's frame and by
its mean velocities. How strange a clip is: the distance of its pieces to the nearest piece that was
learnt on, in units of how far the clips that were learnt on lie from each other. The error of P
does not tell: P gives back much that T has never seen.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree

from .features import POSITIONS, VELOCITIES

PIECE, PIECE_HOP = 60, 30                               # frames: a second, every half second
LEAST = 5                                         # clips without which there is no usual distance
MEANS, DEVIATIONS = slice(0, 63), slice(63, 126)  # of the 63 positions
TURNING, MOVING = slice(126, 127), slice(127, 129)
NUMBERS = 129
STRANGE = 1.5                                     # others' walks reach 1.3, gestures begin at 1.65


@dataclass(frozen=True)
class Known:
    """Pieces of the clips that were learnt on.

    pieces : (n, 129), each group of numbers in units of its own deviation;  scale : (129,) of the
    groups;  usual : the distance that separates one in a hundred of the clips from all the others
    """

    pieces: np.ndarray = field(repr=False)
    scale: np.ndarray = field(repr=False)
    usual: float

    def strangeness(self, features: np.ndarray) -> float:
        """The median over the pieces of a clip on the model's scale; 1 is as strange as what was
        learnt on gets.   (T, 66)  ->  float"""
        found = _to_nearest(_pieces(features) / self.scale, self.pieces)
        return float(np.median(found)) / self.usual


def known(clips: Sequence[np.ndarray]) -> Known | None:
    """What a style knows after these clips.

    list of (T, 66)  ->  Known, or None with fewer than `LEAST` clips
    """
    if len(clips) < LEAST:
        return None
    rows = [_pieces(clip) for clip in clips]
    owner = np.repeat(np.arange(len(rows)), [len(r) for r in rows])
    pieces = np.concatenate(rows)
    deviation, scale = pieces.std(axis=0), np.empty(NUMBERS)
    for part in (MEANS, DEVIATIONS, TURNING, MOVING):
        scale[part] = np.sqrt(np.mean(deviation[part] ** 2)) or 1.0
    pieces = (pieces / scale).astype(np.float32)
    apart = [np.median(_to_nearest(pieces[owner == k], pieces[owner != k]))
             for k in range(len(rows))]
    return Known(pieces, scale, max(float(np.quantile(apart, 0.99)), 1e-6))


def _pieces(features):
    """(T, 66)  ->  (n, 129)"""
    starts = range(0, max(1, len(features) - PIECE + 1), PIECE_HOP)
    return np.array([_told(features[s:s + PIECE]) for s in starts])


def _told(piece):
    return np.concatenate([piece[:, POSITIONS].mean(axis=0), piece[:, POSITIONS].std(axis=0),
                           piece[:, VELOCITIES].mean(axis=0)])


def _to_nearest(these, those):
    return cKDTree(those).query(these)[0]
