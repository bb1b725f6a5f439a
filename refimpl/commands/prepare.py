"""`refimpl prepare`: a folder of BVH clips to one file of features with labels."""

import argparse
from pathlib import Path
import sys
from typing import Any

from ..motion.dataset import (HELD_OUT, PATTERN, Dataset, LabelError, expression, find_clips,
                              labels_by_pattern, labels_from_file, prepare, save_dataset)
from ..motion.features import FPS
from ..motion.joints import read_mapping
from .options import (InputFolder, InputPath, OutputPath, add_processes, add_reading, number,
                      reading)
from .progress import Progress, table
from .workers import workers

MOST = 20                                                        # warnings shown


def add_commands(commands: Any) -> None:
    """Add `refimpl prepare` to the subparsers of the command line."""
    command = commands.add_parser("prepare", description=__doc__)
    command.add_argument("folder", metavar="FOLDER", type=InputFolder,
                         help="searched for .bvh files, also below")
    command.add_argument("-o", "--output", metavar="MOTIONS.npz", type=OutputPath, required=True)
    labels = command.add_mutually_exclusive_group()
    labels.add_argument("--labels", metavar="LABELS.csv", type=InputPath,
                        help="header clip,content,style[,begin,end], or 100STYLE's "
                             "Frame_Cuts.csv; a clip by its path below FOLDER or its name")
    labels.add_argument("--pattern", metavar="REGEX", default=PATTERN,
                        help="searched in each file's name without its ending; named groups "
                             "content and style; other files are left out "
                             f"(default: {PATTERN.replace('%', '%%')})")
    add_reading(command)
    command.add_argument("--mapping-for", nargs=2, action="append", default=[],
                         metavar=("REGEX", "FILE.csv"),
                         help="a mapping file for the clips in whose path REGEX is found; may be "
                              "given several times, the first that fits counts")
    command.add_argument("--skip-bad", action="store_true",
                         help="leave out clips that cannot be used, and list them")
    command.add_argument("--hold-out", type=number(least=0, below=1), default=HELD_OUT,
                         metavar="SHARE",
                         help="share of the clips of each content and style kept out of training, "
                              "rounded down (default: %(default)s)")
    add_processes(command, "read clips")
    command.set_defaults(run=run, also_reads=lambda arguments: {
        f"--mapping-for {regex}": path for regex, path in arguments.mapping_for})


def run(arguments: argparse.Namespace) -> None:
    """Read the clips, write the data set and print what is in it."""
    general, how = reading(arguments)
    special = [(expression(regex), read_mapping(path)) for regex, path in arguments.mapping_for]
    folder = Path(arguments.folder)
    paths = find_clips(folder)
    idle = [regex.pattern for regex, _ in special
            if not any(regex.search(path.as_posix()) for path in paths)]
    if idle:
        raise LabelError(f"--mapping-for: found {idle[0]!r} in the path of no clip, needed an "
                         "expression that fits some")
    missing: list[str] = []
    labels = (labels_from_file(paths, arguments.labels, folder, missing.append) if arguments.labels
              else labels_by_pattern(paths, arguments.pattern))
    if missing:
        print(f"in the table and not in {folder}, {len(missing)}: {_few(missing)}")
    _say_labels(labels, arguments.labels, paths)
    progress, bad, odd = Progress(len(labels), "clip"), [], []
    with workers(arguments.processes) as executor:
        dataset = prepare(
            folder, labels, fraction=arguments.hold_out, report=lambda path: progress.step(
                path.name), executor=executor, overrides=lambda path: next(
                    (own for regex, own in special if regex.search(path.as_posix())), general),
            skip=(lambda path, why: bad.append(str(why))) if arguments.skip_bad else None,
            doubt=lambda path, why: odd.append(f"{path}: {why}"), **how)
    save_dataset(arguments.output, dataset)
    for line in [*odd[:MOST], *[f"{len(odd) - MOST} more such lines"][:len(odd) > MOST]]:
        print(f"refimpl: warning: {line}", file=sys.stderr)
    print("\n".join(clips_by_style(dataset)))
    print(f"{arguments.output}: {len(dataset.clips)} of {len(paths)} clips, "
          f"{sum(c.held_out for c in dataset.clips)} kept out of training")
    if bad:
        print("\n".join([f"left out, {len(bad)}:", *(f"  {why}" for why in bad)]))


def _say_labels(labels, table_file, paths):
    """Where the labels came from, what they are, and which clips have none."""
    contents, styles = (sorted({both[n] for both in labels.values()}) for n in (0, 1))
    print(f"from {'the table' if table_file else 'the names'}: content {_few(contents)}; style "
          f"{_few(styles)}")
    if without := sorted(set(map(str, paths)) - {str(getattr(key, "path", key)) for key in labels}):
        print(f"without a label, left out, {len(without)}: {_few(without)}")


def _few(words, most=8):
    return ", ".join(words[:most]) + (f" and {len(words) - most} more" if len(words) > most else "")


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
