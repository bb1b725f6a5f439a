"""The ways from one end to the other a second time: frame by frame, and training as a plain loop
over the gradients of single operations, which are verified by themselves.
"""

from collections.abc import Sequence
import math
from typing import Any

import numpy as np

from ..holden2016 import losses
from ..holden2016.rows import CONTACTS, TRAJECTORY
from ..holden2017 import networks
from ..motion.joints import FEET, LEGS
from . import (definitions_2016 as code, definitions_holden as paper, definitions_nn as plain,
               functions_2016, functions_holden)
from .definitions_smooth import across, deviation_of, smoothed, trained, turned
from .specification import Array


def facing_direction(positions: Array) -> Array:
    """Cross products with the vertical, one frame at a time."""
    def _unit(v):
        return v / math.hypot(*v)
    found = []
    for frame in positions:
        found.append(_unit(np.cross(across(frame), [0.0, 1.0, 0.0])[[0, 2]]))
    return np.array([_unit(v) for v in smoothed(np.array(found), 20.0)])


def _leg(positions):
    return float(np.median([math.dist(p[hip], p[knee]) + math.dist(p[knee], p[heel])
                            for hip, knee, heel, _ in LEGS for p in positions]))


def floor_height(positions: Array) -> float:
    """The soft minimum, one frame at a time."""
    lowest = [min(frame[foot][1] for foot in FEET) for frame in positions]
    weights = [math.exp(-(h - min(lowest)) / (0.01 * _leg(positions))) for h in lowest]
    return sum(w * h for w, h in zip(weights, lowest)) / sum(weights)


def foot_contacts(positions: Array, *, floor: float) -> Array:
    """One foot and one step at a time."""
    unit, T = _leg(positions) / 80.07, len(positions)
    found = np.zeros((T, 4), int)
    for t, (number, foot) in ((t, f) for t in range(T) for f in enumerate(FEET)):
        here, after = positions[t, foot], positions[min(t + 1, T - 1), foot]
        found[t, number] = (math.dist(here, after) ** 2 < 1.5 * unit ** 2
                            and here[1] - floor < (11, 3)[number % 2] * unit)
    found[-1] = found[max(T - 2, 0)]
    return found


def planted_feet(positions: Array) -> tuple[Array, Array]:
    """One joint after the other."""
    T, leg = len(positions), _leg(positions)
    rests, worst = [], []
    paths = [smoothed(np.array([_nearest_to_all([positions[min(max(t + k, 0), T - 1), foot]
                                                 for k in (0, -2, -1, 1, 2)])
                                for t in range(T)]), 1.0) for foot in FEET]
    for path in paths:
        speed = [math.dist(path[min(t + 1, T - 1)], path[max(t - 1, 0)])
                 / max(min(t + 1, T - 1) - max(t - 1, 0), 1) / (0.0148 * leg) for t in range(T)]
        still = [path[t][1] for t in range(T) if speed[t] < 0.5]
        heights = sorted(still if len(still) >= max(4, 0.02 * T) else [p[1] for p in path])
        low = heights[int(0.05 * (len(heights) - 1))]
        rests.append(float(np.median([h for h in heights if abs(h - low) <= 0.0125 * leg])))
        worst.append(speed)
    rests = [min(own, other) if own > other + 0.08 * leg else own
             for own, other in zip(rests, rests[2:] + rests[:2])]
    labels = np.zeros((T, 4), int)
    for n, path in enumerate(paths):
        bad = [max(s, (p[1] - rests[n]) / (0.0375 * leg)) for s, p in zip(worst[n], path)]
        runs = [r for r in _runs([b < 1.1 for b in bad]) if min(bad[r[0]:r[1]]) < 1 / 1.1]
        joined: list[tuple[int, int]] = []
        for a, b in runs:
            if joined and a - joined[-1][1] <= 4:
                a = joined.pop()[0]
            joined.append((a, b))
        for a, b in joined:
            labels[a:b, n] = b - a >= 4 or a == 0 or b == T
    return np.array(rests), labels


def ground_height(positions: Array) -> float:
    """Of the second and the fourth foot joint."""
    _, left, _, right = planted_feet(positions)[0]
    return min(left, right)


def _nearest_to_all(points):
    sums = [sum(math.dist(p, q) for q in points) for p in points]
    return points[0 if sums[0] * (1 - 1e-9) <= min(sums) else sums.index(min(sums))]


def _runs(labels):
    around = [False, *labels, False]
    edges = [t for t in range(len(labels) + 1) if around[t] != around[t + 1]]
    return list(zip(edges[::2], edges[1::2]))


def motion_to_numbers(positions: Array, *, floor: float) -> tuple[Array, Array]:
    """One joint of one frame at a time."""
    forward, T = facing_direction(positions), len(positions)
    path = smoothed(positions[:, 0], 3.0)
    root = np.array([[x, floor, z] for x, _, z in path])
    yaw = [math.atan2(x, z) for x, z in forward]
    found = np.zeros((T, 66))
    for t in range(T):
        for j in range(21):
            found[t, 3 * j:3 * j + 3] = turned(positions[t, j] - root[t], -yaw[t])
        if t + 1 < T:
            sideways, _, ahead = turned(root[t + 1] - root[t], -yaw[t + 1])
            found[t, 63:] = math.remainder(yaw[t + 1] - yaw[t], 2 * math.pi), ahead, sideways
    found[-1, 63:] = found[max(T - 2, 0), 63:]
    return found, np.array([root[0, 0], root[0, 2], yaw[0]])


def numbers_to_motion(features: Array, start: Array) -> Array:
    """One frame after the other."""
    root, yaw, found = np.array([start[0], start[3], start[1]]), start[2], []
    for row in features:
        found.append([root + turned(row[3 * j:3 * j + 3], yaw) for j in range(21)])
        yaw = yaw + row[63]
        root = root + turned([row[65], 0.0, row[64]], yaw)
    return np.array(found)


def motion_windows(features: Array, contacts: Array, *, length: int = 240,
                   step: int = 120) -> tuple[Array, Array]:
    """One window after the other."""
    T = len(features)
    if T < length:
        before = (length - T) // 2
        numbers = [min(max(t - before, 0), T - 1) for t in range(length)]
        still = [t < 0 or t >= T - 1 for t in range(-before, length - before)]
        window = np.array([[*features[n, :63], *(features[n, 63:] * (not s))]
                           for n, s in zip(numbers, still)])
        return window[None], contacts[numbers][None]
    begins = [b for b in range(T) if b % step == 0 and b + length <= T]
    begins += [T - length] * (begins[-1] + length < T)
    return (np.array([[features[b + t] for t in range(length)] for b in begins]),
            np.array([[contacts[b + t] for t in range(length)] for b in begins]))


def normaliser(features: Array, contacts: Array, *, form: str = "groups") -> tuple[Array, Array]:
    """Sums over frames, number by number."""
    own = [deviation_of(column) for column in features.T]
    groups = [range(63), (64, 65), (63,)]
    if form == "groups":
        sizes = [math.sqrt(sum(own[i] ** 2 for i in group) / len(group)) for group in groups]
    else:
        rows = np.concatenate([np.zeros((len(features), 3)), features, contacts], axis=1)
        sizes = [deviation_of(rows.ravel()), 0.9 * deviation_of(features[:, 64:].ravel()),
                 0.9 * own[63]]
    deviation = np.zeros(66)
    for group, size in zip(groups, sizes):
        largest = max(abs(features[t, i]) for t in range(len(features)) for i in group)
        deviation[list(group)] = size if size > 1e-12 * largest else max(own) or 1.0
    if form == "2016":
        for foot in FEET:
            deviation[3 * foot:3 * foot + 3] *= 0.9
    mean = [sum(column) / len(column) for column in features.T]
    return np.array([*mean[:63], 0.0, 0.0, 0.0]), deviation


def project(X: Array, W0: Array, b0: Array) -> Array:
    """Equations 1 and 2 on an even number of frames."""
    T = X.shape[2]
    even = X[:, :, [*range(T), *[T - 1] * (T % 2)]]
    return paper.decode(paper.encode(even, W0, b0), W0, b0)[:, :, :T]


def style_target(hidden: Array, *, lengths: Sequence[int], frames: int) -> Array:
    """The mean over all frames of the exemplars, frame by frame."""
    assert sum(lengths) == hidden.shape[1]
    return frames * sum(np.outer(h, h) for h in hidden.T) / hidden.shape[1]


def initial_filters(uniform: Array) -> Array:
    """One number at a time."""
    outputs, inputs, width = uniform.shape
    bound = math.sqrt(6 / (inputs * width + outputs * width))
    return np.array([[[bound * (2 * u - 1) for u in row] for row in f] for f in uniform])


def initial_networks(uniform: Array, *, hidden: int, channels: int, features: int,
                     width: int) -> tuple[Array, ...]:
    """Filter after filter."""
    made: list[Array] = []
    at = 0
    for outputs, inputs in ((hidden, features), (channels, features), (channels, channels),
                            (features, channels), (hidden, features), (features, hidden)):
        count = outputs * inputs * width
        made += [initial_filters(uniform[at:at + count].reshape(outputs, inputs, width)),
                 np.zeros(outputs)]
        at += count
    return tuple(made)


def initial_noise(uniform: Array) -> Array:
    """One number at a time."""
    bound = math.sqrt(6 / sum(uniform.shape))
    return np.array([[[bound * (2 * u - 1) for u in row] for row in uniform]])


def learning_rate(epoch: Array, *, rate: float, epochs: int) -> Array:
    """Constant for half of the epochs, then a straight line."""
    return np.array([rate if 2 * e - 1 <= epochs else rate * (2 * epochs - 2 * e + 1) / epochs
                     for e in epoch.tolist()])


def _trained(arrays, order, batch, rate, of_batch):
    rates = learning_rate(np.arange(1, len(order) + 1), rate=rate, epochs=len(order))
    return trained(arrays, order, batch, rates, of_batch)


def train_loss_network(W0: Array, b0: Array, *, X: Array, order: Array,
                       batch: int, rate: float, alpha: float = 0.01, dropout: float = 0.0,
                       kept: Array | None = None, chosen: Array | None = None) -> tuple[Array, ...]:
    """Equation 3 written out, of each batch."""
    def _of(arrays, indices, epoch):
        clean = X[indices]
        seen = clean if kept is None else clean * kept[epoch, indices] / (1 - dropout)
        places = None if chosen is None else chosen[epoch, indices]
        again = paper.decode(paper.encode(seen, *arrays), *arrays, chosen=places)
        sizes = np.concatenate([np.abs(a).ravel() for a in arrays])
        _, found = networks.autoencoder_loss_backward(
            1.0, clean, dict(zip(("W0", "b0"), arrays)), alpha=alpha, noisy=seen, chosen=places)
        return np.mean((again - clean) ** 2) + alpha * np.mean(sizes), found.values()
    return _trained((W0, b0), order, batch, rate, _of)


def train_transformation_network(*arrays: Array, I: Array, order: Array, batch: int,
                                 rate: float, W0: Array, b0: Array, gram: Array, contacts: Array,
                                 trajectory: Array, foot_velocity: Array | None = None,
                                 **constants: Any) -> tuple[Array, ...]:
    """`total_loss` and its gradient, of each batch."""
    def _of(moved, indices, epoch):
        problem = {"I": I[indices], "gram": gram[indices], "contacts": contacts[indices],
                   "trajectory": trajectory[indices], "hidden": paper.encode(I[indices], W0, b0),
                   "W0": W0, "b0": b0, "reading": "mean_squares", **constants,
                   "foot_velocity": None if foot_velocity is None else foot_velocity[indices]}
        return (paper.total_loss(*moved, **problem),
                functions_holden.total_loss_backward(1.0, *moved, **problem))
    return _trained(arrays, order, batch, rate, _of)


def style_search(content: Array, style: Array, start: Array, We: Array, be: Array,
                 Wd: Array, bd: Array, *, mean: Array, deviation: Array, amount: float = 0.1,
                 iterations: int = 250, constraint_iterations: int = 100) -> tuple[Array, ...]:
    """Steps 1 to 4 one after the other."""
    def _seen(rows):
        return code.encode(np.array([[(r - mean) / deviation for r in rows]])[0].T[None], We, be)

    def _motion(H):
        return code.decode(H, Wd, bd) * deviation[:, None] + mean[:, None]

    def _down(H, gradient, steps):
        m, v = np.zeros(H.shape), np.zeros(H.shape)
        for t in range(1, steps + 1):
            H, m, v = plain.adam_step(H, gradient(H), m, v, t=t, rate=0.01, epsilon=1e-5)
        return H

    def _constrained(H):
        motion, one = _motion(H), np.ones(1)
        slope = (losses.foot_loss_backward(one, motion, contacts)
                 + losses.bone_loss_backward(one, motion)
                 + losses.trajectory_loss_backward(one, motion, wanted))
        return functions_2016.decode_backward(slope / 3 * deviation[:, None], H, Wd, bd)[0]
    C, gram = _seen(content), plain.gram(_seen(style))
    H = _down(code.encode(start, We, be), lambda h: losses.search_loss_backward(
        np.ones(1), h, C, gram, amount=amount), iterations)
    after = _motion(H)[0].T
    speeds = [sum(math.hypot(*row[66:68]) for row in rows) for rows in (after, content)]
    tail = np.array([[*(row[66:68] * speeds[0] / speeds[1]), *row[68:]] for row in content])
    contacts, wanted = content[None, :, CONTACTS].swapaxes(1, 2), tail[None, :, :3].swapaxes(1, 2)
    H = _down(_seen(after), _constrained, constraint_iterations)
    before = _motion(H)[0].T
    return np.hstack([before[:, :TRAJECTORY.start], tail]), after, before
