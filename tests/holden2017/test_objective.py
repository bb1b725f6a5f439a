"""Equation 10 as a whole, through T and the loss network, by finite differences; and training that
learns.
"""

from dataclasses import replace

import numpy as np
import pytest

from refimpl import nn
from refimpl.fast.shards import sharded
from refimpl.holden2017 import networks, objective, train
from refimpl.holden2017.pairing import TrainingSet, PairingError, pair_contents
from refimpl.holden2017.losses import READINGS
from refimpl.holden2017.objective import EQUATION_10, WEIGHTS, Batch, Weights
from refimpl.fast.gradients import StyleStep
from refimpl.motion.joints import BONES


# of a larger array a sample of so many elements, and all of them along a line
ONE_BY_ONE = 60


def problem(seed=3, frames=8, hidden=6, reading="norm"):
    """A small but complete case: T, the loss network, a target with every term, all in float64."""
    rng = np.random.default_rng(seed)
    T = networks.init_transformation_network(rng, channels=4, width=3, dtype=float)
    L = networks.init_loss_network(rng, hidden=hidden, width=5, dtype=float)
    I = rng.normal(size=(2, 66, frames))
    mean, deviation = rng.normal(size=66) * 3, rng.uniform(0.5, 4, 66)
    gram = np.stack([g @ g.T for g in rng.normal(size=(2, hidden, hidden))])
    target = Batch(I, gram, (rng.random((2, 4, frames)) < 0.6).astype(float),
                   rng.uniform(1, 4, len(BONES)), rng.normal(size=(2, 3, frames)),
                   networks.encode(I, L), foot_velocity=rng.normal(size=(2, 4, 3, frames - 1)))
    weights = Weights(content=1.3, style=0.4, foot=0.02, bone=0.03, trajectory=0.05, turn=7.0,
                      reading=reading)
    return T, target, L, mean, deviation, weights


@pytest.mark.parametrize("reading", READINGS)
def test_gradient_of_the_whole_loss_through_the_output(reading):
    _, target, L, mean, deviation, weights = problem(reading=reading)
    nn.check_gradient(lambda O: sum(objective.motion_losses(O, target, L, mean, deviation,
                                                            weights).values()), lambda d,
                      O: objective.motion_losses_backward(d, O, target, L, mean, deviation,
                                                          weights), target.I * 0.9,
                      elements=ONE_BY_ONE)


@pytest.mark.parametrize("seed, reading", list(enumerate(READINGS, start=1)))
def test_gradient_of_the_whole_loss_through_T(seed, reading):
    T, *rest = problem(seed, reading=reading)
    names = tuple(T)

    def f(*arrays):
        return np.asarray(objective.total_loss(dict(zip(names, arrays)), *rest)[0])

    def backward(d, *arrays):
        gradients = objective.total_loss_backward(float(d), dict(zip(names, arrays)), *rest)
        return tuple(gradients[name] for name in names)

    nn.check_gradient(f, backward, *T.values(), names=names, seed=seed, elements=ONE_BY_ONE)


def test_weights_follow_the_unit():
    cm, metres = Weights().fitted(80.0), Weights().fitted(0.8)
    assert cm == Weights()
    # squared metres are 1e-4 of squared centimetres
    np.testing.assert_allclose(metres.bone, 1e4 * cm.bone)
    np.testing.assert_allclose(metres.turn * metres.trajectory, cm.turn * cm.trajectory)


def test_constraints_of_means_follow_the_number_of_units():
    narrow = Weights().fitted(80.0, 64)
    assert ((narrow.foot, narrow.bone, narrow.trajectory)
            == (4 * Weights().foot, 4 * Weights().bone, 4 * Weights().trajectory))
    assert ((narrow.style, narrow.content, narrow.turn) == (Weights().style, Weights().content,
                                                            Weights().turn))
    for reading in ("norm", "sum_squares"):
        assert WEIGHTS[reading].fitted(80.0, 64) == WEIGHTS[reading]


def test_the_printed_constants_are_the_defaults():
    """c = 1.0 and s = 0.01, with the bars read as means of squares."""
    assert (Weights().content, Weights().style, Weights().reading) == (1.0, 0.01, "mean_squares")
    assert (set(WEIGHTS) == set(READINGS)
            and all(weights.reading == reading for reading, weights in WEIGHTS.items()))


def test_constraints_keep_their_share_from_reading_to_reading():
    """A sum of squares is m T / 2 = 30,720 times its mean, so are its constraints; s differs, which
    weighs squares of m^2 elements.
    """
    means, sums = WEIGHTS["mean_squares"], WEIGHTS["sum_squares"]
    for name in ("foot", "bone", "trajectory"):
        assert getattr(sums, name) / getattr(means, name) == pytest.approx(256 * 240 / 2, rel=0.05)


def test_every_term_counts():
    T, target, L, mean, deviation, weights = problem()
    terms = objective.total_loss(T, target, L, mean, deviation, weights)[1]
    assert (tuple(terms) == tuple(term.name for term in EQUATION_10)
            and all(value > 0 for value in terms.values()))


def lesson_and_manifold():
    from refimpl.holden2017.trained import Manifold
    from refimpl.motion.windows import Normaliser
    _, target, L, mean, deviation, _ = problem()
    lesson = TrainingSet(target.I, target.contacts, target.trajectory, {"walk": target.gram[0]},
                         ("walk", "walk"), target.bones)
    return lesson, Manifold(L, Normaliser(mean, deviation, "made up"), 80.0, target.bones)


def test_training_lowers_the_loss_and_repeats_to_the_last_bit():
    lesson, manifold = lesson_and_manifold()
    settings = dict(epochs=40, channels=4, width=3, seed=5)
    runs = [list(train.train_style(lesson, manifold, **settings)) for _ in range(2)]
    first, last = runs[0][0][0], runs[0][-1][0]
    assert last.losses["loss"] < 0.8 * first.losses["loss"] and last.epoch == 40
    for name, value in runs[0][-1][1].params.items():
        np.testing.assert_array_equal(value, runs[1][-1][1].params[name])


def test_training_goes_on_where_it_stopped():
    lesson, manifold = lesson_and_manifold()
    settings = dict(epochs=6, channels=4, width=3)
    *_, (_, whole) = train.train_style(lesson, manifold, **settings)
    states = [state for _, state in train.train_style(lesson, manifold, **settings)]
    *_, (_, resumed) = train.train_style(lesson, manifold, state=states[2], **settings)
    for name in whole.params:
        np.testing.assert_array_equal(whole.params[name], resumed.params[name])


@pytest.mark.parametrize("depooling", train.DEPOOLING)
def test_autoencoder_learns_a_simple_motion(depooling):
    t = np.arange(48)
    X = np.stack([np.sin(0.3 * t + phase)[None] * np.linspace(-1, 1, 66)[:, None]
                  for phase in range(8)])
    records = [record for record,
               _ in train.train_autoencoder(X, epochs=30, hidden=16, width=5, dropout=0.0, batch=4,
                                            rate=3e-3, depooling=depooling)]
    assert records[-1].losses["loss"] < 0.2 * records[0].losses["loss"]


def test_chance_is_seeded_and_resumed():
    X = np.random.default_rng(0).normal(size=(6, 66, 24)).astype(np.float32)
    settings = dict(epochs=4, hidden=8, width=5, batch=4, seed=3)
    states = [state for _, state in train.train_autoencoder(X, **settings)]
    again = [state for _, state in train.train_autoencoder(X, state=states[1], **settings)]
    parts = [state for _, state in train.train_autoencoder(X,
                                                           gradients=sharded(
                                                               networks.autoencoder_gradients, 2),
                                                           **settings)]
    other = [state for _, state in train.train_autoencoder(X, **{**settings, "seed": 4})]
    for name, value in states[-1].params.items():
        np.testing.assert_array_equal(again[-1].params[name], value)
        # the choices do not depend on the parts
        np.testing.assert_allclose(parts[-1].params[name], value, atol=1e-5)
        assert not np.array_equal(other[-1].params[name], value)
    with pytest.raises(ValueError, match="depooling: found 'max', needed random or average"):
        next(train.train_autoencoder(X, depooling="max", **settings))


def test_learning_by_chance_makes_smooth_filters():
    """Twelve slow waves: filters that learn with halves carry wiggles which undo the steps, those
    that learn by chance cannot.
    """
    t = np.arange(60)
    rng = np.random.default_rng(1)
    X = np.stack([np.sin(0.2 * t + phase) * rng.normal(size=(66, 1))
                  for phase in np.linspace(0, 6, 12)])
    fast = {}
    for depooling in train.DEPOOLING:
        *_, (_, state) = train.train_autoencoder(X, epochs=60, hidden=16, width=9, dropout=0.0,
                                                 batch=4, rate=3e-3, depooling=depooling)
        moved = networks.project(X, state.params) - X
        fast[depooling] = np.square(np.diff(moved, n=3, axis=2)).mean()
    assert fast["random"] < 0.25 * fast["average"]


def test_non_finite_training_stops_and_names_the_batch():
    lesson, manifold = lesson_and_manifold()
    lesson.X[1, 0, 0] = np.nan
    with pytest.raises(train.TrainingError,
                       match="epoch 1, batch 1 of 1"), np.errstate(all="ignore"):
        next(train.train_style(lesson, manifold, epochs=1, channels=4, width=3))


def test_contents_are_paired_by_name_then_by_its_beginning():
    assert pair_contents(["walk", "walk-turn-left", "run"],
                         {"walk": 1, "run": 1}) == {"run": "run", "walk": "walk",
                                                    "walk-turn-left": "walk"}
    assert pair_contents(["walk-turn-left"],
                         {"walk": 1, "walk-turn-left": 1}) == {"walk-turn-left": "walk-turn-left"}
    with pytest.raises(PairingError, match="'jump'"):
        pair_contents(["jump"], {"walk": 1})


def acceleration(motion, batch, weights):
    """|| p'' - p'' of the input ||^2: a sixth loss that nobody here knows, with a constant of the
    batch.
    """
    return nn.sum_squares(np.diff(motion - batch.motion, n=2, axis=2))


def acceleration_backward(dloss, motion, batch, weights):
    d = nn.sum_squares_backward(dloss, np.diff(motion - batch.motion, n=2, axis=2))
    dmotion = np.zeros_like(motion)
    for shift, factor in enumerate((1, -2, 1)):
        dmotion[:, :, shift:shift + d.shape[2]] += factor * d
    return dmotion


def energy(H, batch, weights):
    return nn.mean_squares(H - batch.hidden) * 2


def energy_backward(dloss, H, batch, weights):
    return nn.mean_squares_backward(2 * dloss, H - batch.hidden)


MINE = (objective.Term("acceleration", "motion", acceleration, acceleration_backward, weight=0.003,
                       power=-2), objective.Term("energy", "hidden", energy, energy_backward,
                                                 weight=0.7))


@pytest.mark.parametrize("order", [lambda terms: terms, lambda terms: terms[::-1]])
def test_terms_from_outside_are_summed_named_and_trained_with(order):
    """No file of the package changes for them: definition, gradient, fast step and training walk
    the list.
    """
    terms = tuple(order([*EQUATION_10, *MINE]))
    T, batch, L, mean, deviation, weights = problem(4, frames=8)
    names = tuple(T)
    nn.check_gradient(lambda *a: np.asarray(objective.total_loss(dict(zip(names, a)), batch, L,
                                                                 mean, deviation, weights,
                                                                 terms=terms)[0]), lambda d,
                      *a: tuple(objective.total_loss_backward(float(d), dict(zip(names, a)), batch,
                                                              L, mean, deviation, weights,
                                                              terms=terms)[n] for n in names),
                      *T.values(), names=names, elements=ONE_BY_ONE)
    found = objective.total_loss(T, batch, L, mean, deviation, weights, terms=terms)[1]
    assert (tuple(found) == tuple(term.name for term in terms) and found["acceleration"] > 0
            and found["energy"] > 0)
    fast, gradients = StyleStep(2, 8, T, L, mean, deviation, weights, terms)(T, batch)
    assert list(fast) == list(found)
    needed = objective.total_loss_backward(1.0, T, batch, L, mean, deviation, weights, terms=terms)
    for name, value in found.items():
        np.testing.assert_allclose(fast[name], value, rtol=1e-12)
    for name in names:
        np.testing.assert_allclose(gradients[name], needed[name],
                                   atol=1e-12 * np.abs(needed[name]).max())
    lesson, manifold = lesson_and_manifold()
    runs = [list(train.train_style(lesson, manifold, epochs=2, channels=4, width=3, terms=chosen))
            for chosen in (terms, EQUATION_10)]
    assert set(runs[0][-1][0].losses) == {"loss", *(term.name for term in terms)}
    assert not np.array_equal(runs[0][-1][1].params["W1"], runs[1][-1][1].params["W1"])


def test_a_term_weighed_by_its_own_weight_and_another_of_a_known_name():
    """The fast step knows content and style by what they compute, not by their names."""
    T, batch, L, mean, deviation, weights = problem(6)
    heavier = tuple(replace(term, weight=3.0) if term.name == "content" else term
                    for term in EQUATION_10)
    impostor = tuple(replace(MINE[1], name="style") if term.name == "style" else term
                     for term in EQUATION_10)
    for terms in (heavier, impostor):
        found = objective.total_loss(T, batch, L, mean, deviation, weights, terms=terms)[1]
        fast, gradients = StyleStep(2, 8, T, L, mean, deviation, weights, terms)(T, batch)
        needed = objective.total_loss_backward(1.0, T, batch, L, mean, deviation, weights,
                                               terms=terms)
        for name, value in found.items():
            np.testing.assert_allclose(fast[name], value, rtol=1e-12)
        for name in needed:
            np.testing.assert_allclose(gradients[name], needed[name],
                                       atol=1e-12 * np.abs(needed[name]).max())


def test_a_sum_of_some_terms_alone():
    T, batch, L, mean, deviation, weights = problem(5)
    alone = objective.total_loss(T, batch, L, mean, deviation, weights, terms=(objective.BONE,))
    assert (list(alone[1]) == ["bone"]
            and alone[0] == objective.total_loss(T, batch, L, mean, deviation, weights)[1]["bone"])
