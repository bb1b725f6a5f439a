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
- several exemplars count as one long one, and contacts are not among the numbers;
- beyond both ends the clip goes on, instead of zeros (`stylised_features`).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..holden2017 import losses, networks as text
from ..holden2017.objective import (CONSTRAINTS, WEIGHTS, Batch, Weights, column, denormalise,
                                    term_losses, term_losses_backward)
from ..nn.adam import annealed
from ..nn.pool import even as even_frames
from ..holden2017.trained import Manifold
from ..motion.stylised import Stylised, onto_skeleton
from ..motion.body import MARGIN, Seen, Take, seen
from ..motion.features import FEATURES, VELOCITIES, bone_lengths
from . import search

# s by the normaliser's form, and the weights of the constraints for centimetres.
STYLE_SHARES = {"groups": 0.003, "2016": search.AMOUNT / (1 + search.AMOUNT)}
CONSTRAINT_WEIGHTS = replace(WEIGHTS["norm"], foot=0.001)


@dataclass(frozen=True)
class Settings:
    """What both searches do.

    style : s against c = 1 - s, that of STYLE_SHARES unless given;  start : "noise" or "content";
    iterations and first rate of Adam, of both searches.   Raises ValueError.
    """

    style: float | None = None
    start: str = "noise"
    iterations: int = 250
    rate: float = 0.1
    constraint_iterations: int = 100
    constraint_rate: float = 0.01

    def __post_init__(self) -> None:
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


def hidden_loss(H: np.ndarray, content: np.ndarray, gram: np.ndarray, *,
                style: float) -> np.ndarray:
    """The first search's loss.   H, content : (N, m, T // 2), gram : (N, m, m), style : s  ->  (N,)

    >>> H = np.ones((1, 2, 3))
    >>> hidden_loss(H, 0 * H, np.full((1, 2, 2), 3.0), style=0.25)     # the Gram matrix is met
    array([0.75])
    """
    return (losses.style_loss(gram, H, s=style, reading="mean_squares")
            + losses.content_loss(content, H, c=1 - style, reading="mean_squares"))


def hidden_loss_backward(dloss: np.ndarray, H: np.ndarray, content: np.ndarray, gram: np.ndarray,
                         *, style: float) -> np.ndarray:
    """The gradient of `hidden_loss`.   dloss : (N,)  ->  dH (N, m, T // 2)"""
    return (losses.style_loss_backward(dloss, gram, H, s=style, reading="mean_squares")[1]
            + losses.content_loss_backward(dloss, content, H, c=1 - style,
                                           reading="mean_squares")[1])


def decoded_loss(H: np.ndarray, target: Batch, params: Mapping[str, np.ndarray], mean: np.ndarray,
                 deviation: np.ndarray, weights: Weights = Weights()) -> np.ndarray:
    """The second search's loss, of the decoded motion.

    H : (N, m, T // 2);  target : Batch;  params : W0, b0;  mean, deviation : (66,)  ->  (N,)
    """
    motion = denormalise(text.decode(H, params), mean, deviation)
    return np.add.reduce([*term_losses(motion, target, CONSTRAINTS, weights).values()])


def decoded_loss_backward(dloss: np.ndarray, H: np.ndarray, target: Batch,
                          params: Mapping[str, np.ndarray], mean: np.ndarray,
                          deviation: np.ndarray, weights: Weights = Weights(),
                          networks: Any = text) -> np.ndarray:
    """The gradient of `decoded_loss`.   dloss : (N,)  ->  dH (N, m, T // 2)"""
    X = networks.decode(H, params)
    dmotion = term_losses_backward(dloss, denormalise(X, mean, deviation), target, CONSTRAINTS,
                                   weights)
    return networks.decode_backward_to_input(dmotion * column(deviation, X), H, params)


def minimise_annealed(H: np.ndarray, backward: Callable[[np.ndarray], np.ndarray], iterations: int,
                      rate: float) -> np.ndarray:
    """Adam on hidden units, its rate annealed like that of a training (`nn.adam.annealed`).

    backward : H ->  dH;  rate : the first   ->  H

    >>> minimise_annealed(np.zeros((1, 1, 1)), lambda H: 2 * (H - 1), 200, 0.1).round(3)
    array([[[1.]]])
    """
    return search.minimise(H, None, backward, iterations, epsilon=1e-8,
                           rate=lambda step: annealed(rate, step, iterations))


def optimise(features: np.ndarray, contacts: np.ndarray, exemplars: Sequence[np.ndarray],
             manifold: Manifold, *, bones: np.ndarray | None = None,
             settings: Settings = Settings(), weights: Weights | None = None, seed: int = 0,
             networks: Any = text) -> np.ndarray:
    """Content features in the style of the exemplars, all on the manifold's scale.

    features : (T, 66);  contacts : (T, 4);  exemplars : list of (T_e, 66);  bones : (20,) lengths
    to keep, the manifold's unless given;  weights : of the constraints, for the manifold's unit,
    CONSTRAINT_WEIGHTS unless given;  seed : of the noise;  networks : who computes encode, decode
    and its gradient, `fast.networks` say   ->  (T, 66).   Raises ValueError.
    """
    if not exemplars:
        raise ValueError("exemplars: found none, needed at least one clip in the style")
    params, normaliser = manifold.params, manifold.normaliser
    weights = weights or CONSTRAINT_WEIGHTS.fitted(manifold.leg)
    s = STYLE_SHARES[normaliser.form] if settings.style is None else settings.style
    even, planted = even_frames(features, axis=0), even_frames(contacts, axis=0)
    X = manifold.network_input(even)
    one = np.ones(1, X.dtype)
    content = networks.encode(X, params)
    gram = losses.style_target([networks.encode(manifold.network_input(pairs(e)), params)[0]
                                for e in exemplars], content.shape[2])[None]
    start = content
    if settings.start == "noise":
        noise = search.noise(np.random.default_rng([seed, 4]), X.shape[2], FEATURES)
        start = networks.encode(noise.astype(X.dtype), params)

    H = minimise_annealed(start, lambda H: hidden_loss_backward(one, H, content, gram, style=s),
                          settings.iterations, settings.rate)
    styled = networks.decode(H, params)
    path = walked_as(even[:, VELOCITIES], manifold.motion(styled)[:, VELOCITIES])
    target = Batch(X, None, planted.T[None].astype(X.dtype),
                   manifold.bones if bones is None else bones, path.T[None].astype(X.dtype))
    H = minimise_annealed(
        networks.encode(styled, params), lambda H: decoded_loss_backward(
            one, H, target, params, normaliser.mean, normaliser.deviation, weights, networks),
        settings.constraint_iterations, settings.constraint_rate)
    moved = manifold.motion(networks.decode(H, params))
    moved[:, VELOCITIES] = path
    return moved[:len(features)]


def walked_as(content: np.ndarray, result: np.ndarray) -> np.ndarray:
    """A root's velocities with the mean speed of another's; it turns as before.

    content, result : (T, 3), turn, forward, sideways  ->  (T, 3)

    >>> walked_as(np.array([[0.5, 3.0, 4.0]]), np.array([[9.0, 0.0, 10.0]]))
    array([[0.5, 6. , 8. ]])
    """
    speed, wanted = (float(np.linalg.norm(v[:, 1:], axis=1).mean()) for v in (content, result))
    return content * np.array([1.0, *[wanted / speed if speed > 0 else 1.0] * 2])


def pairs(features: np.ndarray) -> np.ndarray:
    """An even number of frames, for the pooling.   (T, 66)  ->  (T - T % 2, 66), or one frame twice

    >>> pairs(np.zeros((5, 66))).shape, pairs(np.zeros((1, 66))).shape
    ((4, 66), (2, 66))
    """
    T = len(features)
    return features[:T - T % 2] if T > 1 else np.repeat(features, 2, axis=0)


def transfer(take: Take, exemplars: Sequence[Take], manifold: Manifold, *, clean: bool = True,
             settings: Settings = Settings(), weights: Weights | None = None, seed: int = 0,
             networks: Any = text, **back: Any) -> Stylised:
    """Stylise a take by optimisation, on the body that the loss network knows and back.

    take : Take;  exemplars : Takes in the style, on any body;  clean, back (strength, only, fps) :
    see `motion.stylised.onto_skeleton`
    ->  Stylised
    """
    there = seen(take, manifold.body)
    moved = stylised_features(there, take.contacts, [seen(e, manifold.body).features
                                                     for e in exemplars],
                              manifold, settings, weights, seed, networks)
    return onto_skeleton(take, there, moved, clean=clean, **back)


def stylised_features(there: Seen, contacts: np.ndarray, exemplars: Sequence[np.ndarray],
                      manifold: Manifold, settings: Settings = Settings(),
                      weights: Weights | None = None, seed: int = 0,
                      networks: Any = text) -> np.ndarray:
    """What `optimise` makes of a take, which goes on beyond both its ends (`motion.extend`); no
    foot is held there. The 2016 code sees zeros.

    there : the take on the manifold's body;  contacts : (T, 4);  exemplars : list of (T_e, 66) on
    that body   ->  (T, 66)
    """
    moved = optimise(there.around, np.pad(contacts, ((MARGIN, MARGIN), (0, 0))),
                     exemplars, manifold, bones=bone_lengths(there.positions), settings=settings,
                     weights=weights, seed=seed, networks=networks)
    return moved[MARGIN:-MARGIN]
