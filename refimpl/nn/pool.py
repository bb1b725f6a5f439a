r"""Pooling over time: the largest or the mean of each window, and the ways back up.

Window t holds the positions `t stride + k dilation - padding`, k = 0 .. width - 1, of the input.
"""

import numpy as np

from .arguments import check_arrays, check_shape, check_whole
from .sums import power_of_two, wide_sum


def max_pool1d(x: np.ndarray, width: int = 2, *, stride: int | None = None, padding: int = 0,
               dilation: int = 1, ceil_mode: bool = False) -> np.ndarray:
    r"""The largest element of each window (Holden 2017, Psi of eq. 1: width 2).

        y[n, c, t] = max_k x[n, c, t stride + k dilation - padding]

    x : (N, C, T)  ->  (N, C, T_out). stride : the width unless given. A NaN in a window is its
    largest element. Padding counts as -inf. With ceil_mode a last, incomplete window counts, if it
    begins inside the input or the left padding.

    >>> max_pool1d(np.array([[[1.0, 5, 7, 3]]]))
    array([[[5., 7.]]])
    """
    return _take(x, max_pool1d_indices(x, width, stride=stride, padding=padding, dilation=dilation,
                                       ceil_mode=ceil_mode))


def max_pool1d_backward(dy: np.ndarray, x: np.ndarray, width: int = 2, *, stride: int | None = None,
                        padding: int = 0, dilation: int = 1, ceil_mode: bool = False) -> np.ndarray:
    r"""All of a window's gradient goes to its first largest element (the tie rule); windows that
    overlap add up.

        dx[n, c, s] = sum over windows t whose first largest element is s of dy[n, c, t]

    dy : (N, C, T_out), x : (N, C, T)  ->  (N, C, T)

    >>> max_pool1d_backward(np.array([[[10.0, 20]]]), np.array([[[1.0, 5, 7, 7]]]))
    array([[[ 0., 10., 20.,  0.]]])
    """
    indices = max_pool1d_indices(x, width, stride=stride, padding=padding, dilation=dilation,
                                 ceil_mode=ceil_mode)
    check_arrays(x=x, dy=dy, real=True)
    check_shape("dy", dy, indices.shape, ", the shape of the output")
    return _put(dy, indices, x.shape[2])


def max_pool1d_indices(x: np.ndarray, width: int = 2, *, stride: int | None = None,
                       padding: int = 0, dilation: int = 1, ceil_mode: bool = False) -> np.ndarray:
    """Where in the input each window's first largest element stands; -1 for a window that holds
    padding alone (dilation can make one).

    x : (N, C, T)  ->  (N, C, T_out) of int64

    >>> max_pool1d_indices(np.array([[[1.0, 5, 7, 7]]]))
    array([[[1, 2]]])
    """
    check_arrays(x=x, ndim={"x": 3}, real=True)
    positions = _windows(x.shape[2], width, stride, padding, dilation, ceil_mode)  # (T_out, width)
    if (np.array_equal(positions.ravel(), np.arange(positions.size))
            and positions.size <= x.shape[2]):     # the plain case: windows cut x in pieces
        side_by_side = x[:, :, :positions.size].reshape(x.shape[:2] + positions.shape)
        return np.argmax(side_by_side, axis=-1) + positions[:, 0]
    inside = (positions >= 0) & (positions < x.shape[2])
    # (N, C, T_out, width)
    candidates = np.where(inside, x[:, :, np.clip(positions, 0, x.shape[2] - 1)], -np.inf)
    k = np.argmax(candidates, axis=-1)             # the first largest; NaN counts as largest
    t = np.arange(len(positions))
    # In a window of -inf alone: its first real element, not the padding.
    k = np.where(inside[t, k], k, np.argmax(inside, axis=1))
    return np.where(inside.any(axis=1), positions[t, k], -1)


def max_unpool1d(h: np.ndarray, indices: np.ndarray, length: int) -> np.ndarray:
    r"""Put each value where `max_pool1d_indices` found it, zeros elsewhere. Where two windows chose
    one position the last value stands.

    h, indices : (N, C, T)  ->  (N, C, length)

    >>> max_unpool1d(np.array([[[5.0, 7]]]), np.array([[[1, 2]]]), 4)
    array([[[0., 5., 7., 0.]]])
    """
    _check_unpool(h, indices, length)
    return _place(h, indices, length)


def max_unpool1d_backward(dx: np.ndarray, h: np.ndarray, indices: np.ndarray,
                          length: int) -> np.ndarray:
    """Every value gets the gradient of its place, but a value that a later one overwrote gets none.

    dx : (N, C, length)  ->  (N, C, T)

    >>> dx, h = np.array([[[1.0, 2, 3, 4]]]), np.array([[[5.0, 7]]])
    >>> max_unpool1d_backward(dx, h, np.array([[[1, 2]]]), 4)
    array([[[2., 3.]]])
    """
    _check_unpool(h, indices, length)
    check_arrays(h=h, dx=dx)
    check_shape("dx", dx, h.shape[:2] + (length,), ", the shape of the output")
    order = np.broadcast_to(np.arange(h.shape[2]), h.shape)
    stands = np.take_along_axis(_place(order, indices, length), indices, axis=2) == order
    return np.where(stands, np.take_along_axis(dx, indices, axis=2), dx.dtype.type(0))


def avg_pool1d(x: np.ndarray, width: int = 2, *, stride: int | None = None, padding: int = 0,
               ceil_mode: bool = False, count_include_pad: bool = True) -> np.ndarray:
    r"""The mean of each window.

        y[n, c, t] = (1 / n_t) sum_k x[n, c, t stride + k - padding]

    n_t : elements of the window inside the input and, with count_include_pad, its padding; what
    hangs over the end because of ceil_mode never counts.   x : (N, C, T)  ->  (N, C, T_out)

    >>> avg_pool1d(np.array([[[1.0, 5, 7, 3]]]))
    array([[[3., 5.]]])
    """
    check_arrays(x=x, ndim={"x": 3})
    positions, count = _counts(x, width, stride, padding, ceil_mode, count_include_pad)
    # The last window begins inside.
    padded = np.pad(x, ((0, 0), (0, 0), (int(padding), int(width))))
    return _mean(padded[:, :, positions + int(padding)], count)


def avg_pool1d_backward(dy: np.ndarray, x: np.ndarray, width: int = 2, *, stride: int | None = None,
                        padding: int = 0, ceil_mode: bool = False,
                        count_include_pad: bool = True) -> np.ndarray:
    r"""dx[n, c, s] = sum over windows t that hold s of dy[n, c, t] / n_t.

    dy : (N, C, T_out)  ->  (N, C, T)

    >>> avg_pool1d_backward(np.array([[[10.0, 20]]]), np.zeros((1, 1, 4)))
    array([[[ 5.,  5., 10., 10.]]])
    """
    check_arrays(x=x, dy=dy, ndim={"x": 3})
    positions, count = _counts(x, width, stride, padding, ceil_mode, count_include_pad)
    check_shape("dy", dy, x.shape[:2] + (len(positions),), ", the shape of the output")
    share, begin = dy / count, int(padding)
    wide = np.promote_types(share.dtype, np.float64)             # as many terms as windows overlap
    dpadded = np.zeros(x.shape[:2] + (begin + x.shape[2] + int(width),), wide)
    for k in range(positions.shape[1]):            # element k of every window: no position twice
        dpadded[:, :, positions[:, k] + begin] += share
    return dpadded[:, :, begin:begin + x.shape[2]].astype(share.dtype)


def avg_depool1d(h: np.ndarray, width: int = 2) -> np.ndarray:
    r"""Average-depooling (Holden 2017, Psi-dagger of eq. 2): each value `width` times over, divided
    by width.

        x[n, c, t] = h[n, c, floor(t / width)] / width

    h : (N, C, T)  ->  (N, C, width T)

    >>> avg_depool1d(np.array([[[2.0, 4]]]))
    array([[[1., 1., 2., 2.]]])
    """
    check_arrays(h=h, ndim={"h": 3})
    _check_frames(h)
    return np.repeat(h / _real(h, check_whole("width", width, 1)), width, axis=2)


def avg_depool1d_backward(dx: np.ndarray, h: np.ndarray, width: int = 2) -> np.ndarray:
    r"""dh[n, c, t] = (1 / width) sum_k dx[n, c, width t + k].   dx : (N, C, width T)  ->  (N, C, T)

    >>> avg_depool1d_backward(np.array([[[1.0, 3, 5, 7]]]), np.zeros((1, 1, 2)))
    array([[[2., 6.]]])
    """
    check_arrays(h=h, dx=dx, ndim={"h": 3})
    check_whole("width", width, 1)
    _check_frames(h)
    check_shape("dx", dx, h.shape[:2] + (width * h.shape[2],), ", the shape of the output")
    return _mean(dx.reshape(h.shape + (width,)), _real(dx, width))


def random_depool1d(h: np.ndarray, chosen: np.ndarray, width: int = 2) -> np.ndarray:
    r"""Depooling by chance: of the `width` frames that a value may have come from, one gets all of
    it and the others 0. The loss network of the 2016 authors' code learns with it and runs with
    `avg_depool1d`, which is its mean over all choices.

        x[n, c, width t + k] = h[n, c, t]  if k = chosen[n, c, t],  else 0

    h : (N, C, T);  chosen : (N, C, T) of whole numbers from 0 to width - 1, drawn by the caller, so
    that the function itself is a function   ->  (N, C, width T)

    >>> random_depool1d(np.array([[[2.0, 4]]]), np.array([[[1, 0]]]))
    array([[[0., 2., 4., 0.]]])
    """
    places = _places(h, chosen, width)
    return _place(h, places, width * h.shape[2])


def random_depool1d_backward(dx: np.ndarray, h: np.ndarray, chosen: np.ndarray,
                             width: int = 2) -> np.ndarray:
    r"""dh[n, c, t] = dx[n, c, width t + chosen[n, c, t]]; the choice is a constant.

    dx : (N, C, width T)  ->  (N, C, T)

    >>> dx, h = np.array([[[1.0, 3, 5, 7]]]), np.zeros((1, 1, 2))
    >>> random_depool1d_backward(dx, h, np.array([[[1, 0]]]))
    array([[[3., 5.]]])
    """
    places = _places(h, chosen, width)
    check_arrays(h=h, dx=dx)
    check_shape("dx", dx, h.shape[:2] + (width * h.shape[2],), ", the shape of the output")
    return np.take_along_axis(dx, places, axis=2)


def _windows(T, width, stride, padding, dilation, ceil_mode):
    """Positions of every window's elements in the input, some of them outside it.

    ->  (T_out, width)
    """
    width, dilation = check_whole("width", width, 1), check_whole("dilation", dilation, 1)
    stride = width if stride is None else check_whole("stride", stride, 1)
    padding = check_whole("padding", padding, 0)
    if 2 * padding > width:
        raise ValueError(f"padding: found {padding}, needed at most half of width {width}")
    reach = dilation * (width - 1) + 1
    free = T + 2 * padding - reach
    T_out = (-(-free // stride) if ceil_mode else free // stride) + 1
    if T < 1 or T_out < 1:
        raise ValueError(f"x: found {T} frames and {padding} of padding on both sides, needed at "
                         f"least {reach} for one window of width {width} with dilation {dilation}")
    if ceil_mode and (T_out - 1) * stride >= T + padding:
        T_out -= 1
    return np.arange(T_out)[:, None] * stride + np.arange(width) * dilation - padding


def _counts(x, width, stride, padding, ceil_mode, count_include_pad):
    """Positions (T_out, width), and how many of each window's elements its mean counts (T_out,), in
    x's precision."""
    positions, padding = _windows(x.shape[2], width, stride, padding, 1, ceil_mode), int(padding)
    counted = ((positions >= (-padding if count_include_pad else 0))
               & (positions < x.shape[2] + (padding if count_include_pad else 0)))
    return positions, counted.sum(axis=1).astype(x.real.dtype)


def _mean(windows, count):
    """The last axis added up and divided by count; the sum may overflow where its mean does not."""
    with np.errstate(over="ignore"):
        total = wide_sum(windows, -1)
    if np.isfinite(total).all():                                 # nearly always
        return total / count
    scale = power_of_two(np.abs(windows).max(axis=-1))
    return scale * (wide_sum(windows / scale[..., None], -1) / count)


def _take(x, indices):
    return np.where(indices < 0, x.dtype.type(-np.inf),
                    np.take_along_axis(x, np.maximum(indices, 0), axis=2))


def _place(values, indices, length):
    """Values (N, C, T) at their places, zeros elsewhere; the last one stands.

    ->  (N, C, length)
    """
    placed = np.zeros(values.shape[:2] + (length,), values.dtype)
    np.put_along_axis(placed, indices, values, axis=2)
    return placed


def _put(dy, indices, length):
    """The adjoint of `_take`: add each value up at its place."""
    N, C, T_out = dy.shape
    dy, indices = np.where(indices < 0, dy.dtype.type(0), dy), np.maximum(indices, 0)
    if (np.diff(indices) > 0).all():                             # no place twice: nothing to add up
        return _place(dy, indices, length)
    dx = np.zeros((N * C, length), dy.dtype)
    np.add.at(dx, (np.arange(N * C)[:, None], indices.reshape(N * C, T_out)),
              dy.reshape(N * C, T_out))
    return dx.reshape(N, C, length)


def _check_frames(h):
    if h.shape[2] < 1:
        raise ValueError(f"h: found shape {h.shape}, needed at least one frame; without one there "
                         "is no output")


def _real(like, number):
    return like.real.dtype.type(number)


def _places(h, chosen, width):
    """Where each value goes.   ->  (N, C, T) of int64"""
    check_arrays(h=h, ndim={"h": 3})
    width = check_whole("width", width, 1)
    _check_frames(h)
    check_shape("chosen", chosen, h.shape, ", the shape of h")
    _check_indices("chosen", chosen, width, "which of the frames gets the value")
    return width * np.arange(h.shape[2]) + np.asarray(chosen, dtype=np.int64)


def _check_unpool(h, indices, length):
    check_arrays(h=h, ndim={"h": 3})
    check_whole("length", length, 1)
    check_shape("indices", indices, h.shape, ", the shape of h")
    _check_indices("indices", indices, length, "as max_pool1d_indices gives them")


def _check_indices(name, indices, below, what):
    indices = np.asarray(indices)
    if indices.dtype.kind not in "iu" or (
            indices.size and not 0 <= indices.min() <= indices.max() < below):
        raise ValueError(f"{name}: found {indices.dtype} from {np.min(indices, initial=0)} to "
                         f"{np.max(indices, initial=0)}, needed whole numbers from 0 to "
                         f"{below - 1}, {what}")
