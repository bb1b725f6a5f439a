r"""How legs walk and jog: where the feet are planted, how they roll and swing, how high the hips
can be, how the knee bends.

One cycle of the gait is phase 0..1 and begins when the left foot lands. Lengths are centimetres of
a body of average size, angles radians, y is up; a body with yaw a faces (sin a, 0, cos a) and has
its left side at (cos a, 0, -sin a). Every curve is closed-form in the phase with a continuous
velocity; time is always the first axis, and nothing loops over it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import convolve1d, maximum_filter1d

from ..motion import rotation
from ..motion.easing import bump, ease, glide
from ..motion.foot_ik import two_bone

THIGH, SHIN = 39.0, 41.0
ANKLE_HEIGHT, TOE_HEIGHT = 11.74, 4.25       # of a foot that stands flat
# from ankle to ball, 11.76 long
ANKLE_TO_BALL = np.array([0.0, TOE_HEIGHT - ANKLE_HEIGHT, 9.06])
LEG_REACH = 0.986 * (THIGH + SHIN)           # of a planted leg at most: 19 degrees of knee


@dataclass(frozen=True)
class Gait:
    """A content: what the legs do before any style.

    speed : cm/s;  stride : cm from one landing of a foot to its next, at that speed
    slowest, fastest : cm/s
    stance : part of the cycle that a foot is planted
    longest : its limit for any style (below 0.5: both feet leave the floor)
    landing : part of the stance before the hips are above the ankle
    flat, heel_off : parts of the stance after which the sole lies flat and the heel rises
    strike, push : pitch of the foot when it lands (toe up) and when it leaves (heel up), degrees
    clearance : cm by which a swinging foot is lifted;  width : cm between an ankle and the path
    height : cm, hips above the floor
    bounce : cm, amplitude of the hips, positive when highest over a planted foot
    sway : cm, amplitude of the hips sideways;  lean, elbow, arm_swing, twist : degrees
    """

    speed: float
    stride: float
    slowest: float
    fastest: float
    stance: float
    longest: float
    landing: float
    flat: float
    heel_off: float
    strike: float
    push: float
    clearance: float
    width: float
    height: float
    bounce: float
    sway: float
    lean: float
    elbow: float
    arm_swing: float
    twist: float


WALK = Gait(speed=110.0, stride=113.0, slowest=15.0, fastest=190.0, stance=0.60, longest=0.70,
            landing=0.39, flat=0.15, heel_off=0.55, strike=20.0, push=66.0, clearance=5.0,
            width=6.5, height=92.6, bounce=0.6, sway=2.0, lean=2.0, elbow=14.0, arm_swing=24.0,
            twist=6.0)
JOG = Gait(speed=240.0, stride=168.0, slowest=120.0, fastest=380.0, stance=0.35, longest=0.44,
           landing=0.42, flat=0.18, heel_off=0.48, strike=12.0, push=58.0, clearance=16.0,
           width=4.5, height=88.0, bounce=-2.6, sway=1.2, lean=8.0, elbow=78.0, arm_swing=30.0,
           twist=9.0)
STAND = Gait(speed=0.0, stride=0.0, slowest=0.0, fastest=0.0, stance=1.0, longest=1.0, landing=0.5,
             flat=0.0, heel_off=1.0, strike=0.0, push=0.0, clearance=0.0, width=9.0, height=92.6,
             bounce=0.0, sway=1.5, lean=0.0, elbow=12.0, arm_swing=1.5, twist=1.0)


def forward_of(yaw: np.ndarray) -> np.ndarray:
    """Where a body with this yaw faces.   yaw : (...)  ->  (..., 3)"""
    return rotation.yaw_rotation(yaw)[..., 2]


def left_of(yaw: np.ndarray) -> np.ndarray:
    """Where its left side is.   yaw : (...)  ->  (..., 3)"""
    return rotation.yaw_rotation(yaw)[..., 0]


@dataclass(frozen=True)
class Path:
    """Where the body is on the floor, sampled finely and beyond both ends of the clip.

    phase : (n,) cycles, rising;  position : (n, 3) cm, y = 0;  yaw : (n,) radians, not wrapped
    """

    phase: np.ndarray
    position: np.ndarray
    yaw: np.ndarray

    def at(self, phase: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where the body is when the gait is at a phase.

        phase : (...)  ->  position (..., 3), yaw (...)
        """
        x, z, yaw = (np.interp(phase, self.phase, column)
                     for column in (self.position[:, 0], self.position[:, 2], self.yaw))
        return np.stack([x, np.zeros_like(x), z], axis=-1), yaw


@dataclass(frozen=True)
class FootPlan:
    """One foot over time.

    ankle : (T, 3);  yaw, pitch : (T,), positive to the left and heel up
    bend : (T,) of the toes against the foot
    heel, toe : (T,) bool, while one is True that joint does not move
    swing : (T,) 0 to 1 within the swing, 0 while planted
    """

    ankle: np.ndarray
    yaw: np.ndarray
    pitch: np.ndarray
    bend: np.ndarray
    heel: np.ndarray
    toe: np.ndarray
    swing: np.ndarray


def plan_foot(phase: np.ndarray, path: Path, side: int, start: float, stance: float, gait: Gait, *,
              width: float, ahead: float, toe_out: float, strike: float, push: float,
              clearance: float, around: float) -> FootPlan:
    r"""The curve of a foot that lands at phases `start + k` and stays for `stance` of the cycle.

    The footprint lies beside the place where the body is in mid-stance. B is where the ball of the
    foot would be if the foot were flat: it rests on the print, then glides to the next one. Two
    pitches roll the foot, h (heel up, pivot: the ball) and g (toe up, pivot: the ankle), with a the
    ankle's place seen from the ball and R the rotation by yaw and pitch:

        ankle = B + R(h) a,     ball = ankle - R(h - g) a

    So the ankle rests exactly while B rests and h = 0, the ball rests exactly while B rests and
    g = 0.

    phase : (T,) cycles;  side : +1 left, -1 right;  toe_out, strike, push : radians
    width, ahead, clearance, around : cm (ahead: the print is moved forward; around: the swing bends
        outwards)
    """
    cycle = np.floor(phase - start)
    c = phase - start - cycle
    index = (cycle - cycle[0]).astype(int)
    landings = start + cycle[0] + np.arange(index[-1] + 2)
    prints, yaws = path.at(landings + gait.landing * stance)
    prints = prints + side * width * left_of(yaws) + ahead * forward_of(yaws)
    yaws = yaws + side * toe_out

    u = np.clip((c - stance) / max(1.0 - stance, 1e-9), 0.0, 1.0)
    move = glide(u)[:, None]
    yaw = yaws[index] + move[:, 0] * (yaws[index + 1] - yaws[index])
    ankle_flat = prints[index] + move * (prints[index + 1] - prints[index])
    ankle_flat = ankle_flat + (side * around * bump(u))[:, None] * left_of(yaw)
    ankle_flat[:, 1] = ANKLE_HEIGHT + clearance * (4.0 * u * (1.0 - u)) ** 2

    lift, land = gait.heel_off * stance, gait.flat * stance
    peak, back = stance + 0.06 * (1.0 - stance), stance + 0.72 * (1.0 - stance)
    raise_toe = 1.0 - 0.55 * (1.0 - stance)
    push, strike = (push, strike) if stance < 1.0 else (0.0, 0.0)    # who stands does not roll
    h = (push * ease((c - lift) / max(peak - lift, 1e-9))
         * (1.0 - ease((c - peak) / max(back - peak, 1e-9))))
    g = strike * np.where(c < stance, 1.0 - ease(c / max(land, 1e-9)),
                          ease((c - raise_toe) / max(1.0 - raise_toe, 1e-9)))

    turn = rotation.yaw_rotation(yaw)
    flat = (turn @ ANKLE_TO_BALL[:, None])[..., 0]
    ankle = (ankle_flat + flat
             - (turn @ rotation.axis_rotation("X", h) @ ANKLE_TO_BALL[:, None])[..., 0])
    planted = c <= stance
    return FootPlan(ankle, yaw, h - g, -h * (1.0 - ease(u / 0.45)), planted & (c <= lift),
                    planted & (c >= land), u)


def hip_height(wanted: np.ndarray, hips: np.ndarray, sockets: Sequence[np.ndarray],
               feet: Sequence[FootPlan], frames: int) -> np.ndarray:
    r"""The height of the hips that every planted leg can reach, near the wanted one and smooth.

    A planted leg with its ankle at (x, y, z) allows its socket no more than
    `y + sqrt(LEG_REACH^2 - horizontal distance^2)`. What is wanted beyond that is too much; each
    frame gives up the most that is too much within `frames` before and after, averaged over the
    same window. All that is averaged are largest values of windows around the frame in question, so
    it is never less than what is too much there.

    wanted : (T,);  hips : (T, 3), y ignored;  sockets : two (T, 3) from the hips to the hip joints
    feet : of the two legs   ->  (T,)
    Raises ValueError when a planted foot is too far away.
    """
    excess = np.zeros_like(wanted)
    for socket, foot in zip(sockets, feet):
        away = foot.ankle - hips - socket
        square = LEG_REACH ** 2 - away[:, 0] ** 2 - away[:, 2] ** 2
        planted = foot.swing == 0
        if (square[planted] < (0.6 * LEG_REACH) ** 2).any():
            far = np.sqrt(LEG_REACH ** 2 - square[planted].min())
            raise ValueError(
                f"speed, turn, style: found a foot planted {far:.0f} cm from the hips, needed at "
                f"most {0.8 * LEG_REACH:.0f} cm on a body of average size; take a lower speed or "
                "a shorter stride")
        allowed = foot.ankle[:, 1] - socket[:, 1] + np.sqrt(np.maximum(square, 0.0))
        excess = np.where(planted, np.maximum(excess, wanted - allowed), excess)
    weights = bump(np.arange(1, 2 * frames + 2) / (2 * frames + 2))
    return wanted - convolve1d(maximum_filter1d(excess, 2 * frames + 1, mode="nearest"),
                               weights / weights.sum(), mode="nearest")


def within_reach(socket: np.ndarray, foot: FootPlan) -> np.ndarray:
    """The ankle, drawn towards its hip joint where it would stretch the leg. Only a swinging foot
    is, and the knee has time to give way.

    socket : (T, 3)  ->  ankle (T, 3)
    """
    away = foot.ankle - socket
    distance = np.linalg.norm(away, axis=-1, keepdims=True)
    easy = LEG_REACH - 3.0 * (4.0 * foot.swing * (1.0 - foot.swing))[:, None]
    soft = 1.01 * LEG_REACH - easy
    over = np.maximum(distance - easy, 0.0) * (foot.swing > 0)[:, None]
    shift = (soft * np.tanh(over / soft) - over) * away / distance
    return foot.ankle + shift


def bend_leg(socket: np.ndarray, ankle: np.ndarray,
             facing: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    r"""Two bones between hip joint and ankle, the knee towards `facing` (`foot_ik.two_bone`):

        cos(pi - knee) = (THIGH^2 + SHIN^2 - |ankle - socket|^2) / (2 THIGH SHIN)

    Both bones turn about facing x (ankle - socket), the body's left.

    socket, ankle, facing : (T, 3)
    ->  thigh and shin rotations (T, 3, 3) for bones that lie along -y at rest, knee angle (T,),
    0 straight
    """
    knee = two_bone(socket, ankle, THIGH, SHIN, facing)
    left = np.cross(facing, ankle - socket)
    left = left / np.linalg.norm(left, axis=-1, keepdims=True)
    square = np.sum((ankle - socket) ** 2, axis=-1)
    cos_inner = (THIGH ** 2 + SHIN ** 2 - square) / (2 * THIGH * SHIN)
    angle = np.pi - np.arccos(np.clip(cos_inner, -1.0, 1.0))
    return _frame(left, (socket - knee) / THIGH), _frame(left, (knee - ankle) / SHIN), angle


def _frame(x, y):
    """The rotation with these two columns.   (T, 3), (T, 3)  ->  (T, 3, 3)"""
    return np.stack([x, y, np.cross(x, y)], axis=-1)
