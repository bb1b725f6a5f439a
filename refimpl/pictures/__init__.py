"""Pictures and players; nothing but `plot` imports Matplotlib.

- `plot`: strips of poses, root paths, curves.   `player`: a page in which figures move; `staging`:
  who stands where, in which colour.
"""

from ..lazy import opened

__getattr__, __dir__ = opened(__name__)
