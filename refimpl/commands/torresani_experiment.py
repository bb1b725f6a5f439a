"""`refimpl experiment torresani`: the tables of docs/torresani.md, and an analyst's sheets."""

import argparse
from dataclasses import replace
from functools import cache, partial
import json
from pathlib import Path
from typing import Any

from ..experiments import learning, observers, phrases, sheets, synthesis
from ..experiments import torresani as experiment
from ..embedded import performers
from ..motion.bvh import write_bvh
from ..motion.dataset import PATTERN
from ..storage import atomic_write
from ..torresani2006.database import database_of, train
from ..torresani2006.efforts import BY_PATHS, BY_SWINGS
from ..torresani2006.observe import EFFORTS, POLES
from .options import (InputFolder, InputPath, OutputFolder, OutputPath, there_already, whole,
                      write_json)
from .progress import Progress, table

TABLES = ("observers", "blends", "table 1", "contents", "phrases", "synthesis", "three fragments",
          "learning curve", "support vectors", "M", "figure 1")


def add_command(papers: Any) -> None:
    """Add `torresani` to the experiments."""
    command = papers.add_parser(
        "torresani",
        help="Table 1 and Figure 1 of Torresani 2006, segmentation and synthesis measured",
        description="Table 1 of Torresani 2006 beside what it has to be held against, Figure 1, "
        "how phrases are cut, whether a style asked for is seen. Or motions for an analyst to "
        "label, and Table 1 from the labels.")
    command.add_argument("folder", metavar="FOLDER", nargs="?", type=InputFolder,
                         help="BVH clips, five actions by twelve performers or fewer; the embedded "
                         "performers unless given")
    command.add_argument("--out", metavar="DIR", type=OutputFolder,
                         default=OutputFolder("refimpl-torresani"),
                         help="made if missing (default: %(default)s)")
    command.add_argument("--pattern", metavar="REGEX", default=PATTERN,
                         help="named groups content and style (here: the performer)")
    command.add_argument("--only", nargs="+", choices=TABLES, default=list(TABLES), metavar="TABLE",
                         help=f"some of {', '.join(TABLES)} (default: all)")
    for word, default, what in (
            ("draws", learning.DRAWS, "of 105 blends for Table 1"),
            ("splits", learning.SPLITS, "of each draw"),
            ("blends", learning.PAPER_BLENDS, "to export, and that the labels are of"),
            ("orders", 10, "of each newcomer's phrase"),
            ("trials", 3, "styles asked for, of each performer")):
        command.add_argument(f"--{word}", type=whole(1), default=default, metavar="N",
                             help=f"{what} (default: %(default)s)")
    command.add_argument("--seed", type=whole(0), default=0, metavar="N",
                         help="(default: %(default)s)")
    command.add_argument("--export-blends", metavar="DIR", type=OutputFolder,
                         help="write fragments and blends as clips, pages that show them and "
                         "sheet.csv to fill in, and do no more")
    command.add_argument("--labels", metavar="SHEET.csv", nargs="+", type=InputPath,
                         help="filled sheets, one or several analysts': Table 1 from them, and do "
                         "no more (FOLDER, --blends and --seed as they were for --export-blends)")
    command.add_argument("--json", metavar="FILE", type=OutputPath,
                         help="write the tables as JSON (default: report.json in --out)")
    command.add_argument("--into", metavar="FILE", type=OutputPath,
                         help="put them among the tables of other clips that FILE holds, too")
    command.set_defaults(run=run, also_writes=lambda a: there_already(a.out, [
        "figure_1.csv", "figure_1_1.png", "figure_1_2.png", "figure_1_3.png", "report.json",
        "phrase.bvh"]))


def run(arguments: argparse.Namespace) -> None:
    """Repeat the experiments and print and write their tables; or export, or read labels.

    A ValueError says which clips or labels are lacking.
    """
    cast = (experiment.folder_cast(arguments.folder, arguments.pattern) if arguments.folder
            else experiment.embedded_cast())
    database, seed = cast.database, arguments.seed
    if arguments.export_blends:
        out = Path(arguments.export_blends)
        progress = Progress(len(database.fragments) + arguments.blends, "motion")
        from ..pictures.player import write_player
        count = sheets.export(database, out, arguments.blends, seed, progress.step,
                              page=partial(write_player, align=True))
        print(f"{out}: {count} motions in clips/, index.html to look at them, sheet.csv to fill in")
        return
    if arguments.labels:
        Z, Y, told = sheets.from_sheets(database, arguments.labels, arguments.blends, seed)
        told["table 1"] = sheets.table_of_sheets(Z, Y, seed=seed)
        for effort, x in told["agreement"].items():
            print(f"analysts on {effort}: correlation {x['correlation']:.2f}, mean difference "
                  f"{x['difference']:.2f}")
        print(f"{', '.join(told['analysts'])}: {told['motions']} motions with a label; "
              f"{told['blends']} blends in the table, {told['blends left out']} left out for want "
              "of one; spread over splits")
        print("\n".join(table(learning.table_rows(told["table 1"]))))
        if arguments.json:
            write_json(arguments.json, told)
        return
    if arguments.into:
        _tables(arguments.into)                                  # before hours of work
    arguments.out = Path(arguments.out)
    arguments.out.mkdir(parents=True, exist_ok=True)
    report = {"data": Path(arguments.folder).name if arguments.folder else "embedded performers",
              "fragments": len(database.fragments), "performers": len(set(cast.performer)),
              **_measured(cast, arguments)}
    write_json(arguments.json or arguments.out / "report.json", report)
    if arguments.into:                                           # it may have grown meanwhile
        known = _tables(arguments.into)
        known[report["data"]] = known.get(report["data"], {}) | report
        write_json(arguments.into, known)
    if "figure 1" in arguments.only:
        write_bvh(arguments.out / "phrase.bvh",
                  performers.perform(tuple(performers.ACTIONS), 99).clip)
        print(f"{arguments.out}: figure_1.csv, figure_1_1.png to _3.png, and phrase.bvh, five "
              "actions by an embedded performer to try `segment` and `synthesise` with")


def _tables(path):
    """The tables by clips that --into put into a file, none where none is."""
    try:
        known = json.loads(Path(path).read_text()) if Path(path).is_file() else {}
        if all(isinstance(tables, dict) for tables in known.values()):
            return known
    except (ValueError, AttributeError):
        pass
    raise ValueError(f"{path}: found no tables that --into wrote, needed such a file, or none; "
                     "give another name")


def _measured(cast, arguments):
    """The tables that are asked for, printed as they come.   ->  {table: {row: {column: value}}}"""
    database, seed = learning.remembered(cast.database), arguments.seed
    found: dict[str, Any] = {}
    trained = cache(lambda: train(database, seed=seed))

    def _blends():
        return {"": experiment.blends_that_pop(database, 1000, seed=seed,
                                               report=Progress(1000, "blend").step)}

    def _phrases():
        rows = {"known fragments": phrases.cut_again(database, seed=seed)}
        for way, habits in (("newcomers, as printed", True),
                            ("newcomers, habits out, whitened", False)):
            rows[way] = phrases.cut_newcomers(
                cast, orders=arguments.orders, habits=habits, seed=seed,
                report=Progress(len(set(cast.performer)), "newcomer").step)
        return rows

    def _synthesis():
        return synthesis.asked_and_seen(
            cast, lambda others: train(others, blends=learning.PAPER_BLENDS, seed=seed),
            trials=arguments.trials, seed=seed,
            report=Progress(len(set(cast.performer)), "performer").step)
    made = {"observers": lambda: observers.worth(cast, seed=seed), "blends": _blends,
            "contents": lambda: phrases.contents_found(cast),
            "phrases": _phrases, "synthesis": _synthesis,
            "three fragments": lambda: experiment.three_way(database, seed=seed),
            "learning curve": lambda: learning.learning_curve(
                database, seed=seed, report=Progress(1500, "blend").step),
            "support vectors": lambda: learning.support_vectors(learning.drawn(database),
                                                                seed=seed),
            "M": lambda: learning.samples_tried(database, *trained(), seed=seed)}
    if "table 1" in arguments.only:
        found["table 1"] = {}
        for labels, own in _labelled(cast, database):
            errors = learning.table_1(
                learning.drawn(own), arguments.draws, arguments.splits, seed=seed,
                report=Progress(arguments.draws, f"draw, {labels}").step)
            found["table 1"][labels] = learning.over_draws(errors)
            print(f"Table 1, {labels}: error and spread over draws")
            print("\n".join(table(learning.table_rows(found["table 1"][labels]))))
    for name in arguments.only:
        if name in made:
            found[name] = {row: {word: round(x, 3) if isinstance(x, float) else x
                                 for word, x in values.items()}
                           for row, values in made[name]().items()}
            print("\n".join(f"{name}, {row or 'all'}: " + ", ".join(
                f"{word} {x}" for word, x in values.items())
                for row, values in found[name].items()))
    if "figure 1" in arguments.only:
        _figure_1(arguments.out, database, experiment.figure_1(database, *trained(), seed=seed))
    return found


def _labelled(cast, database):
    """Databases of the same fragments with labels by both observers; and, where the performers'
    efforts are known, with these, its blends labelled by the observer of swings."""
    for sight in (BY_SWINGS, BY_PATHS):
        yield f"labels by the observer of {sight.name}", replace(database_of(
            [replace(f, style=None) for f in database.fragments], database.body, sight=sight),
            between=database.between)
    if cast.efforts is not None:
        yield "fragments' efforts known, blends labelled by the observer of swings", replace(
            database, fragments=tuple(replace(f, style=e) for f, e in zip(
                database.fragments, cast.efforts)))


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
