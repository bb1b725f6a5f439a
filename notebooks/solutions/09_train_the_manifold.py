"""Answers to 09_train_the_manifold.ipynb."""

import numpy as np

from refimpl import nn


def my_autoencoder_steps(dE, X, W0, b0):
    Z = nn.conv1d(X, W0, b0)
    Q = nn.max_pool1d(Z)
    H = nn.relu(Q)
    D = nn.avg_depool1d(H) - b0[:, None]
    R = nn.conv_transpose1d(D, W0)
    dR = 2 * (R - X) / X.size * dE
    dD, dW_decoder, _ = nn.conv_transpose1d_backward(dR, D, W0)
    dH = nn.avg_depool1d_backward(dD, H)
    dQ = nn.relu_backward(dH, Q)
    dZ = nn.max_pool1d_backward(dQ, Z)
    dW_encoder = nn.conv1d_backward(dZ, X, W0, b0)[1]
    return {"dR": dR, "dD": dD, "dH": dH, "dQ": dQ, "dZ": dZ, "dW_decoder": dW_decoder,
            "dW_encoder": dW_encoder}


def my_autoencoder_backward(dE, X, W0, b0):
    Z = nn.conv1d(X, W0, b0)
    P = nn.max_pool1d(Z)
    H = nn.relu(P)
    D = nn.avg_depool1d(H) - b0[:, None]
    R = nn.conv_transpose1d(D, W0)
    dR = 2 * (R - X) / X.size * dE
    dD, dW_decoder, _ = nn.conv_transpose1d_backward(dR, D, W0)
    dH = nn.avg_depool1d_backward(dD, H)
    dZ = nn.max_pool1d_backward(nn.relu_backward(dH, P), Z)
    _, dW_encoder, db_encoder = nn.conv1d_backward(dZ, X, W0, b0)
    return dW_decoder + dW_encoder, db_encoder - dD.sum(axis=(0, 2))


def my_sparsity_backward(dE, theta, alpha):
    return alpha * dE * np.sign(theta) / theta.size


def my_random_depool(h, chosen):
    both = np.stack([h * (chosen == k) for k in (0, 1)], axis=3)          # (N, C, T, 2)
    return both.reshape(h.shape[0], h.shape[1], 2 * h.shape[2])


def my_random_depool_backward(dx, h, chosen):
    pairs = dx.reshape(*h.shape, 2)                                   # (N, C, T, 2)
    return np.where(chosen == 1, pairs[..., 1], pairs[..., 0])


def my_project(X, W0, b0):
    frames = X.shape[2]
    if frames % 2:
        X = np.concatenate([X, X[:, :, -1:]], axis=2)
    H = nn.relu(nn.max_pool1d(nn.conv1d(X, W0, b0)))
    return nn.conv_transpose1d(nn.avg_depool1d(H) - b0[:, None], W0)[:, :, :frames]
