"""The reference from one end to the other as functions of arrays alone: from motion to the numbers
that are learnt and back, training with its order and its chances given, the search of 2016, and
equation 12 over all pairs.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np

from ..holden2016 import network, rows, search
from ..holden2017 import losses, networks, objective, pairing, train
from ..motion import features as numbers, feet, ground, windows
from ..nn.adam import annealed
from ..torresani2006 import align, regress, synthesise
from .dealt import Dealt, draws_of, said, trained
from .functions_holden import T_NAMES
from .functions_transfer import manifold_of
from .specification import Array


def facing_direction(positions: Array) -> Array:
    """Where the body faces on the floor: across = (LeftArm - RightArm) + (LeftUpLeg - RightUpLeg),
    forward = across x up, on the floor a unit vector, smoothed over time by
    scipy.ndimage.gaussian_filter1d(..., 20, mode="nearest") and made a unit vector again.

    positions : (T, 21, 3), y up   ->  (T, 2): x and z
    """
    return numbers.facing(positions)


def floor_height(positions: Array) -> float:
    """The mean of the heights of the lowest foot joint, h[t], with the weights

        exp(-(h[t] - min h) / s),   s = 0.01 leg

    leg is the median over all frames of both legs of |UpLeg - Leg| + |Leg - Foot|.

    positions : (T, 21, 3), y up   ->  scalar
    """
    return numbers.floor_height(positions)


def foot_contacts(positions: Array, *, floor: float) -> Array:
    """1 where a foot joint is slow and low, leg as for `floor_height`:

        |p[t+1] - p[t]|^2 < 1.5 (leg / 80.07)^2   and   y[t] - floor < 11 leg / 80.07 (heels),
        3 leg / 80.07 (toes)

    positions : (T, 21, 3), y up, 60 frames a second   ->  (T, 4) whole numbers: heels are the
    joints Foot, in the order left heel, left toe, right heel, right toe. The last row is the one
    before it again; a single frame stands still.
    """
    return feet.foot_contacts(positions, floor).astype(int)


def planted_feet(positions: Array) -> tuple[Array, Array]:
    """Where each of the four foot joints rests on this body, and in which frames it is planted.

    1. Of each five frames (the clip's ends repeated) the position nearest to the other four, by the
       sum of distances, the middle one of equals; then gaussian_filter1d(..., 1, mode="nearest")
       over time. Speed: |np.gradient(path)|. leg as for `floor_height`.
    2. Still is below 0.5 * 0.0148 legs a frame. Of the heights of still frames (of all frames where
       fewer than 4, or 2 %, are still) the 5 % quantile q (the next lower of them), then the median
       of those within 0.0125 legs of q. A joint that rests 0.08 legs above the other foot's rests
       there instead.
    3. worst = the larger of speed / 0.0148 legs and height above rest / 0.0375 legs. A stance is a
       run with worst < 1.1 that goes below 1 / 1.1; runs at most 4 frames apart are one; then those
       of fewer than 4 frames are none, unless they touch an end of the clip.

    positions : (T, 21, 3), y up, 60 frames a second
    ->  heights (4,), whole numbers (T, 4): left heel (Foot), left toe, right heel, right toe
    """
    return ground.resting_heights(positions), ground.planted_feet(positions)[1].astype(int)


def ground_height(positions: Array) -> float:
    """The lower of the two heights at which the toes rest (`planted_feet`).

    positions : (T, 21, 3), y up, 60 frames a second   ->  scalar
    """
    return ground.planted_feet(positions)[0]


def motion_to_numbers(positions: Array, *, floor: float) -> tuple[Array, Array]:
    """Section 3.1: the 66 numbers of each frame. The root is x and z of the joint Hips, smoothed by
    scipy.ndimage.gaussian_filter1d(..., 3, mode="nearest"), at the floor's height; yaw = atan2(x,
    z) of `facing_direction`; Y(a) turns about y and takes (0, 0, 1) to (sin a, 0, cos a);

        p_j^local[t] = Y(-yaw[t]) (p_j[t] - root[t]),   v_r[t] = Y(-yaw[t+1]) (root[t+1] - root[t])
        turn[t] = yaw[t+1] - yaw[t], within half a turn

    The last row has the velocities of the row before, a single frame has none.

    positions : (T, 21, 3), y up, 60 frames a second;  floor : its height   ->  (T, 66), and
    (x, z, yaw) of the root in frame 0
    """
    found, start = numbers.encode(positions, floor)
    return found, np.array([start.x, start.z, start.yaw])


def numbers_to_motion(features: Array, start: Array) -> Array:
    """The way back:   yaw[t+1] = yaw[t] + turn[t],   root[t+1] = root[t] + Y(yaw[t+1]) v_r[t]

    features : (T, 66);  start : (4,) x, z and yaw of the root in frame 0, and its height, which is
    the floor's   ->  (T, 21, 3)
    """
    return numbers.decode(features, numbers.Start(*map(float, start)))


def motion_windows(features: Array, contacts: Array,
                   *, length: int | None = None, step: int | None = None) -> tuple[Array, Array]:
    """Windows that begin every `step` frames, and one more that ends with the clip where frames are
    left over. A clip shorter than a window is padded by its first and last frame, one more behind
    than before where they are odd; its last row and all of the padding get velocities of 0.

    features : (T, 66), contacts : (T, 4);  length, step : 240 and 120 frames unless given
    ->  (N, length, 66), (N, length, 4)
    """
    return windows.windows(features, contacts, **said(length=length, step=step))


def normaliser(features: Array, contacts: Array, *, form: str = "groups") -> tuple[Array, Array]:
    """Mean and deviation (of the population) of each of the 66 numbers; the velocities' mean is 0,
    their deviations are about their own.

    form "groups" : all positions have the root of their mean variance, likewise the two
    translational velocities; turning has its own deviation. "2016" : positions have the deviation
    of all numbers of 73 rows together (three zeros, the 66, the 4 contacts); the translational
    velocities 0.9 of that of both together; turning 0.9 of its own. What comes to no more than
    1e-12 of its largest number is replaced by the largest of the 66 deviations, or by 1. After
    that, in "2016", the twelve numbers of the foot joints are 0.9 of the other positions.

    features : (T, 66), T at least 2;  contacts : (T, 4), for "2016"   ->  (66,), (66,)
    """
    found = windows.fit_normaliser(features, "these", contacts=contacts, form=form)
    return found.mean, found.deviation


def project(X: Array, W0: Array, b0: Array) -> Array:
    """Projection onto the manifold, decode(encode(X)); where T is odd the last frame is doubled
    before and dropped after.   X : (N, C, T), W0 : (m, C, K), b0 : (m,)   ->  (N, C, T)"""
    return networks.project(X, {"W0": W0, "b0": b0})


def style_target(hidden: Array, *, lengths: tuple[int, ...], frames: int) -> Array:
    """The Gram matrix that an output of so many hidden frames should have, of several exemplars:

        frames * sum_e H_e H_e^T / sum_e T_e

    hidden : (m, sum of lengths), exemplars one after the other, lengths : T_e   ->  (m, m)
    """
    if sum(lengths) != hidden.shape[1]:
        raise ValueError(f"lengths: found {lengths}, {sum(lengths)} frames together, needed the "
                         f"{hidden.shape[1]} of hidden")
    return losses.style_target(np.split(hidden, np.cumsum(lengths)[:-1], axis=1), frames)


def initial_filters(uniform: Array) -> Array:
    """Filters before training, of uniform random numbers of [0, 1):

        (2 uniform - 1) sqrt(6 / ((inputs + outputs) width))

    uniform : (outputs, inputs, width)   ->  the same shape
    """
    rng: Any = Dealt(numbers=uniform.ravel())
    outputs, inputs, width = uniform.shape
    return networks.uniform_filters(rng, outputs, inputs, width, uniform.dtype)


def learning_rate(epoch: Array, *, rate: float, epochs: int) -> Array:
    """rate min(1, 2 (1 - (epoch - 1/2) / epochs)) in each epoch, of which the first is 1.

    epoch : (E,) whole numbers   ->  (E,)
    """
    return np.array([annealed(rate, int(e), epochs) for e in epoch])


def train_loss_network(W0: Array, b0: Array, *, X: Array, order: Array, batch: int,
                       rate: float, alpha: float = networks.SPARSE, dropout: float = 0.0,
                       kept: Array | None = None, chosen: Array | None = None) -> tuple[Array, ...]:
    """Training the loss network on equation 3 (means) by Adam (`learning_rate`, 0.9, 0.999, 1e-8).
    Epoch e visits the windows in the order order[e], `batch` at a time, the last batch as small as
    it comes; Adam counts its steps through all epochs.

    W0 : (m, C, K), b0 : (m,);  X : (N, C, T), T even;  order : (epochs, N) whole numbers;
    kept : (epochs, N, C, T) of 0 and 1, by epoch and number of the window; X kept / (1 - dropout)
    is encoded then, and X is what is wanted; without it nothing is dropped
    chosen : (epochs, N, m, T // 2) whole numbers, likewise, for random_depool1d
    ->  W0, b0, and the mean over the windows of each epoch of the loss, as the parameters were when
    it was computed
    """
    parts = [kept] if chosen is None else [kept, chosen.swapaxes(2, 3)]
    return trained(train.train_autoencoder(
        X, epochs=len(order), batch=batch, rate=rate, alpha=alpha, dropout=dropout,
        depooling="average" if chosen is None else "random", draws=draws_of(order, *parts),
        state=train.start_state({"W0": W0, "b0": b0})), W0.dtype)


def train_transformation_network(*arrays: Array, I: Array,
                                 gram: Array, contacts: Array, bones: Array, trajectory: Array,
                                 W0: Array, b0: Array, mean: Array, deviation: Array, order: Array,
                                 batch: int, rate: float, reading: str = "mean_squares",
                                 foot_velocity: Array | None = None) -> tuple[Array, ...]:
    """Training T on equation 10 (`total_loss`, the mean over a batch) against a loss network that
    stays; Adam, epochs and batches as in `train_loss_network`.

    W1 ... b3 : of T, as for `transform`;  I, contacts, bones, trajectory, W0, b0, mean, deviation,
    reading, foot_velocity : as for `total_loss`, of N windows, whose hidden units are encode(I);
    gram : (N, m, m);  order : (epochs, N) whole numbers
    ->  W1, b1, W2, b2, W3, b3, and each epoch's mean loss
    """
    names = tuple(map(str, range(len(I))))
    of_all: Any = pairing.TrainingSet(I, contacts, trajectory, dict(zip(names, gram)), names, bones)
    if foot_velocity is not None:                                # which no training set has
        every = objective.Batch(I, gram, contacts, bones, trajectory, foot_velocity=foot_velocity)
        of_all = SimpleNamespace(X=I, batch=every.part)
    return trained(train.train_style(
        of_all, manifold_of(W0, b0, mean, deviation), epochs=len(order), batch=batch, rate=rate,
        weights=objective.WEIGHTS[reading], draws=draws_of(order),
        state=train.start_state(dict(zip(T_NAMES.split(), arrays)))), I.dtype)


def initial_networks(uniform: Array, *, hidden: int, channels: int, features: int,
                     width: int) -> tuple[Array, ...]:
    """The networks before training, filters of one stream of uniform random numbers of [0, 1) as
    `initial_filters` makes them, biases 0: W0, W1, W2, W3 of 2017, then We, Wd of 2016.

    uniform : (U,);  T has channels, channels and features outputs; L has `hidden` units
    ->  W0, b0, W1, b1, W2, b2, W3, b3, We, be, Wd, bd
    """
    rng: Any = Dealt(numbers=uniform)
    size: dict[str, Any] = {"width": width, "dtype": uniform.dtype}
    made = networks.init_loss_network(rng, hidden=hidden, features=features, **size)
    T = networks.init_transformation_network(rng, channels=channels, features=features, **size)
    code = network.init_network(rng, hidden=hidden, numbers=features, **size)
    return (*made.values(), *T.values(), *code.values())


def initial_noise(uniform: Array) -> Array:
    """What the search of 2016 begins at:   (2 uniform - 1) sqrt(6 / (numbers + T))

    uniform : (numbers, T) of [0, 1)   ->  (1, numbers, T)
    """
    rng: Any = Dealt(numbers=uniform.ravel())
    return search.noise(rng, uniform.shape[1], uniform.shape[0])


def style_search(content: Array, style: Array, start: Array,
                 We: Array, be: Array, Wd: Array, bd: Array, *, mean: Array, deviation: Array,
                 amount: float = search.AMOUNT, iterations: int = search.ITERATIONS,
                 constraint_iterations: int = search.CONSTRAINT_ITERATIONS) -> tuple[Array, ...]:
    """The script of the 2016 code. L and L+ are encode_2016 and decode_2016 without dropout, on
    (rows - mean) / deviation; G = L(style) L(style)^T.

    1. H = L(start); `iterations` steps of Adam (rate 0.01, 0.9, 0.999, epsilon 1e-5) on H down
       search_loss_2016 with content L(content), gram G and amount.
    2. After style: L+(H) in units. The tail: the content's last seven rows, the two velocities
       times the mean length of both of that result over that of the content (where this is 0,
       times 1).
    3. H = L(L+(H)); `constraint_iterations` such steps of another Adam down (foot_loss_2016 +
       bone_loss_2016 + trajectory_loss_2016) / 3 of L+(H) in units, with the content's contacts
       and the tail's first three rows.
    4. Before the tail: L+(H) in units. The result: its last seven rows are the tail.

    content, style : (T, 73), (T_s, 73), both even, in units;  start : (1, 73, T) normalised noise
    We : (m, 73, K), be : (m,), Wd : (73, m, K), bd : (73,);  mean, deviation : (73,)
    ->  result, after style, before the tail, each (T, 73)
    """
    found = search.transfer(content, style, {"We": We, "be": be, "Wd": Wd, "bd": bd},
                            rows.Normaliser(mean, deviation), start=start, amount=amount,
                            iterations=iterations, constraint_iterations=constraint_iterations)
    return found.result, found.after_style, found.before_tail


def cluster_threshold(ssd: Array, *, count: int) -> float:
    """A threshold with which `content_clusters` finds so many contents: half-way between the
    longest link that is needed (0 for N contents) and the shortest that is not to be made; for one
    content twice the longest, plus 1. Where these two are equally long no threshold does, and it is
    that length.

    ssd : (N, N) symmetric, count : from 1 to N   ->  scalar
    """
    return align.threshold_for(ssd, count)


def best_pair(coefficients: Array, styles: Array, Z: Array, Y: Array, *, target: Array,
              kind: str, ridge: float, gamma: float | None = None) -> tuple[Array, ...]:
    """Equation 12 over all ordered pairs k, l that are not one:   arg min || e - f(z_kl(alpha)) ||,
    alpha in [-0.25, 1.25] found as in `best_alpha` (13 samples, to 1e-5), or the best sample where
    the search ends higher. z_kl(alpha) = c_k, c_l, e_k, e_l, alpha.

    coefficients : c (N, components), styles : e (N, 3) of the fragments;  Z, Y, ridge, gamma : of
    f, as for `predicted_style`;  kind : "linear ridge" or "kernel ridge";  target : (3,) e
    ->  k and l (2,), alpha, f(z) (3,), the error
    """
    chosen = {"lambda": ridge} if gamma is None else {"gamma": gamma, "lambda": ridge}
    model = regress.fit_with(kind, Z, Y, [chosen] * Y.shape[1], tolerance=1e-12)
    pairs = np.array([(i, j) for i in range(len(styles)) for j in range(len(styles)) if i != j])
    best = synthesise.rank(coefficients, styles, model, pairs, target)[0]
    return (np.array([best.i, best.j]), np.asarray(best.alpha), best.predicted,
            np.asarray(best.error))
