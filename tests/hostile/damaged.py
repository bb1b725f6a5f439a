"""Other frames, other print, and damage: the rest of what happens to a clip on its way.

Each of `ALTERATIONS` takes a clip and makes an `Altered` of it. Each of `DAMAGES` takes a clip and
makes the text of a file that is to be refused, or told, or (where `harmless` says so) both files
are to give the same answer.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from tests.hostile import altered
from tests.hostile.altered import Altered, same
from tests.hostile.strangers import Clip, height, write

Generator = np.random.Generator


def _rows(clip: Clip, rows: np.ndarray, **other) -> Clip:
    return replace(clip, turns=clip.turns[rows], places=clip.places[rows], **other)


def resampled(clip: Clip, rng: Generator) -> Altered:
    """Another rate: each n-th row, or rows between by slerp and straight lines.

    Curves that are cut into straight pieces, and contacts that are seen at other times, are within
    the bound of answers that are not exact.
    """
    rate = round(1 / clip.step)
    wanted = int(rng.choice([r for r in (24, 30, 60, 120) if r != rate]))
    count = len(clip.turns)
    if rate % wanted == 0:
        rows = np.arange(0, count, rate // wanted)
        return same(_rows(clip, rows, step=1 / wanted), frames=(rows, np.arange(len(rows))),
                    exact=False, said=f"{wanted} of {rate} rows a second")
    times = np.arange(int((count - 1) * wanted / rate) + 1) * rate / wanted
    turns = np.stack([Slerp(np.arange(count), Rotation.from_matrix(clip.turns[:, j]))(times)
                      .as_matrix() for j in range(len(clip.names))], axis=1)
    low = np.minimum(times.astype(int), count - 2)
    share = (times - low)[:, None, None]
    places = clip.places[low] * (1 - share) + clip.places[low + 1] * share
    common = np.flatnonzero(np.abs(times - np.round(times)) < 1e-9)
    return same(replace(clip, turns=turns, places=places, step=1 / wanted), exact=False,
                frames=(np.round(times[common]).astype(int), common),
                said=f"{wanted} rows a second made of {rate}")


def repeated(clip: Clip, rng: Generator) -> Altered:
    """The first row again and again before the clip: whoever stands, stands still."""
    more = int(rng.integers(2, 12))
    rows = np.concatenate([np.zeros(more, dtype=int), np.arange(len(clip.turns))])
    base = np.arange(len(clip.turns))
    return same(_rows(clip, rows), frames=(base, base + more), exact=False, said=f"{more} rows")


def cut(clip: Clip, rng: Generator) -> Altered:
    """The first or the second part of the clip alone."""
    count = len(clip.turns)
    middle = int(rng.uniform(0.4, 0.6) * count)
    rows = (np.arange(middle), np.arange(middle, count))[rng.integers(2)]
    return same(_rows(clip, rows), frames=(rows, np.arange(len(rows))), exact=False,
                said=f"rows {rows[0]} to {rows[-1]}")


def part(clip: Clip, rng: Generator) -> Altered:
    """`--from` and `--to` write rows of the whole clip's answer, and nothing else.

    The row at `--to` itself is the next part's first.
    """
    begin, end = sorted(rng.choice(len(clip.turns), 2, replace=False))
    rows = np.arange(begin, end)
    words = [f"{row * clip.step:.9f}" for row in (begin, end)]
    return same(_rows(clip, rows), frames=(rows, np.arange(len(rows))), text=lambda _: write(clip),
                options=("--from", words[0], "--to", words[1]), said=f"rows {begin} to {end}")


def other_rate(clip: Clip, rng: Generator) -> Altered:
    """`--fps` writes the same answer at another rate."""
    one = resampled(clip, rng)
    return replace(one, text=lambda _: write(clip),
                   options=("--fps", str(round(1 / one.clip.step))))


def wrong_time(clip: Clip, rng: Generator) -> Altered:
    """A wrong Frame Time, which `--rate` sets right."""
    factor = float(rng.choice([0.5, 2, 4]))
    return same(clip, text=lambda _: write(replace(clip, step=clip.step * factor)),
                options=("--rate", f"{1 / clip.step:.9g}"), said=f"times {factor:g}")


PRINTS = {
    "CR LF": lambda clip: write(clip).replace("\n", "\r\n"),
    "blanks for tabs": lambda clip: write(clip, tab="  ").replace("Frames: ", "Frames:\t"),
    "no indent": lambda clip: write(clip, tab=""),
    "trailing blanks": lambda clip: write(clip).replace("\n", "  \n"),
    "exponents": lambda clip: write(clip, digits=".11e"),
    "many digits": lambda clip: write(clip, digits=".17g"),
    "six decimals": lambda clip: write(clip, digits=".6f"),
    "plus signs": lambda clip: write(clip, digits="+.12g"),
    "blank lines at the end": lambda clip: write(clip) + "\n\n",
    "no last line break": lambda clip: write(clip).rstrip("\n"),
    "tabs between numbers": lambda clip: write(clip).replace(" ", "\t").replace("End\t", "End "),
}
FOREIGN = {
    "blank lines between rows": lambda clip: write(clip).replace("\n", "\n\n"),
    "comments": lambda clip: "# by a tool\n" + write(clip),
    "a BOM": lambda clip: "\ufeff" + write(clip),
    "CR alone": lambda clip: write(clip).replace("\n", "\r"),
    "decimal commas": lambda clip: write(clip, digits=".6f").replace(".", ","),
    "no End Sites": lambda clip: write(replace(clip, ends=(None,) * len(clip.names))),
}


def printed(clip: Clip, rng: Generator) -> Altered:
    """The same clip as other tools print it; what is no BVH may be refused."""
    said = str(rng.choice(sorted(PRINTS) * 2 + sorted(FOREIGN)))
    return same(clip, text={**PRINTS, **FOREIGN}[said], said=said, foreign=said in FOREIGN)


ALTERATIONS: dict[str, altered.Maker] = {
    function.__name__: function for function in (
        altered.renamed, altered.nonsense, altered.mapped, altered.mirrored, altered.scaled,
        altered.turned, altered.upended, altered.moved, altered.reordered_channels,
        altered.positions, altered.meaningless_offsets, altered.ends, altered.reordered_children,
        altered.extra, altered.fewer, resampled, repeated, cut, part, other_rate, wrong_time,
        printed)}
ONLY = {"part": ("transfer",), "other_rate": ("transfer",),
        "wrong_time": ("inspect", "transfer", "prepare")}


# ----- damage ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Damaged:
    """The text of a file, and whether an answer without a word would be right, too."""

    text: str
    said: str
    harmless: bool = False


def _broken_text(clip: Clip, rng: Generator) -> Damaged:
    text = write(clip, digits=".8g")
    start = text.index("MOTION")
    lines = text.split("\n")
    row = len(lines) - 2 - int(rng.integers(0, len(clip.turns) - 2))
    cell = int(rng.integers(0, len(lines[row].split())))

    def with_cell(word: str) -> str:
        words = lines[row].split()
        words[cell:cell + 1] = word.split()
        return "\n".join(lines[:row] + [" ".join(words)] + lines[row + 1:])
    count = len(clip.turns)
    kinds = {
        "truncated in the tree": text[:int(rng.uniform(0.1, 0.9) * start)],
        "truncated in a row": text[:int(rng.uniform(start + 100, len(text) - 10))],
        "truncated between rows": "\n".join(lines[:row]) + "\n",
        "NaN": with_cell("nan"), "infinity": with_cell("inf"), "a word": with_cell("12.a4"),
        "a number too many": with_cell("1 2"), "a number missing": with_cell(""),
        "too large": with_cell("1e300"),
        "more frames announced": text.replace(f"Frames: {count}", f"Frames: {count + 7}"),
        "fewer frames announced": text.replace(f"Frames: {count}", f"Frames: {count - 7}"),
        "frames below none": text.replace(f"Frames: {count}", "Frames: -3"),
        "no frame time": text.replace("Frame Time", "Frame Tim"),
        "frame time 0": text.replace(f"Frame Time: {clip.step:.9g}", "Frame Time: 0"),
        "frame time below 0": text.replace(f"Frame Time: {clip.step:.9g}", "Frame Time: -0.033"),
        "frame time of an hour": text.replace(f"Frame Time: {clip.step:.9g}", "Frame Time: 3600"),
        "a brace missing": text.replace("}", "", 1),
        "a brace too many": text.replace("}", "} }", 1),
        "unknown channel": text.replace("Zrotation", "Wrotation", 1),
        "one channel twice": text.replace("Zrotation", "Xrotation", 1),
        "wrong count of channels": text.replace("CHANNELS 3", "CHANNELS 2", 1).replace(
            "CHANNELS 6", "CHANNELS 5", 1),
        "two joints of one name": text.replace(clip.names[-1] + "\n", clip.names[-2] + "\n"),
        "empty": "", "a picture": "\x89PNG\r\n\x1a\n" + text[:100], "no motion": text[:start],
        "no rows": "\n".join(lines[:len(lines) - 1 - count]).replace(
            f"Frames: {count}", "Frames: 0") + "\n",
    }
    said = str(rng.choice(sorted(kinds)))
    return Damaged(kinds[said], said)


def _headless(clip: Clip, rng: Generator) -> Damaged:
    parts = {"UpLeg": "a thigh", "Leg": "a shin", "Arm": "an arm", "Spine1": "the chest"}
    gone = [j for j, name in enumerate(clip.names) if altered.side_and_part(name)[1] in parts]
    first = int(rng.choice(gone))
    dead = {first}
    for joint, parent in enumerate(clip.parents):
        if parent in dead:
            dead.add(joint)
    kept = [j for j in range(len(clip.names)) if j not in dead]
    return Damaged(write(altered.taken(clip, kept)), f"without {clip.names[first]} and below")


def _teleporting(clip: Clip, rng: Generator) -> Damaged:
    places = clip.places.copy()
    begin = int(rng.integers(5, len(places) - 5))
    end = (begin + 1, len(places))[rng.integers(2)]
    mover = int(np.argmax(np.ptp(places, axis=0).max(axis=1)))
    places[begin:end, mover] += rng.choice([-1, 1], 3) * rng.uniform(3, 8) * height(clip)
    return Damaged(write(replace(clip, places=places)), f"elsewhere from row {begin} to {end}")


def _lost(clip: Clip, rng: Generator) -> Damaged:
    turns, places = clip.turns.copy(), clip.places.copy()
    row = int(rng.choice([0, int(rng.integers(5, len(turns) - 5)), len(turns) - 1]))
    turns[row] = np.eye(3)
    places[row] = np.where(altered.inner(clip)[:, None], places[row], 0)
    return Damaged(write(replace(clip, turns=turns, places=places)), f"row {row} is all zeros")


def _sized(clip: Clip, rng: Generator) -> Damaged:
    scale = float(rng.choice([1e-9, 1e-5, 1e5, 1e9]))
    return Damaged(write(replace(clip, places=clip.places * scale, offsets=clip.offsets * scale)),
                   f"times {scale:g}")


def _short(clip: Clip, rng: Generator) -> Damaged:
    rows = np.arange(int(rng.integers(1, 4)))
    return Damaged(write(_rows(clip, rows)), f"{len(rows)} rows alone", harmless=True)


def _frozen(clip: Clip, rng: Generator) -> Damaged:
    return Damaged(write(_rows(clip, np.zeros(len(clip.turns), dtype=int))), "one row throughout",
                   harmless=True)


DAMAGES = {function.__name__.strip("_"): function for function in (
    _broken_text, _headless, _teleporting, _lost, _sized, _short, _frozen)}
