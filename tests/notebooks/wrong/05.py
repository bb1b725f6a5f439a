"""What students write in notebook 05 and should not get away with: `exercise__what_is_wrong`."""

import numpy as np


def _each(x, measure):
    gradient = np.zeros(x.shape)
    for index in np.ndindex(x.shape):
        v = np.zeros(x.shape)
        v[index] = 1.0
        gradient[index] = measure(v)
    return gradient


def my_differences__one_sided(f, x, dy, h):
    return _each(x, lambda v: np.sum(dy * (f(x + h * v) - f(x))) / h)


def my_differences__half_forgotten(f, x, dy, h):
    return _each(x, lambda v: np.sum(dy * (f(x + h * v) - f(x - h * v))) / h)


def my_differences__upstream_forgotten(f, x, dy, h):
    return _each(x, lambda v: np.sum(f(x + h * v) - f(x - h * v)) / (2 * h))


def my_differences__all_elements_at_once(f, x, dy, h):
    return np.full(x.shape, np.sum(dy * (f(x + h) - f(x - h))) / (2 * h))


def my_differences__leaves_x_moved(f, x, dy, h):
    gradient = np.zeros(x.shape)
    for index in np.ndindex(x.shape):
        x[index] += h
        above = np.sum(dy * f(x))
        x[index] -= 2 * h
        gradient[index] = (above - np.sum(dy * f(x))) / (2 * h)
    return gradient


def my_differences__step_too_small(f, x, dy, h):
    return _each(x, lambda v: np.sum(dy * (f(x + 1e-13 * v) - f(x - 1e-13 * v))) / 2e-13)


def my_complex_step__real_part(f, x, dy):
    return _each(x, lambda v: np.sum(dy * np.real(f(x + 1e-30j * v))) / 1e-30)


def my_complex_step__step_too_large(f, x, dy):
    return _each(x, lambda v: np.sum(dy * np.imag(f(x + 1e-3j * v))) / 1e-3)


def my_complex_step__not_divided(f, x, dy):
    return _each(x, lambda v: np.sum(dy * np.imag(f(x + 1e-30j * v))))


def my_complex_step__upstream_forgotten(f, x, dy):
    return _each(x, lambda v: np.sum(np.imag(f(x + 1e-30j * v))) / 1e-30)


def my_complex_step__differences_instead(f, x, dy):
    return _each(x, lambda v: np.sum(dy * (f(x + 1e-6 * v) - f(x - 1e-6 * v))) / 2e-6)


def _verdict(f, f_backward, x, upstream=None, accept=None, h=None):
    dy = np.random.default_rng(0).normal(size=f(x).shape) if upstream is None else upstream
    h = 1e-5 * np.sqrt(np.mean(x**2)) if h is None else h
    measured = _each(x, lambda v: np.sum(dy * (f(x + h * v) - f(x - h * v))) / (2 * h))
    claimed = f_backward(dy, x)
    if accept is None:
        def accept(claimed, measured):
            return np.abs(claimed - measured).max() <= 1e-6 * np.abs(measured).max()
    return bool(claimed.shape == x.shape and accept(claimed, measured))


def my_verdict__ones_upstream(f, f_backward, x):
    return _verdict(f, f_backward, x, upstream=np.ones(f(x).shape))


def my_verdict__absolute_tolerance(f, f_backward, x):
    return _verdict(f, f_backward, x, accept=lambda claimed,
                    measured: np.abs(claimed - measured).max() <= 1e-6)


def my_verdict__exact(f, f_backward, x):
    return _verdict(f, f_backward, x, accept=np.array_equal)


def my_verdict__compares_sums(f, f_backward, x):
    return _verdict(f, f_backward, x, accept=lambda claimed,
                    measured: abs(claimed.sum() - measured.sum()) <= 1e-6 * np.abs(measured).max())


def my_verdict__first_element_only(f, f_backward, x):
    return _verdict(f, f_backward, x, accept=lambda claimed,
                    measured: abs(claimed.flat[0] - measured.flat[0])
                    <= 1e-6 * np.abs(measured).max())


def my_verdict__one_per_cent_is_near_enough(f, f_backward, x):
    return _verdict(f, f_backward, x, accept=lambda claimed,
                    measured: np.abs(claimed - measured).max() <= 1e-2 * np.abs(measured).max())


def my_verdict__absolute_step(f, f_backward, x):
    return _verdict(f, f_backward, x, h=1e-2)


def my_verdict__relative_to_each_element(f, f_backward, x):
    return _verdict(f, f_backward, x, accept=lambda claimed,
                    measured: (np.abs(claimed - measured) <= 1e-12 * np.abs(measured)).all())


def my_verdict__shape_not_looked_at(f, f_backward, x):
    dy = np.random.default_rng(0).normal(size=f(x).shape)
    return bool(np.isfinite(f_backward(dy, x)).all())


def my_gram_backward__as_planted(dG, h):
    return 2 * dG @ h


def my_gram_backward__column_only(dG, h):
    return dG.swapaxes(1, 2) @ h


def my_gram_backward__transposed_twice(dG, h):
    return 2 * dG.swapaxes(1, 2) @ h


def my_gram_backward__clips_mixed(dG, h):
    return (dG + dG.transpose(0, 2, 1)[::-1]) @ h


def my_mean_squares_backward__as_planted(dM, r):
    return 2 * dM[:, None, None] * r / r.size


def my_mean_squares_backward__factor_two_forgotten(dM, r):
    return dM[:, None, None] * r / r[0].size


def my_mean_squares_backward__frames_only(dM, r):
    return 2 * dM[:, None, None] * r / r.shape[2]


def my_mean_squares_backward__upstream_summed(dM, r):
    return 2 * dM.sum() * r / r[0].size


def _conv_x(dy, x, w, tap, shift=0):
    T, K = x.shape[2], w.shape[2]
    padded = np.pad(dy, ((0, 0), (0, 0), (K // 2 + shift, K // 2 - shift if K > 1 else K)))
    return sum(w[:, :, tap(k, K)].T @ padded[:, :, k:k + T] for k in range(K))


def my_conv1d_backward_x__as_planted(dy, x, w):
    return _conv_x(dy, x, w, lambda k, K: k)


def my_conv1d_backward_x__one_frame_late(dy, x, w):
    return _conv_x(dy, x, w, lambda k, K: K - 1 - k, shift=1)


def my_conv1d_backward_x__signal_reversed_instead(dy, x, w):
    return np.ascontiguousarray(_conv_x(dy[:, :, ::-1], x, w, lambda k, K: k))


def my_conv1d_backward_x__centre_tap_only(dy, x, w):
    return w[:, :, w.shape[2] // 2].T @ dy
