"""`python -m refimpl` is `refimpl`. Ctrl-C while the libraries are read in ends the program without
a word.
"""

import os
import signal
import sys


def run() -> int:
    """The program: read in what it needs, then do what the command line says.   ->  exit status"""
    own = signal.getsignal(signal.SIGINT)
    if own is signal.default_int_handler:                        # not ignored, as under nohup
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        from .cli import main
    except MemoryError:
        print("refimpl: error: not enough memory to read in NumPy and SciPy", file=sys.stderr)
        return 2
    signal.signal(signal.SIGINT, own)
    status = main()
    # told to end: no waiting for what workers left behind
    if status in (130, 143):
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)
    return status


if __name__ == "__main__":
    sys.exit(run())
