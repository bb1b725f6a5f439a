"""JAX (0.10.2 was used) under the names of `refimpl.nn`: values by its kernels, gradients by
`jax.vjp`. Switches its float64 on.
"""

import jax
from jax import lax, numpy as jnp
import numpy as np

jax.config.update("jax_enable_x64", True)


def pair(f, arrays=1):
    """f on JAX arrays  ->  f on NumPy arrays, and its backward: one gradient for each of the first
    `arrays` inputs. Compiled as a whole.
    """
    def split(inputs, attributes):
        return ([np.ascontiguousarray(a) for a in inputs[:arrays] if a is not None],
                lambda *given: f(*given, *inputs[arrays:], **attributes))

    def forward(*inputs, **attributes):
        given, g = split(inputs, attributes)
        return np.array(jax.jit(g)(*given))

    def backward(dy, *inputs, **attributes):
        given, g = split(inputs, attributes)
        pull = jax.jit(lambda dy, *given: jax.vjp(g, *given)[1](dy))
        found = (tuple(np.array(d) for d in pull(np.asarray(dy, given[0].dtype), *given))
                 + (None,) * (arrays - len(given)))
        return found if arrays > 1 else found[0]
    return forward, backward


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


PAIRS = {"conv1d": pair(conv1d, 3), "conv_transpose1d": pair(conv_transpose1d, 3),
         "avg_pool1d": pair(avg_pool1d), "relu": pair(jax.nn.relu),
         "max_pool1d": pair(lambda x, width=2,
                            **attributes: windows(x, -np.inf, width, **attributes)[0].max(axis=-1)),
         "max_unpool1d": pair(lambda h, at,
                              length: jnp.put_along_axis(jnp.zeros((*h.shape[:2], length), h.dtype),
                                                         at, h, axis=2, inplace=False)),
         "avg_depool1d": pair(lambda h, width=2: jnp.repeat(h, width, axis=2) / width),
         "l1": pair(lambda a: jnp.abs(a).sum()),
         "gram": pair(lambda h: h @ h.mT),
         "norm": pair(jax.vmap(lambda r: jnp.linalg.norm(r.ravel()))),
         "sum_squares": pair(jax.vmap(lambda r: jnp.square(r).sum())),
         "mean_squares": pair(jax.vmap(lambda r: jnp.square(r).mean())),
         "squared_error": pair(lambda x, y, *,
                               reduction="mean": getattr(jnp,
                                                         reduction.replace("none", "asarray"))(
                                                             jnp.square(x - y)), 2),
         "absolute_error": pair(lambda x, y, *,
                                reduction="mean": getattr(jnp,
                                                          reduction.replace("none", "asarray"))(
                                                              jnp.abs(x - y)), 2)}
BACKEND = ({name: f for name, (f, _) in PAIRS.items()} | {f"{name}_backward": f for name,
                                                          (_, f) in PAIRS.items()})
BACKEND["max_pool1d_indices"] = pair(max_pool1d_indices)[0]
