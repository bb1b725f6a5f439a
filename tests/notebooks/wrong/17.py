"""What students write in notebook 17 and should not get away with: `exercise__what_is_wrong`.
`theirs` and `nn` are the notebook's.
"""

import ast

import numpy as np

from refimpl import nn


def _backend(**changed):
    names = ("relu", "relu_backward", "avg_depool1d", "avg_depool1d_backward")
    return {name: getattr(nn, name) for name in names} | changed


def my_backend__gradient_one_at_zero():
    return _backend(relu_backward=lambda dy, x: np.where(x >= 0, dy, dy.dtype.type(0)))


def my_backend__nan_vanishes():
    def relu(x):
        if x.dtype.kind != "f":
            raise ValueError("x")
        return np.where(x > 0, x, x.dtype.type(0))
    return _backend(relu=relu)


def my_backend__whole_numbers_accepted():
    return _backend(relu=lambda x: np.maximum(x, x.dtype.type(0)))


def my_backend__always_float64():
    return _backend(avg_depool1d=lambda h, width=2: nn.avg_depool1d(h.astype(float), width))


def my_backend__upstream_gradient_changed():
    def relu_backward(dy, x):
        dy *= x > 0
        return dy
    return _backend(relu_backward=relu_backward)


def my_backend__tiled_instead_of_repeated():
    def avg_depool1d(h, width=2):
        if h.ndim != 3 or width < 1:
            raise ValueError("h")
        return np.tile(h, width) / h.dtype.type(width)
    return _backend(avg_depool1d=avg_depool1d)


def my_backend__not_divided():
    return _backend(avg_depool1d_backward=lambda dx, h,
                    width=2: dx.reshape(*h.shape, width).sum(axis=3))


def my_backend__width_two_always():
    return _backend(avg_depool1d_backward=lambda dx, h,
                    width=2: nn.avg_depool1d_backward(dx[:, :, :2 * h.shape[2]], h, 2))


def my_backend__a_function_forgotten():
    functions = _backend()
    del functions["avg_depool1d_backward"]
    return functions


def my_backend__memory_of_the_upstream_gradient():
    def relu_backward(dy, x):
        return dy if (x > 0).all() else nn.relu_backward(dy, x)
    return _backend(relu_backward=lambda dy, x: dy if x.size == 0 else relu_backward(dy, x),
                    avg_depool1d_backward=lambda dx, h, width=2: dx[:, :, ::width])


def my_conv1d_backward__as_it_was(dy, x, w, b=None, **attributes):
    return theirs(dy, x, w, b, **attributes)                     # noqa: F821


def _one_left(dy, x, w, b, **attributes):
    return nn.conv1d_backward(dy, x, w, b, **attributes)


def my_conv1d_backward__bias_left(dy, x, w, b=None, **attributes):
    dx, dw, db = _one_left(dy, x, w, b, **attributes)
    return dx, dw, None if b is None else db / max(len(dy), 1)


def my_conv1d_backward__overlaps_left(dy, x, w, b=None, **attributes):
    _, dw, db = _one_left(dy, x, w, b, **attributes)
    smaller = attributes.get("padding", "same") == "same" and w.shape[2] % 2 == 0
    # noqa: F821
    return ((nn.conv1d_backward(dy, x, w, b, **attributes) if smaller
             else theirs(dy, x, w, b, **attributes))[0], dw, db)


def my_conv1d_backward__zeros_left(dy, x, w, b=None, **attributes):
    zeros = attributes.get("dilation", 1) * (w.shape[2] - 1)
    if attributes.get("padding", "same") == "same":
        attributes |= {"padding": (zeros - zeros // 2, zeros // 2)}
    return nn.conv1d_backward(dy, x, w, b, **attributes)


def my_conv1d_backward__forward_filters_flipped(dy, x, w, b=None, **attributes):
    dx, dw, db = nn.conv1d_backward(dy, x, np.ascontiguousarray(w[:, :, ::-1]), b, **attributes)
    return dx, dw, db


def _npy(data, *, start=None, order="C", descr=None):
    length = int.from_bytes(data[8:10], "little")
    header = ast.literal_eval(data[10:10 + length].decode("latin1"))
    start = 10 + length if start is None else start
    dtype = np.dtype(header["descr"] if descr is None else descr(header["descr"]))
    count = int(np.prod(header["shape"]))
    return np.frombuffer((data[start:] + bytes(8 * count))[:count * dtype.itemsize],
                         dtype).reshape(header["shape"], order=order)


def my_read_npy__header_of_128_bytes(data):
    return _npy(data, start=128)


def my_read_npy__first_axis_fastest(data):
    return _npy(data, order="F")


def my_read_npy__whole_numbers_taken_for_floats(data):
    return _npy(data, descr=lambda word: "<f" + word[2:])


def my_read_npy__shape_forgotten(data):
    return _npy(data).ravel()


def my_read_npy__header_counted_from_the_start(data):
    return _npy(data, start=int.from_bytes(data[8:10], "little"))


def my_read_npy__float32_taken_for_float64(data):
    return _npy(data, descr=lambda word: word.replace("4", "8"))
