r"""Every operation of the 2006 system a second time: loops straight from the equations, by another
way where there is one.

Slow, and written without a look at the fast forms. Frames count from 0, angles are radians,
everything is float64.
"""

from collections.abc import Sequence
import math
from typing import Any

import numpy as np

from .specification import Array


def distance(x: Any, y: Any) -> float:
    """The sum of squared differences."""
    return sum((float(a) - float(b)) ** 2 for a, b in zip(x, y))


def dtw(X: Array, Y: Array) -> tuple[float, Array]:
    """Equations 3 to 5 with a pointer back from every cell; of equal ways the diagonal, then p-1,
    then q-1.   ->  cost, path"""
    cost: dict[Any, float] = {}
    back: dict[Any, Any] = {}
    for p, q in np.ndindex(len(X), len(Y)):
        ways = [cell for cell in ((p - 1, q - 1), (p - 1, q), (p, q - 1)) if cell in cost]
        back[p, q] = best = min(ways, key=cost.__getitem__, default=None)
        cost[p, q] = distance(X[p], Y[q]) + (cost[best] if best else 0.0)
    end = cell = (len(X) - 1, len(Y) - 1)
    path = []
    while cell is not None:
        path.append(cell)
        cell = back[cell]
    return cost[end], np.array(path[::-1])


def dtw_cost(X: Array, Y: Array) -> float:
    """The cost of the cheapest path."""
    return dtw(X, Y)[0]


def dtw_path(X: Array, Y: Array) -> Array:
    """The cheapest path."""
    return dtw(X, Y)[1]


def content_clusters(ssd: Array, *, threshold: float) -> Array:
    """Spread each fragment's number to all that it matches, until nothing changes."""
    label = list(range(len(ssd)))
    changed = True
    while changed:
        changed = False
        for i, j in np.ndindex(*np.shape(ssd)):
            if ssd[i, j] < threshold and label[j] != label[i]:
                label[i] = label[j] = min(label[i], label[j])
                changed = True
    order = sorted(set(label))
    return np.array([order.index(number) for number in label])


def _read(values, time):
    """A sequence at a time between two frames."""
    before = min(int(time), max(len(values) - 2, 0))
    after, u = min(before + 1, len(values) - 1), time - before
    return (1 - u) * values[before] + u * values[after]


def _smoothed(column, sigma):
    """A Gaussian of `sigma` frames, cut at four sigma; beyond its ends the sequence goes on by its
    point reflection about them."""
    last, radius = len(column) - 1, int(4 * sigma + 0.5)

    def _at(n):
        if n < 0:
            return 2 * column[0] - _at(-n)
        return 2 * column[last] - _at(2 * last - n) if n > last else column[n]
    weights = [math.exp(-0.5 * (k / sigma) ** 2) for k in range(-radius, radius + 1)]
    return [sum(w * _at(n + k - radius) for k, w in enumerate(weights)) / sum(weights)
            for n in range(last + 1)]


def _time_curve(path, smooth):
    """->  (p*, q*) as two lists over the path, and where on it each whole p and each whole q is
    reached"""
    curves, inverses = [], []
    for column in np.asarray(path, dtype=float).T.tolist():
        curve = list(column)
        if smooth and len(column) > 2:
            inner, largest = _smoothed(column, smooth), 0.0
            for n in range(1, len(column) - 1):
                largest = max(largest, inner[n]) if n > 1 else inner[n]
                curve[n] = min(max(largest, column[0]), column[-1])
        curves.append(np.array(curve))
        inverses.append([_reached(curve, k) for k in range(int(round(curve[-1])) + 1)])
    return curves, inverses


def _reached(curve, k):
    """The parameter n at which a rising curve is k; where it stands there, the middle; at both ends
    the ends."""
    if k == 0 or k == int(round(curve[-1])):
        return 0.0 if k == 0 and len(curve) > 1 and curve[-1] > 0 else float(len(curve) - 1)
    standing = [n for n, value in enumerate(curve) if value == k]
    if standing:
        return (standing[0] + standing[-1]) / 2
    n = max(n for n, value in enumerate(curve) if value < k)
    return n + (k - curve[n]) / (curve[n + 1] - curve[n])


def space_time_interpolation(X: Array, Y: Array, root_X: Array, root_Y: Array,
                             path: Array, *, alpha: float, smooth: float = 6.0,
                             up: str = "y") -> tuple[Array, Array]:
    """Section 5, frame by frame.   ->  angles (T, D), root (T, 4)"""
    (p_curve, q_curve), (n0, n1) = _time_curve(path, smooth)
    exact = (1 - alpha) * len(X) + alpha * len(Y)
    frames = max(round(exact), 2, math.ceil(min(len(X), len(Y)) / 2))
    angles, root, farthest = np.zeros((frames, X.shape[1])), np.zeros((frames, 4)), 0.0
    turns = round((root_Y[0, 3] - root_X[0, 3]) / (2 * math.pi))
    shifted = np.array(root_Y, dtype=float)
    shifted[:, 3] -= 2 * math.pi * turns
    here = []
    for k in range(frames):
        n = ((1 - alpha) * _read(n0, k * (len(X) - 1) / (frames - 1))
             + alpha * _read(n1, k * (len(Y) - 1) / (frames - 1)))
        farthest = max(farthest, min(n, len(path) - 1.0))
        n = 0.0 if k == 0 else len(path) - 1.0 if k == frames - 1 else farthest
        p, q = _read(p_curve, n), _read(q_curve, n)
        angles[k] = (1 - alpha) * _read(X, p) + alpha * _read(Y, q)
        here.append((_read(root_X, p), _read(shifted, q)))
        root[k] = (1 - alpha) * here[k][0] + alpha * here[k][1]
    floor = [0, 2] if up == "y" else [0, 1]
    for k in range(1, frames):
        step = sum(w * turned(here[k][i][floor] - here[k - 1][i][floor], -here[k - 1][i][3], up)
                   for i, w in ((0, 1 - alpha), (1, alpha)))
        root[k, floor] = root[k - 1, floor] + turned(step, root[k - 1, 3], up)
    return angles, root


def turned(v: Any, angle: float, up: str) -> Array:
    """By complex numbers: x + i y about z; about y it is z + i x that turns by +angle."""
    if up == "z":
        w = complex(v[0], v[1]) * complex(math.cos(angle), math.sin(angle))
        return np.array([w.real, w.imag])
    w = complex(v[1], v[0]) * complex(math.cos(angle), math.sin(angle))
    return np.array([w.imag, w.real])


def sequences(frames: Array, lengths: Sequence[int]) -> list[Array]:
    """The sequences that come end to end in one array.

    >>> [list(x) for x in sequences(np.arange(5), (2, 3))] == [[0, 1], [2, 3, 4]]
    True
    """
    ends = [sum(lengths[:i + 1]) for i in range(len(lengths))]
    return [frames[end - n:end] for end, n in zip(ends, lengths)]


def one_stage_segmentation(Y: Array, frames: Array, lengths: Sequence[int],
                           ) -> tuple[float, Array, Array, Array]:
    """Equations 8 to 11 with a pointer back from every cell (p, q, i).

    ->  cost, fragments, ends, costs
    """
    X, ended = sequences(frames, lengths), 0           # ended : the cheapest fragment to come from
    cost: dict[Any, float] = {}
    back: dict[Any, Any] = {}
    for p in range(len(Y)):
        if p:
            ended = min(range(len(X)), key=lambda j: cost[p - 1, len(X[j]) - 1, j])
        for i in range(len(X)):
            for q in range(len(X[i])):
                if q:
                    ways = [cell for cell in ((p - 1, q - 1, i), (p - 1, q, i), (p, q - 1, i))
                            if cell in cost]
                else:
                    ways = [(p - 1, 0, i), (p - 1, len(X[ended]) - 1, ended)] if p else []
                best = min(ways, key=cost.__getitem__, default=None)
                entered = best is None or (not q and best != ways[0])
                cost[p, q, i] = distance(Y[p], X[i][q]) + (cost[best] if best else 0.0)
                back[p, q, i] = (best, entered)
    total, i = min((cost[len(Y) - 1, len(X[i]) - 1, i], i) for i in range(len(X)))
    cell = end = (len(Y) - 1, len(X[i]) - 1, i)
    pieces = []
    while cell is not None:
        before, entered = back[cell]
        if entered:
            pieces.append((cell[2], end[0] + 1, cost[end] - (cost[before] if before else 0.0)))
            end = before
        cell = before
    found, ends, costs = zip(*pieces[::-1])
    return total, np.array(found), np.array(ends), np.array(costs)


def principal_components(frames: Array, lengths: Sequence[int], *, components: int,
                         length: int) -> tuple[Array, Array, Array]:
    """From the eigenvectors of the fragments' products with each other.

    ->  mean, basis, coefficients
    """
    X = np.array([np.concatenate([_read(x, (len(x) - 1) * k / (length - 1) if length > 1 else 0.0)
                                  for k in range(length)]) for x in sequences(frames, lengths)])
    mean = sum(X) / len(X)
    values, vectors = np.linalg.eigh((X - mean) @ (X - mean).T)
    basis = np.zeros((components, X.shape[1]))
    for n, column in enumerate(np.argsort(-values)[:components]):
        direction = sum(vectors[i, column] * (X[i] - mean) for i in range(len(X)))
        direction = direction / math.sqrt(sum(direction ** 2))
        most = max(abs(x) for x in direction)
        first = next(k for k, x in enumerate(direction) if abs(x) >= (1 - 1e-9) * most)
        basis[n] = direction if direction[first] > 0 else -direction
    return mean, basis, np.array([[sum(b * (x - mean)) for b in basis] for x in X])


def gaussian_kernel(A: Array, B: Array, *, gamma: float) -> Array:
    """exp(-gamma distance), pair by pair."""
    return np.array([[math.exp(-gamma * distance(a, b)) for b in B] for a in A])


def linear_ridge(Z: Array, Y: Array, *, ridge: float) -> Array:
    """The normal equations, by their singular values."""
    d = Z.shape[1]
    A = [[sum(z[i] * z[j] for z in Z) + (ridge if i == j else 0.0) for j in range(d)]
         for i in range(d)]
    return np.linalg.lstsq(A, [sum(z[i] * y for z, y in zip(Z, Y)) for i in range(d)], 0.0)[0]


def kernel_ridge(K: Array, Y: Array, *, ridge: float) -> Array:
    """The equations of the dual, by their singular values."""
    return np.linalg.lstsq(K + ridge * np.eye(len(K)), Y, 0.0)[0]
