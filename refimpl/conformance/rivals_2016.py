"""Conventions of others for the 2016 code's network and losses, as `rivals` has them for the rest.
"""

import numpy as np

from .. import nn
from ..holden2016 import losses, network
from ..holden2016.rows import TURN
from ..holden2017 import losses as losses_2017
from . import operations_2016 as ours


def kinks_of_theano(dH, X, We, be, *, kept=None):
    """ReLU's gradient 1 at 0, and all of equal largest elements get the gradient."""
    D = network.drop(X, kept)
    Z = nn.conv1d(D, We, be)
    P = np.repeat(nn.max_pool1d(nn.relu(Z)), 2, axis=2)
    dZ = np.zeros_like(Z)
    dZ[:, :, :P.shape[2]] = np.repeat(dH, 2, axis=2) * ((nn.relu(Z)[:, :, :P.shape[2]] == P) &
                                                        (Z[:, :, :P.shape[2]] >= 0))
    dD, dWe, dbe = nn.conv1d_backward(dZ, D, We, be)
    return network.drop(dD, kept), dWe, dbe


def not_divided(function):
    """A dropout that does not divide what it keeps, as in the papers before the inverted form."""
    def form(x, *arrays, kept=None, **attributes):
        return function(x if kept is None else x * np.asarray(kept, x.dtype), *arrays, **attributes)
    return form


def depooled_by_repetition(H, Wd, bd, *, chosen=None, kept=None):
    return ours.decode(2 * H if chosen is None else H, Wd, bd, chosen=chosen, kept=kept)


def with_flipped_filters(function):
    """The filters as Theano has them, used without reversing them."""
    def form(x, W, b, **attributes):
        return function(x, np.ascontiguousarray(W[:, :, ::-1]), b, **attributes)
    return form


def one_sparsity(X, We, be, Wd, bd, **chances):
    """Equation 3's one weight of 0.01 for both filters, in means."""
    own = 0.001 * np.abs(We).mean() + 0.00125 * np.abs(Wd).mean()
    other = 0.01 * (np.abs(We).sum() + np.abs(Wd).sum()) / (We.size + Wd.size)
    return ours.autoencoder_loss(X, We, be, Wd, bd, **chances) - own + other


def without_the_floor(motion, contacts):
    count = 4 * max(motion.shape[2] - 1, 1)
    return losses.SCALE / 4 / count * losses_2017.foot_loss(losses.as_66(motion), contacts)


def turning_as_in_2017(motion, contacts):
    """Row 68 taken for the turning, where it is minus the turning."""
    motion = motion.copy()
    motion[:, TURN] *= -1
    return losses.foot_loss(motion, contacts)


def arms_at_the_chest(motion):
    count = len(losses.BONES) * motion.shape[2]
    return losses_2017.bone_loss(losses.as_66(motion), losses.LENGTHS) / count


def sums_for_means(motion):
    return losses.bone_loss(motion) * len(losses.BONES) * motion.shape[2]


def without_ten(motion, *, wanted):
    return losses.trajectory_loss(motion, wanted) / losses.SCALE


def weights_not_divided(H, *, content, gram, amount=0.1):
    """s = amount and c = 1, not divided by their sum."""
    return losses.search_loss(H, content, gram, amount=amount) * (1 + amount)


RIVALS = {
    "encode_2016": [
        ("a dropout that does not divide by 0.75", not_divided(ours.encode)),
        ("the filters as Theano has them, not reversed", with_flipped_filters(ours.encode))],
    "encode_2016_backward": [
        ("Theano's kinks: relu'(0) = 1, ties to all", kinks_of_theano)], "decode_2016": [
            ("depooling by repetition, without the half", depooled_by_repetition),
            ("the filters as Theano has them, not reversed", with_flipped_filters(ours.decode))],
    "autoencoder_loss_2016": [
        ("one weight of 0.01 for both filters", one_sparsity)], "foot_loss_2016": [
            ("the feet without the floor term", without_the_floor),
            ("the turning with its sign of 2017", turning_as_in_2017)], "bone_loss_2016": [
                ("arms at the chest, as in 2017", arms_at_the_chest),
                ("sums for means, as in 2017", sums_for_means)], "trajectory_loss_2016": [
                    ("without the factor of 10", without_ten)], "search_loss_2016": [
                        ("s and c not divided by their sum", weights_not_divided)], }
