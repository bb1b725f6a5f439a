r"""The 73 numbers of a frame of the 2016 code, its windows and its normaliser (`export.py`,
`train.py`).

| slice      | numbers | meaning                                                                 |
| ---------- | ------- | ----------------------------------------------------------------------- |
| `POINTS`   | 0..65   | 22 points (x, y, z) in the character's frame: the reference joint,      |
|            |         | which is always 0, then the 21 joints                                   |
| `VELOCITY` | 66, 67  | of the root, x (to the left) and z (forward), seen from the frame that  |
|            |         | it leads to                                                             |
| `TURN`     | 68      | **minus** the turning from this frame to the next, in radians           |
| `CONTACTS` | 69..72  | 1 where a foot is planted: left heel, left toe, right heel, right toe   |

Lengths are in the code's unit, of which a leg has 14.8 and the hips 17.00 above the floor: 5.4 cm.
A clip of n frames gives n - 1 rows, since a row leads to the next frame. `features` has the 66
numbers of 2017; what differs besides the order is said at each function.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ..motion.bvh import read_bvh
from ..motion.features import FACING_SIGMA, FPS, root_path
from ..motion.joints import FEET, JOINTS, SLOT, TOES
from ..motion.mapping import map_clip
from ..motion.rotation import yaw_rotation
from ..motion.skeleton import clip_at, forward_kinematics, local_pose

REFERENCE = slice(0, 3)
POSITIONS = slice(3, 3 + 3 * JOINTS)                             # of the 21 joints
POINTS = slice(0, POSITIONS.stop)
VELOCITY = slice(POINTS.stop, POINTS.stop + 2)
TURN = VELOCITY.stop
TRAJECTORY = slice(VELOCITY.start, TURN + 1)                     # velocity and turning
CONTACTS = slice(TRAJECTORY.stop, TRAJECTORY.stop + 4)
NUMBERS = CONTACTS.stop
# Which of the 73 each of the 66 numbers of 2017 is, and its sign.
ORDER = np.concatenate([np.arange(POSITIONS.start, POSITIONS.stop),
                        [TURN, VELOCITY.start + 1, VELOCITY.start]])
SIGN = np.where(ORDER == TURN, -1.0, 1.0)

WINDOW, STEP, SHORTEST = 240, 120, 30                            # frames
SLOW, HEEL_HEIGHT, TOE_HEIGHT = 0.05, 3.0, 2.0                   # units^2/frame^2; above the floor
SHARE = 0.9                                                      # of deviations, `fit_normaliser`
HIPS_HEIGHT = 17.0                                               # mean of its authors' normaliser
# Standing hips over thigh + shin, on bodies as different as an actor's and a made one.
HIPS_PER_LEG = 1.12


def read_points(path: str, overrides: dict[str, str] | None = None) -> np.ndarray:
    """The 21 joints of a BVH file in the world at 60 frames a second, in the file's unit.

    Of a file of 120 frames a second every second one is taken, as the code does with whatever it
    gets; another rate is brought to 60 (a choice).

    path : of the BVH file
    overrides : {slot: joint name} of a mapping file
    ->  (T, 21, 3)
    """
    clip = read_bvh(path)
    if abs(clip.fps - 2 * FPS) < 0.5:
        rotations, roots = (part[::2] for part in local_pose(clip))
    else:
        rotations, roots = clip_at(clip, FPS)
    mapping = map_clip(clip, overrides, str(path))
    return mapping.positions(*forward_kinematics(clip.parents, rotations, roots))


def floor_height(positions: np.ndarray) -> float:
    r"""A soft minimum over time of the lower toe's height h (`export.py`):

        floor = min h - ln(1/2 + exp(min h - max h))

    It lies up to 0.69 units above the lowest toe where the toe rises high, up to 0.41 below it
    where it does not, and depends on the unit. The code means all four feet; its indices are used
    before the reference joint is put in front, so that two of them are toes (the others are an
    upper leg and the spine, never the lowest).

    positions : (T, 21, 3)  ->  height, in their unit

    >>> round(floor_height(np.zeros((5, 21, 3))), 4)                 # - ln(3/2)
    -0.4055
    """
    lower = positions[:, TOES, 1].min(axis=1)
    return float(lower.min() - np.log(0.5 + np.exp(lower.min() - lower.max())))


def facing(positions: np.ndarray) -> np.ndarray:
    r"""Where the body faces, on the floor plane (`export.py`):

        across = (left shoulder - right shoulder) + (left hip - right hip), of length 1 in space
        forward = across x up, smoothed over time, then of length 1

    `features.facing` makes forward of length 1 before it smooths: up to 1.5e-4 radians apart.

    positions : (T, 21, 3)  ->  (T, 2): x and z

    >>> pose = np.zeros((1, 21, 3))
    >>> pose[:, SLOT["LeftArm"], 0] = 18.0                           # its left at +x
    >>> (facing(pose) + 0.0).tolist()
    [[0.0, 1.0]]
    """
    across = (positions[:, SLOT["LeftArm"]] - positions[:, SLOT["RightArm"]]
              + positions[:, SLOT["LeftUpLeg"]] - positions[:, SLOT["RightUpLeg"]])
    across = across / np.linalg.norm(across, axis=1, keepdims=True)
    forward = np.stack([-across[:, 2], across[:, 0]], axis=1)
    forward = gaussian_filter1d(forward, FACING_SIGMA, axis=0, mode="nearest")
    return forward / np.linalg.norm(forward, axis=1, keepdims=True)


def foot_contacts(positions: np.ndarray, floor: float) -> np.ndarray:
    r"""Which feet are planted (`export.py`): slow and low, in the code's unit.

        |p[t+1] - p[t]|^2 < 0.05   and   y[t] - floor < 3.0 (heel), 2.0 (toe)

    positions : (T, 21, 3)  ->  (T - 1, 4) bool

    >>> foot_contacts(np.full((2, 21, 3), 2.5), floor=0.0).tolist()
    [[True, False, True, False]]
    """
    feet = positions[:, FEET]
    speed2 = np.sum(np.diff(feet, axis=0) ** 2, axis=-1)
    height = feet[:-1, :, 1] - floor
    return (speed2 < SLOW) & (height < np.array([HEEL_HEIGHT, TOE_HEIGHT] * 2))


def encode(positions: np.ndarray) -> np.ndarray:
    r"""World positions at 60 frames a second to the 73 numbers (`export.py`, process_file).

        p_local = Y(-yaw) (p - root),   v[t] = Y(-yaw[t+1]) (root[t+1] - root[t]),
        row 68 = -(yaw[t+1] - yaw[t])

    positions : (T, 21, 3) in the code's unit, y up  ->  (T - 1, 73)
    Raises ValueError.

    >>> encode(np.random.default_rng(0).normal(size=(5, 21, 3))).shape
    (4, 73)
    """
    positions = np.asarray(positions, dtype=float)
    if positions.ndim != 3 or positions.shape[1:] != (JOINTS, 3) or len(positions) < 2:
        raise ValueError(f"positions: found shape {positions.shape}, needed (frames, {JOINTS}, 3) "
                         "with at least two frames")
    if not np.isfinite(positions).all():
        raise ValueError("positions: found a value that is not finite, needed finite positions")
    floor, path, forward = floor_height(positions), root_path(positions), facing(positions)
    yaw = np.arctan2(forward[:, 0], forward[:, 1])
    to_local = yaw_rotation(-yaw)                                # (T, 3, 3)
    root = np.stack([path[:, 0], np.full(len(path), floor), path[:, 1]], axis=1)
    local = (positions - root[:, None]) @ to_local.swapaxes(1, 2)
    velocity = (to_local[1:] @ np.diff(root, axis=0)[:, :, None])[..., 0]
    rows = np.zeros((len(positions) - 1, NUMBERS))
    rows[:, POSITIONS] = local[:-1].reshape(len(rows), -1)
    rows[:, VELOCITY] = velocity[:, [0, 2]]
    rows[:, TURN] = -((np.diff(yaw) + np.pi) % (2 * np.pi) - np.pi)
    rows[:, CONTACTS] = foot_contacts(positions, floor)
    return rows


def decode(rows: np.ndarray) -> np.ndarray:
    r"""The way back (`AnimationPlot.py`), from place and heading 0: first the turn, then the step.

    rows : (T, 73)  ->  (T, 22, 3): the reference joint, which is the smoothed root on the floor,
    and 21 joints

    >>> forward = np.zeros((3, NUMBERS))
    >>> forward[:, VELOCITY] = [0.0, 2.0]
    >>> decode(forward)[:, 0, 2].tolist()
    [0.0, 2.0, 4.0]
    """
    rows = np.asarray(rows, dtype=float)
    yaw = -np.concatenate([[0.0], np.cumsum(rows[:-1, TURN])])
    step = np.zeros((len(rows), 3))
    step[1:, [0, 2]] = rows[:-1, VELOCITY]
    turned = yaw_rotation(yaw)
    root = np.cumsum((turned @ step[:, :, None])[..., 0], axis=0)
    points = rows[:, POINTS].reshape(len(rows), -1, 3) @ turned.swapaxes(1, 2)
    return points + root[:, None]


def windows(rows: np.ndarray, length: int = WINDOW, step: int = STEP) -> np.ndarray:
    """Windows of one length (`export.py`): one begins every `step` rows while more than 30 remain.

    A window longer than what is left of the clip is padded on both sides with its first and last
    row, the odd row on the left, velocities 0 in the padding. The clip's own last row keeps its
    velocity (`motion.windows.windows` sets it to 0, and ends its last window with the clip).

    rows : (T, 73)  ->  (N, length, 73), N = 0 for 30 rows or fewer

    >>> windows(np.zeros((300, NUMBERS))).shape
    (3, 240, 73)
    """
    made = []
    for begin in range(0, len(rows) - SHORTEST, step):
        piece = rows[begin:begin + length]
        missing = length - len(piece)
        before = (missing + 1) // 2
        window = np.pad(piece, ((before, missing - before), (0, 0)), mode="edge")
        window[:before, TRAJECTORY] = 0.0
        window[before + len(piece):, TRAJECTORY] = 0.0
        made.append(window)
    return np.stack(made) if made else np.zeros((0, length, rows.shape[1]))


@dataclass(frozen=True)
class Normaliser:
    """What is subtracted from each of the 73 numbers and what it is divided by.

    mean, deviation : (73,)

    >>> halves = Normaliser(np.zeros(NUMBERS), np.full(NUMBERS, 0.5))
    >>> X = halves.apply(np.ones((4, NUMBERS)))
    >>> X.shape, float(X[0, 0]), float(halves.undo(X)[0, 0])
    ((73, 4), 2.0, 1.0)
    """

    mean: np.ndarray = field(repr=False)
    deviation: np.ndarray = field(repr=False)

    def apply(self, rows: np.ndarray) -> np.ndarray:
        """(..., T, 73) in units  ->  (..., 73, T) normalised, as the network takes it"""
        return np.swapaxes((rows - self.mean) / self.deviation, -1, -2)

    def undo(self, X: np.ndarray) -> np.ndarray:
        """The inverse of `apply`.   (..., 73, T)  ->  (..., T, 73)"""
        return np.swapaxes(X, -1, -2) * self.deviation + self.mean


def fit_normaliser(windows: np.ndarray) -> Normaliser:
    r"""Mean and standard deviation of the training windows (`train.py`).

    Mean: of each number; velocities and turning 0, contacts 0.5. Deviation: of *all 73 numbers of
    all frames together* for positions, so that the distances between the joints count; 0.9 of it
    for the feet; 0.9 of that of the two velocities together; 0.9 of that of the turning; contacts
    0.5.

    windows : (N, T, 73)
    Raises ValueError.

    >>> fit_normaliser(np.ones((1, 4, NUMBERS))).mean[[POSITIONS.start, TURN, CONTACTS.start]]
    array([1. , 0. , 0.5])
    """
    windows = np.asarray(windows, dtype=float)
    if windows.ndim != 3 or windows.shape[2] != NUMBERS or not windows.size:
        raise ValueError(f"windows: found shape {windows.shape}, needed (N, frames, {NUMBERS}) "
                         "with at least one window")
    mean = windows.mean(axis=(0, 1))
    mean[TRAJECTORY], mean[CONTACTS] = 0.0, 0.5
    deviation = np.full(NUMBERS, windows.std())
    for foot in FEET:
        deviation[POSITIONS.start + 3 * foot:POSITIONS.start + 3 * foot + 3] *= SHARE
    deviation[VELOCITY] = SHARE * windows[..., VELOCITY].std()
    deviation[TURN] = SHARE * windows[..., TURN].std()
    deviation[CONTACTS] = 0.5
    still = deviation <= 0                                       # never moves or turns (a choice)
    return Normaliser(mean, np.where(still, deviation.max(), deviation))
