"""`refimpl experiment code-2016`: the 2016 code's style transfer with one statement changed at a
time."""

import argparse
import re
from typing import Any

import numpy as np

from ..experiments import code_2016
from ..holden2016 import bridge, rows
from ..motion.dataset import load_dataset
from ..motion.features import decode, scale
from .options import InputPath, OutputPath, pattern, whole, write_report
from .progress import Progress, table

DESCRIPTION = """The 2016 code's style transfer on clips that were kept out of training, as its code
is and with one statement changed at a time: the scale of the style's Gram matrix, the noise, the
second encoding, Adam's epsilon and rate, the floor term, the lengths of the bones, the replaced
velocities. Some 1.5 s a search of 300 frames with 128 hidden units; there are 14 to a pair."""

_COLUMNS = ("first", "left", "excursion", "speed", "jerk", "bones", "moved", "sunk")


def add_command(papers: Any) -> None:
    """Add `code-2016` to the subparsers of `experiment`."""
    command = papers.add_parser("code-2016", description=DESCRIPTION,
                                help="what each statement of the 2016 code does")
    command.add_argument("motions", metavar="MOTIONS.npz", type=InputPath,
                         help="what `refimpl prepare` wrote, with clips held out")
    for name, what in (("network", "the authors' network_core.npz, or of `refimpl train-2016`"),
                       ("preprocess", "its normaliser")):
        command.add_argument(f"--{name}", metavar="FILE.npz", type=InputPath, required=True,
                             help=what)
    command.add_argument("--clips", metavar="REGEX", type=pattern, default="",
                         help="only clips in whose name this is found")
    command.add_argument("--contents", metavar="NAME", default="normal",
                         help="the style of the contents (default: %(default)s)")
    command.add_argument("--styles", metavar="A,B", default="elderly,youthful",
                         help="(default: %(default)s)")
    command.add_argument("--most", metavar="N", type=whole(1), default=7,
                         help="contents at most (default: %(default)s)")
    command.add_argument("--seed", metavar="N", type=whole(0), default=0, help="of the noise")
    command.add_argument("--json", metavar="FILE", type=OutputPath, help="write every row as JSON")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print the medians of each way. A ValueError says which clips are lacking."""
    dataset = load_dataset(arguments.motions)
    network = bridge.read(arguments.network, arguments.preprocess)
    found = [c for c in dataset.clips if re.search(arguments.clips, c.name)]
    contents = [c for c in found if c.held_out and c.style == arguments.contents]
    contents = contents[::max(1, len(contents) // arguments.most)][:arguments.most]
    pairs = [(clip, style) for name in arguments.styles.split(",") for clip in contents
             for style in _longest(c for c in found if c.style == name and c.content == clip.content
                                   and not c.held_out and len(c.features) > rows.SHORTEST)]
    if not pairs:
        missing = (f"no clip of {arguments.contents!r} held out" if not contents else
                   f"no clip of {arguments.styles} for learning with the content of one of "
                   f"{arguments.contents!r} held out")
        raise ValueError(f"{arguments.motions}: found {missing}, needed some; do --contents, "
                         "--styles and --clips fit?")
    progress = Progress(len(pairs) * (len(code_2016.WAYS) + 3), "search")
    named = [(f"{clip.name} in style {style.style}", _as_rows(clip), _as_rows(style), clip.fps)
             for clip, style in pairs]
    measured = []
    for row in code_2016.ablation_rows(named, network, arguments.seed):
        measured.append(row)
        progress.step(f"{row['pair']}: {row['way']}")
    print(f"{len(pairs)} pairs of {len(contents)} contents with styles {arguments.styles}; medians")
    shown = [["", *_COLUMNS]]
    for way in dict.fromkeys(row["way"] for row in measured):
        of = [row for row in measured if row["way"] == way]
        shown.append([way, *(f"{np.median([row[name] for row in of]):.3g}" for name in _COLUMNS)])
    print("\n".join(table(shown)))
    if arguments.json:
        settings = {key: value for key, value in vars(arguments).items() if key != "run"}
        write_report(arguments.json, "experiment code-2016", settings, measured,
                     units={"moved": "units of the 2016 code, 5.4 cm", "sunk": "the same"})


def _longest(clips):
    """The longest of some clips, in a list; none of none."""
    return sorted(clips, key=lambda clip: len(clip.features))[-1:]


def _as_rows(clip):
    """A clip of a Dataset in the code's unit.   ->  (T, 73)"""
    size = bridge.unit_of(decode(clip.features))
    return bridge.to_rows(scale(clip.features, size), clip.contacts)
