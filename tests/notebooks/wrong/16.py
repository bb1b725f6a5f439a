"""What students write in notebook 16 and should not get away with: `exercise__what_is_wrong`. Names
of the notebook are known.
"""

import numpy as np

from refimpl.torresani2006 import align
from refimpl.torresani2006.segment import segment as _own


def _one_stage(Y, fragments, *, others=True, wait=True, along=True, start_anywhere=False,
               end_anywhere=False, enter_late=False, first=True):
    d = [align.distances(Y, X) for X in fragments]
    before, enter = [np.full(len(X), np.inf) for X in fragments], 0.0
    for p in range(len(Y)):
        after = []
        for i, C in enumerate(before):
            now = np.empty(len(C))
            door = enter if others or not p else C[-1]
            now[0] = d[i][p, 0] + min(C[0] if wait else np.inf, door)
            for q in range(1, len(C)):
                ways = ([C[q], C[q - 1]] + [now[q - 1]] * (along and (p > 0 or first))
                        + [enter] * (enter_late or start_anywhere and not p))
                now[q] = d[i][p, q] + min(ways)
            after.append(now)
        before, enter = after, min(C[-1] for C in after)
    return min(C.min() for C in before) if end_anywhere else enter


def my_one_stage__comes_back_to_the_same_fragment_only(Y, fragments):
    return _one_stage(Y, fragments, others=False)


def my_one_stage__never_waits_at_the_beginning(Y, fragments):
    return _one_stage(Y, fragments, wait=False)


def my_one_stage__never_runs_through_a_fragment(Y, fragments):
    return _one_stage(Y, fragments, along=False)


def my_one_stage__begins_anywhere(Y, fragments):
    return _one_stage(Y, fragments, start_anywhere=True)


def my_one_stage__ends_anywhere(Y, fragments):
    return _one_stage(Y, fragments, end_anywhere=True)


def my_one_stage__enters_anywhere(Y, fragments):
    return _one_stage(Y, fragments, enter_late=True)


def my_one_stage__no_steps_along_q_in_the_first_frame(Y, fragments):
    return _one_stage(Y, fragments, first=False)


def my_one_stage__best_single_fragment(Y, fragments):
    return min(align.dtw(Y, X)[0] for X in fragments)


def my_one_stage__nearest_pose_of_all(Y, fragments):
    return align.distances(Y, np.concatenate(fragments)).min(axis=1).sum()


def _segment(Y, fragments):
    cost, pieces = _own(Y, fragments)
    return (cost, np.array([piece.fragment for piece in pieces]),
            np.array([piece.start for piece in pieces]))


def my_segment__backwards(Y, fragments):
    cost, numbers, starts = _segment(Y, fragments)
    return cost, numbers[::-1].copy(), starts[::-1].copy()


def my_segment__last_frames_instead_of_first(Y, fragments):
    cost, numbers, starts = _segment(Y, fragments)
    return cost, numbers, np.append(starts[1:], len(Y)) - 1


def my_segment__one_frame_late(Y, fragments):
    cost, numbers, starts = _segment(Y, fragments)
    return cost, numbers, np.where(starts > 0, starts + 1, 0)


def my_segment__last_piece_only(Y, fragments):
    cost, numbers, starts = _segment(Y, fragments)
    return cost, numbers[-1:], starts[-1:]


def my_segment__repeated_fragments_counted_once(Y, fragments):
    cost, numbers, starts = _segment(Y, fragments)
    keep = np.append(True, np.diff(numbers) != 0)
    return cost, numbers[keep], starts[keep]


def my_segment__entry_of_the_cell_below(Y, fragments):
    """The frame of entry is taken from q - 1 whatever the minimum came from."""
    d = [align.distances(Y, X) for X in fragments]
    before, enter, ends = [[(np.inf, 0)] * len(X) for X in fragments], 0.0, []
    for p in range(len(Y)):
        after = []
        for i, C in enumerate(before):
            now = [(d[i][p, 0] + min(C[0][0], enter), p if enter < C[0][0] else C[0][1])]
            for q in range(1, len(C)):
                now.append((d[i][p, q] + min(C[q - 1][0], C[q][0], now[q - 1][0]),
                            C[q - 1][1] if p else 0))
            after.append(now)
        before = after
        best = min(range(len(fragments)), key=lambda i: after[i][-1][0])
        enter = after[best][-1][0]
        ends.append((best, after[best][-1][1]))
    pieces, p = [], len(Y) - 1
    while p >= 0:
        pieces.append(ends[p])
        p = min(ends[p][1], p) - 1
    numbers, starts = np.array(pieces[::-1]).T
    return enter, numbers, starts


def my_segment__fragment_of_the_last_frame_only(Y, fragments):
    cost, numbers, starts = _segment(Y, fragments)
    return cost, np.full_like(numbers, numbers[-1]), starts


def _golden(f, low, high, tolerance, r=(np.sqrt(5.0) - 1.0) / 2.0, swap=False, strict=True,
            answer="middle"):
    for _ in range(200):
        if high - low <= tolerance:
            break
        left, right = high - r * (high - low), low + r * (high - low)
        better = f(left) < f(right) if strict else f(left) <= f(right)
        if better != swap:
            high = right
        else:
            low = left
    return 0.5 * (low + high) if answer == "middle" else low


def my_golden_section__thirds(f, low, high, tolerance):
    return _golden(f, low, high, tolerance, r=2 / 3)


def my_golden_section__keeps_the_worse_side(f, low, high, tolerance):
    return _golden(f, low, high, tolerance, swap=True)


def my_golden_section__right_end_moves_in_a_draw(f, low, high, tolerance):
    return _golden(f, low, high, tolerance, strict=False)


def my_golden_section__lower_end_is_the_answer(f, low, high, tolerance):
    return _golden(f, low, high, tolerance, answer="low")


def my_golden_section__stops_one_step_early(f, low, high, tolerance):
    return _golden(f, low, high, tolerance / 0.7)


def my_golden_section__values_not_moved_with_the_points(f, low, high, tolerance):
    r = (np.sqrt(5.0) - 1.0) / 2.0
    left, right = high - r * (high - low), low + r * (high - low)
    f_left, f_right = f(left), f(right)
    while high - low > tolerance:
        if f_left < f_right:
            high, right = right, left
            left = high - r * (high - low)
            f_left = f(left)
        else:
            low, left = left, right
            right = low + r * (high - low)
            f_right = f(right)
    return 0.5 * (low + high)


def _best_alpha(f, samples, low=-0.25, high=1.25, refine=True, whole=False, keep=True, reach=1):
    grid = np.linspace(low, high, samples)
    values = [f(alpha) for alpha in grid]
    n = int(np.argmin(values))
    if not refine:
        return grid[n]
    ends = (low, high) if whole else (grid[max(n - reach, 0)], grid[min(n + 1, samples - 1)])
    alpha = _golden(f, *ends, 1e-5)
    return alpha if f(alpha) <= values[n] or not keep else grid[n]


def my_best_alpha__samples_alone(f, samples):
    return _best_alpha(f, samples, refine=False)


def my_best_alpha__from_zero_to_one(f, samples):
    return _best_alpha(f, samples, low=0.0, high=1.0)


def my_best_alpha__searches_the_whole_range(f, samples):
    return _best_alpha(f, samples, whole=True)


def my_best_alpha__sample_not_kept(f, samples):
    return _best_alpha(f, samples, keep=False)


def my_best_alpha__one_side_of_the_sample(f, samples):
    return _best_alpha(f, samples, reach=0)


def my_best_alpha__one_sample_fewer(f, samples):
    return _best_alpha(f, samples - 1)


def my_best_alpha__the_worst(f, samples):
    return _best_alpha(lambda u: -f(u), samples)
