"""Tables of `refimpl experiment holden` that write files: the paper's own problem, and the paper's
figures.
"""

import argparse
from collections.abc import Mapping, Sequence
import csv
from pathlib import Path
from typing import Any

import numpy as np

from ..experiments import nulls, other_uses, problem, statements
from ..fast import networks
from ..holden2016.own import Settings, stylised_features
from ..holden2017.objective import WEIGHTS
from ..holden2017.trained import Manifold, Style
from ..holden2017.transfer import transfer
from ..motion.body import Take, seen
from ..motion.bvh import write_bvh
from ..motion.dataset import assemble, features_on
from ..motion.stylised import onto_skeleton
from ..storage import atomic_write
from ..styles.files import load_manifold, load_style, save_manifold, save_style
from . import score
from .options import OutputFolder, pattern
from .progress import Progress

LEFT = "style left (content = 1)"
REFEREE = 1000                                                  # the seed of its network
EMBEDDED = problem.Roles("_00[01]$", "_00[23]$", "_00[56]$", "_000$", "_001$")


def add_options(command: argparse.ArgumentParser) -> None:
    """What these tables need beside the other options of the experiment."""
    command.add_argument("--exemplars", metavar="REGEX", type=pattern,
                         default="1_(walk|run)_.*_001$",
                         help="problem: takes of the styles whose beginning is learnt from, one a "
                              "content (default: %(default)s)")
    command.add_argument("--others", metavar="REGEX", type=pattern, default="1_walk_.*_002$",
                         help="problem: other takes of the styles, for the judges and as the level "
                              "to reach (default: %(default)s)")
    command.add_argument("--steps", metavar="N,N", default="600,4000",
                         help="gestures: steps of training (default: %(default)s)")
    command.add_argument("--out", metavar="DIR", type=OutputFolder,
                         default=OutputFolder("refimpl-holden"),
                         help="problem, figures: networks, results and figures go there, and what "
                              "is there already is used (default: %(default)s)")


def more_tables(arguments: argparse.Namespace, chosen: Sequence[str], takes: Mapping[str, Take],
                labels: Mapping[str, tuple[str, str]], styles: list[str]
                ) -> tuple[list[nulls.ScoreRow], dict[str, Any]]:
    """The tables that are asked for.   ->  rows; what else to tell"""
    rows: list[nulls.ScoreRow] = []
    more: dict[str, Any] = {}
    if "gestures" in chosen:
        rows += gesture_rows(arguments, takes, labels, styles[0])
    if {"problem", "statements", "body", "figures"} & set(chosen):
        split = shared_out(arguments, takes, labels, styles)
        referee, made = trained(arguments, split, styles)
        more["split"] = split.names()
        if "problem" in chosen:
            found, more["judges"] = problem_rows(arguments, split, referee, made)
            rows += found
        if "statements" in chosen:
            rows += statement_rows(split, referee, made)
        if "body" in chosen:
            rows += body_rows(arguments, split, made)
        if "figures" in chosen:
            draw_figures(arguments, split, made)
    return rows, more


def shared_out(arguments: argparse.Namespace, takes: Mapping[str, Take],
               labels: Mapping[str, tuple[str, str]], styles: list[str]) -> problem.Split:
    """The clips by what they are for.   Raises ValueError where a style has no exemplar."""
    roles = (problem.Roles(arguments.learn, arguments.judge, arguments.kept_out,
                           arguments.exemplars, arguments.others) if arguments.folder else EMBEDDED)
    split = problem.split(takes, labels, roles, styles, arguments.contents)
    for part in ("learn", "judges", "contents"):
        if not split.parts[part]:
            raise ValueError(f"problem: found no clip for {part}, needed some; the patterns are "
                             f"{roles}")
    for style in styles:
        if not split.exemplars(style):
            raise ValueError(f"problem: found no exemplar of {style!r} for {roles.exemplar!r}, "
                             "needed one a content")
    return split


def trained(arguments: argparse.Namespace, split: problem.Split, styles: list[str]
            ) -> tuple[Manifold, dict[str, dict[int, Style]]]:
    """The referee, and {style: {seed: Style}}: read where they are, learnt where they are not."""
    folder = Path(arguments.out) / "networks"
    folder.mkdir(parents=True, exist_ok=True)
    progress = Progress(1 + arguments.seeds * (1 + len(styles)), "     network")

    def _loss(seed):
        path = folder / f"loss_{seed}.npz"
        if not path.exists():
            save_manifold(path, problem.loss_network(split, seed, hidden=arguments.hidden,
                                                     epochs=arguments.loss_epochs))
        progress.step(path.stem)
        return load_manifold(path)
    made: dict[str, dict[int, Style]] = {style: {} for style in styles}
    for seed in range(arguments.seeds):
        manifold = _loss(seed)
        for style in styles:
            path = folder / f"{style}_{seed}.npz"
            if not path.exists():
                save_style(path, problem.style_network(
                    split, manifold, style, seed, channels=arguments.channels,
                    epochs=arguments.epochs))
            progress.step(path.stem)
            made[style][seed] = load_style(path)
    return _loss(REFEREE), made


def problem_rows(arguments: argparse.Namespace, split: problem.Split, referee: Manifold,
                 made: Mapping[str, Mapping[int, Style]]
                 ) -> tuple[list[nulls.ScoreRow], dict[str, Any]]:
    """Write the results and their table, score it, and print what `score` prints.

    ->  rows of systems, and of systems by style; facts of the judges
    """
    out = Path(arguments.out)
    files = problem.write_clips(split, out)
    table = _write_results(split, out, files, made)
    judges = score.read_judges([str(out / "judges")])
    entries, scored = score.score_file(table, judges, with_nulls=True)
    looked: dict[int, np.ndarray] = {}

    def _look(motion):
        if id(motion) not in looked:
            looked[id(motion)] = features_on(motion.positions, referee.body, motion.contacts)
        return looked[id(motion)]
    for row, entry in zip(scored, entries):
        row[LEFT] = problem.left(
            _look(entry.result), _look(entry.content), _look(entry.exemplar), referee)
    of_results = [row for row in scored if row["row"] == "result"]
    rows = [row for row in scored if row["row"] == "system"]
    for row in rows:
        row |= nulls.summary([{key: r[key] for key in ("style asked for", LEFT)}
                              for r in of_results if r["system"] == row["system"]])
    score.print_systems(rows, judges)
    for style in made:
        for system in dict.fromkeys(r["system"] for r in of_results):
            own = [r for r in of_results if (r["system"], r["style asked for"]) == (system, style)]
            if own:
                rows.append({"row": "style", "system": system, "style": style, "results": len(own),
                             **{key: float(np.mean([r[key] for r in own])) for key in (
                                 "style seen by joints", "content seen by joints", "path met")},
                             **{key: float(np.median([r[key] for r in own])) for key in (
                                 LEFT, "movement kept (correlation)")}})
    return [{"table": "problem", **score.plain(row)} for row in rows], judges.facts


def _write_results(split, out, files, made):
    """->  the path of the table"""
    lines: list[list[Any]] = [["content", "style", "result", "system"]]
    folder = out / "results"
    folder.mkdir(exist_ok=True)
    progress = Progress(len(made), "     style")
    for style, by_seed in made.items():
        shown = split.exemplars(style)
        pairs = problem.pair_contents({split.labels[c][0] for c in split.parts["contents"]}, shown)

        def _line(content, result, system):
            exemplar = files[shown[pairs[split.labels[content][0]]]]
            lines.append([*(p.relative_to(out).as_posix() for p in (
                files[content], exemplar, result)), system])
        for content, system, key, make in problem.results(split, by_seed, style):
            path = folder / f"{style}, {system}, {files[content].stem}{key}.bvh"
            if not path.exists():
                write_bvh(path, make())
            _line(content, path, system)
        for real in split.parts["real"]:
            if split.labels[real][1] == style:
                for content in split.parts["contents"]:
                    if split.labels[content][0] == split.labels[real][0]:
                        _line(content, files[real], problem.OTHER_TAKE)
        progress.step(style)
    with atomic_write(out / "table.csv") as file:
        csv.writer(file, lineterminator="\n").writerows(lines)
    return out / "table.csv"


def gesture_rows(arguments: argparse.Namespace, takes: Mapping[str, Take],
                 labels: Mapping[str, tuple[str, str]], style: str) -> list[dict[str, Any]]:
    """A style of the clips that are not locomotion, by few and by many steps, and with no style."""
    steps = [int(word) for word in arguments.steps.split(",")]
    ways = [*((WEIGHTS["mean_squares"].style, n) for n in steps), (0.0, steps[-1])]
    rows = list(other_uses.gestures(
        assemble(takes.items(), dict(labels), "gestures", 0.0), style, arguments.contents, ways,
        hidden=arguments.hidden, epochs=arguments.loss_epochs, channels=arguments.channels))
    _say("gestures", rows)
    return [{"table": "gestures", **row} for row in rows]


def body_rows(arguments: argparse.Namespace, split: problem.Split,
              made: Mapping[str, Mapping[int, Style]]) -> list[dict[str, Any]]:
    """Another body from one clip, on the first seed's loss network."""
    manifold = next(iter(made.values()))[0].manifold
    take = next(take for name, take in split.parts["learn"].items()
                if split.labels[name][1] == arguments.contents)
    rows = other_uses.another_body(split, manifold, take, channels=arguments.channels,
                                   epochs=arguments.epochs)
    _say("another body", rows)
    return [{"table": "body", **row} for row in rows]


def _say(name, rows):
    print(f"\n{name}")
    for row in rows:
        print(", ".join(f"{key} {value:.3g}" if isinstance(value, float) else f"{key} {value}"
                        for key, value in row.items()))


def statement_rows(split: problem.Split, referee: Manifold,
                   made: Mapping[str, Mapping[int, Style]]) -> list[dict[str, Any]]:
    """What the paper says in passing, measured on the first seed's networks."""
    styles = [by_seed[0] for by_seed in list(made.values())[:3]]
    manifold = styles[0].manifold
    contents = [seen(take, manifold.body).features for take in split.parts["contents"].values()]
    rows = []
    for name, found in (("basis", statements.sparse_or_not(split, manifold, referee)),
                        ("reach", statements.reach(styles[0])),
                        ("known later", statements.known_later(styles, contents[::3])),
                        ("sum or average", statements.sum_or_average(split, manifold))):
        _say(name, found)
        rows += [{"table": "statements", "of": name, **row} for row in found]
    return rows


def draw_figures(arguments: argparse.Namespace, split: problem.Split,
                 made: Mapping[str, Mapping[int, Style]]) -> None:
    """Figures 1 to 4 of the paper, by the first seed's networks, from walks and turns."""
    from ..pictures import figures
    out, shown = Path(arguments.out), list(made)[:4]
    styles = {name: made[name][0] for name in shown}
    contents = list({split.labels[name][0]: take
                     for name, take in split.parts["contents"].items()}.items())[-2:]
    pairs = problem.pair_contents([label for label, _ in contents], split.exemplars(shown[0]))
    first, (label, take) = styles[shown[0]], contents[-1]
    signals, filters = problem.flow(seen(take, first.manifold.body).features, first)
    figures.draw_networks(signals, filters, out / "figure1.png", title="the transformation network "
                          "and the loss network: signals and filters of trained ones")
    before, after = (transfer(take, first, projected=projected, clean=False,
                              networks=networks).positions for projected in (False, True))
    figures.draw_projection(before, after, out / "figure2.png",
                            title=f"T(I) in grey, P(T(I)) in blue: {shown[0]}, {label}")
    rows, beside = [], []
    progress = Progress(len(styles) * len(contents), "     strip")
    for name, style in styles.items():
        for label, take in contents:
            exemplar = split.parts["exemplars"][split.exemplars(name)[pairs[label]]]
            result = transfer(take, style, networks=networks).positions
            told, there = f"{name}, {label}", seen(take, style.manifold.body)
            rows.append(({"style": exemplar.positions, "content": take.positions,
                          "result": result}, told))
            if label == contents[-1][0]:             # the search of 2016 takes its time
                moved = stylised_features(
                    there, take.contacts, [seen(exemplar, style.manifold.body).features],
                    style.manifold, Settings(), networks=networks)
                beside.append(({"content": take.positions, "2016": onto_skeleton(
                    take, there, moved).positions, "2017": result}, told))
            progress.step(told)
    for number, lines in ((3, rows), (4, beside)):
        figures.sheet(lines, out / f"figure{number}.png", views=("side", "front"), most=len(lines))
