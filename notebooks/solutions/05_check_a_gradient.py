"""Answers to 05_check_a_gradient.ipynb."""

import numpy as np


def my_differences(f, x, dy, h):
    gradient = np.zeros(x.shape)
    for index in np.ndindex(x.shape):
        v = np.zeros(x.shape)
        v[index] = h
        gradient[index] = np.sum(dy * (f(x + v) - f(x - v))) / (2 * h)
    return gradient


def my_complex_step(f, x, dy, h=1e-30):
    gradient = np.zeros(x.shape)
    for index in np.ndindex(x.shape):
        z = x.astype(complex)
        z[index] += 1j * h
        gradient[index] = np.sum(dy * np.imag(f(z))) / h
    return gradient


def my_verdict(f, f_backward, x):
    dy = np.random.default_rng(0).normal(size=f(x).shape)             # never ones
    h = 1e-5 * np.sqrt(np.mean(x**2))                                 # relative to the size of x
    measured = np.zeros(x.shape)
    for index in np.ndindex(x.shape):
        v = np.zeros(x.shape)
        v[index] = h
        measured[index] = np.sum(dy * (f(x + v) - f(x - v))) / (2 * h)
    claimed = f_backward(dy, x)
    if claimed.shape != x.shape:
        return False
    return bool(np.abs(claimed - measured).max() <= 1e-6 * np.abs(measured).max())


def my_gram_backward(dG, h):
    # h stands in a row and in a column of G
    return (dG + dG.swapaxes(1, 2)) @ h


def my_mean_squares_backward(dM, r):
    return 2 * dM[:, None, None] * r / r[0].size                      # the mean is over one clip


def my_conv1d_backward_x(dy, x, w):
    T, K = x.shape[2], w.shape[2]
    padded = np.pad(dy, ((0, 0), (0, 0), (K // 2, K // 2)))
    dx = np.zeros_like(x)
    for k in range(K):
        dx += w[:, :, K - 1 - k].T @ padded[:, :, k:k + T]            # the filter reversed
    return dx
