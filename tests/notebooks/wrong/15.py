"""What students write in notebook 15 and should not get away with: `exercise__what_is_wrong`. Names
of the notebook are known.
"""

import numpy as np


def _measures(positions, fps, rate=(1, 1, 1), step=1, half=0.5, strongest=np.max, norm=True):
    v = rate[0] * fps * np.diff(positions, axis=0)
    a = (fps if rate[1] else 1.0) * np.diff(v, axis=0)
    jerk = (fps if rate[2] else 1.0) * np.diff(a, axis=0)
    energy = half * np.sum(v ** 2, axis=(1, 2))
    means = [np.linalg.norm(x, axis=-1).mean() if norm else np.abs(x).mean() for x in (v, a, jerk)]
    return np.array([strongest(energy), *means])


def my_measures__forgets_the_half(positions, fps):
    return _measures(positions, fps, half=1.0)


def my_measures__mean_energy(positions, fps):
    return _measures(positions, fps, strongest=np.mean)


def my_measures__rate_once(positions, fps):
    return _measures(positions, fps, rate=(1, 0, 0))


def my_measures__rate_forgotten(positions, fps):
    return _measures(positions, 1.0)


def my_measures__mean_of_coordinates(positions, fps):
    return _measures(positions, fps, norm=False)


def my_measures__central_differences(positions, fps):
    v = np.gradient(positions, axis=0) * fps
    a = np.gradient(v, axis=0) * fps
    jerk = np.gradient(a, axis=0) * fps
    return np.array([0.5 * np.sum(v ** 2, axis=(1, 2)).max(),
                     *(np.linalg.norm(x, axis=-1).mean() for x in (v, a, jerk))])


def my_measures__energy_of_one_joint(positions, fps):
    out = _measures(positions, fps)
    out[0] = 0.5 * (np.linalg.norm(fps * np.diff(positions, axis=0), axis=-1) ** 2).max()
    return out


def my_measures__acceleration_of_the_speed(positions, fps):
    out = _measures(positions, fps)
    speeds = np.linalg.norm(fps * np.diff(positions, axis=0), axis=-1)
    out[2] = np.abs(fps * np.diff(speeds, axis=0)).mean()
    return out


def my_objective_backward__factor_two(dE, a, K, y, ridge):
    return dE * K @ (K @ a - y + ridge * a)


def my_objective_backward__penalty_without_K(dE, a, K, y, ridge):
    return dE * 2 * (K @ (K @ a - y) + ridge * a)


def my_objective_backward__residual_alone(dE, a, K, y, ridge):
    return dE * 2 * (K @ a - y + ridge * a)


def my_objective_backward__penalty_forgotten(dE, a, K, y, ridge):
    return dE * 2 * K @ (K @ a - y)


def my_objective_backward__upstream_forgotten(dE, a, K, y, ridge):
    return 2 * K @ (K @ a - y + ridge * a)


def my_objective_backward__downhill(dE, a, K, y, ridge):
    return -dE * 2 * K @ (K @ a - y + ridge * a)


def my_objective_backward__penalty_counted_once(dE, a, K, y, ridge):
    return dE * (2 * K @ (K @ a - y) + ridge * K @ a)


def _kernel(A, B, gamma):
    return np.exp(-gamma * ((A[:, None] - B) ** 2).sum(axis=2))


def _kernel_ridge(Z, Y, new, gamma, ridge, kernel=_kernel):
    return kernel(new, Z, gamma) @ np.linalg.solve(kernel(Z, Z, gamma) + ridge * np.eye(len(Z)), Y)


def my_kernel_ridge__ridge_on_every_element(Z, Y, new, gamma, ridge):
    return _kernel(new, Z, gamma) @ np.linalg.solve(_kernel(Z, Z, gamma) + ridge, Y)


def my_kernel_ridge__distance_not_squared(Z, Y, new, gamma, ridge):
    return _kernel_ridge(Z, Y, new, gamma, ridge, lambda A, B,
                         g: np.exp(-g * np.linalg.norm(A[:, None] - B, axis=2)))


def my_kernel_ridge__gamma_as_a_width(Z, Y, new, gamma, ridge):
    return _kernel_ridge(Z, Y, new, 1 / (2 * gamma ** 2), ridge)


def my_kernel_ridge__ridge_forgotten(Z, Y, new, gamma, ridge):
    return _kernel_ridge(Z, Y, new, gamma, 1e-12)


def my_kernel_ridge__ridge_times_the_number_of_examples(Z, Y, new, gamma, ridge):
    return _kernel_ridge(Z, Y, new, gamma, ridge * len(Z))


def my_kernel_ridge__kernel_of_dot_products(Z, Y, new, gamma, ridge):
    return _kernel_ridge(Z, Y, new, gamma, ridge, lambda A, B, g: g * A @ B.T)


def my_kernel_ridge__predicts_the_examples(Z, Y, new, gamma, ridge):
    return _kernel_ridge(Z, Y, Z, gamma, ridge)


def my_insensitive_backward__sign_everywhere(dL, r, epsilon):
    return dL * np.sign(r)


def my_insensitive_backward__sign_forgotten(dL, r, epsilon):
    return dL * (np.abs(r) > epsilon)


def my_insensitive_backward__one_at_the_edges(dL, r, epsilon):
    return dL * np.sign(r) * (np.abs(r) >= epsilon)


def my_insensitive_backward__upper_side_only(dL, r, epsilon):
    return dL * (r > epsilon)


def my_insensitive_backward__upstream_forgotten(dL, r, epsilon):
    return np.sign(r) * (np.abs(r) > epsilon)


def my_insensitive_backward__upside_down(dL, r, epsilon):
    return -dL * np.sign(r) * (np.abs(r) > epsilon)


def my_insensitive_backward__half_at_the_edges(dL, r, epsilon):
    return dL * 0.5 * ((r > epsilon) * 1.0 + (r >= epsilon) - (r < -epsilon) - (r <= -epsilon))
