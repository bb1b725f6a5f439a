"""JAX under the names of `refimpl.nn`: values by its own kernels, gradients by `jax.vjp`; NumPy arrays in and out, precision kept.

Needs jax (0.10.2 was used); importing this module switches its float64 on.
"""

import jax
from jax import lax, numpy as jnp
import numpy as np

jax.config.update("jax_enable_x64", True)


def pair(f, arrays=1):
    """f on JAX arrays  ->  f on NumPy arrays, and its backward: one gradient for each of the first `arrays` inputs."""
    def forward(*inputs, **attributes):
        return np.array(f(*inputs, **attributes))

    def backward(dy, *inputs, **attributes):
        given = [np.ascontiguousarray(a) for a in inputs[:arrays] if a is not None]
        y, pull = jax.vjp(lambda *a: f(*a, *inputs[arrays:], **attributes), *given)
        found = [np.array(d) for d in pull(jnp.asarray(dy, y.dtype))]
        return found[0] if arrays == 1 else tuple(found + [None] * (arrays - len(found)))
    return forward, backward


def pad(x, before, after, value=0.0):
    return lax.pad(x, x.dtype.type(value), ((0, 0, 0), (0, 0, 0), (before, after, 0)))


def convolve(x, w, stride, dilation, groups, holes=1):
    return lax.conv_general_dilated(x, w, (stride,), "VALID", (holes,), (dilation,), ("NCH", "OIH", "NCH"), groups)


def zeros(padding, reach):
    named = {"valid": (0, 0), "same": (reach // 2, reach - reach // 2)}
    return named[padding] if isinstance(padding, str) else padding if isinstance(padding, tuple) else (padding, padding)


def conv1d(x, w, b=None, *, stride=1, padding="same", dilation=1, groups=1):
    y = convolve(pad(x, *zeros(padding, dilation * (w.shape[2] - 1))), w, stride, dilation, groups)
    return y if b is None else y + b[:, None]


def conv_transpose1d(h, w, b=None, *, stride=1, padding="same", output_padding=0, dilation=1, groups=1):
    """A convolution with the filters turned round, over h with stride - 1 zeros between its frames."""
    (O, C, K), reach = w.shape, dilation * (w.shape[2] - 1)
    left, right = zeros(padding, reach)
    turned = jnp.swapaxes(jnp.reshape(w, (groups, O // groups, C, K)), 1, 2).reshape(groups * C, O // groups, K)[:, :, ::-1]
    apart = lax.pad(h, h.dtype.type(0), ((0, 0, 0), (0, 0, 0), (reach, reach + output_padding, stride - 1)))
    full = convolve(apart, turned, 1, dilation, groups)
    return full[..., left:full.shape[2] - right] + (0 if b is None else b[:, None])


def windows(x, width, stride, padding, dilation, ceil_mode, fill):
    """x padded so that whole windows cover it, and the positions in x of every window's elements (T_out, width)."""
    T, stride = x.shape[2], stride or width
    free = T + 2 * padding - dilation * (width - 1) - 1
    count = (free + (stride - 1 if ceil_mode else 0)) // stride + 1
    count -= (count - 1) * stride >= T + padding                 # begins in the padding at the end
    at = np.arange(count)[:, None] * stride + np.arange(width) * dilation - padding
    return pad(x, padding, padding + (count - 1) * stride - free, fill), at, (1, 1, stride)


def max_pool1d(x, width=2, *, stride=None, padding=0, dilation=1, ceil_mode=False):
    padded, at, strides = windows(x, width, stride, padding, dilation, ceil_mode, -np.inf)
    if dilation > 1:                                             # where reduce_window has no gradient
        return padded[:, :, at + padding].max(axis=-1)
    return lax.reduce_window(padded, x.dtype.type(-np.inf), lax.max, (1, 1, width), strides, "VALID")


def max_pool1d_indices(x, width=2, *, stride=None, padding=0, dilation=1, ceil_mode=False):
    padded, at, _ = windows(jnp.asarray(x), width, stride, padding, dilation, ceil_mode, -np.inf)
    return at[np.arange(len(at)), padded[:, :, at + padding].argmax(axis=-1)]


def avg_pool1d(x, width=2, *, stride=None, padding=0, ceil_mode=False, count_include_pad=True):
    padded, at, strides = windows(x, width, stride, padding, 1, ceil_mode, 0.0)
    margin = padding if count_include_pad else 0
    count = ((at >= -margin) & (at < x.shape[2] + margin)).sum(axis=1).astype(x.dtype)
    return lax.reduce_window(padded, x.dtype.type(0), lax.add, (1, 1, width), strides, "VALID") / count


def max_unpool1d(h, indices, length):
    n, c, _ = np.indices(h.shape, sparse=True)
    return jnp.zeros((*h.shape[:2], length), h.dtype).at[n, c, indices].set(h)


def clips(r):
    return jnp.reshape(r, (len(r), int(np.prod(r.shape[1:]))))


def error(measure):
    return lambda x, y, *, reduction="mean": {"none": jnp.asarray, "mean": jnp.mean, "sum": jnp.sum}[reduction](measure(x - y))


PAIRS = {"conv1d": pair(conv1d, 3), "conv_transpose1d": pair(conv_transpose1d, 3), "max_pool1d": pair(max_pool1d), "avg_pool1d": pair(avg_pool1d),
         "max_unpool1d": pair(max_unpool1d), "avg_depool1d": pair(lambda h, width=2: jnp.repeat(h, width, axis=2) / width),
         "relu": pair(jax.nn.relu), "gram": pair(lambda h: h @ jnp.swapaxes(h, 1, 2)), "l1": pair(lambda a: jnp.abs(a).sum()),
         "norm": pair(lambda r: jnp.linalg.norm(clips(r), axis=1)), "sum_squares": pair(lambda r: jnp.square(clips(r)).sum(axis=1)),
         "mean_squares": pair(lambda r: jnp.square(clips(r)).mean(axis=1)),
         "squared_error": pair(error(jnp.square), 2), "absolute_error": pair(error(jnp.abs), 2)}
BACKEND = {name: f for name, (f, _) in PAIRS.items()} | {f"{name}_backward": f for name, (_, f) in PAIRS.items()}
BACKEND["max_pool1d_indices"] = pair(max_pool1d_indices)[0]
