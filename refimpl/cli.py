"""The command line: which words there are. What they do stands in `commands/`, one file a group."""

import argparse
from collections.abc import Sequence
import os
from pathlib import Path
import signal
import sys
import threading
from typing import NoReturn

from . import __version__
from .blas import prefer

prefer(os.environ)                                               # before NumPy is first imported

from .commands import (bench, blend, check, demo, evaluate, inspect, prepare,  # noqa: E402
                       score, styles, torresani, train, train_2016, transfer)
from .commands.options import InputFolder, OutputFolder, files_of  # noqa: E402
from .commands.terminal import safe_streams  # noqa: E402
from .storage import (OutputError, check_folder, check_outputs, identity,  # noqa: E402
                      protected)

GROUPS = (styles, demo, inspect, prepare, train, train_2016, transfer, evaluate, score, blend,
          torresani, check, bench)


class Parser(argparse.ArgumentParser):
    """argparse's parser, which answers wrong words in one line like every other error here."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong and end with status 2."""
        self.exit(2, f"refimpl: error: {' '.join(message.split())}; see `{self.prog} --help`\n")


class Terminated(BaseException):
    """SIGTERM: raised where the program stands, so that nothing is left half written."""


def parser() -> Parser:
    """The whole command line as an argparse parser."""
    top = Parser(prog="refimpl",
                 description="Motion style transfer in NumPy with hand-written gradients.",
                 epilog="Every step leaves one file, so that each can be looked at and repeated. "
                        "`refimpl COMMAND --help` tells more.")
    top.add_argument("--version", action="version", version=f"refimpl {__version__}")
    commands = top.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for group in GROUPS:
        group.add_commands(commands)
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
        arguments = parser().parse_args(argv)
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
