r"""Input segmentation (Torresani 2006, section 7.1, equations 8 to 11): Ney's one-stage dynamic
programme.

A sequence Y is aligned with the best concatenation of database fragments, however many and however
often. Frames count from 0 here.
"""

from dataclasses import dataclass

import numpy as np

from .align import AlignError, checked, distances


class SegmentError(ValueError):
    """A sequence or a database that cannot be cut."""


@dataclass(frozen=True)
class Piece:
    """A stretch of Y and the fragment that it matches.
    start, end : frames of Y, the end not included;
    cost : the piece's share of equation 8, radians squared."""

    fragment: int
    start: int
    end: int
    cost: float


def segment(Y, fragments):
    r"""The best concatenation, frame of Y by frame:

        C(p, q, i) = d(p, q, i) + min( C(p-1, q, i), C(p-1, q-1, i), C(p, q-1, i) )        q > 0   (equation 10)
        C(p, 0, i) = d(p, 0, i) + min( C(p-1, 0, i), min over j of C(p-1, T_j - 1, j) )            (equation 9)
        C(0, 0, i) = d(0, 0, i);   the answer ends in the last frame of some fragment              (equation 11)

    All fragments are computed side by side. With every C goes the frame of Y where its path entered
    the fragment; with every p the fragment that can best end there. Following these back from the
    end of Y gives the pieces. Of equal costs: the diagonal step, then p-1, then q-1; staying in a
    fragment before entering one; the first fragment.

    Y : (T, D) radians, fragments : list of (T_i, D)
    ->  total cost in radians squared, list of Piece
    Raises SegmentError without fragments, AlignError for other columns, no frames, or numbers that
    are not real and finite.
    """
    if not len(fragments):
        raise SegmentError("fragments: found none, needed at least one to match with")
    Y, fragments = checked("Y", Y), [checked(f"fragments[{i}]", X) for i, X in enumerate(fragments)]
    for i, X in enumerate(fragments):
        if X.shape[1] != Y.shape[1]:
            raise AlignError(
                f"fragments[{i}]: found {X.shape[1]} angles a frame, needed {Y.shape[1]} as in Y; "
                "are they of one skeleton?")
    lengths = np.array([len(X) for X in fragments])
    T, N, Q = len(Y), len(fragments), lengths.max()
    # (T, sum of T_i)
    d = distances(Y, np.concatenate(fragments))
    # (Q, N) into d
    columns = np.minimum(
        np.cumsum(lengths)[:, None] - lengths[:, None] + np.arange(Q), d.shape[1] - 1).T
    rows = np.arange(Q)[:, None]
    beyond = rows >= lengths
    C, entered = np.full((Q, N), np.inf), np.zeros((Q, N), dtype=int)
    best_end, best_fragment, best_start = np.full(T, np.inf), np.zeros(T, dtype=int), np.zeros(
        T, dtype=int)
    for p in range(T):
        now = d[p, columns]
        now[beyond] = np.inf
        before, was = C, entered
        C, entered = now, np.empty_like(was)
        enter = best_end[p - 1] if p else 0.0
        stay = before[0] <= enter if p else np.zeros(N, dtype=bool)
        C[0] += np.where(stay, before[0], enter)
        # p-1 strictly better than the diagonal
        from_p = before[1:] < before[:-1]
        cost = np.where(from_p, before[1:], before[:-1])
        for q in range(1, Q):
            C[q] += np.minimum(C[q - 1], cost[q - 1])
        entered[0] = np.where(stay, was[0], p)
        entered[1:] = np.where(from_p, was[1:], was[:-1])
        not_from_q = np.concatenate([np.ones((1, N), dtype=bool), cost <= C[:-1]])
        # steps along q keep where they came from
        source = np.maximum.accumulate(np.where(not_from_q, rows, 0), axis=0)
        entered = np.take_along_axis(entered, source, axis=0)
        ends = C[lengths - 1, np.arange(N)]
        best_fragment[p] = ends.argmin()
        best_end[p], best_start[p] = ends[best_fragment[p]], entered[lengths[best_fragment[p]] - 1,
                                                                     best_fragment[p]]
    pieces, end = [], T
    while end > 0:
        start = best_start[end - 1]
        cost = best_end[end - 1] - (best_end[start - 1] if start else 0.0)
        pieces.append(Piece(int(best_fragment[end - 1]), int(start), int(end), float(cost)))
        end = start
    return float(best_end[-1]), pieces[::-1]
