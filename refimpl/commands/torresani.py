"""`refimpl segment` and `refimpl synthesise`: the 2006 system; `refimpl experiment`."""

import argparse
from dataclasses import replace
from pathlib import Path
import sys
from typing import Any

import numpy as np

from ..motion.bvh import write_bvh
from ..motion.dataset import PATTERN, find_clips
from ..torresani2006.blend import standing
from ..torresani2006.database import BLENDS, embedded_database, read_database, train
from ..torresani2006.efforts import BY_PATHS
from ..torresani2006.observe import EFFORTS, POLES, fit_observer
from ..torresani2006.poses import clip_of, fit_body, fragment_of, size_ratio
from ..torresani2006.regress import MODELS
from ..torresani2006.segment import segment
from ..torresani2006.synthesise import (LOOKS, NEIGHBOURS, check_style, contents_of, observed_style,
                                        restyle)
from . import bodies, code_2016, ground, holden, torresani_experiment
from .blend import read_warned
from .options import InputFolder, InputPath, OutputClip, OutputPath, whole, write_report
from .progress import Progress, table


def add_commands(commands: Any) -> None:
    """Add `segment`, `synthesise` and `experiment` to the subparsers of the program."""
    command = commands.add_parser(
        "segment",
        description="Cut a clip into pieces, each matched by a fragment of a database (equations 8 "
        "to 11).")
    _add_database(command)
    command.add_argument("--as-printed", action="store_true",
                         help="compare poses as equation 3 has them; otherwise, where file names "
                         "tell performers, each one's mean pose is taken out and what differs "
                         "within actions counts less")
    command.set_defaults(run=run_segment)
    command = commands.add_parser(
        "synthesise",
        description="Replace each action of a clip by a blend of two of the database's, in the "
        "style asked for.")
    _add_database(command)
    for effort, poles in zip(EFFORTS, POLES):
        command.add_argument(f"--{effort}", type=float, default=0.0, metavar="E",
                             help=f"{poles} (default: %(default)g)")
    command.add_argument("-o", "--output", metavar="OUT.bvh", type=OutputClip, required=True)
    command.add_argument("--model", choices=MODELS, default="kernel ridge",
                         help="(default: %(default)s)")
    command.add_argument("--neighbours", type=whole(2), default=NEIGHBOURS, metavar="K",
                         help="fragments to blend from (default: %(default)s)")
    command.add_argument("--looks", type=whole(1), metavar="N",
                         help="of the N best pairs take the one whose blend the computed observer "
                         f"sees nearest; 1 trusts the prediction alone (default: {LOOKS}, with "
                         "--labels 1)")
    command.add_argument("--persona", action="store_true",
                         help="blend the same two performers in every piece")
    command.add_argument("--seed", type=whole(0), default=0, metavar="N",
                         help="of the blends learnt from (default: %(default)s)")
    command.set_defaults(run=run_synthesise)
    command = commands.add_parser("experiment",
                                  description="Repeat a paper's experiments.")
    papers = command.add_subparsers(title="experiments", metavar="PAPER", required=True)
    holden.add_command(papers)
    ground.add_command(papers)
    code_2016.add_command(papers)
    bodies.add_command(papers)
    torresani_experiment.add_command(papers)


def _add_database(command):
    command.add_argument("clip", metavar="CLIP.bvh", type=InputPath)
    command.add_argument("database", metavar="DATABASE", nargs="?", type=InputFolder,
                         help="a folder of BVH clips on the same skeleton, each an action; the "
                         "embedded performers unless given")
    command.add_argument("--labels", metavar="LABELS.csv", type=InputPath,
                         help="an analyst's styles: header clip,start,end,flow,weight,time; every "
                         "line is a fragment. Without it styles are those of the computed "
                         "observer")
    command.add_argument("--pattern", metavar="REGEX", default=PATTERN,
                         help="content from file names; clips of other names are grouped by "
                         f"likeness (default: {PATTERN.replace('%', '%%')})")
    command.add_argument("--contents", type=whole(1), metavar="N",
                         help="how many actions to group such clips into "
                         "(default: one for every 12)")
    command.add_argument("--json", metavar="FILE", type=OutputPath,
                         help="write a row a piece as JSON")


def _load(arguments, styles=True):
    """->  the database, the clip, the clip as a fragment"""
    clip = read_warned(arguments.clip)
    if arguments.database is None:
        if arguments.labels:
            raise ValueError("--labels: found a label file without a DATABASE, needed the folder "
                             "with the clips that it names")
        database = embedded_database()
    else:
        progress = Progress(len(find_clips(arguments.database)), "clip")
        database = read_database(arguments.database, labels=arguments.labels, styles=styles,
                                 pattern=arguments.pattern, contents=arguments.contents,
                                 report=lambda path: progress.step(path.name))
    if database.warning:
        print(f"refimpl: {database.warning}", file=sys.stderr)
    return database, clip, fragment_of(clip, database.body, Path(arguments.clip).stem)


def _cut(database, Y, printed=False):
    """->  SSD, pieces, how far each lies from the database (above 1: nothing there is like it)"""
    if printed or database.performers is None:
        cost, pieces = segment(Y.angles, [fragment.angles for fragment in database.fragments])
        return cost, pieces, [float("nan")] * len(pieces)
    view = database.contents()
    cost, pieces = view.cut(Y.angles)
    return cost, pieces, [view.like(piece) for piece in pieces]


def run_segment(arguments: argparse.Namespace) -> None:
    """Print how a clip is cut. A ValueError says what cannot be read or does not fit."""
    database, clip, Y = _load(arguments, styles=False)
    cost, pieces, far = _cut(database, Y, arguments.as_printed)
    rows = _piece_rows(database, clip, Y, pieces, far)
    print("\n".join(table([list(rows[0]), *([f"{x:.3f}" if isinstance(x, float) else str(x)
                                             for x in row.values()] for row in rows)])))
    if arguments.json:
        _write_rows(arguments, "segment", rows)
    strange = sum(row["like"] == "nothing" for row in rows)
    print(f"{arguments.clip}: {len(pieces)} pieces in frames of the file, SSD {cost:.5g}"
          + (f"; {strange} like nothing in the database" if strange else ""))


def _piece_rows(database, clip, Y, pieces, far):
    """A row a piece, in frames of the file."""
    rows = []
    for piece, away in zip(pieces, far):
        matched = database.fragments[piece.fragment]
        rows.append({"begin": round(piece.start * clip.fps / Y.fps),
                     "end": round(piece.end * clip.fps / Y.fps), "content": matched.content,
                     "ssd": piece.cost, "fragment": matched.name,
                     "distance": None if np.isnan(away) else away,
                     "like": "unknown" if np.isnan(away) else "nothing" if away > 1 else "yes"})
    return rows


def _write_rows(arguments, command, rows):
    """The rows as JSON, with every setting of the command that is not an output."""
    settings = {name.replace("_", " "): value for name, value in vars(arguments).items()
                if name not in ("run", "json", "output")}
    write_report(arguments.json, command, settings, rows)


def run_synthesise(arguments: argparse.Namespace) -> None:
    """Write a clip in the style asked for and print what was blended and what the observer sees.

    A ValueError says what cannot be read or does not fit.
    """
    target = check_style([getattr(arguments, effort) for effort in EFFORTS])
    database, clip, Y = _load(arguments)
    progress = Progress(BLENDS, "blend")
    model, projection = train(database, arguments.model, seed=arguments.seed,
                              report=lambda done: progress.step())
    _, pieces, far = _cut(database, Y)
    made = restyle(Y, pieces, database, model, projection, target, count=arguments.neighbours,
                   looks=arguments.looks, persona=arguments.persona)
    own = replace(fit_body([clip]), reference=database.body.reference,
                  carrier=database.body.carrier)
    root = made.fragment.root.copy()
    root[:, :3] *= size_ratio(own, database.body)
    made_clip, slid, slides = standing(clip_of(replace(made.fragment, root=root), own, clip.fps))
    contents = contents_of(database, made.pieces)
    judge = (None if database.labelled else
             fit_observer(database.fragments, database.body, BY_PATHS))
    predicted = np.mean([choice.predicted for choice in made.choices], axis=0)
    said = [("asked", target), ("predicted", predicted)]
    if judge:
        said += [(word, observed_style(f, cuts, contents, judge)) for word, f, cuts in (
            ("seen in the input", Y, (0, *(piece.end for piece in made.pieces))),
            ("seen by an observer that did not choose", made.fragment, made.cuts))]
    write_bvh(arguments.output, made_clip)
    print("\n".join(table(_choice_rows(database, made))))
    if arguments.json:
        rows = _piece_rows(database, clip, Y, pieces, far)
        for row, choice in zip(rows, made.choices):
            row |= {"alpha": choice.alpha, **{f"predicted {effort}": x for effort, x
                                              in zip(EFFORTS, choice.predicted)},
                    "from": database.fragments[choice.i].name,
                    "to": database.fragments[choice.j].name}
        _write_rows(arguments, "synthesise", rows)
    print("; ".join(f"{words}: {_style(style)}" for words, style in said))
    seams = ", ".join(f"{cut / made.fragment.fps:.2f}" for cut in made.cuts[1:-1]) or "none"
    print(f"{arguments.output}: {made.fragment.frames / made.fragment.fps:.2f} s in "
          f"{len(made.pieces)} pieces, seams at {seams} s; planted feet slid {slid:.2f}, now "
          f"{slides:.2f} a second")
    strange = [str(content) for content, away in zip(contents, far) if away > 1]
    if strange:
        print(f"refimpl: {len(strange)} of the input's pieces are like nothing in the database; "
              f"they became {', '.join(strange)}", file=sys.stderr)


def _choice_rows(database, made):
    rows = [["content", "alpha", *(f"predicted {effort}" for effort in EFFORTS), "from", "to"]]
    for choice, content in zip(made.choices, contents_of(database, made.pieces)):
        rows.append([str(content), f"{choice.alpha:.2f}", *(f"{x:.2f}" for x in choice.predicted),
                     database.fragments[choice.i].name, database.fragments[choice.j].name])
    return rows


def _style(style):
    return ", ".join(f"{effort} {x:.2f}" for effort, x in zip(EFFORTS, style))
