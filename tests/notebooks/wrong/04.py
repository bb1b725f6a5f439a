"""What students write in notebook 04 and should not get away with: `exercise__what_is_wrong`."""

import numpy as np


def my_relu_backward__one_at_the_kink(dy, x):
    return np.where(x >= 0, dy, 0.0)


def my_relu_backward__half_at_the_kink(dy, x):
    return dy * (0.5 * (x > 0) + 0.5 * (x >= 0))


def my_relu_backward__upstream_forgotten(dy, x):
    return (x > 0).astype(float)


def my_relu_backward__cuts_the_gradient_instead(dy, x):
    return np.maximum(dy, 0.0)


def my_relu_backward__in_place(dy, x):
    dy[x <= 0] = 0.0
    return dy


def _pool_backward(dy, x, width, share):
    N, C, T = x.shape
    used = T // width * width
    windows = x[:, :, :used].reshape(N, C, T // width, width)
    dx = np.zeros(x.shape)
    dx[:, :, :used] = (share(windows) * dy[..., None]).reshape(N, C, used)
    return dx


def _largest(windows):
    return windows == windows.max(axis=-1, keepdims=True)


def my_max_pool1d_backward__tie_to_both(dy, x, width):
    return _pool_backward(dy, x, width, lambda windows: _largest(windows).astype(float))


def my_max_pool1d_backward__tie_split_equally(dy, x, width):
    return _pool_backward(dy, x, width,
                          lambda windows: _largest(windows)
                          / _largest(windows).sum(axis=-1, keepdims=True))


def my_max_pool1d_backward__tie_to_the_last(dy, x, width):
    def last(windows):
        return np.arange(width) == width - 1 - np.argmax(windows[..., ::-1], axis=-1)[..., None]
    return _pool_backward(dy, x, width, last)


def my_max_pool1d_backward__spread_over_the_window(dy, x, width):
    return _pool_backward(dy, x, width, lambda windows: np.full(windows.shape, 1.0 / width))


def my_max_pool1d_backward__times_the_value(dy, x, width):
    return _pool_backward(dy, x, width, lambda windows: _largest(windows) * windows)


def my_max_pool1d_backward__windows_of_two_always(dy, x, width):
    N, C, T = x.shape
    dx = np.zeros(x.shape)
    for t in range(dy.shape[2]):
        s = 2 * t + np.argmax(x[:, :, 2 * t:2 * t + 2], axis=-1)
        np.put_along_axis(dx, s[..., None], dy[:, :, t:t + 1], axis=2)
    return dx


def my_avg_depool1d_backward__factor_forgotten(dx, h, width):
    return dx.reshape(h.shape + (width,)).sum(axis=-1)


def my_avg_depool1d_backward__factor_one_half_always(dx, h, width):
    return dx.reshape(h.shape + (width,)).sum(axis=-1) / 2


def my_avg_depool1d_backward__first_copy_only(dx, h, width):
    return dx[:, :, ::width].copy()


def my_avg_depool1d_backward__wrong_axis(dx, h, width):
    N, C, T = h.shape
    return dx.reshape(N, C, width, T).sum(axis=2) / width


def my_avg_depool1d_backward__as_the_forward_pass(dx, h, width):
    return np.repeat(dx / width, width, axis=2)
