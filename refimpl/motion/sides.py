"""Which way is up, and which side is left, of a skeleton whose names do not count; with that the
whole reading of a tree.
"""

from collections.abc import Sequence

import numpy as np

from .tree import Tree, Unclear, finger_of, limbs, toe_of, trunk, two_bones

SURE = 0.25                      # of 1: how well toes and knees must agree on the left side


def upward(tree: Tree, head: int, feet: Sequence[int]) -> np.ndarray:
    """The world's axis along which the head is farthest above the feet.   ->  (3,)"""
    rise = np.mean(tree.positions[:, head] - tree.positions[:, list(feet)].mean(axis=1), axis=0)
    axis = 2 if abs(rise[2]) > abs(rise[1]) else 1
    return np.sign(rise[axis] or 1.0) * np.eye(3)[axis]


def leftness(tree: Tree, legs: Sequence[Sequence[int]], toes: Sequence[np.ndarray | None],
             up: np.ndarray) -> float:
    """How sure it is that the first leg is the left one, from 1 to -1.

    legs : hip, knee, ankle of two;  toes : (T, 3) of each, or None
    """
    P = tree.positions
    across = P[:, legs[0][0]] - P[:, legs[1][0]]
    told = []
    if all(toe is not None for toe in toes):
        told.append(2 * sum(toe - P[:, leg[2]] for toe, leg in zip(toes, legs)))
    for hip, knee, ankle in legs:
        line = P[:, ankle] - P[:, hip]
        share = (np.sum((P[:, knee] - P[:, hip]) * line, axis=-1)
                 / np.maximum(np.sum(line * line, axis=-1), 1e-300))
        told.append(P[:, knee] - P[:, hip] - share[:, None] * line)
    forward = sum(told)
    left = np.cross(up, forward)
    size = np.linalg.norm(left, axis=-1) * np.linalg.norm(across - np.outer(across @ up, up),
                                                          axis=-1)
    weight = np.linalg.norm(left, axis=-1)
    good = size > 0
    if not good.any() or weight.max() <= 0:
        return 0.0
    cosine = np.sum(left * across, axis=-1)[good] / size[good]
    return float(np.average(cosine, weights=weight[good]))


def read_tree(tree: Tree) -> dict[str, int]:
    """Which joint feeds which slot by the tree alone; what it lacks is left out.

    ->  {slot: joint}.   Raises Unclear.
    """
    hips, branch, legs, arms, head = limbs(tree)
    crotch = tree.meet(legs)
    lower = [two_bones(tree, crotch, *pair) for pair in (legs, legs[::-1])]
    upper = [two_bones(tree, branch, *pair) for pair in (arms, arms[::-1])]
    size = sum(tree.apart(a, b) + tree.apart(b, c) for a, b, c in lower) / 2
    toes = [toe_of(tree, bones[2], j, size) for bones, j in zip(lower, legs)]
    up = upward(tree, branch, [bones[2] for bones in lower])
    points = [tree.positions[:, toe] if toe >= 0 else tree.ends.get(bones[2])
              for toe, bones in zip(toes, lower)]
    sure = leftness(tree, lower, points, up)
    if abs(sure) < SURE:
        raise Unclear("found nothing that tells left from right (toes, bent knees)")
    across = tree.positions[:, lower[0][0]] - tree.positions[:, lower[1][0]]
    same = np.mean(np.sum(across * (tree.positions[:, upper[0][0]]
                                    - tree.positions[:, upper[1][0]]), axis=-1))
    found = trunk(tree, hips, branch, head, [bones[0] for bones in upper], up)
    for parts, bones, tips, first_left in (
            (("UpLeg", "Leg", "Foot", "Toe"), lower, toes, sure > 0),
            (("Arm", "ForeArm", "Hand", "Finger"), upper,
             [finger_of(tree, b[1], b[2], size) for b in upper], (sure > 0) == (same > 0))):
        for n, (joints, tip) in enumerate(zip(bones, tips)):
            side = "Left" if (n == 0) == first_left else "Right"
            found |= {side + part: j for part, j in zip(parts, (*joints, tip)) if j >= 0}
    return found
