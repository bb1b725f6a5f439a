"""`python -m refimpl` is `refimpl`. Ctrl-C while libraries are imported ends it without a word."""

import os
import signal
import sys


def run() -> int:
    """Import what the program needs, then do what the command line says.   ->  exit status"""
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
    if status in (130, 143):                                     # stopped: do not wait for workers
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)
    return status


if __name__ == "__main__":
    sys.exit(run())
