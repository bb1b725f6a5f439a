"""Answers to 08_adam.ipynb."""

import numpy as np


def my_adam_step(p, g, m, v, t, rate, beta1, beta2, epsilon):
    m = beta1 * m + (1 - beta1) * g
    v = beta2 * v + (1 - beta2) * g**2
    m_hat, v_hat = m / (1 - beta1**t), v / (1 - beta2**t)
    return p - rate * m_hat / (np.sqrt(v_hat) + epsilon), m, v


def my_epsilon_hat_step(p, g, m, v, t, rate, beta1, beta2, epsilon):
    m = beta1 * m + (1 - beta1) * g
    v = beta2 * v + (1 - beta2) * g**2
    return p - rate * np.sqrt(1 - beta2**t) / (1 - beta1**t) * m / (np.sqrt(v) + epsilon), m, v


def my_annealed(rate, epoch, epochs):
    return rate * min(1.0, 2 * (1 - (epoch - 0.5) / epochs))
