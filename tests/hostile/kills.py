"""Kill every command at events of its own: `python -m tests.hostile.kills [KILLS [COMMAND ...]]`

An event is a call that writes (those that `tests.hostile.faults` fails) or a step of progress, and
the kill is SIGKILL or SIGTERM to the command's process, or Ctrl-C to its whole group, as a terminal
sends it. What the command made the last time lies there already. Afterwards inputs are what they
were, every output is the old or the new one and whole, no process is left, and no unfinished file
is: after SIGKILL one, as tests/hostile/README.md says.

A fifth of the kills goes to the two trainings as they are typed, each in a process of its own:
killed after a random number of epochs, resumed to their end, and compared with a run that nobody
disturbed.
"""

from collections import Counter
import ctypes
import io
import json
import os
from pathlib import Path
import random
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
import time
import zipfile

from refimpl.commands import demo
from refimpl.commands.checkpoint import VERSION
from refimpl.commands.progress import Progress
from refimpl.embedded import walkers as synthetic
from refimpl.motion import bvh
from refimpl.storage import FormatError, load_npz
from refimpl.styles import make
from refimpl.styles.files import load_manifold, load_style
from tests.commands.terminals import OnTerminal
from tests.hostile import faults
from tests.hostile.targets import _there, made, quiet, snapshot

AUTOENCODER = ["--hidden", "16", "--width", "9", "--batch", "2"]
STYLE = ["--style", "old", "--channels", "8", "--width", "9", "--batch", "2"]
SMALL = "--hidden 6 --channels 4 --loss-epochs 1 --epochs 1"
COMMANDS = {
    **faults.COMMANDS,
    "prepare by two": "prepare clips -o m.npz --processes 2",
    "blend": "blend clips/walk_old_0.bvh clips/walk_old_1.bvh -o b.bvh",
    "score": "score results.csv --json s.json --sheet s.png",
    "segment": "segment clips/walk_old_0.bvh clips --json g.json",
    "observe": "observe c.bvh --json o.json",
    "styles": "styles --json y.json",
    "styles made": "styles --make box --only old zombie",
    "demo": "demo --out d --json d.json",
    "evaluate": "evaluate clips motions.npz old.npz --most 1 --processes 2 --out v --json v.json",
    "bench": "bench --no-peer --seconds 0.001 --json h.json",
    "experiment holden": f"experiment holden --tables path {SMALL} --processes 2 --json x.json",
    "experiment ground": f"experiment ground {SMALL} --json x.json",
    "experiment code-2016": "experiment code-2016 motions.npz --network n16.npz --preprocess "
                            "q16.npz --styles old --most 1 --json x.json",
    "experiment bodies": "experiment bodies old.npz --most 1 --processes 2 --json x.json",
    "experiment torresani": "experiment torresani --only phrases --orders 1 --out t --into x.json",
    "blends exported": "experiment torresani --export-blends t --blends 2"}
SLOW = ("demo", "evaluate", "bench", "experiment holden", "experiment ground", "experiment bodies",
        "experiment torresani", "blends exported", "styles made", "synthesise")
FRESH = ("export",)                                              # into an empty folder alone
READ_AGAIN = "--into"                                            # it reads what it adds to
SIGNALS = {signal.SIGKILL: -signal.SIGKILL, signal.SIGTERM: 143, signal.SIGINT: 130}


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


def run_and_kill(words, epochs, sent=signal.SIGKILL):
    """Run a command and kill it as soon as it has told of so many epochs.
    ->  whether it was still running
    """
    training = OnTerminal(words, start_new_session=True)
    if training.until(rf"epoch ({'|'.join(map(str, range(epochs, 1000)))})/"):
        os.killpg(training.process.pid, sent)
    return training.end() == SIGNALS[sent]


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
            while (made < kills and run_and_kill(
                    [*words, "--resume"], rng.randint(1, max(1, epochs // 3)),
                    sent := rng.choice(list(SIGNALS)))):
                made += 1
                unfinished = list(folder.glob(".*.part"))
                corrupt += unfinished if sent != signal.SIGKILL else []
                for path in unfinished:
                    path.unlink()
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


class Kill(faults.Faults):
    """Counts the events of a command, and ends its process at the one of a number."""

    def __init__(self, number=0, sent=None):
        super().__init__(number)
        self.sent, self.process = sent, os.getpid()

    def call(self, name):
        if os.getpid() == self.process:                          # not in a worker
            self.names.append(name)
            if len(self.names) == self.fails:
                (os.killpg if self.sent == signal.SIGINT else os.kill)(self.process, self.sent)

    def follow(self, words, said):
        """Run a command in this process, with the smallest demo and box, and tell its events."""
        step = Progress.step
        Progress.step = lambda *given, **more: (self.call("step"), step(*given, **more))[1]
        demo._EPOCHS.update(dict.fromkeys(demo._EPOCHS, 2))
        make.made_style.__kwdefaults__.update(scenes=6, epochs=1)
        with self.planted():
            status, err = quiet(words)
        Path(said).write_text(json.dumps([err, self.names]))
        return status


def killed(words, folder, number=0, sent=None):
    """Run a command in a child, in a copy of a folder, and kill it at an event.
    ->  status, [what was said, events] or None, files afterwards, processes that were left
    """
    with tempfile.TemporaryDirectory() as scratch:
        shutil.copytree(folder, f"{scratch}/w", symlinks=True)
        child = os.fork()
        if child == 0:
            try:
                os.setsid()
                os.chdir(f"{scratch}/w")
                os._exit(Kill(number, sent).follow(words, f"{scratch}/said"))
            finally:
                os._exit(99)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        left = _left()
        with _there(f"{scratch}/w"):
            said = Path(f"{scratch}/said")
            said = json.loads(said.read_text()) if said.exists() else None
            return status, said, snapshot(), left


def _left(seconds=20):
    """Wait for what a dead child has started, now ours.   ->  how many had to be ended"""
    began, ended = time.monotonic(), 0
    while True:
        try:
            if os.waitpid(-1, os.WNOHANG)[0] == 0:
                if time.monotonic() - began > seconds:
                    for process in _children():
                        os.kill(process, signal.SIGKILL)
                        ended += 1
                time.sleep(0.02)
        except ChildProcessError:
            return ended


def _children():
    return [int(stat.parent.name) for stat in Path("/proc").glob("[0-9]*/stat")
            if stat.read_text().rpartition(")")[2].split()[1] == str(os.getpid())]


class Campaign:
    """A command with its old outputs in place, and what it writes when nobody disturbs it."""

    def __init__(self, command, origin, scratch):
        self.words, self.folder = COMMANDS[command], Path(scratch) / "with old outputs"
        status, told, self.made, _ = killed(self.words, origin)
        assert status == 0, told
        shutil.copytree(origin, self.folder, symlinks=True)
        for name, (kind, data) in self.made.items():
            path = self.folder / name
            if not path.exists() and stat.S_ISREG(kind) and command not in FRESH:
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(data if READ_AGAIN in self.words else b"old")
        with _there(self.folder):
            self.before = snapshot()
        status, (_, self.events), self.again, _ = killed(self.words, self.folder)
        assert status == 0

    def kill(self, rng):
        """->  signal, event, what is wrong or "", unfinished files left"""
        kinds, sent = sorted(set(self.events)), rng.choice(list(SIGNALS))
        name = "step" if "step" in kinds and rng.random() < 0.4 else rng.choice(kinds)  # workers
        number = rng.choice([n for n, event in enumerate(self.events, 1) if event == name])
        status, told, after, left = killed(self.words, self.folder, number, sent)
        parts = [f for f in after if f.endswith(".part")]
        lost = [f for f in self.before if f not in after and not self._used_up(f, after)]
        torn = [f for f in after if f not in parts and not self._may_be(f, after[f])]
        wrong = [f"lost {lost}" * bool(lost), f"torn {torn}" * bool(torn),
                 f"{left} processes left" * bool(left),
                 f"left {parts}" * (len(parts) > (sent == signal.SIGKILL)),
                 f"status {status}" * (status != SIGNALS[sent])]
        if told and (told[0].count("refimpl:") != 1 or "Traceback" in told[0]):
            wrong.append(f"said {told[0]!r}")
        return sent.name, name, "; ".join(filter(None, wrong)), len(parts)

    def _used_up(self, name, after):
        """Whether it is the checkpoint of a network that is there, or has been put aside."""
        network = name.removesuffix(".checkpoint")
        return name != network and (after.get(network) == self.again.get(network, ())
                                    or self.before[name] in after.values())

    def _may_be(self, name, found):
        """Whether a file is the old one, the new one, or, where two runs differ as they hold
        seconds, whole.
        """
        if found in (self.before.get(name), self.again.get(name)):
            return True
        if ".checkpoint" not in name and self.made.get(name) == self.again.get(name):
            return False
        try:
            return (bool(json.loads(found[1])) if name.endswith(".json")
                    else zipfile.ZipFile(io.BytesIO(found[1])).testzip() is None)
        except (ValueError, zipfile.BadZipFile):
            return False


def at_events(kills, chosen, seed=0):
    """Share so many kills among commands, six to a slow one.
    ->  Counter of (signal, event), list of what is wrong, unfinished files left
    """
    quick = [command for command in chosen if command not in SLOW] or chosen
    few = {command: 6 for command in chosen if command not in quick}
    kills -= 6 * len(few)
    ctypes.CDLL(None).prctl(36, 1, 0, 0, 0)                      # what a dead child leaves is ours
    counts, wrong, unfinished, rng = Counter(), [], 0, random.Random(seed)
    with tempfile.TemporaryDirectory() as origin:
        made(Path(origin))
        with _there(origin):
            faults.stopped()
        shares = {command: kills // len(quick) + (place < kills % len(quick))
                  for place, command in enumerate(quick)} | few
        for command, share in shares.items():
            with tempfile.TemporaryDirectory() as scratch:
                tried = Campaign(command, origin, scratch)
                for _ in range(share):
                    sent, event, bad, left = tried.kill(rng)
                    counts[sent, event] += 1
                    unfinished += left
                    wrong += [f"{command}, {sent} at {event}: {bad}"] * bool(bad)
            print(f"{command:24} {len(tried.events):6} events, {len(wrong):3} wrong", flush=True)
    return counts, wrong, unfinished


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)     # a shell's background ignores it
    kills = int(sys.argv[1]) if len(sys.argv) > 1 else 500
    trained = 0 if len(sys.argv) > 2 else kills // 5
    counts, wrong, unfinished = at_events(kills - trained, sys.argv[2:] or list(COMMANDS))
    print("\n".join(wrong))
    for key, number in sorted(counts.items()):
        print(f"{number:6}  {' at '.join(key)}")
    print(f"{counts.total()} kills at events of {len(sys.argv[2:]) or len(COMMANDS)} commands, "
          f"{unfinished} unfinished files left by SIGKILL, {len(wrong)} wrong")
    if trained:
        with tempfile.TemporaryDirectory() as name:
            number, under_way, finished, corrupt, differing = campaign(Path(name), trained)
        print(f"{number} kills, {under_way} of them after an epoch was done, {finished} pairs of "
              f"trainings brought to their end, {len(corrupt)} corrupt files, {len(differing)} "
              "differing results")
        wrong += corrupt + differing
    sys.exit(bool(wrong))
