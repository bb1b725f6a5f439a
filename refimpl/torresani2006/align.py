r"""Content match (Torresani 2006, section 4, equations 3 to 5) and space-time interpolation (section 5).

Frames count from 0 here and from 1 in the paper. Angles are in radians, distances and SSD therefore in radians squared.
"""

import numpy as np
from scipy.cluster.hierarchy import linkage
from scipy.ndimage import gaussian_filter1d
from scipy.sparse.csgraph import connected_components
from scipy.spatial.distance import cdist, squareform

from .poses import HEADING, Fragment

LOWEST, HIGHEST = -0.25, 1.25                                # alpha: a quarter beyond both ends
SMOOTH = 6.0                                                 # frames
CELLS = 6_000_000                                            # of distance at a time: about 150 MB


class AlignError(ValueError):
    """Sequences that cannot be compared, or an alpha that cannot be."""


def checked(name, array):
    """A sequence (frames, angles) as float64, or an AlignError that names it."""
    array = np.asarray(array)
    if array.ndim != 2 or not array.size:
        raise AlignError(f"{name}: found shape {array.shape}, needed (frames, angles) with at least one of each")
    if array.dtype.kind not in "fiub":
        raise AlignError(f"{name}: found dtype {array.dtype}, needed real numbers")
    array = array.astype(float, copy=False)
    if not np.isfinite(array).all():
        raise AlignError(f"{name}: found {array[~np.isfinite(array)][0]} among its angles, needed finite numbers")
    return array


def distances(X, Y, names=("X", "Y")):
    r"""d(p, q) = || X(p) - Y(q) ||^2, the squares added up from the first column to the last.

    X : (P, D), Y : (Q, D), names : what errors call them  ->  (P, Q).
    Raises AlignError for other shapes, no frames, or numbers that are not real and finite.
    """
    X, Y = checked(names[0], X), checked(names[1], Y)
    if X.shape[1] != Y.shape[1]:
        raise AlignError(f"{', '.join(names)}: found {X.shape[1]} and {Y.shape[1]} angles a frame, needed as many; are they of one skeleton?")
    return cdist(X, Y, "sqeuclidean")


def dtw_definition(d):
    r"""Equations 3 to 5 by dynamic programming, cell by cell:

        C(p, q) = d(p, q) + min( C(p-1, q-1), C(p-1, q), C(p, q-1) ),   C(0, 0) = d(0, 0)

    Every step costs the distance of the cell that it enters, the diagonal one no more than the others (others call it "symmetric1").

    d : (P, Q)  ->  C : (P, Q); the SSD of equation 3 is its last element. `accumulate` gives the same bits faster.
    """
    C = np.full(d.shape, np.inf)
    for p in range(d.shape[0]):
        for q in range(d.shape[1]):
            if p == 0 and q == 0:
                C[p, q] = d[p, q]
                continue
            diagonal = C[p - 1, q - 1] if p and q else np.inf
            from_p = C[p - 1, q] if p else np.inf
            from_q = C[p, q - 1] if q else np.inf
            C[p, q] = d[p, q] + min(diagonal, from_p, from_q)
    return C


def accumulate(d):
    r"""`dtw_definition` for many pairs at once, one anti-diagonal k = p + q after the other: its cells depend on k-1 and k-2 alone.

    d : (B, P, Q), inf where a shorter pair ends  ->  C : (P + Q - 1, B, P) skewed, C[p + q, b, p] = C_b(p, q)
    """
    B, P, Q = d.shape
    padded = np.full((B, P, P + Q), np.inf)                  # rows one longer than the skewed ones: read as such, each slips by one
    padded[:, :, :Q] = d
    skewed = padded.reshape(B, -1)[:, :P * (P + Q - 1)].reshape(B, P, P + Q - 1)
    C = np.ascontiguousarray(skewed.transpose(2, 0, 1))
    for k in range(1, P + Q - 1):
        best = C[k - 1].copy()                               # from (p, q-1)
        np.minimum(best[:, 1:], C[k - 1][:, :-1], out=best[:, 1:])           # from (p-1, q)
        if k > 1:
            np.minimum(best[:, 1:], C[k - 2][:, :-1], out=best[:, 1:])       # from (p-1, q-1)
        C[k] += best
    return C


def dtw(X, Y):
    r"""The best alignment of two sequences (equation 3) and its path w* = (p*, q*).

    X : (P, D), Y : (Q, D)  ->  SSD, path (L, 2) of whole numbers from (0, 0) to (P-1, Q-1)
    Of equal ways back the diagonal one is taken, then (p-1, q), then (p, q-1).
    Compared on the same convention (symmetric1, squared Euclidean) with dtw-python 1.9 and dtaidistance 2.5: costs of 100 random pairs equal
    to 2e-16 relative, paths identical.
    """
    C = accumulate(distances(X, Y)[None])[:, 0]
    p, q = len(X) - 1, len(Y) - 1
    cost, path = float(C[p + q, p]), [(p, q)]
    while p or q:
        ways = [(C[p + q - 2, p - 1], p - 1, q - 1)] if p and q else []
        ways += [(C[p + q - 1, p - 1], p - 1, q)] if p else []
        ways += [(C[p + q - 1, p], p, q - 1)] if q else []
        _, p, q = min(ways, key=lambda way: way[0])          # the first of equals
        path.append((p, q))
    return cost, np.array(path[::-1])


def pair_costs(pairs):
    """SSD of many pairs of sequences, without their paths.   [(X (P, D), Y (Q, D))]  ->  (N,)"""
    lengths = np.array([(len(X), len(Y)) for X, Y in pairs]).reshape(-1, 2)
    order = np.lexsort((lengths[:, 1], lengths[:, 0]))       # like lengths together: little is padded
    costs, at = np.empty(len(pairs)), 0
    while at < len(order):
        P, Q = lengths[order[at]]
        chunk = [order[at]]
        for n in order[at + 1:]:
            P, Q = max(P, lengths[n, 0]), max(Q, lengths[n, 1])
            if (len(chunk) + 1) * P * Q > CELLS:
                break
            chunk.append(n)
        P, Q = lengths[chunk].max(axis=0)
        d = np.full((len(chunk), P, Q), np.inf)
        for row, n in zip(d, chunk):
            row[:lengths[n, 0], :lengths[n, 1]] = distances(*pairs[n])
        C = accumulate(d)
        last = lengths[chunk] - 1
        costs[chunk] = C[last.sum(axis=1), np.arange(len(chunk)), last[:, 0]]
        at += len(chunk)
    return costs


def all_pairs(sequences):
    """SSD of every sequence with every other.   list of (T_i, D)  ->  (N, N), symmetric, 0 on the diagonal"""
    upper = np.triu_indices(len(sequences), 1)
    ssd = np.zeros((len(sequences),) * 2)
    ssd[upper] = pair_costs([(sequences[i], sequences[j]) for i, j in zip(*upper)])
    return ssd + ssd.T


def per_frame(ssd, lengths):
    """SSD divided by the frames of both sequences: comparable between long and short ones.   (N, N), (N,)  ->  (N, N)"""
    lengths = np.asarray(lengths)
    return ssd / (lengths[:, None] + lengths)


def clusters(ssd, threshold):
    """Contents: fragments linked by a chain of matches, where two match when their SSD is below a threshold (section 4).

    ssd : (N, N)  ->  (N,) numbers from 0 in the order of their first fragments.   Raises AlignError for another shape.
    """
    ssd = np.asarray(ssd)
    if ssd.ndim != 2 or len(set(ssd.shape)) != 1:
        raise AlignError(f"ssd: found shape {ssd.shape}, needed (fragments, fragments)")
    _, found = connected_components(ssd < threshold, directed=False)
    _, first, inverse = np.unique(found, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[inverse]


def threshold_for(ssd, count):
    """A threshold that leaves this many clusters: half-way between the last link made and the first not made. Where these two are equally
    long no threshold does; then it is the next one that leaves more.

    ssd : (N, N), count from 1 to N  ->  float.   Raises AlignError for a count that cannot be.
    """
    if not 1 <= count <= len(ssd):
        raise AlignError(f"count: found {count}, needed a number of clusters from 1 to {len(ssd)}, the number of fragments")
    links = linkage(squareform(ssd, checks=False), "single")[:, 2] if len(ssd) > 1 else np.zeros(0)
    made, not_made = np.r_[0.0, links][len(ssd) - count], np.r_[links, np.inf][len(ssd) - count]
    return float(0.5 * (made + not_made)) if np.isfinite(not_made) else float(np.nextafter(made, np.inf) * 2 + 1)


def time_curve(path, smooth=SMOOTH):
    r"""The path as a continuous curve (p*(n), q*(n)), and the parameters n at which each sequence plays in its own time.

    The steps are smoothed by a Gaussian of `smooth` frames, reflected about both ends so that these stay (0 keeps the steps: motion
    then halts where a step stands still). n0_k solves p*(n0_k) = k; where p* stands still it is the middle.

    path : (L, 2)  ->  curve (L, 2), n0 (T_i,), n1 (T_j,).   Raises AlignError for a path that equations 4 and 5 do not allow.
    """
    path = np.asarray(path)
    steps = np.diff(path, axis=0) if path.ndim == 2 else path
    if path.ndim != 2 or path.shape[1] != 2 or not len(path) or path[0].any() or not (np.isin(steps, (0, 1)).all() and steps.any(axis=1).all()):
        raise AlignError(f"path: found an array of shape {path.shape}, needed (L, 2) frames from (0, 0) on, each of both going on by 0 or 1 a step")
    curve = path.astype(float)
    if smooth and len(curve) > 2:
        pad = int(np.ceil(4 * smooth)) + 1
        padded = np.pad(curve, ((pad, pad), (0, 0)), mode="reflect", reflect_type="odd")
        smoothed = gaussian_filter1d(padded, smooth, axis=0, mode="nearest")[pad:-pad]
        curve = np.concatenate([curve[:1], np.maximum.accumulate(smoothed[1:-1]), curve[-1:]]).clip(curve[0], curve[-1])
    inverses = []
    for column in curve.T:
        values, group, sizes = np.unique(column, return_inverse=True, return_counts=True)
        middle = np.bincount(group, weights=np.arange(len(column))) / sizes
        middle[0], middle[-1] = 0, len(column) - 1           # both sequences begin and end with the path
        inverses.append(np.interp(np.arange(int(round(column[-1])) + 1), values, middle))
    return curve, *inverses


def synchronised(path, alpha, smooth=SMOOTH):
    r"""Where each sequence is read for a blend (section 5): T = (1-alpha) T_i + alpha T_j frames (halves rounded to the even number; beyond
    [0, 1] at least half of the shorter sequence, a choice: the line itself would reach 0) at path parameters

        n^alpha_k = (1-alpha) n0(k (T_i-1)/(T-1)) + alpha n1(k (T_j-1)/(T-1)),

    between the timing of i and that of j; beyond [0, 1] it is held within the path and never runs backwards.

    path : (L, 2)  ->  times p*(n^alpha) and q*(n^alpha), each (T,), in frames of i and of j
    """
    curve, n0, n1 = time_curve(path, smooth)
    shortest = max(2, (min(len(n0), len(n1)) + 1) // 2)
    frames = max(shortest, int(round((1 - alpha) * len(n0) + alpha * len(n1))))
    k = np.arange(frames)
    n = ((1 - alpha) * read_at(n0, k * (len(n0) - 1) / (frames - 1)) + alpha * read_at(n1, k * (len(n1) - 1) / (frames - 1)))
    n = np.maximum.accumulate(np.clip(n, 0, len(curve) - 1))
    n[0], n[-1] = 0, len(curve) - 1
    return read_at(curve[:, 0], n), read_at(curve[:, 1], n)


def read_at(X, times):
    """A sequence between its frames, linearly.   X : (T, ...), times : (K,) from 0 to T-1  ->  (K, ...)"""
    before = np.minimum(times.astype(int), max(len(X) - 2, 0))
    u = (times - before).reshape((-1,) + (1,) * (X.ndim - 1))
    return (1 - u) * X[before] + u * X[np.minimum(before + 1, len(X) - 1)]


def interpolate(a, b, alpha, path=None, up="y", smooth=SMOOTH):
    r"""Space-time interpolation of two fragments of one content (section 5):

        X^alpha(k) = (1-alpha) X_i(p*(n^alpha_k)) + alpha X_j(q*(n^alpha_k))

    The root's height likewise; its steps over the floor and turns are averaged as its own body sees them (ahead, aside, turning) and
    added up again from a start between both.

    a, b : Fragment;  alpha in [-0.25, 1.25], 0 gives back a and 1 gives b;  path : w* if it is known;  up : "y" or "z"   ->  Fragment
    Raises AlignError for another alpha, frame rates or angles that differ, and a path of other fragments.
    """
    if not LOWEST <= alpha <= HIGHEST:
        raise AlignError(f"alpha: found {alpha}, needed {LOWEST} to {HIGHEST}")
    if a.fps != b.fps:
        raise AlignError(f"{a.name}, {b.name}: found {a.fps:g} and {b.fps:g} frames/s, needed the same; resample one of them")
    if a.angles.shape[1:] != b.angles.shape[1:]:
        raise AlignError(f"{a.name}, {b.name}: found angles of shapes {a.angles.shape} and {b.angles.shape}, needed those of one skeleton")
    path = dtw(a.angles, b.angles)[1] if path is None else path
    p, q = synchronised(path, alpha, smooth)
    if (p[-1], q[-1]) != (a.frames - 1, b.frames - 1):
        raise AlignError(f"path: found its end at frames {p[-1]:g} and {q[-1]:g}, needed {a.frames - 1} and {b.frames - 1}, the last of "
                         f"{a.name} and {b.name}; is it another pair's?")
    angles = (1 - alpha) * read_at(a.angles, p) + alpha * read_at(b.angles, q)
    root = _blend_roots(read_at(a.root, p), read_at(b.root, q), alpha, up)
    same = a.content if a.content == b.content else None
    return Fragment(f"{a.name}+{b.name}@{alpha:.2f}", same, None, angles, root, a.fps)


def _blend_roots(A, B, alpha, up):
    """Two synchronised roots (T, 4) to one, see `interpolate`."""
    B = B.copy()
    B[:, HEADING] -= 2 * np.pi * np.round((B[0, HEADING] - A[0, HEADING]) / (2 * np.pi))       # start nearer than half a turn
    out = (1 - alpha) * A + alpha * B
    floor = [0, 2] if up == "y" else [0, 1]
    steps = sum(weight * turned(np.diff(R[:, floor], axis=0), -R[:-1, HEADING], up) for weight, R in ((1 - alpha, A), (alpha, B)))
    out[1:, floor] = out[0, floor] + np.cumsum(turned(steps, out[:-1, HEADING], up), axis=0)
    return out


def turned(v, angle, up):
    """Floor vectors turned about the vertical.   v : (..., 2) the columns of `Body.floor`, angle : (...)  ->  (..., 2)"""
    angle = angle if up == "z" else -angle                   # (x, y) about z; (x, z) about y is the other way round
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * v[..., 0] - s * v[..., 1], s * v[..., 0] + c * v[..., 1]], axis=-1)

