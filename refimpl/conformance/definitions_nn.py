r"""Every operation of `nn` a second time: loops and sums straight from the formula, one output
element after the other.

Slow, and written without a look at the fast form: where the two agree, an error would have had to
be made twice. They take float64 and, where the mathematics is analytic, complex numbers, so that
the complex step can differentiate them.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np


def pads(padding: str | int | tuple, K: int, dilation: int) -> tuple[int, int]:
    """Zeros on the left and on the right."""
    if padding == "valid":
        return 0, 0
    if padding == "same":
        zeros = dilation * (K - 1)
        return zeros // 2, zeros - zeros // 2
    return (padding, padding) if isinstance(padding, int) else tuple(padding)


def conv1d(x: np.ndarray, w: np.ndarray, b: np.ndarray | None = None, *, stride: int = 1,
           padding: str | int | tuple = "same", dilation: int = 1, groups: int = 1) -> np.ndarray:
    (N, C, T), (O, Cg, K) = x.shape, w.shape
    left, right = pads(padding, K, dilation)
    T_out = len([t for t in range(0, T + left + right, stride)
                 if t + dilation * (K - 1) < T + left + right])
    y = np.zeros((N, O, T_out), np.result_type(x, w, *([] if b is None else [b])))
    strange = not np.isfinite(w).all()
    for n, o, t in np.ndindex(y.shape):
        first = o // (O // groups) * Cg
        for c in range(Cg):
            for k in range(K):
                s = t * stride + k * dilation - left
                if 0 <= s < T:
                    y[n, o, t] += w[o, c, k] * x[n, first + c, s]
                elif strange:                                    # 0 times infinity is NaN
                    y[n, o, t] += w[o, c, k] * 0.0
        if b is not None:
            y[n, o, t] += b[o]
    return y


def conv_transpose1d(h: np.ndarray, w: np.ndarray, b: np.ndarray | None = None, *, stride: int = 1,
                     padding: str | int | tuple = "same", output_padding: int = 0,
                     dilation: int = 1, groups: int = 1) -> np.ndarray:
    (N, O, T), (_, Cg, K) = h.shape, w.shape
    left, right = pads(padding, K, dilation)
    length = (T - 1) * stride + dilation * (K - 1) + 1 - left - right + output_padding
    x = np.zeros((N, Cg * groups, length), np.result_type(h, w, *([] if b is None else [b])))
    for n, o, t in np.ndindex(h.shape):
        first = o // (O // groups) * Cg
        for c in range(Cg):
            for k in range(K):
                s = t * stride + k * dilation - left
                if 0 <= s < length:
                    x[n, first + c, s] += w[o, c, k] * h[n, o, t]
    return x if b is None else x + b[None, :, None]


def window_positions(T: int, width: int, stride: int | None, padding: int, dilation: int,
                     ceil_mode: bool) -> list[list[int]]:
    """Lists of positions, one a window, some outside 0 .. T - 1."""
    stride, found, first = stride or width, [], -padding
    while True:
        last = first + dilation * (width - 1)
        whole = last < T + padding
        begun = first < T and (not found
                               or first - stride + dilation * (width - 1) < T + padding - 1)
        if not (whole or (ceil_mode and begun)):
            return found
        found.append([first + k * dilation for k in range(width)])
        first += stride


def max_pool1d(x: np.ndarray, width: int = 2, *, stride: int | None = None, padding: int = 0,
               dilation: int = 1, ceil_mode: bool = False) -> np.ndarray:
    if np.iscomplexobj(x):
        raise TypeError("the largest of complex numbers is not analytic")
    windows = window_positions(x.shape[2], width, stride, padding, dilation, ceil_mode)
    y = np.full(x.shape[:2] + (len(windows),), -np.inf)
    for n, c, t in np.ndindex(y.shape):
        for s in windows[t]:
            if 0 <= s < x.shape[2] and not np.isnan(y[n, c, t]) and not x[n, c, s] <= y[n, c, t]:
                y[n, c, t] = x[n, c, s]
    return y


def max_pool1d_indices(x: np.ndarray, width: int = 2, *, stride: int | None = None,
                       padding: int = 0, dilation: int = 1, ceil_mode: bool = False) -> np.ndarray:
    windows = window_positions(x.shape[2], width, stride, padding, dilation, ceil_mode)
    best = max_pool1d(x, width, stride=stride, padding=padding, dilation=dilation,
                      ceil_mode=ceil_mode)
    indices = np.zeros(best.shape, int)
    for n, c, t in np.ndindex(best.shape):
        same = [s for s in windows[t] if 0 <= s < x.shape[2]
                and (x[n, c, s] == best[n, c, t]
                     or np.isnan(best[n, c, t]) and np.isnan(x[n, c, s]))]
        indices[n, c, t] = same[0] if same else -1
    return indices


def max_unpool1d(h: np.ndarray, indices: np.ndarray, length: int) -> np.ndarray:
    x = np.zeros(h.shape[:2] + (length,), h.dtype)
    for n, c, t in np.ndindex(h.shape):
        x[n, c, indices[n, c, t]] = h[n, c, t]
    return x


def avg_pool1d(x: np.ndarray, width: int = 2, *, stride: int | None = None, padding: int = 0,
               ceil_mode: bool = False, count_include_pad: bool = True) -> np.ndarray:
    T = x.shape[2]
    windows = window_positions(T, width, stride, padding, 1, ceil_mode)
    y = np.zeros(x.shape[:2] + (len(windows),), x.dtype)
    for n, c, t in np.ndindex(y.shape):
        inside = [s for s in windows[t] if 0 <= s < T]
        counted = [s for s in windows[t] if s < T + padding] if count_include_pad else inside
        y[n, c, t] = sum(x[n, c, s] for s in inside) / len(counted)
    return y


def avg_depool1d(h: np.ndarray, width: int = 2) -> np.ndarray:
    x = np.zeros(h.shape[:2] + (width * h.shape[2],), h.dtype)
    for n, c, t in np.ndindex(x.shape):
        x[n, c, t] = h[n, c, t // width] / width
    return x


def random_depool1d(h: np.ndarray, chosen: np.ndarray, width: int = 2) -> np.ndarray:
    x = np.zeros(h.shape[:2] + (width * h.shape[2],), h.dtype)
    for n, c, t in np.ndindex(h.shape):
        x[n, c, width * t + chosen[n, c, t]] = h[n, c, t]
    return x


def relu(x: np.ndarray) -> np.ndarray:
    return np.where(np.isnan(x) | (x > 0), x, 0.0)


def gram(h: np.ndarray) -> np.ndarray:
    return np.einsum("nct,ndt->ncd", h, h)


def sum_squares(r: np.ndarray) -> np.ndarray:
    return np.array([sum(v * v for v in clip.ravel()) for clip in r], dtype=r.dtype)


def mean_squares(r: np.ndarray) -> np.ndarray:
    return np.array([sum(v * v for v in clip.ravel()) / clip.size for clip in r], dtype=r.dtype)


def norm(r: np.ndarray) -> np.ndarray:
    return np.sqrt(sum_squares(r))


def l1(a: np.ndarray) -> np.ndarray:
    return np.asarray(sum(abs(v) for v in a.ravel()), dtype=float)


def squared_error(x: np.ndarray, y: np.ndarray, *, reduction: str = "mean") -> np.ndarray:
    return reduced([(a - b) * (a - b) for a, b in zip(x.ravel(), y.ravel())], x.shape, reduction)


def absolute_error(x: np.ndarray, y: np.ndarray, *, reduction: str = "mean") -> np.ndarray:
    return reduced([abs(a - b) for a, b in zip(x.ravel(), y.ravel())], x.shape, reduction)


def reduced(errors: Sequence[Any], shape: tuple[int, ...], reduction: str) -> np.ndarray:
    """Errors of single elements, their sum or their mean."""
    if reduction == "none":
        return np.array(errors).reshape(shape)
    return np.asarray(sum(errors) / (len(errors) if reduction == "mean" else 1))


def adam(p: np.ndarray, g: np.ndarray, m: np.ndarray, v: np.ndarray, *, t: int, rate: float,
         beta1: float, beta2: float, epsilon: float,
         variant: str = "kingma-ba") -> tuple[np.ndarray, ...]:
    """One step of algorithm 1 for one array, element by element; t counts this step.

    ->  p, m, v
    """
    results = np.zeros((3, p.size))
    for i, (p_i, g_i, m_i, v_i) in enumerate(zip(p.ravel(), g.ravel(), m.ravel(), v.ravel())):
        m_i, v_i = beta1 * m_i + (1 - beta1) * g_i, beta2 * v_i + (1 - beta2) * g_i ** 2
        if variant == "epsilon-hat":
            step = np.sqrt(1 - beta2 ** t) / (1 - beta1 ** t) * m_i / (np.sqrt(v_i) + epsilon)
        elif variant == "no-bias-correction":
            step = m_i / (np.sqrt(v_i) + epsilon)
        else:
            step = m_i / (1 - beta1 ** t) / (np.sqrt(v_i / (1 - beta2 ** t)) + epsilon)
        results[:, i] = p_i - rate * step, m_i, v_i
    return tuple(r.reshape(p.shape) for r in results)
