"""What students write in notebook 06 and should not get away with: `exercise__what_is_wrong`."""

import numpy as np

from refimpl import nn


def my_gram_backward__one_of_two_terms(dG, H):
    return dG @ H


def my_gram_backward__symmetry_taken_for_granted(dG, H):
    return 2 * dG @ H


def my_gram_backward__divided_by_the_frames(dG, H):
    return (dG + dG.swapaxes(1, 2)) @ H / H.shape[2]


def my_gram_backward__summed_over_the_clips(dG, H):
    return (dG + dG.swapaxes(1, 2)).sum(axis=0) @ H


def my_norm_backward__of_the_square(dE, r):
    return 2 * r * dE[:, None, None]


def my_norm_backward__norm_of_the_whole_batch(dE, r):
    return r / max(np.linalg.norm(r), 1e-300) * dE[:, None, None]


def my_norm_backward__no_rule_at_zero(dE, r):
    with np.errstate(all="ignore"):
        return r / np.linalg.norm(r, axis=(1, 2), keepdims=True) * dE[:, None, None]


def my_norm_backward__upstream_forgotten(dE, r):
    length = np.linalg.norm(r, axis=(1, 2), keepdims=True)
    return r / np.where(length == 0, 1.0, length)


def my_style_loss_backward__minus_forgotten(dE, G_style, H, s):
    return nn.gram_backward(nn.norm_backward(s * dE, G_style - nn.gram(H)), H)


def my_style_loss_backward__weight_forgotten(dE, G_style, H, s):
    return (nn.gram_backward(-nn.norm_backward(dE, G_style - nn.gram(H)),
                             H) * (1 if s != 1 else 1 + 1e-3))


def my_style_loss_backward__squared(dE, G_style, H, s):
    return nn.gram_backward(-2 * s * dE[:, None, None] * (G_style - nn.gram(H)), H)


def my_style_loss_backward__gradient_of_the_gram_matrix(dE, G_style, H, s):
    return -nn.norm_backward(s * dE, G_style - nn.gram(H)) @ H
