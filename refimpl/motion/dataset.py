"""A folder of clips as one file of features with labels: what the networks are trained on."""

from dataclasses import dataclass, field
import functools
from pathlib import Path
import re

import numpy as np

from ..storage import FormatError, load_npz, plausible, read_table, save_npz
from . import features as feature_space
from .features import FEATURES, FPS, LEG_RANGE
from .joints import BONES
from .take import bone_lengths, read_take

# with 2 the root's velocity is seen from the frame that it leads to
FORMAT, VERSION = "motions", 2
# walk_old_001, dataset-1_walk_old_001
PATTERN = r"(?:^|_)(?P<content>[^_]+)_(?P<style>[^_]+)_[^_]*$"
HELD_OUT = 0.15


@dataclass(frozen=True)
class Labelled:
    """One clip: name, content, style, whether it is kept out of training, features (T, 66) float64
    and contacts (T, 4) bool at 60 frames a second.

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
    """Labelled clips of one skeleton.

    leg : leg length, in the unit of all features;  bones : (20,) lengths in the order of
    `joints.BONES`;  source : where they came from.
    """

    clips: tuple
    leg: float
    bones: np.ndarray
    source: str

    def select(self, *, style=None, content=None, held_out=None):
        """The clips with these labels, in order.   ->  tuple of Labelled"""
        return tuple(c for c in self.clips if style in (None, c.style) and content in (
            None, c.content) and held_out in (None, c.held_out))

    @property
    def styles(self):
        return sorted({clip.style for clip in self.clips})


class LabelError(ValueError):
    """A label file or pattern that does not fit the clips; the message names file and line."""


def labels_by_pattern(paths, pattern=PATTERN):
    """Labels from file names: `pattern` is searched in each name without its ending.

    paths : BVH files, pattern : a regular expression with the groups content and style
    ->  {path: (content, style)} of the files that fit.
    Raises LabelError when the pattern is no such expression.
    """
    try:
        expression = re.compile(pattern)
    except re.error as error:
        raise LabelError(
            f"pattern {pattern!r}: found {error}, needed a regular expression") from None
    if not {"content", "style"} <= set(expression.groupindex):
        raise LabelError(
            f"pattern {pattern!r}: needed the named groups (?P<content>...) and (?P<style>...)")
    matches = ((path, expression.search(path.stem)) for path in paths)
    return {path: (match["content"], match["style"]) for path, match in matches if match}


def labels_from_file(paths, label_file, folder):
    """Labels from a CSV file with the header `clip,content,style`; a clip is named by its path
    below the folder or its file name.

    ->  {path: (content, style)}.
    Raises LabelError naming the line: unknown clip, one named twice, an empty label.
    """
    known = {}
    for path in paths:
        for name in (path.relative_to(folder).as_posix(), path.name, path.stem):
            known.setdefault(name, path)
    labels = {}
    rows = read_table(label_file, "the header clip,content,style", LabelError)
    if not rows or rows[0] != ["clip", "content", "style"]:
        raise LabelError(
            f"{label_file}:1: found {','.join(rows[0]) if rows else 'an empty file'!r}, needed the "
            "header clip,content,style")
    for line, row in enumerate(rows[1:], start=2):
        if not any(row):
            continue
        if len(row) != 3 or not all(row):
            raise LabelError(
                f"{label_file}:{line}: found {','.join(row)!r}, needed clip,content,style")
        if row[0] not in known:
            raise LabelError(
                f"{label_file}:{line}: found no clip {row[0]!r} in {folder}, needed the name of a "
                "BVH file there")
        if known[row[0]] in labels:
            raise LabelError(
                f"{label_file}:{line}: found {row[0]!r} a second time, needed each clip once")
        labels[known[row[0]]] = (row[1], row[2])
    return labels


def find_clips(folder):
    """The BVH files below a folder, sorted.   Raises FileNotFoundError when there are none."""
    folder = Path(folder)
    if not folder.is_dir():
        raise FileNotFoundError(f"{folder}: found no such folder, needed a folder of BVH files")
    paths = sorted(path for path in folder.rglob("*")
                   if path.suffix.lower() == ".bvh" and path.is_file())
    if not paths:
        raise FileNotFoundError(f"{folder}: found no BVH file in it or below, needed at least one")
    return paths


def hold_out(labels, fraction=HELD_OUT):
    """Choose clips to keep out of training: of each group of n clips with the same labels the last
    floor(n fraction).

    labels : {clip: (content, style)}, clips in any order that can be sorted  ->  set of clips
    """
    groups = {}
    for clip in sorted(labels):
        groups.setdefault(labels[clip], []).append(clip)
    return {
        clip for group in groups.values()
        for clip in group[len(group) - int(len(group) * fraction):]}


def prepare(folder, labels, *, fraction=HELD_OUT, overrides=None, report=lambda path: None,
            executor=None):
    """Read the labelled clips of a folder and make their features.

    labels : {path: (content, style)};  fraction : of each group kept out of training;
    overrides : {slot: joint} for odd skeletons;
    report : called with each path when it has been read;  executor : a
    `concurrent.futures.Executor` whose workers read them   ->  Dataset
    """
    if not labels:
        raise LabelError(
            f"{folder}: found no clip with labels, needed at least one; does the pattern fit the "
            "file names?")
    named = {path.relative_to(folder).with_suffix("").as_posix(): path for path in sorted(labels)}

    def parts():
        read_one = functools.partial(_read_part, overrides=overrides)
        # not its map, which cancels what runs when the command is stopped
        if executor:
            futures = [executor.submit(read_one, path) for path in named.values()]
            read = (future.result() for future in futures)
        else:
            read = map(read_one, named.values())
        for (name, path), part in zip(named.items(), read):
            report(path)
            yield name, part

    return _assemble(dict(parts()), {name: labels[path] for name, path in named.items()},
                     Path(folder).resolve().name, fraction)


def assemble(takes, labels, source, fraction=HELD_OUT):
    """A Dataset of takes, all brought to the scale of the median leg.

    takes : iterable of (name, Take), looked at one by one;  labels : {name: (content, style)};
    source : a name for all of them
    """
    return _assemble({name: _part(take) for name, take in takes}, labels, source, fraction)


def _part(take):
    """What a Dataset needs of a Take: features, contacts, leg, bones, the recording's rate."""
    return take.features, take.contacts, take.leg, bone_lengths(take.positions), take.clip.fps


def _read_part(path, overrides):
    return _part(read_take(path, overrides))


def _assemble(parts, labels, source, fraction):
    kept_out = hold_out(labels, fraction)
    leg = float(np.median([own_leg for _, _, own_leg, _, _ in parts.values()]))
    bones = np.median([bones * (leg / own_leg) for _, _, own_leg, bones, _ in parts.values()],
                      axis=0)
    clips = tuple(
        Labelled(name, *labels[name], name in kept_out, to_scale(features, own_leg, leg), contacts,
                 fps) for name, (features, contacts, own_leg, _, fps) in parts.items())
    return Dataset(clips, leg, bones, source)


def to_scale(features, leg, new_leg):
    """Features of a character with this leg as those of one with another; left alone within 0.1 %,
    the noise of a capture.
    """
    return features if abs(new_leg / leg
                           - 1) < 1e-3 else feature_space.scale(features, new_leg / leg)


def save_dataset(path, dataset):
    """Write a Dataset as `.npz`: all frames in one array, and where each clip begins and ends."""
    lengths = [len(clip.features) for clip in dataset.clips]
    save_npz(
        path, FORMAT, VERSION, {
            "features": np.concatenate([clip.features for clip in dataset.clips]),
            "contacts": np.concatenate([clip.contacts
                                        for clip in dataset.clips]), "lengths": np.array(lengths),
            "held_out": np.array([clip.held_out for clip in dataset.clips]), "bones": dataset.bones,
            "fps": np.array([clip.fps for clip in dataset.clips], dtype=float)}, {
                "names": [clip.name for clip in dataset.clips], "contents": [
                    clip.content for clip in dataset.clips], "styles": [
                        clip.style
                        for clip in dataset.clips], "leg": dataset.leg, "source": dataset.source})


def load_dataset(path):
    """Read what `save_dataset` wrote.   ->  Dataset.
    Raises FormatError when its parts do not fit each other.
    """
    arrays, facts = load_npz(
        path, FORMAT, VERSION, ("features", "contacts", "lengths", "held_out", "bones", "fps"),
        {"names": list, "contents": list, "styles": list, "leg": float, "source": str})
    lengths = arrays["lengths"]
    names, contents, styles = (facts[key] for key in ("names", "contents", "styles"))
    if not (lengths.ndim == arrays["held_out"].ndim == 1 and lengths.dtype.kind == "i"
            and arrays["held_out"].dtype == arrays["contacts"].dtype == bool
            and arrays["features"].dtype == arrays["bones"].dtype == float and len(names) ==
            len(contents) == len(styles) == len(lengths) == len(arrays["held_out"]) > 0
            and arrays["features"].shape == (lengths.sum(), FEATURES) and arrays["contacts"].shape
            == (lengths.sum(), 4) and arrays["bones"].shape == (len(BONES),) and
            (lengths > 0).all() and arrays["fps"].shape == lengths.shape
            and arrays["fps"].dtype == float and (arrays["fps"] > 0).all()
            and np.isfinite(arrays["fps"]).all() and plausible(arrays["features"])
            and plausible(arrays["bones"]) and LEG_RANGE[0] <= facts["leg"] <= LEG_RANGE[1]):
        raise FormatError(
            f"{path}: found arrays and labels that do not fit each other, needed those of one "
            "prepare; make it again")
    ends = np.cumsum(lengths)
    clips = tuple(
        Labelled(name, content, style, bool(out), arrays["features"][end - length:end],
                 arrays["contacts"][end - length:end], float(fps))
        for name, content, style, out, length, end, fps in zip(
            names, contents, styles, arrays["held_out"], lengths, ends, arrays["fps"]))
    return Dataset(clips, facts["leg"], arrays["bones"], facts["source"])
