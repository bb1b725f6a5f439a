"""A folder of clips as one file of features with labels: what the networks are trained on."""

from collections.abc import Callable, Iterable
from concurrent.futures import Executor
from dataclasses import dataclass, field
import functools
from pathlib import Path
import re
from typing import Any

import numpy as np

from ..storage import FormatError, load_npz, plausible, read_table, save_npz
from .body import Take, features_on, read_take
from .canonical import mean_body, measured
from .features import FEATURES, FPS, LEG_RANGE
from .joints import BONES, FEET, JOINTS

FORMAT, VERSION = "motions", 2       # with 2 the root's velocity is seen from the frame it leads to
PATTERN = r"(?:^|_)(?P<content>[^_]+)_(?P<style>[^_]+)_[^_]*$"       # dataset-1_walk_old_001
HELD_OUT = 0.15


@dataclass(frozen=True)
class Labelled:
    """One clip and its labels.

    held_out : whether it is kept out of training
    features (T, 66) float64, contacts (T, 4) bool : at 60 frames a second
    fps : frames a second of the recording that it was made of
    """

    name: str
    content: str
    style: str
    held_out: bool
    features: np.ndarray = field(repr=False)
    contacts: np.ndarray = field(repr=False)
    fps: float = FPS


@dataclass(frozen=True)
class Dataset:
    """Labelled clips, of any skeletons, on one body.

    leg : leg length, in the unit of all features
    bones : (20,) lengths in the order of `joints.BONES`;  source : where they came from
    rest : (21, 3) of the body (`canonical.Physique`)
    """

    clips: tuple[Labelled, ...]
    leg: float
    bones: np.ndarray
    source: str
    rest: np.ndarray | None = field(default=None, repr=False)

    def select(self, *, style: str | None = None, content: str | None = None,
               held_out: bool | None = None, name: str | None = None) -> tuple[Labelled, ...]:
        """The clips with these labels, in whose name the regular expression `name` is found, in
        order; None takes all.   Raises LabelError on a bad expression.
        """
        found = _expression(name or "").search
        return tuple(c for c in self.clips
                     if style in (None, c.style) and content in (None, c.content)
                     and held_out in (None, c.held_out) and found(c.name))

    @property
    def styles(self) -> list[str]:
        """The styles that occur, sorted."""
        return sorted({clip.style for clip in self.clips})


class LabelError(ValueError):
    """A label file or pattern that does not fit the clips; the message names file and line."""


def _expression(pattern):
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
    expression = _expression(pattern)
    if not {"content", "style"} <= set(expression.groupindex):
        raise LabelError(f"pattern {pattern!r}: needed the named groups (?P<content>...) and "
                         "(?P<style>...)")
    matches = ((path, expression.search(path.stem)) for path in paths)
    return {path: (match["content"], match["style"]) for path, match in matches if match}


def labels_from_file(paths: Iterable[Path], label_file: str | Path,
                     folder: str | Path) -> dict[Path, tuple[str, str]]:
    """Labels from a CSV file with the header `clip,content,style`; a clip is named by its path
    below the folder or its file name.

    paths : BVH files in the folder  ->  {path: (content, style)}
    Raises LabelError naming the line: unknown clip, one named twice, an empty label.
    """
    known: dict[str, Path] = {}
    for path in paths:
        for name in (path.relative_to(folder).as_posix(), path.name, path.stem):
            known.setdefault(name, path)
    labels: dict[Path, tuple[str, str]] = {}
    rows = read_table(label_file, "the header clip,content,style", LabelError)
    if not rows or rows[0] != ["clip", "content", "style"]:
        found = ",".join(rows[0]) if rows else "an empty file"
        raise LabelError(f"{label_file}:1: found {found!r}, needed the header clip,content,style")
    for line, row in enumerate(rows[1:], start=2):
        if not any(row):
            continue
        if len(row) != 3 or not all(row):
            raise LabelError(f"{label_file}:{line}: found {','.join(row)!r}, needed "
                             "clip,content,style")
        if row[0] not in known:
            raise LabelError(f"{label_file}:{line}: found no clip {row[0]!r} in {folder}, needed "
                             "the name of a BVH file there")
        if known[row[0]] in labels:
            raise LabelError(f"{label_file}:{line}: found {row[0]!r} a second time, needed each "
                             "clip once")
        labels[known[row[0]]] = (row[1], row[2])
    return labels


def find_clips(folder: str | Path) -> list[Path]:
    """The BVH files below a folder, sorted.   Raises FileNotFoundError when there are none."""
    folder = Path(folder)
    if not folder.is_dir():
        raise FileNotFoundError(f"{folder}: found no such folder, needed a folder of BVH files")
    paths = sorted(path for path in folder.rglob("*")
                   if path.suffix.lower() == ".bvh" and path.is_file())
    if not paths:
        raise FileNotFoundError(f"{folder}: found no BVH file in it or below, needed at least one")
    return paths


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


def prepare(folder: str | Path, labels: dict[Path, tuple[str, str]], *,
            fraction: float = HELD_OUT, overrides: dict[str, str] | None = None,
            report: Callable[[Path], Any] = lambda path: None,
            executor: Executor | None = None) -> Dataset:
    """Read the labelled clips of a folder and make their features.

    labels : {path: (content, style)};  fraction : of each group kept out of training
    overrides : {slot: joint} for odd skeletons
    report : called with each path when it has been read;  executor : whose workers read them
    ->  Dataset.   Raises LabelError where there are none, and what `read_take` raises.
    """
    if not labels:
        raise LabelError(f"{folder}: found no clip with labels, needed at least one; does the "
                         "pattern fit the file names?")
    named = {path.relative_to(folder).with_suffix("").as_posix(): path for path in sorted(labels)}
    read_one = functools.partial(_read_part, overrides=overrides)
    if executor:                     # not its map, which cancels what runs when it is stopped
        futures = [executor.submit(read_one, path) for path in named.values()]
        read = (future.result() for future in futures)
    else:
        read = (read_one(path) for path in named.values())
    parts = {}
    for (name, path), part in zip(named.items(), read):
        report(path)
        parts[name] = part
    return _assemble(parts, {name: labels[path] for name, path in named.items()},
                     Path(folder).resolve().name, fraction)


def assemble(takes: Iterable[tuple[str, Take]], labels: dict[str, tuple[str, str]], source: str,
             fraction: float = HELD_OUT) -> Dataset:
    """A Dataset of takes, all brought to one body, the median of theirs.

    takes : (name, Take), looked at one by one;  labels : {name: (content, style)}
    source : a name for all of them;  fraction : of each group kept out of training
    """
    return _assemble({name: _part(take) for name, take in takes}, labels, source, fraction)


def _part(take):
    """What a Dataset needs of a Take: points, contacts, its body, the recording's rate."""
    return take.positions, take.contacts, measured(take.positions, take.contacts), take.clip.fps


def _read_part(path, overrides):
    return _part(read_take(path, overrides))


def _assemble(parts, labels, source, fraction):
    kept_out = hold_out(labels, fraction)
    body = mean_body([own for _, _, own, _ in parts.values()])
    clips = tuple(Labelled(name, labels[name][0], labels[name][1], name in kept_out,
                           features_on(positions, body, contacts), contacts, fps)
                  for name, (positions, contacts, _, fps) in parts.items())
    return Dataset(clips, body.leg, body.bones, source, body.rest)


def save_dataset(path: str | Path, dataset: Dataset) -> None:
    """Write a Dataset as `.npz`: all frames in one array, and where each clip begins and ends."""
    clips = dataset.clips
    arrays = {
        "features": np.concatenate([clip.features for clip in clips]),
        "contacts": np.concatenate([clip.contacts for clip in clips]),
        "lengths": np.array([len(clip.features) for clip in clips]),
        "held_out": np.array([clip.held_out for clip in clips]), "bones": dataset.bones,
        "fps": np.array([clip.fps for clip in clips], dtype=float)}
    if dataset.rest is not None:
        arrays["rest"] = dataset.rest
    facts = {"names": [clip.name for clip in clips], "contents": [clip.content for clip in clips],
             "styles": [clip.style for clip in clips], "leg": dataset.leg, "source": dataset.source}
    save_npz(path, FORMAT, VERSION, arrays, facts)


def load_dataset(path: str | Path) -> Dataset:
    """Read what `save_dataset` wrote.   ->  Dataset.
    Raises FormatError when its parts do not fit each other.
    """
    arrays, facts = load_npz(
        path, FORMAT, VERSION, ("features", "contacts", "lengths", "held_out", "bones", "fps"),
        {"names": list, "contents": list, "styles": list, "leg": float, "source": str})
    names, contents, styles = (facts[key] for key in ("names", "contents", "styles"))
    count, lengths = len(names), arrays["lengths"]
    whole = lengths.shape == (count,) and lengths.dtype.kind == "i"
    frames = lengths.sum() if whole else 0
    needed = {"features": (float, (frames, FEATURES)), "contacts": (bool, (frames, len(FEET))),
              "held_out": (bool, (count,)), "fps": (float, (count,)),
              "bones": (float, (len(BONES),))}
    if not (whole and 0 < count == len(contents) == len(styles) and (lengths > 0).all()
            and all((arrays[key].dtype, arrays[key].shape) == needed[key] for key in needed)
            and (arrays["fps"] > 0).all() and np.isfinite(arrays["fps"]).all()
            and ("rest" not in arrays or (arrays["rest"].shape == (JOINTS, 3)
                                          and plausible(arrays["rest"])))
            and plausible(arrays["features"]) and plausible(arrays["bones"])
            and LEG_RANGE[0] <= facts["leg"] <= LEG_RANGE[1]):
        raise FormatError(f"{path}: found arrays and labels that do not fit each other, needed "
                          "those of one prepare; make it again")
    cuts = np.cumsum(lengths)[:-1]
    clips = tuple(Labelled(name, content, style, bool(out), features, planted, float(fps))
                  for name, content, style, out, features, planted, fps in zip(
                      names, contents, styles, arrays["held_out"],
                      np.split(arrays["features"], cuts), np.split(arrays["contacts"], cuts),
                      arrays["fps"]))
    return Dataset(clips, facts["leg"], arrays["bones"], facts["source"], arrays.get("rest"))
