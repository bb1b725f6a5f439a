"""Answers to 16_segment_and_synthesise.ipynb."""

import numpy as np

from refimpl.torresani2006 import align


def my_one_stage(Y, fragments):
    d = [align.distances(Y, X) for X in fragments]
    # enter: what it costs to begin a fragment in this frame
    before, enter = [np.full(len(X), np.inf) for X in fragments], 0.0
    for p in range(len(Y)):
        after = []
        for i, C in enumerate(before):
            now = np.empty(len(C))
            now[0] = d[i][p, 0] + min(C[0], enter)
            for q in range(1, len(C)):
                now[q] = d[i][p, q] + min(C[q], C[q - 1], now[q - 1])
            after.append(now)
        before, enter = after, min(C[-1] for C in after)
    return enter


def my_segment(Y, fragments):
    d = [align.distances(Y, X) for X in fragments]
    # (cost, frame of entry) of every cell
    before = [[(np.inf, 0)] * len(X) for X in fragments]
    enter, ends = 0.0, []
    for p in range(len(Y)):
        after = []
        for i, C in enumerate(before):
            cost, when = min([C[0], (enter, p)], key=lambda way: way[0])
            now = [(d[i][p, 0] + cost, when)]
            for q in range(1, len(C)):
                cost, when = min([C[q - 1], C[q], now[q - 1]], key=lambda way: way[0])
                now.append((d[i][p, q] + cost, when))
            after.append(now)
        before = after
        best = min(range(len(fragments)), key=lambda i: after[i][-1][0])
        enter, when = after[best][-1]
        ends.append((best, when))
    pieces, p = [], len(Y) - 1
    while p >= 0:
        pieces.append(ends[p])
        p = ends[p][1] - 1
    numbers, starts = np.array(pieces[::-1]).T
    return enter, numbers, starts


def my_golden_section(f, low, high, tolerance):
    r = (np.sqrt(5.0) - 1.0) / 2.0
    left, right = high - r * (high - low), low + r * (high - low)
    f_left, f_right = f(left), f(right)
    while high - low > tolerance:
        if f_left < f_right:
            high, right, f_right = right, left, f_left
            left = high - r * (high - low)
            f_left = f(left)
        else:
            low, left, f_left = left, right, f_right
            right = low + r * (high - low)
            f_right = f(right)
    return 0.5 * (low + high)


def my_best_alpha(f, samples):
    grid = np.linspace(-0.25, 1.25, samples)
    values = [f(alpha) for alpha in grid]
    n = int(np.argmin(values))
    alpha = my_golden_section(f, grid[max(n - 1, 0)], grid[min(n + 1, samples - 1)], 1e-5)
    return alpha if f(alpha) <= values[n] else grid[n]
