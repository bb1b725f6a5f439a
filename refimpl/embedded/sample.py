"""A motion to look at: a real clip where REFIMPL_MOCAP names a folder of them, an embedded one
otherwise.
"""

import os

from ..motion.body import Take, make_take, read_take
from ..motion.dataset import find_clips, labels_by_pattern
from .walkers import make_clip

BANDAI = "Bandai-Namco-Research-Motiondataset, CC BY-NC 4.0: non-commercial"
# What the embedded motion calls a content or a style, and what recorded clips call it.
CONTENT_NAMES = {"jog": ("run",), "turn-left": ("walk-turn-left",),
                 "turn-right": ("walk-turn-right",)}
STYLE_NAMES = {"old": ("elderly", "old"), "depressed": ("sad", "exhausted"), "injured": ("tired",),
               "childlike": ("childish", "youthful"), "proud": ("proud", "masculine")}


def sample_take(content: str = "walk", style: str = "normal",
                seconds: float = 4.0) -> tuple[Take, str]:
    """A take of at least so many seconds, and whose motion it is, to be said beside each picture of
    it.

    content, style : names in `walkers.CONTENTS` and `walkers.STYLES`; recorded clips are found by
        what they are called there. The first that is long enough is taken; where there is none, the
        embedded motion.
    ->  Take, credit
    Raises ValueError for unknown names, FileNotFoundError where REFIMPL_MOCAP names no folder of
    clips.
    """
    made = make_clip(content, style, seconds=seconds)
    folder = os.environ.get("REFIMPL_MOCAP")
    if folder:
        wanted = {(c, s) for c in (content, *CONTENT_NAMES.get(content, ()))
                  for s in (style, *STYLE_NAMES.get(style, ()))}
        labels = labels_by_pattern(find_clips(folder))
        for path in sorted((path for path in labels if labels[path] in wanted),
                           key=lambda path: path.name, reverse=True):
            take = read_take(path)
            if len(take.features) >= 60 * seconds:
                bandai = path.name.startswith("dataset-")
                return take, f"{path.stem}, {BANDAI}" if bandai else path.stem
    return make_take(made.clip), f"{made.name}, made by refimpl"
