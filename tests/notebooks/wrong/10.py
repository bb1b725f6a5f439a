"""What students write in notebook 10 and should not get away with: `exercise__what_is_wrong`."""

import numpy as np

from refimpl import nn


def _hidden(dE, H, content, gram, s, style=4, size=None, frames=True, sign=1, spread=True):
    _, m, T = H.shape
    D = H @ H.swapaxes(1, 2) - gram
    dH = (style * s / (m**2 if size is None else size) * (D @ H)
          + sign * 2 * (1 - s) / (m * T if frames else m) * (H - content))
    return dH * (dE[:, None, None] if spread else dE.sum())


def my_hidden_loss_backward__one_of_the_grams_two_terms(dE, H, content, gram, s):
    return _hidden(dE, H, content, gram, s, style=2)


def my_hidden_loss_backward__content_divided_by_the_units_alone(dE, H, content, gram, s):
    return _hidden(dE, H, content, gram, s, frames=False)


def my_hidden_loss_backward__style_not_divided(dE, H, content, gram, s):
    return _hidden(dE, H, content, gram, s, size=1)


def my_hidden_loss_backward__content_pushed_away(dE, H, content, gram, s):
    return _hidden(dE, H, content, gram, s, sign=-1)


def my_hidden_loss_backward__upstream_of_all_clips_together(dE, H, content, gram, s):
    return _hidden(dE, H, content, gram, s, spread=False)


def my_decoded_motion_backward__half_forgotten(dm, H, W0, b0, deviation):
    dE = nn.conv1d(dm * deviation[:, None], W0)
    return dE[:, :, 0::2] + dE[:, :, 1::2]


def my_decoded_motion_backward__deviation_forgotten(dm, H, W0, b0, deviation):
    dE = nn.conv1d(dm, W0)
    return 0.5 * (dE[:, :, 0::2] + dE[:, :, 1::2])


def my_decoded_motion_backward__filters_flipped(dm, H, W0, b0, deviation):
    dE = nn.conv1d(dm * deviation[:, None], np.ascontiguousarray(W0[:, :, ::-1]))
    return 0.5 * (dE[:, :, 0::2] + dE[:, :, 1::2])


def my_decoded_motion_backward__first_frame_of_each_pair(dm, H, W0, b0, deviation):
    return nn.conv1d(dm * deviation[:, None], W0)[:, :, 0::2]


def my_decoded_motion_backward__bias_subtracted_again(dm, H, W0, b0, deviation):
    dE = nn.conv1d(dm * deviation[:, None], W0) - b0[:, None]
    return 0.5 * (dE[:, :, 0::2] + dE[:, :, 1::2])


def _walked(content, result, columns=slice(1, 3), invert=False, mean=np.mean, squares=False):
    speeds = [mean(np.linalg.norm(v[:, 1:], axis=1)) for v in (content, result)]
    path = content.copy()
    path[:, columns] *= speeds[0] / speeds[1] if invert else speeds[1] / speeds[0]
    return path


def my_walked_as__turns_faster_too(content, result):
    return _walked(content, result, columns=slice(0, 3))


def my_walked_as__the_inverse(content, result):
    return _walked(content, result, invert=True)


def my_walked_as__forward_alone(content, result):
    return _walked(content, result, columns=slice(1, 2))


def my_walked_as__frame_by_frame(content, result):
    path = content.copy()
    path[:, 1:] *= (np.linalg.norm(result[:, 1:],
                                   axis=1) / np.linalg.norm(content[:, 1:], axis=1))[:, None]
    return path
