"""What students write in notebook 08 and should not get away with: `exercise__what_is_wrong`."""

import numpy as np


def _step(p, g, m, v, t, rate, beta1, beta2, epsilon, *, correct=True, inside=False, square=True,
          old=False, late=0, hat=False):
    before = m, v
    m = beta1 * m + (1 - beta1) * g
    v = beta2 * v + (1 - beta2) * (g**2 if square else np.abs(g))
    used = before if old else (m, v)
    c1, c2 = (1 - beta1 ** (t + late), 1 - beta2 ** (t + late)) if correct else (1.0, 1.0)
    if hat:
        return p - rate * np.sqrt(c2) / c1 * used[0] / (np.sqrt(used[1]) + epsilon), m, v
    root = np.sqrt(used[1] / c2 + epsilon) if inside else np.sqrt(used[1] / c2) + epsilon
    return p - rate * (used[0] / c1) / root, m, v


def my_adam_step__bias_not_corrected(*arguments):
    return _step(*arguments, correct=False)


def my_adam_step__epsilon_inside_the_root(*arguments):
    return _step(*arguments, inside=True)


def my_adam_step__not_squared(*arguments):
    return _step(*arguments, square=False)


def my_adam_step__the_means_before_this_gradient(*arguments):
    return _step(*arguments, old=True)


def my_adam_step__t_counted_from_two(*arguments):
    return _step(*arguments, late=1)


def my_adam_step__uphill(p, *rest):
    new, m, v = _step(p, *rest)
    return 2 * p - new, m, v


def my_epsilon_hat_step__algorithm_1(*arguments):
    return _step(*arguments)


def my_epsilon_hat_step__bias_not_corrected(*arguments):
    return _step(*arguments, correct=False, hat=True)


def my_epsilon_hat_step__root_forgotten(p, g, m, v, t, rate, beta1, beta2, epsilon):
    m = beta1 * m + (1 - beta1) * g
    v = beta2 * v + (1 - beta2) * g**2
    return p - rate * (1 - beta2**t) / (1 - beta1**t) * m / (np.sqrt(v) + epsilon), m, v


def my_annealed__falls_from_the_start(rate, epoch, epochs):
    return rate * (1 - (epoch - 0.5) / epochs)


def my_annealed__counted_from_zero(rate, epoch, epochs):
    return rate * min(1.0, 2 * (1 - (epoch + 0.5) / epochs))


def my_annealed__zero_at_the_end(rate, epoch, epochs):
    return rate * min(1.0, 2 * (1 - epoch / epochs))


def my_annealed__constant(rate, epoch, epochs):
    return rate
