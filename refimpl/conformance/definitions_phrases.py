"""Whole poses and phrases of 2006 a second time: one joint of one frame after the other, and
phrases out of the definitions of single operations.
"""

from collections.abc import Sequence
from itertools import permutations
import math
from typing import Any

import numpy as np

from . import definitions_learning as learning, definitions_torresani as plain
from .definitions_rotation import orthogonal
from .definitions_torresani import sequences
from .specification import Array


def _turn(angle, up):
    axis = {"y": 1, "z": 2}[up]
    return learning.exponential_map(angle * np.eye(3)[axis])


def _headings(R, reference, up):
    """tan(h / 2) = (difference across the diagonal) / (1 + trace) of R reference^T."""
    a, b = {"y": (0, 2), "z": (1, 0)}[up]
    found: list[float] = []
    for M in (frame @ reference.T for frame in R):
        h = 2 * math.atan2(M[a, b] - M[b, a], 1 + M[0, 0] + M[1, 1] + M[2, 2])
        h = math.remainder(h, 2 * math.pi) if not found else (
            found[-1] + math.remainder(h - found[-1], 2 * math.pi))
        found.append(h)
    return found


def _in_the_world(R, t, parents):
    """One frame: rotations and places of all joints, parents first."""
    rotations: list[Array] = []
    places: list[Array] = []
    for j, parent in enumerate(parents):
        rotations.append(R[j] if parent < 0 else rotations[parent] @ R[j])
        places.append(t[j] if parent < 0 else places[parent] + rotations[parent] @ t[j])
    return rotations, np.array(places)


def _at_thirty(R, places, fps):
    """Frames of a clip at 30 a second."""
    found, n = [], 0
    while n * fps / 30 <= len(R) - 1 + 1e-6:
        time = min(n * fps / 30, len(R) - 1.0)
        before = min(int(time), len(R) - 2)
        u = time - before
        turns = [A @ learning.exponential_map(u * learning.rotation_vector(A.T @ B))
                 for A, B in zip(R[before], R[before + 1])]
        found.append((turns, (1 - u) * places[before] + u * places[before + 1]))
        n += 1
    return found


def motion_to_poses(rotations: Array, places: Array, *, lengths: Sequence[int], parents: Array,
                    bones: Array, free: Sequence[int], fps: float) -> tuple[Array, ...]:
    """One clip, joint and frame at a time."""
    chain = [0]
    while list(parents).count(chain[-1]) == 1:
        chain.append(list(parents).index(chain[-1]))
    carrier = max((j for j in chain if j in free), default=0)
    above = chain[:chain.index(carrier)]

    def _stood(place, own):
        return np.array([place if j == free[0] else bone for j, bone in enumerate(own)])
    clips = [(R, [_stood(p, own) for p in ps], own) for R, ps, own in zip(
        sequences(rotations, lengths), sequences(places, lengths), bones)]
    worlds = [[_in_the_world(r, t, parents) for r, t in zip(R, ts)] for R, ts, _ in clips]
    own = [j for j in range(len(parents)) if j not in above]
    spread = [np.mean([np.mean([max(x[own, axis]) - min(x[own, axis]) for _, x in world])
                       for world in worlds]) for axis in range(3)]
    up = "z" if spread[2] > spread[1] else "y"
    common = np.median([ts[0] for _, ts, _ in clips], axis=0)
    reference = [orthogonal(sum(sum(r[j] for r in R) / len(R) for R, _, _ in clips))
                 for j in range(len(parents))]
    for j in above:
        common[j], reference[j] = bones[0][j], np.eye(3)
    first = worlds[0][0][0][carrier]
    ahead = []
    for world in worlds:
        carried = [R[carrier] for R, _ in world]
        ahead.append(sum(_turn(-h, up) @ R for h, R in zip(_headings(carried, first, up), carried))
                     / len(carried))
    reference[carrier] = orthogonal(sum(ahead))
    below = [j for j in range(len(parents)) if j not in (carrier, *above)]
    angles, root = [], []
    for R, ts, _ in clips:
        ratio = (sum(math.hypot(*common[j]) for j in below)
                 / sum(math.hypot(*ts[0][j]) for j in below))
        frames = [_in_the_world(r, t, parents) + (r,) for r, t in _at_thirty(R, ts, fps)]
        headings = _headings([W[carrier] for W, _, _ in frames], reference[carrier], up)
        local = np.array([[np.eye(3) if j in above else _turn(-h, up) @ W[j] if j == carrier
                           else r[j] for j in range(len(parents))]
                          for (W, _, r), h in zip(frames, headings)])
        angles.append(learning.continuous_exponential_maps(local, np.array(reference)))
        root += [[*x[carrier] * (ratio if abs(ratio - 1) >= 1e-3 else 1.0), h]
                 for (_, x, _), h in zip(frames, headings)]
    return (np.array(carrier), np.array("yz".index(up)), common, np.array(reference),
            np.concatenate(angles), np.array(root))


def posed_joints(angles: Array, root: Array, *, parents: Array, bones: Array,
                 reference: Array, carrier: int, up: str) -> Array:
    """One joint of one frame at a time, parents first."""
    above, j, found = np.zeros(3), parents[carrier], []
    while j >= 0:
        above, j = above + bones[j], parents[j]
    for v, place in zip(angles.reshape(len(angles), -1, 3), root):
        R = [A @ learning.exponential_map(a) for A, a in zip(reference, v)]
        R[carrier] = _turn(place[3], up) @ R[carrier]
        t = [place[:3] - above if j == carrier else bone for j, bone in enumerate(bones)]
        found.append(_in_the_world(R, t, parents)[1])
    return np.array(found)


def _described(angles, root, fps, relative, body):
    measured = learning.effort_measures(posed_joints(angles, root, **body), fps=fps)
    energy, speed, acceleration, jerk = (math.log(max(x, 1e-12)) for x in measured)
    return np.array([acceleration - jerk, energy, acceleration - speed] if relative else
                    [-jerk, energy, acceleration])


class _Observer:
    """The computed observer, which has seen these fragments."""

    def __init__(self, parts, contents, fps, relative, body):
        self.how = fps, relative, body
        seen = [_described(angles, root, *self.how) for angles, root in parts]
        self.usual = {c: sum(d for d, own in zip(seen, contents) if own == c) / contents.count(c)
                      for c in contents}
        self.mean = sum(seen) / len(seen)
        squares = sum((d - self.usual[c]) ** 2 for d, c in zip(seen, contents))
        self.spread = np.sqrt(squares / (len(seen) - len(self.usual)))

    def style(self, part: Any, content: int) -> Array:
        """What it sees."""
        angles, root = part
        d = _described(angles, root, *self.how) - self.usual.get(content, self.mean)
        return np.array([min(max(1.5 * x / s, -3.0), 3.0) for x, s in zip(d, self.spread)])


def observed_styles(angles: Array, root: Array, *, lengths: Sequence[int], contents: Sequence[int],
                    asked: Sequence[int], fps: float, relative: bool, **body: Any) -> Array:
    """One fragment after the other."""
    parts = list(zip(sequences(angles, lengths), sequences(root, lengths)))
    observer = _Observer(parts, [int(c) for c in contents], fps, relative, body)
    return np.array([observer.style(part, int(c)) for part, c in zip(parts, asked)])


def all_dtw_costs(frames: Array, *, lengths: Sequence[int]) -> Array:
    """Each pair for itself."""
    parts = sequences(frames, lengths)
    return np.array([[0.0 if i == j else plain.dtw_cost(parts[min(i, j)], parts[max(i, j)])
                      for j in range(len(parts))] for i in range(len(parts))])


def joined_motions(angles: Array, root: Array, *, lengths: Sequence[int], reference: Array,
                   fps: float, seam: float | None = None, up: str = "y") -> tuple[Array, Array]:
    """One seam after the other, joint by joint."""
    floor, height = [0, 2] if up == "y" else [0, 1], "xyz".index(up)
    width = round((0.6 if seam is None else seam) * fps)
    log, exp = learning.rotation_vector, learning.exponential_map
    parts = [[[A @ exp(v) for A, v in zip(reference, frame)] for frame in part]
             for part in sequences(angles.reshape(len(angles), -1, 3), lengths)]
    roots = [x.copy() for x in sequences(root, lengths)]
    for before, x in zip(roots, roots[1:]):
        own = x.copy()
        by = before[-1, 3] + (before[-1, 3] - before[-2, 3] + own[1, 3] - own[0, 3]) / 2 - own[0, 3]
        step = (before[-1, floor] - before[-2, floor]
                + plain.turned(own[1, floor] - own[0, floor], by, up)) / 2
        for t, row in enumerate(own):
            x[t, floor] = (before[-1, floor] + step
                           + plain.turned(row[floor] - own[0, floor], by, up))
            x[t, 3] = row[3] + by

    def _fade(n, frames):
        u = min(n / max(min(max(width, 1), frames // 2), 1), 1.0)
        return 1 - (6 * u ** 5 - 15 * u ** 4 + 10 * u ** 3)
    jumps = []
    for A, B, a, b in zip(parts, parts[1:], roots, roots[1:]):
        steps = [(log(A[-2][j].T @ A[-1][j]) + log(B[0][j].T @ B[1][j])) / 2
                 for j in range(len(reference))]
        jumps.append(([log((A[-1][j] @ exp(v)).T @ B[0][j]) for j, v in enumerate(steps)],
                      b[0, height] - a[-1, height] - (a[-1, height] - a[-2, height]
                                                      + b[1, height] - b[0, height]) / 2))
    for n, (deltas, rise) in enumerate(jumps):
        for part, x, side in ((parts[n], roots[n], 1), (parts[n + 1], roots[n + 1], -1)):
            for t, frame in enumerate(part):
                share = side * _fade(len(part) - 1 - t if side > 0 else t, len(part)) / 2
                for j, delta in enumerate(deltas):
                    frame[j] = frame[j] @ exp(share * delta)
                x[t, height] += share * rise
    return (learning.continuous_exponential_maps(np.array(sum(parts, [])), reference),
            np.concatenate(roots))


def styled_phrase(Y: Array, *, root_Y: Array, angles: Array, root: Array,
                  lengths: Sequence[int], contents: Sequence[int] | None, styles: Array | None,
                  fps: float, pairs: Array, alpha: Array, dealt: Array, kind: str,
                  target: Array, components: int = 3, clusters: int = 1, relative: bool = True,
                  count: int = 12, looks: int | None = None, **body: Any) -> tuple[Array, ...]:
    """The parts of it one after the other."""
    looks = (8 if styles is None else 1) if looks is None else looks
    up, parts = body["up"], list(zip(sequences(angles, lengths), sequences(root, lengths)))
    ssd, numbers = all_dtw_costs(angles, lengths=lengths), range(len(parts))
    of = [int(c) for c in (plain.content_clusters(ssd, threshold=cluster_threshold(
        ssd, count=clusters)) if contents is None else contents)]
    observer = _Observer(parts, of, fps, relative, body)
    seen = [observer.style(part, c) for part, c in zip(parts, of)]
    e = seen if styles is None else list(styles)
    c = plain.principal_components(angles, lengths, components=components, length=50)[2]

    def _z(k, m, a):
        return [*c[k], *c[m], *e[k], *e[m], a]

    def _blend(k, m, a):
        path = plain.dtw_path(parts[k][0], parts[m][0])
        return plain.space_time_interpolation(parts[k][0], parts[m][0], parts[k][1], parts[m][1],
                                              path, alpha=a, up=up)
    Z, E = [], []
    for (k, m), a in zip(pairs.tolist(), alpha):
        style = observer.style(_blend(k, m, a), of[k])
        if styles is not None:
            style = np.clip(style + (1 - a) * (e[k] - seen[k]) + a * (e[m] - seen[m]), -3, 3)
        Z.append(_z(k, m, a))
        E.append(style)
    own = [(k, min((m for m in numbers if m != k and of[m] == of[k]), key=lambda m: ssd[k, m]))
           for k in numbers if of.count(of[k]) > 1]
    Z += [_z(k, m, 0.0) for k, m in own] + [_z(m, k, 1.0) for k, m in own]
    E += [e[k] for k, _ in own] * 2
    chosen_for = learning.least_errors(np.array(Z), np.array(E), kind, dealt)

    def _predicted(z):
        return np.array([learning.predicted_style(
            np.array(Z), np.array(E)[:, [n]], np.array(z), kind=kind, **how)[:, 0]
            for n, how in enumerate(chosen_for)]).T
    _, found, ends, _ = plain.one_stage_segmentation(Y, angles, lengths)
    made, chosen, alphas = [], [], []
    for piece in found:
        near = sorted((m for m in numbers if of[m] == of[piece]), key=lambda m: ssd[piece, m])
        looked = _ranked([(k, m) for k in near[:count] for m in near[:count] if k != m],
                         _predicted, _z, target)[:looks]
        blends = [_blend(k, m, a) for _, k, m, a in looked]
        misses = [math.dist(observer.style(blend, of[looked[0][1]]), target) for blend in blends]
        best = misses.index(min(misses)) if looks > 1 else 0
        made.append(blends[best])
        chosen.append(looked[best][1:3])
        alphas.append(looked[best][3])
    start = made[0][1]
    by, floor = root_Y[0, 3] - start[0, 3], [0, 2] if up == "y" else [0, 1]
    places = [root_Y[0, floor] + plain.turned(row[floor] - start[0, floor], by, up)
              for row in start]
    start[:, floor], start[:, 3] = places, start[:, 3] + by
    moved, way = joined_motions(np.concatenate([x for x, _ in made]),
                                np.concatenate([x for _, x in made]), up=up, fps=fps,
                                lengths=[len(x) for x, _ in made], reference=body["reference"])
    cuts = [sum(len(x) for x, _ in made[:n]) for n in range(len(made) + 1)]
    final = [observer.style((moved[a:b], way[a:b]), of[piece])
             for a, b, piece in zip(cuts, cuts[1:], found) if b - a >= 4]
    return (moved, way, np.array(cuts), np.array(chosen), np.array(alphas),
            np.array(final).sum(axis=0) / len(final))


def _ranked(pairs, predicted, z, target):
    """Errors, pairs and alphas, the least error first; alpha by ever finer steps, of all pairs
    together."""
    low, high, steps = [-0.25] * len(pairs), [1.25] * len(pairs), 12
    while max(b - a for a, b in zip(low, high)) > 1e-8:
        grids = [np.linspace(a, b, steps + 1) for a, b in zip(low, high)]
        styles = predicted([z(k, m, a) for (k, m), grid in zip(pairs, grids) for a in grid])
        errors = [math.dist(style, target) for style in styles]
        rows = [errors[n * (steps + 1):(n + 1) * (steps + 1)] for n in range(len(pairs))]
        best = [row.index(min(row)) for row in rows]
        low = [grid[max(n - 1, 0)] for grid, n in zip(grids, best)]
        high = [grid[min(n + 1, steps)] for grid, n in zip(grids, best)]
        steps = 40
    return sorted((row[n], k, m, grid[n]) for row, n, (k, m), grid in zip(rows, best, pairs, grids))


def cluster_threshold(ssd: Array, *, count: int) -> float:
    """Links made one after the other, the shortest first, each that joins two clusters."""
    cluster, joined = list(range(len(ssd))), [0.0]
    for d, i, j in sorted((ssd[i, j], i, j) for i in range(len(ssd)) for j in range(i)):
        if cluster[i] != cluster[j]:
            joined.append(d)
            cluster = [cluster[i] if c == cluster[j] else c for c in cluster]
    made = joined[len(ssd) - count]
    return (math.nextafter(made, math.inf) * 2 + 1 if count == 1
            else (made + joined[len(ssd) - count + 1]) / 2)


def best_pair(coefficients: Array, styles: Array, Z: Array, Y: Array, *,
              target: Array, **model: Any) -> tuple[Array, ...]:
    """All pairs, alpha by ever finer steps about the best of 13 even ones."""
    def _z(k, m, a):
        return [*coefficients[k], *coefficients[m], *styles[k], *styles[m], a]

    def _predicted(z):
        return learning.predicted_style(Z, Y, np.array(z), **model)
    error, k, m, alpha = _ranked(list(permutations(range(len(styles)), 2)), _predicted, _z,
                                 target)[0]
    return (np.array([k, m]), np.asarray(alpha), _predicted([_z(k, m, alpha)])[0],
            np.asarray(error))
