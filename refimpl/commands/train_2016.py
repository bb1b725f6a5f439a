"""`refimpl train-2016`: the network of the 2016 code, trained on a user's clips, in files like the
authors' own.
"""

import argparse
from typing import Any

import numpy as np

from ..holden2016 import bridge, rows
from ..holden2016.files import save_network, save_preprocess
from ..holden2016.network import init_network
from ..holden2016.train import EPOCHS, RATE, train
from .checkpoint import fingerprint
from ..motion.dataset import load_dataset
from .options import InputPath, OutputPath, whole
from .train import finish, follow, training_options

DESCRIPTION = """Train the autoencoder of the 2016 code on clips: two dropouts of 0.25, depooling by
chance, a decoder of its own. It writes the two files that `transfer --method optimise` and
`evaluate` read as they read the authors' own. It uses the plain reference formulas and is slow: 0.1
s a window and epoch at full width. The script's rate of 1e-5 is for the authors' large databases;
with a few hundred windows take more, 5e-4 with batches of 10, say."""


def add_commands(commands: Any) -> None:
    """Add `train-2016` to the subparsers of the program."""
    command = commands.add_parser("train-2016", description=DESCRIPTION)
    command.add_argument("motions", metavar="MOTIONS.npz", type=InputPath,
                         help="what `refimpl prepare` wrote")
    command.add_argument("-o", "--output", metavar="NETWORK.npz", type=OutputPath, required=True,
                         help="the network, like network_core.npz")
    command.add_argument("--preprocess", metavar="PREPROCESS.npz", type=OutputPath, required=True,
                         help="its normaliser, like preprocess_core.npz")
    training_options(command, epochs=EPOCHS, rate=RATE, batch=1, threads=False)
    command.add_argument("--hidden", type=whole(1), default=256, metavar="M",
                         help="hidden units (default: %(default)s)")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Train a network of 2016 and write its two files. A ValueError says what cannot be trained."""
    if not arguments.width % 2:
        raise ValueError(f"--width: found {arguments.width}, needed an odd number, as the authors' "
                         "files have")
    dataset = load_dataset(arguments.motions)
    windows = bridge.training_windows(dataset.select(held_out=False))
    if not len(windows):
        raise ValueError(f"{arguments.motions}: found no clip of more than {rows.SHORTEST} frames "
                         "to train on, needed some that are not held out")
    normaliser = rows.fit_normaliser(windows)
    X = np.ascontiguousarray(normaliser.apply(windows), np.float32)
    print(f"{len(X)} windows of {X.shape[2]} frames of {dataset.source}, remainders padded as the "
          "2016 code does")
    settings = {name: getattr(arguments, name)
                for name in ("epochs", "batch", "rate", "hidden", "width", "seed")}
    like = init_network(np.random.default_rng(0), hidden=arguments.hidden, width=arguments.width,
                        dtype=X.dtype)
    params = follow(arguments, fingerprint(["2016", settings], X), like, ("loss",),
                    lambda state, _: train(X, state=state, **settings))
    save_network(arguments.output, params)
    save_preprocess(arguments.preprocess, normaliser)
    finish(arguments)
    print(f"{arguments.output}, {arguments.preprocess}: {arguments.hidden} hidden units, "
          f"filters of {arguments.width} frames")
