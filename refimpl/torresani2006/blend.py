r"""Blends that do not pop: the space-time interpolation of section 5 (`align.interpolate`) along a
time curve whose slope is limited, with a guard on what comes out.

The path of equation 3 may let one motion wait for any number of frames of the other; where it is
then read again, it runs through these frames at once. Here, for the time curve alone (SSD is
equation 3's still):

1. No motion runs more than three times as fast as the other (`limited_path`: registration curves,
   Kovar and Gleicher 2003; "symmetricP05", Sakoe and Chiba 1978). Where their lengths allow no such
   path, equation 3's is taken.
2. A blend's peak acceleration, of any joint in any frame, stays within twice the larger of its
   parents'. Where it would not, the time curve is drawn half or all the way to the straight line,
   and where that is not enough the blend is slowed down.

What was done is told by `Blend`, and an experiment counts it.
"""

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from .align import SMOOTH, AlignError, distances, dtw, interpolate
from .poses import POSE_FPS, Body, Fragment, fragment_positions

STEEPEST = 3
PEAK = 2.0
STRAIGHT = 0.0, 0.5, 1.0


@dataclass(frozen=True)
class Blend:
    """A blend, and what it took.

    limited : whether the path could be limited in slope;  straight : how far the time curve was
    drawn to the straight line, from 0 to 1;  slower : by which factor it was slowed down;
    peak : its largest acceleration beside the larger of its parents'.
    """

    fragment: Fragment = field(repr=False)
    limited: bool
    straight: float
    slower: float
    peak: float


def limited_path(X: np.ndarray, Y: np.ndarray, steepest: int = STEEPEST) -> np.ndarray | None:
    r"""The path of least cost on which neither motion runs more than `steepest` times as fast as
    the other: equation 3 with these steps alone, each at the cost of every cell that it enters,

        (1, 1);   (1, 1) and then (0, 1) once, or up to `steepest` - 1 times;   likewise (1, 0).

    X : (P, D), Y : (Q, D)   ->  (L, 2) as of `align.dtw`, None where their lengths allow none

    >>> limited_path(np.array([[0.0], [0.0], [0.0], [9.0]]), np.array([[0.0], [9.0]])).tolist()
    [[0, 0], [1, 1], [2, 1], [3, 1]]
    """
    d = distances(X, Y)
    P, Q = d.shape
    along = np.concatenate([np.zeros((P, 1)), np.cumsum(d, axis=1)], axis=1)
    down = np.concatenate([np.zeros((1, Q)), np.cumsum(d, axis=0)])
    steps = [(1, 1), *((1, k) for k in range(2, steepest + 1)),
             *((k, 1) for k in range(2, steepest + 1))]
    C, taken = np.full((P, Q), np.inf), np.zeros((P, Q), dtype=int)
    C[0, 0] = d[0, 0]
    for p in range(1, P):
        ways = np.full((len(steps), Q), np.inf)
        for way, (i, j) in zip(ways, steps):
            if i <= p and j < Q:
                entered = along[p, j + 1:] - along[p, 1:Q - j + 1] if i == 1 else (
                    down[p + 1, j:] - down[p + 1 - i, j:])
                way[j:] = C[p - i, :Q - j] + entered
        taken[p] = ways.argmin(axis=0)
        C[p] = ways.min(axis=0)
    if not np.isfinite(C[-1, -1]):
        return None
    p, q, path = P - 1, Q - 1, []
    while p or q:
        i, j = steps[taken[p, q]]
        path += [(p - min(k, i - 1), q - min(k, j - 1)) for k in range(max(i, j))]
        p, q = p - i, q - j
    return np.array([*path, (0, 0)][::-1])


def peak_acceleration(fragment: Fragment, body: Body) -> float:
    """The largest acceleration of any joint in any frame, by differences of its places, in their
    unit per second squared; 0 for fewer than three frames.
    """
    second = np.diff(fragment_positions(fragment, body), 2, axis=0)
    return float(np.linalg.norm(second, axis=-1).max(initial=0.0)) * fragment.fps ** 2


def blend(a: Fragment, b: Fragment, alpha: float, body: Body, peak: float = PEAK) -> Blend:
    """A blend of two fragments of one content that does not pop.

    alpha : in [-0.25, 1.25], 0 for a and 1 for b;  peak : how many times the larger parent's its
    acceleration may be.   Raises AlignError as `align.interpolate` does.

    >>> from refimpl.torresani2006.database import embedded_database
    >>> database = embedded_database(2)
    >>> blend(*database.fragments[:2], 0.5, database.body).limited
    True
    """
    if a.angles.shape[1:] != b.angles.shape[1:]:
        raise AlignError(f"{a.name}, {b.name}: found angles of shapes {a.angles.shape} and "
                         f"{b.angles.shape}, needed those of one skeleton")
    path = limited_path(a.angles, b.angles)
    made = partial(interpolate, a, b, alpha, dtw(a.angles, b.angles)[1] if path is None else path,
                   body.up, SMOOTH * a.fps / POSE_FPS)
    larger = max(peak_acceleration(a, body), peak_acceleration(b, body), 1e-9)
    slower = 1.0
    for straight in STRAIGHT:
        fragment = made(straight=straight)
        found = peak_acceleration(fragment, body) / larger
        if found <= peak:
            break
    while found > peak and slower < 9:
        slower *= 1.05 * np.sqrt(found / peak)
        fragment = made(straight=straight, slower=slower)
        found = peak_acceleration(fragment, body) / larger
    return Blend(fragment, path is not None, straight, float(slower), float(found))


def smooth(a: Fragment, b: Fragment, alpha: float, body: Body) -> Fragment:
    """The blend alone, see `blend`."""
    return blend(a, b, alpha, body).fragment


def as_printed(a: Fragment, b: Fragment, alpha: float, body: Body) -> Fragment:
    """Section 5 along the path of equation 3, whatever pops."""
    return interpolate(a, b, alpha, up=body.up)
