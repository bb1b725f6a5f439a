"""Lines that tell how far long work has come."""

import sys
import time

from ..gradcheck.report import columns as table
from ..holden2017.train import Record

__all__ = ["Progress", "duration", "epoch_line", "table"]


class Progress:
    """Prints a line a step with the time left to the standard error.

    total : number of steps
    name : of a step
    seconds : between two lines at least; the last one always comes
    """

    def __init__(self, total: int, name: str, seconds: float = 1.0) -> None:
        self.total, self.name, self.seconds = total, name, seconds
        self.done, self.began, self.shown = 0, time.monotonic(), 0.0

    def step(self, text: str) -> None:
        """Count a step as done and print its line, with `text`, if it is time for one."""
        self.done += 1
        now = time.monotonic()
        if now - self.shown < self.seconds and self.done < self.total:
            return
        self.shown = now
        left = (now - self.began) / self.done * (self.total - self.done)
        print(f"{self.name} {self.done}/{self.total}  {text}  {duration(left)} left",
              file=sys.stderr, flush=True)


def duration(seconds: float) -> str:
    """Seconds in words.

    >>> duration(5), duration(130), duration(3900)
    ('5 s', '2 min 10 s', '1 h 05 min')
    """
    seconds = round(seconds)
    if seconds < 60:
        return f"{seconds} s"
    if seconds < 3600:
        return f"{seconds // 60} min {seconds % 60:02d} s"
    return f"{seconds // 3600} h {seconds % 3600 // 60:02d} min"


def epoch_line(record: Record) -> str:
    """The losses, the gradient's norm and the seconds of an epoch in one line."""
    terms = "  ".join(f"{name} {value:.4g}" for name, value in record.losses.items())
    return f"{terms}  |gradient| {record.gradient_norm:.3g}  {record.seconds:.1f} s"
