"""Styles asked for and seen (section 8): every performer in turn is the input and all others are
the database; equation 12 and what may be changed about it, beside what doing nothing would give.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..torresani2006.align import pair_costs
from ..torresani2006.blend import peak_acceleration, standing
from ..torresani2006.content import Contents, without_habits
from ..torresani2006.database import Database
from ..torresani2006.efforts import BY_PATHS
from ..torresani2006.join import join
from ..torresani2006.observe import LIMIT, fit_observer
from ..torresani2006.pca import PrincipalComponents
from ..torresani2006.poses import Body, Fragment, clip_of, fragment_positions
from ..torresani2006.regress import StyleModel
from ..torresani2006.segment import Piece
from ..torresani2006.synthesise import contents_of, observed_style, restyle
from .phrases import newcomer
from .torresani import Cast

NARROW = 4                                 # neighbours, where 7.2's choice of them is to matter
AT_A_SEAM = 0.2                         # seconds on either side of it
CHOOSING: dict[str, dict[str, Any]] = {     # options of `restyle`; equation 12 alone first
    "equation 12": {"looks": 1},
    f"{NARROW} neighbours of the match (7.2)": {"looks": 1, "count": NARROW},
    f"{NARROW} neighbours of the piece": {"looks": 1, "count": NARROW, "by_piece": True},
    "one persona": {"looks": 1, "persona": True},
    "best seen of 8": {"looks": 8}}


def asked_and_seen(cast: Cast,
                   train: Callable[[Database], tuple[StyleModel, PrincipalComponents]], *,
                   trials: int = 3, seed: int = 0,
                   report: Callable[[str], None] = lambda name: None) -> dict[str, dict[str, Any]]:
    """Ask for styles at least 1 from all that the fragments have (the paper's were "considerably
    different" from those of training) and observe what comes of it.

    The judge looks at paths, the observer that labels and chooses at swings. The nulls: the input
    as it is, a motion of style 0, a random fragment of the content for each piece, and the one
    whose label is nearest.

    "True cuts", and these with the true contents, tell what better segmentation would do for
    equation 12; random fragments of the true contents, how far "kept" can be trusted.

    train : see `database.train`;  trials : styles, of each performer
    ->  {way: row} with "nearer": the share judged nearer to the style asked for than the input is,
    and its standard error over performers; "error": mean squared, by effort; "r": correlation of
    asked and seen, by effort; "kept": share of pieces that look most like what is done there, among
    the actions of all performers of whom they are not made, habits taken out and whitened; medians
    of "peak" and "seam", the largest acceleration of the whole and within 0.2 s of a seam, beside
    the input's largest; and of "slide" of planted feet, in the file's unit a second, once they are
    held (`blend.standing`)
    """
    rng, rows = np.random.default_rng([seed, 15]), []
    for name in dict.fromkeys(cast.performer):
        phrase, cuts, truth, others = newcomer(cast, name, rng)
        model, pca = train(others)
        view = others.contents()
        _, pieces = view.cut(phrase.angles)
        better = {"true cuts": _matched(view, phrase.angles, cuts, None),
                  "true cuts and contents": _matched(view, phrase.angles, cuts, truth)}
        contents, body = contents_of(others, pieces), others.body
        judge = fit_observer(others.fragments, body, BY_PATHS)
        own = [f for f, who in zip(cast.database.fragments, cast.performer) if who == name]
        poses = without_habits([f.angles for f in own], [name] * len(own))
        looked = ([*view.sequences, *(x @ view.whitening for x in poses)],
                  [*view.names, *(f.content for f in own)],
                  [*cast.performer[cast.performer != name], *[name] * len(own)])
        who, done, peak = looked[2], _done(pieces, cuts, truth), peak_acceleration(phrase, body)
        for _ in range(trials):
            target = _beyond(others.styles, rng)
            made: dict[str, tuple[Any, ...]] = {"the input": (
                phrase, (0, *(piece.end for piece in pieces)), contents, done,
                [{name}] * len(pieces))}
            for way, known, words, real, options in (
                    *((way, pieces, contents, done, given) for way, given in CHOOSING.items()),
                    *((way, some, contents_of(others, some), truth, {"looks": 1})
                      for way, some in better.items())):
                one = restyle(phrase, known, others, model, pca, target, **options)
                made[way] = (one.fragment, one.cuts, words, real,
                             [{who[c.i], who[c.j]} for c in one.choices])
            for way, acted, real, chosen in (
                    ("random fragments", contents, done, _random(others, contents, rng)),
                    ("nearest fragments", contents, done, _nearest(others, contents, target)),
                    ("random fragments, true contents", truth, truth,
                     _random(others, truth, rng))):
                parts = [others.fragments[n] for n in chosen]
                at = np.cumsum([0, *(f.frames for f in parts)]).tolist()
                made[way] = join(parts, body), at, acted, real, [{who[n]} for n in chosen]
            row = {way: {"seen": observed_style(f, at, words, judge),
                         "kept": np.mean([_alike(x @ view.whitening, looked, but) == word
                                          for x, word, but in zip(np.split(
                                              f.angles - f.angles.mean(axis=0), at[1:-1]),
                                              real, parents)]),
                         **_played(f, at, body, peak)}
                   for way, (f, at, words, real, parents) in made.items()}
            row["style 0"] = {"seen": np.zeros(3)}
            rows.append((name, target, row))
        report(name)
    return {way: _told(way, rows) for way in rows[0][2]}


def _matched(view: Contents, angles, cuts, names) -> list[Piece]:
    """Pieces between known cuts, each matched by the nearest fragment, of its content if known."""
    seen, found = (angles - angles.mean(axis=0)) @ view.whitening, []
    for n, (start, end) in enumerate(zip(cuts, cuts[1:])):
        some = [k for k, name in enumerate(view.names) if names is None or name == names[n]]
        best = _nearest_pose(seen[start:end], [view.sequences[k] for k in some])
        found.append(Piece(some[best], start, end, 0.0))
    return found


def _done(pieces: Sequence[Piece], cuts, truth):
    """What the input does in each piece, for most of its frames."""
    frames = np.repeat(np.array(truth), np.diff(cuts))
    found = [np.unique(frames[p.start:p.end], return_counts=True) for p in pieces]
    return [names[counts.argmax()] for names, counts in found]


def _nearest_pose(angles, sequences):
    """Which of some sequences is nearest, by SSD a frame."""
    return int(np.argmin(_far(angles, sequences)))


def _far(angles, sequences):
    """SSD a frame of every other frame."""
    return pair_costs([(angles[::2], x[::2]) for x in sequences]) / [
        len(angles) + len(x) for x in sequences]


def _alike(angles, looked, but):
    """The content of which the three nearest performances are nearest (their median), by others
    than some performers."""
    sequences, names, who = looked
    some = [n for n, name in enumerate(who) if name not in but]
    far = _far(angles, [sequences[n] for n in some])
    return min(dict.fromkeys(names), key=lambda name: np.median(np.sort(
        [x for x, n in zip(far, some) if names[n] == name] or [np.inf])[:3]))


def _played(fragment: Fragment, at: Sequence[int], body: Body, peak: float) -> dict[str, float]:
    bend = np.linalg.norm(np.diff(fragment_positions(fragment, body), 2, axis=0), axis=-1).max(
        axis=1) * fragment.fps ** 2 / peak
    wide = round(AT_A_SEAM * fragment.fps)
    return {"peak": bend.max(), "slide": standing(clip_of(fragment, body))[2],
            "seam": max((bend[max(0, cut - wide):cut + wide].max() for cut in at[1:-1]),
                        default=0.0)}


def _told(way, rows):
    """A way's row of the table, rounded."""
    asked, seen, given = np.array([(target, row[way]["seen"], row["the input"]["seen"])
                                   for _, target, row in rows]).transpose(1, 0, 2)
    nearer = (np.linalg.norm(seen - asked, axis=1) < np.linalg.norm(given - asked, axis=1))
    by = [nearer[[who == name for who, *_ in rows]].mean() for name in {who for who, *_ in rows}]
    found: dict[str, Any] = {
        "nearer": [nearer.mean(), np.std(by, ddof=1) / np.sqrt(len(by)) if len(by) > 1 else 0.0],
        "error": ((seen - asked) ** 2).mean(axis=0)}
    if way != "style 0":
        found["r"] = [np.corrcoef(asked[:, n], seen[:, n])[0, 1] for n in range(3)]
        found["kept"] = np.mean([row[way]["kept"] for *_, row in rows])
        found |= {word: np.median([row[way][word] for *_, row in rows])
                  for word in ("peak", "seam", "slide")}
    return {word: np.round(x, 2).tolist() for word, x in found.items()}


def _beyond(styles, rng):
    """A style at least 1 from all that there are, or the farthest of a hundred."""
    tried = rng.uniform(-LIMIT, LIMIT, (100, 3))
    away = np.linalg.norm(tried[:, None] - styles, axis=-1).min(axis=1)
    return tried[np.argmax(away >= 1)] if (away >= 1).any() else tried[away.argmax()]


def _random(database, contents, rng):
    return [rng.choice([n for n, f in enumerate(database.fragments) if f.content == content])
            for content in contents]


def _nearest(database, contents, target):
    return [min((n for n, f in enumerate(database.fragments) if f.content == content),
                key=lambda n: np.linalg.norm(database.fragments[n].style - target))
            for content in contents]
