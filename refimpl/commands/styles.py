"""`refimpl styles`: the styles that come with the package, and how each is made again."""

import argparse
from pathlib import Path
from typing import Any

from ..styles import make
from ..styles.box import LOSS_NETWORK, STYLES_SAID, find_style
from .options import OutputFolder, OutputPath, there_already, write_report
from .progress import Progress, table


def add_commands(commands: Any) -> None:
    """Add `refimpl styles` to the subparsers of the command line."""
    command = commands.add_parser("styles", description=__doc__)
    command.add_argument("--make", metavar="FOLDER", type=OutputFolder,
                         help="make them again, on the embedded walkers, into this folder; about "
                              "ten minutes")
    command.add_argument("--only", metavar="NAME", nargs="+",
                         choices=[LOSS_NETWORK, *STYLES_SAID], default=[],
                         help=f"these alone: {LOSS_NETWORK}, or styles on the one in the box")
    command.add_argument("--json", metavar="FILE", type=OutputPath, help="write the list as JSON")
    command.set_defaults(run=run, also_writes=lambda a: there_already(
        a.make, [f"{name}.npz" for name in a.only or (LOSS_NETWORK, *STYLES_SAID)])
        if a.make else {})


def run(arguments: argparse.Namespace) -> None:
    """Print a line a style, or make them again."""
    if arguments.make:
        Path(arguments.make).mkdir(parents=True, exist_ok=True)
        progress = Progress(make.reports(arguments.only), "step")
        for path in make.make_box(arguments.make, arguments.only, report=progress.step):
            print(f"{path}: {path.stem}, {path.stat().st_size} bytes")
        return
    styles = [find_style(name) for name in STYLES_SAID]
    rows = [{"style": style.name, "looks": STYLES_SAID[style.name],
             "range": style.known.said if style.known else ""} for style in styles]
    print("\n".join(table([list(row.values()) for row in rows])))
    if arguments.json:
        write_report(arguments.json, "styles", {}, rows)
