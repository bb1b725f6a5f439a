"""Answers to 00_start_here.ipynb."""


def my_sum_squares_backward(dy, r):
    dy = dy.reshape((-1,) + (1,) * (r.ndim - 1))     # (N, 1, ...): one number a clip
    return 2 * dy * r
