"""Every fallible call of a command's writing fails once. `python -m tests.hostile.faults [COMMAND
...]`

A command is run once to count its calls of open, write, flush, close, fsync, chmod, replace,
rename, unlink, mkdir and the temporary file that tries a folder. Then it is run again for each of
them (of the later writes of a long file for some), and that call alone fails. Afterwards inputs are
what they were, every output is the old file or the whole new one, nothing else is there, and one
line has said what happened.
"""

import builtins
import contextlib
import errno
import os
from pathlib import Path
import shutil
import sys
import tempfile

from refimpl.cli import Terminated
from tests.hostile.targets import TINY, _there, made, quiet, snapshot

TWICE = TINY.replace("--epochs 1", "--epochs 2")
COMMANDS = {
    "inspect": "inspect c.bvh --write-mapping m.csv --json i.json",
    "transfer": "transfer old.npz c.bvh -o o.bvh --plot p.png --animate a.html --json t.json",
    "prepare": "prepare clips -o m.npz",
    "train-autoencoder": f"train-autoencoder motions.npz -o n.npz --hidden 6 --curves k.png {TINY}",
    "train-style": "train-style motions.npz manifold.npz --style old -o s.npz --channels 4 "
                   f"--report r.json {TINY}",
    "resume": f"train-autoencoder motions.npz -o half.npz --hidden 6 --resume {TWICE}",
    "anew": f"train-autoencoder motions.npz -o half.npz --hidden 6 {TWICE}",
    "train-2016": f"train-2016 motions.npz -o n.npz --preprocess q.npz --hidden 6 {TINY}",
    "check": "check refimpl.nn --operations gram --profile small --json c.json --junit c.xml",
    "export": "export golden --operations gram",
    "synthesise": "synthesise c.bvh -o y.bvh --neighbours 3 --looks 1"}
ERRORS = {"no space": lambda: OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)),
          "not allowed": lambda: PermissionError(errno.EACCES, os.strerror(errno.EACCES)),
          "device": lambda: OSError(errno.EIO, os.strerror(errno.EIO)),
          "interrupted": lambda: InterruptedError(errno.EINTR, os.strerror(errno.EINTR)),
          "memory": MemoryError, "Ctrl-C": KeyboardInterrupt, "SIGTERM": Terminated}
CALLS = ("fsync", "chmod", "replace", "rename", "unlink", "remove", "mkdir", "open")


class _File:
    """A file whose write, flush and close may fail."""

    def __init__(self, file, faults):
        self._file, self._faults = file, faults

    def __getattr__(self, name):
        return getattr(self._file, name)

    def write(self, data):
        self._faults.call("write")
        return self._file.write(data)

    def flush(self):
        self._faults.call("flush")
        return self._file.flush()

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self._file.close()
        if error[0] is None:
            self._faults.call("close")


class Faults:
    """Counts calls, and fails the one of a number.

    fails : number of the call that fails, none with 0;  error : makes the exception
    """

    def __init__(self, fails=0, error=None):
        self.fails, self.error, self.names = fails, error, []

    def call(self, name):
        self.names.append(name)
        if len(self.names) == self.fails:
            raise self.error()

    @contextlib.contextmanager
    def planted(self):
        """While the block runs, calls from the package are counted and fail."""
        kept = {(os, name): getattr(os, name) for name in CALLS}
        kept |= {(builtins, "open"): open, (tempfile, "TemporaryFile"): tempfile.TemporaryFile}

        def planted(name, function):
            def call(*arguments, **options):
                caller = sys._getframe(1).f_globals.get("__name__", "")
                mode = (options.get("mode") or (arguments[1:2] or ("r",))[0]) if (
                    function is kept[builtins, "open"]) else "w"
                if (caller.startswith(("refimpl", "pathlib")) and "terminal" not in caller
                        and set("wxa") & set(str(mode))):
                    self.call(name)
                    result = function(*arguments, **options)
                    return _File(result, self) if function is kept[builtins, "open"] else result
                return function(*arguments, **options)
            return call
        try:
            for (owner, name), function in kept.items():
                setattr(owner, name, planted(name, function))
            yield
        finally:
            for (owner, name), function in kept.items():
                setattr(owner, name, function)


def run(words, folder, faults):
    """A command in a fresh copy of a folder.   ->  status, what was said, files before and after"""
    with tempfile.TemporaryDirectory() as scratch:
        shutil.copytree(folder, f"{scratch}/w", symlinks=True)
        with _there(f"{scratch}/w"):
            before = snapshot()
            with faults.planted():
                status, err = quiet(words)
            return status, err, before, snapshot()


def _same(name, found, needed):
    """Whether a file is one of those that may be there; a checkpoint holds seconds."""
    return found in needed or (".checkpoint" in name and found[1][:2] == b"PK")


def fault_of(words, folder, number, error, whole):
    """Fail one call.   whole : files after an undisturbed run   ->  what is wrong, or "" """
    faults = Faults(number, ERRORS[error])
    status, err, before, after = run(words, folder, faults)
    if len(faults.names) < number:               # a picture's compression is not always as long
        return ""
    name = faults.names[number - 1]
    where = f"{words.split()[0]}, {name} ({number}), {error}: "
    lost = [f for f in before if f not in after and f not in ("./half.npz.checkpoint",)]
    odd = [f for f in after if not _same(f, after[f], (before.get(f), whole.get(f)))]
    odd += [f for f in after if ".part" in f]
    if before.get("./half.npz.checkpoint") and not any(
            f.startswith("./half.npz") for f in after):
        lost.append("./half.npz.checkpoint")
    if lost or odd:
        return f"{where}lost {lost}, odd {odd}"
    if status == 0 and {f for f in whole if "__pycache__" not in f} - set(after):
        return f"{where}status 0 without {set(whole) - set(after)}"
    said = [line for line in err.splitlines() if line.startswith("refimpl:")
            and "warning" not in line]
    wanted = {"Ctrl-C": 130, "SIGTERM": 143}.get(error, 2)
    if status not in (0, wanted) or (status and len(said) != 1) or "Traceback" in err:
        return f"{where}status {status}, said {said or err[-200:]}"
    if "this is a fault of refimpl" in err:
        return where + err[-300:]
    return ""


def chosen(names, errors, often):
    """Which call fails how.   ->  list of (number, error)

    The first and second call of each kind fail in every way; later ones, of which a long file has
    hundreds, in one way each, and one in `often` of them.
    """
    pairs, seen = [], {}
    for number, name in enumerate(names, start=1):
        seen[name] = seen.get(name, 0) + 1
        if seen[name] <= 2:
            pairs += [(number, error) for error in errors]
        elif name not in ("write", "flush") or seen[name] % often == 0:
            pairs.append((number, errors[number % len(errors)]))
    return pairs


def campaign(folder, commands, errors, often=20):
    """->  {command: (calls, runs)}, list of what is wrong"""
    if not (folder / "half.npz.checkpoint").exists():
        with _there(folder):
            stopped()
    counts, wrong = {}, []
    for command in commands:
        words = COMMANDS[command]
        faults = Faults()
        status, err, _, whole = run(words, folder, faults)
        assert status == 0, err
        pairs = chosen(faults.names, errors, often)
        counts[command] = (len(faults.names), len(pairs))
        wrong += filter(None, (fault_of(words, folder, number, error, whole)
                               for number, error in pairs))
        print(command, counts[command], len(wrong), flush=True)
    return counts, wrong


def stopped():
    """Train for one epoch of two and stop, so that the checkpoint is there for "resume"."""
    from refimpl.commands import train
    save = train.save_checkpoint

    def saving(*arguments):
        save(*arguments)
        raise KeyboardInterrupt
    train.save_checkpoint = saving
    try:
        assert quiet(COMMANDS["anew"])[0] == 130
    finally:
        train.save_checkpoint = save


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        made(Path(scratch))
        counts, wrong = campaign(Path(scratch), sys.argv[1:] or list(COMMANDS), list(ERRORS))
    for line in wrong[:60]:
        print(line)
    for command, (calls, runs) in counts.items():
        print(f"{command:20} {calls:5} calls, {runs:6} runs")
    print(f"{sum(c for c, _ in counts.values())} calls of {len(counts)} commands, "
          f"{sum(r for _, r in counts.values())} runs with one fault each, {len(wrong)} wrong")
    sys.exit(bool(wrong))
