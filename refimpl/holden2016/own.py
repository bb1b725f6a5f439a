r"""The system of 2016 in this package's own form, on the 66 numbers and any loss network of 2017.

    H = argmin  s mean_squares(Gram(H) - G) + c mean_squares(H - L(C)),       s + c = 1
    H = argmin  foot + bone + trajectory of  L+(H) deviation + mean,          begun at L(L+(H))

The path of the second is the content's, walked as fast as the result of the first search walks:
v_r' = v_r(C) mean |v_r(L+(H))| / mean |v_r(C)|.

From the 2016 code (`search`) it has the noise, the second encoding, the means of squares and the
numbers of steps. Its own are:

- G is the style's Gram matrix scaled to the content's frames (`losses.style_target`): the code asks
  for half the energy of a style window of half its length, and damps the motion;
- s = 0.003, not 0.1 / 1.1: the style term grows with the fourth power of the hidden units, the
  content term with the second, and this package's usual normaliser makes them 2.4 times larger;
  0.003 was found by trial. With the 2016 normaliser s is the code's;
- Adam's rate is 0.1 and falls to 0 in the second half of the steps. With the code's 0.01 a unit
  moves by some 2.5 in 250 steps while gradients keep their size, less than units of this size have
  to: begun at noise, that leaves 0.82 of the style distance, this 0.16;
- the constraints are the sums of equations 7 to 9, in which a foot weighs a tenth of what it does
  in training by norms: with that the legs shake, with this feet slide little more than the
  content's do (15 against 12 cm/s), and `foot_ik` can lock them;
- several exemplars count as one long one, and contacts are not among the numbers.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..holden2017 import losses, networks as text
from ..holden2017.objective import (CONSTRAINTS, WEIGHTS as TRAINING, Batch, Weights, column,
                                    denormalise, term_losses, term_losses_backward)
from ..holden2017.train import annealed
from ..holden2017.transfer import onto_skeleton
from ..motion.body import to_scale
from ..motion.features import FEATURES, VELOCITIES, bone_lengths
from . import search

STYLE = {"groups": 0.003, "2016": search.AMOUNT / (1 + search.AMOUNT)}          # s by the normaliser's form
# of the constraints, for centimetres
WEIGHTS = replace(TRAINING["norm"], foot=0.001)


@dataclass(frozen=True)
class Settings:
    """style : s against c = 1 - s, that of STYLE unless given;  start : "noise" or "content";
    iterations and first rate of Adam, of both searches.   Raises ValueError.
    """

    style: float | None = None
    start: str = "noise"
    iterations: int = 250
    rate: float = 0.1
    constraint_iterations: int = 100
    constraint_rate: float = 0.01

    def __post_init__(self):
        if self.style is not None and not 0 <= self.style <= 1:
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
    """The first search's loss.   H, content : (N, m, T // 2), gram : (N, m, m), style : s  ->  (N,)
    """
    return (losses.style_loss(gram, H, s=style, reading="mean_squares")
            + losses.content_loss(content, H, c=1 - style, reading="mean_squares"))


def hidden_loss_backward(dloss, H, content, gram, *, style):
    """dloss : (N,)  ->  dH (N, m, T // 2)"""
    return (
        losses.style_loss_backward(dloss, gram, H, s=style, reading="mean_squares")[1]
        + losses.content_loss_backward(dloss, content, H, c=1 - style, reading="mean_squares")[1])


def decoded_loss(H, target, params, mean, deviation, weights=Weights()):
    """The second search's loss, of the decoded motion.
    H : (N, m, T // 2), target : Batch, params : W0, b0  ->  (N,)
    """
    return sum(
        term_losses(denormalise(text.decode(H, params), mean, deviation), target, CONSTRAINTS,
                    weights).values())


def decoded_loss_backward(dloss, H, target, params, mean, deviation, weights=Weights(),
                          networks=text):
    """dloss : (N,)  ->  dH (N, m, T // 2)"""
    X = networks.decode(H, params)
    dmotion = term_losses_backward(dloss, denormalise(X, mean, deviation), target, CONSTRAINTS,
                                   weights)
    return networks.decode_backward_to_input(dmotion * column(deviation, X), H, params)


def minimise(H, backward, iterations, rate):
    """Adam on hidden units, its rate annealed like that of a training (`train.annealed`).
    backward : H ->  dH   ->  H
    """
    return search.minimise(H, None, backward, iterations, epsilon=1e-8,
                           rate=lambda step: annealed(rate, step, iterations))


def optimise(features, contacts, exemplars, manifold, *, bones=None, settings=Settings(),
             weights=None, seed=0, networks=text):
    """Content features in the style of the exemplars, all on the manifold's scale.

    features : (T, 66);  contacts : (T, 4);  exemplars : list of (T_e, 66);  bones : (20,) lengths
    to keep, the manifold's unless given;  weights : of the constraints, for the manifold's unit,
    WEIGHTS unless given;  seed : of the noise;  networks : who computes encode, decode and its
    gradient, `fast.networks` say   ->  (T, 66).   Raises ValueError.
    """
    if not exemplars:
        raise ValueError("exemplars: found none, needed at least one clip in the style")
    params, normaliser = manifold.params, manifold.normaliser
    weights = weights or WEIGHTS.fitted(manifold.leg)
    s = STYLE[normaliser.form] if settings.style is None else settings.style
    even, planted = search.even(features), search.even(contacts)
    X = manifold.network_input(even)
    one = np.ones(1, X.dtype)
    content = networks.encode(X, params)
    gram = losses.style_target(
        [networks.encode(manifold.network_input(pairs(e)), params)[0] for e in exemplars],
        content.shape[2])[None]
    start = content
    if settings.start == "noise":
        start = networks.encode(
            search.noise(np.random.default_rng([seed, 4]), X.shape[2], FEATURES).astype(X.dtype), params)

    H = minimise(start, lambda H: hidden_loss_backward(one, H, content, gram, style=s),
                 settings.iterations, settings.rate)
    styled = networks.decode(H, params)
    path = walked_as(even[:, VELOCITIES], manifold.motion(styled)[:, VELOCITIES])
    target = Batch(X, None, planted.T[None].astype(X.dtype),
                   manifold.bones if bones is None else bones, path.T[None].astype(X.dtype))
    H = minimise(
        networks.encode(styled, params), lambda H: decoded_loss_backward(
            one, H, target, params, normaliser.mean, normaliser.deviation, weights, networks),
        settings.constraint_iterations, settings.constraint_rate)
    moved = manifold.motion(networks.decode(H, params))
    moved[:, VELOCITIES] = path
    return moved[:len(features)]


def walked_as(content, result):
    """A root's velocities with the mean speed of another's; it turns as before.
    (T, 3), (T, 3): turn, forward, sideways  ->  (T, 3)
    """
    speed, wanted = (float(np.linalg.norm(v[:, 1:], axis=1).mean()) for v in (content, result))
    return content * np.array([1.0, *[wanted / speed if speed > 0 else 1.0] * 2])


def pairs(features):
    """An even number of frames, for the pooling.   (T, 66)  ->  (T - T % 2, 66), or one frame twice
    """
    return features[:len(features)
                    - len(features) % 2] if len(features) > 1 else np.repeat(features, 2, axis=0)


def transfer(take, exemplars, manifold, *, clean=True, settings=Settings(), weights=None, seed=0,
             networks=text):
    """Stylise a take by optimisation; its bones keep their own lengths.

    Take, list of Take in the style, Manifold;  clean : see `transfer.onto_skeleton`
    ->  `transfer.Stylised`
    """
    size = manifold.leg / take.leg
    moved = optimise(to_scale(take.features, take.leg, manifold.leg), take.contacts,
                     [to_scale(e.features, e.leg, manifold.leg)
                      for e in exemplars], manifold, bones=bone_lengths(take.positions) * size,
                     settings=settings, weights=weights, seed=seed, networks=networks)
    return onto_skeleton(take, to_scale(moved, manifold.leg, take.leg), clean=clean)
