"""The predecessor: its two losses by finite differences, its searches on the embedded motion."""

from dataclasses import replace

import numpy as np
import pytest

from refimpl import nn
from refimpl.holden2016 import own
from refimpl.holden2016.own import Settings
from refimpl.experiments import measures as measure
from refimpl.holden2017 import networks, objective
from refimpl.holden2017.trained import Manifold
from refimpl.nn.adam import annealed
from refimpl.motion.features import VELOCITIES, bone_lengths
from refimpl.motion.joints import BONES
from refimpl.motion.windows import fit_normaliser
from refimpl.embedded.walkers import make_clip
from refimpl.motion.body import make_take, seen


def problem(seed):
    rng = np.random.default_rng(seed)
    L = networks.init_loss_network(rng, hidden=6, width=5, dtype=float)
    H = rng.normal(size=(2, 6, 4))
    gram = np.stack([g @ g.T for g in rng.normal(size=(2, 6, 6))])
    target = objective.Batch(None, None, (rng.random((2, 4, 8)) < 0.6).astype(float),
                             rng.uniform(1, 4, len(BONES)), rng.normal(size=(2, 3, 8)))
    return (H, rng.normal(size=H.shape), gram, target, L, rng.normal(size=66) * 3,
            rng.uniform(0.5, 4, 66))


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("s", [0.0, 0.1, 0.7, 1.0])
def test_gradient_of_gram_and_content(s, seed):
    H, content, gram, *_ = problem(seed)
    nn.check_gradient(lambda H: own.hidden_loss(H, content, gram, style=s), lambda d,
                      H: own.hidden_loss_backward(d, H, content, gram, style=s), H, names=["H"],
                      seed=seed)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_gradient_of_the_decoded_constraints(seed):
    H, _, _, target, L, mean, deviation = problem(seed)
    weights = objective.Weights(foot=0.02, bone=0.03, trajectory=0.05, turn=7.0)
    nn.check_gradient(lambda H: own.decoded_loss(H, target, L, mean, deviation, weights), lambda d,
                      H: own.decoded_loss_backward(d, H, target, L, mean, deviation, weights), H,
                      names=["H"], seed=seed)


def test_the_losses_are_those_of_the_equations():
    H, content, gram, target, L, mean, deviation = problem(5)
    np.testing.assert_allclose(own.hidden_loss(H, content, gram, style=0.3),
                               [0.3 * np.mean((h @ h.T - g) ** 2) + 0.7 * np.mean((h - c) ** 2)
                                for h, g, c in zip(H, gram, content)])
    motion = networks.decode(H, L) * deviation[:, None] + mean[:, None]
    wanted = sum(objective.term_losses(motion, target, objective.CONSTRAINTS,
                                       objective.Weights()).values())
    np.testing.assert_allclose(own.decoded_loss(H, target, L, mean, deviation), wanted)


def test_adam_takes_the_steps_of_algorithm_1():
    H, content, gram, *_ = problem(6)

    def backward(H):
        return own.hidden_loss_backward(np.ones(2), H, content, gram, style=0.2)
    params, state = {"H": H}, nn.adam_start({"H": H})
    for step in range(1, 8):
        params, state = nn.adam_step(params, {"H": backward(params["H"])}, state,
                                     rate=annealed(0.03, step, 7))
    np.testing.assert_array_equal(own.minimise_annealed(H, backward, 7, 0.03), params["H"])
    np.testing.assert_array_equal(H, problem(6)[0])


def test_the_path_is_walked_with_the_results_mean_speed():
    rng = np.random.default_rng(7)
    content, result = rng.normal(size=(2, 50, 3))
    path = own.walked_as(content, result)
    np.testing.assert_array_equal(path[:, 0], content[:, 0])
    np.testing.assert_allclose(np.linalg.norm(path[:, 1:], axis=1).mean(),
                               np.linalg.norm(result[:, 1:], axis=1).mean())
    np.testing.assert_allclose(path[:, 1] * content[:, 2], path[:, 2] * content[:, 1])
    still = content * [1, 0, 0]
    np.testing.assert_array_equal(own.walked_as(still, result), still)


@pytest.fixture(scope="module")
def world():
    """A content, a style, and a loss network that passes motion through: two filters of one tap for
    each of the 66 numbers, one up and one down.
    """
    content, style = (make_take(make_clip("walk", name, seconds=2.0).clip)
                      for name in ("normal", "zombie"))
    normaliser = fit_normaliser(np.concatenate([content.features, style.features]), "test")
    W0 = np.zeros((132, 66, 25))
    W0[np.arange(66), np.arange(66), 12], W0[np.arange(66) + 66, np.arange(66), 12] = 1.0, -1.0
    return (content, style, Manifold({"W0": W0, "b0": np.zeros(132)}, normaliser, content.leg,
                                     bone_lengths(content.positions)))


def test_a_walk_takes_on_the_style_and_keeps_its_path(world):
    content, style, manifold = world
    odd, planted, exemplars = content.features[:-1], content.contacts[:-1], [style.features]
    moved = own.optimise(odd, planted, exemplars, manifold)
    assert moved.shape == odd.shape
    assert (measure.style_distance(moved, exemplars, manifold)
            < 0.6 * measure.style_distance(odd, exemplars, manifold))
    ratio = (np.linalg.norm(moved[:, VELOCITIES][:, 1:],
                            axis=1) / np.linalg.norm(odd[:, VELOCITIES][:, 1:], axis=1))
    np.testing.assert_allclose(ratio, ratio[0])
    np.testing.assert_array_equal(moved, own.optimise(odd, planted, exemplars, manifold))
    assert not np.array_equal(moved, own.optimise(odd, planted, exemplars, manifold, seed=1))
    from_content = [own.optimise(odd, planted, exemplars, manifold,
                                 settings=Settings(start="content"), seed=seed) for seed in (0, 1)]
    np.testing.assert_array_equal(*from_content)
    assert not np.array_equal(moved, from_content[0])


def test_the_second_search_serves_the_constraints(world):
    content, style, manifold = world

    def left(iterations):
        moved = own.optimise(content.features, content.contacts, [style.features], manifold,
                             settings=Settings(style=0.01, constraint_iterations=iterations,
                                               constraint_rate=0.02))
        motion = moved.T[None]
        target = objective.Batch(None, None, content.contacts.T[None].astype(float), manifold.bones,
                                 motion[:, VELOCITIES])
        return sum(objective.term_losses(motion, target, objective.CONSTRAINTS,
                                         objective.Weights()).values())[0]
    assert left(100) < 0.5 * left(0)


def test_a_take_comes_back_on_its_own_skeleton_with_planted_feet(world):
    content, style, manifold = world
    made = own.transfer(content, [style], manifold,
                        settings=Settings(style=0.001, iterations=30, constraint_iterations=10))
    assert [j.name for j in made.clip.joints] == [j.name for j in content.clip.joints]
    np.testing.assert_allclose(bone_lengths(made.positions), bone_lengths(content.positions),
                               rtol=1e-9)


def test_the_joints_hardly_know_where_a_clip_was_cut(world):
    _, style, manifold = world
    clip = make_clip("walk", "normal", seconds=4.0).clip
    takes = [make_take(clip), make_take(replace(clip, values=clip.values[40:]))]
    few = Settings(style=0.001, start="content", iterations=40, constraint_iterations=20)
    made = {True: [own.stylised_features(seen(t), t.contacts, [style.features], manifold, few)
                   for t in takes],
            False: [own.optimise(t.features, t.contacts, [style.features], manifold,
                                 bones=bone_lengths(t.positions), settings=few) for t in takes]}
    apart = {goes_on: np.abs(whole[40:, :63] - cut[:, :63])[:8].mean()
             for goes_on, (whole, cut) in made.items()}
    assert apart[True] < 0.6 * apart[False]


@pytest.mark.parametrize("wrong, message", [
    ({"style": 1.5}, "style: found 1.5, needed a share from 0 to 1"),
    ({"iterations": -1}, "iterations: found -1, needed a whole number"),
    ({"constraint_iterations": 1.5}, "constraint_iterations: found 1.5"),
    ({"rate": 0.0}, "rate: found 0.0, needed a positive number"),
    ({"start": "zero"}, "start: found 'zero', needed noise or content"),
    ({"constraint_rate": np.nan}, "constraint_rate: found nan")])
def test_settings_that_cannot_be_are_named(wrong, message):
    with pytest.raises(ValueError, match=message):
        Settings(**wrong)


def test_no_exemplar_is_named(world):
    content, _, manifold = world
    with pytest.raises(ValueError, match="exemplars: found none"):
        own.optimise(content.features, content.contacts, [], manifold)
