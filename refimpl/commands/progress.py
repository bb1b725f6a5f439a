"""How far long work has come."""

from collections.abc import Collection, Iterator
import sys
import time
from typing import Any

from ..gradcheck.report import columns as table
from ..holden2017.train import Record

__all__ = ["Progress", "duration", "epoch_line", "table"]


class Progress:
    """Shows on the terminal of the standard error how many steps are done and how long the rest
    will take; where that is no terminal it is silent. What is printed next takes the line's place.

    total : number of steps;  name : of a step
    """

    def __init__(self, total: float, name: str) -> None:
        self.total, self.name, self.done, self.began = total, name, 0.0, time.monotonic()
        self.shown = self.began
        self._show("")

    def step(self, text: str = "", share: float = 1.0) -> None:
        """Count a step as done; say what was done.   share : how many steps it counts for"""
        self.done += share
        if time.monotonic() - self.shown >= 0.1 or self.done == share:
            left = (time.monotonic() - self.began) * max(0.0, self.total / self.done - 1)
            self._show(f", {duration(left)} left  {text}")

    @classmethod
    def over(cls, items: Collection[Any], name: str) -> Iterator[Any]:
        """The items one after the other, each a step."""
        progress = cls(len(items), name)
        for item in items:
            yield item
            progress.step(item if isinstance(item, str) else "")

    def _show(self, text):
        self.shown = time.monotonic()
        show = getattr(sys.stderr, "show", None)                 # a `Terminal` while a command runs
        if show is not None:
            show(f"{self.name} {self.done:g}/{self.total:g}{text}")


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
