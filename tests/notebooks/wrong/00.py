"""What students write in notebook 00 and should not get away with: `exercise__what_is_wrong`."""

import numpy as np


def _each(dy, r):
    return dy.reshape((-1,) + (1,) * (r.ndim - 1))


def my_sum_squares_backward__factor_forgotten(dy, r):
    return _each(dy, r) * r


def my_sum_squares_backward__upstream_forgotten(dy, r):
    return 2 * r


def my_sum_squares_backward__upstream_added_up(dy, r):
    return 2 * dy.sum() * r


def my_sum_squares_backward__sign(dy, r):
    return -2 * _each(dy, r) * r


def my_sum_squares_backward__of_a_mean(dy, r):
    return 2 * _each(dy, r) * r / r[0].size


def my_sum_squares_backward__of_a_norm(dy, r):
    return _each(dy, r) * r / np.sqrt(np.sum(r**2, axis=tuple(range(1, r.ndim)), keepdims=True))


def my_sum_squares_backward__one_number_a_clip(dy, r):
    return 2 * dy * r.reshape(len(r), -1).sum(axis=1)


def my_sum_squares_backward__written_into_r(dy, r):
    r *= 2 * _each(dy, r)
    return r
