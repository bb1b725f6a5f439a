"""Motion style transfer in NumPy, with hand-written gradients: a text to read and an oracle to
check against.

The rooms, from the ground floor up; imports only point downwards:

- `refimpl.nn`: what is a gradient? Each operation a pure function `f(x, ...)` with its
  `f_backward(dy, x, ...)` right below it, and Adam. Knows nothing of motion. Begin with `nn.gram`.
- `refimpl.gradcheck`: is a gradient right? The instruments that check it.
- `refimpl.motion`: what is a motion? BVH files, rotations, the 21 joints, the 66 numbers a frame
  and back, contacts, windows. Begin with `motion.features`.
  `refimpl.embedded`: motion made by formulas.
- `refimpl.holden2017`: Holden, Habibie, Kusajima, Komura 2017, "Fast Neural Style Transfer for
  Motion Data". `networks` are its figure 1, `losses` its equations 4 to 9, `objective` equation 10,
  `train` and `transfer` the rest.
- `refimpl.holden2016`: its predecessor, as the authors' code is. Begin with `search`.
- `refimpl.torresani2006`: Torresani, Hackney, Bregler 2006, "Learning Motion Style Synthesis from
  Perceptual Observations". Begin with `align`.
- `refimpl.conformance`: what does agreement mean? The kit that checks another implementation, and
  this one. Begin with `cases`.
- `refimpl.experiments`: what was measured, and how fast.
  `refimpl.pictures`: plots and animations.
- `refimpl.styles`: small styles in the box, and how they were made.
- `refimpl.exercise`: what a notebook's check cell calls.
  `refimpl.commands` and `refimpl.cli`: the command line, one file a step.

The front door, a clip in another style (`refimpl.front`):

    import refimpl

    walk = refimpl.read("walk.bvh")                    # a clip (also .npy points)
    old = refimpl.style("old")                         # one in the box, or a file
    result = old.transform(walk, strength=1.0)         # on the clip's own skeleton, at its own rate
    result.save("old_walk.bvh")                        # result.show() in a notebook

Nothing is loaded before it is asked for: `refimpl.motion.features.encode` works after `import
refimpl`.
"""

from typing import TYPE_CHECKING

from .lazy import opened

if TYPE_CHECKING:
    from .front import fit, read, style

__version__ = "0.1.0"
__all__ = ["fit", "read", "style"]

__getattr__, __dir__ = opened(__name__, __all__)
