"""`refimpl demo`: the whole system on the embedded motion, with narrow networks, in under a minute.
"""

import argparse
from pathlib import Path
import time
from typing import Any

import numpy as np

from ..fast import networks
from ..fast.autoencoder import autoencoder_gradients
from ..fast.gradients import style_gradients
from ..holden2017.pairing import make_training_set
from ..motion.windows import clean_windows
from ..experiments.measures import held_out_distances
from ..holden2017.trained import Manifold
from ..styles.files import save_manifold, save_style
from ..holden2017.objective import EQUATION_10, Weights
from ..holden2017.train import train_autoencoder, train_style
from ..holden2017.transfer import transfer
from ..motion.bvh import write_bvh
from ..motion.dataset import assemble, save_dataset
from ..motion.features import path_error, path_length
from ..embedded.walkers import STYLES, make_database
from ..motion.body import make_take
from .options import OutputFolder, OutputPath, there_already, whole, write_json, write_report
from .progress import Progress, epoch_line

_HIDDEN, _CHANNELS = 64, 48
_PEOPLE, _SECONDS, _HELD_OUT = 5, 4.5, 0.2
_EPOCHS, _RATES = {"autoencoder": 30, "style": 60}, {"autoencoder": 5e-4, "style": 1e-3}
_FILES = ["motions.npz", "manifold.npz", "content.bvh", "style.bvh", "stylised.bvh", "figure3.png",
          "animation.html", "curves.png", "report.json"]


def add_commands(commands: Any) -> None:
    """Add `demo` to the subparsers of the program."""
    command = commands.add_parser("demo", description=__doc__)
    command.add_argument("--out", metavar="DIR", type=OutputFolder,
                         default=OutputFolder("refimpl-demo"),
                         help="made if missing (default: %(default)s)")
    command.add_argument("--style", choices=[name for name in STYLES if name != "normal"],
                         default="old", help="(default: %(default)s)")
    command.add_argument("--seed", type=whole(0), default=0, metavar="N",
                         help="of the networks' first weights (default: %(default)s)")
    command.add_argument("--json", metavar="FILE", type=OutputPath,
                         help="write the numbers that are printed as JSON")
    command.set_defaults(run=run,
                         also_writes=lambda a: there_already(a.out, [*_FILES, f"{a.style}.npz"]))


def run(arguments: argparse.Namespace) -> None:
    """Train both networks on embedded motion, transfer a style, write and print the results."""
    began = time.perf_counter()
    out = Path(arguments.out)
    out.mkdir(parents=True, exist_ok=True)

    print("1/5  motion: walkers, joggers and turners, made by the program")
    # The manifold should know more than two styles.
    styles = dict.fromkeys(("normal", arguments.style, "old", "zombie"))
    motions = make_database(seconds_per_clip=_SECONDS, people=_PEOPLE, styles=tuple(styles))
    takes = {motion.name: make_take(motion.clip, name=motion.name)
             for motion in Progress.over(motions, "motion")}
    dataset = assemble(takes.items(),
                       {motion.name: (motion.content, motion.style) for motion in motions},
                       "embedded motion", _HELD_OUT)
    save_dataset(out / "motions.npz", dataset)

    print("2/5  the loss network (equations 1 to 3)")
    manifold, manifold_records = _manifold(dataset, arguments.seed)
    save_manifold(out / "manifold.npz", manifold)

    print(f"3/5  the transformation network for style {arguments.style!r} (equations 4 to 10)")
    lesson, held_out, exemplars = make_training_set(dataset, manifold, arguments.style,
                                                    networks=networks)
    style, style_records = _style(lesson, manifold, arguments.style, arguments.seed)
    save_style(out / f"{arguments.style}.npz", style)

    print("4/5  transfer to a clip kept out of training")
    content = next(clip for clip in held_out if clip.content == "walk")
    exemplar = next(motion for motion in motions
                    if (motion.content, motion.style) == ("walk", arguments.style))
    result = transfer(takes[content.name], style, networks=networks)
    for name, clip in (("content", takes[content.name].clip), ("style", exemplar.clip),
                       ("stylised", result.clip)):
        write_bvh(out / f"{name}.bvh", clip)
    distances = held_out_distances(held_out, exemplars, style, dataset.leg)

    print("5/5  pictures")
    _pictures(out, takes[exemplar.name].positions, takes[content.name].positions, result.positions,
              {"loss network": manifold_records, "style": style_records})
    report = _report(arguments.style, dataset, manifold_records, style_records, distances,
                     (*path_error(result.features, takes[content.name].features),
                      path_length(takes[content.name].features)),
                     time.perf_counter() - began)
    write_json(out / "report.json", report)
    if arguments.json:
        write_report(arguments.json, "demo", {"style": arguments.style, "seed": arguments.seed,
                                              **report["networks"]}, [report["numbers"]])
    for key, value in report["numbers"].items():
        print(f"     {key}: {value:.4g}")
    print(f"{out}: content.bvh, style.bvh, stylised.bvh, figure3.png, animation.html, curves.png, "
          "report.json and the model files")


def _manifold(dataset, seed):
    clips = dataset.select(held_out=False)
    X, normaliser = clean_windows(clips, dataset.source)
    epochs = train_autoencoder(X, epochs=_EPOCHS["autoencoder"], rate=_RATES["autoencoder"],
                               hidden=_HIDDEN, seed=seed, gradients=autoencoder_gradients)
    records, state = _follow(epochs, _EPOCHS["autoencoder"])
    return Manifold(state.params, normaliser, dataset.leg, dataset.bones,
                    rest=dataset.rest), records


def _style(lesson, manifold, name, seed):
    weights = Weights().fitted(manifold.leg, _HIDDEN)
    epochs = train_style(lesson, manifold, epochs=_EPOCHS["style"], rate=_RATES["style"],
                         channels=_CHANNELS, seed=seed, weights=weights, gradients=style_gradients)
    records, state = _follow(epochs, _EPOCHS["style"])
    return lesson.style(state.params, manifold, name, weights), records


def _follow(epochs, total):
    progress, records = Progress(total, "epoch"), []
    for record, state in epochs:
        records.append({"epoch": record.epoch, **record.losses,
                        "gradient_norm": record.gradient_norm, "seconds": record.seconds})
        progress.step(epoch_line(record))
    return records, state


def _pictures(out, style, content, result, records):
    from ..pictures import player, plot
    motions = {"style": style, "content": content, "result": result}
    plot.save(plot.strip(motions), out / "figure3.png")
    player.write_player(out / "animation.html", motions, align=True)
    plot.save(plot.curves(records["style"], ("loss", *(term.name for term in EQUATION_10))),
              out / "curves.png")


def _report(style, dataset, manifold_records, style_records, distances, path, seconds):
    mean = {key: float(np.mean([clip[key] for clip in distances]))
            for key in ("content", "transformed", "projected")}
    numbers = {
        "clips": float(len(dataset.clips)),
        "reconstruction loss, first epoch": manifold_records[0]["loss"],
        "reconstruction loss, last epoch": manifold_records[-1]["loss"],
        "style distance of held-out content": mean["content"],
        "style distance of T(I)": mean["transformed"],
        "style distance of P(T(I))": mean["projected"],
        "share of the style distance left": mean["projected"] / mean["content"],
        "mean distance between the paths, cm": path[0],
        "largest distance between the paths, cm": path[1],
        "length of the content's path, cm": path[2], "seconds": seconds}
    return {"style": style, "data": dataset.source,
            "networks": {"hidden": _HIDDEN, "channels": _CHANNELS}, "numbers": numbers,
            "held_out_clips": distances,
            "epochs": {"loss network": manifold_records, "style": style_records}}
