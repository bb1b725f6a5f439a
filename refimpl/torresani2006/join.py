"""Motions one after the other (section 7.2; the paper says nothing of the seams)."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import accumulate

import numpy as np

from ..motion import rotation
from ..motion.easing import ease
from .align import turned
from .poses import HEADING, Body, Fragment, exponential_maps, rotation_matrices

SEAM = 0.6                                                   # seconds on either side of a joint


class SynthesisError(ValueError):
    """A style that cannot be asked for, or a content without two fragments."""


def join(parts: Sequence[Fragment], body: Body, seam: float = SEAM) -> Fragment:
    r"""Motions one after the other, with continuous root and pose.

    Each part is set down where the one before ends, facing its way, one step of the mean speed of
    both further. What jump remains in a joint, delta = log(exp(-v)^T A_last^T B_first) with v the
    mean step of both, is shared: half of it fades in before the seam and half fades out after it.
    Height likewise.

    parts : at least one, of one frame rate;  seam : seconds on either side.
    Raises SynthesisError.
    """
    if not parts or len({part.fps for part in parts}) != 1:
        raise SynthesisError(f"parts: found {len(parts)} of {sorted({part.fps for part in parts})} "
                             "frames/s, needed at least one, all of one rate")
    placed = list(accumulate(parts, lambda before, part: _set_down(part, before, body)))
    rotations = [rotation_matrices(part.angles, body.reference) for part in placed]
    roots = [part.root.copy() for part in placed]
    up, width = "xyz".index(body.up), max(1, round(seam * parts[0].fps))
    jumps = []
    for A, B, a, b in zip(rotations, rotations[1:], roots, roots[1:]):
        step = 0.5 * (rotation.log_map(_turn(A[-2], A[-1])) + rotation.log_map(_turn(B[0], B[1])))
        jumps.append((rotation.log_map(_turn(A[-1] @ rotation.exp_map(step), B[0])),
                      b[0, up] - a[-1, up] - 0.5 * (a[-1, up] - a[-2, up] + b[1, up] - b[0, up])))
    for n, (delta, rise) in enumerate(jumps):
        before, after = _fade(len(rotations[n]), width)[::-1], _fade(len(rotations[n + 1]), width)
        rotations[n] = rotations[n] @ rotation.exp_map(0.5 * before[:, None, None] * delta)
        rotations[n + 1] = rotations[n + 1] @ rotation.exp_map(-0.5 * after[:, None, None] * delta)
        roots[n][:, up] += 0.5 * before * rise
        roots[n + 1][:, up] -= 0.5 * after * rise
    angles = exponential_maps(np.concatenate(rotations), body.reference)
    return replace(parts[0], name=" ".join(part.name for part in parts),
                   content=None if len(parts) > 1 else parts[0].content, style=None, angles=angles,
                   root=np.concatenate(roots))


def _turn(A, B):
    return A.swapaxes(-1, -2) @ B


def _fade(frames, width):
    """From 1 at the first frame to 0 after `width` frames, or after half of the frames if these are
    fewer.   ->  (frames,)
    """
    return 1.0 - ease(np.arange(frames) / max(1, min(width, frames // 2)))


def _set_down(part, before, body):
    """A part moved over the floor and turned so that it goes on from the one before, at the mean
    speed of both.   ->  Fragment
    """
    root, end, floor = part.root, before.root, body.floor
    turn = 0.5 * (end[-1, HEADING] - end[-2, HEADING] + root[1, HEADING] - root[0, HEADING])
    root = at_origin(root, end[-1, HEADING] + turn, body)
    step = 0.5 * (end[-1, floor] - end[-2, floor] + root[1, floor] - root[0, floor])
    root[:, floor] = root[:, floor] + end[-1, floor] + step
    return replace(part, root=root)


def at_origin(root: np.ndarray, heading: float, body: Body) -> np.ndarray:
    """A root (T, 4) that begins at the floor's origin with this heading (radians).   ->  (T, 4)"""
    moved, floor, angle = root.copy(), body.floor, heading - root[0, HEADING]
    moved[:, floor] = turned(root[:, floor] - root[0, floor], angle, body.up)
    moved[:, HEADING] += angle
    return moved
