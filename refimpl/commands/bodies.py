"""`refimpl experiment bodies`: what a transfer does to bodies of other proportions."""

import argparse
import itertools
import math
from pathlib import Path
import re
from typing import Any

import numpy as np

from ..embedded.walkers import make_clip
from ..experiments import bodies
from ..motion.body import make_take, read_take
from ..motion.dataset import find_clips
from ..styles.files import load_style
from .options import (InputFolder, InputPath, OutputPath, add_processes, pattern, whole,
                      write_report)
from .progress import Progress, table
from .workers import each

DESCRIPTION = """Clips on bodies with proportions changed by up to 40 %, at other rates, short, and
without names: nothing at all, P(content), and each style, brought back to each body. What is
measured is said beside the content's own."""
COLUMNS = (("hips off", "{:.1%}"), ("shoulders off", "{:.1%}"), ("foot pitch off", "{:+.1f}"),
           ("hip height off", "{:+.1%}"), ("slide", "{:.3f}"), ("slide of content", "{:.3f}"),
           ("lowest", "{:+.3f}"), ("lowest of content", "{:+.3f}"), ("acceleration", "{:.0f}"),
           ("acceleration of content", "{:.0f}"), ("ends", "{:.2f}"), ("ends of content", "{:.2f}"))


def add_command(papers: Any) -> None:
    """Add `bodies` to the subparsers of `experiment`."""
    command = papers.add_parser("bodies", description=DESCRIPTION,
                                help="what a transfer does to bodies of other proportions")
    command.add_argument("styles", metavar="STYLE.npz", nargs="+", type=InputPath,
                         help="what `refimpl train-style` wrote")
    command.add_argument("--folder", metavar="FOLDER", type=InputFolder,
                         help="BVH clips; embedded walkers unless given")
    command.add_argument("--clips", metavar="REGEX", type=pattern, default="",
                         help="only clips in whose path this is found")
    command.add_argument("--most", type=whole(1), default=3, metavar="N",
                         help="clips at most (default: %(default)s)")
    add_processes(command, "take clips")
    command.add_argument("--json", metavar="FILE", type=OutputPath, help="write every row as JSON")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print a line a body and system, medians over the clips. A ValueError says what is lacking."""
    if arguments.folder:
        paths = [path for path in find_clips(arguments.folder)
                 if re.search(arguments.clips, path.as_posix())][:arguments.most]
        if not paths:
            raise ValueError(f"{arguments.folder}: found no clip for --clips, needed some")
        takes = {Path(path).stem: read_take(path) for path in paths}
    else:
        takes = {name: make_take(make_clip(name).clip)
                 for name in ("walk", "jog", "turn-left")[:arguments.most]}
    styles = {style.name: style for style in map(load_style, arguments.styles)}
    count = len(takes) * (len(bodies.BODIES) + len(bodies.OTHER_FORMS)) * (2 + len(styles))
    progress, rows = Progress(count, "result"), []
    for row in itertools.chain.from_iterable(
            each(arguments.processes, _of_clip, takes.items(), styles)):
        rows.append(row)
        progress.step(f"{row['clip']}, {row['body']}, {row['system']}")
    print("\n".join(table(_lines(rows))))
    if arguments.json:
        settings = {key: value for key, value in vars(arguments).items() if key != "run"}
        write_report(arguments.json, "experiment bodies", settings, rows,
                     units={"lengths": "legs", "foot pitch off": "degrees", "slide": "legs / s",
                            "acceleration": "legs / s^2"})


def _of_clip(named, styles):
    return list(bodies.matrix(dict([named]), next(iter(styles.values())).manifold, styles))


def _lines(rows):
    shown = [["body", "system", *(name for name, _ in COLUMNS)]]
    for body, system in dict.fromkeys((row["body"], row["system"]) for row in rows):
        own = [row for row in rows if (row["body"], row["system"]) == (body, system)]
        cells = []
        for name, form in COLUMNS:
            values = [row[name] for row in own if not math.isnan(row[name])]
            cells.append(form.format(float(np.median(values))) if values else "")
        shown.append([body, system, *cells])
    return shown
