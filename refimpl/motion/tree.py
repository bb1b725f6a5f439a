"""What the tree of a skeleton and the way it moves say of its joints, whatever they are called.

A body has five long branches: two legs, two arms, a head. The legs leave from the hips, arms and
head from the chest. Along a leg or an arm the two longest bones are thigh and shin, upper arm and
forearm; a joint that never bends (a twist joint) makes no bone of its own. Left is left by where
toes point, knees bend, and the body goes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from .joints import SLOT

LONGEST_TWIG = 0.6               # of the shortest limb: what hangs on a body besides its limbs
UNLIKE = 1.5                     # how much longer one limb of a pair may be than the other
SHORT = 0.02                     # of the body: a bone that is none
NEVER_BENT = np.radians(4.0)       # a joint that never bends further is no knee
USUAL = 0.92                     # of the upper bone: how long the lower one is
SURE = 0.25                      # of 1: how well toes, knees and way must agree on the left side


@dataclass(frozen=True)
class Tree:
    """A skeleton in motion, without names.

    parents : of each joint, -1 for the root;  positions : (T, J, 3) in the world, some frames
    ends : {joint: (T, 3)} of the End Sites that lie away from their joint
    """

    parents: Sequence[int]
    positions: np.ndarray = field(repr=False)
    ends: dict[int, np.ndarray] = field(repr=False)

    def above(self, j: int) -> list[int]:
        """A joint and all above it, up to the root."""
        found = []
        while j >= 0:
            found.append(int(j))
            j = self.parents[j]
        return found

    def way(self, top: int, j: int) -> list[int]:
        """The joints from below `top` down to j."""
        above = self.above(j)
        return above[:above.index(top)][::-1]

    def meet(self, joints: Sequence[int]) -> int:
        """The lowest joint that is above all of these, or one of them; -1 where there is none."""
        common = [k for k in self.above(joints[0]) if all(k in self.above(j) for j in joints[1:])]
        return common[0] if common else -1

    def apart(self, a: int, b: int) -> float:
        """The median distance of two joints."""
        return float(np.median(np.linalg.norm(self.positions[:, a] - self.positions[:, b],
                                              axis=-1)))

    def bone(self, j: int) -> float:
        """The length of the bone that ends in a joint."""
        return self.apart(self.parents[j], j) if self.parents[j] >= 0 else 0.0


class Unclear(ValueError):
    """Why the tree does not tell which joint is which."""


def long_branches(tree: Tree) -> list[int]:
    """The five joints at the ends of the five long branches.   Raises Unclear for another number.
    """
    J = len(tree.parents)
    children: list[list[int]] = [[] for _ in range(J)]
    for j, parent in enumerate(tree.parents):
        if parent >= 0:
            children[parent].append(j)
    down = np.zeros(J)                               # the longest way down from each joint
    for j in reversed(range(J)):
        own = [np.median(np.linalg.norm(tree.ends[j] - tree.positions[:, j], axis=-1))
               ] if j in tree.ends else []
        down[j] = max([tree.bone(c) + down[c] for c in children[j]] + own, default=0.0)
    branches, begins = [], [j for j, parent in enumerate(tree.parents) if parent < 0]
    while begins:
        top = begins.pop()
        length, j = down[top] + (tree.bone(top) if tree.parents[top] >= 0 else np.inf), top
        while children[j]:
            longest, *others = sorted(children[j], key=lambda c: -tree.bone(c) - down[c])
            begins += others
            j = longest
        branches.append((float(length), j))
    branches.sort(reverse=True)
    if not max(map(tree.bone, range(J))) > 0:
        raise Unclear("found bones of length 0; position channels replace the OFFSET: if they hold "
                      "differences from it, say --positions add")
    if len(branches) < 5:
        raise Unclear(f"found {len(branches)} branches, needed legs, arms and a head")
    if len(branches) > 5 and branches[5][0] > LONGEST_TWIG * branches[4][0]:
        raise Unclear(f"found a branch to joint {branches[5][1]} about as long as a limb, needed "
                      "two legs, two arms and a head that stand out")
    return [j for _, j in branches[:5]]


def limbs(tree: Tree) -> tuple[int, int, list[int], list[int], int]:
    """Hips, where the arms branch, the ends of the legs, of the arms, of the head.

    Raises Unclear.
    """
    ends = long_branches(tree)
    crotch = tree.meet(ends)

    def _groups(top, some):
        found: dict[int, list[int]] = {}
        for j in some:
            found.setdefault(tree.way(top, j)[0] if j != top else top, []).append(j)
        return sorted(found.values(), key=len)
    parts = _groups(crotch, ends) if crotch >= 0 else []
    if [len(part) for part in parts] != [1, 1, 3]:
        raise Unclear("found no joint from which two legs and a trunk with two arms and a head "
                      "leave")
    legs, upper = [parts[0][0], parts[1][0]], parts[2]
    branch = tree.meet(upper)
    length = {j: sum(map(tree.bone, tree.way(crotch if j in legs else branch, j))) for j in ends}
    pairs = [(a, b) for n, a in enumerate(upper) for b in upper[n + 1:]]

    def _unlike(pair):
        counts = [len(tree.way(crotch if j in legs else branch, j)) for j in pair]
        return (max(length[j] for j in pair) / max(min(length[j] for j in pair), 1e-9)
                + 0.1 * abs(counts[0] - counts[1]))
    pairs.sort(key=_unlike)
    arms = list(pairs[0])
    head = next(j for j in upper if j not in arms)
    for pair, what in ((legs, "legs"), (arms, "arms")):
        if _unlike(pair) > UNLIKE:
            raise Unclear(f"found {what} that are not alike")
    if _unlike(pairs[1]) < _unlike(pairs[0]) + 0.05:
        raise Unclear("found no two of three branches that are arms rather than a head")
    return _hips(tree, crotch, legs), branch, legs, arms, head


def _hips(tree, crotch, legs):
    """The joint amid the tops of the legs, of the crotch and those above it."""
    tops = [tree.way(crotch, j)[0] for j in legs]
    middle = tree.positions[:, tops].mean(axis=1)
    size = sum(tree.apart(crotch, j) for j in legs) / 2

    def _off(j):
        off = np.linalg.norm(tree.positions[:, j] - middle, axis=-1)
        return float(np.median(off)) / max(size, 1e-300)
    above = tree.above(crotch)[:3]
    return min(above, key=lambda j: round(_off(j) / (2 * SHORT)))


def two_bones(tree: Tree, top: int, end: int) -> tuple[int, int, int]:
    """The three joints of the two longest bones on the way down from `top`: hip, knee and ankle, or
    shoulder, elbow and wrist.   Raises Unclear.
    """
    way = tree.way(top, end)
    total = sum(map(tree.bone, way))
    places = [[j] for j in way[:1]]                  # joints in one place count as one
    for j in way[1:]:
        if tree.bone(j) > 1e-3 * total:
            places.append([j])
        else:
            places[-1].append(j)
    P = tree.positions[:, [place[0] for place in places]]
    bones = np.diff(P, axis=1)
    lengths = np.median(np.linalg.norm(bones, axis=-1), axis=0)
    cross = np.linalg.norm(np.cross(bones[:, :-1], bones[:, 1:]), axis=-1)
    bends = np.quantile(np.arctan2(cross, np.sum(bones[:, :-1] * bones[:, 1:], axis=-1)), 0.95,
                        axis=0) > NEVER_BENT           # whether places 1, 2, ... ever bend
    found = []
    for i in range(len(places)):
        for m in range(i + 1, len(places)):
            for k in range(m + 1, len(places)):
                upper, lower = lengths[i:m].sum(), lengths[m:k].sum()
                if not bends[i:m - 1].any() and not bends[m:k - 1].any() and (
                        min(upper, lower) > 0.45 * max(upper, lower)):
                    found.append((upper + lower, abs(np.log(lower / upper / USUAL)), i, m, k))
    if not found:
        raise Unclear("found a limb without two long bones")
    knee = max(found)[3]
    _, _, i, m, k = min((f for f in found if f[3] == knee), key=lambda f: f[1])
    return places[i][-1], places[m][0], places[k][0]


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
        share = np.sum((P[:, knee] - P[:, hip]) * line, axis=-1) / np.sum(line * line, axis=-1)
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


def toe_of(tree: Tree, ankle: int, end: int, size: float) -> int:
    """The first joint beyond the ankle on the way to the end of a leg, -1 where there is none."""
    way = tree.way(ankle, end)
    return next((j for j in way if tree.apart(ankle, j) > SHORT * size), -1)


def finger_of(tree: Tree, elbow: int, wrist: int, size: float) -> int:
    """The joint beyond the wrist that lies straightest on from the forearm, -1 where there is none.
    """
    along = tree.positions[:, wrist] - tree.positions[:, elbow]
    best, found = 0.0, -1
    for j in range(len(tree.parents)):
        above = tree.above(j)
        if wrist not in above[1:] or tree.apart(wrist, j) <= SHORT * size:
            continue
        if any(tree.apart(wrist, k) > SHORT * size for k in above[1:above.index(wrist)]):
            continue
        there = tree.positions[:, j] - tree.positions[:, wrist]
        cosine = np.mean(np.sum(there * along, axis=-1) / (
            np.linalg.norm(there, axis=-1) * np.linalg.norm(along, axis=-1) + 1e-12))
        if cosine > best + 0.002:
            best, found = float(cosine), j
    return found


def trunk(tree: Tree, hips: int, branch: int, head_end: int, shoulders: Sequence[int],
          up: np.ndarray, at_neck: bool | None = None) -> dict[str, int]:
    """Spine, Chest, Neck and Head where the tree has them.

    branch : where arms and head branch;  shoulders : the two upper arms;  at_neck : whether that is
    a neck which carries the collar bones, as where it lies above the shoulders, where not given
    """
    size = tree.apart(hips, branch)
    way = tree.way(branch, head_end)
    heights = tree.positions @ up
    chest = branch
    above = [j for j in way if tree.apart(branch, j) > 2 * SHORT * size]
    if at_neck is None:
        at_neck = len(above) < 2 and np.median(
            heights[:, branch] - heights[:, list(shoulders)].mean(axis=1)) > 0.02 * size
    at_neck = at_neck and tree.parents[branch] not in (-1, hips)
    if at_neck:
        above, chest = [branch, *above], tree.parents[branch]
    found = {"Hips": hips, "Chest": chest}
    spine = [j for j in tree.way(hips, chest)[:-1] if tree.apart(hips, j) > 2 * SHORT * size
             and tree.apart(j, chest) > 2 * SHORT * size]
    if spine:
        found["Spine"] = spine[0]
    if len(above) > 1:
        last = above[-1]
        if len(above) > 2 and last not in tree.ends and tree.bone(last) > 1.3 * tree.bone(
                above[-2]):
            above = above[:-1]                       # the top of the head
        found["Neck"] = above[0]
    if above:
        found["Head"] = above[-1]
    return found


def read_tree(tree: Tree) -> dict[str, int]:
    """Which joint feeds which slot by the tree alone; what it lacks is left out.

    ->  {slot: joint}.   Raises Unclear.
    """
    hips, branch, legs, arms, head = limbs(tree)
    crotch = tree.meet(legs)
    lower = [two_bones(tree, crotch, j) for j in legs]
    upper = [two_bones(tree, branch, j) for j in arms]
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
    assert set(found) <= set(SLOT)
    return found
