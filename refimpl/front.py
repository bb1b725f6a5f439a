"""The front door: a clip in another style, in four lines.

    import refimpl

    walk = refimpl.read("walk.bvh")
    old = refimpl.style("old")
    result = old.transform(walk, strength=1.0)
    result.save("old_walk.bvh")

`fit` learns a style from clips of it. What stands here is a few lines over the rooms below;
`refimpl transfer` does the same with more options.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
import warnings

import numpy as np

from .fast import networks
from .holden2017.trained import Style
from .holden2017.transfer import transfer
from .motion.body import Take, guess_unit, read_take, standing_height
from .motion.bvh import write_bvh
from .motion.clip import Clip
from .motion.features import bone_lengths
from .motion.joints import read_mapping
from .motion.stylised import Stylised
from .pictures import player
from .styles import box, make
from .styles.files import save_style


def read(path: str | Path, *, mapping: Mapping[str, str] | str | Path | None = None,
         rate: float | None = None) -> Take:
    """Read a clip: a BVH file of any skeleton, or points in a `.npy` or `.npz` file.

    mapping : {slot: joint}, or a file of such lines, for joints that are not found as they should
    be;  rate : frames a second, where the file does not say so   ->  Take
    Raises ValueError where the file is no clip or a joint is missing, OSError.
    """
    overrides = (read_mapping(str(mapping)) if isinstance(mapping, (str, Path)) else
                 dict(mapping) if mapping else None)
    return read_take(path, overrides, rate=rate)


def style(name: str | Path) -> "StyleTransfer":
    """A style: one in the box, by its name, or a file that `refimpl train-style` or `save` wrote.

    >>> style("old").name
    'old'

    Raises ValueError for a name that is neither.
    """
    return StyleTransfer(box.find_style(name))


def fit(shown: Sequence[Take] | Mapping[str, Sequence[Take]], *, name: str = "own",
        epochs: int = make.EPOCHS, seed: int = 0) -> "StyleTransfer":
    """Learn a style from clips of it, in a minute or two; what is stylised while it learns are the
    embedded walkers.

    shown : clips in the style, or {what is done in them: clips} with some of `make.KINDS`, so that
    walks learn from walks and runs from runs
    name : of the style;  epochs : of training;  seed : of T's first weights
    Raises ValueError for no clip or for another word.
    """
    return StyleTransfer(make.fitted(shown, name, epochs=epochs, seed=seed))


@dataclass(frozen=True)
class StyleTransfer:
    """A style, ready to be put on clips.

    style : what was trained
    """

    style: Style = field(repr=False)

    @property
    def name(self) -> str:
        """Its name."""
        return self.style.name

    @property
    def range(self) -> str:
        """What it knows, in words; a clip outside of it is told."""
        return self.style.known.said if self.style.known else ""

    def transform(self, clip: Take, *, strength: float = 1.0, only: Sequence[str] = (),
                  fps: float | None = None) -> "Result":
        """The clip in this style: its own joints, bones, frames and path.

        clip : what `read` gives;  strength : how much of the change, 0 none, 1 all
        only : the parts to change, of `motion.canonical.PARTS`, all unless given
        fps : frames a second of the result, the clip's own unless given   ->  Result
        Warns where the clip lies outside of the style's range. Raises ValueError for a negative
        strength or an unknown part.

        >>> from refimpl.embedded.sample import sample_take
        >>> walk = sample_take(seconds=1.0)[0]
        >>> result = style("old").transform(walk, strength=0.5)
        >>> result.clip.frames == walk.clip.frames
        True
        """
        if not (np.isfinite(strength) and strength >= 0):
            raise ValueError(f"strength: found {strength}, needed a number from 0 on")
        made = transfer(clip, self.style, networks=networks, strength=strength, fps=fps,
                        only=(only,) if isinstance(only, str) else tuple(only))
        for warning in made.warnings:
            warnings.warn(warning, stacklevel=2)
        return Result(clip, made)

    def save(self, path: str | Path) -> None:
        """Write it as one file, with its loss network, for `style` and `refimpl transfer`."""
        save_style(path, self.style)


@dataclass(frozen=True)
class Result:
    """A clip in a style, beside what it was made of.

    content : the clip;  stylised : what became of it
    """

    content: Take = field(repr=False)
    stylised: Stylised = field(repr=False)

    @property
    def clip(self) -> Clip:
        """On the content's own skeleton."""
        return self.stylised.clip

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why not to trust it."""
        return self.stylised.warnings

    def save(self, path: str | Path) -> None:
        """Write it as BVH, whole or not at all.   Raises ValueError for another ending, OSError."""
        if Path(path).suffix.lower() != ".bvh":
            raise ValueError(f"{path}: found a name that does not end in .bvh, needed one that "
                             "does, since that is what is written")
        write_bvh(path, self.clip)

    def show(self) -> Any:
        """Content and result in a player, as the last line of a notebook's cell shows it."""
        unit = guess_unit(standing_height(bone_lengths(self.content.positions)))
        return player.show([
            player.Figure(name, positions, planted=self.content.contacts) for name, positions in
            (("content", self.content.positions), ("result", self.stylised.positions))], unit=unit)
