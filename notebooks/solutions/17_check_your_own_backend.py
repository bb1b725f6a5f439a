"""Answers to 17_check_your_own_backend.ipynb."""

import ast

import numpy as np


def my_backend():
    def relu(x):
        if x.dtype.kind != "f":
            raise ValueError(f"x: found {x.dtype}, needed floating-point numbers")
        # NaN wins every comparison of np.maximum
        return np.maximum(x, x.dtype.type(0))

    def relu_backward(dy, x):
        return np.where(x > 0, dy, dy.dtype.type(0))

    def avg_depool1d(h, width=2):
        if h.ndim != 3 or h.shape[2] < 1 or width < 1:
            raise ValueError(f"found shape {h.shape} and width {width}, needed 3 axes, frames, and "
                             "a width from 1 on")
        return np.repeat(h, width, axis=2) / h.dtype.type(width)

    def avg_depool1d_backward(dx, h, width=2):
        return dx.reshape(*h.shape, width).sum(axis=3) / dx.dtype.type(width)

    return {"relu": relu, "relu_backward": relu_backward, "avg_depool1d": avg_depool1d,
            "avg_depool1d_backward": avg_depool1d_backward}


def my_conv1d_backward(dy, x, w, b=None, *, stride=1, padding="same", dilation=1, groups=1):
    (N, C, T), (O, _, K), T_out = x.shape, w.shape, dy.shape[2]
    zeros = dilation * (K - 1)
    if padding == "same":
        # the smaller half to the left: an even width shows it
        left, right = zeros // 2, zeros - zeros // 2
    elif padding == "valid":
        left, right = 0, 0
    else:
        left, right = padding if isinstance(padding, tuple) else (padding, padding)
    padded = np.pad(x, ((0, 0), (0, 0), (left, right)))
    at = stride * np.arange(T_out)[:, None] + dilation * np.arange(K)
    windows = padded[:, :, at].reshape(N, groups, C // groups, T_out, K)
    filters = w.reshape(groups, O // groups, C // groups, K)
    D = dy.reshape(N, groups, O // groups, T_out)

    dw = np.einsum("ngot,ngctk->gock", D, windows, optimize=True).reshape(w.shape)
    d_windows = np.einsum("ngot,gock->ngctk", D, filters, optimize=True).reshape(N, C, T_out, K)
    d_padded = np.zeros_like(padded)
    # += keeps one of the values that meet at a place
    np.add.at(d_padded, (slice(None), slice(None), at), d_windows)
    dx = d_padded[:, :, left:left + T]
    # a sum over clips: the loss has its own mean, if any
    db = None if b is None else dy.sum(axis=(0, 2))
    return dx, dw, db


def my_read_npy(data):
    length = int.from_bytes(data[8:10], "little")
    header = ast.literal_eval(data[10:10 + length].decode("latin1"))
    return np.frombuffer(data[10 + length:], np.dtype(header["descr"])).reshape(header["shape"])
