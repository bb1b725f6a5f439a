r"""The optimisation-based predecessor (Holden, Saito and Komura 2016), the second system of Table 1: no network is trained for a style.

1. Hidden units, begun as those of noise (or of the content), get the style's Gram matrix G and stay near the content's units:

    H = argmin  s mean_squares(Gram(H) - G) + c mean_squares(H - L(C)),       s + c = 1

2. They give way until the decoded motion keeps to its feet, bones and path:

    H = argmin  foot + bone + trajectory of  deviation L+(H) + mean

   where the path is the content's, walked as fast as the style walks: v_r' = v_r(C) * mean |v_r(L+(H))| / mean |v_r(C)|.

Both by Adam. The means of squares of the first search, the steps of 0.01 and their numbers are the 2016 code's. What is not, measured
by running that code:

- s = 0.1 / 1.1 there: a Gram matrix grows with the square of the hidden units, which this package's normaliser makes 2.4 times
  larger, and of those 0.1 leaves nothing of the content;
- the noise there is uniform within sqrt(6 / (C + T)), some 0.10 of a normalised unit; here it is a unit Gaussian, 17 times larger;
- between the two searches the motion is decoded and encoded again there, which projects it; here the same H goes on. Begun at noise
  the result's jerk is 1.9 times real motion's before any clean-up, begun at the content 1.5 (of a loss network that learnt with halves
  several times more);
- the constraints are means there, feet are kept above the floor and both arms hang from the neck; here they are the sums of
  equations 7 to 9. Adam's epsilon is 1e-5 in the search there, 1e-8 here (harmless);
- the style's Gram matrix is not scaled to the content's frames there; the motion has 73 numbers, contacts among them.
"""

from dataclasses import dataclass

import numpy as np

from .. import nn
from ..motion.dataset import to_scale
from ..motion.features import VELOCITIES
from . import losses
from .networks import decode, decode_backward_to_input, encode
from .total import WEIGHTS, Target, Weights, column, constraint_losses, constraint_losses_backward, denormalise
from .transfer import onto_skeleton


@dataclass(frozen=True)
class Settings:
    """s against c = 1 - s;  start : "noise" or "content";  iterations and rate of Adam, of both searches.   Raises ValueError."""

    style: float = 0.003
    start: str = "noise"
    iterations: int = 250
    rate: float = 0.01
    constraint_iterations: int = 100
    constraint_rate: float = 0.01

    def __post_init__(self):
        if not 0 <= self.style <= 1:
            raise ValueError(f"style: found {self.style}, needed a share from 0 to 1")
        if self.start not in ("noise", "content"):
            raise ValueError(f"start: found {self.start!r}, needed noise or content")
        for name in ("iterations", "constraint_iterations"):
            value = getattr(self, name)
            if not isinstance(value, (int, np.integer)) or value < 0:
                raise ValueError(f"{name}: found {value!r}, needed a whole number from 0 on")
        for name in ("rate", "constraint_rate"):
            if not 0 < getattr(self, name) < np.inf:
                raise ValueError(f"{name}: found {getattr(self, name)}, needed a positive number")


def hidden_loss(H, content, gram, *, style):
    """The first search's loss.   H, content : (N, m, T // 2), gram : (N, m, m), style : s  ->  (N,)"""
    return (losses.style_loss(gram, H, s=style, reading="mean_squares")
            + losses.content_loss(content, H, c=1 - style, reading="mean_squares"))


def hidden_loss_backward(dloss, H, content, gram, *, style):
    """dloss : (N,)  ->  dH (N, m, T // 2)"""
    return (losses.style_loss_backward(dloss, gram, H, s=style, reading="mean_squares")[1]
            + losses.content_loss_backward(dloss, content, H, c=1 - style, reading="mean_squares")[1])


def decoded_loss(H, target, params, mean, deviation, weights=Weights()):
    """The second search's loss, of the decoded motion.   H : (N, m, T // 2), target : Target, params : W0, b0  ->  (N,)"""
    return sum(constraint_losses(denormalise(decode(H, params), mean, deviation), target, weights).values())


def decoded_loss_backward(dloss, H, target, params, mean, deviation, weights=Weights()):
    """dloss : (N,)  ->  dH (N, m, T // 2)"""
    X = decode(H, params)
    dmotion = constraint_losses_backward(dloss, denormalise(X, mean, deviation), target, weights)
    return decode_backward_to_input(dmotion * column(deviation, X), H, params)


def minimise(H, backward, iterations, rate):
    """Adam on hidden units.   backward : H -> dH   ->  H"""
    params = {"H": H.copy()}
    state = nn.adam_start(params)
    for _ in range(iterations):
        nn.adam_update(params, {"H": backward(params["H"])}, state, rate=rate)
    return params["H"]


def optimise(features, contacts, exemplars, manifold, *, settings=Settings(), weights=None, seed=0):
    """Content features in the style of the exemplars, all on the manifold's scale.

    features : (T, 66);  contacts : (T, 4);  exemplars : list of (T_e, 66);  weights : of the constraints, those of training unless given
    ->  (T, 66).   Raises ValueError.
    """
    if not exemplars:
        raise ValueError("exemplars: found none, needed at least one clip in the style")
    params, normaliser = manifold.params, manifold.normaliser
    weights = weights or WEIGHTS["norm"].fitted(manifold.leg)
    even = np.concatenate([features, features[-1:]]) if len(features) % 2 else features
    planted = np.concatenate([contacts, contacts[-1:]]) if len(features) % 2 else contacts
    X = manifold.network_input(even)
    one = np.ones(1, X.dtype)
    content = encode(X, params)
    gram = losses.style_target([encode(manifold.network_input(pairs(e)), params)[0] for e in exemplars], content.shape[2])[None]
    start = encode(np.random.default_rng([seed, 4]).standard_normal(X.shape).astype(X.dtype), params) if settings.start == "noise" else content

    H = minimise(start, lambda H: hidden_loss_backward(one, H, content, gram, style=settings.style),
                 settings.iterations, settings.rate)
    path = walked_as(even[:, VELOCITIES], manifold.motion(decode(H, params))[:, VELOCITIES])
    target = Target(None, None, planted.T[None].astype(X.dtype), manifold.bones, path.T[None].astype(X.dtype))
    H = minimise(H, lambda H: decoded_loss_backward(one, H, target, params, normaliser.mean, normaliser.deviation, weights),
                 settings.constraint_iterations, settings.constraint_rate)
    moved = manifold.motion(decode(H, params))
    moved[:, VELOCITIES] = path
    return moved[:len(features)]


def walked_as(content, result):
    """A root's velocities with the mean speed of another's; it turns as before.   (T, 3), (T, 3): turn, forward, sideways  ->  (T, 3)"""
    speed, wanted = (float(np.linalg.norm(v[:, 1:], axis=1).mean()) for v in (content, result))
    return content * np.array([1.0, *[wanted / speed if speed > 0 else 1.0] * 2])


def pairs(features):
    """An even number of frames, for the pooling.   (T, 66)  ->  (T - T % 2, 66), or one frame twice"""
    return features[:len(features) - len(features) % 2] if len(features) > 1 else np.repeat(features, 2, axis=0)


def optimise_transfer(take, exemplars, manifold, *, clean=True, settings=Settings(), weights=None, seed=0):
    """Stylise a take by optimisation.   Take, list of Take in the style, Manifold  ->  `transfer.Stylised`.   clean : see `transfer.onto_skeleton`"""
    moved = optimise(to_scale(take.features, take.leg, manifold.leg), take.contacts, [to_scale(e.features, e.leg, manifold.leg) for e in exemplars],
                     manifold, settings=settings, weights=weights, seed=seed)
    return onto_skeleton(take, to_scale(moved, manifold.leg, take.leg), clean=clean)
