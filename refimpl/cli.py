"""The command line: which words there are. What they do stands in `commands/`, one file a group."""

import argparse
import os
import sys

from .blas import prefer

prefer(os.environ)                                               # before NumPy is first imported, hence before the commands

from .commands import bench, check, demo, evaluate, inspect, prepare, torresani, train, transfer

GROUPS = (demo, inspect, prepare, train, transfer, evaluate, torresani, check, bench)


class Parser(argparse.ArgumentParser):
    """argparse's parser, which answers wrong words in one line like every other error here."""

    def error(self, message):
        self.exit(2, f"refimpl: error: {message}; see `{self.prog} --help`\n")


def parser():
    """The whole command line as an argparse parser."""
    top = Parser(
        prog="refimpl", description="Motion style transfer in NumPy with hand-written gradients.",
        epilog="Every step leaves one file, so that each can be looked at and repeated. `refimpl COMMAND --help` tells more.")
    commands = top.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for group in GROUPS:
        group.add_commands(commands)
    return top


def main(argv=None):
    """Run one command.   argv : list of words, the process's own unless given   ->  exit status

    0 done; 1 a check failed; 2 bad input or a file that cannot be read or written (one line says what, where and what to do); 130 stopped
    with Ctrl-C. With REFIMPL_TRACEBACK set in the environment an error shows where it came from.
    """
    arguments = parser().parse_args(argv)
    try:
        return arguments.run(arguments) or 0
    except (ValueError, OSError) as error:
        if os.environ.get("REFIMPL_TRACEBACK"):
            raise
        print(f"refimpl: error: {_one_line(error)}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("refimpl: stopped; nothing is half written, and a training goes on from its last epoch with --resume", file=sys.stderr)
        return 130


def _one_line(error):
    if isinstance(error, OSError) and error.strerror and error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    return " ".join(str(error).split()) or type(error).__name__
