r"""The 66 numbers a frame of Holden et al. 2017, section 3.1, and the way back to the world.

- `POSITIONS`, 0..62, length: 21 joints x (x, y, z) in the character's own frame: origin under the
  hips on the floor, y up, z forward, x to the left
- `TURN`, 63, radians/frame: turning velocity, yaw from this frame to the next, positive to the left
- `FORWARD`, 64, length/frame: velocity of the root along the character's z of the next frame
- `SIDEWAYS`, 65, length/frame: velocity of the root along the character's x of the next frame

Frame t's velocities lead from frame t to t + 1: first the turn, then the step, which is seen from
where the turn leads, as in the 2016 authors' code. To such a step equation 7 of Holden et al. adds
omega x p[t], which is right to first order; to one seen from frame t it would have to add
omega x p[t+1]. The last row repeats the velocities of the row before.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from .joints import BONES, FEET, JOINTS, LEGS, SLOT
from .rotation import nearest_turn, yaw_rotation

POSITIONS = slice(0, 3 * JOINTS)
TURN = 3 * JOINTS
FORWARD = TURN + 1
SIDEWAYS = TURN + 2
VELOCITIES = slice(TURN, SIDEWAYS + 1)
TRANSLATION = slice(FORWARD, SIDEWAYS + 1)
FEATURES = SIDEWAYS + 1

FPS = 60.0
FLOOR = {"y": [0, 2], "z": [0, 1]}           # the flat columns of a position, by what is up
ROOT_SIGMA, FACING_SIGMA = 3.0, 20.0         # frames: how root and facing are smoothed
FLOOR_SOFTNESS = 0.01                        # legs: how near the lowest a frame must be to count
AT_A_TIME = 2048                             # frames of a long clip that are looked at together
LEG_RANGE = (1e-6, 1e6)                      # lengths of a leg that a body may have, in any unit


@dataclass(frozen=True)
class Start:
    """What the 66 numbers leave out: where the character stands at frame 0, its yaw there, and the
    floor's height.
    """

    x: float = 0.0
    z: float = 0.0
    yaw: float = 0.0
    floor: float = 0.0


def in_pieces(work: Callable[[slice], np.ndarray], frames: int) -> np.ndarray:
    """What is made of each frame alone, of `AT_A_TIME` frames at a time: what lies between takes
    several times the memory of what comes out.

    work : frames to the rows that become of them;  frames : how many there are
    """
    first = work(slice(0, min(AT_A_TIME, frames)))
    if frames <= AT_A_TIME:
        return first
    made = np.empty((frames, *first.shape[1:]), first.dtype)
    made[:AT_A_TIME] = first
    for n in range(AT_A_TIME, frames, AT_A_TIME):
        made[n:n + AT_A_TIME] = work(slice(n, min(n + AT_A_TIME, frames)))
    return made


def checked_positions(positions: np.ndarray, name: str = "positions") -> np.ndarray:
    """World positions as a float array, or a ValueError on a wrong shape or on values that are not
    finite.

    positions : (T, 21, 3);  name : what to call them in the message   ->  (T, 21, 3)
    """
    positions = np.asarray(positions, dtype=float)
    if positions.ndim != 3 or positions.shape[1:] != (JOINTS, 3) or not len(positions):
        raise ValueError(f"{name}: found shape {positions.shape}, needed (frames, {JOINTS}, 3) "
                         "with at least one frame")
    if not np.isfinite(positions).all():
        frame, joint = np.argwhere(~np.isfinite(positions))[0, :2]
        raise ValueError(f"{name}: found {positions[frame, joint]} in frame {frame}, joint "
                         f"{joint}, needed finite positions")
    return positions


def leg_length(positions: np.ndarray) -> float:
    """Thigh plus shin, the median over frames and both legs: the size of a character.

    positions : (T, 21, 3)  ->  float, in their unit
    """
    thigh_and_shin = [np.linalg.norm(positions[:, knee] - positions[:, hip], axis=-1)
                      + np.linalg.norm(positions[:, heel] - positions[:, knee], axis=-1)
                      for hip, knee, heel, _ in LEGS]
    return float(np.median(thigh_and_shin))


def bone_lengths_by_frame(positions: np.ndarray) -> np.ndarray:
    """Length of each bone of `joints.BONES` in each frame.   positions : (T, 21, 3)  ->  (T, 20)"""
    parents, children = np.array(BONES).T
    return in_pieces(lambda some: np.linalg.norm(
        positions[some][:, children] - positions[some][:, parents], axis=-1), len(positions))


def mean_steps(positions: np.ndarray) -> np.ndarray:
    """How far the joints move on average from each frame to the next.   (T, 21, 3)  ->  (T - 1,)"""
    return in_pieces(lambda some: np.linalg.norm(
        np.diff(positions[some.start:some.stop + 1], axis=0), axis=-1).mean(axis=1),
        len(positions) - 1)


def bone_lengths(positions: np.ndarray) -> np.ndarray:
    """Median length of each bone of `joints.BONES`.   positions : (T, 21, 3)  ->  (20,)

    >>> crouched = np.arange(21.0)[:, None] * [0, 0, 1]              # every joint at a z of its own
    >>> bone_lengths(crouched[None])[:5]
    array([1., 1., 1., 1., 5.])
    """
    return np.median(bone_lengths_by_frame(positions), axis=0)


def floor_height(positions: np.ndarray) -> float:
    r"""Soft minimum over time of the lowest foot joint's height h: a mean of the heights that are
    close to the lowest one,

        floor = sum_t w_t h_t / sum_t w_t,    w_t = exp(-(h_t - min h) / s),    s = 1 % of a leg

    A frame that lies lower than the rest by 1 % of a leg or less moves it little; one that lies
    lower by more takes the floor with it, whatever the others say (a rest pose as first row, a
    stumble of the capture). It does not depend on the unit or the clip's length (the 2016 code's
    form, min - log(1/2 + exp(min - max)) of the lower toe, depends on the unit).

    positions : (T, 21, 3), y up  ->  float
    """
    lowest = positions[:, FEET, 1].min(axis=1)
    weight = np.exp(-(lowest - lowest.min()) / (FLOOR_SOFTNESS * leg_length(positions)))
    return float(weight @ lowest / weight.sum())


def root_path(positions: np.ndarray) -> np.ndarray:
    """The hips on the floor plane, smoothed over time.

    positions : (T, 21, 3)  ->  (T, 2): x and z
    """
    hips = positions[:, SLOT["Hips"]][:, FLOOR["y"]]
    return gaussian_filter1d(hips, ROOT_SIGMA, axis=0, mode="nearest")


def across(positions: np.ndarray) -> np.ndarray:
    """From right to left through shoulders and hips: (left - right shoulder) + (left - right hip).

    positions : (..., 21, 3)  ->  (..., 3)
    """
    return (positions[..., SLOT["LeftArm"], :] - positions[..., SLOT["RightArm"], :]
            + positions[..., SLOT["LeftUpLeg"], :] - positions[..., SLOT["RightUpLeg"], :])


def facing(positions: np.ndarray) -> np.ndarray:
    r"""Where the body faces, as a unit vector on the floor plane:

        forward = across x up

    smoothed over time (a sway of the shoulders is not a turn) and normalised again. A frame that
    faces nowhere, its shoulders exactly opposite to its hips, takes what the frames about it say.

    positions : (T, 21, 3)  ->  (T, 2): x and z

    >>> body = np.zeros((3, 21, 3))
    >>> body[:, SLOT["LeftArm"], 0] = 20.0                           # the left side at +x
    >>> float(facing(body)[0, 1])                                    # forward is +z
    1.0
    """
    x, _, z = np.moveaxis(across(positions), -1, 0)
    forward = np.stack([-z, x], axis=1)
    size = np.linalg.norm(forward, axis=1, keepdims=True)
    forward = forward / np.where(size > 1e-9 * size.max(), size, np.inf)
    forward = gaussian_filter1d(forward, FACING_SIGMA, axis=0, mode="nearest")
    return forward / np.linalg.norm(forward, axis=1, keepdims=True)


def facing_yaw(positions: np.ndarray) -> np.ndarray:
    """The yaw of where the body faces, radians.   (T, 21, 3)  ->  (T,)"""
    forward = facing(positions)
    return np.arctan2(forward[:, 0], forward[:, 1])


def encode(positions: np.ndarray, floor: float | None = None) -> tuple[np.ndarray, Start]:
    r"""World positions at 60 frames a second to the 66 numbers.

        p_j^local = Y(-yaw) (p_j - root),   v_r[t] = Y(-yaw[t+1]) (root[t+1] - root[t]),
        turn[t] = yaw[t+1] - yaw[t]

    positions : (T, 21, 3), y up, any unit
    floor : its height, found by `floor_height` unless given
    ->  features (T, 66), Start.   Raises ValueError, see `checked_positions`.
    """
    positions = checked_positions(positions)
    floor = floor_height(positions) if floor is None else float(floor)
    root, yaw = root_path(positions), facing_yaw(positions)
    to_local = yaw_rotation(-yaw).swapaxes(1, 2)                                    # (T, 3, 3)
    origin = np.stack([root[:, 0], np.full(len(root), floor), root[:, 1]], axis=1)  # (T, 3)
    velocity = np.diff(origin, axis=0)[:, None] @ to_local[1:]                      # (T-1, 1, 3)

    features = np.zeros((len(positions), FEATURES))
    for n in range(0, len(positions), AT_A_TIME):
        some = slice(n, n + AT_A_TIME)
        local = (positions[some] - origin[some, None]) @ to_local[some]             # (n, 21, 3)
        features[some, POSITIONS] = local.reshape(len(local), -1)
    features[:-1, TURN] = nearest_turn(np.diff(yaw))
    features[:-1, FORWARD], features[:-1, SIDEWAYS] = velocity[:, 0, 2], velocity[:, 0, 0]
    features[-1, VELOCITIES] = features[-2:, VELOCITIES][0]          # a single frame stands still
    x, z = map(float, root[0])
    return features, Start(x, z, float(yaw[0]), floor)


def root_motion(features: np.ndarray, start: Start = Start()) -> tuple[np.ndarray, np.ndarray]:
    r"""Integrate the velocities:

        yaw[t+1] = yaw[t] + turn[t],    root[t+1] = root[t] + Y(yaw[t+1]) v_r[t]

    features : (T, 66)  ->  root (T, 3) on the floor, yaw (T,)

    >>> ahead = np.zeros((3, FEATURES))
    >>> ahead[:, FORWARD] = 2.0
    >>> root_motion(ahead)[0][:, 2]
    array([0., 2., 4.])
    """
    yaw = start.yaw + np.concatenate([[0.0], np.cumsum(features[:-1, TURN])])
    velocity = np.zeros((len(features), 3))
    velocity[1:, 0], velocity[1:, 2] = features[:-1, SIDEWAYS], features[:-1, FORWARD]
    velocity[1:] = (yaw_rotation(yaw[1:]) @ velocity[1:, :, None])[..., 0]
    return np.array([start.x, start.floor, start.z]) + np.cumsum(velocity, axis=0), yaw


def decode(features: np.ndarray, start: Start = Start()) -> np.ndarray:
    """The inverse of `encode`: the 66 numbers back to world positions.

    features : (T, 66);  start : what the numbers leave out  ->  (T, 21, 3)
    Raises ValueError on a wrong shape.
    """
    features = np.asarray(features, dtype=float)
    if features.ndim != 2 or features.shape[1] != FEATURES:
        raise ValueError(f"features: found shape {features.shape}, needed (frames, {FEATURES})")
    root, yaw = root_motion(features, start)
    return in_pieces(lambda some: placed(features[some], root[some], yaw[some]), len(features))


def placed(features: np.ndarray, root: np.ndarray, yaw: np.ndarray) -> np.ndarray:
    """World positions where `root_motion` has led.   (T, 66), (T, 3), (T,)  ->  (T, 21, 3)"""
    local = features[:, POSITIONS].reshape(len(features), JOINTS, 3)
    return local @ yaw_rotation(yaw).swapaxes(1, 2) + root[:, None]


def scale(features: np.ndarray, factor: float) -> np.ndarray:
    """The same motion of a character `factor` times as large; turning stays.

    features : (T, 66)  ->  (T, 66)

    >>> scale(np.ones((1, FEATURES)), 2.0)[0, [0, TURN, FORWARD]]
    array([2., 1., 2.])
    """
    scaled = features * factor
    scaled[:, TURN] = features[:, TURN]
    return scaled


def path_error(features: np.ndarray, content: np.ndarray) -> tuple[float, float]:
    """How far two root paths are apart when both begin alike.

    features, content : (T, 66)  ->  mean and largest distance over the frames, in their unit
    """
    here, there = (root_motion(f)[0][:, FLOOR["y"]] for f in (features, content))
    distance = np.linalg.norm(here - there, axis=1)
    return float(distance.mean()), float(distance.max())


def path_length(features: np.ndarray) -> float:
    """How long the way of the root is, in the features' unit.   features : (T, 66)  ->  float"""
    return float(np.linalg.norm(features[:-1, TRANSLATION], axis=1).sum())
