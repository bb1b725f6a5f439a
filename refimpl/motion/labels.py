"""Which content and style a clip has: from file names, from a table, for parts of clips too."""

from collections.abc import Callable, Iterable, Mapping
import os
from pathlib import Path
import re
from typing import Any, NamedTuple

from ..storage import is_special
from .tables import read_table

PATTERN = r"(?:^|_)(?P<content>[^_]+)_(?P<style>[^_]+)_[^_]*$"       # dataset-1_walk_old_001
LABELLED = ["clip", "content", "style"]
HELD_OUT = 0.15


class Excerpt(NamedTuple):
    """Some rows of a clip, `end` not among them."""

    path: Path
    begin: int
    end: int


class LabelError(ValueError):
    """A label file or pattern that does not fit the clips; the message names file and line."""


def expression(pattern: str) -> re.Pattern[str]:
    """A regular expression.   Raises LabelError where it is none."""
    try:
        return re.compile(pattern)
    except re.error as why:
        raise LabelError(f"pattern {pattern!r}: found {why}, needed a regular expression") from None


def labels_by_pattern(paths: Iterable[Path],
                      pattern: str = PATTERN) -> dict[Path, tuple[str, str]]:
    """Labels from file names: `pattern` is searched in each name without its ending.

    paths : BVH files;  pattern : a regular expression with the groups content and style
    ->  {path: (content, style)} of the files that fit
    Raises LabelError when the pattern is no such expression.

    >>> list(labels_by_pattern([Path("a/dataset-1_walk_old_001.bvh")]).values())
    [('walk', 'old')]
    """
    regex = expression(pattern)
    if not {"content", "style"} <= set(regex.groupindex):
        raise LabelError(f"pattern {pattern!r}: needed the named groups (?P<content>...) and "
                         "(?P<style>...)")
    matches = ((path, regex.search(path.stem)) for path in paths)
    return {path: (match["content"], match["style"]) for path, match in matches
            if match and match["content"] and match["style"]}


def labels_from_file(paths: Iterable[Path], label_file: str | Path, folder: str | Path,
                     missing: Callable[[str], Any] = lambda name: None
                     ) -> dict[Any, tuple[str, str]]:
    """Labels from a CSV file with the header `clip,content,style`, or `clip,content,style,begin,
    end` for parts of clips; a clip is named by its path below the folder or, where no other clip
    has it, its file name. The Frame_Cuts.csv of 100STYLE is read as it is: a line a style, begin
    and end of each content.

    paths : BVH files in the folder;  missing : called with each clip of 100STYLE's table that is
    not among them  ->  {path or Excerpt: (content, style)}
    Raises LabelError naming the line: unknown clip, a name that several have, a clip or some of its
    rows named twice, an empty label, no such rows.
    """
    known: dict[str, list[Path]] = {}
    exact = {path.relative_to(folder).as_posix(): [path] for path in paths}
    for below, (path,) in exact.items():
        for name in {os.path.splitext(below)[0], path.name, path.stem}:
            known.setdefault(name, []).append(path)
    known |= exact
    labels: dict[Any, tuple[str, str]] = {}
    rows = read_table(label_file, "the header clip,content,style", LabelError)
    if rows and rows[0][:1] == ["STYLE_NAME"]:
        return _frame_cuts(rows, known, label_file, missing)
    parts = bool(rows) and rows[0] == [*LABELLED, "begin", "end"]
    if not rows or not (rows[0] == LABELLED or parts):
        found = ",".join(rows[0]) if rows else "an empty file"
        raise LabelError(f"{label_file}:1: found {found!r}, needed the header clip,content,style "
                         "or clip,content,style,begin,end")
    for line, row in enumerate(rows[1:], start=2):
        if not any(row):
            continue
        if len(row) != len(rows[0]) or not all(row):
            raise LabelError(f"{label_file}:{line}: found {','.join(row)!r}, needed "
                             f"{','.join(rows[0])}")
        if row[0] not in known:
            raise LabelError(f"{label_file}:{line}: found no clip {row[0]!r} in {folder}, needed "
                             "the name of a BVH file there")
        key: Any = _one(known[row[0]], row[0], f"{label_file}:{line}")
        if parts:
            key = _piece(key, row[3], row[4], f"{label_file}:{line}")
        if key in labels or parts and any(key.path == other.path and key.begin < other.end
                                          and other.begin < key.end for other in labels):
            rows_of = "rows of " if parts else ""
            raise LabelError(f"{label_file}:{line}: found {rows_of}{row[0]!r} a second time, "
                             "needed each once")
        labels[key] = (row[1], row[2])
    return labels


def _one(paths, name, where):
    if len(paths) > 1:
        raise LabelError(f"{where}: found {name!r}, which {len(paths)} clips are called "
                         f"({', '.join(map(str, paths[:3]))}), needed the path below the folder")
    return paths[0]


def _piece(path, begin, end, where):
    whole = all(re.fullmatch("[0-9]{1,9}", text) for text in (begin, end))
    if not whole or not int(begin) < int(end):
        raise LabelError(f"{where}: found rows {begin} to {end}, needed two whole numbers, the end "
                         "above the begin")
    return Excerpt(path, int(begin), int(end))


def _frame_cuts(rows, known, label_file, missing):
    """100STYLE's table: STYLE_NAME, then for each content NAME_START and NAME_STOP, or N/A."""
    labels: dict[Any, tuple[str, str]] = {}
    columns = {name.strip(): n for n, name in enumerate(rows[0])}
    contents = [name.removesuffix("_START") for name in columns if name.endswith("_START")]
    for line, row in enumerate(rows[1:], start=2):
        where = f"{label_file}:{line}"
        if any(row) and len(row) != len(rows[0]):
            raise LabelError(f"{where}: found {len(row)} cells, needed {len(rows[0])} as the "
                             "header has")
        for content in contents if any(row) else []:
            cut = [row[columns[f"{content}_{edge}"]] for edge in ("START", "STOP")]
            name = f"{row[0]}_{content}"
            if set(cut) <= {"N/A", ""}:
                continue
            if name not in known:
                missing(name)
            else:
                piece = _piece(_one(known[name], name, where), cut[0], cut[1], where)
                if piece in labels:
                    raise LabelError(f"{where}: found {name!r} a second time, needed each once")
                labels[piece] = (content, row[0])
    return labels


def find_clips(folder: str | Path) -> list[Path]:
    """The BVH files below a folder, sorted; where there are none, files of points (`.npy`, see
    `points`).

    Raises FileNotFoundError when there are neither, PermissionError for a folder that may not be
    read, LabelError for two files of one name (`walk.bvh`, `walk.BVH`).
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise FileNotFoundError(f"{folder}: found no such folder, needed a folder of BVH files")
    every = (Path(where, name) for where, _, names in os.walk(folder, onerror=_refuse)
             for name in names)
    found = sorted(path for path in every if path.suffix.lower() in (".bvh", ".npy"))
    if special := [str(path) for path in found if is_special(path)]:
        raise LabelError(f"{special[0]}: found a pipe or a device, needed files; take it out")
    paths = [path for path in found if path.suffix.lower() == ".bvh"] or found
    if not paths:
        raise FileNotFoundError(f"{folder}: found no BVH file in it or below, needed at least one")
    named: dict[Path, Path] = {}
    for path in paths:
        other = named.setdefault(path.with_suffix(""), path)
        if other is not path:
            raise LabelError(f"{path}: found {other.name} beside it, needed each name once, "
                             "whatever its ending; rename one of them")
    return paths


def _refuse(error):
    raise error


def piece_named(name: str, paths: Mapping[str, Path]) -> Excerpt | None:
    """What a clip of a dataset was read from.

    name : a name among the paths, with the rows of a part, if it is one

    >>> piece_named("walk[10:70]", {"walk": Path("walk.bvh")})
    Excerpt(path=PosixPath('walk.bvh'), begin=10, end=70)
    """
    part = re.fullmatch(r"(.*)\[(\d+):(\d+)\]", name)
    if name in paths or not part:
        return Excerpt(paths[name], 0, -1) if name in paths else None
    return Excerpt(paths[part[1]], int(part[2]), int(part[3])) if part[1] in paths else None


def hold_out(labels: dict[Any, tuple[str, str]], fraction: float = HELD_OUT) -> set[Any]:
    """Choose clips to keep out of training: of each group of n clips with the same labels the last
    floor(n fraction).

    labels : {clip: (content, style)}, clips in any order that can be sorted  ->  set of clips

    >>> sorted(hold_out({name: ("walk", "old") for name in "abcdef"}, 0.4))
    ['e', 'f']
    """
    groups: dict[tuple[str, str], list] = {}
    for clip in sorted(labels):
        groups.setdefault(labels[clip], []).append(clip)
    return {clip for group in groups.values()
            for clip in group[len(group) - int(len(group) * fraction):]}
