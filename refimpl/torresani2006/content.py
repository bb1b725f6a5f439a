r"""Contents that survive another performer. Equation 3 compares poses as they are; how somebody
stands then weighs more than what is done. Named options, of no equation of the paper:

- A performer's habit is taken out: the mean pose of all that is known of one.
- Angles are whitened within contents: with r the residuals of the warping paths of pairs of one
  content, S = mean of r r^T and a ridge of a tenth of its mean diagonal, x becomes x S^(-1/2): what
  differs between performances of one action counts little.

SSD is divided by the number of frames where motions of different length are compared, groups are
those of complete linkage (`groups`), and a piece that lies further from the database than its own
contents lie from each other is said to be like nothing (`Contents.like`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import squareform

from .align import AlignError, dtw, pair_costs
from .segment import Piece, segment

RIDGE, PAIRS = 0.1, 30                  # of the mean diagonal; of each content, looked at
BEYOND_OWN = 1.3                        # times as far as nearly all lie from their own content
PHRASE = 0.5                            # of the contents' lengths: from here on a phrase
ROUNDS = 1                              # of finding a habit and cutting anew
SWALLOWED = 0.5                         # share of all in one group that is warned of


@dataclass(frozen=True)
class Contents:
    """A database's fragments as contents are told by.

    sequences : without habits, whitened;  names : their contents;  whitening : (D, D);
    own : (N,) SSD a frame from each to the nearest of its content by another performer;
    habits : (performers, D) their mean poses, whitened.
    """

    sequences: list[np.ndarray] = field(repr=False)
    names: list[str]
    whitening: np.ndarray = field(repr=False)
    own: np.ndarray = field(repr=False)
    habits: np.ndarray = field(repr=False)

    def cut(self, angles: np.ndarray, rounds: int = ROUNDS) -> tuple[float, list[Piece]]:
        """Equations 8 to 11 of a motion by one performer, seen as the sequences are.

        Its habit is guessed at first: the motion's own mean pose, where it is long enough for half
        of the contents there are; that of a few actions would take away what they are, and the mean
        of the performers' habits is taken. Then what is left between the motion and the fragments
        that it matches is taken out, too, in `rounds`.   ->  as `segment.segment`
        """
        raw = angles @ self.whitening
        usual = sum(len(x) / self.names.count(name) for x, name in zip(self.sequences, self.names))
        seen = raw - (raw if len(raw) >= PHRASE * usual else self.habits).mean(axis=0)
        cost, pieces = segment(seen, self.sequences)
        for _ in range(rounds):
            left = []
            for piece in pieces:
                Y, X = seen[piece.start:piece.end], self.sequences[piece.fragment]
                p, q = dtw(Y, X)[1].T
                left.append((piece.end - piece.start) * (Y[p] - X[q]).mean(axis=0))
            seen = seen - np.sum(left, axis=0) / len(seen)
            cost, pieces = segment(seen, self.sequences)
        return cost, pieces

    def like(self, piece: Piece) -> float:
        """How far a piece lies from the fragment that it matches, beside `BEYOND_OWN` times the
        90th percentile of how far fragments lie from their own content: above 1 it is like nothing
        there.
        """
        if not len(self.own):
            return float("nan")                              # nobody did anything twice
        far = piece.cost / (piece.end - piece.start)
        return far / max(BEYOND_OWN * float(np.percentile(self.own, 90)), 1e-12)


def habits_of(sequences: Sequence[np.ndarray], performer: Sequence[str]) -> dict[str, np.ndarray]:
    """The mean pose of all that each performer does.   [(T_i, D)]  ->  {performer: (D,)}

    >>> habits_of([np.array([[1.0]]), np.array([[3.0]])], ["she", "she"])
    {'she': array([2.])}
    """
    return {who: np.concatenate([x for x, by in zip(sequences, performer) if by == who]).mean(
        axis=0) for who in dict.fromkeys(performer)}


def without_habits(sequences: Sequence[np.ndarray], performer: Sequence[str]) -> list[np.ndarray]:
    """Angles minus their performer's habit.   [(T_i, D)]  ->  the same

    >>> without_habits([np.array([[1.0]]), np.array([[3.0]])], ["she", "she"])
    [array([[-1.]]), array([[1.]])]
    """
    of = habits_of(sequences, performer)
    return [x - of[by] for x, by in zip(sequences, performer)]


def whitening(sequences: Sequence[np.ndarray], names: Sequence[str], pairs: int = PAIRS,
              seed: int = 0) -> np.ndarray:
    """S^(-1/2) of the residuals within contents, of the mean size that leaves SSD's scale.

    names : the contents;  pairs : of each content at most;  seed : of those that are looked at
    ->  (D, D).   Raises AlignError where no content has two.
    """
    rng, residuals = np.random.default_rng(seed), []
    for name in dict.fromkeys(names):
        members = np.flatnonzero(np.array(names) == name)
        i, j = np.triu_indices(len(members), 1)
        for n in rng.permutation(len(i))[:pairs]:
            X, Y = sequences[members[i[n]]], sequences[members[j[n]]]
            p, q = dtw(X, Y)[1].T
            residuals.append((X[p] - Y[q]) / np.sqrt(len(p)))
    if not residuals:
        raise AlignError("names: found no content twice, needed two of one to know what differs "
                         "within it")
    S = sum(r.T @ r for r in residuals) / len(residuals)
    values, vectors = np.linalg.eigh(S + (RIDGE * np.trace(S) / len(S) + 1e-12) * np.eye(len(S)))
    return (vectors / np.sqrt(values)) @ vectors.T * np.sqrt(np.trace(S) / len(S) + 1e-12)


def contents_of_names(sequences: Sequence[np.ndarray], names: Sequence[str],
                      performer: Sequence[str]) -> Contents:
    """Fragments whose contents and performers are known.   sequences : [(T_i, D)] radians"""
    free = without_habits(sequences, performer)
    repeated = len(set(names)) < len(names)
    W = whitening(free, names) if repeated else np.eye(free[0].shape[1])
    seen = [x @ W for x in free]
    others = np.array(names)[:, None] == np.array(names)
    if len(set(performer)) > 1:
        others &= np.array(performer)[:, None] != np.array(performer)
    i, j = np.nonzero(np.triu(others, 1))
    far = np.full(others.shape, np.inf)
    far[i, j] = far[j, i] = pair_costs([(seen[a], seen[b]) for a, b in zip(i, j)]) / np.maximum(
        *(np.array([len(seen[n]) for n in some]) for some in (i, j)))
    own = far.min(axis=1)
    habits = np.array(list(habits_of(sequences, performer).values())) @ W
    return Contents(seen, list(names), W, own[np.isfinite(own)], habits)


def groups(far: np.ndarray, count: int) -> tuple[np.ndarray, str]:
    """Complete linkage: fragments grouped so that the farthest two of a group are near.

    far : (N, N) such as SSD a frame, count : of groups   ->  (N,) numbers from 0 in the order of
    their first members, and a warning where one group swallows more than half, or ""

    >>> groups(np.array([[0.0, 9.0, 1.0], [9.0, 0.0, 9.0], [1.0, 9.0, 0.0]]), 2)[0]
    array([0, 1, 0])
    """
    if not 1 <= count <= len(far):
        raise AlignError(f"count: found {count}, needed a number of groups from 1 to {len(far)}")
    found = (fcluster(linkage(squareform(far, checks=False), "complete"), count, "maxclust")
             if len(far) > 1 else np.zeros(1, dtype=int))
    _, first, inverse, sizes = np.unique(found, return_index=True, return_inverse=True,
                                         return_counts=True)
    swallowed = count > 1 and len(far) > 3 and sizes.max() > SWALLOWED * len(far)
    return np.argsort(np.argsort(first))[inverse], (
        f"one of {count} groups holds {sizes.max()} of {len(far)} fragments: contents are not told "
        "apart; name them, or ask for more" if swallowed else "")


def each_once(far: np.ndarray, performer: Sequence[str], rounds: int = 4) -> np.ndarray:
    """Groups where every performer does each action once, as in section 8's twelve phrases of five:
    from one performer's actions on, everybody else's are assigned to the groups at the least sum of
    median distances (Kuhn and Munkres), in `rounds`; of all performers to begin with the one whose
    groups are tightest.   far : (N, N), performer : (N,)  ->  (N,) numbers from 0

    >>> each_once(np.abs(np.subtract.outer([0, 9, 8, 1], [0, 9, 8, 1])), ["a", "a", "b", "b"])
    array([0, 1, 1, 0])
    """
    who, best, tightest = np.array(performer), np.zeros(len(far), dtype=int), np.inf
    for begin in dict.fromkeys(performer):
        found = np.full(len(far), -1)
        found[who == begin] = range(int((who == begin).sum()))
        for n in range(rounds):
            for name in dict.fromkeys(performer):
                mine = np.flatnonzero(who == name)
                if name == begin and n == 0 or len(mine) > found.max() + 1:
                    continue
                found[mine] = -1
                cost = [[np.median(far[m, found == k]) if (found == k).any() else far.max()
                         for k in range(int((who == begin).sum()))] for m in mine]
                rows, columns = linear_sum_assignment(np.array(cost))
                found[mine[rows]] = columns
        spread = sum(far[np.ix_(found == k, found == k)].sum() for k in set(found))
        if spread < tightest:
            best, tightest = found, spread
    return best
