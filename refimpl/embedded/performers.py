r"""Performers made by the program: five actions, each carried out with an effort that is known. The
embedded data of this room.

They have the skeleton of `embedded.walkers`, centimetres, y up, 60 frames a second. An action
passes through key poses, all from and to a quiet stand; a planted foot stays where it is. The
effort (flow, weight, time), each in [-3, 3], shapes how it is done:

- time (sustained..sudden): the part of each phase in which the body moves, from all of it to a
  burst between two rests, and the tempo;
- weight (light..strong): the size of the movement;
- flow (bound..free): bound goes by fits and starts, free goes on and lets hands and head follow
  later.

Two further formulas make the same actions otherwise, to hold an observer against what it was not
made with: "passing" and "submovements" (`FORMULAS`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ..motion import rotation
from ..motion.clip import Clip
from ..motion.easing import ease
from ..motion.features import FPS
from ..motion.joints import HEELS, PARENTS, SLOT, SLOTS, TOES
from ..motion.skeleton import forward_kinematics
from .gait import TOE_HEIGHT
from .manner import person
from .walkers import skeleton_joints

EFFORT_LIMIT = 3.0

# Rotation vectors in degrees from the T-pose; what is not named is as in the stand. x: pitch
# forward, y: turn left, z: raise the left side.
QUIET = {"LeftArm": (0, 0, -78), "RightArm": (0, 0, 78), "LeftForeArm": (0, -12, 0),
         "RightForeArm": (0, 12, 0)}
REACH_OUT = {"RightArm": (0, 75, -40), "RightForeArm": (0, 5, 0), "Spine": (-8, 8, 0),
             "Chest": (-6, 10, 4), "Head": (-22, 0, 0), "LeftArm": (15, 0, -70),
             "LeftUpLeg": (10, 0, 0), "LeftLeg": (10, 0, 0), "Hips": (0, 15, 0)}
DRAW_BACK = {"RightArm": (0, -25, 60), "RightForeArm": (0, 70, 0), "Chest": (0, -14, 0),
             "Hips": (0, -8, 0)}
BOW = {"Hips": (28, 0, 0), "Spine": (22, 0, 0), "Chest": (20, 0, 0), "Neck": (10, 0, 0),
       "Head": (12, 0, 0), "LeftUpLeg": (-34, 0, 0), "RightUpLeg": (-34, 0, 0),
       "LeftLeg": (8, 0, 0), "RightLeg": (8, 0, 0), "LeftArm": (20, 0, -75),
       "RightArm": (20, 0, 75)}
WAVE_IN = {"LeftArm": (0, 0, 22), "LeftForeArm": (0, 0, 95), "LeftHand": (0, 0, 15),
           "Chest": (0, 0, -5), "Head": (0, 14, -5)}
WAVE_OUT = {"LeftArm": (0, 0, 10), "LeftForeArm": (0, 0, 35), "LeftHand": (0, 0, -25),
            "Chest": (0, 0, 4), "Head": (0, 14, 5)}
KNEE_UP = {"LeftUpLeg": (-85, 0, 0), "LeftLeg": (95, 0, 0), "LeftFoot": (20, 0, 0),
           "Spine": (8, 0, 0), "RightArm": (0, 30, 55), "LeftArm": (0, 25, -45),
           "RightLeg": (6, 0, 0), "RightUpLeg": (-4, 0, 0)}
KICK = {"LeftUpLeg": (-80, 0, 0), "LeftLeg": (8, 0, 0), "LeftFoot": (30, 0, 0),
        "Spine": (-6, 0, 0), "Chest": (-8, 0, 0), "RightArm": (0, 45, 30), "LeftArm": (0, 30, -35),
        "RightLeg": (10, 0, 0), "RightUpLeg": (-6, 0, 0)}
STRIDE = {"LeftUpLeg": (-34, 0, 0), "LeftLeg": (12, 0, 0), "RightUpLeg": (24, 0, 0),
          "RightLeg": (20, 0, 0), "RightFoot": (10, 0, 0), "RightArm": (0, 45, 62),
          "LeftArm": (0, 35, -62), "Hips": (4, -10, 0), "Chest": (0, 16, 0),
          "RightForeArm": (0, 40, 0)}
# Key poses between two stands, seconds of each phase from pose to pose, and which foot stands
# during the phase (R or L).
ACTIONS = {
    "reach": ((DRAW_BACK, REACH_OUT), (0.7, 0.9, 1.1), "RRR"),
    "bow": ((BOW, BOW), (1.0, 0.3, 1.1), "RRR"),
    "wave": ((WAVE_IN, WAVE_OUT, WAVE_IN, WAVE_OUT), (0.7, 0.45, 0.45, 0.45, 0.7), "RRRRR"),
    "kick": ((KNEE_UP, KICK, KNEE_UP), (0.7, 0.5, 0.5, 0.7), "RRRR"),
    "step": ((STRIDE,), (1.1, 1.1), "RL"),
}
# How late the ends of the limbs are, against each other.
LATE = np.array([{"Head": 2, "LeftForeArm": 1, "RightForeArm": 1, "LeftHand": 2, "RightHand": 2,
                  "LeftFinger": 3, "RightFinger": 3, "Neck": 1, "LeftFoot": 1, "RightFoot": 1,
                  }.get(name, 0) for name in SLOTS])


class PerformerError(ValueError):
    """An action or an effort that cannot be."""


@dataclass(frozen=True)
class Performance:
    """A clip and the truth about it.

    contents : the actions in it, in order;  effort : (3,) flow, weight, time
    cuts : the first frame of each action, then the end
    """

    name: str
    contents: tuple[str, ...]
    effort: np.ndarray
    clip: Clip = field(repr=False)
    cuts: tuple[int, ...]


def perform(contents: str | Sequence[str], number: int,
            effort: Sequence[float] | np.ndarray | None = None,
            formula: str = "eased") -> Performance:
    """Performer `number` does some actions one after the other, always in the same way.

    contents : a name in ACTIONS or several
    effort : (3,) in [-3, 3], the performer's own unless given;  formula : one of FORMULAS
    Raises PerformerError for an unknown action or an effort out of range.

    >>> made = perform(("bow", "kick"), 5)
    >>> made.name, made.cuts[-1] == made.clip.frames
    ('bow-kick_005', True)
    """
    contents = (contents,) if isinstance(contents, str) else tuple(contents)
    unknown = [name for name in contents if name not in ACTIONS]
    if unknown or not contents:
        raise PerformerError(f"contents: found {', '.join(map(repr, unknown)) or 'none'}, needed "
                             f"some of {', '.join(ACTIONS)}")
    effort = own_effort(number) if effort is None else np.asarray(effort, dtype=float)
    if effort.shape != (3,) or not (np.abs(effort) <= EFFORT_LIMIT).all():
        raise PerformerError(f"effort: found {effort}, needed flow, weight and time, each from "
                             "-3 to 3")
    if formula not in FORMULAS:
        raise PerformerError(f"formula: found {formula!r}, needed one of {', '.join(FORMULAS)}")
    parts = [FORMULAS[formula](content, number, effort) for content in contents]
    cuts = np.cumsum([0] + [len(angles) for angles, _ in parts])
    angles, support = (np.concatenate(arrays) for arrays in zip(*parts))
    habits = 2.5 * np.random.default_rng([68, number]).normal(size=(len(SLOTS), 3))  # how he stands
    rotations = rotation.exp_map(np.radians(angles + habits))
    clip = _clip(rotations, support, skeleton_joints(person(100 + number)))
    return Performance(f"{'-'.join(contents)}_{number:03d}", contents, effort, clip,
                       tuple(int(cut) for cut in cuts))


def own_effort(number: int) -> np.ndarray:
    """The effort that a performer has by nature.   ->  (3,) flow, weight, time in [-2.7, 2.7]"""
    return np.random.default_rng([67, number]).uniform(-2.7, 2.7, 3)


def make_performers(performers: int = 12, contents: Sequence[str] = tuple(ACTIONS),
                    first: int = 0) -> list[Performance]:
    """Every action by every performer: 60 fragments, as in section 8.

    performers : how many;  contents : names in ACTIONS;  first : number of the first performer
    """
    return [perform(content, number) for content in contents
            for number in range(first, first + performers)]


def _angles(content, number, effort):
    """Rotation vectors of an action at 60 frames a second.
    ->  (T, 21, 3) degrees, (T,) 0 where the left foot stands and 1 the right
    """
    flow, weight, time = effort
    keys, seconds, feet = ACTIONS[content]
    rng = np.random.default_rng([69, number, list(ACTIONS).index(content)])
    seconds = np.array(seconds) * 2.0 ** (-time / 14.0) * rng.uniform(0.92, 1.08, len(seconds))
    size = (1.0 + 0.13 * weight) * rng.uniform(0.95, 1.05)
    stand = _pose(QUIET)
    poses = [stand, *(stand + size * (_pose({**QUIET, **key}) - stand) for key in keys), stand]
    starts = np.concatenate([[0.0], np.cumsum(seconds)])
    clock = np.arange(max(2, round(FPS * starts[-1]))) / FPS
    angles = np.broadcast_to(stand, (len(clock), *stand.shape)).copy()
    for begin, long, before, after in zip(starts, seconds, poses, poses[1:]):
        angles += _progress((clock - begin) / long, flow, time)[:, :, None] * (after - before)
    phase = np.searchsorted(starts[1:-1], clock, side="right")
    support = np.array([int(foot == "R") for foot in feet])[phase]
    drift = sum(rng.normal(size=stand.shape)
                * np.sin(np.pi * n * np.linspace(0, 1, len(clock)))[:, None, None]
                for n in (1, 2, 3))
    return angles + 0.6 * drift, support


def _phases(content, number, stream, size, jitter):
    """->  poses, seconds of each phase before the effort, which foot stands, generator"""
    keys, seconds, feet = ACTIONS[content]
    rng = np.random.default_rng([stream, number, list(ACTIONS).index(content)])
    stand, size = _pose(QUIET), size * rng.uniform(0.95, 1.05)
    poses = [stand, *(stand + size * (_pose({**QUIET, **key}) - stand) for key in keys), stand]
    return poses, np.array(seconds) * rng.uniform(1 - jitter, 1 + jitter, len(seconds)), feet, rng


def _strokes(poses, seconds, feet, stroke):
    """The poses one after the other.   stroke : of the part of a phase (T,), how far it has come
    ->  (T, 21, 3) degrees, (T,) support, seconds (T,)"""
    starts = np.concatenate([[0.0], np.cumsum(seconds)])
    clock = np.arange(round(FPS * starts[-1])) / FPS
    angles = np.broadcast_to(poses[0], (len(clock), *poses[0].shape)).copy()
    for begin, long, before, after in zip(starts, seconds, poses, poses[1:]):
        angles += stroke((clock - begin) / long)[:, None, None] * (after - before)
    phase = np.searchsorted(starts[1:-1], clock, side="right")
    return angles, np.array([int(foot == "R") for foot in feet])[phase], clock


def _passing(content, number, effort):
    """After EMOTE (Chi et al. 2000): sudden rises steeply; strong is larger and swings back and
    over; free passes through the key poses, bound halts every nine frames."""
    flow, weight, time = effort
    poses, seconds, feet, _ = _phases(content, number, 70, 1.0 + 0.1 * weight, 0.1)
    k, free = 5.4 * 2.0 ** (1.3 * time / 3), (flow + EFFORT_LIMIT) / (2 * EFFORT_LIMIT)

    def _stroke(u):
        u = np.clip(u, 0, 1)
        s, least = 1 / (1 + np.exp(-k * (2 * u - 1))), 1 / (1 + np.exp(k))
        over = np.where(u < 0.5, 0.6, 1.0) * np.sin(2 * np.pi * u) * 4 * u * (1 - u)
        return (s - least) / (1 - 2 * least) - 0.1 * max(weight, 0) / 3 * over
    angles, support, _ = _strokes(poses, 1.1 * seconds, feet, _stroke)
    angles = gaussian_filter1d(angles, 1 + 7 * free, axis=0, mode="nearest")
    n, every = np.arange(len(angles)), 9.0
    warped = n + 0.9 * (1 - free) * every / (2 * np.pi) * np.sin(2 * np.pi * n / every)
    low = np.clip(warped.astype(int), 0, len(n) - 2)
    part = np.clip(warped - low, 0, 1)[:, None, None]
    return (1 - part) * angles[low] + part * angles[low + 1], support


def _submovements(content, number, effort):
    """Strokes of least jerk (Flash and Hogan 1985): sudden ones take less of their phase; strong is
    larger; bound goes in four submovements, with a tremor of 4 to 6 Hz."""
    flow, weight, time = effort
    poses, seconds, feet, rng = _phases(content, number, 71, 1.0 + 0.12 * weight, 0.1)
    bound = (EFFORT_LIMIT - flow) / (2 * EFFORT_LIMIT)

    def _least_jerk(u):
        u = np.clip(u, 0, 1)
        return u ** 3 * (10 - 15 * u + 6 * u * u)

    def _stroke(u):
        v = np.clip((u - 0.5) / (0.75 - 0.13 * time) + 0.5, 0, 1)
        steps = sum(_least_jerk(4 * v - k) for k in range(4)) / 4
        return (1 - 0.75 * bound) * _least_jerk(v) + 0.75 * bound * steps
    angles, support, clock = _strokes(poses, seconds * 2.0 ** (-time / 10), feet, _stroke)
    phase = rng.uniform(0, 2 * np.pi, angles.shape[1:])
    rate = 2 * np.pi * rng.uniform(4, 6, angles.shape[1:])
    return angles + 0.5 * bound * np.sin(rate * clock[:, None, None] + phase), support


def _progress(u, flow, time):
    r"""How far each joint has come from one key pose to the next: 0 before, 1 after.
    u : (T,) part of the phase  ->  (T, 21)

    An ease within the middle `width` of the phase; free flow delays the ends of the limbs, bound
    flow slackens four times:

        s  ->  s - h sin(8 pi s) / (8 pi)
    """
    width = 0.7 - 0.08 * time                        # 0.94 sustained .. 0.46 sudden
    free = (flow + EFFORT_LIMIT) / (2 * EFFORT_LIMIT)
    late = 0.5 * (1 - width) * free * LATE / LATE.max()
    s = ease((u[:, None] - 0.5 - late) / width + 0.5)
    return s - 0.4 * (1 - free) * np.sin(8 * np.pi * s) / (8 * np.pi)


FORMULAS = {"eased": _angles, "passing": _passing, "submovements": _submovements}


def _pose(key):
    """A key pose's rotation vectors as one array.   ->  (21, 3) degrees"""
    return np.array([key.get(name, (0, 0, 0)) for name in SLOTS], dtype=float)


def _clip(rotations, support, joints):
    """The root goes where the standing foot stays: it moves against that foot's motion seen from
    the hips, and the foot is on the floor.
    """
    offsets = np.broadcast_to([joint.offset for joint in joints], rotations.shape[:2] + (3,)).copy()
    offsets[:, SLOT["Hips"]] = 0
    _, seen = forward_kinematics(PARENTS, rotations, offsets)
    toes = seen[:, TOES]
    steps = -np.diff(toes, axis=0)[np.arange(len(toes) - 1), support[1:]]
    hips = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    heel_rise = 7.5                                  # of a resting heel joint above a toe's
    feet = seen[:, [*TOES, *HEELS], 1]
    hips[:, 1] = TOE_HEIGHT - (feet - [0, 0, heel_rise, heel_rise]).min(axis=1)
    angles = np.unwrap(rotation.matrix_to_euler(rotations, "ZXY"), axis=0)
    values = np.concatenate([hips, np.degrees(angles).reshape(len(angles), -1)], axis=1)
    return Clip(joints, 1.0 / FPS, values)
