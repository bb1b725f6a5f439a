"""`refimpl train-autoencoder` and `refimpl train-style`: the loss network, and one transformation
network a style.
"""

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..fast import networks
from ..fast.autoencoder import autoencoder_gradients
from ..fast.gradients import style_gradients
from ..fast.shards import sharded
from ..holden2016 import bridge
from ..experiments.measures import held_out_distances
from .checkpoint import Run, fingerprint, load_checkpoint, save_checkpoint, set_aside
from ..holden2017.pairing import make_training_set
from ..motion.windows import clean_windows
from ..holden2017.networks import DEPOOLING, init_loss_network, init_transformation_network
from ..holden2017.trained import Manifold
from ..styles.files import load_manifold, save_manifold, save_style
from ..holden2017.objective import EQUATION_10, WEIGHED, WEIGHTS, Weights
from ..holden2017.train import (AUTOENCODER_RATE, BATCH, RATE, Record, State, train_autoencoder,
                                train_style)
from ..motion.dataset import load_dataset
from ..motion.windows import FORMS
from .options import InputPath, OutputPath, OutputPicture, number, whole, write_json
from .progress import Progress, epoch_line, table


def add_commands(commands: Any) -> None:
    """Add `train-autoencoder` and `train-style` to the subparsers of the program."""
    manifold = commands.add_parser(
        "train-autoencoder",
        description="Train the convolutional autoencoder, the loss network of equations 1 to 3.")
    manifold.add_argument("motions", metavar="MOTIONS.npz", type=InputPath,
                          help="what `refimpl prepare` wrote")
    manifold.add_argument("-o", "--output", metavar="MANIFOLD.npz", type=OutputPath, required=True)
    training_options(manifold, epochs=100, rate=AUTOENCODER_RATE)
    manifold.add_argument("--hidden", type=whole(1), default=256, metavar="M",
                          help="hidden units (default: %(default)s)")
    manifold.add_argument("--dropout", type=number(least=0, below=1), default=0.02, metavar="P",
                          help="share of input numbers set to 0 while it learns; 0 is equation 3 "
                          "as printed (default: %(default)s)")
    manifold.add_argument("--depooling", choices=DEPOOLING, default="random",
                          help="while it learns: random gives one of two frames the whole value, "
                          "average half to each, with which it learns to jitter "
                          "(default: %(default)s; it always runs with averages)")
    manifold.add_argument("--normaliser", choices=FORMS, default="groups",
                          help="what the 66 numbers are divided by: deviations of positions, "
                          "velocities and turning, or the 2016 code's form (default: %(default)s)")
    manifold.add_argument("--alpha", type=number(least=0), default=0.01, metavar="A",
                          help="weight of the sparsity term (default: %(default)s)")
    manifold.set_defaults(run=run_autoencoder)

    style = commands.add_parser(
        "train-style",
        description="Train the transformation network for one style, equations 4 to 10.")
    style.add_argument("motions", metavar="MOTIONS.npz", type=InputPath,
                       help="what `refimpl prepare` wrote")
    style.add_argument("manifold", metavar="MANIFOLD.npz", type=InputPath,
                       help="what `refimpl train-autoencoder` wrote, or with --preprocess a "
                       "network of 2016")
    style.add_argument("--preprocess", metavar="P.npz", type=InputPath,
                       help="the normaliser of a network of 2016 (the authors' two files, or "
                       "`refimpl train-2016`'s), which then is the loss network, with contacts at "
                       "their mean")
    style.add_argument("--style", required=True, metavar="NAME",
                       help="the label of the style's exemplar clips")
    style.add_argument("-o", "--output", metavar="STYLE.npz", type=OutputPath, required=True)
    training_options(style, epochs=100, rate=RATE)
    style.add_argument("--channels", type=whole(1), default=128, metavar="C",
                       help="channels between its layers (default: %(default)s)")
    style.add_argument("--content-style", default="normal", metavar="NAME",
                       help="the style of the clips to learn on, or several: A,B "
                       "(default: %(default)s)")
    style.add_argument("--clips", metavar="REGEX",
                       help="learn only on content clips in whose name this is found")
    style.add_argument("--exemplars", metavar="REGEX",
                       help="take only exemplar clips in whose name this is found")
    style.add_argument("--contents", metavar="A,B", help="learn only these contents (default: all)")
    style.add_argument("--pair", action="append", default=[], metavar="CONTENT=EXEMPLAR",
                       help="pair a content with another content's exemplar; may be repeated "
                       "(default: the same name, or the beginning of it: walk-turn-left with walk)")
    style.add_argument("--reading", choices=list(WEIGHTS), default=Weights().reading,
                       help="of the bars of equations 4 and 5: norms as printed, or squares "
                       "(default: %(default)s)")
    for name in WEIGHED:
        what = (f"weight of the {name} loss, for centimetres" if name != "turn" else
                "what a squared radian counts against a squared centimetre in the trajectory loss")
        values = {reading: getattr(weights, name) for reading, weights in WEIGHTS.items()}
        usual = (f"{values['norm']:g}" if len(set(values.values())) == 1 else
                 ", ".join(f"{value:g} with {reading}" for reading, value in values.items()))
        style.add_argument(f"--weight-{name}", type=number(least=0), metavar="W",
                           help=f"{what} (default: {usual})")
    style.add_argument("--report", metavar="FILE.json", type=OutputPath,
                       help="write what was measured on the held-out clips")
    style.set_defaults(run=run_style)


def training_options(command: argparse.ArgumentParser, epochs: int, rate: float, *,
                     batch: int = BATCH, threads: bool = True) -> None:
    """Add what every training command takes.

    epochs, rate, batch : the defaults;  threads : whether its batches can be computed in parts
    """
    command.add_argument("--epochs", type=whole(1), default=epochs, metavar="N",
                         help="(default: %(default)s)")
    command.add_argument("--batch", type=whole(1), default=batch, metavar="N",
                         help="windows a step (default: %(default)s)")
    command.add_argument("--rate", type=number(above=0), default=rate, metavar="R",
                         help="Adam's learning rate (default: %(default)s)")
    command.add_argument("--width", type=whole(1), default=25, metavar="K",
                         help="frames of a filter (default: %(default)s)")
    command.add_argument("--seed", type=whole(0), default=0, metavar="N",
                         help="(default: %(default)s)")
    if threads:
        command.add_argument("--threads", type=whole(1, 256), default=2, metavar="N",
                             help="compute each batch in so many parts side by side; the same "
                             "number gives the same bits (default: %(default)s)")
    command.set_defaults(also_writes=lambda arguments: {"the checkpoint": checkpoint_of(arguments)})
    command.add_argument("--resume", action="store_true",
                         help="go on from OUTPUT.checkpoint, which every epoch leaves, if it is "
                         "there; without it such a file is kept under another name")
    command.add_argument("--curves", metavar="FILE.png", type=OutputPicture,
                         help="draw the losses by epoch")


def run_autoencoder(arguments: argparse.Namespace) -> None:
    """Train a loss network and write it. A ValueError says what cannot be trained on."""
    dataset = load_dataset(arguments.motions)
    clips = dataset.select(held_out=False)
    if not clips:
        raise ValueError(
            f"{arguments.motions}: found no clip to train on, needed some that are not held out")
    X, normaliser = clean_windows(clips, dataset.source, form=arguments.normaliser)
    print(f"{len(X)} windows of {X.shape[2]} frames from {len(clips)} clips of {dataset.source}")
    settings = {name: getattr(arguments, name)
                for name in ("epochs", "batch", "rate", "alpha", "dropout", "depooling", "hidden",
                             "width", "seed")}
    run = fingerprint(["autoencoder", settings, arguments.threads], X)
    like = init_loss_network(np.random.default_rng(0), hidden=arguments.hidden,
                             width=arguments.width, dtype=X.dtype)
    params = follow(arguments, run, like, ("loss",), lambda state, executor: train_autoencoder(
        X, state=state, **settings,
        gradients=sharded(autoencoder_gradients, arguments.threads, executor)))
    save_manifold(arguments.output,
                  Manifold(params, normaliser, dataset.leg, dataset.bones, arguments.depooling,
                           dataset.rest))
    finish(arguments)
    print(f"{arguments.output}: {arguments.hidden} hidden units, "
          f"filters of {arguments.width} frames")


def run_style(arguments: argparse.Namespace) -> None:
    """Train the transformation network of a style, write it and print what it does to clips that
    were held out. A ValueError says what cannot be trained on.
    """
    dataset = load_dataset(arguments.motions)
    manifold = (bridge.read(arguments.manifold, arguments.preprocess).manifold()
                if arguments.preprocess else load_manifold(arguments.manifold))
    chosen = {name: getattr(arguments, f"weight_{name}") for name in WEIGHED}
    weights = replace(WEIGHTS[arguments.reading],
                      **{name: value for name, value in chosen.items() if value is not None})
    lesson, held_out, exemplars = make_training_set(
        dataset, manifold, arguments.style, content_style=arguments.content_style,
        clips=arguments.clips, exemplars=arguments.exemplars,
        contents=arguments.contents.split(",") if arguments.contents else None,
        pairs=_pairs(arguments.pair), networks=networks)
    counts = ", ".join(f"{len(clips)} clips for {content}" for content, clips in exemplars.items())
    print(f"{len(lesson.X)} windows of {', '.join(exemplars)}; style {arguments.style!r} from "
          + counts)
    settings = {name: getattr(arguments, name)
                for name in ("epochs", "batch", "rate", "channels", "width", "seed")}
    run = fingerprint(["style", settings, arguments.threads, vars(weights), lesson.contents],
                      lesson.X, lesson.contacts, lesson.trajectory, *lesson.grams.values(),
                      *manifold.params.values())
    like = init_transformation_network(np.random.default_rng(0), channels=arguments.channels,
                                       width=arguments.width, dtype=lesson.X.dtype)
    fitted = weights.fitted(manifold.leg, len(manifold.params["b0"]))
    params = follow(arguments, run, like, ("loss", *(term.name for term in EQUATION_10)),
                    lambda state, executor: train_style(
                        lesson, manifold, weights=fitted, state=state, **settings,
                        gradients=sharded(style_gradients, arguments.threads, executor)))
    style = lesson.style(params, manifold, arguments.style, fitted)
    save_style(arguments.output, style)
    finish(arguments)
    measured = held_out_distances(held_out, exemplars, style, dataset.leg)
    for line in table(_distance_rows(measured)):
        print(line)
    if arguments.report:
        write_json(arguments.report, {"style": arguments.style, "clips": measured})
    print(f"{arguments.output}: style {arguments.style!r} for {', '.join(exemplars)}")


def follow(arguments: argparse.Namespace, run: Run, like: Mapping[str, np.ndarray],
           keys: Sequence[str],
           epochs: Callable[[State | None, Executor | None], Iterator[tuple[Record, State]]],
           ) -> dict[str, np.ndarray]:
    """Follow a training loop, from its checkpoint on if that is asked for; leave a checkpoint after
    every epoch; draw the curves.

    run : what the checkpoint must belong to;  like : parameters of the shapes to expect;
    keys : names of the losses to draw;  epochs : (state, executor or None) ->  the generator of
    training   ->  the last parameters
    """
    checkpoint = checkpoint_of(arguments)
    state: Any = None
    records: list[Record] = []
    if arguments.resume and checkpoint.exists():
        state, records, exact = load_checkpoint(checkpoint, run, like, arguments.epochs)
        print(f"{checkpoint}: going on after epoch {state.epoch} of {arguments.epochs}" + (
            "" if exact else
            "; its data differ from today's in their last digits, as they do on another processor: "
            "the result will not be the same bits as an undisturbed run's"))
    elif aside := set_aside(checkpoint):
        print(f"{checkpoint}: found the checkpoint of an earlier run and --resume not given; "
              f"it is kept as {aside}")
    progress = Progress(arguments.epochs - len(records), "epoch")
    threads = getattr(arguments, "threads", None)
    with ThreadPoolExecutor(threads) if threads and threads > 1 else nullcontext() as executor:
        for record, state in epochs(state, executor):
            records.append(record)
            save_checkpoint(checkpoint, state, records, run)
            progress.step(epoch_line(record))
    if arguments.curves:
        from ..pictures import plot
        plot.save(plot.curves([{"epoch": r.epoch, **r.losses} for r in records], keys),
                  arguments.curves)
    return state.params


def checkpoint_of(arguments: argparse.Namespace) -> Path:
    """The path of a run's checkpoint, which stands beside its output."""
    return Path(f"{arguments.output}.checkpoint")


def finish(arguments: argparse.Namespace) -> None:
    """Remove the checkpoint of a run whose output is complete."""
    checkpoint_of(arguments).unlink(missing_ok=True)


def _distance_rows(measured):
    """Held-out clips as rows: style distances of I, T(I) and P(T(I)), and the share left of it."""
    rows = [["held-out clip", "content's style distance", "T(I)", "P(T(I))", "left"]]
    if not measured:
        return [["no clip was held out: nothing to measure the style on"]]
    keys = ("content", "transformed", "projected")
    means = {key: float(np.mean([clip[key] for clip in measured])) for key in keys}
    for clip in [*measured, {"clip": "mean", **means}]:
        rows.append([clip["clip"], *(f"{clip[key]:.1f}" for key in keys),
                     f"{clip['projected'] / clip['content']:.0%}" if clip["content"] else "-"])
    return rows


def _pairs(words):
    for word in words:
        if word.count("=") != 1 or not all(word.split("=")):
            raise ValueError(f"--pair: found {word!r}, needed CONTENT=EXEMPLAR")
    return dict(word.split("=") for word in words)
