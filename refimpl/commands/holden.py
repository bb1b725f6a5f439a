"""`refimpl experiment holden`: what the recipe of training does, on a folder of clips or on
embedded motion.
"""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
import re
from typing import Any

from ..experiments import holden
from ..holden2017.objective import WEIGHTS
from ..motion.dataset import PATTERN, find_clips, labels_by_pattern
from ..embedded.walkers import make_database
from ..motion.body import Take, make_take, read_take
from . import problem
from .options import InputFolder, OutputPath, add_processes, pattern, whole, write_report
from .progress import Progress, table
from .workers import each

DESCRIPTION = """Loss networks that learn with depooling by chance and by halves; styles with each
reading of equations 4 and 5, and with more and less weight on the constraints; measured before any
clean-up on clips kept out. It takes some two minutes for each loss network and one for each style
network of the usual width, on an hour of clips."""

TABLES = ("projection", "readings", "path")
MORE_TABLES = ("problem", "statements", "body", "figures", "gestures")
_READINGS = (("groups", "mean_squares", 0.01), ("groups", "mean_squares", 0.0213),
             ("groups", "sum_squares", 0.01), ("groups", "norm", 0.06), ("groups", "norm", 0.01),
             ("2016", "mean_squares", 0.01), ("2016", "norm", 0.06))
SHARES = (0.25, 0.5, 1.0, 2.0, 4.0)
LOSS_NETWORKS = (("average", "groups"), ("random", "groups"), ("random", "2016"))
_PROJECTION_COLUMNS = ("error", "jerk", "path", "path at most", "noisy error", "noisy jerk",
                       "noise jerk")
_STYLE_COLUMNS = ("left", "seen", "content seen", "jerk", "path", "path / way", "met", "speed",
                  "skate", "bones")


def add_command(papers: Any) -> None:
    """Add `holden` to the subparsers of `experiment`."""
    command = papers.add_parser(
        "holden", description=DESCRIPTION,
        help="the recipe of Holden 2017 measured: projection, readings of the bars, style and path")
    command.add_argument("--tables", metavar="A,B", default=",".join(TABLES),
                         help=f"also {', '.join(MORE_TABLES)} (default: %(default)s)")
    problem.add_options(command)
    add_options(command, {"seeds": 1, "hidden": 256, "channels": 128, "loss-epochs": 80,
                          "epochs": 100})
    add_processes(command, "learn style networks")
    command.set_defaults(run=run)


def add_options(command: argparse.ArgumentParser, counts: dict[str, int]) -> None:
    """What experiments on labelled clips have in common.   counts : {option: default}"""
    command.add_argument("folder", metavar="FOLDER", nargs="?", type=InputFolder,
                         help="labelled BVH clips on one skeleton; embedded walkers unless given")
    command.add_argument("--pattern", metavar="REGEX", default=PATTERN,
                         help="content and style from file names, as in prepare")
    for name, default, what in (("clips", "", "only clips in whose path this is found"),
                                ("kept-out", "8$|walk_.*_002$", "clips to measure on"),
                                ("learn", "1$", "clips that styles learn on"),
                                ("judge", "4$", "clips that the judge of joints is fitted on")):
        command.add_argument(f"--{name}", metavar="REGEX", type=pattern, default=default,
                             help=what + (" (default: %(default)s)" if default else ""))
    command.add_argument("--contents", metavar="NAME", default="normal",
                         help="the style of the contents (default: %(default)s)")
    command.add_argument("--styles", metavar="A,B",
                         help="styles to learn (default: elderly,youthful; embedded: old)")
    for name, value in counts.items():
        command.add_argument(f"--{name}", type=whole(1), default=value, metavar="N",
                             help="(default: %(default)s)")
    command.add_argument("--json", metavar="FILE", type=OutputPath, help="write every row as JSON")


def run(arguments: argparse.Namespace) -> None:
    """Print the tables asked for. A ValueError says which clips or tables are lacking."""
    chosen = arguments.tables.split(",")
    unknown = sorted(set(chosen) - {*TABLES, *MORE_TABLES})
    if unknown:
        raise ValueError(f"--tables: found {unknown[0]!r}, needed some of "
                         f"{', '.join(TABLES + MORE_TABLES)}")
    rows: list[dict[str, Any]] = []
    more: dict[str, Any] = {}
    if set(chosen) & set(TABLES):
        ground, _, styles = read_ground(arguments)
        rows = [row for rows in _tables(arguments, ground, styles, chosen) for row in rows]
    if set(chosen) & set(MORE_TABLES):
        takes, labels = _folder(arguments) if arguments.folder else _embedded()
        found, more = problem.more_tables(arguments, chosen, takes, labels, _styles(arguments))
        rows += found
    if arguments.json:
        settings = {key: value for key, value in vars(arguments).items() if key != "run"}
        write_report(arguments.json, "experiment holden", settings, rows, **more)


def _tables(arguments, ground, styles, chosen):
    """Print each table as it is done.   ->  yields its rows"""
    networks: dict[tuple, Any] = {}

    def _network(seed, depooling="random", form="groups"):
        key = seed, depooling, form
        if key not in networks:
            networks[key] = holden.learn_manifold(
                ground, depooling=depooling, form=form, seed=seed, hidden=arguments.hidden,
                epochs=arguments.loss_epochs)
        return networks[key]
    if "projection" in chosen:
        places: dict[str, list] = {}
        for clip in ground.dataset.select(held_out=True):
            place = clip.name.rpartition("/")[0] or ground.dataset.source
            places.setdefault(place, []).append(clip)
        runs = [(seed, depooling, form, place) for seed in range(arguments.seeds)
                for depooling, form in LOSS_NETWORKS for place in places]
        rows = [{"table": "projection", "clips": place, "depooling": depooling, "normaliser": form,
                 "seed": seed,
                 **holden.projection(ground, _network(seed, depooling, form), places[place])}
                for seed, depooling, form, place in Progress.over(runs, "measurement")]
        print_rows(rows, ("clips", "depooling", "normaliser", "seed"), _PROJECTION_COLUMNS)
        yield rows
    by_reading = [(form, replace(WEIGHTS[reading], style=s), 1.0) for form, reading, s in _READINGS]
    by_share = [("groups", WEIGHTS["mean_squares"], share) for share in SHARES]
    for name, ways in (("readings", by_reading), ("path", by_share)):
        if name in chosen:
            rows = _style_rows(arguments, ground, styles, _network, name, ways)
            print_rows(rows, ("style", "normaliser", "reading", "s", "constraints", "seed"),
                       _STYLE_COLUMNS)
            yield rows


def _style_rows(arguments, ground, styles, network, name, ways):
    """Each style by each way, and what the content and real takes would get."""
    progress = Progress(arguments.seeds * len(styles) * len(ways), "style network")
    rows, referee = [], network(problem.REFEREE)
    tasks = [(seed, style, network(seed, form=form), *how) for seed in range(arguments.seeds)
             for style in styles for form, *how in ways]
    learnt = each(arguments.processes, _learnt, tasks, ground, referee, {
        name: getattr(arguments, name) for name in ("contents", "channels", "epochs")})
    for seed in range(arguments.seeds):
        for style in styles:
            for who, null in holden.nulls(ground, style, arguments.contents, referee):
                rows.append({"table": name, "style": style, "reading": who, "seed": seed, **null})
            for form, weights, share in ways:
                found = next(learnt)
                rows.append({"table": name, "style": style, "normaliser": form,
                             "reading": weights.reading, "s": weights.style,
                             "constraints": share, "seed": seed, **found})
                progress.step(f"{style}, {weights.reading}, s = {weights.style:g}, "
                              f"constraints x {share:g}")
    return rows


def _learnt(task, ground, referee, options):
    seed, style, manifold, weights, share = task
    return holden.style_row(ground, manifold, style, weights, share, referee, seed=seed, **options)


def read_ground(arguments: argparse.Namespace) -> tuple[holden.Ground, dict[str, Take], list[str]]:
    """The clips that the options name, what each is for, and the styles to learn.

    Raises ValueError where a style has no clip to measure on.
    """
    if arguments.folder:
        takes, labels = _folder(arguments)
        ground = holden.ground(takes, labels, Path(arguments.folder).name,
                               kept_out=arguments.kept_out, learn=arguments.learn,
                               classify=arguments.judge)
    else:
        takes, labels = _embedded()
        ground = holden.ground(takes, labels, "embedded motion", kept_out="_00[56]$",
                               learn="_00[0-2]$", classify="_00[34]$")
    styles = _styles(arguments)
    for name in [arguments.contents, *styles]:
        if not ground.kept_out(name):
            raise ValueError(f"{arguments.folder or 'embedded motion'}: found no clip of style "
                             f"{name!r} to measure on, needed some; the styles are "
                             f"{', '.join(ground.dataset.styles)}")
    return ground, takes, styles


def _styles(arguments):
    usual = "elderly,youthful" if arguments.folder else "old"
    return (arguments.styles or usual).split(",")


def _embedded():
    """->  {name: Take}, {name: (content, style)}"""
    motions = make_database(seconds_per_clip=4.5, people=7, styles=("normal", "old", "zombie"))
    return ({m.name: make_take(m.clip, name=m.name) for m in motions},
            {m.name: (m.content, m.style) for m in motions})


def _folder(arguments):
    """->  {name: Take}, {name: (content, style)}"""
    paths = [path for path in find_clips(arguments.folder)
             if re.search(arguments.clips, path.as_posix())]
    labels = labels_by_pattern(paths, arguments.pattern)
    if not labels:
        raise ValueError(f"{arguments.folder}: found no clip with labels, needed some; do "
                         "--pattern and --clips fit?")
    progress, takes, named = Progress(len(labels), "clip"), {}, {}
    for path, label in labels.items():
        name = path.relative_to(arguments.folder).with_suffix("").as_posix()
        takes[name], named[name] = read_take(path), label
        progress.step(name)
    return takes, named


def print_rows(rows: list[dict[str, Any]], names: Sequence[str], numbers: Sequence[str]) -> None:
    """A table of rows: columns of words, then of numbers."""
    print()
    shown = [[*names, *numbers]]
    for row in rows:
        shown.append([*(str(row.get(name, "")) for name in names),
                      *(f"{row[name]:.3g}" if name in row else "" for name in numbers)])
    print("\n".join(table(shown)))
