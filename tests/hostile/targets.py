"""Every output of every command on fifteen kinds of target, every folder on four: is a file lost
that was not to be written? `python -m tests.hostile.targets [COMMAND ...]`

Outputs are found in the parser, so that a new option is tried as soon as it is there. Targets that
must be refused are refused before any work, in one line, and nothing in the folder is another byte;
of the others only the target may change. A link stays a link, a pipe a pipe.
"""

import argparse
import contextlib
import io
import os
from pathlib import Path
import sys
import tempfile
import threading

from refimpl.cli import main, parser
from refimpl.commands.options import OutputFolder, OutputPath
from refimpl.embedded import walkers
from refimpl.motion import bvh

TINY = "--epochs 1 --width 9 --batch 4"
SMALL = "--hidden 6 --channels 4 --loss-epochs 1 --epochs 1"
WORDS = {       # a command that works, without any output but those that it needs
    "inspect": "c.bvh",
    "prepare": "clips -o OUT",
    "train-autoencoder": f"motions.npz -o OUT --hidden 6 {TINY}",
    "train-style": f"motions.npz manifold.npz --style old -o OUT --channels 4 {TINY}",
    "train-2016": f"motions.npz -o OUT --preprocess OUT2 --hidden 6 {TINY}",
    "transfer": "old.npz c.bvh -o OUT.bvh",
    "synthesise": "c.bvh -o OUT.bvh",
    "check": "refimpl.nn --operations gram --profile small",
    "observe": "c.bvh",
    "experiment ground": SMALL,
    "experiment code-2016": "motions.npz --network n16.npz --preprocess q16.npz --styles old "
                            "--most 1",
    "bench": "--no-peer --seconds 0.001",
    "evaluate": "clips motions.npz old.npz --most 1", "experiment bodies": "old.npz --most 1",
    "score": "results.csv", "segment": "clips/walk_old_0.bvh clips", "styles": "",
    "blend": "clips/walk_old_0.bvh clips/walk_old_1.bvh -o OUT.bvh",
    "demo": "", "export": "OUT", "experiment torresani": "--only phrases --orders 1",
    "experiment holden": f"--tables path {SMALL}"}
SLOW = ("experiment", "bench", "evaluate", "demo", "synthesise", "export", "train-2016")
REFUSED = ("folder", "missing folder", "below a file", "circle", "input", "hard link", "linked "
           "input", "other output", "long name")
WRITTEN = ("new", "old", "link", "dangling", "pipe", "device")
OWN_FOLDERS = "./refimpl-"                       # where commands write when they are told no --out
NO_FOLDER = ("file", "below a file", "circle", "input")
INPUT = {"evaluate": "motions.npz", "synthesise": "c.bvh", "check": "known",
         "experiment bodies": "old.npz", "observe": "c.bvh",
         "experiment code-2016": "motions.npz", "prepare": "clips/walk_old_0.bvh",
         "train-autoencoder": "motions.npz", "train-style": "manifold.npz",
         "train-2016": "motions.npz", "score": "results.csv", "blend": "clips/walk_old_0.bvh",
         "segment": "clips/walk_old_0.bvh"}


def made(folder):
    """Clips, motions.npz, manifold.npz and old.npz of tiny networks, in an empty folder."""
    (folder / "clips").mkdir()
    for style in ("normal", "old"):
        for number in range(4):
            bvh.write_bvh(folder / "clips" / f"walk_{style}_{number}.bvh", walkers.make_clip(
                "walk", style, walkers.person(number), seconds=4.1, seed=number).clip)
    bvh.write_bvh(folder / "c.bvh", walkers.make_clip("walk", "normal", seconds=2.0).clip)
    (folder / "known").write_text("gram/*\n")
    (folder / "results.csv").write_text("content,style,result\n"
                                        "clips/walk_normal_0.bvh,clips/walk_old_0.bvh,c.bvh\n")
    with contextlib.chdir(folder) if hasattr(contextlib, "chdir") else _there(folder):
        for words in ("prepare clips -o motions.npz --hold-out 0.25",
                      f"train-autoencoder motions.npz -o manifold.npz --hidden 6 {TINY}",
                      "train-style motions.npz manifold.npz --style old -o old.npz --channels 4 "
                      f"--clips [01]$ --exemplars [01]$ {TINY}",
                      f"train-2016 motions.npz -o n16.npz --preprocess q16.npz --hidden 6 {TINY}"):
            assert quiet(words)[0] == 0


@contextlib.contextmanager
def _there(folder):
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def quiet(words):
    """->  status, what was said on standard error"""
    err = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(err):
        try:
            return main(words.split() if isinstance(words, str) else words), err.getvalue()
        except SystemExit as stop:
            return stop.code, err.getvalue()


def outputs():
    """Every output of every command.   ->  list of (command, option, "" for a folder's, or suffix)
    """
    found = []

    def walk(parser, name):
        for action in parser._actions:
            if isinstance(action, argparse._SubParsersAction):
                for word, other in action.choices.items():
                    walk(other, f"{name} {word}".strip())
            elif isinstance(action.type, type) and issubclass(action.type, OutputPath):
                option = action.option_strings[0] if action.option_strings else action.dest
                found.append((name, option, issubclass(action.type, OutputFolder)))
    walk(parser(), "")
    return found


def snapshot():
    """Everything below the current folder: kind, and bytes or where a link leads."""
    found = {}
    for where, folders, names in os.walk("."):
        for name in [*folders, *names]:
            path = os.path.join(where, name)
            kind = os.lstat(path).st_mode & 0o170000
            found[path] = (kind, os.readlink(path) if os.path.islink(path) else
                           Path(path).read_bytes() if os.path.isfile(path) else b"")
    return found


def target_of(kind, command, ending):
    """Put such a target there.   ->  its path"""
    name = f"target{ending}"
    source = INPUT.get(command, "c.bvh")
    if kind == "folder":
        os.mkdir(name)
    elif kind == "old":
        Path(name).write_text("{}")
    elif kind == "circle":
        os.symlink("round" + ending, name)
        os.symlink(name, "round" + ending)
    elif kind in ("link", "dangling"):
        Path("there.txt").write_text("{}")
        os.symlink("there.txt" if kind == "link" else "not there.txt", name)
    elif kind == "hard link":
        os.link(source, name)
    elif kind == "linked input":
        os.symlink(source, name)
    elif kind == "pipe":
        os.mkfifo(name)
    return {"input": source, "missing folder": f"no/{name}", "below a file": f"{source}/{name}",
            "long name": "x" * 300 + ending, "device": "/dev/null"}.get(kind, name)


def words_with(command, option, path, kind):
    """The command's words with this output at that path."""
    words = [*command.split(), *WORDS[command].split()]
    place = {"-o": "OUT.bvh" if "OUT.bvh" in words else "OUT", "folder": "OUT",
             "--preprocess": "OUT2"}.get(option)
    if place in words:
        words[words.index(place)] = path
    else:
        words += [option, path]
    if kind == "other output":                                   # a second one of the same file
        other = {o: w for c, o, is_folder in outputs() if c == command and not is_folder
                 for w in [o] if o not in (option, "--preprocess")}
        if not other:
            return None
        second = next(iter(other))
        if second == "-o":
            words = [path if word.startswith("OUT") and word != "OUT2" else word for word in words]
        else:
            words += [second, path]
    if kind in ("input", "hard link", "linked input") and command == "check":
        words += ["--xfail", "known"]
    return words


def tried(command, option, kind):
    """One output on one kind of target, in the current folder.   ->  what is wrong, or ""  """
    if kind in ("input", "hard link", "linked input") and command in (
            "bench", "experiment ground", "experiment holden", "styles"):
        return None                                              # it reads no file
    ending = {"--plot": ".png", "--sheet": ".png", "--curves": ".png", "--animate": ".html"}.get(
        option, ".bvh" if option == "-o" and f"{WORDS[command]} ".find("OUT.bvh ") >= 0 else "")
    path = target_of(kind, command, ending)
    words = words_with(command, option, path, kind)
    if words is None:
        return None
    before, read = snapshot(), []
    reader = threading.Thread(target=lambda: read.append(Path(path).read_bytes()), daemon=True)
    if kind == "pipe":
        reader.start()
    status, err = quiet(words)
    if kind == "pipe":
        reader.join(5)
    after = snapshot()
    mine = {f"./{path}", "./there.txt" if kind == "link" else "./not there.txt"}
    mine |= {f"./{word}" for word in words if word.startswith("OUT")}
    lost = [name for name in before if before[name] != after.get(name)
            and (kind in REFUSED or name not in mine)]
    left = [name for name in after if name not in before
            and (kind in REFUSED or name not in mine and not name.startswith(OWN_FOLDERS))
            and "__pycache__" not in name]
    if lost or left:
        return f"lost {lost}, left {left}"
    if kind in REFUSED:
        good = status == 2 and err.startswith("refimpl: error:") and err.count("\n") == 1
        return "" if good else f"status {status}, said {err[-200:]!r}"
    if status not in (0, 1) or (kind == "pipe" and not (read and read[0])):
        return f"status {status}, said {err[-200:]!r}"
    if kind in ("link", "dangling") and not os.path.islink(path):
        return "a link was replaced"
    return ""


def tried_folder(command, option, kind):
    """One folder to write into that cannot be one, in the current folder.   ->  what is wrong"""
    path = {"input": INPUT.get(command, "c.bvh"), "below a file": "c.bvh/deep/er"}.get(kind, "no")
    if kind == "file":
        Path(path).write_text("{}")
    elif kind == "circle":
        os.symlink("round", path)
        os.symlink(path, "round")
    before = snapshot()
    status, err = quiet(words_with(command, option, path, kind))
    good = status == 2 and err.startswith("refimpl: error:") and err.count("\n") == 1
    return ("" if good else f"status {status}, said {err[-200:]!r}") + (
        "" if snapshot() == before else "; something was written")


def campaign(origin, commands, kinds):
    """->  list of (command, option, kind, what is wrong or None where there is no such thing)"""
    import shutil
    told = []
    for command, option, is_folder in outputs():
        for kind in () if command not in commands else NO_FOLDER if is_folder else kinds:
            with tempfile.TemporaryDirectory() as folder:
                shutil.copytree(origin, f"{folder}/w", symlinks=True)
                with _there(f"{folder}/w"):
                    told.append((command, option, kind, (
                        tried_folder if is_folder else tried)(command, option, kind)))
    return told


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        made(Path(folder))
        told = campaign(folder, sys.argv[1:] or list(WORDS), (*REFUSED, *WRITTEN))
    tried_ = [row for row in told if row[3] is not None]
    for command, option, kind, wrong in tried_:
        if wrong:
            print(f"{command} {option}, {kind}: {wrong}")
    there = {(command, option) for command, option, _, _ in tried_}
    missing = sorted({c for c, *_ in outputs()} - set(WORDS))
    print(f"{len(there)} outputs of {len({c for c, _ in there})} commands, {len(tried_)} pairs of "
          f"an output and a kind of target, {sum(bool(row[3]) for row in tried_)} wrong"
          + (f"; not tried: {', '.join(missing)}" if missing else ""))
    sys.exit(any(row[3] for row in tried_))
