"""Experiments of section 8 on contents and phrases: grouping, and segmentation of known fragments
and of newcomers.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..torresani2006.align import all_pairs, clusters, read_at, threshold_for
from ..torresani2006.content import each_once, groups, without_habits
from ..torresani2006.database import Database, without
from ..torresani2006.join import SEAM, join
from ..torresani2006.poses import Fragment
from ..torresani2006.segment import segment
from ..torresani2006.synthesise import contents_of
from .torresani import Cast

CUT_TOLERANCE = 3                               # frames by which a cut may miss its place: 0.1 s
RATES = ("sequences", "contents", "cuts", "fragments", "merged", "frames", "majority")
POSE_NOISE, WARP = 0.02, 0.3                     # radians; how far the speed strays from 1


def disguised(angles: np.ndarray, rng: np.random.Generator, warp: float = WARP,
              noise: float = POSE_NOISE) -> np.ndarray:
    """The same motion, its speed straying smoothly from 1 by up to `warp`, and every angle with
    Gaussian noise.   (T, D)  ->  (T', D)
    """
    u = np.linspace(0, 1, len(angles))
    speed = 1 + warp * np.sin(2 * np.pi * (rng.uniform(0.5, 1.5) * u + rng.uniform()))
    arrival = np.concatenate([[0], np.cumsum(0.5 * (1 / speed[1:] + 1 / speed[:-1]))])
    frames = max(2, round(arrival[-1]) + 1)
    played = np.interp(np.linspace(0, arrival[-1], frames), arrival, np.arange(len(angles)))
    return read_at(angles, played) + noise * rng.normal(size=(frames, angles.shape[1]))


def cut_again(database: Database, trials: int = 40, length: int = 5, *, seed: int = 0,
              warp: float = WARP, noise: float = POSE_NOISE,
              tolerance: int = CUT_TOLERANCE) -> dict[str, float]:
    """Sequences of `length` known fragments, warped and with noise, segmented by the whole
    database.

    ->  {"sequences": share cut into the right contents with every cut within `tolerance` frames,
    "contents": share with the right contents in order, "cuts": share of the cuts within
    `tolerance`, "fragments": share of the pieces matched by the very fragment, "merged": share with
    the right contents once neighbouring pieces of one content count as one}
    """
    rng, results = np.random.default_rng([seed, 13]), []
    for _ in range(trials):
        chosen = rng.choice(len(database.fragments), length, replace=False)
        parts = [disguised(database.fragments[n].angles, rng, warp, noise) for n in chosen]
        cuts = np.cumsum([len(part) for part in parts])[:-1]
        contents = [database.fragments[n].content for n in chosen]
        results.append(_compare(database, np.concatenate(parts), cuts, contents, tolerance, chosen))
    return _rates(results)


def cut_newcomers(cast: Cast, *, orders: int = 1, seed: int = 0, habits: bool = True,
                  seam: float = SEAM, tolerance: int = CUT_TOLERANCE,
                  report: Callable[[str], None] = lambda name: None) -> dict[str, Any]:
    """Each performer's actions in phrases of random order, joined, and segmented by the fragments
    of all others.

    orders : phrases of each;  habits : leave them in, by equation 3 as printed, or take them out
    and whiten (`content`);  seam : see `join.join`
    ->  as `cut_again`, and "spread": the standard error of "contents" over the orders
    """
    results: list[list] = [[] for _ in range(orders)]
    for name in dict.fromkeys(cast.performer):
        others = without(cast.database, cast.performer != name)
        view = None if habits else others.contents()
        for n in range(orders):
            phrase, cuts, contents, _ = newcomer(
                cast, name, np.random.default_rng([seed, 14, n, *map(ord, name)]), seam)
            results[n].append(_compare(others, phrase.angles, cuts[1:-1], contents, tolerance, None,
                                       view))
        report(name)
    right = [np.mean([row[1] for row in rows]) for rows in results]
    spread = np.std(right, ddof=1) / np.sqrt(orders) if orders > 1 else 0.0
    rates = _rates([row for rows in results for row in rows])
    rates.pop("fragments")                                   # the very fragment is not there
    return {**rates, "spread": float(spread)}


def newcomer(cast: Cast, name: str, rng: np.random.Generator, seam: float = SEAM
             ) -> tuple[Fragment, tuple[int, ...], list[str], Database]:
    """One performer's actions joined in random order, and the database of all others.
    ->  the joined motion, its cuts, its contents, the database
    """
    own = rng.permutation(np.flatnonzero(cast.performer == name))
    parts = [cast.database.fragments[n] for n in own]
    cuts = tuple(int(cut) for cut in np.cumsum([0] + [part.frames for part in parts]))
    return (join(parts, cast.database.body, seam), cuts, [part.content for part in parts],
            without(cast.database, cast.performer != name))


def _compare(database, Y, cuts, contents, tolerance, chosen, view=None):
    """->  (all right, contents right, share of cuts found, share of the very fragments, contents
    right when merged, share of frames with the right content, share of the true pieces whose
    majority label is right), in the order of RATES
    """
    _, pieces = view.cut(Y) if view else segment(Y, [f.angles for f in database.fragments])
    found = contents_of(database, pieces)
    right, ends = found == list(contents), np.array([piece.end for piece in pieces[:-1]])
    near = [bool(len(ends)) and int(np.abs(ends - cut).min()) <= tolerance for cut in cuts]
    same = 0.0
    if right:
        same = float("nan") if chosen is None else np.mean(
            [piece.fragment == n for piece, n in zip(pieces, chosen)])
    said = np.repeat(np.array(found), [piece.end - piece.start for piece in pieces])
    stretches = np.split(said, cuts)
    hits = [np.mean(part == name) for part, name in zip(stretches, contents)]
    return (right and all(near), right, np.mean(near), same, _merged(found) == _merged(contents),
            np.average(hits, weights=[len(part) for part in stretches]),
            np.mean(np.array(hits) > 0.5))


def _merged(contents):
    return [content for n, content in enumerate(contents) if n == 0 or content != contents[n - 1]]


def _rates(results):
    return dict(zip(RATES, np.array(results, dtype=float).mean(axis=0).tolist()))


def adjusted_rand(a: Sequence[Any], b: Sequence[Any]) -> float:
    """How far two groupings agree, 1 for the same, 0 for chance (Hubert and Arabie 1985).

    >>> adjusted_rand([0, 0, 1, 1], ["x", "x", "y", "y"])
    1.0
    """
    table = np.array([[sum(x == i and y == j for x, y in zip(a, b)) for j in set(b)]
                      for i in set(a)])

    def _pairs(counts):
        return float((counts * (counts - 1) / 2).sum())
    both, one, other = _pairs(table), _pairs(table.sum(axis=1)), _pairs(table.sum(axis=0))
    chance = one * other / max(_pairs(np.array([len(a)])), 1.0)
    return (both - chance) / (0.5 * (one + other) - chance) if one + other > 2 * chance else 1.0


def contents_found(cast: Cast) -> dict[str, dict[str, float]]:
    """"All fragments were automatically clustered into 5 groups" (section 8), three ways: section
    4's chains of matches; complete linkage of SSD a frame, habits out; the same with each
    performer's actions all different (`content.each_once`).   ->  {way: {"adjusted Rand index",
    "largest"}}
    """
    fragments, who = cast.database.fragments, cast.performer.tolist()
    names = [f.content for f in fragments]
    count, lengths = len(set(names)), np.array([f.frames for f in fragments])
    far = all_pairs(without_habits([f.angles for f in fragments], who)) / (
        lengths[:, None] + lengths)
    ways = {"chains of matches (section 4)":
            clusters(cast.database.ssd, threshold_for(cast.database.ssd, count)),
            "complete linkage, habits out": groups(far, count)[0],
            "each action once a performer": each_once(far, who)}
    return {way: {"adjusted Rand index": round(adjusted_rand(names, found.tolist()), 3),
                  "largest": int(np.bincount(found).max())} for way, found in ways.items()}
