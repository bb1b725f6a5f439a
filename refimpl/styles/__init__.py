"""Trained styles.

- `box`: the small ones that come with the package.   `make`: how they were made, and how one is
  made of somebody's clips.
- `files`: styles and manifolds as they stand in files.
"""

from ..lazy import opened

__getattr__, __dir__ = opened(__name__)
