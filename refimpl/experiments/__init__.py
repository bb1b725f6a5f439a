"""What was measured: each table and figure of README and docs from one command.

- `holden`: the recipe of training.   `evaluate`: both systems beside real motion, Table 1.
- `code_2016`: the 2016 code with one statement changed.   `torresani`: section 8 of the 2006 paper.
- `classifiers`, `measures`: who says what a motion looks like, and how far it is from a style.
- `speed`: how fast, compared with what.
  `peer_torch`, `peer_onnx`: the same in PyTorch and ONNX Runtime, imported by `bench` alone.
"""

from ..lazy import opened

__getattr__, __dir__ = opened(__name__)
