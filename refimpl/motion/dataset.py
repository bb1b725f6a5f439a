"""A folder of clips as one file of features with labels: what the networks are trained on."""

from collections.abc import Callable, Iterable
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
import functools
from pathlib import Path
from typing import Any

import numpy as np

from ..storage import FormatError, load_npz, plausible, save_npz
from .body import Take, features_on, make_take, read_clip, read_take
from .canonical import mean_body, measured
from .features import FEATURES, FPS, LEG_RANGE
from .joints import BONES, FEET, JOINTS
from .labels import (HELD_OUT, PATTERN, LabelError, Excerpt, expression, find_clips,  # noqa: F401
                     hold_out, labels_by_pattern, labels_from_file)

Overrides = dict[str, str] | Callable[[Path], dict[str, str] | None] | None
FORMAT, VERSION = "motions", 2       # with 2 the root's velocity is seen from the frame it leads to


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
        found = expression(name or "").search
        return tuple(c for c in self.clips
                     if style in (None, c.style) and content in (None, c.content)
                     and held_out in (None, c.held_out) and found(c.name))

    @property
    def styles(self) -> list[str]:
        """The styles that occur, sorted."""
        return sorted({clip.style for clip in self.clips})


def prepare(folder: str | Path, labels: dict[Any, tuple[str, str]], *,
            fraction: float = HELD_OUT, overrides: Overrides = None,
            report: Callable[[Path], Any] = lambda path: None,
            executor: Executor | None = None, skip: Callable[[Path, Exception], Any] | None = None,
            doubt: Callable[[Path, str], Any] = lambda path, why: None,
            **how: Any) -> Dataset:
    """Read the labelled clips of a folder, of any skeletons, and make their features.

    labels : {path or labels.Excerpt: (content, style)};  fraction : of each group kept out of
    training;  overrides : {slot: joint} for odd skeletons, or a function of a path that gives it
    report : called with each path when it has been read;  executor : whose workers read them
    skip : called with what cannot be used and why, which is left out; else it is raised
    doubt : called with what is odd about a clip that is used (`doubts`)
    how : rate and positions, as in `body.read_clip`
    ->  Dataset.   Raises LabelError where there are none, and what `read_take` raises.
    """
    if not labels:
        raise LabelError(f"{folder}: found no clip with labels, needed at least one; does the "
                         "pattern fit the file names?")
    labels = {Excerpt(key, 0, -1) if isinstance(key, Path) else key: both
              for key, both in labels.items()}
    pieces = sorted(labels)
    named = {piece.path.relative_to(folder).with_suffix("").as_posix()
             + (f"[{piece.begin}:{piece.end}]" if piece.end >= 0 else ""): piece
             for piece in pieces}
    jobs = [functools.partial(_read_part, piece, overrides(piece.path) if callable(overrides)
                              else overrides, how) for piece in pieces]
    # not the executor's map, which cancels what runs when it is stopped
    read: list[Callable[[], Any]] = (
        [executor.submit(job).result for job in jobs] if executor else list(jobs))
    parts = {}
    for (name, piece), result in zip(named.items(), read):
        try:
            *parts[name], odd = result()
            for why in odd:
                doubt(piece.path, why)
        except (ValueError, OSError) as error:
            if skip is None:
                raise
            skip(piece.path, error)
        report(piece.path)
    if not parts:
        raise LabelError(f"{folder}: found no clip that can be used, needed at least one")
    return _assemble(parts, {name: labels[named[name]] for name in parts},
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


def read_piece(piece: Excerpt, overrides: dict[str, str] | None = None, **how: Any) -> Take:
    """A clip, or the rows of it that a label names.

    overrides, how : as in `body.read_take`
    Raises LabelError where the clip has no such rows, and what `read_take` raises.
    """
    path = piece.path
    if piece.end < 0:
        return read_take(path, overrides, **how)
    clip = read_clip(path, overrides, **how)
    if piece.end > clip.frames:
        raise LabelError(f"{path}: found {clip.frames} rows, needed {piece.end} for the labelled "
                         f"part {piece.begin} to {piece.end}")
    part = replace(clip, values=clip.values[piece.begin:piece.end])
    return make_take(part, overrides, str(path))


def _read_part(piece, overrides, how):
    take = read_piece(piece, overrides, **how)
    return *_part(take), take.doubts


def _assemble(parts, labels, source, fraction):
    kept_out = hold_out(labels, fraction)
    body = mean_body([own for _, _, own, _ in parts.values()])
    clips = tuple(Labelled(name, labels[name][0], labels[name][1], name in kept_out,
                           features_on(positions, body, contacts), contacts, fps)
                  for name, (positions, contacts, _, fps) in parts.items())
    return Dataset(clips, body.leg, body.bones, source, body.rest)


def save_dataset(path: str | Path, dataset: Dataset) -> None:
    """Write a Dataset as `.npz`: all frames in one array, and where each clip begins and ends.
    Raises FormatError for what `load_dataset` would refuse.
    """
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
    _check(path, arrays, facts)
    save_npz(path, FORMAT, VERSION, arrays, facts)


def load_dataset(path: str | Path) -> Dataset:
    """Read what `save_dataset` wrote.   ->  Dataset.
    Raises FormatError when its parts do not fit each other.
    """
    arrays, facts = load_npz(
        path, FORMAT, VERSION, ("features", "contacts", "lengths", "held_out", "bones", "fps"),
        {"names": list, "contents": list, "styles": list, "leg": float, "source": str})
    _check(path, arrays, facts)
    names, contents, styles = (facts[key] for key in ("names", "contents", "styles"))
    cuts = np.cumsum(arrays["lengths"])[:-1]
    clips = tuple(Labelled(name, content, style, bool(out), features, planted, float(fps))
                  for name, content, style, out, features, planted, fps in zip(
                      names, contents, styles, arrays["held_out"],
                      np.split(arrays["features"], cuts), np.split(arrays["contacts"], cuts),
                      arrays["fps"]))
    return Dataset(clips, facts["leg"], arrays["bones"], facts["source"], arrays.get("rest"))


def _check(path, arrays, facts):
    """Raise FormatError unless the parts of a file of motions fit each other."""
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
                          "those of one prepare, with numbers within 1e9; make it again")
