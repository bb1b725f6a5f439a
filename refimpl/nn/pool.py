r"""Pooling over time: the largest or the mean of each window, and the ways back up.

Window t holds the positions `t stride + k dilation - padding`, k = 0 .. width - 1, of the input.
"""

from typing import Any

import numpy as np

from .arguments import check_arrays, check_shape, check_whole, in_precision
from .sums import power_of_two, wide_sum


def max_pool1d(x: np.ndarray, width: int = 2, *, stride: int | None = None, padding: int = 0,
               dilation: int = 1, ceil_mode: bool = False) -> np.ndarray:
    r"""The largest element of each window (Psi in equation 1 of Holden et al.: width 2).

        y[n, c, t] = max_k x[n, c, t stride + k dilation - padding]

        T_out = floor((T + 2 padding - dilation (width - 1) - 1) / stride) + 1

    x : (N, C, T)  ->  (N, C, T_out). stride : the width unless given. A NaN in a window is its
    largest element. padding : on both sides, at most half the width; counts as -inf. With ceil_mode
    T_out is rounded up, so that a last, incomplete window counts, if it begins inside the input or
    the left padding.

    >>> max_pool1d(np.array([[[1.0, 5, 7, 3]]]))
    array([[[5., 7.]]])
    """
    return _windows(x, -np.inf, width, stride, padding, dilation, ceil_mode)[0].max(axis=-1)


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
    check_arrays(x=x, dy=dy, real=True, shape=indices.shape)
    if indices.min(initial=0) >= 0 and (np.diff(indices) > 0).all():      # no place twice
        return max_unpool1d(dy, indices, x.shape[2])
    dx = np.zeros(x.shape[:2] + (x.shape[2] + 1,), dy.dtype)     # place -1, the last, is dropped
    places: Any = *np.indices(dy.shape, sparse=True)[:2], indices
    np.add.at(dx, places, dy)
    return dx[:, :, :-1]


def max_pool1d_indices(x: np.ndarray, width: int = 2, *, stride: int | None = None,
                       padding: int = 0, dilation: int = 1, ceil_mode: bool = False) -> np.ndarray:
    """Where in the input each window's first largest element stands; -1 for a window that holds
    padding alone (dilation can make one). Windows and options are those of `max_pool1d`.

    x : (N, C, T)  ->  (N, C, T_out) of int64

    >>> max_pool1d_indices(np.array([[[1.0, 5, 7, 7]]]))
    array([[[1, 2]]])
    """
    windows, positions, inside = _windows(x, -np.inf, width, stride, padding, dilation, ceil_mode)
    k, t = windows.argmax(axis=-1), np.arange(len(positions))    # the first largest, NaN if any
    # In a window of -inf alone: its first real element, not the padding.
    k = np.where(inside[t, k], k, inside.argmax(axis=1))
    return np.where(inside.any(axis=1), positions[t, k], -1)


def max_unpool1d(h: np.ndarray, indices: np.ndarray, length: int) -> np.ndarray:
    r"""Put each value where `max_pool1d_indices` found it, zeros elsewhere. Where two windows chose
    one position the last value stands.

    h, indices : (N, C, T)  ->  (N, C, length)

    >>> max_unpool1d(np.array([[[5.0, 7]]]), np.array([[[1, 2]]]), 4)
    array([[[0., 5., 7., 0.]]])
    """
    _check_unpool(h, indices, length)
    x = np.zeros(h.shape[:2] + (length,), h.dtype)
    np.put_along_axis(x, indices, h, axis=2)
    return x


def max_unpool1d_backward(dx: np.ndarray, h: np.ndarray, indices: np.ndarray,
                          length: int) -> np.ndarray:
    """Every value gets the gradient of its place, but a value that a later one overwrote gets none.

    dx : (N, C, length)  ->  (N, C, T)

    >>> dx, h = np.array([[[1.0, 2, 3, 4]]]), np.array([[[5.0, 7]]])
    >>> max_unpool1d_backward(dx, h, np.array([[[1, 2]]]), 4)
    array([[[2., 3.]]])
    """
    _check_unpool(h, indices, length)
    check_arrays(h=h, dx=dx, shape=h.shape[:2] + (length,))
    order, last = np.broadcast_to(np.arange(h.shape[2]), h.shape), np.zeros(dx.shape, int)
    np.put_along_axis(last, indices, order, axis=2)              # whose value stands at each place
    stands = np.take_along_axis(last, indices, axis=2) == order
    return np.where(stands, np.take_along_axis(dx, indices, axis=2), dx.dtype.type(0))


def avg_pool1d(x: np.ndarray, width: int = 2, *, stride: int | None = None, padding: int = 0,
               ceil_mode: bool = False, count_include_pad: bool = True) -> np.ndarray:
    r"""The mean of each window.

        y[n, c, t] = (1 / n_t) sum_k x[n, c, t stride + k - padding]

    n_t : elements of the window inside the input and, with count_include_pad, its padding; what
    hangs over the end because of ceil_mode never counts.   x : (N, C, T)  ->  (N, C, T_out), with
    stride, padding on both sides, ceil_mode and T_out as in `max_pool1d` without dilation

    >>> avg_pool1d(np.array([[[1.0, 5, 7, 3]]]))
    array([[[3., 5.]]])
    """
    windows, positions, inside = _windows(x, 0, width, stride, padding, 1, ceil_mode)
    counted = positions < x.shape[2] + int(padding) if count_include_pad else inside
    return _mean(windows, in_precision(counted.sum(axis=1), x))


def avg_pool1d_backward(dy: np.ndarray, x: np.ndarray, width: int = 2, *, stride: int | None = None,
                        padding: int = 0, ceil_mode: bool = False,
                        count_include_pad: bool = True) -> np.ndarray:
    r"""dx[n, c, s] = sum over windows t that hold s of dy[n, c, t] / n_t.

    dy : (N, C, T_out)  ->  (N, C, T)

    >>> avg_pool1d_backward(np.array([[[10.0, 20]]]), np.zeros((1, 1, 4)))
    array([[[ 5.,  5., 10., 10.]]])
    """
    _, positions, inside = _windows(x, 0, width, stride, padding, 1, ceil_mode)
    check_arrays(x=x, dy=dy, shape=x.shape[:2] + positions.shape[:1])
    counted = positions < x.shape[2] + int(padding) if count_include_pad else inside
    share = dy / in_precision(counted.sum(axis=1), x)
    dx = np.zeros(x.shape[:2] + (x.shape[2] + 1,), np.promote_types(share.dtype, np.float64))
    places: Any = ..., np.where(inside, positions, -1)
    np.add.at(dx, places, share[..., None])
    return dx[:, :, :-1].astype(share.dtype)                     # place -1, the last, is dropped


def avg_depool1d(h: np.ndarray, width: int = 2) -> np.ndarray:
    r"""Average-depooling (Psi-dagger in equation 2 of Holden et al.): each value `width` times
    over, divided by width.

        x[n, c, t] = h[n, c, floor(t / width)] / width

    h : (N, C, T)  ->  (N, C, width T)

    >>> avg_depool1d(np.array([[[2.0, 4]]]))
    array([[[1., 1., 2., 2.]]])
    """
    width = _check_depool(h, width)
    return np.repeat(h / in_precision(width, h), width, axis=2)


def avg_depool1d_backward(dx: np.ndarray, h: np.ndarray, width: int = 2) -> np.ndarray:
    r"""dh[n, c, t] = (1 / width) sum_k dx[n, c, width t + k].   dx : (N, C, width T)  ->  (N, C, T)

    >>> avg_depool1d_backward(np.array([[[1.0, 3, 5, 7]]]), np.zeros((1, 1, 2)))
    array([[[2., 6.]]])
    """
    width = _check_depool(h, width, dx=dx)
    return _mean(dx.reshape(h.shape + (width,)), width)


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
    width = _check_depool(h, width, chosen=chosen)
    places = width * np.arange(h.shape[2]) + np.asarray(chosen, dtype=np.int64)
    return max_unpool1d(h, places, width * h.shape[2])


def random_depool1d_backward(dx: np.ndarray, h: np.ndarray, chosen: np.ndarray,
                             width: int = 2) -> np.ndarray:
    r"""dh[n, c, t] = dx[n, c, width t + chosen[n, c, t]]; the choice is a constant.

    dx : (N, C, width T)  ->  (N, C, T)

    >>> dx, h = np.array([[[1.0, 3, 5, 7]]]), np.zeros((1, 1, 2))
    >>> random_depool1d_backward(dx, h, np.array([[[1, 0]]]))
    array([[[3., 5.]]])
    """
    width = _check_depool(h, width, chosen=chosen, dx=dx)
    windows = dx.reshape(h.shape + (width,))
    return np.take_along_axis(windows, np.asarray(chosen)[..., None], axis=-1)[..., 0]


def even(X: np.ndarray, axis: int = -1) -> np.ndarray:
    """The last frame doubled where the number of frames, those along the axis, is odd.

    (N, C, T)  ->  (N, C, T + T % 2)

    >>> even(np.array([[[1.0, 2, 3]]]))
    array([[[1., 2., 3., 3.]]])
    """
    return np.concatenate([X, X.take([-1], axis)], axis) if X.shape[axis] % 2 else X


def _windows(x, outside, width, stride, padding, dilation, ceil_mode):
    """The elements of every window (N, C, T_out, width), their positions in the input (T_out,
    width), and which of these are inside it; elements that are not are `outside`."""
    check_arrays(x=x, ndim={"x": 3}, real=outside == -np.inf)    # only a largest needs an order
    width, stride, padding, dilation = map(
        check_whole, ("width", "stride", "padding", "dilation"),
        (width, width if stride is None else stride, padding, dilation), (1, 1, 0, 1))
    if 2 * padding > width:
        raise ValueError(f"padding: found {padding}, needed at most half of width {width}")
    T, reach = x.shape[2], dilation * (width - 1) + 1
    free = T + 2 * padding - reach
    T_out = (-(-free // stride) if ceil_mode else free // stride) + 1
    if T < 1 or T_out < 1:
        raise ValueError(f"x: found {T} frames and {padding} of padding on both sides, needed at "
                         f"least {reach} for one window of width {width} with dilation {dilation}")
    if ceil_mode and (T_out - 1) * stride >= T + padding:
        T_out -= 1
    positions = np.arange(T_out)[:, None] * stride + np.arange(width) * dilation - padding
    inside = (positions >= 0) & (positions < T)
    return np.where(inside, x[:, :, np.clip(positions, 0, T - 1)], outside), positions, inside


def _mean(windows, count):
    """The last axis added up and divided by count; the sum may overflow where its mean does not."""
    scale = power_of_two(windows, -1)
    return scale * (wide_sum(windows / scale[..., None], -1) / count)


def _check_unpool(h, indices, length):
    check_arrays(h=h, ndim={"h": 3})
    check_whole("length", length, 1)
    _check_places("indices", indices, h, length, "as max_pool1d_indices gives them")


def _check_depool(h, width, *, chosen=None, dx=None):
    check_arrays(h=h, ndim={"h": 3})
    width = check_whole("width", width, 1)
    if h.shape[2] < 1:
        raise ValueError(f"h: found shape {h.shape}, needed at least one frame; without one there "
                         "is no output")
    if chosen is not None:
        _check_places("chosen", chosen, h, width, "which of the frames gets the value")
    if dx is not None:
        check_arrays(h=h, dx=dx, shape=h.shape[:2] + (width * h.shape[2],))
    return width


def _check_places(name, places, h, below, what):
    check_shape(name, places, h.shape, ", the shape of h")
    places = np.asarray(places)
    least, most = places.min(initial=0), places.max(initial=0)
    if places.dtype.kind not in "iu" or least < 0 or most >= below:
        raise ValueError(f"{name}: found {places.dtype} from {least} to {most}, needed whole "
                         f"numbers from 0 to {below - 1}, {what}")
