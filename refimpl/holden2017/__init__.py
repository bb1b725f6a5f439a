"""Holden, Habibie, Kusajima, Komura 2017: Fast Neural Style Transfer for Motion Data.

- `networks`: the loss network (equations 1 to 3) and the transformation network.
  `losses`: equations 4 to 9.   `objective`: equation 10, a list of terms.
- `lesson`: windows, each paired with the style it should take.   `train`: both training loops.
  `model`: what they leave in files.
- `stylist`, `step`, `half`, `parts`: the same networks, losses and gradients, fast: spectra and
  arrays kept, the decoder at half resolution, batches in parts for threads, processes or machines.
  Each is tested to be its definition above.
- `transfer`: stylise(I) = P(T(I)) of a whole clip, back on its own skeleton.
  `known`: does a clip lie within what a style has learnt?
"""
