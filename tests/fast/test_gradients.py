"""The fast forms are the definitions: half-resolution decoder, stylist, shared training steps,
parts of a batch by any executor.
"""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
import pickle
import tracemalloc

from hypothesis import given, strategies as st
import numpy as np
import pytest

from refimpl.holden2017 import networks, objective, train
from refimpl.fast.decoder import half_filters, half_filters_backward
from refimpl.holden2017.pairing import TrainingSet
from refimpl.holden2017.losses import READINGS
from refimpl.holden2017.trained import Manifold
from refimpl.fast.autoencoder import AutoencoderStep
from refimpl.fast.gradients import StyleStep, style_gradients
from refimpl.fast.autoencoder import autoencoder_gradients
from refimpl.fast.shards import sharded
from refimpl.fast.stylist import Stylist
from refimpl.holden2017.objective import EQUATION_10, Batch, Weights
from refimpl.motion.joints import BONES
from refimpl.motion.windows import Normaliser


def made(seed, *, hidden=10, channels=6, width=9, T_width=None, dtype=float):
    """Both networks, with biases that are not 0."""
    rng = np.random.default_rng(seed)
    T = networks.init_transformation_network(rng, channels=channels, width=T_width or width,
                                             dtype=dtype)
    L = networks.init_loss_network(rng, hidden=hidden, width=width, dtype=dtype)
    for params in (T, L):
        for name in params:
            if name[0] == "b":
                params[name] = rng.normal(size=params[name].shape).astype(dtype) * dtype(0.1)
    return rng, T, L


def close(found, needed, precision=1e-12):
    assert found.shape == needed.shape and found.dtype == needed.dtype
    assert (np.abs(found - needed).max(initial=0)
            <= precision * (np.abs(needed).max(initial=0) or 1.0))


@given(st.integers(0, 10 ** 6), st.integers(1, 26), st.integers(1, 20), st.integers(1, 3))
def test_the_decoder_at_half_resolution_is_the_decoder(seed, width, frames, clips):
    rng, _, L = made(seed, width=width)
    H = rng.normal(size=(clips, 10, frames))
    stylist = Stylist(None, L)
    plan = stylist._plan({}, 1, clips, frames)
    plan.input[:] = (H / 2 - L["b0"][:, None]).swapaxes(1, 2)
    X = plan.forward(stylist._filter_spectra(1, plan)).reshape(clips, 2 * frames, 66).swapaxes(1, 2)
    close(X, networks.decode(H, L))


@given(st.integers(0, 10 ** 6), st.integers(1, 30))
def test_half_filters_and_their_adjoint(seed, width):
    rng = np.random.default_rng(seed)
    W0 = rng.normal(size=(4, 3, width))
    V = half_filters(W0)
    dV = rng.normal(size=V.shape)
    np.testing.assert_allclose(np.vdot(dV, V), np.vdot(half_filters_backward(dV, width), W0),
                               rtol=1e-12)


@pytest.mark.parametrize("frames, threads", [(240, 1), (240, 2), (481, 2), (961, 3), (5000, 2),
                                             (5000, 4)])
def test_threads_share_a_clip_as_far_as_it_makes_it_faster(frames, threads):
    _, T, L = made(0)
    stylist = Stylist(T, L, threads=threads)
    used, size = stylist._shares(frames)
    assert 1 <= used <= threads and size % 2 == 0 and size <= stylist.block
    blocks = -(-frames // size)
    assert blocks % used == 0 or blocks == used                  # everybody gets as many
    assert stylist._shares(480)[0] == 1                          # too short to be shared
    assert stylist._shares(5000)[0] == threads
    X = np.random.default_rng(1).normal(size=(1, 66, frames))
    found = [stylist.stylise(X) for _ in range(2)]
    np.testing.assert_array_equal(*found)
    np.testing.assert_allclose(found[0], Stylist(T, L).stylise(X), atol=1e-11)


@given(st.integers(0, 10 ** 6), st.integers(1, 3), st.integers(1, 150), st.integers(3, 12),
       st.sampled_from([2, 7, 40, 1920]), st.sampled_from([1, 2, 3]))
def test_a_stylist_is_the_networks(seed, clips, frames, width, block, threads):
    rng, T, L = made(seed, width=width)
    X = rng.normal(size=(clips, 66, frames))
    stylist = Stylist(T, L, block=block, threads=threads)
    O = networks.transformation(X, T)
    for _ in range(2):                                           # the second time from kept arrays
        close(stylist.transform(X), O)
        close(stylist.stylise(X), networks.project(O, L))
        close(stylist.project(X), networks.project(X, L))
        close(Stylist(None, L, block=block).project(X), networks.project(X, L))


def test_a_stylist_in_float32_at_the_papers_sizes():
    rng, T, L = made(5, hidden=256, channels=128, width=25, dtype=np.float32)
    X = rng.normal(size=(1, 66, 240)).astype(np.float32)
    wide = [{name: p.astype(float) for name, p in params.items()} for params in (T, L)]
    exact = networks.project(networks.transformation(X.astype(float), wide[0]), wide[1])
    found = Stylist(T, L).stylise(X)
    assert (found.dtype == np.float32 and np.linalg.norm(found - exact)
            <= 2e-6 * np.linalg.norm(exact))


def problem(seed, B=3, T=40, reading="norm", **sizes):
    """Arguments of the definition and of the step."""
    rng, params, L = made(seed, **sizes)
    m = len(L["b0"])
    I = rng.normal(size=(B, 66, T))
    grams = [g @ g.T for g in rng.normal(size=(B, m, m))]
    contacts, trajectory, bones = (rng.random((B, 4, T))
                                   < 0.5).astype(float), rng.normal(size=(B, 3, T)), rng.uniform(
                                       1, 4, len(BONES))
    mean, deviation = rng.normal(size=66), rng.uniform(0.5, 3, 66)
    weights = Weights(content=1.3, style=0.4, foot=0.02, bone=0.03, trajectory=0.05, turn=7.0,
                      reading=reading)
    target = Batch(I, np.stack(grams), contacts, bones, trajectory)
    return params, target, L, mean, deviation, weights


@pytest.mark.parametrize("seed,T_width,reading",
                         [(1, None, "norm"), (2, None, "mean_squares"), (4, None, "sum_squares"),
                          (3, 5, "norm")])
def test_the_shared_style_step_is_equation_10(seed, T_width, reading):
    params, target, L, mean, deviation, weights = problem(seed, T_width=T_width, reading=reading)
    _, terms = objective.total_loss(params, target, L, mean, deviation, weights)
    gradients = objective.total_loss_backward(1.0, params, target, L, mean, deviation, weights)
    step = StyleStep(3, 40, params, L, mean, deviation, weights)
    for _ in range(2):
        found, walked = step(params, target)
        assert list(found) == list(terms)
        for name in terms:
            np.testing.assert_allclose(found[name], terms[name], rtol=1e-12)
        assert set(walked) == set(gradients)
        for name in gradients:
            close(walked[name], gradients[name])


@pytest.mark.parametrize("reading", READINGS)
def test_the_shared_style_step_where_norms_are_zero(reading):
    params, target, L, mean, deviation, weights = problem(4, reading=reading)
    # no unit is ever active
    dead = {"W0": L["W0"], "b0": np.full_like(L["b0"], -1e9)}
    target = replace(target, gram=np.zeros_like(target.gram))
    gradients = objective.total_loss_backward(1.0, params, target, dead, mean, deviation, weights)
    found, walked = StyleStep(3, 40, params, dead, mean, deviation, weights)(params, target)
    assert found["content"] == found["style"] == 0
    for name in gradients:
        close(walked[name], gradients[name])


@pytest.mark.parametrize("noise, chance, width",
                         [(False, False, 9), (True, False, 9), (True, True, 9), (False, True, 8),
                          (False, True, 1)])
def test_the_shared_autoencoder_step_is_equation_3(noise, chance, width):
    rng, _, L = made(6, width=width)
    X = rng.normal(size=(4, 66, 30))
    noisy = rng.normal(size=X.shape) if noise else None
    step = AutoencoderStep(4, 30, L, random=chance)
    for _ in range(2):
        chosen = rng.integers(2, size=(4, 10, 15)) if chance else None
        loss, gradients = step(L, X, noisy, chosen)
        np.testing.assert_allclose(loss,
                                   networks.autoencoder_loss(X, L, noisy=noisy, chosen=chosen),
                                   rtol=1e-12)
        needed = networks.autoencoder_loss_backward(1.0, X, L, noisy=noisy, chosen=chosen)[1]
        for name in needed:
            close(gradients[name], needed[name])


def test_ties_of_the_pooling_go_to_the_first_in_the_steps_too():
    rng, params, L = made(7)
    # constant in time: every inner pair ties
    X = np.repeat(rng.normal(size=(2, 66, 1)), 30, axis=2)
    needed = networks.autoencoder_loss_backward(1.0, X, L)[1]
    # all pairs tie exactly, and are active
    quiet = {"W0": np.zeros_like(L["W0"]), "b0": np.abs(L["b0"])}
    needed = networks.autoencoder_loss_backward(1.0, X, quiet)[1]
    _, gradients = AutoencoderStep(2, 30, quiet)(quiet, X)
    for name in needed:
        close(gradients[name], needed[name])


def test_an_odd_number_of_frames_is_refused():
    params, _, L, mean, deviation, weights = problem(8)
    with pytest.raises(ValueError, match="found 41 frames, needed an even number"):
        StyleStep(3, 41, params, L, mean, deviation, weights)
    with pytest.raises(ValueError, match="found 41 frames, needed an even number"):
        AutoencoderStep(3, 41, L)


def lesson_and_manifold(dtype=float, N=7, T=40):
    rng, _, L = made(9, dtype=dtype)
    X = rng.normal(size=(N, 66, T)).astype(dtype)
    grams = {name: (g @ g.T).astype(dtype) for name, g in zip("ab", rng.normal(size=(2, 10, 10)))}
    lesson = TrainingSet(X, (rng.random((N, 4, T)) < 0.5).astype(dtype),
                         rng.normal(size=(N, 3, T)).astype(dtype), grams, tuple("abababa"[:N]),
                         rng.uniform(1, 4, len(BONES)))
    return (lesson, Manifold(L,
                             Normaliser(rng.normal(size=66), rng.uniform(0.5, 2, 66),
                                        "random numbers"), 80.0, lesson.bones))


def trained(epochs, **how):
    return list(epochs(epochs=2, batch=5, seed=3, **how))


def both(lesson, manifold):
    """The two training loops, with the gradients of this room in so many parts."""
    def style(parts=1, executor=None, training_set=None, **how):
        return train.train_style(
            lesson, manifold, channels=6, width=9,
            gradients=sharded(style_gradients, parts, executor, training_set), **how)

    def autoencoder(parts=1, executor=None, **how):
        return train.train_autoencoder(lesson.X, hidden=10, width=9,
                                       gradients=sharded(autoencoder_gradients, parts, executor),
                                       **how)

    return style, autoencoder


class Wire:
    """An executor in another place: it counts the bytes that go there and back, step by step."""

    def __init__(self):
        self.sent, self.back = [], []

    def map(self, function, parts):
        parts = list(map(pickle.dumps, parts))
        answers = [pickle.dumps(function(pickle.loads(part))) for part in parts]
        self.sent.append(sum(map(len, parts)))
        self.back.append(sum(map(len, answers)))
        return map(pickle.loads, answers)


def test_what_does_not_change_is_sent_once():
    """At the paper's widths, parts of five windows."""
    rng = np.random.default_rng(0)
    params = networks.init_transformation_network(rng)
    L = networks.init_loss_network(rng)
    X = rng.normal(size=(10, 66, 240)).astype(np.float32)
    lesson = TrainingSet(X, np.ones((10, 4, 240), np.float32), np.zeros((10, 3, 240), np.float32),
                         {"a": np.eye(256, dtype=np.float32)}, ("a",) * 10, np.ones(20))
    constants = (L, np.zeros(66), np.ones(66), Weights(), EQUATION_10)
    batch, wire, found = lesson.batch(np.arange(10)), Wire(), []
    before = 2 * len(pickle.dumps((constants, params, batch.part(slice(5)))))
    for how in ({"executor": wire, "training_set": lesson}, {}):
        of_batch = sharded(style_gradients, 2, **how)(*constants)
        found.append([{name: g.copy() for name, g in of_batch(params, batch)[1].items()}
                      for _ in range(2)])
    for name in params:
        np.testing.assert_array_equal(found[0][1][name], found[1][1][name])
    # asked without the run, sent it once (one worker here), and from then on without it
    first, again, second = wire.sent
    assert again > first and second == first <= before / 2, (wire.sent, before)


@pytest.mark.parametrize("make", [lambda: ThreadPoolExecutor(2), lambda: ProcessPoolExecutor(2)],
                         ids=["threads", "processes"])
def test_any_executor_gives_the_bits_of_one_process(make):
    with make() as executor:
        lesson, manifold = lesson_and_manifold()
        loops = both(lesson, manifold)
        for epochs, more in (*((one, {}) for one in loops), (loops[0], {"training_set": lesson})):
            alone, side_by_side = (trained(epochs, parts=2),
                                   trained(epochs, parts=2, executor=executor, **more))
            for (record, state), (same, bits) in zip(side_by_side, alone):
                assert record.losses == same.losses
                for name in state.params:
                    np.testing.assert_array_equal(state.params[name], bits.params[name])


def test_the_gradient_of_a_batch_is_that_of_its_parts():
    lesson, manifold = lesson_and_manifold()
    _, params, _ = made(11)

    def gradients(parts):
        make = sharded(style_gradients, parts)
        normaliser = manifold.normaliser
        of_batch = make(manifold.params, normaliser.mean, normaliser.deviation, Weights())
        return of_batch(params, lesson.batch(np.arange(7)))

    losses, whole = gradients(1)
    losses, whole = dict(losses), {name: g.copy() for name, g in whole.items()}
    for parts in (2, 3, 9):
        found, pieces = gradients(parts)
        for name in losses:
            np.testing.assert_allclose(found[name], losses[name], rtol=1e-12)
        for name in whole:
            close(pieces[name], whole[name])


def test_training_in_parts_ends_near_training_whole():
    for epochs in both(*lesson_and_manifold()):
        (_, whole), (_, parts) = trained(epochs)[-1], trained(epochs, parts=2)[-1]
        for name in whole.params:
            # Adam divides by small gradients: rounding grows
            close(parts.params[name], whole.params[name], 1e-5)


def test_a_dask_cluster_gives_what_one_process_gives():
    distributed = pytest.importorskip("distributed", reason="optional: pip install distributed")
    lesson, manifold = lesson_and_manifold()
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1,
                                  dashboard_address=None) as cluster, distributed.Client(
                                      cluster) as client:
        executor = client.get_executor()
        found = trained(both(lesson, manifold)[0], parts=2, executor=executor)
    needed = trained(both(lesson, manifold)[0], parts=2)
    for name in needed[-1][1].params:
        np.testing.assert_array_equal(found[-1][1].params[name], needed[-1][1].params[name])


def test_the_definition_trains_to_the_same_weights():
    lesson, manifold = lesson_and_manifold()
    definitions = (lambda **how: train.train_style(lesson, manifold, channels=6, width=9, **how),
                   lambda **how: train.train_autoencoder(lesson.X, hidden=10, width=9, **how))
    for fast, slow in zip(both(lesson, manifold), definitions):
        (_, found), (_, needed) = trained(fast)[-1], trained(slow)[-1]
        for name in needed.params:
            close(found.params[name], needed.params[name], 1e-5)


def test_a_state_that_was_handed_out_stays_as_it_is():
    states = [state for _, state in trained(both(*lesson_and_manifold())[0])]
    assert (states[0].adam["t"] == 2
            and not np.array_equal(states[0].params["W1"], states[1].params["W1"]))


def test_training_allocates_nothing_large_after_its_first_step():
    params, target, L, mean, deviation, weights = problem(10, B=4, T=240, hidden=256, channels=128,
                                                          width=25)
    params = {name: np.asfortranarray(p) for name, p in params.items()}
    step = StyleStep(4, 240, params, L, mean, deviation, weights)

    def perceptual():
        O, hidden = step._forward(params, target.I)
        # the constraints' arrays are of the size of the motion itself
        _, dO = step._perceptual(O, hidden, target)
        return step._backward(dO)

    perceptual()
    tracemalloc.start()
    perceptual()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # no signal of a layer, no filters (3.3 MB), no Gram matrix
    assert peak < 0.5 * target.I.nbytes


def test_an_hour_of_motion_needs_less_than_a_gibibyte_beside_itself():
    """216,000 frames through the paper's networks in one call."""
    rng = np.random.default_rng(0)
    stylist = Stylist(networks.init_transformation_network(rng), networks.init_loss_network(rng))
    X = np.zeros((1, 66, 216_000), np.float32)
    tracemalloc.start()
    found = stylist.stylise(X)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found.shape == X.shape and peak < 2 ** 30
