"""What holds for any input: adjoints, linearity, shifts, permutations, bounds."""

from hypothesis import assume, given, strategies as st
import numpy as np
import pytest

from refimpl import nn

seeds = st.integers(0, 2 ** 32)


@st.composite
def convolutions(draw):
    """rng, x (N, C, T), w, options."""
    rng = np.random.default_rng(draw(seeds))
    groups, stride, dilation = (draw(st.integers(1, 2)), draw(st.integers(1, 3)),
                                draw(st.integers(1, 3)))
    N, C, O, T, K = (draw(st.integers(1, most)) for most in (3, 3, 3, 12, 5))
    padding = draw(st.sampled_from(["valid", 2, (0, 3)] + ["same"] * (stride == 1)))
    x, w = rng.normal(size=(N, groups * C, T)), rng.normal(size=(groups * O, C, K))
    zeros = ({"valid": 0, "same": dilation * (K - 1)}[padding] if isinstance(padding, str) else 4
             if padding == 2 else 3)
    assume(T + zeros > dilation * (K - 1))
    return rng, x, w, dict(stride=stride, padding=padding, dilation=dilation, groups=groups)


def inner(a, b):
    return np.sum(a * b)


def adjoint(f, backward, *arrays, rng, linear=0):
    """<f(x), y> = <x, f_backward(y)> in the argument in which f is linear."""
    y = f(*arrays)
    up = rng.normal(size=np.shape(y))
    gradients = backward(up, *arrays)
    gradient = gradients[linear] if isinstance(gradients, tuple) else gradients
    np.testing.assert_allclose(inner(y, up), inner(arrays[linear], gradient), rtol=1e-9, atol=1e-9)


def is_linear(f, a, b):
    np.testing.assert_allclose(f(2.5 * a - 0.5 * b), 2.5 * f(a) - 0.5 * f(b), rtol=1e-9, atol=1e-10)


@given(convolutions())
def test_convolution_is_linear_in_both_factors_and_its_gradients_are_the_adjoints(case):
    rng, x, w, options = case
    for linear, other in ((0, rng.normal(size=x.shape)), (1, rng.normal(size=w.shape))):
        adjoint(lambda *a: nn.conv1d(*a, **options), lambda d,
                *a: nn.conv1d_backward(d, *a, **options), x, w, rng=rng, linear=linear)
        is_linear(lambda a: nn.conv1d(*((a, w) if linear == 0 else (x, a)), **options),
                  (x, w)[linear], other)
    y = nn.conv1d(x, w, rng.normal(size=len(w)), **options)
    db = nn.conv1d_backward(np.ones_like(y), x, w, np.zeros(len(w)), **options)[2]
    np.testing.assert_array_equal(db, np.full(len(w), y.shape[0] * y.shape[2]))


@given(convolutions(), st.integers(0, 2))
def test_the_transposed_convolution_is_linear_and_its_gradients_are_the_adjoints(
        case, output_padding):
    rng, x, w, options = case
    options = {**options, "output_padding": min(output_padding,
                                                max(options["stride"], options["dilation"]) - 1)}
    h = rng.normal(size=(len(x), len(w), x.shape[2]))
    try:
        nn.conv_transpose1d(h, w, **options)
    except ValueError:                                           # the padding would leave no frame
        assume(False)
    for linear, other in ((0, rng.normal(size=h.shape)), (1, rng.normal(size=w.shape))):
        adjoint(lambda *a: nn.conv_transpose1d(*a, **options), lambda d,
                *a: nn.conv_transpose1d_backward(d, *a, **options), h, w, rng=rng, linear=linear)
        is_linear(lambda a: nn.conv_transpose1d(*((a, w) if linear == 0 else (h, a)), **options),
                  (h, w)[linear], other)


@given(convolutions(), st.integers(1, 4))
def test_a_shifted_input_gives_a_shifted_output(case, shift):
    _, x, w, options = case
    assume(x.shape[2] - shift * options["stride"] > options["dilation"] * (w.shape[2] - 1))
    options = {**options, "padding": "valid"}
    np.testing.assert_allclose(nn.conv1d(x[:, :, shift * options["stride"]:], w, **options),
                               nn.conv1d(x, w, **options)[:, :, shift:], atol=1e-12)


@given(convolutions())
def test_the_order_of_clips_and_channels_is_no_matter(case):
    rng, x, w, options = case
    options = {**options, "groups": 1}
    w = rng.normal(size=(len(w), x.shape[1], w.shape[2]))
    clips, channels, filters = (rng.permutation(len(x)), rng.permutation(x.shape[1]),
                                rng.permutation(len(w)))
    y = nn.conv1d(x, w, **options)
    np.testing.assert_allclose(nn.conv1d(x[clips], w, **options), y[clips], atol=1e-12)
    np.testing.assert_allclose(nn.conv1d(x[:, channels], w[:, channels], **options), y, atol=1e-12)
    np.testing.assert_allclose(nn.conv1d(x, w[filters], **options), y[:, filters], atol=1e-12)
    for f in (nn.max_pool1d, nn.avg_pool1d, nn.avg_depool1d, nn.relu):
        np.testing.assert_array_equal(f(x[clips][:, channels], *(() if f is nn.relu else (1,))),
                                      f(x, *(() if f is nn.relu else (1,)))[clips][:, channels])
    np.testing.assert_allclose(nn.gram(x[:, channels]), nn.gram(x)[:, channels][:, :, channels],
                               atol=1e-12)
    for f in (nn.norm, nn.sum_squares, nn.mean_squares):
        np.testing.assert_allclose(f(x[clips][:, channels]), f(x)[clips], rtol=1e-12)


@st.composite
def poolings(draw):
    """rng, x, width, options."""
    rng = np.random.default_rng(draw(seeds))
    width = draw(st.integers(1, 4))
    options = dict(stride=draw(st.none() | st.integers(1, 4)),
                   padding=draw(st.integers(0, width // 2)), ceil_mode=draw(st.booleans()))
    return (rng, rng.normal(size=(draw(st.integers(1, 3)), draw(st.integers(1, 3)),
                                  draw(st.integers(width, 12)))), width, options)


@given(poolings())
def test_a_largest_is_one_of_its_window_and_no_mean_is_above_it(case):
    rng, x, width, options = case
    largest, indices = (nn.max_pool1d(x, width, **options),
                        nn.max_pool1d_indices(x, width, **options))
    np.testing.assert_array_equal(largest, np.take_along_axis(x, indices, axis=2))
    mean = nn.avg_pool1d(x, width, count_include_pad=False, **options)
    assert ((mean <= largest + 1e-12).all()
            and (mean >= -nn.max_pool1d(-x, width, **options) - 1e-12).all())
    np.testing.assert_allclose(nn.max_pool1d(3 * x + 2, width, **options), 3 * largest + 2,
                               rtol=1e-12, atol=1e-12)
    dy = rng.normal(size=largest.shape)
    dx = nn.max_pool1d_backward(dy, x, width, **options)
    # nothing lost, nothing added
    np.testing.assert_allclose([dx.sum(), inner(x, dx)], [dy.sum(), inner(largest, dy)], atol=1e-10)


@given(poolings(), st.booleans())
def test_linear_pooling_and_depooling_have_adjoints(case, count_include_pad):
    rng, x, width, options = case
    options["count_include_pad"] = count_include_pad
    other, chosen = rng.normal(size=x.shape), rng.integers(width, size=x.shape)
    length = x.shape[2] + 3
    places = rng.integers(length, size=x.shape)
    for f, backward in ((lambda a: nn.avg_pool1d(a, width, **options), lambda d,
                         a: nn.avg_pool1d_backward(d, a, width, **options)),
                        (lambda a: nn.avg_depool1d(a, width), lambda d,
                         a: nn.avg_depool1d_backward(d, a, width)),
                        (lambda a: nn.random_depool1d(a, chosen, width), lambda d,
                         a: nn.random_depool1d_backward(d, a, chosen, width)),
                        (lambda a: nn.max_unpool1d(a, places, length), lambda d,
                         a: nn.max_unpool1d_backward(d, a, places, length))):
        adjoint(f, backward, x, rng=rng)
        is_linear(f, x, other)


@given(seeds, st.integers(1, 5), st.integers(1, 6))
def test_a_gram_matrix_is_symmetric_and_positive_semidefinite(seed, channels, frames):
    rng = np.random.default_rng(seed)
    h = rng.normal(size=(2, channels, frames))
    G, dG = nn.gram(h), rng.normal(size=(2, channels, channels))
    np.testing.assert_array_equal(G, G.swapaxes(1, 2))
    assert np.linalg.eigvalsh(G).min() > -1e-12
    # Euler: gram is of degree 2
    np.testing.assert_allclose(2 * inner(G, dG), inner(h, nn.gram_backward(dG, h)), rtol=1e-9,
                               atol=1e-9)


@given(seeds, st.floats(0.0, 8.0))
def test_relu_cuts_and_sizes_grow_in_proportion(seed, factor):
    rng = np.random.default_rng(seed)
    x, y = rng.normal(size=(2, 3, 4)), rng.normal(size=(2, 3, 4))
    np.testing.assert_array_equal(nn.relu(x) - nn.relu(-x), x)
    np.testing.assert_array_equal(nn.relu(nn.relu(x)), nn.relu(x))
    assert inner(nn.relu(x), y) == pytest.approx(inner(x, nn.relu_backward(y, x)), abs=1e-12)
    np.testing.assert_allclose(nn.norm(factor * x), factor * nn.norm(x), rtol=1e-12)
    np.testing.assert_allclose(nn.sum_squares(factor * x), factor ** 2 * nn.sum_squares(x),
                               rtol=1e-12)
    assert nn.l1(factor * x) == pytest.approx(factor * nn.l1(x), rel=1e-12)
    assert ((nn.norm(x + y) <= nn.norm(x) + nn.norm(y) + 1e-12).all()
            and nn.l1(x) >= nn.norm(x[None])[0] - 1e-12)
    for degree, f, backward, dy in ((1, nn.norm, nn.norm_backward, np.ones(2)),
                                    (2, nn.sum_squares, nn.sum_squares_backward, np.ones(2)),
                                    (2, nn.mean_squares, nn.mean_squares_backward, np.ones(2)),
                                    (1, nn.l1, nn.l1_backward, 1.0)):
        # Euler's theorem
        assert inner(x, backward(dy, x)) == pytest.approx(degree * np.sum(f(x)), rel=1e-9)


@given(seeds, st.sampled_from(["none", "mean", "sum"]))
def test_errors_are_symmetric_and_their_two_gradients_opposite(seed, reduction):
    rng = np.random.default_rng(seed)
    x, y = rng.normal(size=(2, 3)), rng.normal(size=(2, 3))
    for degree, f, backward in ((2, nn.squared_error, nn.squared_error_backward),
                                (1, nn.absolute_error, nn.absolute_error_backward)):
        np.testing.assert_array_equal(f(x, y, reduction=reduction), f(y, x, reduction=reduction))
        assert np.sum(f(x, x, reduction=reduction)) == 0
        up = np.ones((2, 3)) if reduction == "none" else 1.0
        dx, dy = backward(up, x, y, reduction=reduction)
        np.testing.assert_array_equal(dx, -dy)
        assert (inner(dx, x - y) == pytest.approx(degree * np.sum(f(x, y, reduction=reduction)),
                                                  rel=1e-9))


@given(seeds, st.floats(1e-6, 1e6), st.integers(1, 8), st.sampled_from(["C", "F"]))
def test_a_step_of_adam_is_bounded_and_keeps_the_layout(seed, size, steps, order):
    """The first step is a rate at most; by Cauchy and Schwarz none is longer than (1 - beta1) /
    sqrt((1 - beta2) (1 - beta1^2 / beta2)) = 7.27 rates.
    """
    rng = np.random.default_rng(seed)
    params = {"w": np.array(rng.normal(size=(2, 3)), order=order), "b": rng.normal(size=2)}
    state = nn.adam_start(params)
    for t in range(1, steps + 1):
        gradients = {name: np.array(size * rng.normal(size=p.shape), order=order) for name,
                     p in params.items()}
        before, (params, state) = params, nn.adam_step(params, gradients, state, rate=0.01)
        for name, p in params.items():
            assert (np.abs(p - before[name]) <= 0.01 * (1 + 1e-9) if t == 1
                    else np.abs(p - before[name]) < 0.0728).all()
        for array in (params["w"], state["m"]["w"], state["v"]["w"]):
            assert array.flags.f_contiguous if order == "F" else array.flags.c_contiguous
    assert state["t"] == steps
