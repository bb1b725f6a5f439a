r"""Content match (section 4, equations 3 to 5) and space-time interpolation (section 5).

Frames count from 0, in the paper from 1; sums of squared differences (SSD) in radians squared.
"""

from collections.abc import Sequence

import numpy as np
from scipy.cluster.hierarchy import linkage
from scipy.ndimage import gaussian_filter1d
from scipy.sparse.csgraph import connected_components
from scipy.spatial.distance import cdist, squareform

from .poses import HEADING, Fragment

LOWEST, HIGHEST = -0.25, 1.25           # alpha: a quarter beyond both ends
SMOOTH = 6.0                            # standard deviation of the Gaussian over a path, in frames
PATH_STEPS = ((1, 1), (1, 0), (0, 1))   # of a path, of equals the first
CELLS = 6_000_000                       # of distance at a time: about 150 MB


class AlignError(ValueError):
    """Sequences that cannot be compared, or an alpha that cannot be."""


def check_sequence(name: str, array: np.ndarray) -> np.ndarray:
    """A sequence (frames, angles) as float64.   Raises AlignError, which names it."""
    array = np.asarray(array)
    if array.ndim != 2 or not array.size:
        raise AlignError(f"{name}: found shape {array.shape}, needed (frames, angles) with at "
                         "least one of each")
    if array.dtype.kind not in "fiub":
        raise AlignError(f"{name}: found dtype {array.dtype}, needed real numbers")
    array = array.astype(float, copy=False)
    if not np.isfinite(array).all():
        raise AlignError(f"{name}: found {array[~np.isfinite(array)][0]} among its angles, needed "
                         "finite numbers")
    return array


def distances(X: np.ndarray, Y: np.ndarray, names: tuple[str, str] = ("X", "Y")) -> np.ndarray:
    r"""d(p, q) = || X(p) - Y(q) ||^2, the squares added up from the first column to the last.

    X : (P, D), Y : (Q, D), names : what errors call them  ->  (P, Q).
    Raises AlignError for other shapes, no frames, or numbers that are not real and finite.

    >>> distances(np.array([[0.0, 1.0]]), np.array([[3.0, 1.0], [0.0, 0.0]]))
    array([[9., 1.]])
    """
    X, Y = check_sequence(names[0], X), check_sequence(names[1], Y)
    if X.shape[1] != Y.shape[1]:
        raise AlignError(f"{', '.join(names)}: found {X.shape[1]} and {Y.shape[1]} angles a frame, "
                         "needed as many; are they of one skeleton?")
    return cdist(X, Y, "sqeuclidean")


def dtw_definition(d: np.ndarray) -> np.ndarray:
    r"""The least cost of every beginning of an alignment by dynamic programming, cell by cell:

        C(p, q) = d(p, q) + min( C(p-1, q-1), C(p-1, q), C(p, q-1) ),   C(0, 0) = d(0, 0)

    Torresani 2006, Equation 3: SSD = min over paths w of sum_n d(w(n)), the last element of C.
    Torresani 2006, Equation 4: a path leads from the first frames of both to the last of both.
    Torresani 2006, Equation 5: each step goes on by one frame in one of the two, or in both.

    A step costs the distance of the cell that it enters ("symmetric1"). `accumulate` gives the same
    bits faster.   (P, Q)  ->  (P, Q)

    >>> dtw_definition(np.array([[0.0, 2.0], [3.0, 1.0]]))
    array([[0., 2.],
           [3., 1.]])
    """
    C = np.full(np.add(d.shape, 1), np.inf)                  # a row and a column before frame 0
    C[0, 0] = 0.0
    for p, q in np.ndindex(d.shape):
        C[p + 1, q + 1] = d[p, q] + min(C[p, q], C[p, q + 1], C[p + 1, q])
    return C[1:, 1:]


def accumulate(d: np.ndarray) -> np.ndarray:
    r"""`dtw_definition` for many pairs at once, one anti-diagonal k = p + q after the other: its
    cells depend on k-1 and k-2 alone.

    d : (B, P, Q), inf where a shorter pair ends
    ->  C : (P + Q - 1, B, P) skewed, C[p + q, b, p] = C_b(p, q)

    >>> float(accumulate(np.array([[[0.0, 2.0], [3.0, 1.0]]]))[1 + 1, 0, 1])
    1.0
    """
    B, P, Q = d.shape
    # Rows one longer than the skewed ones: read as rows of those, each slips by one.
    padded = np.full((B, P, P + Q), np.inf)
    padded[:, :, :Q] = d
    skewed = padded.reshape(B, -1)[:, :P * (P + Q - 1)].reshape(B, P, P + Q - 1)
    C = np.ascontiguousarray(skewed.transpose(2, 0, 1))
    for k in range(1, P + Q - 1):
        best = C[k - 1].copy()                                              # from (p, q-1)
        np.minimum(best[:, 1:], C[k - 1][:, :-1], out=best[:, 1:])          # from (p-1, q)
        if k > 1:
            np.minimum(best[:, 1:], C[k - 2][:, :-1], out=best[:, 1:])      # from (p-1, q-1)
        C[k] += best
    return C


def dtw(X: np.ndarray, Y: np.ndarray) -> tuple[float, np.ndarray]:
    r"""The SSD of two sequences (equation 3) and the path w* = (p*, q*) that has it.

    X : (P, D), Y : (Q, D)  ->  SSD, path (L, 2) of whole numbers from (0, 0) to (P-1, Q-1).
    Of equal ways back the diagonal one is taken, then (p-1, q), then (p, q-1). With dtw-python and
    dtaidistance 2.5 (symmetric1, squared Euclidean) costs agree to 2e-16, paths are identical.

    >>> cost, path = dtw(np.array([[0.0], [1.0]]), np.array([[0.0], [0.5], [1.0]]))
    >>> cost, path.tolist()
    (0.25, [[0, 0], [0, 1], [1, 2]])
    """
    C = accumulate(distances(X, Y)[None])[:, 0]
    p, q = len(X) - 1, len(Y) - 1
    cost, path = float(C[p + q, p]), [(p, q)]
    while p or q:
        ways = [(C[p + q - i - j, p - i], p - i, q - j) for i, j in PATH_STEPS if i <= p and j <= q]
        _, p, q = min(ways, key=lambda way: way[0])          # the first of equals
        path.append((p, q))
    return cost, np.array(path[::-1])


def pair_costs(pairs: Sequence[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """The SSD of many pairs of sequences, without their paths.   [(X (P, D), Y (Q, D))]  ->  (N,)

    >>> pair_costs([(np.zeros((2, 1)), np.ones((3, 1))), (np.zeros((1, 1)), np.zeros((1, 1)))])
    array([3., 0.])
    """
    lengths = np.array([(len(X), len(Y)) for X, Y in pairs]).reshape(-1, 2)
    order = np.lexsort((lengths[:, 1], lengths[:, 0]))       # like lengths together, little padding
    costs, at = np.empty(len(pairs)), 0
    while at < len(order):
        longest = np.maximum.accumulate(lengths[order[at:]], axis=0)
        cells = longest.prod(axis=1) * np.arange(1, len(longest) + 1)    # of so many pairs, padded
        chunk = order[at:at + max(1, int(np.searchsorted(cells, CELLS, "right")))]
        P, Q = lengths[chunk].max(axis=0)
        d = np.full((len(chunk), P, Q), np.inf)
        for row, n in zip(d, chunk.tolist()):
            row[:lengths[n, 0], :lengths[n, 1]] = distances(*pairs[n])
        last = lengths[chunk] - 1
        costs[chunk] = accumulate(d)[last.sum(axis=1), np.arange(len(chunk)), last[:, 0]]
        at += len(chunk)
    return costs


def all_pairs(sequences: Sequence[np.ndarray]) -> np.ndarray:
    """The SSD of every sequence with every other.   [(T_i, D)]  ->  (N, N), symmetric"""
    upper, ssd = np.triu_indices(len(sequences), 1), np.zeros((len(sequences),) * 2)
    ssd[upper] = pair_costs([(sequences[i], sequences[j]) for i, j in np.transpose(upper).tolist()])
    return ssd + ssd.T


def clusters(ssd: np.ndarray, threshold: float) -> np.ndarray:
    """Contents: fragments linked by chains of matches, pairs whose SSD is below a threshold.

    ssd : (N, N)  ->  (N,) from 0 in the order of first fragments.   Raises AlignError.

    >>> clusters(np.array([[0.0, 9.0, 1.0], [9.0, 0.0, 9.0], [1.0, 9.0, 0.0]]), 2.0)
    array([0, 1, 0])
    """
    ssd = np.asarray(ssd)
    if ssd.ndim != 2 or len(set(ssd.shape)) != 1:
        raise AlignError(f"ssd: found shape {ssd.shape}, needed (fragments, fragments)")
    found = connected_components(ssd < threshold, directed=False)[1]
    _, first, inverse = np.unique(found, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[inverse]


def threshold_for(ssd: np.ndarray, count: int) -> float:
    """A threshold that leaves this many clusters, half-way between the last link made and the first
    one not made; where these are equally long no threshold does, and it is the next one up.

    ssd : (N, N), count : from 1 to N.   Raises AlignError for a count that cannot be.

    >>> threshold_for(np.array([[0.0, 9.0, 1.0], [9.0, 0.0, 9.0], [1.0, 9.0, 0.0]]), 2)
    5.0
    """
    if not 1 <= count <= len(ssd):
        raise AlignError(f"count: found {count}, needed a number of clusters from 1 to {len(ssd)}, "
                         "the number of fragments")
    if np.asarray(ssd).dtype.kind not in "fiu":
        raise AlignError(f"ssd: found dtype {np.asarray(ssd).dtype}, needed real numbers")
    links = linkage(squareform(ssd, checks=False), "single")[:, 2] if len(ssd) > 1 else np.zeros(0)
    made, not_made = np.r_[0.0, links, np.inf][len(ssd) - count:][:2]
    above = np.nextafter(made, np.inf) * 2 + 1
    return float(0.5 * (made + not_made) if np.isfinite(not_made) else above)


def time_curve(path: np.ndarray, smooth: float = SMOOTH,
               straight: float = 0.0) -> tuple[np.ndarray, ...]:
    r"""The path as a continuous curve (p*(n), q*(n)), and the parameters n at which each sequence
    plays in its own time: n0_k solves p*(n0_k) = k, n1_k likewise for q*.

    The steps are smoothed by a Gaussian of `smooth` frames, reflected about both ends so that these
    stay (0 keeps the steps: motion then halts where one stands still).
    path : (L, 2);  straight : how far the curve is drawn to the straight line, from 0 to 1
    ->  curve (L, 2), n0 (T_i,), n1 (T_j,).
    Raises AlignError for a path that equations 4 and 5 do not allow.
    """
    path = np.asarray(path)
    if path.shape[1:] != (2,) or not len(path) or path[0].any() or not (
            set(map(tuple, np.diff(path, axis=0).tolist())) <= set(PATH_STEPS)):
        raise AlignError(f"path: found an array of shape {path.shape}, needed (L, 2) frames from "
                         "(0, 0) on, each of both going on by 0 or 1 a step")
    curve = path.astype(float)
    if smooth and len(curve) > 2:
        pad = int(np.ceil(4 * smooth)) + 1
        padded = np.pad(curve, ((pad, pad), (0, 0)), mode="reflect", reflect_type="odd")
        smoothed = gaussian_filter1d(padded, smooth, axis=0, mode="nearest")[pad:-pad]
        inner = np.maximum.accumulate(smoothed[1:-1])
        curve = np.concatenate([curve[:1], inner, curve[-1:]]).clip(curve[0], curve[-1])
    if straight:
        curve = (1 - straight) * curve + straight * np.linspace(curve[0], curve[-1], len(curve))
    return curve, _own_time(curve[:, 0]), _own_time(curve[:, 1])


def _own_time(frames):
    """n_k with frames(n_k) = k, in the middle where the curve stands still.   (L,)  ->  (T,)"""
    values, group, sizes = np.unique(frames, return_inverse=True, return_counts=True)
    middle = np.bincount(group, weights=np.arange(len(frames))) / sizes
    middle[0], middle[-1] = 0, len(frames) - 1               # both sequences begin and end with it
    return np.interp(np.arange(int(round(frames[-1])) + 1), values, middle)


def synchronised(path: np.ndarray, alpha: float, smooth: float = SMOOTH, straight: float = 0.0,
                 slower: float = 1.0) -> tuple[np.ndarray, ...]:
    r"""Where each sequence is read for a blend (section 5): T = (1-alpha) T_i + alpha T_j frames
    (halves rounded to even; beyond [0, 1] at least half of the shorter sequence, a choice: the line
    itself would reach 0) at path parameters

        n^alpha_k = (1-alpha) n0(k (T_i-1)/(T-1)) + alpha n1(k (T_j-1)/(T-1)),

    between the timing of i and that of j, held within the path and never running backwards.

    path : (L, 2);  straight : see `time_curve`;  slower : a factor on T, 1 in the paper
    ->  p*(n^alpha) and q*(n^alpha), each (T,), in frames of i and of j
    """
    curve, n0, n1 = time_curve(path, smooth, straight)
    shortest = max(2, (min(len(n0), len(n1)) + 1) // 2)
    frames = max(shortest, int(round(slower * ((1 - alpha) * len(n0) + alpha * len(n1)))))
    own, other = (read_at(n, np.arange(frames) * (len(n) - 1) / (frames - 1)) for n in (n0, n1))
    n = np.maximum.accumulate(np.clip((1 - alpha) * own + alpha * other, 0, len(curve) - 1))
    n[0], n[-1] = 0, len(curve) - 1
    return read_at(curve[:, 0], n), read_at(curve[:, 1], n)


def read_at(X: np.ndarray, times: np.ndarray) -> np.ndarray:
    """A sequence between its frames, linearly.   (T, ...), times (K,) from 0 to T-1  ->  (K, ...)

    >>> read_at(np.array([0.0, 10.0]), np.array([0.0, 0.3, 1.0]))
    array([ 0.,  3., 10.])
    """
    before = np.minimum(times.astype(int), max(len(X) - 2, 0))
    u = (times - before).reshape((-1,) + (1,) * (X.ndim - 1))
    return (1 - u) * X[before] + u * X[np.minimum(before + 1, len(X) - 1)]


def interpolate(a: Fragment, b: Fragment, alpha: float, path: np.ndarray | None = None,
                up: str = "y", smooth: float = SMOOTH, straight: float = 0.0,
                slower: float = 1.0) -> Fragment:
    r"""Space-time interpolation of two fragments of one content (section 5):

        X^alpha(k) = (1-alpha) X_i(p*(n^alpha_k)) + alpha X_j(q*(n^alpha_k))

    The root's height likewise; its steps over the floor and turns are averaged as its own body sees
    them (ahead, aside, turning) and added up again from a start between both.

    alpha : in [-0.25, 1.25], 0 for a and 1 for b;  path : w* if it is known;  up : "y" or "z";
    straight, slower : see `synchronised`; `blend.steady_blend` finds them.
    Raises AlignError for another alpha, rates or angles that differ, a path of other fragments.

    >>> low, high = (Fragment(name, "bow", None, np.full((3, 3), angle), np.zeros((3, 4)))
    ...              for name, angle in (("low", 0.0), ("high", 1.0)))
    >>> interpolate(low, high, 0.25).angles[0]
    array([0.25, 0.25, 0.25])
    """
    if not LOWEST <= alpha <= HIGHEST:
        raise AlignError(f"alpha: found {alpha}, needed {LOWEST} to {HIGHEST}")
    if a.fps != b.fps:
        raise AlignError(f"{a.name}, {b.name}: found {a.fps:g} and {b.fps:g} frames/s, needed one")
    if a.angles.shape[1:] != b.angles.shape[1:]:
        raise AlignError(f"{a.name}, {b.name}: found angles of shapes {a.angles.shape} and "
                         f"{b.angles.shape}, needed those of one skeleton")
    p, q = synchronised(dtw(a.angles, b.angles)[1] if path is None else path, alpha, smooth,
                        straight, slower)
    if (p[-1], q[-1]) != (a.frames - 1, b.frames - 1):
        raise AlignError(
            f"path: found its end at frames {p[-1]:g} and {q[-1]:g}, needed {a.frames - 1} and "
            f"{b.frames - 1}, the last of {a.name} and {b.name}; is it another pair's?")
    angles = (1 - alpha) * read_at(a.angles, p) + alpha * read_at(b.angles, q)
    root = _blend_roots(read_at(a.root, p), read_at(b.root, q), alpha, up)
    same = a.content if a.content == b.content else None
    return Fragment(f"{a.name}+{b.name}@{alpha:.2f}", same, None, angles, root, a.fps)


def _blend_roots(A, B, alpha, up):
    """Two synchronised roots (T, 4) to one, see `interpolate`."""
    B = B.copy()                                             # to start nearer than half a turn to A
    B[:, HEADING] -= 2 * np.pi * np.round((B[0, HEADING] - A[0, HEADING]) / (2 * np.pi))
    out = (1 - alpha) * A + alpha * B
    floor = [0, 2] if up == "y" else [0, 1]
    steps = sum(weight * turned(np.diff(R[:, floor], axis=0), -R[:-1, HEADING], up)
                for weight, R in ((1 - alpha, A), (alpha, B)))
    out[1:, floor] = out[0, floor] + np.cumsum(turned(steps, out[:-1, HEADING], up), axis=0)
    return out


def turned(v: np.ndarray, angle: np.ndarray, up: str) -> np.ndarray:
    """Floor vectors turned about the vertical.
    v : (..., 2) the columns of `Body.floor`, angle : (...)  ->  (..., 2)

    >>> turned(np.array([1.0, 0.0]), np.array(np.pi / 2), "z").round(9)
    array([0., 1.])
    """
    angle = angle if up == "z" else -angle                   # (x, z) about y is the other way
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * v[..., 0] - s * v[..., 1], s * v[..., 0] + c * v[..., 1]], axis=-1)
