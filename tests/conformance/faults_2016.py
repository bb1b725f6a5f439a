"""Faults of the 2016 code's network and losses: (what is wrong, function, what stands in its
place).
"""

import numpy as np

from refimpl.conformance import functions_2016 as ours
from refimpl.conformance import rivals_2016 as rivals
from refimpl.holden2016 import losses
from refimpl.holden2016.rows import CONTACTS, REFERENCE, TURN, VELOCITY
from refimpl.motion.joints import FEET


def changed(function, number, change):
    """One gradient of several, changed by `change(gradient, *arguments)`."""
    def wrong(*arguments, **attributes):
        results = list(function(*arguments, **attributes))
        results[number] = change(results[number], *arguments)
        return tuple(results)
    return wrong


def without(name, function):
    """A keyword forgotten."""
    def wrong(*arguments, **attributes):
        attributes.pop(name, None)
        return function(*arguments, **attributes)
    return wrong


def rows_forgotten(function, rows):
    def wrong(*arguments, **attributes):
        gradient = function(*arguments, **attributes).copy()
        gradient[:, rows] = 0
        return gradient
    return wrong


def from_the_first_frame(motion, contacts):
    """The floor seen in frames 0 to T - 2, as the slides are."""
    heights = motion[:, [3 + 3 * foot + 1 for foot in FEET]]
    below = np.minimum(heights, 0) ** 2
    count = 4 * max(motion.shape[2] - 1, 1)
    return (losses.foot_loss(motion, contacts)
            + 10 / 4 / count * (below[:, :, :-1] - below[:, :, 1:]).sum((1, 2)))


def floor_of_planted_feet(motion, contacts):
    """The floor term masked by the contacts."""
    heights = motion[:, [3 + 3 * foot + 1 for foot in FEET], 1:]
    count = 4 * max(motion.shape[2] - 1, 1)
    free = (np.minimum(heights,
                       0) ** 2 * (1 - np.asarray(contacts, motion.dtype)[:, :, :-1])).sum((1, 2))
    return losses.foot_loss(motion, contacts) - 10 / 4 / count * free


def other_length(motion):
    """One of the code's 20 lengths with two digits exchanged: 2.37 for 2.73."""
    lengths = losses.LENGTHS.copy()
    lengths[16] = 2.37
    return (losses.losses.bone_loss(losses.as_66(motion), lengths,
                                    bones=losses.BONES) / (20 * motion.shape[2]))


FAULTS = (
    ("2016: dropout not divided", "encode_2016", rivals.not_divided(ours.encode)),
    ("2016: dropout forgotten in its gradient", "encode_2016_backward",
     without("kept", ours.encode_backward)),
    ("2016: the encoder's bias twice", "encode_2016", lambda X, W, b,
     **k: ours.encode(X, W, 2 * b, **k)),
    ("2016: Theano's kinks", "encode_2016_backward", rivals.kinks_of_theano),
    ("2016: depooling by repetition", "decode_2016", rivals.depooled_by_repetition),
    ("2016: the decoder's filters flipped", "decode_2016",
     rivals.flipped(ours.decode)),
    ("2016: the decoder's bias subtracted, as where it is tied", "decode_2016", lambda H, W, b,
     **k: ours.decode(H, W, -b, **k)),
    ("2016: the choice forgotten in the decoder's gradient", "decode_2016_backward",
     without("chosen", ours.decode_backward)),
    ("2016: the decoder's bias gradient a mean", "decode_2016_backward",
     changed(ours.decode_backward, 2, lambda g, d, *a: g / len(d))),
    ("2016: one weight of sparsity", "autoencoder_loss_2016", rivals.one_sparsity),
    ("2016: sparsity of a bias too", "autoencoder_loss_2016",
     lambda X, We, be, Wd, bd,
     **k: ours.autoencoder_loss(X, We, be, Wd, bd, **k) + X.dtype.type(0.001) * np.abs(be).mean()),
    ("2016: the gradient without what is wanted", "autoencoder_loss_2016_backward",
     changed(ours.autoencoder_loss_backward, 0, lambda g, d, X, *a: g + 2 * d * X / X.size)),
    ("2016: the hidden dropout forgotten in the gradient", "autoencoder_loss_2016_backward",
     without("kept_hidden", ours.autoencoder_loss_backward)),
    ("2016: no floor term", "foot_loss_2016", rivals.without_the_floor),
    ("2016: the floor a frame early", "foot_loss_2016", from_the_first_frame),
    ("2016: the floor of planted feet alone", "foot_loss_2016", floor_of_planted_feet),
    ("2016: the turning with its sign of 2017", "foot_loss_2016", rivals.turning_as_in_2017),
    ("2016: no gradient of the turning", "foot_loss_2016_backward",
     rows_forgotten(losses.foot_loss_backward, TURN)),
    ("2016: no gradient of the velocity", "foot_loss_2016_backward",
     rows_forgotten(losses.foot_loss_backward, VELOCITY)),
    ("2016: arms at the chest", "bone_loss_2016", rivals.arms_at_the_chest),
    ("2016: one length with its digits exchanged", "bone_loss_2016", other_length),
    ("2016: no gradient of the hips", "bone_loss_2016_backward",
     rows_forgotten(losses.bone_loss_backward, slice(REFERENCE.stop, REFERENCE.stop + 3))),
    ("2016: without the factor of 10", "trajectory_loss_2016", rivals.without_ten),
    ("2016: contacts among the path", "trajectory_loss_2016_backward",
     lambda d, motion, *, wanted: losses.trajectory_loss_backward(d, motion, wanted)
     + 1e-3 * d[:, None, None] * (np.arange(motion.shape[1])
                                  == CONTACTS.start)[:, None].astype(motion.dtype)),
    ("2016: s and c not divided", "search_loss_2016", rivals.weights_not_divided),
    ("2016: half the Gram matrix's gradient", "search_loss_2016_backward",
     lambda d, H, *, content, gram,
     amount=0.1: 0.5 * (losses.search_loss_backward(d, H, content, gram, amount=amount)
                                                       + 2 * d[:, None, None] * (H - content)
                        / (H[0].size * (1 + amount)))),
)
