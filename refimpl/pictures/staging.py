"""Who stands where and in which colour: what still and moving pictures share."""

from collections.abc import Collection

import numpy as np

from ..motion.features import facing
from ..motion.joints import SLOT

# By Okabe and Ito, told apart by the colour-blind too.
COLOURS = {"style": "#D55E00", "content": "#009E73", "result": "#0072B2"}
OTHERS = ("#CC79A7", "#E69F00", "#56B4E9", "#444444", "#0072B2", "#009E73", "#D55E00")


def colours(labels: Collection[str]) -> dict[str, str]:
    """A colour for each label: style, content and result have their own, others take what is left.

    >>> colours(["content", "mine"])
    {'content': '#009E73', 'mine': '#CC79A7'}
    """
    own = {label: COLOURS[label] for label in labels if label in COLOURS}
    rest = iter([c for c in OTHERS if c not in own.values()] * (1 + len(labels)))
    return {label: own[label] if label in own else next(rest) for label in labels}


def round_length(length: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is not above a length.

    >>> float(round_length(104.0)), float(round_length(0.6))
    (100.0, 0.5)
    """
    power = 10.0 ** np.floor(np.log10(length))
    return power * max(step for step in (1, 2, 5) if step * power <= length * (1 + 1e-9))


def turned_forward(pose: np.ndarray) -> np.ndarray:
    """The rotation about y after which a pose faces +z; the identity where it faces nowhere.

    pose : (21, 3)  ->  (3, 3), to multiply rows of positions from the right
    """
    with np.errstate(invalid="ignore"):
        s, c = facing(pose[None])[0]                             # sine and cosine of the yaw
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) if np.isfinite(s + c) else np.eye(3)


def facing_forward(positions: np.ndarray) -> np.ndarray:
    """The motion turned and moved over the floor: its first pose faces +z above the origin.

    positions : (T, 21, 3)  ->  (T, 21, 3)
    """
    return (positions - positions[0, SLOT["Hips"]] * [1, 0, 1]) @ turned_forward(positions[0])
