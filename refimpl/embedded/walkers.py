r"""Walkers and joggers made from nothing but formulas: the embedded data, with known style, foot
contacts and phase.

Their skeleton has exactly the 21 joints of `joints.SLOTS`, a T-pose at rest, centimetres, y up, 60
frames per second, and faces +z with its left side at +x. Who walks is a `Manner` and a `Person`;
the legs are those of `gait`; trunk and arms swing on cosines of the phase. Everything is
deterministic: the same arguments make the same bits.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..motion import rotation
from ..motion.clip import POSITION_CHANNELS, Clip, Joint
from ..motion.features import FPS
from ..motion.joints import PARENTS, SLOT, SLOTS
from . import course
from . import gait as legs
# blend is part of this module's face
from .manner import STYLES, Person, Manner, blend, person  # noqa: F401

# The gait and the turn, radians / second.
CONTENTS = {"walk": (legs.WALK, 0.0), "jog": (legs.JOG, 0.0), "turn-left": (legs.WALK, 0.55),
            "turn-right": (legs.WALK, -0.55), "stand": (legs.STAND, 0.0)}
GRAVITY = 981.0                                      # cm / s^2

_ARM = {"Arm": (15.0, 12.0, -0.5), "ForeArm": (24.0, 0.0, 0.0), "Hand": (22.0, 0.0, 0.0),
        "Finger": (3.9, 0.0, 0.0)}
_LEG = {"UpLeg": (7.5, -1.8, 0.0), "Leg": (0.0, -legs.THIGH, 0.0), "Foot": (0.0, -legs.SHIN, 0.0),
        "Toe": tuple(legs.ANKLE_TO_BALL)}
OFFSETS = {"Hips": (0.0, 93.0, 0.0), "Spine": (0.0, 10.0, -1.0), "Chest": (0.0, 14.0, -0.5),
           "Neck": (0.0, 16.0, 0.5), "Head": (0.0, 8.0, 1.5)}
OFFSETS.update({side + part: (sign * x, y, z) for side, sign in (("Left", 1.0), ("Right", -1.0))
                for part, (x, y, z) in {**_ARM, **_LEG}.items()})
END_SITES = {"Head": (0.0, 15.0, 2.0), "LeftToe": (0.0, -2.0, 5.5), "RightToe": (0.0, -2.0, 5.5),
             "LeftFinger": (7.0, 0.0, 0.0), "RightFinger": (-7.0, 0.0, 0.0)}


@dataclass(frozen=True)
class Motion:
    """A clip and the truth about it.

    contacts : (T, 4) bool in the order of joints.FEET
    phase : (T,) in [0, 1), 0 when the left foot lands
    """

    name: str
    content: str
    style: str
    clip: Clip = field(repr=False)
    contacts: np.ndarray = field(repr=False)
    phase: np.ndarray = field(repr=False)


def skeleton_joints(person: Person = Person()) -> tuple[Joint, ...]:
    """The 21 joints in a T-pose, in a person's size and in the order of `joints.SLOTS`."""
    turn = ("Zrotation", "Xrotation", "Yrotation")
    sized, ends = ({name: tuple(person.scale * x for x in offset) for name, offset in table.items()}
                   for table in (OFFSETS, END_SITES))
    return tuple(Joint(name, int(parent), sized[name],
                       turn if parent >= 0 else POSITION_CHANNELS + turn, ends.get(name))
                 for name, parent in zip(SLOTS, PARENTS))


def make_clip(content: str = "walk", style: str | Manner = "normal", person: Person = Person(),
              seconds: float = 4.0, seed: int = 0, speed: float | None = None,
              turn: float | None = None, pause: tuple[float, float] | None = None,
              gestures: float = 0.0, heading: float = 0.0) -> Motion:
    r"""A clip of somebody who walks or jogs somewhere.

    content : a name in CONTENTS;  style : a name in STYLES or a Manner
    seconds : length, at least one frame;  seed : the phase at the start and small irregularities
    speed : cm/s and turn : radians/s (positive: left), instead of the content's own
    pause : from when to when, in seconds, a walker stands still; slows down before, speeds up after
    gestures : 0 to 1, how much the arms do beside swinging, each for itself, and trunk and head
    with them;  heading : radians, which way it goes from where it faces, pi for backwards
    ->  Motion of round(60 seconds) frames
    Raises ValueError for a content, style, length, speed, turn or pause that cannot be.

    >>> made = make_clip("jog", "old", seconds=0.5)
    >>> made.name, made.clip.frames, made.contacts.shape
    ('jog_old', 30, (30, 4))
    """
    if content not in CONTENTS:
        raise ValueError(f"content: found {content!r}, needed one of {', '.join(CONTENTS)}")
    if not isinstance(style, Manner) and style not in STYLES:
        raise ValueError(f"style: found {style!r}, needed a Manner or one of {', '.join(STYLES)}")
    if not (np.isfinite(seconds) and round(FPS * seconds) >= 1):
        raise ValueError(f"seconds: found {seconds}, needed at least one frame, 1/{FPS:g}")
    frames = round(FPS * seconds)
    rng = np.random.default_rng([seed, 4])
    name, plain = ("custom", style) if isinstance(style, Manner) else (style, STYLES[style])
    worn = _worn_by(plain, person)
    gait, usual_turn = CONTENTS[content]
    gait, cadence = _styled(gait, worn, person, speed)
    turn = usual_turn if turn is None else float(turn)
    if not abs(turn) <= 3.0:
        raise ValueError(f"turn: found {turn} radians / second, needed at most 3 to either side")
    if pause and not gait.stance > 0.5:
        raise ValueError(f"pause: found {pause} with {content}, needed a content in which both "
                         "feet stand at times")
    path, pace, start = course.path_over_floor(rng, frames, gait, turn, cadence, pause,
                                               heading)
    phase, position, yaw, pace = (curve[start:start + frames]
                                  for curve in (path.phase, path.position, path.yaw, pace))
    feet, centre = _feet(phase, path, gait, worn, pace)
    time = np.arange(frames) / FPS
    noise = course.irregularity(rng, time, worn.tremor)
    busy = course.gesturing(np.random.default_rng([seed, 5]), time, gestures)
    noise = {name: curve + busy.pop(name, 0.0) for name, curve in noise.items()} | busy
    wave = {name: pace * curve for name, curve in
            course.waves(phase, centre, worn.sharpness).items()}
    turning = np.gradient(yaw) if frames > 1 else np.zeros(1)
    bank = np.degrees(np.arctan(gait.speed * FPS * turning / GRAVITY))

    rotations = np.empty((frames, len(SLOTS), 3, 3))
    _trunk(rotations, yaw, gait, worn, wave, bank, noise)
    _arms(rotations, gait, worn, wave, noise)
    hips = position + (gait.sway * wave["side"] + 1.5 * worn.limp)[:, None] * legs.left_of(yaw)
    knees = _legs(rotations, hips, feet, wave, gait, worn, cadence)

    angles = rotation.matrix_to_euler(rotations, "ZXY")
    for joint, knee in knees.items():
        angles[:, joint] = np.stack([np.zeros(frames), knee, np.zeros(frames)], axis=-1)
    angles = np.degrees(np.unwrap(angles, axis=0)).reshape(frames, -1)
    clip = Clip(skeleton_joints(person), 1.0 / FPS,
                np.concatenate([person.scale * hips, angles], axis=1))
    contacts = np.stack([feet[0].heel, feet[0].toe, feet[1].heel, feet[1].toe], axis=1)
    return Motion(f"{content}_{name}", content, name, clip, contacts, phase % 1.0)


def make_database(seconds_per_clip: float = 8.0, people: int = 2,
                  styles: Sequence[str] = tuple(STYLES),
                  contents: Sequence[str] = ("walk", "jog", "turn-left", "turn-right"),
                  seed: int = 0) -> list[Motion]:
    """Every content in every style by person(0) to person(people - 1), named content_style_number;
    always the same.
    """
    motions: list[Motion] = []
    for number in range(people):
        for style in styles:
            for content in contents:
                made = make_clip(content, style, person(number), seconds_per_clip,
                                 seed=1000 * seed + len(motions))
                motions.append(replace(made, name=f"{made.name}_{number:03d}"))
    return motions


def _worn_by(style, person):
    """The style with a person's habits in it.   ->  Manner"""
    factors = {name: getattr(style, name) * getattr(person, name)
               for name in ("arm_swing", "width", "sway")}
    added = {name: getattr(style, name) + getattr(person, name)
             for name in ("lean", "head", "toe_out", "arm_out", "elbow")}
    return replace(style, **factors, **added)


def _styled(gait, style, person, speed):
    """The gait with a style's numbers in it, for a body of average size.   ->  Gait, cadence in
    cycles a second

    The stride grows with the square root of the speed, and so does the cadence.
    """
    if speed is None:
        speed = gait.speed * style.speed * person.stride * person.cadence
    elif gait.slowest <= speed / person.scale <= gait.fastest:
        speed = speed / person.scale
    else:
        raise ValueError(f"speed: found {speed} cm/s, needed {gait.slowest * person.scale:.0f} to "
                         f"{gait.fastest * person.scale:.0f} for this content and person")
    own = gait.stride * style.stride * np.sqrt(person.stride / person.cadence)
    stride = own * np.sqrt(speed / gait.speed) if gait.speed else 0.0
    cadence = speed / stride if stride else 0.25
    # the amplitude of a bounce at twice the cadence that falls freely
    falling = GRAVITY / (4 * np.pi * cadence) ** 2
    bounce = np.sign(gait.bounce) * min(abs(gait.bounce) + style.bounce, falling)
    styled = replace(
        gait, speed=speed, stride=stride, bounce=bounce,
        stance=min(gait.stance + style.stance, gait.longest), strike=gait.strike * style.roll,
        push=gait.push * style.roll, clearance=gait.clearance * style.clearance,
        width=gait.width * style.width, sway=gait.sway * style.sway,
        height=gait.height - style.crouch - 1.2 * abs(style.bounce), lean=gait.lean + style.lean,
        elbow=gait.elbow + style.elbow * (1.0 - gait.elbow / 120.0),
        arm_swing=gait.arm_swing * style.arm_swing, twist=gait.twist * style.twist)
    return styled, cadence


def _feet(phase, path, gait, style, pace):
    """Both feet, left first, and the phase in the middle of the left foot's stance.
    ->  [FootPlan, FootPlan], float
    """
    feet, middles = [], []
    for side, start, weak in ((1, 0.0, 0.0), (-1, 0.5 + 0.05 * style.limp, style.limp)):
        stance = gait.stance
        if stance < 1.0:
            stance = float(np.clip(stance + 0.06 * style.limp - 0.18 * weak, 0.15, gait.longest))
        stiff = 1.0 - (1.0 - style.stiffness) * (1.0 - 0.8 * weak)
        feet.append(legs.plan_foot(
            phase, path, side, start, stance, gait, width=gait.width,
            ahead=0.12 * (gait.lean + 0.5 * style.slump) + 0.05 * weak * gait.stride,
            toe_out=np.radians(style.toe_out), strike=np.radians(gait.strike) * pace,
            push=np.radians(gait.push) * (1.0 - 0.5 * stiff) * pace,
            clearance=max(0.0, gait.clearance * (1.0 - 0.5 * stiff)), around=5.0 * stiff))
        middles.append(start + 0.5 * stance)
    if (still := pace == 0).any():                   # who pauses stands on both soles
        feet = [replace(foot, heel=foot.heel | still, toe=foot.toe | still) for foot in feet]
    return feet, 0.5 * (middles[0] + middles[1] - 0.5)


def _turned(yaw=0.0, pitch=0.0, roll=0.0):
    """Degrees (T,): yaw to the left, then pitch forward, then roll that raises the left side.
    ->  (T, 3, 3)
    """
    Y, X, Z = (rotation.axis_rotation(axis, np.radians(angle))
               for axis, angle in (("Y", yaw), ("X", pitch), ("Z", roll)))
    return Y @ X @ Z


def _trunk(rotations, yaw, gait, style, wave, bank, noise):
    """Fill in Hips to Head: the pelvis follows the legs, the shoulders turn against it, the head
    looks ahead.
    """
    hurt = style.limp * (0.5 - 0.5 * wave["side"])       # 1 in the middle of the weak leg's stance
    lean = gait.lean + noise["lean"] + 12.0 * hurt
    side = style.tilt + bank + noise["tilt"] + style.limp * (4.0 + 8.0 * wave["side"])
    roll = 0.4 * gait.twist * wave["side"] - 5.0 * hurt
    twist, shoulders = -gait.twist * wave["step"], 0.9 * gait.twist * wave["step"]
    shoulders = shoulders + noise.get("twist", 0.0)
    pitch = lean + 0.8 * style.slump                     # of the chest, in the world
    neck = 0.45 * pitch + 0.3 * style.slump + 0.6 * style.head
    rotations[:, SLOT["Hips"]] = _turned(np.degrees(yaw) + twist, 0.3 * lean, roll)
    for name, part in (("Spine", 0.3), ("Chest", 0.5)):
        rotations[:, SLOT[name]] = _turned(0.5 * (shoulders - twist),
                                           0.35 * lean + part * style.slump, -0.5 * (roll + side))
    look = 0.5 * (noise["look"] - shoulders)
    rotations[:, SLOT["Neck"]] = _turned(look, neck - pitch + noise["nod"], 0.3 * side)
    rotations[:, SLOT["Head"]] = _turned(look, 0.1 * pitch + style.head - neck, 0.3 * side)


def _arms(rotations, gait, style, wave, noise):
    """Fill in both arms. They hang from the chest, swing against the legs, and `reach` lifts them
    to the front.

    In the T-pose the left arm lies along +x: Rz(-90) hangs it down, then Ry(-a) swings it forward
    by a, Rx turns the elbow inwards.
    """
    reach = style.reach
    hang = 0.85 * (gait.lean + 0.8 * style.slump)
    out, inwards = 7.0 + style.arm_out, (1.0 - reach) * (8.0 + 0.25 * gait.elbow)
    for side, name in ((1, "Left"), (-1, "Right")):
        busy = noise.get(name + "Busy", 0.0)             # how much the arm is raised for a gesture
        swing = -side * (1.0 - 0.7 * busy) * gait.arm_swing * wave["arm"]
        raised = out + noise.get(name + "Out", 0.0)
        forward = ((1.0 - reach) * (2.0 + hang + style.arm_forward + swing)
                   + reach * (84.0 + 0.7 * hang + 0.3 * swing))
        elbow = (1.0 - reach) * (gait.elbow + 0.4 * (swing + gait.arm_swing)) + 10.0 * reach
        rotations[:, SLOT[name + "Arm"]] = (
            _turned(roll=-side * (90.0 - raised))
            @ _turned(yaw=-side * (forward + noise[name + "Arm"])) @ _turned(pitch=inwards))
        bent = np.maximum(elbow + noise[name + "Elbow"], 2.0)
        rotations[:, SLOT[name + "ForeArm"]] = _turned(yaw=-side * bent)
        rotations[:, SLOT[name + "Hand"]] = _turned(yaw=-side * (8.0 - 30.0 * reach))
        rotations[:, SLOT[name + "Finger"]] = _turned(yaw=-side * 15.0)


def _legs(rotations, hips, feet, wave, gait, style, cadence):
    """Fill in both legs and the height of `hips`.

    ->  {joint: knee angle (T,)}: it may pass 90 degrees, where Euler angles read back from a matrix
    would jump
    """
    pelvis = rotations[:, SLOT["Hips"]]
    sockets = [(pelvis @ np.array(OFFSETS[side + "UpLeg"])[:, None])[..., 0]
               for side in ("Left", "Right")]
    wanted = (gait.height + gait.bounce * wave["twice"]
              - 4.0 * style.limp * (0.5 - 0.5 * wave["side"]))
    hips[:, 1] = legs.hip_height(wanted, hips, sockets, feet, max(1, round(0.12 * FPS / cadence)))
    pelvis_yaw = np.unwrap(np.arctan2(pelvis[:, 0, 2], pelvis[:, 2, 2]))
    knees = {}
    for side, socket, foot in zip(("Left", "Right"), sockets, feet):
        socket = hips + socket
        ankle = legs.within_reach(socket, foot)
        facing = pelvis_yaw + 0.5 * rotation.nearest_turn(foot.yaw - pelvis_yaw)
        thigh, shin, knee = legs.bend_leg(socket, ankle, legs.forward_of(facing))
        sole = rotation.yaw_rotation(foot.yaw) @ rotation.axis_rotation("X", foot.pitch)
        rotations[:, SLOT[side + "UpLeg"]] = pelvis.swapaxes(-1, -2) @ thigh
        rotations[:, SLOT[side + "Leg"]] = rotation.axis_rotation("X", knee)
        rotations[:, SLOT[side + "Foot"]] = shin.swapaxes(-1, -2) @ sole
        rotations[:, SLOT[side + "Toe"]] = rotation.axis_rotation("X", foot.bend)
        knees[SLOT[side + "Leg"]] = knee
    return knees
