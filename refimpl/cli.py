"""The command line: which words there are. What they do stands in `commands/`, one file a group."""

import argparse
from collections.abc import Sequence
import importlib
from itertools import groupby
import os
from pathlib import Path
import signal
import sys
import threading
from typing import Any, NoReturn

from . import __version__
from .blas import prefer

prefer(os.environ)                                               # before NumPy is first imported

from .commands.options import InputFolder, OutputFolder, files_of  # noqa: E402
from .commands.terminal import safe_streams  # noqa: E402
from .storage import (OutputError, check_folder, check_outputs, identity,  # noqa: E402
                      protected)

# Each command's module, which is loaded when it is typed, and what it is for.
COMMANDS = {
    "styles": ("styles", "list the styles in the box"),
    "demo": ("demo", "run everything on the embedded motion"),
    "inspect": ("inspect", "say what is in a BVH file"),
    "prepare": ("prepare", "make a folder of BVH clips ready for training"),
    "train-autoencoder": ("train", "train the loss network (equation 3)"),
    "train-style": ("train", "train a style (equation 10)"),
    "train-2016": ("train_2016", "train the network of the 2016 system"),
    "transfer": ("transfer", "stylise a BVH clip"),
    "evaluate": ("evaluate", "measure results of 2016 and 2017 beside real motion"),
    "score": ("score", "score a table of results, anybody's, from files alone"),
    "observe": ("blend", "flow, weight and time of clips, as two computed observers see them"),
    "blend": ("blend", "a clip between two clips of one action"),
    "segment": ("torresani", "cut a clip into the actions of a database"),
    "synthesise": ("torresani", "a clip with the flow, weight and time that you ask for"),
    "experiment": ("torresani", "repeat a paper's experiments"),
    "check": ("check", "hold the reference against its second derivation, or judge another "
              "implementation"),
    "export": ("check", "write golden vectors"),
    "bench": ("bench", "measure speed against PyTorch and ONNX Runtime")}


class Parser(argparse.ArgumentParser):
    """argparse's parser, which answers wrong words in one line like every other error here."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong and end with status 2."""
        self.exit(2, f"refimpl: error: {' '.join(message.split())}; see `{self.prog} --help`\n")


class Terminated(BaseException):
    """SIGTERM: raised where the program stands, so that nothing is left half written."""


class _Listed:
    """argparse's subparsers, each told what it is for."""

    def __init__(self, commands):
        self.commands = commands

    def add_parser(self, name: str, **options: Any) -> argparse.ArgumentParser:
        """As argparse's."""
        return self.commands.add_parser(name, help=COMMANDS[name][1], **options)


def parser(words: Sequence[str] | None = None) -> Parser:
    """The command line as an argparse parser.

    words : of a call, whose command alone is loaded then; all are unless they are given
    """
    top = Parser(prog="refimpl",
                 description="Motion style transfer in NumPy with hand-written gradients.",
                 epilog="Every step leaves one file, so that each can be looked at and repeated. "
                        "`refimpl COMMAND --help` tells more.")
    top.add_argument("--version", action="version", version=f"refimpl {__version__}")
    commands = _Listed(top.add_subparsers(title="commands", metavar="COMMAND", required=True))
    typed = next((word for word in words or () if word in COMMANDS), "")
    chosen = {module for name, (module, _) in COMMANDS.items() if words is None or name == typed}
    for module, group in groupby(COMMANDS, key=lambda name: COMMANDS[name][0]):
        if module in chosen:
            importlib.import_module(f".commands.{module}", __package__).add_commands(commands)
        else:
            for name in group:
                commands.add_parser(name)
    return top


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    With REFIMPL_TRACEBACK set in the environment an error shows where it came from.

    argv : words, the process's own unless given
    ->  exit status: 0 done and good; 1 done, and something disagrees; 2 input that cannot be used,
    or a file that cannot be read or written (one line says what, where and what to do); 130 stopped
    with Ctrl-C, 143 with SIGTERM
    """
    with safe_streams() as out:
        words = sys.argv[1:] if argv is None else argv
        arguments = parser(words).parse_args(words)
        _told.clear()
        before = _on_termination(_terminated)
        try:
            status = _run(arguments) or 0
            out.flush()
            if _told:                                            # Python drops it in a callback
                raise Terminated
            return status
        except (KeyboardInterrupt, Terminated) as stop:
            told = isinstance(stop, Terminated)
            print(f"refimpl: {'told to end' if told else 'stopped'}; nothing is half written, and "
                  "a training goes on from its last epoch with --resume", file=sys.stderr)
            return 143 if told else 130
        except Exception as error:
            if os.environ.get("REFIMPL_TRACEBACK"):
                raise
            print(f"refimpl: error: {_one_line(error, arguments)}", file=sys.stderr)
            return 2
        finally:
            _on_termination(before)


def _run(arguments):
    """Check that no output would destroy anything, then do the work with the inputs protected."""
    inputs, outputs = files_of(arguments)
    folders = [path for path in inputs.values() if isinstance(path, InputFolder)]
    read = {**inputs, **{path: path for folder in folders for path in _files_below(folder)}}
    check_outputs({w: p for w, p in outputs.items() if not isinstance(p, OutputFolder)}, read)
    for word, path in outputs.items():
        if isinstance(path, OutputFolder):
            if identity(path) in map(identity, folders):
                raise OutputError(f"{path}: found one folder for {word} and the input, needed "
                                  "another one to write into; nothing was written")
            check_folder(path)
    with protected(read.values()):
        return arguments.run(arguments)


def _files_below(folder):
    """Files of an input folder, however deep."""
    return [os.path.join(where, name) for where, _, names in os.walk(folder) for name in names]


_told: list[int] = []                                            # the signals to end that came


def _terminated(number, frame):
    signal.signal(number, signal.SIG_IGN)                        # once is enough
    _told.append(number)
    raise Terminated


def _on_termination(handler):
    """Set what SIGTERM does, which a thread may not.   ->  what it did before, None in a thread"""
    if handler is None or threading.current_thread() is not threading.main_thread():
        return None
    return signal.signal(signal.SIGTERM, handler)


def _one_line(error, arguments):
    """What is wrong, in one line that names a file of the command."""
    text = " ".join(str(error).split())
    if isinstance(error, OSError) and error.strerror and error.filename is not None:
        said = f"{error.filename}: {error.strerror}"
    elif isinstance(error, OSError) and error.strerror:
        said = error.strerror
    elif isinstance(error, (ValueError, OSError)):
        said = text or type(error).__name__
    elif isinstance(error, MemoryError):
        said = f"not enough memory ({text or 'none left'}); try a smaller input"
    elif isinstance(error, ArithmeticError):
        said = (f"found numbers that cannot be computed with ({error}); is a size or a weight "
                "absurd?")
    else:
        said = (f"could not go on ({type(error).__name__}: {text[:200]}); this is a fault of "
                "refimpl: REFIMPL_TRACEBACK=1 in the environment shows where")
    inputs, outputs = files_of(arguments)
    files = [*inputs.values(), *outputs.values()]
    if files and not said.startswith("-") and not any(Path(f).name in said or f in said
                                                      for f in files):
        said = f"{', '.join(list(inputs.values())[:4] or files[:1])}: {said}"
    return said.replace("\n", "\\n")                             # a file may be called so
