"""Pictures and animations; nothing else imports Matplotlib.

- `plot`: strips of poses, root paths, curves.   `player`: an animation for a browser.
"""

from ..lazy import opened

__getattr__, __dir__ = opened(__name__)
