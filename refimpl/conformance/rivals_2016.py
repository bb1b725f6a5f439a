"""Conventions of others for the 2016 code's network and losses, as `rivals` has them for the rest.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from .. import nn
from ..holden2016 import losses, network
from ..holden2016.rows import TURN
from ..holden2017 import losses as losses_2017
from . import functions_2016 as ours
from .rivals_forms import FLIPPED, flipped
from .specification import Array


def kinks_of_theano(dH: Array, X: Array, We: Array, be: Array, *,
                    kept: Array | None = None) -> tuple[Any, ...]:
    """ReLU's gradient 1 at 0, and all of equal largest elements get the gradient."""
    D = network.drop(X, kept)
    Z = nn.conv1d(D, We, be)
    P = np.repeat(nn.max_pool1d(nn.relu(Z)), 2, axis=2)
    dZ, pooled = np.zeros_like(Z), Z[:, :, :P.shape[2]]
    dZ[:, :, :P.shape[2]] = np.repeat(dH, 2, axis=2) * ((nn.relu(pooled) == P) & (pooled >= 0))
    dD, dWe, dbe = nn.conv1d_backward(dZ, D, We, be)
    return network.drop(dD, kept), dWe, dbe


def not_divided(function: Callable[..., Any]) -> Callable[..., Any]:
    """A dropout that does not divide what it keeps, as in the papers before the inverted form."""
    return lambda x, *arrays, kept=None, **attributes: function(
        x if kept is None else x * np.asarray(kept, x.dtype), *arrays, **attributes)


def depooled_by_repetition(H: Array, Wd: Array, bd: Array,
                           *, chosen: Array | None = None, kept: Array | None = None) -> Array:
    """A decoder whose average-depooling repeats each value and does not halve it."""
    return ours.decode(2 * H if chosen is None else H, Wd, bd, chosen=chosen, kept=kept)


def one_sparsity(X: Array, We: Array, be: Array, Wd: Array, bd: Array, **chances: Any) -> Any:
    """Equation 3's one weight of 0.01 for both filters, in means."""
    by_code = 0.001 * np.abs(We).mean() + 0.00125 * np.abs(Wd).mean()
    by_paper = 0.01 * (np.abs(We).sum() + np.abs(Wd).sum()) / (We.size + Wd.size)
    return ours.autoencoder_loss(X, We, be, Wd, bd, **chances) - by_code + by_paper


def without_the_floor(motion: Array, contacts: Array) -> Array:
    """The foot loss without its term for feet below the floor."""
    count = 4 * max(motion.shape[2] - 1, 1)
    return losses.SCALE / 4 / count * losses_2017.foot_loss(losses.as_66(motion), contacts)


def turning_as_in_2017(motion: Array, contacts: Array) -> Array:
    """Row 68 taken for the turning, where it is minus the turning."""
    motion = motion.copy()
    motion[:, TURN] *= -1
    return losses.foot_loss(motion, contacts)


def arms_at_the_chest(motion: Array) -> Array:
    """The bone loss with arms that hang from the chest."""
    count = len(losses.BONES) * motion.shape[2]
    return losses_2017.bone_loss(losses.as_66(motion), losses.LENGTHS) / count


def sums_for_means(motion: Array) -> Array:
    """The bone loss as a sum over bones and frames."""
    return losses.bone_loss(motion) * len(losses.BONES) * motion.shape[2]


def without_ten(motion: Array, *, wanted: Array) -> Array:
    """The trajectory loss without its factor of ten."""
    return losses.trajectory_loss(motion, wanted) / losses.SCALE


def weights_not_divided(H: Array, *, content: Array, gram: Array, amount: float = 0.1) -> Array:
    """s = amount and c = 1, not divided by their sum."""
    return losses.search_loss(H, content, gram, amount=amount) * (1 + amount)


RIVALS: dict[str, list[tuple[str, Callable[..., Any]]]] = {
    "encode_2016": [
        ("a dropout that does not divide by 0.75", not_divided(ours.encode)),
        (FLIPPED, flipped(ours.encode))],
    "encode_2016_backward": [("Theano's kinks: relu'(0) = 1, ties to all", kinks_of_theano)],
    "decode_2016": [
        ("depooling by repetition, without the half", depooled_by_repetition),
        (FLIPPED, flipped(ours.decode))],
    "autoencoder_loss_2016": [("one weight of 0.01 for both filters", one_sparsity)],
    "foot_loss_2016": [
        ("the feet without the floor term", without_the_floor),
        ("the turning with its sign of 2017", turning_as_in_2017)],
    "bone_loss_2016": [
        ("arms at the chest, as in 2017", arms_at_the_chest),
        ("sums for means, as in 2017", sums_for_means)],
    "trajectory_loss_2016": [("without the factor of 10", without_ten)],
    "search_loss_2016": [("s and c not divided by their sum", weights_not_divided)]}
