"""What students write in notebook 09 and should not get away with: `exercise__what_is_wrong`."""

import numpy as np

from refimpl import nn


def _backward(dE, X, W0, b0, *, encoder=1, decoder=1, bias=-1, relu=True, size=None, target=1):
    Z = nn.conv1d(X, W0, b0)
    P = nn.max_pool1d(Z)
    H = nn.relu(P)
    D = nn.avg_depool1d(H) - b0[:, None]
    dR = 2 * (nn.conv_transpose1d(D, W0) - target * X) / (size or X.size) * dE
    dD, dW_decoder, _ = nn.conv_transpose1d_backward(dR, D, W0)
    dH = nn.avg_depool1d_backward(dD, H)
    dZ = nn.max_pool1d_backward(nn.relu_backward(dH, P) if relu else dH, Z)
    _, dW_encoder, db_encoder = nn.conv1d_backward(dZ, X, W0, b0)
    return decoder * dW_decoder + encoder * dW_encoder, db_encoder + bias * dD.sum(axis=(0, 2))


def my_autoencoder_backward__the_encoders_filters_forgotten(*arguments):
    return _backward(*arguments, encoder=0)


def my_autoencoder_backward__the_decoders_filters_forgotten(*arguments):
    return _backward(*arguments, decoder=0)


def my_autoencoder_backward__sign_of_the_decoders_bias(*arguments):
    return _backward(*arguments, bias=1)


def my_autoencoder_backward__relu_forgotten(*arguments):
    return _backward(*arguments, relu=False)


def my_autoencoder_backward__sum_instead_of_mean(*arguments):
    return _backward(*arguments, size=1)


def my_sparsity_backward__of_the_square(dE, theta, alpha):
    return 2 * alpha * dE * theta / theta.size


def my_sparsity_backward__one_at_zero(dE, theta, alpha):
    return alpha * dE * np.where(theta >= 0, 1.0, -1.0) / theta.size


def my_sparsity_backward__sum_instead_of_mean(dE, theta, alpha):
    return alpha * dE * np.sign(theta)


def my_sparsity_backward__upstream_forgotten(dE, theta, alpha):
    return alpha * np.sign(theta) / theta.size


def _project(X, W0, b0, *, odd="double", sign=-1, half=0.5):
    frames = X.shape[2]
    if frames % 2:
        last = X[:, :, -1:] if odd == "double" else np.zeros_like(X[:, :, -1:])
        X = np.concatenate([X, last], axis=2)
    H = nn.relu(nn.max_pool1d(nn.conv1d(X, W0, b0)))
    return nn.conv_transpose1d(half * np.repeat(H, 2, axis=2) + sign * b0[:, None],
                               W0)[:, :, :frames]


def my_project__a_zero_behind_an_odd_clip(X, W0, b0):
    return _project(X, W0, b0, odd="zero")


def my_project__bias_added_again(X, W0, b0):
    return _project(X, W0, b0, sign=1)


def my_project__repeated_instead_of_averaged(X, W0, b0):
    return _project(X, W0, b0, half=1.0)


def my_project__relu_left_out(X, W0, b0):
    frames = X.shape[2]
    if frames % 2:
        X = np.concatenate([X, X[:, :, -1:]], axis=2)
    return nn.conv_transpose1d(nn.avg_depool1d(nn.max_pool1d(nn.conv1d(X, W0, b0))) - b0[:, None],
                               W0)[:, :, :frames]


def _depooled(h, chosen, share=1.0):
    return nn.random_depool1d(share * h, chosen)


def my_random_depool__half_of_the_value(h, chosen):
    return _depooled(h, chosen, 0.5)


def my_random_depool__the_other_frame(h, chosen):
    return _depooled(h, 1 - chosen)


def my_random_depool__both_frames(h, chosen):
    return nn.avg_depool1d(2 * h)


def my_random_depool__one_choice_for_all_units(h, chosen):
    return _depooled(h, np.broadcast_to(chosen[:, :1], h.shape))


def my_random_depool__first_frames_then_second_frames(h, chosen):
    return np.concatenate([h * (chosen == 0), h * (chosen == 1)], axis=2)


def my_random_depool_backward__of_averages(dx, h, chosen):
    return nn.avg_depool1d_backward(dx, h)


def my_random_depool_backward__sum_of_both(dx, h, chosen):
    return 2 * nn.avg_depool1d_backward(dx, h)


def my_random_depool_backward__the_other_frame(dx, h, chosen):
    return nn.random_depool1d_backward(dx, h, 1 - chosen)


def my_random_depool_backward__half(dx, h, chosen):
    return nn.random_depool1d_backward(dx, h, chosen) / 2


def _steps(dE, X, W0, b0, mask=True, share=0.5, count=None):
    Z = nn.conv1d(X, W0, b0)
    Q = nn.max_pool1d(Z)
    H = nn.relu(Q)
    D = nn.avg_depool1d(H) - b0[:, None]
    dR = 2 * (nn.conv_transpose1d(D, W0) - X) / (count or X.size) * dE
    dD, dW_decoder, _ = nn.conv_transpose1d_backward(dR, D, W0)
    dH = nn.avg_depool1d_backward(dD, H) * (2 * share)
    dQ = nn.relu_backward(dH, Q) if mask else dH
    dZ = nn.max_pool1d_backward(dQ, Z)
    return {"dR": dR, "dD": dD, "dH": dH, "dQ": dQ, "dZ": dZ, "dW_decoder": dW_decoder,
            "dW_encoder": nn.conv1d_backward(dZ, X, W0, b0)[1]}


def my_autoencoder_steps__no_mask(dE, X, W0, b0):
    return _steps(dE, X, W0, b0, mask=False)


def my_autoencoder_steps__depooling_without_its_half(dE, X, W0, b0):
    return _steps(dE, X, W0, b0, share=1.0)


def my_autoencoder_steps__mean_over_clips_alone(dE, X, W0, b0):
    return _steps(dE, X, W0, b0, count=len(X))


def my_autoencoder_steps__upstream_ignored(dE, X, W0, b0):
    return _steps(1.0, X, W0, b0)
