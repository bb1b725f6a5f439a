"""`refimpl prepare`: a folder of BVH clips to one file of features with labels."""

import argparse
from pathlib import Path
from typing import Any

from ..motion.dataset import (HELD_OUT, PATTERN, Dataset, find_clips, labels_by_pattern,
                              labels_from_file, prepare, save_dataset)
from ..motion.features import FPS
from ..motion.joints import read_mapping
from .options import InputFolder, InputPath, OutputPath, number, whole
from .progress import Progress, table
from .workers import workers


def add_commands(commands: Any) -> None:
    """Add `refimpl prepare` to the subparsers of the command line."""
    command = commands.add_parser("prepare", help="make a folder of BVH clips ready for training",
                                  description=__doc__)
    command.add_argument("folder", metavar="FOLDER", type=InputFolder,
                         help="searched for .bvh files, also below")
    command.add_argument("-o", "--output", metavar="MOTIONS.npz", type=OutputPath, required=True)
    labels = command.add_mutually_exclusive_group()
    labels.add_argument("--labels", metavar="LABELS.csv", type=InputPath,
                        help="header clip,content,style; a clip by its path below FOLDER or its "
                             "name")
    labels.add_argument("--pattern", metavar="REGEX", default=PATTERN,
                        help="searched in each file's name without its ending; named groups "
                             "content and style; other files are left out "
                             f"(default: {PATTERN.replace('%', '%%')})")
    command.add_argument("--mapping", metavar="FILE.csv", type=InputPath,
                         help="lines slot,joint for skeletons with other names")
    command.add_argument("--hold-out", type=number(least=0, below=1), default=HELD_OUT,
                         metavar="SHARE",
                         help="share of the clips of each content and style kept out of training, "
                              "rounded down (default: %(default)s)")
    command.add_argument("--processes", type=whole(1, 256), default=1, metavar="N",
                         help="read clips in so many processes (default: %(default)s)")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Read the clips, write the data set and print what is in it."""
    overrides = read_mapping(arguments.mapping) if arguments.mapping else None
    folder = Path(arguments.folder)
    paths = find_clips(folder)
    labels = (labels_from_file(paths, arguments.labels, folder) if arguments.labels
              else labels_by_pattern(paths, arguments.pattern))
    progress = Progress(len(labels), "clip")
    with workers(arguments.processes) as executor:
        dataset = prepare(folder, labels, fraction=arguments.hold_out, overrides=overrides,
                          report=lambda path: progress.step(path.name), executor=executor)
    save_dataset(arguments.output, dataset)
    print("\n".join(clips_by_style(dataset)))
    print(f"{arguments.output}: {len(dataset.clips)} of {len(paths)} clips, "
          f"{sum(c.held_out for c in dataset.clips)} kept out of training")


def clips_by_style(dataset: Dataset) -> list[str]:
    """A table of the clips and seconds of each style, by content, as lines."""
    contents = sorted({clip.content for clip in dataset.clips})
    rows = [["style", *contents]]
    for style in dataset.styles:
        cells = []
        for content in contents:
            clips = dataset.select(style=style, content=content)
            cells.append(f"{len(clips)} / {sum(len(c.features) for c in clips) / FPS:.0f} s"
                         if clips else "-")
        rows.append([style, *cells])
    return table(rows)
