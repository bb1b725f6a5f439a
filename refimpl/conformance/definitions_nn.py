r"""Every operation of `nn` a second time: loops and sums straight from the formula, one output
element after the other.

Slow, and written without a look at the fast form: where the two agree, an error would have had to
be made twice. They take float64 and, where the mathematics is analytic, complex numbers, so that
the complex step can differentiate them.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from .specification import Array

Padding = str | int | tuple[int, int]


def pads(padding: Padding, K: int, dilation: int) -> tuple[int, int]:
    """Zeros on the left and on the right.

    >>> pads("same", K=4, dilation=1)
    (1, 2)
    """
    if isinstance(padding, str):
        zeros = dilation * (K - 1) if padding == "same" else 0
        return zeros // 2, zeros - zeros // 2
    return (padding, padding) if isinstance(padding, int) else padding


def conv1d(x: Array, w: Array, b: Array | None = None, *, stride: int = 1,
           padding: Padding = "same", dilation: int = 1, groups: int = 1) -> Array:
    """`nn.conv1d`: each output element as a sum over channels and taps.

    >>> conv1d(np.array([[[1.0, 2.0, 3.0]]]), np.array([[[1.0, 0.0, -1.0]]])).tolist()
    [[[-2.0, -2.0, 2.0]]]
    """
    (N, _, T), (O, Cg, K) = x.shape, w.shape
    left, right = pads(padding, K, dilation)
    T_out = len([t for t in range(0, T + left + right, stride)
                 if t + dilation * (K - 1) < T + left + right])
    y = np.zeros((N, O, T_out), np.result_type(x, w, *([] if b is None else [b])))
    strange = not np.isfinite(w).all()
    for o, t in np.ndindex(O, T_out):
        first = o // (O // groups) * Cg
        for k in range(K):                                # all clips, and the Cg channels, at once
            s = t * stride + k * dilation - left
            if 0 <= s < T:
                y[:, o, t] += x[:, first:first + Cg, s] @ w[o, :, k]
            elif strange:                                        # 0 times infinity is NaN
                y[:, o, t] += (w[o, :, k] * 0.0).sum()
        if b is not None:
            y[:, o, t] += b[o]
    return y


def conv_transpose1d(h: Array, w: Array, b: Array | None = None, *, stride: int = 1,
                     padding: Padding = "same", output_padding: int = 0, dilation: int = 1,
                     groups: int = 1) -> Array:
    """`nn.conv_transpose1d`: each input element is spread by each of its taps."""
    (N, O, T), (_, Cg, K) = h.shape, w.shape
    left, right = pads(padding, K, dilation)
    length = (T - 1) * stride + dilation * (K - 1) + 1 - left - right + output_padding
    x = np.zeros((N, Cg * groups, length), np.result_type(h, w, *([] if b is None else [b])))
    for n, o, t in np.ndindex(h.shape):
        first = o // (O // groups) * Cg
        for c, k in np.ndindex(Cg, K):
            s = t * stride + k * dilation - left
            if 0 <= s < length:
                x[n, first + c, s] += w[o, c, k] * h[n, o, t]
    return x if b is None else x + b[None, :, None]


def window_positions(T: int, width: int, *, stride: int | None = None, padding: int = 0,
                     dilation: int = 1, ceil_mode: bool = False) -> list[list[int]]:
    """Lists of positions, one a window, some outside 0 .. T - 1.

    >>> window_positions(5, 2, ceil_mode=True)
    [[0, 1], [2, 3], [4, 5]]
    """
    stride, first = stride or width, -padding
    found: list[list[int]] = []
    while True:
        last = first + dilation * (width - 1)
        whole = last < T + padding
        begun = first < T and (not found
                               or first - stride + dilation * (width - 1) < T + padding - 1)
        if not (whole or (ceil_mode and begun)):
            return found
        found.append([first + k * dilation for k in range(width)])
        first += stride


def max_pool1d(x: Array, width: int = 2, **windows: Any) -> Array:
    """`nn.max_pool1d`: the largest element of each window, NaN where it holds one.

    windows : as for `window_positions`
    """
    if np.iscomplexobj(x):
        raise TypeError("the largest of complex numbers is not analytic")
    positions = window_positions(x.shape[2], width, **windows)
    y = np.full(x.shape[:2] + (len(positions),), -np.inf)
    for n, c, t in np.ndindex(y.shape):
        for s in positions[t]:
            if 0 <= s < x.shape[2] and not np.isnan(y[n, c, t]) and not x[n, c, s] <= y[n, c, t]:
                y[n, c, t] = x[n, c, s]
    return y


def max_pool1d_indices(x: Array, width: int = 2, **windows: Any) -> Array:
    """`nn.max_pool1d_indices`: the first frame of each window that holds the largest element."""
    positions = window_positions(x.shape[2], width, **windows)
    best = max_pool1d(x, width, **windows)
    indices = np.zeros(best.shape, int)
    for n, c, t in np.ndindex(best.shape):
        same = [s for s in positions[t] if 0 <= s < x.shape[2] and
                (x[n, c, s] == best[n, c, t] or np.isnan(best[n, c, t]) and np.isnan(x[n, c, s]))]
        indices[n, c, t] = same[0] if same else -1
    return indices


def max_unpool1d(h: Array, indices: Array, length: int) -> Array:
    """`nn.max_unpool1d`: each value in the frame that it came from, the later of two in one."""
    x = np.zeros(h.shape[:2] + (length,), h.dtype)
    for n, c, t in np.ndindex(h.shape):
        x[n, c, indices[n, c, t]] = h[n, c, t]
    return x


def avg_pool1d(x: Array, width: int = 2, *, count_include_pad: bool = True, padding: int = 0,
               **windows: Any) -> Array:
    """`nn.avg_pool1d`: the mean of each window, over its frames or its padding too."""
    T = x.shape[2]
    positions = window_positions(T, width, padding=padding, **windows)
    y = np.zeros(x.shape[:2] + (len(positions),), x.dtype)
    for n, c, t in np.ndindex(y.shape):
        inside = [s for s in positions[t] if 0 <= s < T]
        counted = [s for s in positions[t] if s < T + padding] if count_include_pad else inside
        y[n, c, t] = sum(x[n, c, s] for s in inside) / len(counted)
    return y


def avg_depool1d(h: Array, width: int = 2) -> Array:
    """`nn.avg_depool1d`: each value shared equally by the frames of its window."""
    x = np.zeros(h.shape[:2] + (width * h.shape[2],), h.dtype)
    for n, c, t in np.ndindex(x.shape):
        x[n, c, t] = h[n, c, t // width] / width
    return x


def random_depool1d(h: Array, chosen: Array, width: int = 2) -> Array:
    """`nn.random_depool1d`: each value in the chosen frame of its window."""
    x = np.zeros(h.shape[:2] + (width * h.shape[2],), h.dtype)
    for n, c, t in np.ndindex(h.shape):
        x[n, c, width * t + chosen[n, c, t]] = h[n, c, t]
    return x


def relu(x: Array) -> Array:
    """`nn.relu`: x where it is above 0 or NaN, else 0."""
    return np.where(np.isnan(x) | (x > 0), x, 0.0)


def gram(h: Array) -> Array:
    """`nn.gram`: H H^T of each clip."""
    return np.einsum("nct,ndt->ncd", h, h)


def sum_squares(r: Array) -> Array:
    """`nn.sum_squares`, one number a clip."""
    return np.array([sum(v * v for v in clip.ravel()) for clip in r], dtype=r.dtype)


def mean_squares(r: Array) -> Array:
    """`nn.mean_squares`, one number a clip."""
    return np.array([sum(v * v for v in clip.ravel()) / clip.size for clip in r], dtype=r.dtype)


def norm(r: Array) -> Array:
    """`nn.norm`, one number a clip."""
    return np.sqrt(sum_squares(r))


def size_of(v: Any) -> Any:
    """|v| of a real number, and its analytic continuation for the complex step (|v| of a complex
    number is none)."""
    return -v if np.real(v) < 0 else v


def l1(a: Array) -> Array:
    """`nn.l1`: the sum of all absolute values."""
    return np.asarray(sum(size_of(v) for v in a.ravel()) + 0.0)


def squared_error(x: Array, y: Array, *, reduction: str = "mean") -> Array:
    """`nn.squared_error`, element by element."""
    return reduced([(a - b) * (a - b) for a, b in zip(x.ravel(), y.ravel())], x.shape, reduction)


def absolute_error(x: Array, y: Array, *, reduction: str = "mean") -> Array:
    """`nn.absolute_error`, element by element."""
    return reduced([abs(a - b) for a, b in zip(x.ravel(), y.ravel())], x.shape, reduction)


def reduced(errors: Sequence[Any], shape: tuple[int, ...], reduction: str) -> Array:
    """Errors of single elements, their sum or their mean."""
    if reduction == "none":
        return np.array(errors).reshape(shape)
    return np.asarray(sum(errors) / (len(errors) if reduction == "mean" else 1))


def adam_step(p: Array, g: Array, m: Array, v: Array, *, t: int, rate: float = 1e-3,
              beta1: float = 0.9, beta2: float = 0.999, epsilon: float = 1e-8) -> tuple[Array, ...]:
    """One step of Adam for one array, element by element; t counts this step.   ->  p, m, v"""
    results = np.zeros((3, p.size))
    for i, (p_i, g_i, m_i, v_i) in enumerate(zip(p.ravel(), g.ravel(), m.ravel(), v.ravel())):
        m_i, v_i = beta1 * m_i + (1 - beta1) * g_i, beta2 * v_i + (1 - beta2) * g_i ** 2
        step = m_i / (1 - beta1 ** t) / (np.sqrt(v_i / (1 - beta2 ** t)) + epsilon)
        results[:, i] = p_i - rate * step, m_i, v_i
    return tuple(r.reshape(p.shape) for r in results)
