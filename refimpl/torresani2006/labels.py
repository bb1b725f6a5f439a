"""Labels by one or several analysts: a CSV file of motions and their flow, weight and time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path

import numpy as np

from ..motion.dataset import LabelError
from ..motion.tables import read_table
from .observe import EFFORTS, LIMIT

HEADER = ["clip", "start", "end", *EFFORTS]
ANALYST = "analyst"                     # a further column, which may be left out


@dataclass(frozen=True)
class Label:
    """One line of a label file.

    start, end : frames of the clip from 0, the end not included;  style : (3,) flow, weight, time;
    line : in the file;  analyst : who says so.
    """

    clip: str
    start: int
    end: int
    style: np.ndarray = field(repr=False)
    line: int
    analyst: str = ""


def read_labels(path: str | Path, frames: Mapping[str, int]) -> list[Label]:
    """Labels as they stand: a CSV file with the header `clip,start,end,flow,weight,time`, and
    `analyst` where several say something; empty start and end mean the whole clip, and a line
    without any effort has not been filled in. Semicolons with decimal commas do, too.

    frames : {clip: number of frames} of the clips there are.
    Raises LabelError naming the line: unknown clip, frames not in it, a value outside [-3, 3], a
    stretch labelled twice by one analyst; no label at all.
    """
    rows = read_table(path, f"the header {','.join(HEADER)}", LabelError)
    if rows and ";" in rows[0][0]:
        rows = [[cell.strip().replace(",", ".") for cell in ",".join(row).split(";")]
                for row in rows]
    header = [cell.lower() for cell in rows[0]] if rows else []
    if header not in (HEADER, [*HEADER, ANALYST]):
        raise LabelError(f"{path}:1: found {','.join(rows[0]) if rows else 'an empty file'!r}, "
                         f"needed the header {','.join(HEADER)}, with {ANALYST} behind it or not")
    labels: dict[tuple[str, int, int, str], Label] = {}
    for line, row in enumerate(rows[1:], start=2):
        if not any(row) or row[0].startswith("#"):
            continue
        if len(row) != len(header):
            raise LabelError(f"{path}:{line}: found {len(row)} values, needed {','.join(header)}")
        if not any(row[3:6]):
            continue
        label = _label(f"{path}:{line}", line, row, frames)
        first = labels.setdefault((label.clip, label.start, label.end, label.analyst), label)
        if first is not label:
            by = f" by {label.analyst!r}" if label.analyst else ""
            raise LabelError(
                f"{path}:{line}: found frames {label.start} to {label.end} of {label.clip!r} a "
                f"second time{by} (the first is in line {first.line}), needed each stretch once")
    if not labels:
        raise LabelError(f"{path}: found no line below the header with flow, weight and time, "
                         "needed at least one label")
    return list(labels.values())


def _label(where, line, row, frames):
    """One row, checked.   `where` begins every message.   ->  Label"""
    clip = next((name for name in (row[0], row[0].removesuffix(".bvh")) if name in frames), None)
    if clip is None:
        raise LabelError(f"{where}: found no clip {row[0]!r}, needed the name of one, such as "
                         f"{next(iter(frames), 'none')!r}")
    style = np.empty(3)
    for n, (name, word) in enumerate(zip(EFFORTS, row[3:])):
        try:
            style[n] = float(word)
        except ValueError:
            style[n] = np.nan
        if not abs(style[n]) <= LIMIT:
            raise LabelError(f"{where}: found {name} {word!r}, needed a number from -3 to 3")
    analyst = row[6] if len(row) > 6 else ""
    if not row[1] and not row[2]:
        return Label(clip, 0, frames[clip], style, line, analyst)
    if not (all(word.isascii() and word.isdigit() for word in row[1:3])
            and int(row[1]) < int(row[2]) <= frames[clip]):
        raise LabelError(
            f"{where}: found start {row[1]!r} and end {row[2]!r}, needed whole frames, start < end "
            f"<= {frames[clip]}, the length of {clip!r}; the end is not included")
    return Label(clip, int(row[1]), int(row[2]), style, line, analyst)


def joint(labels: Sequence[Label]) -> list[Label]:
    """One label a stretch: the mean of its analysts.

    >>> a, b = (Label("bow", 0, 9, np.full(3, x), 2, who) for x, who in ((1.0, "a"), (2.0, "b")))
    >>> joint([a, b])[0].style
    array([1.5, 1.5, 1.5])
    """
    found: dict[tuple[str, int, int], list[Label]] = {}
    for label in labels:
        found.setdefault((label.clip, label.start, label.end), []).append(label)
    return [replace(some[0], style=np.mean([label.style for label in some], axis=0), analyst="")
            for some in found.values()]


def overlaps(labels: Sequence[Label]) -> str:
    """What to warn of where stretches of one clip share frames, or "".

    >>> overlaps([Label("bow", a, b, np.zeros(3), line) for a, b, line in ((0, 9, 2), (5, 12, 3))])
    "lines 2 and 3: frames 0 to 9 and 5 to 12 of 'bow' overlap, and what they share counts twice"
    """
    ordered = sorted(labels, key=lambda x: (x.clip, x.start))
    found = [(a, b) for a, b in zip(ordered, ordered[1:]) if a.clip == b.clip and b.start < a.end]
    if not found:
        return ""
    a, b = found[0]
    return (f"lines {a.line} and {b.line}: frames {a.start} to {a.end} and {b.start} to {b.end} of "
            f"{a.clip!r} overlap, and what they share counts twice"
            + (f"; {len(found) - 1} more like these" if len(found) > 1 else ""))


def agreement(labels: Sequence[Label]) -> dict[str, dict[str, float]]:
    """How far analysts agree, by effort: the mean over pairs of analysts of their correlation, and
    the mean difference by size, over the stretches that both have labelled; nothing for one
    analyst.

    >>> agreement([Label("bow", 0, 9, np.zeros(3), 2)])
    {}
    """
    by: dict[str, dict[tuple, np.ndarray]] = {}
    for label in labels:
        by.setdefault(label.analyst, {})[label.clip, label.start, label.end] = label.style
    pairs = [np.array([(a[key], b[key]) for key in a if key in b])
             for a, b in combinations(by.values(), 2)]
    pairs = [pair for pair in pairs if len(pair) > 2]
    found = {}
    for n, effort in enumerate(EFFORTS if pairs else ()):
        both = [pair[:, :, n] for pair in pairs]
        varied = [x for x in both if (x.std(axis=0) > 0).all()]
        r = [np.corrcoef(x.T)[0, 1] for x in varied] or [np.nan]
        found[effort] = {"correlation": float(np.mean(r)),
                         "difference": float(np.mean([np.abs(x[:, 0] - x[:, 1]).mean()
                                                      for x in both]))}
    return found
