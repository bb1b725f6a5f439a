"""Answers to 03_convolution_and_its_gradient.ipynb."""

import numpy as np


def my_by_hand(dy, x, w):
    return {"db": dy[0] + dy[1] + dy[2] + dy[3],
            "dw0": dy[1] * x[0] + dy[2] * x[1] + dy[3] * x[2],
            "dw1": dy[0] * x[0] + dy[1] * x[1] + dy[2] * x[2] + dy[3] * x[3],
            "dw2": dy[0] * x[1] + dy[1] * x[2] + dy[2] * x[3],
            "dx0": dy[0] * w[1] + dy[1] * w[0],
            "dx1": dy[0] * w[2] + dy[1] * w[1] + dy[2] * w[0],
            "dx2": dy[1] * w[2] + dy[2] * w[1] + dy[3] * w[0],
            "dx3": dy[2] * w[2] + dy[3] * w[1]}


def my_conv1d_backward_b(dy, x, w, b):
    return dy.sum(axis=(0, 2))                                        # clips and frames share b


def my_conv1d_backward_w(dy, x, w, b):
    T, K = x.shape[2], w.shape[2]
    left = (K - 1) // 2
    padded = np.pad(x, ((0, 0), (0, 0), (left, K - 1 - left)))        # (N, C, T + K - 1)
    dw = np.zeros_like(w)
    for k in range(K):
        # (N, O, T) @ (N, T, C), summed over N
        dw[:, :, k] = np.sum(dy @ padded[:, :, k:k + T].swapaxes(1, 2), axis=0)
    return dw


def my_conv1d_backward_x(dy, x, w, b):
    T, K = x.shape[2], w.shape[2]
    left = (K - 1) // 2
    dpadded = np.zeros((len(x), w.shape[1], T + K - 1))
    for k in range(K):
        dpadded[:, :, k:k + T] += w[:, :, k].T @ dy                   # (C, O) @ (N, O, T)
    return dpadded[:, :, left:left + T].copy()


def my_conv_transpose1d(h, w, b):
    T, K = h.shape[2], w.shape[2]
    left = (K - 1) // 2
    padded = np.zeros((len(h), w.shape[1], T + K - 1))
    for k in range(K):
        padded[:, :, k:k + T] += w[:, :, k].T @ h
    return padded[:, :, left:left + T] + b[:, None]
