r"""More second definitions of the 2006 system: support vectors, predicted styles, exponential maps,
the search of equation 12, measures of effort.

Loops, and another way than the fast form's where there is one: a support vector machine by moving
every pair of betas and then solving its conditions exactly, an exponential map by its series, a
minimum by the sign of the derivative.
"""

from collections.abc import Callable, Iterable
import math
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial
from scipy.spatial.transform import Rotation

from .definitions_torresani import distance, gaussian_kernel, kernel_ridge, linear_ridge
from .specification import Array


def support_vectors(K: Array, y: Array, C: float, epsilon: float) -> tuple[Array, float]:
    """The dual problem of `torresani2006.svr`.   ->  beta (n,), b"""
    n, beta = len(y), np.zeros(len(y))
    for _ in range(400):
        for i in range(n):
            for j in range(i):
                t = _best_move(K, y, beta, i, j, C, epsilon)
                beta[i], beta[j] = beta[i] + t, beta[j] - t
        exact = _exact_solution(K, y, beta, C, epsilon)
        if exact is not None:
            return exact
    raise ArithmeticError("support vectors: found no end after 400 sweeps")


def _best_move(K, y, beta, i, j, C, epsilon):
    """The t that lowers the dual most when beta_i rises and beta_j sinks by it: a stationary point
    for some pair of signs, a kink or an end.
    """
    slope = sum((K[i, k] - K[j, k]) * beta[k] for k in range(len(y))) - y[i] + y[j]
    curvature = max(K[i, i] + K[j, j] - 2 * K[i, j], 1e-300)
    low, high = max(-C - beta[i], beta[j] - C), min(C - beta[i], C + beta[j])
    tries = [-(slope + epsilon * signs) / curvature for signs in (-2, 0, 2)] + [-beta[i], beta[j]]

    def _change(t):
        return t * (slope + 0.5 * curvature * t) + epsilon * (abs(beta[i] + t) + abs(beta[j] - t)
                                                              - abs(beta[i]) - abs(beta[j]))
    return min((min(max(t, low), high) for t in tries), key=_change)


def _exact_solution(K, y, beta, C, epsilon):
    """Which betas are 0, at the box or between is guessed from `beta`; the conditions are then
    linear equations.   ->  beta, b, or None
    """
    n = len(y)
    free = [i for i in range(n) if 1e-7 * C < abs(beta[i]) < (1 - 1e-7) * C]
    fixed = [0.0 if i in free or abs(beta[i]) < 0.5 * C else math.copysign(C, beta[i])
             for i in range(n)]
    sign = [math.copysign(1.0, beta[i]) for i in free]
    found = np.array(fixed)
    if free:
        A = [[K[i, j] for j in free] + [1.0] for i in free] + [[1.0] * len(free) + [0.0]]
        right = [y[i] - s * epsilon - sum(K[i, k] * fixed[k] for k in range(n))
                 for i, s in zip(free, sign)] + [-sum(fixed)]
        *values, b = np.linalg.lstsq(A, right, 0.0)[0]
        found[free] = values
        if any(v * s < 0 or abs(v) > C for v, s in zip(values, sign)):
            return None
    rest = [y[i] - sum(K[i, k] * found[k] for k in range(n)) for i in range(n)]
    highest = max(r - (epsilon if v >= 0 else -epsilon) for r, v in zip(rest, found) if v < C)
    lowest = min(r - (epsilon if v > 0 else -epsilon) for r, v in zip(rest, found) if v > -C)
    if highest > lowest + 1e-9 or abs(sum(found)) > 1e-9:
        return None
    return found, b if free else (highest + lowest) / 2


def support_vectors_without_bias(K: Array, y: Array, C: float,
                                 epsilon: float) -> tuple[Array, float]:
    """The same with b = 0 and no condition on the sum, as a rival has it: one beta at a time until
    nothing moves.
    """
    beta = np.zeros(len(y))
    for _ in range(5000):
        before = beta.copy()
        for i in range(len(y)):
            rest = y[i] - sum(K[i, k] * beta[k] for k in range(len(y)) if k != i)
            beta[i] = min(max(math.copysign(max(abs(rest) - epsilon, 0.0), rest) / K[i, i], -C), C)
        if np.abs(beta - before).max() < 1e-13:
            break
    return beta, 0.0


def support_vector_regression(
        K: Array, y: Array, K_new: Array, *, C: float, epsilon: float,
        solve: Callable[..., tuple[Array, float]] = support_vectors) -> tuple[Any, Array]:
    """Sums over the support vectors that `solve` finds.   ->  dual objective, predictions"""
    beta, b = solve(K, y, C, epsilon)
    n = range(len(y))
    dual = (sum(0.5 * beta[i] * K[i, j] * beta[j] for i in n for j in n)
            - sum(y[i] * beta[i] - epsilon * abs(beta[i]) for i in n))
    return dual, np.array([sum(row[i] * beta[i] for i in n) + b for row in K_new])


def predicted_style(Z: Array, Y: Array, new: Array, *, kind: str, ridge: float = 0.0,
                    gamma: float = 0.0, C: float = 0.0, epsilon: float = 0.0) -> Array:
    """One effort after the other, on inputs in units of their standard deviation."""
    if kind == "linear interpolation":
        return np.array([[(1 - z[-1]) * z[k - 7] + z[-1] * z[k - 4] for k in range(3)]
                         for z in new])
    mean = [sum(column) / len(Z) for column in Z.T]
    deviation = [math.sqrt(sum((x - m) ** 2 for x in column) / len(Z)) or 1.0
                 for column, m in zip(Z.T, mean)]
    X, there = (np.array([[(x - m) / s for x, m, s in zip(z, mean, deviation)] for z in rows])
                for rows in (Z, new))
    results: list[Any] = []
    for y in Y.T:
        usual = sum(y) / len(y)
        if kind == "linear ridge":
            theta = linear_ridge(X, y - usual, ridge=ridge)
            results.append([sum(a * b for a, b in zip(x, theta)) + usual for x in there])
            continue
        K, K_new = gaussian_kernel(X, X, gamma=gamma), gaussian_kernel(there, X, gamma=gamma)
        if kind == "kernel ridge":
            a = kernel_ridge(K, y - usual, ridge=ridge)
            results.append([sum(w * k for w, k in zip(a, row)) + usual for row in K_new])
        else:
            results.append(support_vector_regression(K, y, K_new, C=C, epsilon=epsilon)[1])
    return np.array(results).T


def exponential_map(v: Array) -> Array:
    """exp(hat v) by its series."""
    out = np.zeros(v.shape + (3,))
    for index in np.ndindex(v.shape[:-1]):
        x, y, z = v[index]
        K, term = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), np.eye(3)
        for k in range(1, 60):
            out[index] += term
            term = term @ K / k
    return out


def rotation_vector(R: Array) -> Array:
    """As SciPy has it, but that of the two vectors of exactly half a turn the one is taken whose
    largest element is positive.
    """
    v = Rotation.from_matrix(R.reshape(-1, 3, 3)).as_rotvec()
    for one in v:
        if math.hypot(*one) > math.pi - 1e-12 and max(one, key=abs) < 0:
            one *= -1
    return v.reshape(R.shape[:-1])


def continuous_exponential_maps(R: Array, reference: Array) -> Array:
    """Of all vectors v + 2 pi k u of one rotation the nearest to the frame before; both ways round
    to begin with, and the shorter one taken unless it takes a longer step.
    """
    T, J = R.shape[:2]
    out = np.zeros((T, J, 3))
    for j in range(J):
        shortest = [rotation_vector(reference[j].T @ R[t, j]) for t in range(T)]
        ways = []
        for turns in (0, -1):
            before, way = _equivalents(shortest[0], shortest[0], (turns,))[0], []
            for v in shortest:
                before = min(_equivalents(v, before, range(-6, 7)),
                             key=lambda x: distance(x, before))
                way.append(before)
            ways.append(way)
        lengths = [sum(math.sqrt(distance(x, [0, 0, 0])) for x in way) / T for way in ways]
        steps = [max((math.sqrt(distance(x, y)) for x, y in zip(way, way[1:])), default=0.0)
                 for way in ways]
        other = lengths[1] < lengths[0] - 1e-9 and steps[1] < steps[0] + 1e-9
        out[:, j] = ways[1] if other else ways[0]
    return out.reshape(T, 3 * J)


def _equivalents(v, before, turns):
    """v + 2 pi k u for some k, u its direction or, for no rotation, that of the vector before."""
    along = v if math.sqrt(distance(v, [0, 0, 0])) >= 1e-9 else before
    length = math.sqrt(distance(along, [0, 0, 0])) or 1.0
    return [v + 2 * math.pi * k * along / length for k in turns]


def golden_section(coefficients: Any, low: Iterable[float], high: Iterable[float], *,
                   tolerance: float = 1e-6) -> Array:
    """Where the slope turns from falling to rising, by halving; of a constant the upper end."""
    found = []
    for c, a, b in zip(coefficients, low, high):
        slope = Polynomial(c).deriv()
        for _ in range(60):
            a, b = (a, (a + b) / 2) if slope((a + b) / 2) > 0 else ((a + b) / 2, b)
        found.append((a + b) / 2)
    return np.array(found)


def best_alpha(coefficients: Array, *, samples: int = 13, tolerance: float = 1e-6) -> Array:
    """The best of even steps over [-0.25, 1.25], or the minimum between its neighbours."""
    grid, found = [-0.25 + 1.5 * k / (samples - 1) for k in range(samples)], []
    for c in coefficients:
        value = Polynomial(c)
        best = int(np.argmin(value(np.array(grid))))
        alpha = golden_section([c], [grid[max(best - 1, 0)]], [grid[min(best + 1, samples - 1)]])[0]
        found.append(alpha if value(alpha) <= value(grid[best]) else grid[best])
    return np.array(found)


def effort_measures(positions: Array, *, fps: float) -> Array:
    """Energy, speed, acceleration and jerk, one joint and one frame after the other."""
    T, J = positions.shape[:2]
    differences = [positions * 1.0]
    for _ in range(3):
        last = differences[-1]
        differences.append(np.array([(last[t + 1] - last[t]) * fps for t in range(len(last) - 1)]))
    lengths = [[[math.sqrt(distance(x, [0, 0, 0])) for x in frame] for frame in difference]
               for difference in differences[1:]]
    energy = np.max([0.5 * sum(v * v for v in frame) for frame in lengths[0]])
    return np.array([energy] + [sum(map(sum, frames)) / (len(frames) * J) for frames in lengths])


def _folds(folds):
    """(others, members) of each fold."""
    for fold in sorted(set(folds.tolist())):
        yield ([n for n, f in enumerate(folds) if f != fold],
               [n for n, f in enumerate(folds) if f == fold])


def ridge_errors(K: Array, Y: Array, *, ridges: Array, folds: Array) -> Array:
    """Trained anew for each fold."""
    found = np.zeros((len(ridges), Y.shape[1]))
    for n, ridge in enumerate(ridges):
        for others, members in _folds(folds):
            a = kernel_ridge(K[np.ix_(others, others)], Y[others], ridge=ridge)
            for i in members:
                found[n] += (sum(K[i, k] * w for k, w in zip(others, a)) - Y[i]) ** 2 / len(Y)
    return found


def machine_errors(Ks: Array, Y: Array, *, boxes: Array, epsilons: Array, folds: Array) -> Array:
    """Trained anew for each fold."""
    found = np.zeros((len(Ks), len(boxes), len(epsilons), Y.shape[1]))
    for g, b, p, e in np.ndindex(found.shape):
        for others, members in _folds(folds):
            beta, offset = support_vectors(Ks[g][np.ix_(others, others)], Y[others, e],
                                           boxes[b], epsilons[p])
            for i in members:
                predicted = sum(Ks[g][i, k] * w for k, w in zip(others, beta)) + offset
                found[g, b, p, e] += (predicted - Y[i, e]) ** 2 / len(Y)
    return found


def machine_violation(K: Array, y: Array, beta: Array, *, C: float, epsilon: float) -> float:
    """One beta at a time."""
    r = [v - sum(k * b for k, b in zip(row, beta)) for v, row in zip(y, K)]
    highest = max((x - (epsilon if b >= 0 else -epsilon) for x, b in zip(r, beta) if b < C),
                  default=-math.inf)
    lowest = min((x - (epsilon if b > 0 else -epsilon) for x, b in zip(r, beta) if b > -C),
                 default=math.inf)
    apart = highest - lowest if math.isfinite(highest - lowest) else 0.0
    return max(apart, 0.0) + max(max(abs(b) - C for b in beta), 0.0) + abs(sum(beta))


def fitted_style(Z: Array, Y: Array, new: Array, *, kind: str, dealt: Array) -> Array:
    """One effort after the other, each with the hyper-parameters that it does best with."""
    if kind == "linear interpolation":
        return predicted_style(Z, Y, new, kind=kind)
    return np.array([predicted_style(Z, y[:, None], new, kind=kind, **chosen)[:, 0]
                     for y, chosen in zip(Y.T, least_errors(Z, Y, kind, dealt))]).T


def least_errors(Z: Array, Y: Array, kind: str, dealt: Array) -> list[dict[str, float]]:
    """The hyper-parameters that each effort does best with."""
    deviation = [float(np.std(column)) or 1.0 for column in Z.T]
    X, folds = (Z - np.mean(Z, axis=0)) / deviation, dealt % min(10, len(Z))
    C, tubes = np.array([1.0, 5.0, 25.0]), np.array([0.05, 0.2])
    gammas, K = [0.02, 0.06, 0.2, 0.6, 2.0], X @ X.T
    lowest = -4 if kind == "linear ridge" else -8
    ridges = np.array([10.0 ** (k / 2) for k in range(lowest, lowest + 11)])
    errors: dict[Any, Any] = {}
    for gamma in [0.0] if kind == "linear ridge" else [g / Z.shape[1] for g in gammas]:
        if gamma:
            K = gaussian_kernel(X, X, gamma=gamma)
        if kind == "support vector":
            table = machine_errors(K[None], Y, boxes=C, epsilons=tubes, folds=folds)[0]
            errors |= {(("gamma", gamma), ("C", C[b]), ("epsilon", tubes[p])): table[b, p]
                       for b, p in np.ndindex(3, 2)}
        else:
            table = ridge_errors(K, Y - sum(Y) / len(Y), ridges=ridges, folds=folds)
            errors |= {(("gamma", gamma), ("ridge", r)): row for r, row in zip(ridges, table)}
    return [dict(min(errors, key=lambda chosen: errors[chosen][e])) for e in range(Y.shape[1])]
