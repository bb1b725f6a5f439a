"""What students write in notebook 13 and should not get away with: `exercise__what_is_wrong`."""

import numpy as np


def _transform(n, *, odd=1, sign=-1, half=True, mixed=False):
    omega = np.pi * (2 * np.arange(n // 2) + odd) / n
    angles = omega[:, None] * np.arange(n)
    if mixed:
        return np.stack([np.cos(angles), -np.sin(angles)], axis=1).reshape(n, n)
    return np.concatenate([np.cos(angles), sign * np.sin(angles)])


def my_transform__even_frequencies(n):
    return _transform(n, odd=0)


def my_transform__sine_without_its_minus(n):
    return _transform(n, sign=1)


def my_transform__made_orthonormal(n):
    return _transform(n) * np.sqrt(2 / n)


def my_transform__the_other_angle(n):
    return _transform(n).T


def my_three_products__real_and_imaginary_exchanged(a, b, c, d):
    return a @ d + b @ c, a @ c - b @ d


def my_three_products__sign_of_the_second_term(a, b, c, d):
    return a @ c + b @ d, a @ d + b @ c


def my_three_products__conjugate(a, b, c, d):
    return a @ c + b @ d, b @ c - a @ d


def my_three_products__element_by_element(a, b, c, d):
    q0 = (a + b).sum(axis=2, keepdims=True) * c.sum(axis=1, keepdims=True)
    q1, q2 = (a.sum(axis=2, keepdims=True) * (d - c).sum(axis=1, keepdims=True),
              -b.sum(axis=2, keepdims=True) * (c + d).sum(axis=1, keepdims=True))
    return q0 + q2, q0 + q1


def _save(x, K, n, correlate, *, step=None, keep=None, cut=True):
    L = n - K + 1
    wanted = len(x) - K + 1
    padded = np.concatenate([x, np.zeros(2 * n)])
    pieces = [correlate(padded[begin:begin + n])[:keep] for begin in range(0, wanted, step or L)]
    joined = np.concatenate(pieces)
    return joined[:wanted] if cut else joined


def my_overlap_save__tiles_side_by_side(x, K, n, correlate):
    return np.resize(_save(x, K, n, correlate, step=n), len(x) - K + 1)


def my_overlap_save__one_frame_too_far(x, K, n, correlate):
    return np.resize(_save(x, K, n, correlate, step=n - K + 2), len(x) - K + 1)


def my_overlap_save__not_cut(x, K, n, correlate):
    return _save(x, K, n, correlate, cut=False)


def my_overlap_save__as_long_as_the_input(x, K, n, correlate):
    return np.resize(_save(np.concatenate([x, np.zeros(K - 1)]), K, n, correlate), len(x))


def my_overlap_save__begins_before_the_signal(x, K, n, correlate):
    return _save(np.concatenate([np.zeros(1), x]), K, n, correlate)[:-1]


def my_overlap_save__one_frame_of_each_tile(x, K, n, correlate):
    return np.array([correlate(np.concatenate([x[t:], np.zeros(n)])[:n])[0]
                     for t in range(len(x) - K + 1)])


def my_overlap_save__zeros_only_where_a_whole_tile_is_missing(x, K, n, correlate):
    L = n - K + 1
    pieces = [correlate(x[begin:begin + n]) for begin in range(0, len(x) - K + 1, L)]
    return np.concatenate(pieces)[:len(x) - K + 1]


def my_three_products__four_of_them(a, b, c, d):
    return a @ c - b @ d, a @ d + b @ c
