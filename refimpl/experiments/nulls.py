"""A table of results, scored row by row and system by system, with the nulls that bound it:

    content copied       nothing done: no style, every column of the content at its best
    exemplar copied      the style without the content: `kept` and the path are lost
    shuffled pairs       results beside contents and styles of other rows: what is seen by chance
    another real take    the level to reach
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .judges import Judges, frechet
from .score import Track, compare, summary

ScoreRow = dict[str, Any]
COPIED, EXEMPLAR, SHUFFLED, REAL = ("null: content copied", "null: exemplar copied",
                                    "null: shuffled pairs", "null: another real take")
SEEN_AS_REAL, LOST, SLACK = 0.75, 0.5, 2.0       # shares, a correlation, standard errors


@dataclass(frozen=True)
class Entry:
    """A row of a table: motions, and the names that the judges should say.

    facts : what is told of it beside its numbers
    """

    content: Track
    exemplar: Track
    result: Track
    system: str
    content_label: str
    style_label: str
    facts: Mapping[str, Any]


def score_entry(entry: Entry, judges: Judges | None) -> tuple[ScoreRow, np.ndarray | None]:
    """The numbers of a row, and where the judge of joints sees its windows."""
    row: ScoreRow = {"row": "result", "system": entry.system, **entry.facts,
                     "style asked for": entry.style_label, "content asked for": entry.content_label,
                     "frames": len(entry.result.positions)}
    windows = None
    if judges:
        said, windows = judges.look(entry.result)
        wanted = {"style": entry.style_label, "content": entry.content_label}
        for name, told in said.items():
            what = name.split()[0]
            row[f"{name}, told"] = told
            known = judges.facts[f"{what}s"]
            row[f"{what} seen{name.removeprefix(what)}"] = (
                told == wanted[what] if wanted[what] in known else None)
        row["Fréchet distance"] = (frechet(judges, entry.style_label, [windows])
                                   if entry.style_label in judges.facts["styles"] else None)
    return {**row, **compare(entry.result, entry.content)}, windows


def score_table(entries: Sequence[Entry], judges: Judges | None, *, nulls: bool = False,
                done: Callable[[], Any] = lambda: None) -> Iterator[ScoreRow]:
    """Rows of results, then of systems, then of the nulls.   done : called after each result"""
    scored = []
    for entry in entries:
        scored.append(score_entry(entry, judges))
        yield scored[-1][0]
        done()
    for system in dict.fromkeys(entry.system for entry in entries):
        own = [pair for pair, entry in zip(scored, entries) if entry.system == system]
        yield system_row(system, own, judges)
    if nulls:
        for name, made in null_entries(entries, [row for row, _ in scored], judges):
            if made:
                row = system_row(name, [score_entry(entry, judges) for entry in made], judges)
                yield row | _bound(name, row, made)


def system_row(system: str, scored: Sequence[tuple[ScoreRow, Any]],
               judges: Judges | None) -> ScoreRow:
    """What is usual over the rows of a system (`score.summary`), and its Fréchet distance to the
    real clips of each style, on average."""
    numbers = summary([{k: v for k, v in row.items() if k not in ("Fréchet distance", "line")}
                       for row, _ in scored])
    line: ScoreRow = {"row": "system", "system": system, "results": len(scored), **numbers}
    if judges:
        by_style: dict[str, list] = {}
        for row, windows in scored:
            if row["Fréchet distance"] is not None:
                by_style.setdefault(row["style asked for"], []).append(windows)
        each = [frechet(judges, style, sorted(of, key=lambda w: tuple(w[0])))
                for style, of in sorted(by_style.items())]
        line |= {"Fréchet distance": float(np.mean(each)) if each else None,
                 "style by chance": 1 / len(judges.facts["styles"]),
                 "content by chance": 1 / max(1, len(judges.facts["contents"]))}
    return line


def null_entries(entries: Sequence[Entry], rows: Sequence[ScoreRow],
                 judges: Judges | None) -> Iterator[tuple[str, list[Entry]]]:
    """The entries of each null: of each pair of content and style once, shuffled for each system.

    rows : of the entries
    """
    pairs = list({(id(e.content), id(e.exemplar)): e for e in entries}.values())
    yield COPIED, [replace(e, result=e.content) for e in pairs]
    yield EXEMPLAR, [replace(e, result=e.exemplar) for e in pairs]
    for system in dict.fromkeys(e.system for e in entries):
        # in an order that neither names nor places in the table decide
        keys = [(row["style asked for"], row["content asked for"],
                 round(row["movement kept (correlation)"], 6), n) for n, row in enumerate(rows)]
        own = [entries[key[-1]] for key in sorted(keys) if entries[key[-1]].system == system]
        order = np.random.default_rng(0).permutation(len(own))
        yield f"{SHUFFLED} of {system}", [replace(e, result=own[n].result, facts={
            "by chance": [own[n].style_label == e.style_label,
                          own[n].content_label == e.content_label]})
            for e, n in zip(own, order) if own[n] is not e]
    real = []
    for e in pairs:
        of_style = [c for c in (judges.kept_back if judges else ()) if c.style == e.style_label]
        same = [c for c in of_style if c.content == e.content_label]
        real += [replace(e, result=judges.motion(c)) for c in (same or of_style)[:1] if judges]
    yield REAL, real


def _bound(name, row, made):
    """What a null must show, and whether it does."""
    style, content = (row.get(f"{what} seen by joints") for what in ("style", "content"))
    if name == COPIED:
        own = np.mean([e.style_label == e.facts.get("style of content") for e in made])
        most = max(own, row["style by chance"]) if style is not None else 1.0
        return {"bound": "no style beyond the content's own, path and bones as they were",
                "holds": bool(max(row["path error (legs)"], row["bones off (share)"]) < 1e-6
                              and _at_most(style, most, made))}
    if name == EXEMPLAR:
        lost = min(row["movement kept (correlation)"], row["path met"])
        return {"bound": f"style seen by {SEEN_AS_REAL:.0%}, path or movement below {LOST}",
                "holds": bool(lost < LOST and (style is None or style >= SEEN_AS_REAL))}
    if name == REAL:
        return {"bound": "the level to reach", "holds": None}
    chances = np.mean([e.facts["by chance"] for e in made], axis=0)
    return {"bound": f"style and content seen by chance, {chances[0]:.0%} and {chances[1]:.0%}",
            "holds": None if style is None else all(
                _at_most(*pair, made) for pair in zip((style, content), chances))}


def _at_most(seen, chance, made):
    """Whether no more is seen than by chance, within `SLACK` standard errors."""
    usual = min(max(chance, 1 / len(made)), 1 - 1 / max(2, len(made)))
    return seen is None or bool(seen <= chance + SLACK * np.sqrt(usual * (1 - usual) / len(made)))
