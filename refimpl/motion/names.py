"""What the name of a joint says: on which side, and which part of a body.

One list for all families of skeletons. Name spaces, prefixes that all joints share, numbers and
words that say nothing are left out; `Left`, `L_`, `.L`, `_l`, `lThigh` and `lfemur` are all the
left side. A name never says more than its words: `LeftShoulder` is a collar bone on one skeleton
and the upper arm on another, which only its neighbours decide.
"""

from collections.abc import Iterable, Sequence
import re

SIDES = {"l": "Left", "left": "Left", "lft": "Left", "lt": "Left",
         "r": "Right", "right": "Right", "rgt": "Right", "rt": "Right"}
# Which places of a limb, counted from the trunk, a word may mean. A leg: 0 between hips and leg,
# 1 thigh, 2 shin, 3 foot, 4 toe. An arm: 0 collar bone, 1 upper arm, 2 forearm, 3 hand, 4 finger.
PLACES = {
    "Leg": {"hipjoint": (0,), "buttock": (0,), "pelvis": (0,), "hip": (1, 0), "upleg": (1,),
            "upperleg": (1,), "legupper": (1,), "thigh": (1,), "thighbend": (1,), "femur": (1,),
            "leg": (2, 1), "lowleg": (2,), "lowerleg": (2,), "leglower": (2,), "knee": (2,),
            "shin": (2,), "calf": (2,), "tibia": (2,), "ankle": (3,), "foot": (3, 4),
            "toe": (4,), "toes": (4,), "toebase": (4,), "ball": (4,), "forefoot": (4,),
            "metatarsals": (4,)},
    "Arm": {"collar": (0,), "collarbone": (0,), "clavicle": (0,), "clavicula": (0,),
            "scapula": (0,), "shoulder": (1, 0), "shldr": (1, 0), "arm": (1,), "uparm": (1,),
            "uarm": (1,),
            "upperarm": (1,), "armupper": (1,), "shldrbend": (1,), "humerus": (1,),
            "forearm": (2,), "farm": (2,),
            "lowarm": (2,), "lowerarm": (2,), "armlower": (2,), "elbow": (2,),
            "forearmbend": (2,), "radius": (2,), "ulna": (2,), "wrist": (3,), "hand": (3, 4)}}
TRUNK = {"hips": "Hips", "hip": "Hips", "pelvis": "Hips", "spinebase": "Hips", "neck": "Neck",
         "lowerneck": "Neck", "necklower": "Neck", "upperneck": "Neck", "neckupper": "Neck",
         "head": "Head", "skull": "Head",
         **dict.fromkeys(("spine", "chest", "thorax", "torso", "back", "lowerback", "upperback",
                          "abdomen", "upperchest", "waist", "lumbar", "spinelower", "spineupper",
                          "abdomenlower", "abdomenupper", "chestlower", "chestupper", "ribs",
                          "spinemid", "spinenavel", "spinechest", "spineshoulder"), "Spine")}
# The finger that stands for the hand: the first of these that there is.
FINGERS = ("middle", "mid", "index", "ring", "fingers", "finger", "fingerbase", "handtip")
# Words that say nothing, and words of joints that are no part of the 21.
_EMPTY = {"j", "c", "m", "f", "b", "avg", "bip", "bip01", "def", "org", "mch", "jnt", "joint",
          "joints", "bone", "bnd", "skel", "rig", "character", "mixamorig", "cc", "hub"}
_OTHERS = {"twist", "roll", "end", "nub", "top", "tip", "ik", "pole", "target", "ctrl", "helper",
           "muscle", "metacarpal", "carpal", "palm", "in", "thumb", "pinky", "pinkie", "little",
           "heel", "eye", "eyes", "jaw", "site", "prop", "weapon", "corrective", "dummy", "cup"}
KNOWN = set().union(*PLACES.values(), TRUNK, FINGERS)


def words_of(names: Sequence[str]) -> list[tuple[str, str]]:
    """Side and word of each joint, without the prefix that nine of ten names have in common.

    names : of all joints  ->  (side or "", word or "") of each

    >>> words_of(["mixamorig:Hips", "LThighTwist", "upper_arm.L", "rfemur", "L5"])
    [('', 'hips'), ('', ''), ('Left', 'upperarm'), ('Right', 'femur'), ('', 'spine')]
    """
    bare = [re.sub(r"^.*[:|]", "", name.strip()) for name in names]
    prefix = _common_prefix(bare)
    return [_word(name.removeprefix(prefix)) for name in bare]


def _common_prefix(names):
    """What nine of ten names begin with, up to a separator; "" where there is none."""
    found = ""
    for name in {n[:m.end()] for n in names for m in re.finditer(r"[_ .-]", n)}:
        if len(name) > len(found) and sum(n.startswith(name) for n in names) >= 0.9 * len(names):
            found = name
    return found if len(names) > 3 else ""


def _word(name):
    if re.fullmatch(r"[LlTt]\d{1,2}", name):         # vertebrae
        return "", "spine"
    tokens = [t.lower() for t in re.findall(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+", name)]
    tokens = [t for t in tokens if t not in _EMPTY] or tokens
    side = next((SIDES[t] for t in tokens if t in SIDES), "") if len(tokens) > 1 else ""
    tokens = [t for t in tokens if not side or t not in SIDES]
    if not side and tokens:                          # lfemur, leftupleg
        begins, rest = re.findall(r"^(left|right|l|r|)(.*)$", tokens[0])[0]
        whole = "".join([rest, *tokens[1:]])
        if begins and tokens[0] not in KNOWN and KNOWN & {rest, whole}:
            side, tokens = SIDES[begins], [rest, *tokens[1:]]
    if set(tokens) & _OTHERS:
        return "", ""
    for finger in FINGERS:
        if finger in tokens:
            return side, finger
    tails = ("".join(tokens[k:]) for k in range(len(tokens)))
    return side, next((word for word in tails if word in KNOWN), "")


def limb_joints(words: Sequence[tuple[str, str]], depth: Sequence[int],
                limb: str) -> dict[tuple[str, int], int]:
    """The joints of both legs or both arms by their names. A word means the same on both sides.

    words : of `words_of`;  depth : of each joint in the tree;  limb : "Leg" or "Arm"
    ->  {(side, place): joint}, of several of one name the highest

    >>> words = words_of(["LeftShoulder", "LeftElbow", "LeftWrist", "LeftHand"])
    >>> limb_joints(words, [0, 1, 2, 3], "Arm")
    {('Left', 1): 0, ('Left', 2): 1, ('Left', 3): 2, ('Left', 4): 3}
    """
    table = PLACES[limb]
    here = sorted((j for j, (side, word) in enumerate(words) if side and word in table),
                  key=lambda j: depth[j])
    meaning: dict[str, int] = {}
    order = list(dict.fromkeys(words[j][1] for j in here))
    for word in order:                               # first what is clear
        if len(table[word]) == 1:
            meaning[word] = table[word][0]
    for word in 2 * order:                           # then what its neighbours make clear
        free = [place for place in table[word] if place not in meaning.values()]
        if word not in meaning and free and (len(free) < len(table[word]) or {
                free[0] - 1, free[0] + 1} & set(meaning.values())):
            meaning[word] = free[0]
    found: dict[tuple[str, int], int] = {}
    for j in here:
        side, word = words[j]
        if word in meaning:
            found.setdefault((side, meaning[word]), j)
    for side in ("Left", "Right"):
        fingers = _fingers(words, depth, side) if limb == "Arm" else []
        if fingers and (side, 4) not in found:
            found[side, 4] = fingers[len(fingers) // 2]
    return dict(sorted(found.items()))


def _fingers(words, depth, side):
    """The first joints of the best named fingers."""
    for finger in FINGERS:
        here = [j for j, (s, word) in enumerate(words) if s == side and word == finger]
        if here:
            nearest = min(depth[j] for j in here)
            return [j for j in here if depth[j] == nearest]
    return []


def trunk_joints(words: Sequence[tuple[str, str]], part: str) -> list[int]:
    """Joints that are called hips, spine, neck or head, in the order of the file.

    part : "Hips", "Spine", "Neck" or "Head"
    """
    return [j for j, (side, word) in enumerate(words) if not side and TRUNK.get(word) == part]


def depths(parents: Iterable[int]) -> list[int]:
    """How many joints are above each.

    >>> depths([-1, 0, 1, 0])
    [0, 1, 2, 1]
    """
    found: list[int] = []
    for parent in parents:
        found.append(0 if parent < 0 else found[parent] + 1)
    return found
