"""`refimpl evaluate`: content, the results of 2016 and of 2017, and real takes, side by side."""

import argparse
from pathlib import Path
import re
from typing import Any

import numpy as np

from ..experiments import evaluate
from ..experiments.evaluate import EvaluationError
from ..experiments.score import motion_of
from ..holden2016 import bridge
from ..styles.files import load_style
from ..motion.dataset import find_clips, load_dataset, read_piece
from ..motion.features import Start, decode
from ..motion.body import to_scale
from ..motion.labels import piece_named
from .options import (InputFolder, InputPath, OutputFolder, OutputPath, add_processes,
                      there_already, whole, write_json, write_report)
from .progress import Progress, table
from .workers import each

DESCRIPTION = """Stylise every clip that was kept out of training by every style network and by
optimisation, write the results, read them again and measure them. The judges are fitted on clips
that no network learnt on: train with --clips and --exemplars that leave some."""

_STYLE_COLUMNS = (("system", "{}"), ("clips", "{}"), ("style by gram", "{:.1%}"),
                  ("style by joints", "{:.1%}"), ("content by gram", "{:.1%}"),
                  ("content by joints", "{:.1%}"), ("style distance left", "{:.1%}"),
                  ("content distance", "{:.1f}"), ("Fréchet distance", "{:.1f}"))
_FEET_COLUMNS = (("system", "{}"), ("slide (legs/s)", "{:.2f}"), ("lowest foot (legs)", "{:+.3f}"),
                 ("bones off (share)", "{:.1e}"), ("hips width off (share)", "{:.1e}"),
                 ("path error (legs)", "{:.2f}"), ("path met", "{:.0%}"),
                 ("timing off (s)", "{:.2f}"), ("movement kept (correlation)", "{:.2f}"),
                 ("jerk / real", "{:.2f}"), ("largest acceleration (legs/s^2)", "{:.0f}"),
                 ("ends off (ratio)", "{:.1f}"), ("frames/s", "{:,.0f}"))


def add_commands(commands: Any) -> None:
    """Add `evaluate` to the subparsers of the program."""
    command = commands.add_parser("evaluate", description=DESCRIPTION)
    command.add_argument("folder", metavar="FOLDER", type=InputFolder,
                         help="the BVH clips that MOTIONS.npz was made of")
    command.add_argument("motions", metavar="MOTIONS.npz", type=InputPath,
                         help="what `refimpl prepare` wrote, with clips held out")
    command.add_argument("styles", metavar="STYLE.npz", nargs="+", type=InputPath,
                         help="what `refimpl train-style` wrote, all of one loss network")
    command.add_argument("--content-style", default="normal", metavar="NAME",
                         help="the style of the contents (default: %(default)s)")
    command.add_argument("--network", metavar="N.npz", type=InputPath,
                         help="a network of 2016 (the authors' network_core.npz, or of `refimpl "
                         "train-2016`): measure that system as its code is, too")
    command.add_argument("--preprocess", metavar="P.npz", type=InputPath, help="its normaliser")
    command.add_argument("--most", type=whole(1), metavar="N",
                         help="clips of each style at most (default: all that were held out)")
    add_processes(command, "stylise and measure clips")
    command.add_argument("--out", metavar="DIR", type=OutputFolder,
                         default=OutputFolder("refimpl-evaluation"),
                         help="made if missing (default: %(default)s)")
    command.add_argument("--json", metavar="FILE", type=OutputPath,
                         help="write the tables as JSON, a row a system and style")
    command.set_defaults(run=run, also_writes=lambda a: there_already(a.out, ["report.json"]))


def run(arguments: argparse.Namespace) -> None:
    """Measure every system on the clips held out; write and print the tables.

    An EvaluationError, which is a ValueError, says what does not belong together.
    """
    arguments.out = Path(arguments.out)
    if bool(arguments.network) != bool(arguments.preprocess):
        raise EvaluationError(
            "evaluate: found one of --network and --preprocess, needed both or neither")
    network = bridge.read(arguments.network, arguments.preprocess) if arguments.network else None
    dataset = load_dataset(arguments.motions)
    styles = [load_style(path) for path in arguments.styles]
    _check(styles, dataset, arguments)
    paths = {path.relative_to(arguments.folder).with_suffix("").as_posix(): path
             for path in find_clips(arguments.folder)}
    manifold = styles[0].manifold
    chosen = evaluate.classifier_clips(dataset, styles, arguments.content_style)
    contents = {style.name: _contents(dataset, style, paths, arguments) for style in styles}
    arguments.out.mkdir(parents=True, exist_ok=True)
    progress = Progress(sum(map(len, contents.values())), "clip")
    classifiers = evaluate.fit_classifiers(chosen, manifold, dataset.leg)
    print(f"judges fitted on {len(chosen)} clips that no network learnt on")
    embed = classifiers["joints"].embed
    reference = {s.name: [embed(to_scale(c.features, dataset.leg, manifold.leg))
                          for c in chosen if c.style == s.name] for s in styles}
    rows: list[dict[str, Any]] = []
    windows: dict[tuple[str, str], list[np.ndarray]] = {}
    tasks = [(number, clip, piece_named(clip.name, paths),
              evaluate.exemplars_of(dataset, style, clip.content), clip is contents[style.name][0])
             for number, style in enumerate(styles) for clip in contents[style.name]]
    found = each(arguments.processes, _clip_rows, tasks, styles, classifiers, network,
                 arguments.out)
    for style in styles:
        for clip in contents[style.name]:
            _keep(rows, windows, next(found))
            progress.step(f"{style.name}, {clip.name}")
        _keep(rows, windows, _real_rows(dataset, style, contents[style.name], classifiers))
    lines = evaluate.summarise_systems(rows, windows, reference)
    by_style = {style.name: evaluate.summarise_systems(
        [r for r in rows if r["style"] == style.name], windows, reference) for style in styles}
    first = contents[styles[0].name][0]
    speed = evaluate.timings(to_scale(first.features, dataset.leg, manifold.leg), first.contacts,
                             evaluate.exemplars_of(dataset, styles[0], first.content), styles[0],
                             network=network)
    effect = evaluate.projection_effect(contents[styles[0].name], styles[0], dataset.leg)
    _print(lines, by_style, speed, effect)
    write_json(arguments.out / "report.json",
               {"summary": lines, "styles": by_style, "table 1": speed, "projection": effect,
                "clips": rows, "judges": [c.name for c in chosen]})
    if arguments.json:
        told = {key: str(value) if isinstance(value, Path) else value
                for key, value in vars(arguments).items() if key not in ("run", "also_writes")}
        every = [("all", lines), *by_style.items()]
        write_report(arguments.json, "evaluate", told,
                     [{"style": name, **line} for name, own in every for line in own],
                     table_1=speed, units={"seconds": "of the mathematics alone"})
    print(f"{arguments.out}: report.json, strip_STYLE.png and the written clips")


def _check(styles, dataset, arguments):
    def _known_by(manifold):
        return [*manifold.params.values(), manifold.normaliser.mean, manifold.normaliser.deviation,
                manifold.leg, manifold.bones]

    first = _known_by(styles[0].manifold)
    for path, style in zip(arguments.styles, styles):
        if not all(map(np.array_equal, _known_by(style.manifold), first)):
            raise EvaluationError(
                f"{path}: found another loss network or normaliser than in {arguments.styles[0]}, "
                "needed the same for all")
    if len({style.name for style in styles}) < len(styles):
        raise EvaluationError(
            f"found styles {', '.join(s.name for s in styles)}, needed each style once")
    if arguments.content_style not in dataset.styles:
        raise EvaluationError(f"--content-style: found {arguments.content_style!r}, needed one of "
                              f"{', '.join(dataset.styles)}")


def _contents(dataset, style, paths, arguments):
    """The held-out clips that a style is tried on, spread over its contents."""
    found = [c for c in dataset.select(style=arguments.content_style, held_out=True)
             if c.content in style.pairs]
    if not found:
        raise EvaluationError(
            f"{arguments.motions}: found no clip of style {arguments.content_style!r} held out for "
            f"{', '.join(style.pairs)}, needed some to try the networks on; prepare with a "
            "larger --hold-out")
    missing = [c.name for c in found if piece_named(c.name, paths) is None]
    if missing:
        raise EvaluationError(f"{arguments.folder}: found no {missing[0]}.bvh, needed the "
                              "folder that MOTIONS.npz was made of")
    turns = sorted(found, key=lambda c: (sum(o.content == c.content and o.name < c.name
                                             for o in found), c.content))
    return turns[:arguments.most]


def _keep(rows, windows, found):
    for row, points in found:
        rows.append(row)
        windows.setdefault((row["style"], row["system"]), []).append(points)


def _clip_rows(task, styles, classifiers, network, out):
    """Every system on one content.
    ->  list of (row, windows embedded by the classifier of joints)
    """
    number, clip, piece, exemplars, drawn = task
    style, take = styles[number], read_piece(piece)
    manifold, content = style.manifold, motion_of(take)

    def _row(system, motion, **more):
        row = {"style": style.name, "system": system, "content": clip.content, "clip": clip.name}
        return ({**row, **evaluate.measure(motion, content, exemplars, manifold, classifiers),
                 **more}, classifiers["joints"].embed(evaluate.seen_by(manifold, motion)))
    motions = {"style": decode(exemplars[0], Start()), "content": take.positions}
    found = [_row("content", content)]
    for system, result, seconds in evaluate.carry_out(take, exemplars, style, network=network):
        label = "_".join(re.findall(r"\w+", system))
        short = re.sub(r"[\[\]:]+", "_", Path(clip.name).name).strip("_")
        again = evaluate.read_back(result.clip, out / f"{style.name}_{short}_{label}.bvh")
        motions[system] = again.positions
        found.append(_row(system, again, seconds=seconds))
    if drawn:
        _strip(out / f"strip_{style.name}.png", motions, style.name)
    return found


def _real_rows(dataset, style, contents, classifiers):
    """The real takes kept out.   ->  yields as `_clip_rows`"""
    manifold = style.manifold
    for clip in dataset.select(style=style.name, held_out=True):
        if clip.content in style.pairs and clip.content in {c.content for c in contents}:
            exemplars = evaluate.exemplars_of(dataset, style, clip.content)
            measured = evaluate.measure_real(clip, dataset.leg, exemplars, manifold, classifiers)
            row = {"style": style.name, "system": "real", "content": clip.content,
                   "clip": clip.name}
            yield {**row, **measured}, classifiers["joints"].embed(
                to_scale(clip.features, dataset.leg, manifold.leg))


def _strip(path, motions, name):
    """As figures 3 and 4: the style, the content and what each system made of it."""
    from ..pictures import plot
    systems = [system for system in (evaluate.CODED, evaluate.OWN) if system in motions]
    shown = {label: motions[label] for label in ("style", "content", *systems)}
    shown["2017"] = motions["2017, own pace"]
    count = min(180, *(len(m) for m in shown.values()))
    title = f"{name}: style; content; {'; '.join(systems)}; 2017 at its own pace"
    plot.save(plot.strip({label: m[:count] for label, m in shown.items()}, title=title), path)


def _print(lines, by_style, speed, effect):
    for columns, title in ((_STYLE_COLUMNS, "style and content, all styles"),
                           (_FEET_COLUMNS, "beside the content, all styles")):
        print("\n" + title)
        _table(columns, lines)
    print("\neach style")
    _table(_STYLE_COLUMNS, [{**line, "system": f"{name}: {line['system']}"}
                            for name, own in by_style.items() for line in own])
    print("\nTable 1, seconds from features to features, without reading, writing and clean-up; "
          "ratio: 2016 in its own form over 2017")
    coded = [evaluate.CODED] if evaluate.CODED in speed[0] else []
    systems = [(name, "{:.4f}") for name in (*coded, evaluate.OWN, "2017")]
    _table((("frames", "{}"), *systems, ("ratio", "{:.0f}")), speed)
    print("\nprojection (figure 2)")
    _table((("what", "{}"), ("bone error", "{:.2%}"), ("error", "{:.2f}"),
            ("jerk / clean", "{:.2f}")), effect)


def _table(columns, lines):
    cells = [["" if line.get(name, np.nan) != line.get(name, np.nan) else form.format(line[name])
              for name, form in columns] for line in lines]
    print("\n".join(table([[name for name, _ in columns], *cells])))
