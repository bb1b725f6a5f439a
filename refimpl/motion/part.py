"""A part of a clip, in seconds, which still knows the clip around it."""

from dataclasses import replace
import math

from .body import MARGIN, Take
from .features import FPS, Start, root_motion
from .strays import Strays


def part_of(take: Take, begin: float = 0.0, end: float | None = None) -> Take:
    """The frames of a take from one time of its file until another, the latter not among them.

    Floor, resting heights and contacts stay those of the whole clip, and what networks see beyond
    the part's ends is the clip itself. Two parts that meet make the frames of the whole one.

    begin, end : seconds from the file's first row; to the last row unless given
    ->  Take, whose clip has the part's rows alone.   Raises ValueError where there is no motion.
    """
    clip, strays, every = take.clip, take.strays, FPS / take.clip.fps
    seconds = clip.frames / clip.fps
    end = seconds if end is None else end
    if not 0 <= begin < end <= seconds + 1 / clip.fps:
        raise ValueError(f"part: found {begin:g} to {end:g} seconds, needed a part of the clip, "
                         f"which lasts from 0 to {seconds:g}")
    first, last = (min(math.ceil(t * clip.fps - 1e-6), clip.frames) for t in (begin, end))
    rows = [min(max(row, strays.begin), strays.end) for row in (first, last)]
    a, b = (min(math.ceil((row - strays.begin) * every - 1e-6), len(take.positions))
            for row in rows)
    if a >= b:
        raise ValueError(f"part: found no motion between {begin:g} and {end:g} seconds, needed "
                         f"some of rows {strays.begin + 1} to {strays.end} ({clip.fps:g} a second)")
    root, yaw = root_motion(take.features, take.start)
    frames = slice(a, b)
    return replace(
        take, clip=replace(clip, values=clip.values[first:last]),
        rotations=take.rotations[frames], translations=take.translations[frames],
        positions=take.positions[frames], features=take.features[frames],
        start=Start(float(root[a, 0]), float(root[a, 2]), float(yaw[a]), take.start.floor),
        contacts=take.contacts[frames], around=take.around[a:b + 2 * MARGIN],
        strays=Strays(rows[0] - first, rows[1] - first, strays.lost[first:last]))
