"""`refimpl segment`, `refimpl synthesise`, `refimpl experiment torresani`: the 2006 system."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..motion.bvh import read_bvh, write_bvh
from ..motion.dataset import PATTERN, find_clips
from ..storage import atomic_write
from ..experiments import torresani as experiment
from ..embedded import performers
from ..torresani2006.database import BLENDS, embedded_database, read_database, train
from ..torresani2006.observe import EFFORTS
from ..torresani2006.poses import clip_of, fit_body, fragment_of, size_ratio
from ..torresani2006.regress import MODELS
from ..torresani2006.segment import segment
from ..torresani2006.synthesise import (LOOKS, NEIGHBOURS, check_style, contents_of, observed_style,
                                        synthesise)
from . import bodies, code_2016, ground, holden
from .options import (InputFolder, InputPath, OutputClip, OutputFolder, there_already, whole,
                      write_json)
from .progress import Progress, table

POLES = ("bound -3 .. free 3", "light -3 .. strong 3", "sustained -3 .. sudden 3")


def add_commands(commands: Any) -> None:
    """Add `segment`, `synthesise` and `experiment` to the subparsers of the program."""
    command = commands.add_parser(
        "segment", help="cut a clip into the actions of a database",
        description="Cut a clip into pieces, each matched by a fragment of a database (equations 8 "
        "to 11).")
    _add_database(command)
    command.set_defaults(run=run_segment)
    command = commands.add_parser(
        "synthesise", help="a clip with the flow, weight and time that you ask for",
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
    command.add_argument("--seed", type=whole(0), default=0, metavar="N",
                         help="of the blends learnt from (default: %(default)s)")
    command.set_defaults(run=run_synthesise)
    command = commands.add_parser("experiment", help="repeat a paper's experiments",
                                  description="Repeat a paper's experiments.")
    papers = command.add_subparsers(title="experiments", metavar="PAPER", required=True)
    holden.add_command(papers)
    ground.add_command(papers)
    code_2016.add_command(papers)
    bodies.add_command(papers)
    command = papers.add_parser(
        "torresani",
        help="Table 1 and Figure 1 of Torresani 2006, segmentation and synthesis measured",
        description="Table 1 and Figure 1 of Torresani 2006, beside the paper's numbers; how "
        "phrases are cut; whether a style asked for is seen.")
    command.add_argument("folder", metavar="FOLDER", nargs="?", type=InputFolder,
                         help="BVH clips, five actions by twelve performers; the embedded "
                         "performers unless given")
    command.add_argument("--out", metavar="DIR", type=OutputFolder,
                         default=OutputFolder("refimpl-torresani"),
                         help="made if missing (default: %(default)s)")
    command.add_argument("--pattern", metavar="REGEX", default=PATTERN,
                         help="named groups content and style (here: the performer)")
    command.add_argument("--splits", type=whole(1), default=experiment.SPLITS, metavar="N",
                         help="(default: %(default)s)")
    command.add_argument("--trials", type=whole(1), default=10, metavar="N",
                         help="styles asked for, of each performer (default: %(default)s)")
    command.add_argument("--seed", type=whole(0), default=0, metavar="N",
                         help="(default: %(default)s)")
    command.set_defaults(
        run=run_experiment, also_writes=lambda a: there_already(a.out, [
            "table_1.csv", "figure_1.csv", "figure_1_1.png", "figure_1_2.png", "figure_1_3.png",
            "report.json", "phrase.bvh"]))


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


def _load(arguments):
    """->  the database, the clip, the clip as a fragment"""
    clip = read_bvh(arguments.clip)
    if arguments.database is None:
        if arguments.labels:
            raise ValueError("--labels: found a label file without a DATABASE, needed the folder "
                             "with the clips that it names")
        database = embedded_database()
    else:
        progress = Progress(len(find_clips(arguments.database)), "clip")
        database = read_database(arguments.database, labels=arguments.labels,
                                 pattern=arguments.pattern, contents=arguments.contents,
                                 report=lambda path: progress.step(path.name))
    return database, clip, fragment_of(clip, database.body, Path(arguments.clip).stem)


def run_segment(arguments: argparse.Namespace) -> None:
    """Print how a clip is cut. A ValueError says what cannot be read or does not fit."""
    database, clip, Y = _load(arguments)
    cost, pieces = segment(Y.angles, [fragment.angles for fragment in database.fragments])
    print("\n".join(table(_piece_rows(database, pieces, Y.fps, clip.fps))))
    print(f"{arguments.clip}: {len(pieces)} pieces, SSD {cost:.5g}")


def _piece_rows(database, pieces, fps, file_fps):
    """Header and a row a piece: frames of the file, seconds, content, fragment, SSD."""
    rows = [["content", "first frame", "last frame", "from s", "to s", "SSD", "fragment"]]
    for piece in pieces:
        fragment = database.fragments[piece.fragment]
        first, last = round(piece.start * file_fps / fps), round((piece.end - 1) * file_fps / fps)
        rows.append([fragment.content, str(first), str(last), f"{piece.start / fps:.2f}",
                     f"{piece.end / fps:.2f}", f"{piece.cost:.4g}", fragment.name])
    return rows


def run_synthesise(arguments: argparse.Namespace) -> None:
    """Write a clip in the style asked for and print what was blended and what the observer sees.

    A ValueError says what cannot be read or does not fit.
    """
    target = check_style([getattr(arguments, effort) for effort in EFFORTS])
    database, clip, Y = _load(arguments)
    progress = Progress(BLENDS, "blend")
    model, projection = train(database, arguments.model, seed=arguments.seed,
                              report=lambda done: progress.step())
    made = synthesise(Y, database, model, projection, target, count=arguments.neighbours,
                      looks=arguments.looks)
    own = replace(fit_body([clip]), reference=database.body.reference,
                  carrier=database.body.carrier)
    root = made.fragment.root.copy()
    root[:, :3] *= size_ratio(own, database.body)
    write_bvh(arguments.output, clip_of(replace(made.fragment, root=root), own, clip.fps))
    print("\n".join(table(_choice_rows(database, made))))
    contents = contents_of(database, made.pieces)
    before = observed_style(Y, (0, *(piece.end for piece in made.pieces)), contents,
                            database.observer)
    after = observed_style(made.fragment, made.cuts, contents, database.observer)
    predicted = np.mean([choice.predicted for choice in made.choices], axis=0)
    for words, style in (("asked for", target), ("predicted, mean of the pieces", predicted),
                         ("computed observer, input", before),
                         ("computed observer, output", after)):
        print(f"{words}: {_style(style)}")
    print(f"{arguments.output}: {made.fragment.frames / made.fragment.fps:.2f} s in "
          f"{len(made.pieces)} pieces")


def _choice_rows(database, made):
    rows = [["content", "alpha", *(f"predicted {effort}" for effort in EFFORTS), "from", "to"]]
    for choice, content in zip(made.choices, contents_of(database, made.pieces)):
        rows.append([str(content), f"{choice.alpha:.2f}", *(f"{x:.2f}" for x in choice.predicted),
                     database.fragments[choice.i].name, database.fragments[choice.j].name])
    return rows


def _style(style):
    return ", ".join(f"{effort} {x:.2f}" for effort, x in zip(EFFORTS, style))


def run_experiment(arguments: argparse.Namespace) -> None:
    """Repeat the experiments, print them and write tables, pictures and a phrase to a folder.

    A ValueError says which clips are lacking.
    """
    arguments.out = Path(arguments.out)
    arguments.out.mkdir(parents=True, exist_ok=True)
    cast = (experiment.folder_cast(arguments.folder, arguments.pattern) if arguments.folder
            else experiment.embedded_cast())
    database, seed = cast.database, arguments.seed
    contents = dict.fromkeys(str(fragment.content) for fragment in database.fragments)
    print(f"1/4  {len(database.fragments)} fragments: {', '.join(contents)} by "
          f"{', '.join(dict.fromkeys(cast.performer))}; styles of the computed observer")
    progress = Progress(arguments.splits, "split")
    errors = experiment.table_1(database, arguments.splits, seed=seed,
                                report=lambda n: progress.step(""))
    rows = experiment.table_rows(errors)
    _write_csv(arguments.out / "table_1.csv", rows)
    print(f"2/4  Table 1: mean squared error over {arguments.splits} splits")
    for line in table(rows):
        print("     " + line)
    progress = Progress(3, "part")
    model, projection = train(database, seed=seed)
    _figure_1(arguments.out, database, experiment.figure_1(database, model, projection, seed=seed))
    progress.step("figure 1")
    known = experiment.cut_again(database, seed=seed)
    progress.step("known fragments")
    new = experiment.cut_newcomers(cast, seed=seed)
    print("3/4  segmentation, within 0.1 s of every joint")
    print(f"     known fragments, warped and with noise: {known['sequences']:.0%} of the "
          f"sequences, {known['cuts']:.0%} of the cuts")
    print(f"     performers that the database lacks: {new['sequences']:.0%} of the sequences, "
          f"{new['cuts']:.0%} of the cuts; the right contents in {new['contents']:.0%}, "
          f"{new['merged']:.0%} with repetitions counted once")
    synthesis = {}
    print("4/4  styles asked for, and whether the computed observer sees the result nearer to them "
          "than the input")
    for looks in (1, LOOKS):
        progress = Progress(len(set(cast.performer)), "performer")
        seen = experiment.asked_and_seen(cast, lambda others: train(others, seed=seed),
                                         trials=arguments.trials, looks=looks, seed=seed,
                                         report=progress.step)
        squares = {part: ((seen[part] - seen["asked"]) ** 2).mean(axis=0)
                   for part in ("input", "seen")}
        print(f"     looks {looks}: nearer in {seen['nearer']:.1%}; mean squared error of the "
              f"input {_style(squares['input'])}; of the result {_style(squares['seen'])}")
        synthesis[f"looks {looks}"] = {"nearer": float(seen["nearer"]),
                                       **{part: x.tolist() for part, x in squares.items()}}
    report = {"data": str(arguments.folder or "embedded performers"), "observer": "computed",
              "splits": arguments.splits,
              "table_1": {name: error.mean(axis=0).tolist() for name, error in errors.items()},
              "paper": experiment.PUBLISHED, "segmentation": {"known": known, "newcomers": new},
              "synthesis": synthesis}
    write_json(arguments.out / "report.json", report)
    write_bvh(arguments.out / "phrase.bvh", performers.perform(tuple(performers.ACTIONS), 99).clip)
    print(f"{arguments.out}: table_1.csv, figure_1.csv, figure_1_1.png to _3.png, report.json, "
          "and phrase.bvh, five actions by an embedded performer to try `segment` and `synthesise` "
          "with")


def _write_csv(path, rows):
    with atomic_write(path) as file:
        file.write("".join(",".join(row) + "\n" for row in rows))


def _figure_1(out, database, figures):
    """The curves as numbers, and a picture a pair."""
    rows = [["from", "to", "alpha", *EFFORTS, *(f"linear {effort}" for effort in EFFORTS)]]
    for number, figure in enumerate(figures, start=1):
        names = tuple(database.fragments[n].name for n in figure.pair)
        rows += [[*names, *(f"{x:.6g}" for x in (a, *e, *line))]
                 for a, e, line in zip(figure.alpha, figure.predicted, figure.linear)]
        _draw(out / f"figure_1_{number}.png", names, figure)
    _write_csv(out / "figure_1.csv", rows)


def _draw(path, names, curves):
    """Three panels, one an effort, as in Figure 1: what f predicts, the straight line, and what the
    computed observer sees.
    """
    from ..pictures import plot
    from ..pictures.staging import COLOURS
    figure = plot.Picture(figsize=(11.0, 4.2), dpi=plot.DPI, layout="constrained")
    panels = zip(figure.subplots(1, 3, sharey=True), EFFORTS, POLES)
    for n, (axes, effort, poles) in enumerate(panels):
        axes.axvspan(0, 1, color="#f2f2f2", zorder=0)
        axes.plot(curves.alpha, curves.predicted[:, n], color=COLOURS["result"], linewidth=2.2,
                  label="predicted, kernel ridge")
        axes.plot(curves.alpha, curves.linear[:, n], color=COLOURS["style"], linewidth=1.6,
                  linestyle="--", label="linear interpolation")
        axes.plot(curves.tried, curves.observed[:, n], "o", color="#222222", markersize=4.5,
                  clip_on=False, zorder=3, label="computed observer")
        axes.set(xlim=(curves.alpha[0], curves.alpha[-1]), ylim=(-3.2, 3.2), title=effort,
                 xlabel="alpha", ylabel=f"{effort}: {poles}")
        axes.grid(color="#e4e4e4", linewidth=0.8)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3,
                  frameon=False)
    figure.suptitle(f"alpha = 0: {names[0]}      alpha = 1: {names[1]}", fontsize=12)
    plot.save(figure, path)
