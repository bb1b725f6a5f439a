"""What students write in notebook 03 and should not get away with: `exercise__what_is_wrong`. Names
of the notebook are known.
"""

import numpy as np


def my_conv1d_backward_b__sums_clips_only(dy, x, w, b):
    return dy.sum(axis=0)


def my_conv1d_backward_b__mean_over_frames(dy, x, w, b):
    return dy.mean(axis=2).sum(axis=0)


def my_conv1d_backward_b__mean_over_clips(dy, x, w, b):
    return dy.mean(axis=0).sum(axis=1)


def my_conv1d_backward_b__wrong_axes(dy, x, w, b):
    return dy.sum(axis=(0, 1))[:len(b)]


def my_conv1d_backward_b__ones_upstream(dy, x, w, b):
    return np.full(len(b), float(dy.shape[0] * dy.shape[2]))


def _padded(x, K, left):
    return np.pad(x, ((0, 0), (0, 0), (left, K - 1 - left)))


def my_conv1d_backward_w__taps_reversed(dy, x, w, b):
    return np.ascontiguousarray(_dw(dy, x, w)[:, :, ::-1])


def _dw(dy, x, w, left=None):
    T, K = x.shape[2], w.shape[2]
    padded = _padded(x, K, (K - 1) // 2 if left is None else left)
    return np.stack([np.sum(dy @ padded[:, :, k:k + T].swapaxes(1, 2), axis=0) for k in range(K)],
                    axis=2)


def my_conv1d_backward_w__larger_half_left(dy, x, w, b):
    return _dw(dy, x, w, left=w.shape[2] // 2)


def my_conv1d_backward_w__mean_over_clips(dy, x, w, b):
    return _dw(dy, x, w) / len(x)


def my_conv1d_backward_w__first_clip_only(dy, x, w, b):
    return _dw(dy[:1], x[:1], w)


def my_conv1d_backward_w__wraps_around(dy, x, w, b):
    left = (w.shape[2] - 1) // 2
    return np.stack([np.sum(dy @ np.roll(x, left - k, axis=2).swapaxes(1, 2), axis=0)
                     for k in range(w.shape[2])], axis=2)


def _dx(dy, x, w, left=None):
    T, K = x.shape[2], w.shape[2]
    left = (K - 1) // 2 if left is None else left
    dpadded = np.zeros((len(x), w.shape[1], T + K - 1))
    for k in range(K):
        dpadded[:, :, k:k + T] += w[:, :, k].T @ dy
    return dpadded[:, :, left:left + T].copy()


def my_conv1d_backward_x__missing_flip(dy, x, w, b):
    return nn.conv1d(dy, np.ascontiguousarray(w.swapaxes(0, 1)))          # noqa: F821


def my_conv1d_backward_x__larger_half_left(dy, x, w, b):
    return _dx(dy, x, w, left=w.shape[2] // 2)


def my_conv1d_backward_x__not_cropped_where_it_was_padded(dy, x, w, b):
    return _dx(dy, x, w, left=0)


def my_conv1d_backward_x__zeros_not_cut_off(dy, x, w, b):
    T, K = x.shape[2], w.shape[2]
    return sum(np.pad(w[:, :, k].T @ dy, ((0, 0), (0, 0), (k, K - 1 - k))) for k in range(K))


def my_conv1d_backward_x__last_tap_forgotten(dy, x, w, b):
    w = w.copy()
    w[:, :, -1] = 0
    return _dx(dy, x, w)


def my_conv_transpose1d__missing_flip(h, w, b):
    return nn.conv1d(h, np.ascontiguousarray(w.swapaxes(0, 1)), b)        # noqa: F821


def my_conv_transpose1d__bias_forgotten(h, w, b):
    return _dx(h, np.zeros((len(h), w.shape[1], h.shape[2])), w)


def my_conv_transpose1d__larger_half_left(h, w, b):
    return _dx(h, h, w, left=w.shape[2] // 2) + b[:, None]


def my_conv_transpose1d__bias_before_the_filters(h, w, b):
    return _dx(h + b[0], h, w)


def _by_hand(dy, x, w):
    padded = np.pad(dy, 1)
    return {"db": dy.sum(), "dw0": dy[1:] @ x[:3], "dw1": dy @ x, "dw2": dy[:3] @ x[1:],
            **{f"dx{s}": padded[s:s + 3] @ w[::-1] for s in range(4)}}


def my_by_hand__not_reversed(dy, x, w):
    padded = np.pad(dy, 1)
    return _by_hand(dy, x, w) | {f"dx{s}": padded[s:s + 3] @ w for s in range(4)}


def my_by_hand__the_edge_wraps_round(dy, x, w):
    return _by_hand(dy, x, w) | {"dx0": dy[0] * w[1] + dy[1] * w[0] + dy[3] * w[2]}


def my_by_hand__filters_exchanged(dy, x, w):
    found = _by_hand(dy, x, w)
    return found | {"dw0": found["dw2"], "dw2": found["dw0"]}


def my_by_hand__one_is_missing(dy, x, w):
    found = _by_hand(dy, x, w)
    del found["dx3"]
    return found
