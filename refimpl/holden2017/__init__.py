"""Holden, Habibie, Kusajima, Komura 2017: Fast Neural Style Transfer for Motion Data, in the order
of its equations.

- `networks`: the loss network (equations 1 to 3) and the transformation network.
  `losses`: equations 4 to 9.   `objective`: equation 10, a list of terms.
- `pairing`: windows, each paired with the style it should take.   `train`: both training loops.
  `trained`: what it leaves.
- `transfer`: stylise(I) = P(T(I)) of a whole clip, back on its own skeleton.

Definitions only: each function runs as it stands here. `refimpl.fast` gives the same numbers sooner
and is handed in, as `gradients` to `train` and as `networks` to `pairing` and `transfer`.
"""

from ..lazy import opened

__getattr__, __dir__ = opened(__name__)
