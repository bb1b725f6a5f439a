"""Kill training with SIGKILL after a random number of epochs, resume it, and compare with a run
that nobody disturbed. `python -m tests.hostile.kills 50`
"""

import os
from pathlib import Path
import random
import signal
import subprocess
import sys
import tempfile

from refimpl.commands.checkpoint import VERSION
from refimpl.styles.files import load_manifold, load_style
from refimpl.motion import bvh
from refimpl.embedded import walkers as synthetic
from refimpl.storage import FormatError, load_npz
from tests.commands.terminals import OnTerminal

AUTOENCODER = ["--hidden", "16", "--width", "9", "--batch", "2"]
STYLE = ["--style", "old", "--channels", "8", "--width", "9", "--batch", "2"]


def prepare_folder(folder):
    """A few clips and motions.npz."""
    clips = folder / "clips"
    clips.mkdir()
    for number in range(3):
        for style in ("normal", "old"):
            bvh.write_bvh(clips / f"walk_{style}_{number}.bvh",
                          synthetic.make_clip("walk", style, synthetic.person(number),
                                              seconds=6.0).clip)
    assert run(["prepare", str(clips), "-o", str(folder / "motions.npz")]) == 0


def commands(folder, name, epochs=6):
    """The words of both trainings, writing NAME-manifold.npz and NAME-old.npz."""
    first, second = [*AUTOENCODER, "--epochs", str(epochs)], [*STYLE, "--epochs", str(epochs)]
    manifold = folder / f"{name}-manifold.npz"
    return (["train-autoencoder", str(folder / "motions.npz"), "-o", str(manifold), *first],
            ["train-style", str(folder / "motions.npz"), str(folder / "whole-manifold.npz"), "-o",
             str(folder / f"{name}-old.npz"), *second])


def run(words):
    """Run a command to its end in a process of its own.   ->  status"""
    return subprocess.run([sys.executable, "-m", "refimpl", *words], stdout=subprocess.DEVNULL,
                          stderr=subprocess.DEVNULL).returncode


def run_and_kill(words, epochs):
    """Run a command and kill it as soon as it has told of so many epochs.
    ->  whether it was still running
    """
    training = OnTerminal(words, start_new_session=True)
    if training.until(rf"epoch ({'|'.join(map(str, range(epochs, 1000)))})/"):
        os.killpg(training.process.pid, signal.SIGKILL)
    return training.end() == -signal.SIGKILL


def corrupt_files(folder):
    """Files under a final name that cannot be read whole.   ->  list of paths"""
    bad = []
    for path in folder.glob("killed-*"):
        try:
            if path.name.endswith(".checkpoint"):
                load_npz(path, "checkpoint", VERSION, ())
            else:
                (load_manifold if "manifold" in path.name else load_style)(path)
        except FormatError:
            bad.append(path)
    return bad


def campaign(folder, kills, epochs=60, seed=0):
    """Kill and resume until so many kills were made.
    ->  kills, those that hit a training under way, finished runs, corrupt files, differing results
    """
    prepare_folder(folder)
    for words in commands(folder, "whole", epochs):
        assert run(words) == 0
    rng, made, under_way, finished, corrupt, differing = random.Random(seed), 0, 0, 0, [], []
    while made < kills:
        for words in commands(folder, "killed", epochs):
            while (made < kills and run_and_kill([*words, "--resume"],
                                                 rng.randint(1, max(1, epochs // 3)))):
                made += 1
                under_way += Path(f"{words[words.index('-o') + 1]}.checkpoint").exists()
                corrupt += corrupt_files(folder)
            if run([*words, "--resume"]) != 0:
                differing.append(" ".join(words))
        finished += 1
        for name in ("manifold", "old"):
            if (folder / f"killed-{name}.npz").read_bytes() != (folder
                                                                / f"whole-{name}.npz").read_bytes():
                differing.append(name)
            (folder / f"killed-{name}.npz").unlink()
    return made, under_way, finished, corrupt, differing


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        made, under_way, finished, corrupt, differing = campaign(Path(name),
                                                                 int(sys.argv[1]) if len(sys.argv)
                                                                 > 1 else 50)
    print(
        f"{made} kills, {under_way} of them after an epoch was done, {finished} pairs of trainings "
        f"brought to their end, {len(corrupt)} corrupt files, {len(differing)} differing results")
    sys.exit(bool(corrupt or differing))
