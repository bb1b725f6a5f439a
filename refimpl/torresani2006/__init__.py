"""Torresani, Hackney, Bregler 2006: Learning Motion Style Synthesis from Perceptual Observations.

- `poses`: clips as exponential maps, the root apart.
  `align`: content match (equations 3 to 5) and space-time interpolation.
- `observe`: styles (flow, weight, time) from an analyst's label file, or from the computed
  observer.
- `pca`: principal components.   `regress`: the four models of style (equations 6 and 7).
  `svr`: the support vector machine, solved by hand.
- `segment`: Ney's one-stage programme (equations 8 to 11).
  `synthesise`: equation 12 and the joining of the pieces.
- `database`: a folder of clips made ready.
"""

from ..lazy import opened

__getattr__, __dir__ = opened(__name__)
