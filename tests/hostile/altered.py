"""What happens to clips on their way through other people's tools, and what it does to an answer.

Each alteration takes a clip and makes an `Altered` of it, which says by which turn, scale and
shift, under which names and in which frames the answer must come back.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import Rotation

from tests.hostile.strangers import FULL, Clip, height, write


@dataclass(frozen=True)
class Altered:
    """A clip, and what its alteration does to an answer.

    A place p of the base's answer is `scale * turn @ p + shift` in the altered one's, of joint
    `names[joint]`, in frame `frames[1][k]` where it was `frames[0][k]`. `exact` answers agree but
    for rounding; the others within the bound that `whole` justifies. `foreign` clips may be
    refused, or told. `options` are the command's, where it has them.
    """

    clip: Clip
    names: dict[str, str]
    turn: np.ndarray = field(default_factory=lambda: np.eye(3))
    scale: float = 1.0
    shift: np.ndarray = field(default_factory=lambda: np.zeros(3))
    frames: tuple[np.ndarray, np.ndarray] | None = None
    text: Callable[[Clip], str] = write
    exact: bool = True
    said: str = ""
    foreign: bool = False
    options: tuple[str, ...] = ()


SIZE = 150.0  # of a body in both kinds of clips, the same for clips that belong together
Maker = Callable[[Clip, np.random.Generator], Altered]


def same(clip: Clip, **other) -> Altered:
    """`clip` with nothing known to differ but what `other` says."""
    return Altered(clip, **{"names": {name: name for name in clip.names}, **other})


# ----- names -----------------------------------------------------------------------------------

PARTS = "Hips Spine Spine1 Neck1 Head Shoulder Arm ForeArm Hand HandIndex1 UpLeg Leg Foot ToeBase"
OTHERS = {
    "mixamo": "mixamorig:Hips mixamorig:Spine mixamorig:Spine1 mixamorig:Neck mixamorig:Head "
              "mixamorig:{Left}Shoulder mixamorig:{Left}Arm mixamorig:{Left}ForeArm "
              "mixamorig:{Left}Hand mixamorig:{Left}HandIndex1 mixamorig:{Left}UpLeg "
              "mixamorig:{Left}Leg mixamorig:{Left}Foot mixamorig:{Left}ToeBase",
    "blender": "hips spine chest neck head shoulder.{L} upper_arm.{L} forearm.{L} hand.{L} "
               "f_index.01.{L} thigh.{L} shin.{L} foot.{L} toe.{L}",
    "unreal": "pelvis spine_01 spine_02 neck_01 head clavicle_{l} upperarm_{l} lowerarm_{l} "
              "hand_{l} index_01_{l} thigh_{l} calf_{l} foot_{l} ball_{l}",
    "biped": "Bip01_Pelvis Bip01_Spine Bip01_Spine1 Bip01_Neck Bip01_Head Bip01_{L}_Clavicle "
             "Bip01_{L}_UpperArm Bip01_{L}_Forearm Bip01_{L}_Hand Bip01_{L}_Finger0 "
             "Bip01_{L}_Thigh Bip01_{L}_Calf Bip01_{L}_Foot Bip01_{L}_Toe0",
    "smpl": "Pelvis Spine1 Spine2 Neck Head {L}_Collar {L}_Shoulder {L}_Elbow {L}_Wrist {L}_Hand "
            "{L}_Hip {L}_Knee {L}_Ankle {L}_Foot",
    "cmu": "Hips Spine Spine1 Neck1 Head {Left}Shoulder {Left}Arm {Left}ForeArm {Left}Hand "
           "{Left}HandIndex1 {Left}UpLeg {Left}Leg {Left}Foot {Left}ToeBase",
    "lower": "hips spine spine1 neck1 head {left}shoulder {left}arm {left}forearm {left}hand "
             "{left}handindex1 {left}upleg {left}leg {left}foot {left}toebase",
}
BANDAI = dict(zip("Spine Chest Neck Shoulder UpperArm LowerArm UpperLeg LowerLeg Toes".split(),
                  "Spine Spine1 Neck1 Shoulder Arm ForeArm UpLeg Leg ToeBase".split()))


def side_and_part(name: str) -> tuple[str, str]:
    """Side and part of a name of the walkers or of the Bandai clips."""
    if name[-2:] in ("_L", "_R"):
        return {"L": "Left", "R": "Right"}[name[-1]], BANDAI.get(name[:-2], name[:-2])
    for side in ("Left", "Right"):
        if name.startswith(side):
            return side, name[len(side):]
    return "", BANDAI.get(name, name)


def _renamed(clip: Clip, names: dict[str, str], **other) -> Altered:
    named = replace(clip, names=tuple(names[name] for name in clip.names))
    return same(named, names=names, **other)


def renamed(clip: Clip, rng: np.random.Generator) -> Altered:
    """The same joints under the names of another tool."""
    scheme = str(rng.choice(sorted(OTHERS)))
    words = dict(zip(PARTS.split(), OTHERS[scheme].split(" ")))
    names = {}
    for name in clip.names:
        side, part = side_and_part(name)
        names[name] = words.get(part, name).format(
            Left=side, left=side.lower(), L=side[:1], l=side[:1].lower())
    return _renamed(clip, names, said=scheme)


def nonsense(clip: Clip, rng: np.random.Generator) -> Altered:
    """Names that mean nothing: read by tree and motion alone, or refused."""
    places = rng.permutation(len(clip.names))
    names = {name: f"j{place:02d}" for name, place in zip(clip.names, places)}
    return _renamed(clip, names, foreign=True)


def mapped(clip: Clip, rng: np.random.Generator) -> Altered:
    """Names that mean nothing, with a mapping file that says what they are."""
    return replace(nonsense(clip, rng), foreign=False, said="--mapping")


# ----- places ----------------------------------------------------------------------------------


def _other_side(name: str) -> str:
    for one, other in (("Left", "Right"), ("Right", "Left"), ("_L", "_R"), ("_R", "_L")):
        if name.startswith(one) or name.endswith(one) and one[0] == "_":
            return name.replace(one, other)
    return name


def _conjugated(clip: Clip, turn: np.ndarray) -> Clip:
    """Every place and every local turn seen from axes that `turn` leads to."""
    return replace(clip, offsets=clip.offsets @ turn.T, places=clip.places @ turn.T,
                   turns=turn @ clip.turns @ turn.T,
                   ends=tuple(None if end is None else turn @ end for end in clip.ends))


def mirrored(clip: Clip, rng: np.random.Generator) -> Altered:
    """Left is right: no network is held to it but within what a side is worth."""
    turn = np.diag([-1.0, 1, 1])
    names = {name: _other_side(name) for name in clip.names}
    return replace(_renamed(_conjugated(clip, turn), names, exact=False), turn=turn)


def scaled(clip: Clip, rng: np.random.Generator) -> Altered:
    """Metres, millimetres, inches instead of centimetres."""
    scale = float(rng.choice([0.01, 10, 100, 1 / 2.54, 2.54]))
    return same(replace(clip, offsets=clip.offsets * scale, places=clip.places * scale,
                        ends=tuple(None if end is None else end * scale for end in clip.ends)),
                scale=scale, said=f"times {scale:g}")


def _turned(clip: Clip, turn: np.ndarray) -> Clip:
    turns, places = clip.turns.copy(), clip.places.copy()
    turns[:, 0], places[:, 0] = turn @ turns[:, 0], places[:, 0] @ turn.T
    return replace(clip, turns=turns, places=places)


def turned(clip: Clip, rng: np.random.Generator) -> Altered:
    """Another heading."""
    angle = float(rng.uniform(-180, 180))
    turn = Rotation.from_euler("y", angle, degrees=True).as_matrix()
    return same(_turned(clip, turn), turn=turn, said=f"{angle:.0f} degrees")


def upended(clip: Clip, rng: np.random.Generator) -> Altered:
    """Another axis is up: by the root alone, or in every joint's own axes."""
    axis, angle, up = [("x", 90, "z"), ("x", -90, "-z"), ("x", 180, "-y"), ("z", 90, "-x"),
                       ("z", -90, "x")][rng.integers(5)]
    turn = np.round(Rotation.from_euler(axis, angle, degrees=True).as_matrix())
    change, how = ((_turned, "root"), (_conjugated, "axes"))[rng.integers(2)]
    return same(change(clip, turn), turn=turn, said=f"{up} is up, by {how}", foreign="x" in up)


def moved(clip: Clip, rng: np.random.Generator) -> Altered:
    """Elsewhere, half of the time on a floor of another height."""
    shift = rng.uniform(-30, 30, 3) * SIZE * [1, rng.integers(2) / 10, 1]
    places = clip.places.copy()
    places[:, 0] += shift
    return same(replace(clip, places=places), shift=shift, said="raised" if shift[1] else "")


# ----- channels and joints ---------------------------------------------------------------------


def reordered_channels(clip: Clip, rng: np.random.Generator) -> Altered:
    """Each joint turns about its axes in an order of its own."""
    def order(listed):
        kinds = [[c for c in listed if c.endswith(kind)] for kind in ("position", "rotation")]
        return tuple(str(c) for kind in kinds for c in rng.permutation(kind)) if listed else listed
    return same(replace(clip, channels=tuple(map(order, clip.channels))))


def inner(clip: Clip) -> np.ndarray:
    """Joints whose place in their parent's frame does not change."""
    still = np.ptp(clip.places, axis=0).max(axis=1) < 1e-4 * height(clip)
    return still & (np.array(clip.parents) >= 0)


def positions(clip: Clip, rng: np.random.Generator) -> Altered:
    """Position channels that say nothing new are left out, or put in."""
    still, listed = np.flatnonzero(inner(clip)), list(clip.channels)
    offsets, places = clip.offsets.copy(), clip.places.copy()
    drop = any(len(listed[j]) > 3 for j in still)
    for joint in still:
        kept = tuple(c for c in listed[joint] if c.endswith("rotation"))
        listed[joint] = kept if drop else FULL + kept
        offsets[joint] = places[:, joint] = clip.places[:, joint].mean(axis=0)
    return same(replace(clip, channels=tuple(listed), offsets=offsets, places=places),
                said="dropped" if drop else "added")


def meaningless_offsets(clip: Clip, rng: np.random.Generator) -> Altered:
    """The OFFSET of a joint whose position channels replace it says nothing."""
    offsets = clip.offsets.copy()
    for joint, listed in enumerate(clip.channels):
        if len(listed) == 6 and not inner(clip)[joint]:
            offsets[joint] += rng.uniform(-3, 3, 3) * SIZE
    return same(replace(clip, offsets=offsets))


def ends(clip: Clip, rng: np.random.Generator) -> Altered:
    """Other End Sites beyond head and toes, which feed nothing."""
    listed = list(clip.ends)
    for joint, name in enumerate(clip.names):
        if listed[joint] is not None and not ("Hand" in name):
            listed[joint] = rng.uniform(-0.05, 0.05, 3) * SIZE
    return same(replace(clip, ends=tuple(listed)))


def taken(clip: Clip, kept: list[int]) -> Clip:
    """The joints `kept`, in that order, parents before children."""
    new = {old: place for place, old in enumerate(kept)}
    pick = tuple(kept)
    parents = tuple(new.get(clip.parents[j], -1) for j in pick)
    closed = list(clip.ends[j] for j in pick)
    for joint, parent in enumerate(clip.parents):
        if joint not in new and parent in new and closed[new[parent]] is None:
            closed[new[parent]] = clip.offsets[joint]
    return Clip(tuple(clip.names[j] for j in pick), parents, clip.offsets[kept],
                tuple(clip.channels[j] for j in pick), tuple(closed), clip.turns[:, kept],
                clip.places[:, kept], clip.step)


def reordered_children(clip: Clip, rng: np.random.Generator) -> Altered:
    """The same tree, its branches listed in another order."""
    def below(joint):
        children = [j for j, parent in enumerate(clip.parents) if parent == joint]
        return [joint] + [k for j in rng.permutation(children).astype(int) for k in below(j)]
    return same(taken(clip, below(0)))


def extra(clip: Clip, rng: np.random.Generator) -> Altered:
    """Joints that feed nothing: a twist bone, an eye, a tool in the hand, a tail's end."""
    added = {"ForeArm": "ForeArmTwist", "LowerArm": "LowerArmTwist", "Head": "Eye",
             "UpLeg": "UpLegTwist", "UpperLeg": "UpperLegTwist"}
    joints = [j for j in range(len(clip.names)) if side_and_part(clip.names[j])[1] in
              ("ForeArm", "Head", "UpLeg")]
    count = len(clip.names)
    names, listed, parents, offsets = (list(clip.names), list(clip.channels), list(clip.parents),
                                       list(clip.offsets))
    turns, places, closed = [clip.turns], [clip.places], list(clip.ends)
    for joint in joints:
        word = next(key for key in added if key in clip.names[joint])
        names.append(clip.names[joint].replace(word, added[word]))
        parents.append(joint)
        listed.append(("Zrotation", "Xrotation", "Yrotation"))
        offsets.append(rng.uniform(-0.03, 0.03, 3) * SIZE)
        angle = 40 * np.sin(rng.uniform(0, 6) + np.arange(len(clip.turns)) * clip.step * 5)
        turns.append(Rotation.from_euler("y", angle[:, None], degrees=True).as_matrix()[:, None])
        places.append(np.tile(offsets[-1], (len(clip.turns), 1, 1)))
        closed.append(np.zeros(3))
    whole = Clip(tuple(names), tuple(parents), np.array(offsets), tuple(listed), tuple(closed),
                 np.concatenate(turns, axis=1), np.concatenate(places, axis=1), clip.step)

    def below(joint):
        return [joint] + [k for j, p in enumerate(parents) if p == joint for k in below(j)]
    return replace(same(taken(whole, below(0))), names={name: name for name in clip.names},
                   said=", ".join(names[count:]))


def fewer(clip: Clip, rng: np.random.Generator) -> Altered:
    """Toes or fingertips are gone, which can be made up."""
    parts = [side_and_part(name)[1] for name in clip.names]
    gone = str(rng.choice([part for part in ("HandIndex1", "ToeBase") if part in parts]))
    kept = [joint for joint, part in enumerate(parts) if part != gone]
    names = {clip.names[j]: clip.names[j] for j in kept}
    return replace(same(taken(clip, kept)), names=names, exact=False, said=f"no {gone}")
