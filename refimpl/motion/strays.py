"""Rows of a clip that are not part of its motion: a rest pose before it begins, which many
exporters write, often at the origin, and single rows in which the capture lost the body.

Networks must not see them, since a jump of metres in one frame is a velocity that no body has. They
are left out, and written back as they were.
"""

from dataclasses import dataclass

import numpy as np

from .features import leg_length, mean_steps
from .ground import stretches
from .rotation import slerp

LEAP = 0.12                      # legs that joints move on average between two rows, at least
SUDDEN = 6.0                     # ... and so many times what they move in the rows about it
AROUND = 8                       # rows on each side
FEW = 3                          # rows that may be lost together
SECONDS = 2.5                    # that a rest pose at an end may last


@dataclass(frozen=True)
class Strays:
    """begin, end : of the rows that are motion;  lost : (rows,) bool, those within that are not"""

    begin: int
    end: int
    lost: np.ndarray

    def said(self) -> str:
        """In words, rows counted from 1; "" where every row is motion."""
        rows = len(self.lost)
        parts = ([f"1 to {self.begin}"] * (self.begin > 0)
                 + [f"{a + 1} to {b}" if b - a > 1 else f"{a + 1}" for a, b in stretches(self.lost)]
                 + [f"{self.end + 1} to {rows}"] * (self.end < rows))
        return (f"rows {', '.join(parts)} lie apart from the motion (a rest pose, a lost body): "
                "left as they are" if parts else "")


def find_strays(positions: np.ndarray, fps: float) -> Strays:
    """Where the joints leap, and which side of a leap is the motion.

    positions : (rows, 21, 3) at the file's own rate   ->  Strays
    """
    rows = len(positions)
    steps = mean_steps(positions) / leg_length(positions)
    leaps = [t + 1 for t in np.flatnonzero(steps > LEAP).tolist()
             if steps[t] > SUDDEN * max(np.median(steps[max(0, t - AROUND):t]) if t else 0.0,
                                        np.median(steps[t + 1:t + 1 + AROUND])
                                        if t + 1 < len(steps) else 0.0)]
    edges = [0, *leaps, rows]
    pieces = list(zip(edges, edges[1:]))
    core = max(range(len(pieces)), key=lambda n: pieces[n][1] - pieces[n][0])
    longest = SECONDS * fps
    begin, end = pieces[0][0], pieces[-1][1]
    before, after = pieces[core][0], rows - pieces[core][1]
    lost = np.zeros(rows, bool)
    if before <= longest and all(b - a > FEW or a == 0 for a, b in pieces[:core]):
        begin = before
    if after <= longest and all(b - a > FEW or b == rows for a, b in pieces[core + 1:]):
        end = pieces[core][1]
    for a, b in pieces:
        if begin < a and b < end and b - a <= FEW:
            lost[a:b] = True
    return Strays(begin, end, lost)


def bridged(rotations: np.ndarray, translations: np.ndarray,
            strays: Strays) -> tuple[np.ndarray, np.ndarray]:
    """The rows that are motion, lost ones made up between their neighbours.

    rotations (rows, J, 3, 3), translations (rows, J, 3)  ->  the same, rows `begin` to `end`
    """
    rotations, translations = rotations.copy(), translations.copy()
    for a, b in stretches(strays.lost):
        t = np.linspace(0, 1, b - a + 2)[1:-1, None]
        rotations[a:b] = slerp(rotations[[a - 1]], rotations[[b]], t)
        translations[a:b] = translations[a - 1] + t[..., None] * (translations[b]
                                                                  - translations[a - 1])
    return rotations[strays.begin:strays.end], translations[strays.begin:strays.end]
