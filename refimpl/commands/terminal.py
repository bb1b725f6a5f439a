"""What is printed: safe for a terminal, and no failure when nobody reads on."""

from collections.abc import Iterator
import contextlib
import os
import sys
from typing import TextIO


class Terminal:
    """A stream that writes what a terminal may show.

    Control characters (a joint may be called ESC[2J) and letters that the stream's encoding lacks
    come out as `\\x1b`. When the reader has gone (`refimpl inspect CLIP | head -1`) the rest is
    dropped and the command goes on to its end and its exit status.
    """

    def __init__(self, stream: TextIO) -> None:
        self.stream, self.gone = stream, False

    def write(self, text: str) -> int:
        """Write it, or drop it when nobody reads."""
        safe = "".join(c if c in "\n\t\r" or c.isprintable()
                       else c.encode("unicode_escape").decode() for c in text)
        encoding = getattr(self.stream, "encoding", None) or "utf-8"
        safe = safe.encode(encoding, "backslashreplace").decode(encoding)
        self._unless_gone(lambda: self.stream.write(safe))
        return len(text)

    def flush(self) -> None:
        """Push out what was written."""
        self._unless_gone(self.stream.flush)

    def _unless_gone(self, act):
        if not self.gone:
            try:
                act()
            except BrokenPipeError:
                self.gone = True

    def __getattr__(self, name):
        return getattr(self.stream, name)


@contextlib.contextmanager
def safe_streams() -> Iterator[Terminal]:
    """Standard output and error as `Terminal`s while the block runs; yields the one for output."""
    with open(os.devnull, "w", encoding="utf-8") as nowhere:     # closed streams are None
        out, err = Terminal(sys.stdout or nowhere), Terminal(sys.stderr or nowhere)
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            yield out
    if out.gone:                                                 # or Python complains as it ends
        with contextlib.suppress(OSError, ValueError):
            sys.stdout.close()
