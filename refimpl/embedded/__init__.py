"""Motion made by formulas, for tests, notebooks and whoever has no clips.

- `walkers`: people who walk and jog on a skeleton of their own.   `manner`: in which style.
  `gait`: how legs go.   `course`: where, when and with what else.
- `crowd`: many of them, as varied as strangers' clips are.
- `performers`: people with known Laban efforts, for the 2006 system.
- `sample`: one clip to begin with, the embedded one or a user's own.
"""

from ..lazy import opened

__getattr__, __dir__ = opened(__name__)
