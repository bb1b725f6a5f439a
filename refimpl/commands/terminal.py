"""What is printed: safe for a terminal, and no failure when nobody reads on."""

from collections.abc import Iterator
import contextlib
import os
import sys
from typing import TextIO
import unicodedata


class Terminal:
    """A stream that writes what a terminal may show.

    Control characters (a joint may be called ESC[2J) and letters that the stream's encoding lacks
    come out as `\\x1b`. When the reader has gone (`refimpl inspect CLIP | head -1`) the rest is
    dropped and the command goes on to its end and its exit status.

    status : the terminal that status lines are shown on, itself unless given
    """

    def __init__(self, stream: TextIO, status: "Terminal | None" = None) -> None:
        self.stream, self.gone, self.status, self.shown = stream, False, status or self, 0

    def write(self, text: str) -> int:
        """Write it in the place of a status line, or drop it when nobody reads."""
        if text and self.watched():
            self.status.show("")
        self._unless_gone(lambda: self.stream.write(self._safe(text)))
        return len(text)

    def watched(self) -> bool:
        """Whether a person looks on."""
        with contextlib.suppress(ValueError):                    # it may be closed
            return self.stream.isatty()
        return False

    def show(self, line: str) -> None:
        """Show a line in the place of the one before, until anything is written; nowhere but where
        a person looks on, and no wider than what that person sees.
        """
        if not self.watched() or not (line or self.shown):
            return
        line, wide = self._safe(line.replace("\n", " ")), 0
        with contextlib.suppress(OSError):
            wide = os.get_terminal_size(self.fileno())[0]
        while _columns(line) >= (wide or 80):
            line = line[:-1]
        blank = " " * (self.shown - _columns(line))
        self.shown = _columns(line)
        self._unless_gone(lambda: self.stream.write(f"\r{line}{blank}" + "\r" * (not line)))
        self.flush()

    def _safe(self, text):
        safe = "".join(c if c in "\n\t\r" or c.isprintable()
                       else c.encode("unicode_escape").decode() for c in text)
        encoding = getattr(self.stream, "encoding", None) or "utf-8"
        return safe.encode(encoding, "backslashreplace").decode(encoding)

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


def _columns(text):
    """How wide a terminal writes it: letters of East Asia take two columns."""
    return sum(1 + (unicodedata.east_asian_width(c) in "WF") for c in text)


@contextlib.contextmanager
def safe_streams() -> Iterator[Terminal]:
    """Standard output and error as `Terminal`s while the block runs; yields the one for output."""
    with open(os.devnull, "w", encoding="utf-8") as nowhere:     # closed streams are None
        err = Terminal(sys.stderr or nowhere)
        out = Terminal(sys.stdout or nowhere, err)
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            yield out
            err.show("")
    if out.gone:                                                 # or Python complains as it ends
        with contextlib.suppress(OSError, ValueError):
            sys.stdout.close()
