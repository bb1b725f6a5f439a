"""A part of a result, in seconds. The whole clip was stylised for it: floor, contacts and what the
networks saw around the part are the clip's own.
"""

from dataclasses import replace
import math

from .body import Take
from .features import FPS
from .stylised import Stylised


def frames_of(take: Take, begin: float = 0.0, end: float | None = None) -> slice:
    """The frames of a take from one time of its file until another, the latter not among them.

    begin, end : seconds from the file's first row; to the last row unless given
    ->  slice of the take's frames, 60 a second.   Raises ValueError where there is no motion.
    """
    clip, strays = take.clip, take.strays
    seconds = clip.frames / clip.fps
    end = seconds if end is None else end
    if not 0 <= begin < end <= seconds + 1 / clip.fps:
        raise ValueError(f"part: found {begin:g} to {end:g} seconds, needed a part of the clip, "
                         f"which lasts from 0 to {seconds:g}")
    rows = [min(max(_row(t, clip.fps), strays.begin), strays.end) for t in (begin, end)]
    a, b = (min(_row((row - strays.begin) / clip.fps, FPS), len(take.positions)) for row in rows)
    if a >= b:
        raise ValueError(f"part: found no motion between {begin:g} and {end:g} seconds, needed "
                         f"some of rows {strays.begin + 1} to {strays.end} ({clip.fps:g} a second)")
    return slice(a, b)


def part_of(take: Take, result: Stylised, begin: float = 0.0,
            end: float | None = None) -> Stylised:
    """That part of a take's result. Parts that meet make the whole."""
    frames, fps = frames_of(take, begin, end), result.clip.fps
    first, last = _row(begin, fps), None if end is None else _row(end, fps)
    return replace(result, clip=replace(result.clip, values=result.clip.values[first:last]),
                   positions=result.positions[frames], made=result.made[frames])


def _row(seconds, fps):
    """The first row at that time or after it."""
    return math.ceil(seconds * fps - 1e-6)
