"""What is a motion?

- `clip`: what a clip is.   `bvh`: files, exact or refused.   `hierarchy`: their tree of joints.
- `rotation`: free functions on [..., 3, 3].   `skeleton`: poses, forward kinematics, frame rates.
  `easing`: curves that begin and end gently.
- `joints`: the 21 joints and which joint of a file feeds each.
  `features`: the 66 numbers a frame, and back.
- `body`: one clip made ready, and moved points back to rotations of the clip's own skeleton.
  `stylised`: a result on that skeleton, and how far to trust it.
- `feet`: which are planted, and how well they stand.   `foot_ik`: the clean-up that locks them.
- `windows`: stretches of equal length and the normaliser.
  `dataset`: a folder of clips as one file.
"""

from ..lazy import opened

__getattr__, __dir__ = opened(__name__)
