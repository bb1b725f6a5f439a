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

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from ..motion.body import make_take
from ..motion.canonical import change
from ..motion.clip import Clip
from ..motion.features import FPS
from ..motion.feet import foot_skate
from ..motion.foot_ik import lock_feet
from ..motion.moved import moved_clip, rig
from .align import SMOOTH, AlignError, distances, dtw, interpolate, synchronised
from .poses import (POSE_FPS, POSITION, Body, Fragment, clip_of, fit_body, fragment_of,
                    fragment_positions, size_ratio)

STEEPEST = 3
PEAK = 2.0
DRAWN = 0.0, 0.5, 1.0


@dataclass(frozen=True)
class Blend:
    """A blend, and what it took.

    limited : whether the path could be limited in slope;  straight : how far the time curve was
    drawn to the straight line, from 0 to 1;  slower : by which factor it was slowed down;
    peak : its largest acceleration, feet held, beside the larger of its parents';
    times : the frame of the one and of the other parent that each of its frames is made of.
    """

    fragment: Fragment = field(repr=False)
    limited: bool
    straight: float
    slower: float
    peak: float
    times: tuple[np.ndarray, ...] = field(repr=False)


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


def steady_blend(a: Fragment, b: Fragment, alpha: float, body: Body, peak: float = PEAK) -> Blend:
    """A blend of two fragments of one content that does not pop.

    alpha : in [-0.25, 1.25], 0 for a and 1 for b;  peak : how many times the larger parent's its
    acceleration may be.   Raises AlignError as `align.interpolate` does.

    >>> from refimpl.torresani2006.database import embedded_database
    >>> database = embedded_database(2)
    >>> steady_blend(*database.fragments[:2], 0.5, database.body).limited
    True
    """
    if a.angles.shape[1:] != b.angles.shape[1:]:
        raise AlignError(f"{a.name}, {b.name}: found angles of shapes {a.angles.shape} and "
                         f"{b.angles.shape}, needed those of one skeleton")
    path = limited_path(a.angles, b.angles)
    along = dtw(a.angles, b.angles)[1] if path is None else path
    width = SMOOTH * a.fps / POSE_FPS
    made = partial(interpolate, a, b, alpha, along, body.up, width)
    larger = max(peak_acceleration(a, body), peak_acceleration(b, body), 1e-9)
    slower = 1.0
    for straight in DRAWN:
        fragment = made(straight=straight)
        found = peak_acceleration(fragment, body) / larger
        if found <= peak:
            break
    while found > peak and slower < 9:
        slower *= 1.05 * np.sqrt(found / peak)
        fragment = made(straight=straight, slower=slower)
        found = peak_acceleration(fragment, body) / larger
    return Blend(fragment, path is not None, straight, float(slower), float(found),
                 synchronised(along, alpha, width, straight, slower))


def smooth(a: Fragment, b: Fragment, alpha: float, body: Body) -> Fragment:
    """The blend alone, see `steady_blend`."""
    return steady_blend(a, b, alpha, body).fragment


def as_printed(a: Fragment, b: Fragment, alpha: float, body: Body) -> Fragment:
    """Section 5 along the path of equation 3, whatever pops."""
    return interpolate(a, b, alpha, up=body.up)


def standing(clip: Clip, contacts: np.ndarray | None = None, least: float = 0.0) -> tuple[
        Clip, float, float]:
    """A clip whose planted feet stay where they are (`motion.foot_ik`), if they slide.

    contacts : (T, 4) which feet are planted, at 60 frames a second, found in the clip unless given;
    least : what is slid without being mended, in the file's unit a second
    ->  the clip, how far its planted feet slid before, and now: that unit a second, both NaN for a
    body without feet, which is left as it is
    """
    try:
        take = make_take(clip)
    except ValueError:
        return clip, float("nan"), float("nan")
    labels = take.contacts if contacts is None else contacts
    before = foot_skate(take.positions, labels)
    if not before > least:
        return clip, before, before
    locked = lock_feet(take.positions, labels, take.rests[1::2], heels=take.rests[::2])
    moved = moved_clip(take, rig(clip.joints, take.mapping), change(take.positions, locked))
    return moved, before, foot_skate(make_take(moved).positions, labels)


def blend_clips(A: Clip, B: Clip, alpha: float) -> tuple[Clip, Blend, float, float]:
    """Two clips of one skeleton and one action to one, at the higher of their frame rates, on a
    body between both. Where feet that are planted in the parent that counts more (of equal ones,
    in that which stands longer) slide more than a tenth beyond what the parents' do, they are held,
    unless a joint then accelerates more than twice as much as in the parents.

    ->  the clip, what the blend took, how far planted feet slid before they were kept, and now.
    Raises PoseError, AlignError.
    """
    body, fps = fit_body([A, B]), max(A.fps, B.fps)
    a, b = (fragment_of(clip, body, name, fps=fps) for clip, name in ((A, "A"), (B, "B")))
    made = steady_blend(a, b, alpha, body)
    bones, offsets = ((1 - alpha) * np.asarray(a) + alpha * np.asarray(b) for a, b in (
        (fit_body([A]).bones, fit_body([B]).bones),
        [[joint.offset for joint in clip.joints] for clip in (A, B)]))
    own = replace(body, bones=bones, joints=tuple(
        replace(joint, offset=tuple(offset)) for joint, offset in zip(A.joints, offsets.tolist())))
    root = made.fragment.root.copy()
    root[:, POSITION] *= size_ratio(own, body)
    clip = clip_of(replace(made.fragment, root=root), own)
    try:
        takes = [make_take(parent) for parent in (A, B)]
        frames = len(make_take(clip).positions)
    except ValueError:
        return clip, made, float("nan"), float("nan")
    labels = [take.contacts[np.minimum(np.rint(np.interp(np.arange(frames) * fps / FPS, np.arange(
        len(times)), times) * FPS / fps).astype(int), len(take.contacts) - 1)]
        for take, times in zip(takes, made.times)]
    least = 1.1 * max(foot_skate(take.positions, take.contacts) for take in takes)
    planted = max(labels, key=np.sum) if alpha == 0.5 else labels[alpha > 0.5]
    kept, before, after = standing(clip, planted, least)
    peaks = [peak_acceleration(fragment_of(c, own, "", fps=fps), own) for c in (clip, kept)]
    if after < before and peaks[1] * made.peak <= PEAK * peaks[0]:
        return kept, replace(made, peak=made.peak * peaks[1] / max(peaks[0], 1e-9)), before, after
    return clip, made, before, before                        # a foot that pops would be worse
