"""What students write in notebook 14 and should not get away with: `exercise__what_is_wrong`. Names
of the notebook are known.
"""

import numpy as np

from refimpl.torresani2006 import align


def _accumulate(d, diagonal=1.0, predecessors=(True, True, True), first=None, best=min):
    C = np.full(d.shape, np.inf)
    for p in range(d.shape[0]):
        for q in range(d.shape[1]):
            ways = ([C[p - 1, q - 1] + (diagonal - 1) * d[p, q]] if p and q and predecessors[0]
                    else [])
            ways += [C[p - 1, q]] if p and (predecessors[1] or not q) else []
            ways += [C[p, q - 1]] if q and (predecessors[2] or not p) else []
            C[p, q] = d[p, q] + best(ways) if ways else (d[p, q] if first is None else first)
    return C


def my_accumulate__no_diagonal(d):
    return _accumulate(d, predecessors=(False, True, True))


def my_accumulate__diagonal_costs_twice(d):
    return _accumulate(d, diagonal=2.0)


def my_accumulate__begins_at_zero(d):
    return _accumulate(d, first=0.0)


def my_accumulate__worst_way(d):
    return _accumulate(d, best=max)


def my_accumulate__never_waits_for_q(d):
    return _accumulate(d, predecessors=(True, True, False))


def my_accumulate__wraps_around_at_the_borders(d):
    C = d.copy()
    for p in range(d.shape[0]):
        for q in range(d.shape[1]):
            if p or q:
                C[p, q] += min(C[p - 1, q - 1], C[p - 1, q], C[p, q - 1])
    return C


def my_accumulate__borders_are_infinite(d):
    C = np.full(d.shape, np.inf)
    C[0, 0] = d[0, 0]
    for p in range(1, d.shape[0]):
        for q in range(1, d.shape[1]):
            C[p, q] = d[p, q] + min(C[p - 1, q - 1], C[p - 1, q], C[p, q - 1])
    return C


def my_accumulate__changes_d(d):
    C = align.dtw_definition(d)
    d[...] = C
    return d


def _dtw(X, Y, order=(0, 1, 2), of=None):
    d = align.distances(X, Y)
    C = align.dtw_definition(d)
    p, q = len(X) - 1, len(Y) - 1
    path = [(p, q)]
    while p or q:
        ways = [way for way in ((p - 1, q - 1), (p - 1, q), (p, q - 1)) if min(way) >= 0]
        if len(ways) == 3:
            ways = [ways[n] for n in order]
        p, q = min(ways, key=lambda way: (C if of is None else d)[way])
        path.append((p, q))
    return C[-1, -1], np.array(path[::-1])


def my_dtw__ties_to_p_first(X, Y):
    return _dtw(X, Y, order=(1, 0, 2))


def my_dtw__ties_to_q_before_p(X, Y):
    return _dtw(X, Y, order=(0, 2, 1))


def my_dtw__path_backwards(X, Y):
    cost, path = _dtw(X, Y)
    return cost, path[::-1].copy()


def my_dtw__follows_d_instead_of_C(X, Y):
    return _dtw(X, Y, of="d")


def my_dtw__columns_swapped(X, Y):
    cost, path = _dtw(X, Y)
    return cost, path[:, ::-1].copy()


def my_dtw__stops_at_a_border(X, Y):
    cost, path = _dtw(X, Y)
    inside = np.flatnonzero(path.min(axis=1) > 0)
    return cost, path[max(inside[0] - 1, 0):] if len(inside) else path[-1:]


def my_dtw__cost_a_step(X, Y):
    cost, path = _dtw(X, Y)
    return cost / len(path), path


def my_dtw__cost_of_distances_not_squared(X, Y):
    _, path = _dtw(X, Y)
    return np.sqrt(align.distances(X, Y))[tuple(path.T)].sum(), path


def my_dtw__path_alone(X, Y):
    return _dtw(X, Y)[1]


def _blend(X, Y, path, alpha, *, time=None, smooth=align.SMOOTH, frames=None, hold=True, rise=True,
           space=None):
    curve, n0, n1 = align.time_curve(path, smooth)
    time, space = alpha if time is None else time, alpha if space is None else space
    T = round((1 - alpha) * len(X) + alpha * len(Y)) if frames is None else frames
    k = np.arange(T)
    n = ((1 - time) * align.read_at(n0, k * (len(X) - 1) / (T - 1))
         + time * align.read_at(n1, k * (len(Y) - 1) / (T - 1)))
    n = np.clip(n, 0, len(curve) - 1) if hold else n
    n = np.maximum.accumulate(n) if rise else n
    n[0], n[-1] = 0, len(curve) - 1
    p, q = align.read_at(curve, n).T
    return (1 - space) * align.read_at(X, p) + space * align.read_at(Y, q)


def my_blend__alpha_the_other_way_round(X, Y, path, alpha):
    return _blend(X, Y, path, alpha, space=1 - alpha)


def my_blend__time_the_other_way_round(X, Y, path, alpha):
    return _blend(X, Y, path, alpha, time=1 - alpha)


def my_blend__in_the_time_of_i(X, Y, path, alpha):
    return _blend(X, Y, path, alpha, time=0.0)


def my_blend__as_long_as_i(X, Y, path, alpha):
    return _blend(X, Y, path, alpha, frames=len(X))


def my_blend__the_stair(X, Y, path, alpha):
    return _blend(X, Y, path, alpha, smooth=0)


def my_blend__runs_backwards(X, Y, path, alpha):
    return _blend(X, Y, path, alpha, rise=False)


def my_blend__not_held_within_the_path(X, Y, path, alpha):
    return _blend(X, Y, path, alpha, hold=False, rise=False)


def my_blend__even_steps_along_the_path(X, Y, path, alpha):
    curve = align.time_curve(path)[0]
    T = round((1 - alpha) * len(X) + alpha * len(Y))
    p, q = align.read_at(curve, np.linspace(0, len(curve) - 1, T)).T
    return (1 - alpha) * align.read_at(X, p) + alpha * align.read_at(Y, q)


def my_blend__stretched_not_aligned(X, Y, path, alpha):
    T = round((1 - alpha) * len(X) + alpha * len(Y))
    p, q = np.linspace(0, len(X) - 1, T), np.linspace(0, len(Y) - 1, T)
    return (1 - alpha) * align.read_at(X, p) + alpha * align.read_at(Y, q)


def _roots(A, B, alpha, whole=True, back=True, by=None):
    B = B.copy()
    if whole:
        B[:, 3] -= 2 * np.pi * np.round((B[0, 3] - A[0, 3]) / (2 * np.pi))
    out = (1 - alpha) * A + alpha * B
    felt = sum(w * (align.turned(np.diff(R[:, [0, 2]], axis=0), -R[:-1, 3], "y") if back
                    else np.diff(R[:, [0, 2]], axis=0)) for w, R in ((1 - alpha, A), (alpha, B)))
    out[1:, [0, 2]] = ((out[0, [0, 2]]
                       + np.cumsum(align.turned(felt, out[:-1, 3] if by is None else by[:-1, 3],
                                                "y"), axis=0)))
    return out


def my_blend_roots__mean_of_the_places(A, B, alpha):
    return (1 - alpha) * A + alpha * B


def my_blend_roots__whole_turns_forgotten(A, B, alpha):
    return _roots(A, B, alpha, whole=False)


def my_blend_roots__steps_of_the_world(A, B, alpha):
    return _roots(A, B, alpha, back=False)


def my_blend_roots__turned_as_A_is(A, B, alpha):
    return _roots(A, B, alpha, by=A)


def my_blend_roots__begins_at_A(A, B, alpha):
    out = _roots(A, B, alpha)
    out[:, [0, 2]] += A[0, [0, 2]] - out[0, [0, 2]]
    return out


def my_blend_roots__y_and_z_mixed_up(A, B, alpha):
    swap = [0, 2, 1, 3]
    return _roots(A[:, swap], B[:, swap], alpha)[:, swap]


def my_blend_roots__heading_of_the_next_frame(A, B, alpha):
    out = _roots(A, B, alpha)
    late = np.concatenate([out[1:], out[-1:]])
    return _roots(A, B, alpha, by=late)


def my_blend_roots__height_of_A(A, B, alpha):
    out = _roots(A, B, alpha)
    out[:, 1] = A[:, 1]
    return out
