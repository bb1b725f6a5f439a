"""`refimpl experiment ground`: how well results stand, on a folder of clips or embedded motion."""

import argparse
from typing import Any

from ..experiments import ground as experiment, holden as recipe
from ..holden2017.objective import WEIGHTS
from .holden import add_options, print_rows, read_ground
from .options import write_report
from .progress import Progress

DESCRIPTION = """Small style networks are learnt, and on clips kept out is measured what the
clean-up and the ends of a clip do: largest accelerations of knees, ankles and elbows and jerk of
the legs beside real takes, sliding feet, the style that a judge sees, the path; how a result
differs where its clip is cut later; what the clean-up does to real motion."""
_COLUMNS = {
    "results": ("clips", *experiment.WATCHED, "legs' jerk", "slide", "seen", "path"),
    "ends": ("clips", "4 frames", "a second", "after", "bones, first", "bones, last",
             "pose, first", "pose, last"),
    "legs": ("clips", "knee", "ankle", "legs' jerk", "slide before", "slide", "moved")}


def add_command(papers: Any) -> None:
    """Add `ground` to the subparsers of `experiment`."""
    command = papers.add_parser("ground", description=DESCRIPTION,
                                help="how well results stand: knees, feet, both ends of a clip")
    add_options(command, {"hidden": 128, "channels": 64, "loss-epochs": 60, "epochs": 60})
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print the three tables. A ValueError says which clips are lacking."""
    ground, takes, styles = read_ground(arguments)
    progress = Progress(len(styles) + 1, "network")
    manifold = recipe.learn_manifold(ground, hidden=arguments.hidden, epochs=arguments.loss_epochs)
    progress.step("loss network")
    rows = []
    for name in styles:
        lesson, _ = recipe.lesson_of(ground, manifold, name)
        style = recipe.learn_style(lesson, manifold, name, WEIGHTS["mean_squares"],
                                   channels=arguments.channels, epochs=arguments.epochs)
        progress.step(name)
        for measured in (experiment.result_rows, experiment.end_rows):
            rows += measured(ground, takes, style, arguments.contents)
    rows += experiment.leg_rows(ground, takes)
    for table, columns in _COLUMNS.items():
        print_rows([row for row in rows if row["table"] == table], ("style", "what"), columns)
    if arguments.json:
        settings = {key: value for key, value in vars(arguments).items() if key != "run"}
        write_report(arguments.json, "experiment ground", settings, rows)
