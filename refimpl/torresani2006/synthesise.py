r"""Piecewise style synthesis (section 7.2, equation 12): the same actions in a style that is asked
for.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from .align import HIGHEST, LOWEST, pair_costs
from .database import Database, blend_inputs, coefficients
from .join import SynthesisError, at_origin, join
from .observe import LIMIT, Observer, observe
from .pca import PrincipalComponents
from .poses import HEADING, Fragment
from .regress import StyleModel, predict
from .segment import Piece, segment

NEIGHBOURS, SAMPLES, LOOKS = 12, 13, 8
GOLDEN, GOLDEN_TOLERANCE = (np.sqrt(5.0) - 1.0) / 2.0, 1e-5


@dataclass(frozen=True)
class Choice:
    """The minimum of equation 12 for one pair of fragments.

    i, j : fragments of the database;  predicted : (3,) f(z);  error : || e - f(z) ||.
    """

    i: int
    j: int
    alpha: float
    predicted: np.ndarray
    error: float


@dataclass(frozen=True)
class Synthesis:
    """A new motion and what it was made of.

    cuts : the first frame of each piece and the end;  pieces : of the input;  choices : one a
    piece.
    """

    fragment: Fragment = field(repr=False)
    cuts: tuple[int, ...]
    pieces: tuple[Piece, ...]
    choices: tuple[Choice, ...]


def neighbours(database: Database, i: int, count: int = NEIGHBOURS,
               piece: np.ndarray | None = None) -> np.ndarray:
    """The fragments of i's content nearest to it by SSD, itself among them; or to a piece of the
    input instead, if its angles are given (section 7.2 has those of the matched X_i).
    ->  (K,) numbers, nearest first
    """
    same = np.array([f.content == database.fragments[i].content for f in database.fragments])
    far = database.ssd[i] if piece is None else pair_costs(
        [(piece, fragment.angles) for fragment in database.fragments])
    nearest = np.argsort(np.where(same, far, np.inf), kind="stable")
    return nearest[:min(count, same.sum())]


def golden_section(f: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray,
                   tolerance: float = GOLDEN_TOLERANCE) -> np.ndarray:
    r"""The minimum of many functions of one number side by side, each between its own ends.

    Two points inside, at 0.382 and 0.618 of the interval; the end beyond the worse one moves there
    (of two equal ones beyond the left), and the better one is kept as one of the next two: the
    interval shrinks by 0.618 at the cost of one evaluation.

    f : (M,) ->  (M,);  low, high : (M,)
    ->  (M,) the middle of the last interval, which is no wider than `tolerance`.
    Raises SynthesisError for ends that are not in order, or a tolerance finer than numbers of their
    size are.

    >>> golden_section(lambda x: (x - 0.3) ** 2, [0.0], [1.0]).round(4)
    array([0.3])
    """
    low, high = np.array(low, dtype=float), np.array(high, dtype=float)
    if low.ndim != 1 or low.shape != high.shape or not (
            (low <= high).all() and np.isfinite(high - low).all()):
        raise SynthesisError(f"low, high: found shapes {low.shape} and {high.shape}, needed finite "
                             "numbers (M,), low <= high")
    finest = 8 * np.finfo(float).eps * max(np.abs(low).max(initial=0), np.abs(high).max(initial=0))
    if not tolerance > finest:
        raise SynthesisError(f"tolerance: found {tolerance}, needed a width above {finest:.1g}")
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    f_left, f_right = f(left), f(right)
    while (high - low).max(initial=0) > tolerance:
        better = f_left < f_right                            # the minimum is left of `right`
        low, high = np.where(better, low, left), np.where(better, right, high)
        kept, f_kept = np.where(better, left, right), np.where(better, f_left, f_right)
        new = np.where(better, high - GOLDEN * (high - low), low + GOLDEN * (high - low))
        f_new = f(new)
        left, right = np.where(better, new, kept), np.where(better, kept, new)
        f_left, f_right = np.where(better, f_new, f_kept), np.where(better, f_kept, f_new)
    return 0.5 * (low + high)


def best_alpha(error: Callable[[np.ndarray], np.ndarray], count: int, samples: int = SAMPLES,
               tolerance: float = GOLDEN_TOLERANCE) -> np.ndarray:
    """The search of section 7.2 for many pairs side by side: the best of M uniform samples of alpha
    in [-0.25, 1.25], then a golden-section search between its neighbours; the sample itself where
    the search ends higher.

    error : (count,) alphas, one a pair ->  (count,), smooth;  samples : M, at least 2
    ->  (count,) alphas.   Raises SynthesisError.

    >>> best_alpha(lambda alpha: (alpha - 0.3) ** 2, 1).round(4)
    array([0.3])
    """
    if samples < 2:
        raise SynthesisError(f"samples: found {samples}, needed at least 2 alphas to try")
    grid = np.linspace(LOWEST, HIGHEST, samples)
    best = np.argmin([error(np.full(count, alpha)) for alpha in grid], axis=0)
    alpha = golden_section(error, grid[np.maximum(best - 1, 0)],
                           grid[np.minimum(best + 1, samples - 1)], tolerance)
    return np.where(error(alpha) <= error(grid[best]), alpha, grid[best])


def rank_pairs(database: Database, model: StyleModel, pca: PrincipalComponents,
               members: Sequence[int] | np.ndarray, target: Sequence[float] | np.ndarray,
               samples: int = SAMPLES) -> list[Choice]:
    r"""The best alpha (`best_alpha`) of every ordered pair of members, the best pair first.

    Torresani 2006, Equation 12: alpha*, k*, l* = arg min || e - f(z_kl(alpha)) ||, over pairs of
    members and alpha in [-0.25, 1.25]; the first of the list.

    members : (K,) fragments, target : e (3,), samples : M, at least 2.
    Raises SynthesisError for fewer than two members, or a target outside [-3, 3].
    """
    target = check_style(target)
    if len(members) < 2:
        raise SynthesisError(f"members: found {len(members)} fragments of this content, needed at "
                             "least 2; a style is made between two performances of one action")
    pairs = np.array([(i, j) for i in members for j in members if i != j])
    return rank(coefficients(database, pca), database.styles, model, pairs, target, samples)


def rank(c: np.ndarray, e: np.ndarray, model: StyleModel, pairs: np.ndarray, target: np.ndarray,
         samples: int = SAMPLES) -> list[Choice]:
    """The same for pairs of fragments that have coefficients c (N, components) and styles e (N, 3).

    pairs : (M, 2), target : (3,)
    """
    def _predicted(alpha):
        return predict(model, blend_inputs(c, e, pairs, alpha))

    alpha = best_alpha(lambda alpha: np.linalg.norm(_predicted(alpha) - target, axis=1),
                       len(pairs), samples)
    predicted = _predicted(alpha)
    errors = np.linalg.norm(predicted - target, axis=1)
    return [Choice(int(pairs[n, 0]), int(pairs[n, 1]), float(alpha[n]), predicted[n],
                   float(errors[n])) for n in np.argsort(errors, kind="stable")]


def check_style(style: Sequence[float] | np.ndarray) -> np.ndarray:
    """(flow, weight, time), each from -3 to 3, as an array (3,).   Raises SynthesisError.

    >>> check_style([0, 3, -3])
    array([ 0.,  3., -3.])
    """
    style = np.asarray(style, dtype=float)
    if style.shape != (3,) or not (np.abs(style) <= LIMIT).all():
        raise SynthesisError(f"style: found {style}, needed flow, weight and time, each a number "
                             "from -3 to 3")
    return style


def synthesise(Y: Fragment, database: Database, model: StyleModel, pca: PrincipalComponents,
               target: Sequence[float] | np.ndarray, *, count: int = NEIGHBOURS,
               samples: int = SAMPLES, looks: int | None = None) -> Synthesis:
    """A motion with the content of Y and the style that is asked for (section 7), set down where Y
    begins.

    Y : of the database's body and frame rate;  model, pca : of `database.train`;
    target : (3,) flow, weight, time;  count, samples, looks : see `restyle`.
    Raises SynthesisError, SegmentError.
    """
    target = check_style(target)
    if Y.fps != database.fragments[0].fps:
        raise SynthesisError(f"{Y.name}: found {Y.fps:g} frames/s, needed "
                             f"{database.fragments[0].fps:g} as in the database")
    _, pieces = segment(Y.angles, [fragment.angles for fragment in database.fragments])
    return restyle(Y, pieces, database, model, pca, target, count=count, samples=samples,
                   looks=looks)


def restyle(Y: Fragment, pieces: Sequence[Piece], database: Database, model: StyleModel,
            pca: PrincipalComponents, target: Sequence[float] | np.ndarray, *,
            count: int = NEIGHBOURS, samples: int = SAMPLES, looks: int | None = None,
            persona: bool = False, by_piece: bool = False) -> Synthesis:
    """`synthesise` for a motion that is cut already.

    Torresani 2006, Equation 2: for each piece alpha*, k*, l* = arg min || e - f(X_k, X_l, e_k, e_l,
    alpha) || among the fragments X that match it (`rank_pairs`).

    count : K of section 7.2, within the content;  samples : M of `best_alpha`;  looks : how many of
    the best pairs are blended; of these the one is taken that the computed observer sees nearest to
    the target. 1 is equation 12, which trusts f alone, and the default where an analyst's labels
    count, since the computed observer cannot rate these; otherwise the default is 8.
    persona : the same two performers for all pieces, those whose errors' sum is least;
    by_piece : neighbours of the piece instead of the matched fragment's
    """
    looks = (1 if database.labelled else LOOKS) if looks is None else looks
    if looks < 1:
        raise SynthesisError(f"looks: found {looks}, needed at least 1 pair to blend")
    target, choices, parts, ranked = check_style(target), [], [], []
    for piece in pieces:
        members = neighbours(database, piece.fragment, count,
                             Y.angles[piece.start:piece.end] if by_piece else None)
        if len(members) < 2:
            content = database.fragments[piece.fragment].content
            raise SynthesisError(
                f"frames {piece.start} to {piece.end} match {content!r}: found {len(members)} "
                "fragment of it to blend, needed at least 2; add performances of this action to "
                "the database, or raise the number of neighbours")
        ranked.append(rank_pairs(database, model, pca, members, target, samples))
    if persona:
        ranked = _of_one_persona(ranked, database)
    for best in (choice[:looks] for choice in ranked):
        blends = [database.blend(c.i, c.j, c.alpha) for c in best]
        misses = [np.linalg.norm(observe(blend, database.observer) - target)
                  for blend in blends] if looks > 1 else [0.0]
        choices.append(best[int(np.argmin(misses))])
        parts.append(blends[int(np.argmin(misses))])
    root, floor = at_origin(parts[0].root, Y.root[0, HEADING], database.body), database.body.floor
    root[:, floor] += Y.root[0, floor]
    parts[0] = replace(parts[0], root=root)
    cuts = np.cumsum([0] + [part.frames for part in parts])
    return Synthesis(join(parts, database.body), tuple(int(cut) for cut in cuts), tuple(pieces),
                     tuple(choices))


def _of_one_persona(ranked, database):
    """Of each piece's choices those by the two performers whose best choices have the least sum of
    errors over all pieces."""
    if database.performers is None:
        raise SynthesisError("persona: found a database without performers' names, needed them in "
                             "the file names; see --pattern")
    who, errors = database.performers, []
    for choices in ranked:
        best: dict[tuple[str, str], float] = {}
        for c in choices:                                    # the best comes first
            best.setdefault((who[c.i], who[c.j]), c.error)
        errors.append(best)
    shared = set.intersection(*map(set, errors))
    if not shared:
        raise SynthesisError("persona: found no two performers near every piece, needed two; "
                             " raise the number of neighbours")
    pair = min(sorted(shared), key=lambda names: sum(best[names] for best in errors))
    return [[c for c in choices if (who[c.i], who[c.j]) == pair] for choices in ranked]


def observed_style(fragment: Fragment, cuts: Sequence[int], contents: Sequence[str | None],
                   observer: Observer) -> np.ndarray:
    """The computed observer on a motion of several actions: the mean of what it sees in each, those
    of fewer than four frames left out.

    cuts : the first frame of each and the end, contents : one each   ->  (3,)
    """
    parts = [(replace(fragment, angles=fragment.angles[a:b], root=fragment.root[a:b]), content)
             for a, b, content in zip(cuts, cuts[1:], contents) if b - a >= 4]
    if not parts:
        raise SynthesisError(
            f"{fragment.name}: found no action of four frames or more, needed one to observe")
    return np.mean([observe(part, observer, content) for part, content in parts], axis=0)


def contents_of(database: Database, pieces: Sequence[Piece]) -> list[str | None]:
    """The content of each piece, that of the fragment it matches."""
    return [database.fragments[piece.fragment].content for piece in pieces]
