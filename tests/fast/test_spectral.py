"""A plan is a correlation, its backward the adjoint, for any size and padding; calls again and kept
arrays change nothing.
"""


from hypothesis import given, strategies as st
import numpy as np
import pytest

from refimpl.fast.spectral import Plan, best_tile, transforms

sizes = st.tuples(st.integers(0, 10 ** 6), st.integers(1, 3), st.integers(1, 90), st.integers(1, 5),
                  st.integers(1, 5), st.integers(1, 30), st.integers(-10, 40), st.integers(1, 120))


def by_definition(x, w, left, T_out):
    """y[b, t, o] = sum_{c, k} w[o, c, k] x[b, t + k - left, c], in loops."""
    y = np.zeros((len(x), T_out, len(w)))
    for t in range(T_out):
        for k in range(w.shape[2]):
            if 0 <= t + k - left < x.shape[1]:
                y[:, t] += x[:, t + k - left] @ w[:, :, k].T
    return y


@given(sizes)
def test_a_plan_is_a_correlation_and_its_backward_the_adjoint(size):
    seed, B, T, C, O, K, left, T_out = size
    rng = np.random.default_rng(seed)
    x, w = rng.normal(size=(B, T, C)), rng.normal(size=(O, C, K))
    plan = Plan(B, T, C, O, K, float, left=left, T_out=T_out)
    plan.input[:] = x
    spectra = plan.spectra(w)
    y = plan.forward(spectra).copy()
    np.testing.assert_allclose(y, by_definition(x, w, left, T_out), atol=1e-12)
    dy = rng.normal(size=y.shape)
    dx, dw = plan.backward(dy, spectra)
    # the operation is linear in x and in w: the adjoint is known by its inner products
    v, u = rng.normal(size=x.shape), rng.normal(size=w.shape)
    np.testing.assert_allclose(np.vdot(dx, v), np.vdot(dy, by_definition(v, w, left, T_out)),
                               atol=1e-10)
    np.testing.assert_allclose(np.vdot(dw, u), np.vdot(dy, by_definition(x, u, left, T_out)),
                               atol=1e-10)


def test_calls_again_give_the_same_bits():
    rng = np.random.default_rng(0)
    w, x, dy = (rng.normal(size=(7, 5, 25)), rng.normal(size=(3, 200, 5)),
                rng.normal(size=(3, 200, 7)))
    results = []
    for plan in [Plan(3, 200, 5, 7, 25, float, left=12)] * 2 + [Plan(3, 200, 5, 7, 25, float,
                                                                     left=12)]:
        plan.input[:] = x
        spectra = plan.spectra(w)
        y = plan.forward(spectra).copy()
        dx, dw = (a.copy() for a in plan.backward(dy, spectra))
        results.append((y, dx, dw))
    for other in results[1:]:
        for a, b in zip(results[0], other):
            np.testing.assert_array_equal(a, b)


def test_a_bank_of_filters_may_be_written_and_walked_back_in_part():
    rng = np.random.default_rng(1)
    one, two, x, dy = (rng.normal(size=(4, 3, 9)), rng.normal(size=(2, 3, 9)),
                       rng.normal(size=(2, 50, 3)), rng.normal(size=(2, 50, 4)))
    plan = Plan(2, 50, 3, 6, 9, float, left=4)
    bank = np.empty((3, plan.n // 2, 3, 6))
    plan.spectra(one, out=bank[..., :4])
    plan.spectra(two, out=bank[..., 4:])
    plan.input[:] = x
    y = plan.forward(bank)
    np.testing.assert_allclose(y, by_definition(x, np.concatenate([one, two]), 4, 50), atol=1e-12)
    alone = Plan(2, 50, 3, 4, 9, float, left=4)
    alone.input[:] = x
    alone.forward(alone.spectra(one))
    for found, needed in zip(plan.backward(dy, bank[..., :4]),
                             alone.backward(dy, alone.spectra(one))):
        np.testing.assert_allclose(found, needed, atol=1e-12)


def test_nothing_large_is_allocated_after_the_first_call():
    import tracemalloc
    rng = np.random.default_rng(2)
    plan = Plan(4, 240, 32, 48, 25, np.float32, left=12)
    w, dy = (np.asfortranarray(rng.normal(size=(48, 32, 25)).astype(np.float32)),
             rng.normal(size=(4, 240, 48)).astype(np.float32))
    spectra = plan.spectra(w)

    def step():
        plan.spectra(w, out=spectra)
        plan.forward(spectra)
        plan.backward(dy, spectra)
    step()
    tracemalloc.start()
    step()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # NumPy passes arrays through 32 kB; the signal alone is 123 kB
    assert peak < 50_000


@pytest.mark.parametrize("K", [1, 8, 13, 25, 40])
def test_the_transforms_turn_a_correlation_into_products(K):
    n = 4 * -(-(K + 20) // 4)
    F, H, G = transforms(K, n, "d")
    rng = np.random.default_rng(K)
    tile, w = rng.normal(size=n), rng.normal(size=K)
    a, b = np.split(F @ tile, 2)
    V = np.split(H @ w, 3)
    q = (a + b) * V[0], a * V[1], b * V[2]
    y = G @ np.concatenate([q[0] + q[1], q[0] + q[2]])
    np.testing.assert_allclose(y, np.correlate(tile, w, "valid"), atol=1e-12)


def test_the_chosen_tile_is_even_and_wider_than_the_filter():
    for B, T, C, O, K in ((1, 240, 128, 128, 25), (10, 240, 66, 256, 25), (1, 1, 1, 1, 1),
                          (32, 120, 256, 132, 13)):
        n = best_tile(B, T, C, O, K)
        assert n % 4 == 0 and n > K
