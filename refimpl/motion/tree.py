"""What the tree of a skeleton and the way it moves say of its joints, whatever they are called.

A body has five long branches: two legs, two arms, a head. The legs leave from the hips, arms and
head from the chest. Along a leg or an arm the two longest bones are thigh and shin, upper arm and
forearm; a joint that never bends (a twist joint) makes no bone of its own. Left is left by where
toes point, knees bend, and the body goes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

LONGEST_TWIG = 0.6               # of the shortest limb: what hangs on a body besides its limbs
UNLIKE = 1.5                     # how much longer one limb of a pair may be than the other
SHORT = 0.02                     # of the body: a bone that is none
NEVER_BENT = np.radians(4.0)       # a joint that never bends further is no knee
USUAL = 0.92                     # of the upper bone: how long the lower one is
RIGID = 0.01                     # of its mean: how little the distance of two shoulders varies


@dataclass(frozen=True)
class Tree:
    """A skeleton in motion, without names.

    parents : of each joint, -1 for the root;  positions : (T, J, 3) in the world, some frames
    ends : {joint: (T, 3)} of the End Sites that lie away from their joint
    still : joints that never turn against their parent
    """

    parents: Sequence[int]
    positions: np.ndarray = field(repr=False)
    ends: dict[int, np.ndarray] = field(repr=False)
    still: frozenset[int] = frozenset()

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
    twists = {j for some in children for j in some if not children[j]
              and any(k != j and children[k] and _lies_on(tree, j, k) for k in some)}
    children = [[j for j in some if j not in twists] for some in children]
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


def _lies_on(tree, j, other):
    """Whether a joint lies on the bone to another child of its parent, as twist joints do."""
    start, P = tree.positions[:, tree.parents[j]], tree.positions
    bone, there = P[:, other] - start, P[:, j] - start
    length2 = np.sum(bone * bone, axis=-1)
    share = np.sum(bone * there, axis=-1) / np.where(length2 > 0, length2, 1.0)
    off = np.linalg.norm(there - share[:, None] * bone, axis=-1)
    return bool(np.median(share) < 1.0 and np.median(off) < 0.05 * np.median(np.sqrt(length2)))


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
    if [len(part) for part in parts] == [2, 3]:      # the upper body beside the lower one
        crotch = tree.meet(parts[0])
        parts = [*([j] for j in parts[0]), parts[1]]
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


def two_bones(tree: Tree, top: int, end: int, other: int) -> tuple[int, int, int]:
    """The three joints of the two longest bones on the way down from `top`: hip, knee and ankle, or
    shoulder, elbow and wrist.

    other : the end of the other limb of the pair, against which knees and elbows move, while
    shoulders do not   Raises Unclear.
    """
    way, across = tree.way(top, end), tree.way(top, other)
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
                    too_long = max(0.0, lengths[k:].sum() - lower)   # what is left of the limb
                    found.append((upper + lower - too_long, abs(np.log(lower / upper / USUAL)),
                                  i, m, k))
    if not found:
        raise Unclear("found a limb without two long bones")
    if len(way) == len(across):
        apart = [np.linalg.norm(P[:, n] - tree.positions[:, across[way.index(place[0])]], axis=-1)
                 for n, place in enumerate(places)]
        moving = [f for f in found if np.std(apart[f[3]]) > RIGID * np.mean(apart[f[3]])]
        found = moving or found
    knee = max(found)[3]
    _, _, i, m, k = min((f for f in found if f[3] == knee), key=lambda f: f[1])
    return places[i][-1], places[m][0], places[k][0]


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
    size, top = tree.apart(hips, branch), tree.meet([hips, branch])
    way = tree.way(branch, head_end)
    heights = tree.positions @ up
    chest, children = branch, list(tree.parents)
    ends = [n for n, j in enumerate(way) if n > 0 and children.count(j) > 1]     # eyes, hair
    way = way[:ends[0] + 1] if ends else way
    above = [j for j in way if tree.apart(branch, j) > 2 * SHORT * size]
    if at_neck is None:
        at_neck = len(above) < 2 and np.median(
            heights[:, branch] - heights[:, list(shoulders)].mean(axis=1)) > 0.02 * size
    at_neck = at_neck and tree.parents[branch] not in (-1, hips)
    if at_neck:
        above, chest = [branch, *above], tree.parents[branch]
    found = {"Hips": hips, "Chest": chest}
    spine = [j for j in tree.way(top, chest)[:-1] if tree.apart(hips, j) > 2 * SHORT * size
             and tree.apart(j, chest) > 2 * SHORT * size]
    if spine:
        found["Spine"] = spine[0]
    if len(above) > 1:
        last = above[-1]
        if len(above) > 2 and last in tree.still and tree.bone(last) > 1.3 * tree.bone(above[-2]):
            above = above[:-1]                       # the top of the head
        found["Neck"] = above[0]
    if above:
        found["Head"] = above[-1]
    return found
