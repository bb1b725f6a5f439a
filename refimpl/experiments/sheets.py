"""Motions for an analyst to look at and a sheet to fill in, and Table 1 from the sheet that comes
back: fragments and blends in a random order, under names that tell nothing.

Which motion is which follows from the cast and the seed, so that no key is kept anywhere.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
import html
from pathlib import Path
from typing import Any

import numpy as np

from ..motion.body import make_take
from ..motion.bvh import write_bvh
from ..motion.dataset import LabelError
from ..storage import atomic_write
from ..torresani2006.align import HIGHEST, LOWEST
from ..torresani2006.database import Blends, Database, random_pairs
from ..torresani2006.labels import ANALYST, HEADER, agreement, joint, read_labels
from ..torresani2006.observe import EFFORTS, POLES
from ..torresani2006.poses import Fragment, clip_of
from .learning import PAPER_BLENDS, TRAINING, inputs_of, over_draws, table_1

FEWEST = 12                             # blends with labels that a table can be made of
A_PAGE = 3
_INDEX = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Motions to label</title></head><body>
<p>Look at each motion as often as you like and write into sheet.csv, from -3 to 3 and in any
fraction: {}. Judge how it is done, not what is done, beside the other motions of that action.
Several analysts: a name each in the last column, lines or sheets of their own.</p>
<ul>{}</ul></body></html>
"""


def motions_of(database: Database, blends: int = PAPER_BLENDS, seed: int = 0
               ) -> tuple[dict[str, Callable[[], Fragment]], np.ndarray, np.ndarray, list[str]]:
    """The fragments and random blends of a database under names in a random order.

    ->  {name: the motion when called}, pairs (blends, 2), alpha (blends,), the names of the
    fragments and then of the blends
    """
    rng = np.random.default_rng([seed, 19])
    pairs = random_pairs(database, blends, rng)
    alpha = rng.uniform(LOWEST, HIGHEST, blends)
    makers: list[Any] = [lambda f=f: f for f in database.fragments]
    makers += [lambda i=i, j=j, a=a: database.blend(i, j, a) for (i, j), a in zip(pairs, alpha)]
    places = rng.permutation(len(makers))
    names = [f"m{seed}_{place + 1:03d}" for place in places]
    return {names[n]: makers[n] for n in np.argsort(places)}, pairs, alpha, names


def export(database: Database, out: Path, blends: int = PAPER_BLENDS, seed: int = 0,
           report: Callable[[str], None] = lambda name: None, *,
           page: Callable[[Path, dict[str, np.ndarray]], Any]) -> int:
    """Write clips/*.bvh, index.html with the pages, and sheet.csv.

    page : writes a file with a player of motions {name: (T, 21, 3)} at 60 frames a second
    ->  how many motions
    """
    motions, *_ = motions_of(database, blends, seed)
    for folder in ("clips", "pages"):
        (out / folder).mkdir(parents=True, exist_ok=True)
    names, links = list(motions), []
    for first in range(0, len(names), A_PAGE):
        seen = {}
        for name in names[first:first + A_PAGE]:
            clip = clip_of(motions[name](), database.body)
            write_bvh(out / "clips" / f"{name}.bvh", clip)
            try:
                seen[name] = make_take(clip).positions
            except ValueError:                               # a body that the player cannot draw
                pass
            report(name)
        if seen:
            name = f"pages/{names[first]}.html"
            page(out / name, seen)
            links.append(f'<li><a href="{name}">{html.escape(", ".join(seen))}</a></li>')
    with atomic_write(out / "index.html") as file:
        file.write(_INDEX.format("; ".join(f"{e}: {p}" for e, p in zip(EFFORTS, POLES)),
                                 "\n".join(links)))
    with atomic_write(out / "sheet.csv") as file:
        file.write("\n".join([",".join([*HEADER, ANALYST]), *(f"{n},,,,,," for n in names)]) + "\n")
    return len(names)


def from_sheets(database: Database, sheets: Sequence[str | Path], blends: int = PAPER_BLENDS,
                seed: int = 0) -> tuple[np.ndarray, np.ndarray, dict[str, Any]]:
    """What sheets say of the blends of a database.

    ->  z (N, d) with the labels of the parents, labels (N, 3), and what is told: analysts, motions
    with a label, blends left out for want of one, agreement.   Raises LabelError.
    """
    motions, pairs, alpha, names = motions_of(database, blends, seed)
    said = []
    for n, sheet in enumerate(sheets):
        read = read_labels(sheet, dict.fromkeys(motions, 1))
        said += [replace(x, analyst=x.analyst or f"sheet {n + 1}") for x in read]
    style = {label.clip: label.style for label in joint(said)}
    count = len(database.fragments)
    known = [style.get(name) for name in names]
    some = [n for n, (i, j) in enumerate(pairs)
            if not any(known[k] is None for k in (count + n, i, j))]
    if len(some) < FEWEST:
        raise LabelError(f"{', '.join(map(str, sheets))}: found {len(some)} blends with labels "
                         f"and with parents that have some, needed {FEWEST}; fill in more lines")
    styles = [np.zeros(3) if x is None else x for x in known]
    complete = replace(database, fragments=tuple(
        replace(f, style=e) for f, e in zip(database.fragments, styles)))
    Y = np.array([styles[count + n] for n in some])
    Z = inputs_of(complete, Blends(pairs[some], alpha[some], Y))
    return Z, Y, {"analysts": sorted({x.analyst for x in said}), "motions": len(style),
                  "blends": len(some), "blends left out": blends - len(some),
                  "agreement": agreement(said)}


def table_of_sheets(Z: np.ndarray, Y: np.ndarray, draws: int = 10, seed: int = 0) -> dict[str, Any]:
    """Table 1 from labels: the paper's share of the blends to learn from, ten times five splits,
    whose spread is that of the splits alone.   ->  as `learning.over_draws`
    """
    training = round(len(Z) * TRAINING / PAPER_BLENDS)
    return over_draws(table_1(lambda rng: (Z, Y), draws, training=training, seed=seed))
