"""JAX (0.10.2 was used) under the names of `refimpl.nn`: values by its kernels, gradients by
`jax.vjp`.
"""

import jax
from jax import lax, numpy as jnp
import numpy as np

from refimpl.adapters.jax import backend


# a float32 convolution's own negative padding reads stray memory
def pad(x, before, after, value=0.0, between=0):
    return lax.pad(x, x.dtype.type(value), ((0, 0, 0), (0, 0, 0), (before, after, between)))


def zeros(padding, reach):
    return {"valid": (0, 0),
            "same": (reach // 2, reach - reach // 2)}.get(padding,
                                                          padding if isinstance(padding, tuple)
                                                          else (padding, padding))


def conv1d(x, w, b=None, *, stride=1, padding="same", dilation=1, groups=1):
    padded = pad(x, *zeros(padding, dilation * (w.shape[2] - 1)))
    # of NCH and OIH
    y = lax.conv_general_dilated(padded, w, (stride,), "VALID", rhs_dilation=(dilation,),
                                 feature_group_count=groups)
    return y if b is None else y + b[:, None]


def conv_transpose1d(h, w, b=None, *, stride=1, padding="same", output_padding=0, dilation=1,
                     groups=1):
    """A convolution with the filters turned round, over h with stride - 1 zeros between its frames.
    """
    (O, C, K), reach = w.shape, dilation * (w.shape[2] - 1)
    left, right = zeros(padding, reach)
    turned = w.reshape(groups, O // groups, C, K).swapaxes(1, 2)
    turned = turned.reshape(groups * C, O // groups, K)[:, :, ::-1]
    full = conv1d(pad(h, reach, reach + output_padding, between=stride - 1), turned,
                  padding="valid", dilation=dilation, groups=groups)
    return full[..., left:full.shape[2] - right] + (0 if b is None else b[:, None])


def windows(x, outside, width=2, *, stride=None, padding=0, dilation=1, ceil_mode=False):
    """All windows (N, C, T_out, width) and the positions of their elements in x (T_out, width)."""
    T, stride, reach = x.shape[2], stride or width, dilation * (width - 1) + 1
    count = (T + 2 * padding - reach + (stride - 1) * ceil_mode) // stride + 1
    # it would begin in the padding at the end
    count -= (count - 1) * stride >= T + padding
    at = np.arange(count)[:, None] * stride + np.arange(width) * dilation
    return (pad(x, padding, (count - 1) * stride + reach - padding - T, outside)[:, :, at],
            at - padding)


def max_pool1d_indices(x, width=2, **attributes):
    held, at = windows(x, -np.inf, width, **attributes)
    return jnp.asarray(at)[np.arange(len(at)), held.argmax(axis=-1)]


def avg_pool1d(x, width=2, *, padding=0, count_include_pad=True, **attributes):
    held, at = windows(x, 0.0, width, padding=padding, **attributes)
    counted = ((at + padding * count_include_pad >= 0) & (at - padding * count_include_pad
                                                          < x.shape[2]))
    return held.sum(axis=-1) / counted.sum(axis=1).astype(x.dtype)


def max_unpool1d(h, at, length):
    return jnp.put_along_axis(jnp.zeros((*h.shape[:2], length), h.dtype), at, h, axis=2,
                              inplace=False)


def reduced(x, reduction):
    return {"mean": jnp.mean, "sum": jnp.sum, "none": jnp.asarray}[reduction](x)


BACKEND = backend(
    conv1d=conv1d, conv_transpose1d=conv_transpose1d, avg_pool1d=avg_pool1d, relu=jax.nn.relu,
    max_pool1d=lambda x, width=2, **k: windows(x, -np.inf, width, **k)[0].max(axis=-1),
    max_pool1d_indices=max_pool1d_indices, max_unpool1d=max_unpool1d,
    avg_depool1d=lambda h, width=2: jnp.repeat(h, width, axis=2) / width,
    l1=lambda a: jnp.abs(a).sum(), gram=lambda h: h @ h.mT,
    norm=jax.vmap(lambda r: jnp.linalg.norm(r.ravel())),
    sum_squares=jax.vmap(lambda r: jnp.square(r).sum()),
    mean_squares=jax.vmap(lambda r: jnp.square(r).mean()),
    squared_error=lambda x, y, *, reduction="mean": reduced(jnp.square(x - y), reduction),
    absolute_error=lambda x, y, *, reduction="mean": reduced(jnp.abs(x - y), reduction))
