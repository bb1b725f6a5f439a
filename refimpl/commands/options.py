"""Kinds of option values: argparse types that refuse what makes no sense, and say what does."""

import argparse
from collections.abc import Callable
import json
import math
import os
from pathlib import Path
import re
from typing import Any

from .. import __version__
from ..motion.clip import POSITIONS_MEAN
from ..motion.joints import read_mapping
from ..storage import atomic_write, is_special


def whole(least: int, most: int = 10 ** 9) -> Callable[[str], int]:
    """An argparse type: a whole number from `least` to `most`.

    >>> whole(1)("12")
    12
    """
    def read(text: str) -> int:
        if not re.fullmatch("[0-9]{1,10}", text) or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(
                f"found {text!r}, needed a whole number from {least} "
                + ("on" if most == 10 ** 9 else f"to {most}"))
        return int(text)
    return read


def number(*, least: float | None = None, above: float | None = None,
           below: float | None = None, most: float | None = None) -> Callable[[str], float]:
    """An argparse type: a finite number within the bounds that are given.

    >>> number(least=0, below=1)("0.15")
    0.15
    """
    given = (("from {:g} on", least), ("above {:g}", above), ("below {:g}", below),
             ("up to {:g}", most))
    bounds = " and ".join(word.format(bound) for word, bound in given if bound is not None)

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if (not math.isfinite(value) or (least is not None and value < least)
                or (above is not None and value <= above) or (most is not None and value > most)
                or (below is not None and value >= below)):
            raise argparse.ArgumentTypeError(f"found {text!r}, needed a number {bounds}")
        return value
    return read


def parts(text: str) -> tuple[str, ...]:
    """An argparse type: some parts of a body, with commas between.

    >>> parts("arms,spine")
    ('arms', 'spine')
    """
    from ..motion.canonical import PARTS                         # with SciPy behind it
    found = tuple(word.strip() for word in text.split(","))
    unknown = [word for word in found if word not in PARTS]
    if unknown:
        raise argparse.ArgumentTypeError(
            f"found {unknown[0]!r}, needed some of {', '.join(PARTS)}, with commas between")
    return found


def pattern(text: str) -> str:
    """An argparse type: a regular expression."""
    try:
        re.compile(text)
    except re.error as error:
        raise argparse.ArgumentTypeError(
            f"found {text!r} ({error}), needed a regular expression") from None
    return text


class _Path(str):
    def __new__(cls, text: str) -> "_Path":
        if not text:
            raise argparse.ArgumentTypeError("found '', needed a name")
        return super().__new__(cls, text)


def add_reading(command: argparse.ArgumentParser) -> None:
    """Add the options that say how a clip is to be read."""
    command.add_argument("--mapping", metavar="FILE.csv", type=InputPath,
                         help="lines slot,joint for what is not found as it should be")
    command.add_argument("--rate", metavar="FPS", type=number(above=0),
                         help="frames a second of the clip, where its Frame Time is wrong")
    command.add_argument("--positions", choices=POSITIONS_MEAN, default=POSITIONS_MEAN[0],
                         help="what position channels do to the OFFSET (default: %(default)s)")


def reading(arguments: argparse.Namespace) -> tuple[dict[str, str] | None, dict[str, Any]]:
    """What these options say.   ->  {slot: joint} or None, options of `motion.body.read_clip`"""
    overrides = read_mapping(arguments.mapping) if arguments.mapping else None
    return overrides, {"rate": arguments.rate, "positions": arguments.positions}


class InputPath(_Path):
    """A file that a command reads: no output may be it."""


class InputFolder(InputPath):
    """A folder that a command reads: no output may be it or a file below it."""


class OutputPath(_Path):
    """A file that a command writes: no input and no other output may be it. Its name ends as what
    is written does (`endings`, anything unless given); a pipe or a device may have any name.

    >>> OutputClip("walk.bvh")
    'walk.bvh'
    """

    endings: tuple[str, ...] = ("",)

    def __new__(cls, text: str) -> Any:
        """Refuse a name of another kind than what is written."""
        if text and not text.lower().endswith(cls.endings) and not is_special(text):
            raise argparse.ArgumentTypeError(
                f"found {text}, which does not end in {' or '.join(cls.endings)}, needed a name "
                f"that does, since that is what is written; try {text}{cls.endings[0]}")
        return super().__new__(cls, text)


class OutputClip(OutputPath):
    """A clip that a command writes, as BVH."""

    endings = (".bvh",)


class OutputPicture(OutputPath):
    """A picture that a command writes, as PNG."""

    endings = (".png",)


class OutputPage(OutputPath):
    """A page that a command writes."""

    endings = (".html", ".htm")


class OutputFolder(OutputPath):
    """A folder that a command writes files into."""


def files_of(arguments: argparse.Namespace) -> tuple[dict[str, str], dict[str, str]]:
    """What a command reads and what it writes, by the words of its options.

    ->  inputs, outputs as {word: path}, with what a command's `also_reads` and `also_writes` add
    """
    inputs: dict[str, str] = {}
    outputs: dict[str, str] = {}
    for name, value in vars(arguments).items():
        word = f"--{name.replace('_', '-')}"
        for place, item in enumerate(value if isinstance(value, list) else [value], start=1):
            key = f"{word} {place}" if isinstance(value, list) else word
            if isinstance(item, InputPath):
                inputs[key] = item
            elif isinstance(item, OutputPath):
                outputs[key] = item
    for word, path in getattr(arguments, "also_writes", lambda _: {})(arguments).items():
        outputs[word] = OutputPath(str(path))
    for word, path in getattr(arguments, "also_reads", lambda _: {})(arguments).items():
        inputs[word] = InputPath(str(path))
    return inputs, outputs


def there_already(folder: str, names: list[str]) -> dict[str, str]:
    """Files of these names that stand in a folder already, for `also_writes`.   ->  {word: path}"""
    paths = {name: os.path.join(folder, name) for name in names}
    return {f"the {name} in {folder}": path for name, path in paths.items()
            if os.path.lexists(path)}


def write_json(path: str | Path, content: Any) -> None:
    """Write a value as JSON text, one item a line, whole or not at all."""
    with atomic_write(path) as file:
        file.write(json.dumps(content, indent=1) + "\n")


def add_processes(command: argparse.ArgumentParser, what: str) -> None:
    """Add --processes.   what : is done in them"""
    command.add_argument("--processes", type=whole(1, 256), default=1, metavar="N",
                         help=f"{what} in so many processes (default: %(default)s)")


def write_report(path: str, command: str, settings: dict[str, Any], rows: list[dict],
                 **more: Any) -> None:
    """One JSON object: command, version, settings, rows (flat) and what else is told."""
    write_json(path, {"command": command, "version": __version__, "settings": settings,
                      "rows": rows, **more})
