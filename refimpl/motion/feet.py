"""Feet: which are planted, and how well they stand. Do planted ones slide, do any sink into the
floor, does a clean-up make them pop?

All lengths are in the unit of the positions. A label at frame t covers the step from t to t + 1, as
in equation 7 of Holden et al.
"""

from collections.abc import Iterable

import numpy as np

from .features import (FEATURES, FLOOR, FORWARD, POSITIONS, SIDEWAYS, TURN, checked_positions,
                       floor_height, leg_length)
from .joints import FEET, JOINTS

# A foot is planted while it is slow and low. In leg lengths (thigh + shin = 80.07 cm on the clips
# where these were measured: squared speed below 1.5 cm^2 / frame^2, ankle below 11 cm, ball of the
# foot below 3 cm, above the lowest resting toe).
CONTACT_SPEED2 = 1.5 / 80.07 ** 2
CONTACT_HEIGHTS = np.array([11.0, 3.0, 11.0, 3.0]) / 80.07


def foot_contacts(positions: np.ndarray, floor: float | None = None) -> np.ndarray:
    r"""Which feet are planted in each frame: slow and low, in units of the character's leg.

        planted_j[t] = |p_j[t+1] - p_j[t]|^2 < 2.3e-4 leg^2
                       and  y_j[t] - floor < 0.14 leg (heel), 0.037 leg (toe)

    positions : (T, 21, 3) at 60 frames a second, y up
    floor : its height, found by `floor_height` unless given
    ->  (T, 4) bool in the order of `joints.FEET`; the last row repeats the one before
    """
    floor = floor_height(positions) if floor is None else floor
    leg = leg_length(positions)
    feet = positions[:, FEET]                        # (T, 4, 3)
    speed2 = np.zeros(feet.shape[:2])
    speed2[:-1] = np.sum(np.diff(feet, axis=0) ** 2, axis=-1)
    planted = (speed2 < CONTACT_SPEED2 * leg ** 2) & (feet[..., 1] - floor < CONTACT_HEIGHTS * leg)
    planted[-1] = planted[-2:][0]
    return planted


def checked_contacts(contacts: np.ndarray, frames: int) -> np.ndarray:
    """Contact labels as bools, or a ValueError on a wrong shape or on labels other than 0 and 1.

    contacts : (T, 4);  frames : the T that is needed   ->  (T, 4) bool

    >>> checked_contacts([[1, 0, 0, 1]], 1)
    array([[ True, False, False,  True]])
    """
    contacts = np.asarray(contacts)
    if contacts.shape != (frames, len(FEET)):
        raise ValueError(f"contacts: found shape {contacts.shape}, needed ({frames}, {len(FEET)}): "
                         "one row a frame, left heel, left toe, right heel, right toe")
    known = np.isin(contacts, (0, 1))
    if not known.all():
        raise ValueError(f"contacts: found {contacts[~known][0]}, needed labels 0 and 1 "
                         "(False and True)")
    return contacts.astype(bool)


def foot_skate(positions: np.ndarray, contacts: np.ndarray, *, fps: float = 60.0) -> float:
    r"""Mean horizontal speed of planted feet:

        skate = fps * mean over planted (t, j) of |(x, z)_j[t+1] - (x, z)_j[t]|

    positions : (T, 21, 3) in the world, y up;  contacts : (T, 4) in the order of `joints.FEET`
    ->  length / s; nan when nothing is planted

    >>> sliding = np.zeros((3, JOINTS, 3)) + np.arange(3.0)[:, None, None] * [0.1, 0, 0]
    >>> round(foot_skate(sliding, np.ones((3, 4))), 6)
    6.0
    """
    positions = checked_positions(positions)
    planted = checked_contacts(contacts, len(positions))[:-1]
    steps = np.diff(positions[:, FEET][..., FLOOR["y"]], axis=0)
    speed = fps * np.linalg.norm(steps, axis=-1)     # (T-1, 4)
    return float(speed[planted].mean()) if planted.any() else float("nan")


def floor_penetration(positions: np.ndarray, floor: float = 0.0, *, heel_height: float = 0.0,
                      toe_height: float = 0.0) -> tuple[float, float]:
    r"""How deep the feet sink into the floor: in each frame the deepest of the four foot joints,

        depth[t] = max(0, max over j of floor + rest_j - y_j[t])

    A joint rests above the sole. `features.floor_height` (`take.start.floor`) is already the height
    of a resting toe joint, so that the heights to add are 0 (a heel joint must not sink below
    resting toes either); with the true floor of a skeleton give its own (4.25 and 11.74 cm on the
    Bandai skeleton).

    positions : (T, 21, 3), y up;  floor : its y
    heel_height, toe_height : of the resting joints above it
    ->  mean over the frames, largest

    >>> floor_penetration(np.zeros((2, JOINTS, 3)), 3.0)
    (3.0, 3.0)
    """
    rest = floor + np.array([heel_height, toe_height] * 2)
    heights = checked_positions(positions)[:, FEET, 1] - rest
    depth = np.maximum(0.0, -heights).max(axis=1)
    return float(depth.mean()), float(depth.max())


def jerk(positions: np.ndarray, joints: Iterable[int] = FEET, *, fps: float = 60.0,
         recorded: float | None = None) -> float:
    """Root of the mean square third difference of some joints, the mark of a motion that pops.

    positions : (T, 21, 3);  fps : frames a second
    recorded : the rate that the motion was recorded at, where it is lower: then frames of that rate
        are taken, for between them the motion was made up, and what was made up has the jerk of the
        curve that made it
    ->  length / s^3, nan below 4 frames

    >>> cubic = np.zeros((5, JOINTS, 3)) + np.arange(5.0)[:, None, None] ** 3 * [1, 0, 0]
    >>> jerk(cubic, fps=1.0)                         # the third derivative of t^3
    6.0
    """
    every = max(1, round(fps / recorded)) if recorded else 1
    taken = checked_positions(positions)[::every, list(joints)]
    third = np.diff(taken, n=3, axis=0) * (fps / every) ** 3
    return float(np.sqrt(np.mean(np.sum(third ** 2, axis=-1)))) if len(third) else float("nan")


def pace(features: np.ndarray, contacts: np.ndarray) -> float:
    r"""How fast a motion should move on so that its planted feet slide least: the factor k of its
    root's velocity in

        minimise  sum over planted (t, j) of || k v_r + u_j ||^2,
        u_j = omega x p_j + p_j[t+1] - p_j[t]     =>     k = - sum v_r . u / sum v_r . v_r

    features : (T, 66), contacts : (T, 4)
    ->  k, 1 where nothing is planted or moves on, and never below 0
    """
    if features.shape[1:] != (FEATURES,):
        raise ValueError(f"features: found shape {features.shape}, needed (frames, {FEATURES})")
    planted = checked_contacts(contacts, len(features))[:-1]
    p = features[:, POSITIONS].reshape(len(features), JOINTS, 3)[:, FEET]
    x, z = p[:-1, :, 0], p[:-1, :, 2]
    turn = features[:-1, TURN, None]
    u = np.diff(p, axis=0)[..., FLOOR["y"]] + np.stack([turn * z, -turn * x], axis=-1)
    v = features[:-1, None, [SIDEWAYS, FORWARD]]     # (T-1, 1, 2), and u (T-1, 4, 2)
    moving = float(np.sum(planted * np.sum(v * v, axis=-1)))
    if not moving > 0:
        return 1.0
    return max(0.0, -float(np.sum(planted * np.sum(v * u, axis=-1))) / moving)
