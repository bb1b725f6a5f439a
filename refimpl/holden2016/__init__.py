"""Holden, Saito and Komura 2016 as their published code is: style by optimisation, the second
system of Table 1 of Holden et al. 2017.

What the code computes beyond both papers is put beside them in `docs/code_of_2016.md`. The
modules `rows`, `network`, `losses`, `train` and `search` name the files of that code they stand for
and are held to its numbers; `files`, `bridge` and `own` are this package's.

- `rows`: the 73 numbers of a frame, windows, the normaliser.   `network`: the convolutional
  autoencoder with its two dropouts and its depooling by chance, and what it costs.
- `losses`: feet, floor, bones, path, and the search's content and style, as means.
- `train`: its trainer.   `search`: the style transfer, from noise to the replaced last rows.
- `files`: reads the authors' `network_core.npz` and `preprocess_core.npz`, and writes such files.
- `bridge`: from the 66 numbers of 2017 to these 73 and back; that network as a loss network of
  2017.
- `own`: this package's own form of the same search, on the 66 numbers, with the style's Gram matrix
  scaled to the content's frames.
"""

from ..lazy import opened

__getattr__, __dir__ = opened(__name__)
