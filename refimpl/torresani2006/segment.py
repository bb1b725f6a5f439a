r"""Input segmentation (section 7.1, equations 8 to 11): Ney's one-stage dynamic programme.

A sequence Y is aligned with the best concatenation of database fragments, however many and however
often. Frames count from 0 here.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .align import AlignError, check_sequence, distances


class SegmentError(ValueError):
    """A sequence or a database that cannot be cut."""


@dataclass(frozen=True)
class Piece:
    """A stretch of Y and the fragment that it matches.

    start, end : frames of Y, the end not included;  cost : the piece's share of the total, in
    radians squared.
    """

    fragment: int
    start: int
    end: int
    cost: float


def segment(Y: np.ndarray, fragments: Sequence[np.ndarray]) -> tuple[float, list[Piece]]:
    r"""The best concatenation, frame of Y by frame, by dynamic programming:

        C(p, q, i) = d(p, q, i) + min( C(p-1, q, i), C(p-1, q-1, i), C(p, q-1, i) )     where q > 0
        C(p, 0, i) = d(p, 0, i) + min( C(p-1, 0, i), min over j of C(p-1, T_j - 1, j) )
        C(0, 0, i) = d(0, 0, i)

    Torresani 2006, Equation 8: the total cost = min over paths w of sum_n d(w(n)).
    Torresani 2006, Equation 9: a path enters a fragment's first frame, q = 0, from the last frame
    of any fragment j, or stays in it; the second line.
    Torresani 2006, Equation 10: within a fragment the steps are those of time warping; the first.
    Torresani 2006, Equation 11: a path begins in the first frames of Y and of a fragment, the third
    line, and ends in the last frames of Y and of a fragment.

    All fragments are computed side by side. With every C goes the frame of Y where its path entered
    the fragment; with every p the fragment that can best end there. Following these back from the
    end of Y gives the pieces. Of equal costs: the diagonal step, then p-1, then q-1; staying in a
    fragment before entering one; the first fragment.

    Y : (T, D) radians, fragments : list of (T_i, D)  ->  total cost in radians squared, the pieces.
    Raises SegmentError without fragments, AlignError for other columns, no frames, or numbers that
    are not real and finite.

    >>> low, high = np.array([[0.0], [1.0]]), np.array([[5.0], [7.0]])
    >>> segment(np.array([[5.0], [6.0], [7.0], [0.0], [1.0]]), [low, high])[1]
    [Piece(fragment=1, start=0, end=3, cost=1.0), Piece(fragment=0, start=3, end=5, cost=0.0)]
    """
    if not len(fragments):
        raise SegmentError("fragments: found none, needed at least one to match with")
    Y = check_sequence("Y", Y)
    fragments = [check_sequence(f"fragments[{i}]", X) for i, X in enumerate(fragments)]
    for i, X in enumerate(fragments):
        if X.shape[1] != Y.shape[1]:
            raise AlignError(f"fragments[{i}]: found {X.shape[1]} angles a frame, needed "
                             f"{Y.shape[1]} as in Y; are they of one skeleton?")
    lengths = np.array([len(X) for X in fragments])
    T, N, Q = len(Y), len(fragments), lengths.max()
    d = distances(Y, np.concatenate(fragments))              # (T, sum of T_i)
    rows = np.arange(Q)[:, None]
    columns = np.minimum(np.cumsum(lengths) - lengths + rows, d.shape[1] - 1)          # (Q, N)
    C, entered = np.full((Q, N), np.inf), np.zeros((Q, N), dtype=int)
    best_end, best_fragment, best_start = np.full(T, np.inf), *np.zeros((2, T), dtype=int)
    for p in range(T):
        before, was = C, entered
        C = np.where(rows < lengths, d[p, columns], np.inf)
        enter = best_end[p - 1] if p else 0.0
        stay = before[0] <= enter if p else np.zeros(N, dtype=bool)
        C[0] += np.where(stay, before[0], enter)
        from_p = before[1:] < before[:-1]                    # p-1 strictly better than the diagonal
        cost = np.where(from_p, before[1:], before[:-1])
        for q in range(1, Q):
            C[q] += np.minimum(C[q - 1], cost[q - 1])
        entered = np.concatenate([np.where(stay, was[:1], p), np.where(from_p, was[1:], was[:-1])])
        not_from_q = np.concatenate([np.ones((1, N), dtype=bool), cost <= C[:-1]])
        # Steps along q keep where they came from.
        source = np.maximum.accumulate(np.where(not_from_q, rows, 0), axis=0)
        entered = np.take_along_axis(entered, source, axis=0)
        last = C[lengths - 1, np.arange(N)]
        i = best_fragment[p] = last.argmin()
        best_end[p], best_start[p] = last[i], entered[lengths[i] - 1, i]
    pieces, end = [], T
    while end > 0:
        start = best_start[end - 1]
        cost = best_end[end - 1] - (best_end[start - 1] if start else 0.0)
        pieces.append(Piece(int(best_fragment[end - 1]), int(start), int(end), float(cost)))
        end = start
    return float(best_end[-1]), pieces[::-1]
