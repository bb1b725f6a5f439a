"""What no body does, in words: why not to trust a clip that can be read all the same.

A file may lie on its side, stand on its head, have a wrong Frame Time or jump from place to place,
and still be a motion for whoever knows why. So it is told and not refused.
"""

import numpy as np

from .features import bone_lengths, leg_length, mean_steps
from .joints import HEELS, SLOT

LEANS = 0.75                     # share of the way from ankles to head that leads up, at least
LEAPS, FAST = 0.5, 0.2            # legs that joints move in 1/60 s: once, and usually
BONES_OF = 3.0, 30.0             # legs that a bone may have, and middle bones that a leg may have
CLIMB = 6.0                      # legs between the lowest and the highest place of the hips
SPIN = 0.3                       # radians that the body usually turns in one
RECORDED_AT = 10.0, 250.0              # frames a second of recordings
DECIMALS = 1e-3, 1e5                 # lengths of a leg that files keep enough decimals of


def doubts(positions: np.ndarray, turn: np.ndarray, fps: float, up: str) -> tuple[str, ...]:
    """What is odd about a motion.

    positions : (T, 21, 3) at 60 frames a second, y up;  turn : (T,) radians a frame
    fps : frames a second of the file;  up : the axis of the file that was taken for up

    >>> body = np.ones((2, 21, 1)) * [0.0, 1.0, 0.0] * np.arange(21.0)[:, None]
    >>> doubts(body, np.zeros(2), 60.0, "y")[0]
    'no joint moves in any frame'
    """
    found, leg = [], leg_length(positions)
    rise = (positions[:, SLOT["Head"]] - positions[:, HEELS].mean(axis=1)).mean(axis=0)
    steps = mean_steps(positions) / leg
    if up.startswith("-"):
        found.append(f"its head is below its feet: taken as a file in which {up} is up")
    if rise[1] < LEANS * np.linalg.norm(rise):
        angle = np.degrees(np.arccos(rise[1] / np.linalg.norm(rise)))
        found.append(f"its head is {angle:.0f} degrees from straight above its ankles on average: "
                     "does it lie, or is another axis up?")
    if len(steps) and steps.max() > LEAPS:
        found.append(f"its joints leap by {steps.max():.3g} legs in a sixtieth of a second (at "
                     f"{steps.argmax() / 60:.2f} s), as no body does")
    elif len(steps) and (np.median(steps) > FAST or np.median(np.abs(turn)) > SPIN):
        found.append(f"its joints move by {np.median(steps):.2g} legs in every sixtieth of a "
                     "second, as no body does: is the Frame Time right?")
    if len(steps) and not steps.max() > 1e-9:
        found.append("no joint moves in any frame")
    if np.ptp(positions[:, SLOT["Hips"], 1]) > CLIMB * leg:
        found.append(f"its hips climb {np.ptp(positions[:, SLOT['Hips'], 1]) / leg:.3g} legs")
    bones = bone_lengths(positions)
    if bones.max() > BONES_OF[0] * leg or leg > BONES_OF[1] * np.median(bones):
        found.append(f"its bones are from {bones.min():.3g} to {bones.max():.3g} long beside a leg "
                     f"of {leg:.3g}")
    if not RECORDED_AT[0] <= fps <= RECORDED_AT[1]:
        found.append(f"it has {fps:g} frames a second, as few recordings have: is the Frame Time "
                     "right?")
    if not DECIMALS[0] <= leg <= DECIMALS[1]:
        found.append(f"a leg is {leg:.3g} long: does the file keep enough decimals?")
    return tuple(found)
