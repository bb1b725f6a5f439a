"""A command whose standard error is a terminal, as it is before a person."""

import fcntl
import os
import pty
import re
import struct
import subprocess
import sys
import termios

import refimpl

HERE = {**os.environ, "PYTHONPATH": os.path.dirname(os.path.dirname(refimpl.__file__))}


class OnTerminal:
    """The process of `refimpl WORDS`, and all that its terminal was sent."""

    def __init__(self, words, columns=80, **options):
        self._ours, its = pty.openpty()
        fcntl.ioctl(its, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        self.process = subprocess.Popen([sys.executable, "-m", "refimpl", *map(str, words)],
                                        stdin=subprocess.DEVNULL, stderr=its, env=HERE,
                                        **{"stdout": subprocess.DEVNULL, **options})
        os.close(its)
        self._sent = b""

    @property
    def text(self):
        return self._sent.decode(errors="replace")

    def until(self, pattern):
        """Wait for a pattern, or for the end.   ->  whether it came"""
        while not re.search(pattern, self.text):
            try:
                data = os.read(self._ours, 1 << 16)
            except OSError:                                      # Linux's end of a terminal
                data = b""
            if not data:
                return False
            self._sent += data
        return True

    def end(self):
        """Wait for the end.   ->  exit status"""
        self.until("(?!)")
        os.close(self._ours)
        return self.process.wait()

    def seen(self):
        """What stands on the terminal's lines in the end, trailing blanks left out."""
        lines = []
        for line in self.text.replace("\r\n", "\n").split("\n"):
            shown = ""
            for part in line.split("\r"):
                shown = part + shown[len(part):]
            lines.append(shown.rstrip())
        return [line for line in lines if line]
