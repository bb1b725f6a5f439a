"""Pooling: by hand, by definition, ties, NaN, and gradients."""

from hypothesis import assume, given, strategies as st
import numpy as np
import pytest

from refimpl import nn


@st.composite
def windows(draw):
    """x and the options of a pooling that makes some output, away from ties."""
    rng = np.random.default_rng(draw(st.integers(0, 2 ** 32)))
    width = draw(st.integers(1, 5))
    options = dict(stride=draw(st.none() | st.integers(1, 4)),
                   padding=draw(st.integers(0, width // 2)), ceil_mode=draw(st.booleans()))
    dilation = draw(st.integers(1, 3))
    x = rng.permutation(3 * 2 * 12).reshape(3, 2, 12)[:draw(st.integers(0, 3)), :,
                                                      :draw(st.integers(1, 12))].astype(float)
    assume(x.shape[2] + 2 * options["padding"] >= dilation * (width - 1) + 1)
    return x, width, dilation, options, rng


def positions(T, width, stride, padding, dilation, ceil_mode):
    """Windows as lists of positions inside the input, by the words of the documentation."""
    stride = stride or width
    t, found = 0, []
    while True:
        first = t * stride - padding
        whole = first + dilation * (width - 1) < T + padding
        if (not whole and not (ceil_mode and first < T
                               and first - stride + dilation * (width - 1) + 1 < T + padding)):
            return found
        found.append([first + k * dilation for k in range(width)])
        t += 1


@given(windows())
def test_max_pool_is_its_definition(case):
    x, width, dilation, options, _ = case
    y = nn.max_pool1d(x, width, dilation=dilation, **options)
    windows = positions(x.shape[2], width, dilation=dilation, **options)
    expected = [[[max([row[s] for s in w if 0 <= s < len(row)], default=-np.inf) for w in windows]
                 for row in clip] for clip in x]
    np.testing.assert_array_equal(y, np.array(expected).reshape(x.shape[:2] + (len(windows),)))


@given(windows(), st.booleans())
def test_avg_pool_is_its_definition(case, count_include_pad):
    x, width, _, options, _ = case
    assume(x.shape[2] + 2 * options["padding"] >= width)
    y = nn.avg_pool1d(x, width, count_include_pad=count_include_pad, **options)
    T, pad = x.shape[2], options["padding"]
    windows = positions(T, width, dilation=1, **options)
    expected = [[[sum(row[s] for s in w if 0 <= s < T) / sum(1 for s in w
                                                             if (s < T + pad if count_include_pad
                                                                 else 0 <= s < T)) for w in windows]
                 for row in clip] for clip in x]
    np.testing.assert_allclose(y, np.array(expected).reshape(x.shape[:2] + (len(windows),)),
                               atol=1e-12)


@given(windows())
def test_pool_gradients(case):
    x, width, dilation, options, _ = case
    nn.check_gradient(lambda a: np.nan_to_num(nn.max_pool1d(a, width, dilation=dilation, **options),
                                              neginf=0.0), lambda d,
                      a: nn.max_pool1d_backward(d, a, width, dilation=dilation, **options), x)
    assume(x.shape[2] + 2 * options["padding"] >= width)
    nn.check_gradient(lambda a: nn.avg_pool1d(a, width, **options), lambda d,
                      a: nn.avg_pool1d_backward(d, a, width, **options), x)


@given(st.integers(0, 10 ** 6), st.integers(1, 4))
def test_depooling_and_unpooling_gradients(seed, width):
    rng = np.random.default_rng(seed)
    h = rng.normal(size=(2, 3, 5))
    nn.check_gradient(lambda a: nn.avg_depool1d(a, width), lambda d,
                      a: nn.avg_depool1d_backward(d, a, width), h)
    indices = rng.integers(0, 9, h.shape)
    nn.check_gradient(lambda a: nn.max_unpool1d(a, indices, 9), lambda d,
                      a: nn.max_unpool1d_backward(d, a, indices, 9), h)
    np.testing.assert_allclose(nn.avg_pool1d(nn.avg_depool1d(h, width), width), h / width)


def test_by_hand():
    x = np.array([[[1.0, 3, 2, 2, 5]]])
    np.testing.assert_array_equal(nn.max_pool1d(x), [[[3, 2]]])
    np.testing.assert_array_equal(nn.max_pool1d(x, ceil_mode=True), [[[3, 2, 5]]])
    np.testing.assert_array_equal(nn.max_pool1d_indices(x), [[[1, 2]]])
    np.testing.assert_array_equal(nn.max_pool1d_backward(np.array([[[10.0, 20]]]), x),
                                  [[[0, 10, 20, 0, 0]]])
    np.testing.assert_array_equal(nn.max_unpool1d(np.array([[[3.0, 2]]]), np.array([[[1, 2]]]), 5),
                                  [[[0, 3, 2, 0, 0]]])
    np.testing.assert_array_equal(nn.avg_pool1d(x), [[[2, 2]]])
    np.testing.assert_array_equal(nn.avg_depool1d(np.array([[[2.0, 6]]])), [[[1, 1, 3, 3]]])


def test_the_2016_pair_of_pooling_and_depooling_halves_a_constant():
    x = np.ones((1, 1, 4))
    np.testing.assert_array_equal(nn.avg_depool1d(nn.max_pool1d(x)), np.full((1, 1, 4), 0.5))


def test_a_tie_goes_to_the_first():
    x = np.array([[[4.0, 4, 4, 4]]])
    np.testing.assert_array_equal(nn.max_pool1d_backward(np.ones((1, 1, 2)), x), [[[1, 0, 1, 0]]])
    np.testing.assert_array_equal(nn.max_pool1d_backward(np.ones((1, 1, 3)), x, 2, stride=1),
                                  [[[1, 1, 1, 0]]])
    nn.check_kink(nn.max_pool1d, nn.max_pool1d_backward, x, direction=np.array([[[1.0, 0, 0, -1]]]))


def test_windows_that_overlap_add_up():
    x = np.array([[[1.0, 9, 1]]])
    np.testing.assert_array_equal(nn.max_pool1d_backward(np.array([[[2.0, 3]]]), x, 2, stride=1),
                                  [[[0, 5, 0]]])


def test_averages_of_windows_that_overlap_add_up():
    x = np.array([[[1.0, 9, 1]]])
    np.testing.assert_array_equal(nn.avg_pool1d(x, 2, stride=1), [[[5, 5]]])
    np.testing.assert_array_equal(nn.avg_pool1d_backward(np.array([[[2.0, 6]]]), x, 2, stride=1),
                                  [[[1, 4, 3]]])


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_overlap_keeps_the_precision(dtype):
    x, dy = np.array([[[1, 9, 1]]], dtype), np.array([[[2, 3]]], dtype)
    for back, needed in ((nn.max_pool1d_backward, [[[0, 5, 0]]]),
                         (nn.avg_pool1d_backward, [[[1, 2.5, 1.5]]])):
        np.testing.assert_array_equal(back(dy, x, 2, stride=1), np.array(needed, dtype),
                                      strict=True)


def test_padding_never_wins_and_may_be_longer_than_the_input():
    np.testing.assert_array_equal(nn.max_pool1d(np.array([[[-1.0, -3, -2]]]), 3, stride=2,
                                                padding=1), [[[-1, -2]]])
    np.testing.assert_array_equal(nn.max_pool1d(np.array([[[-7.0]]]), 5, padding=2), [[[-7]]])
    np.testing.assert_array_equal(nn.avg_pool1d(np.array([[[5.0]]]), 5, padding=2), [[[1]]])
    np.testing.assert_array_equal(nn.avg_pool1d_backward(np.array([[[5.0]]]), np.zeros((1, 1, 1)),
                                                         5, padding=2), [[[1]]])


def test_a_last_window_must_begin_inside_to_count():
    """With stride 3 and one zero on the left, windows begin at -1, 2, 5: in 2 frames one begins
    inside or before them, in 5 frames two.
    """
    x = np.array([[[5.0, 7, 2, 8, 4, 9]]])
    options = dict(stride=3, padding=1, ceil_mode=True)
    np.testing.assert_array_equal(nn.max_pool1d(x[:, :, :2], 2, **options), [[[5]]])
    np.testing.assert_array_equal(nn.max_pool1d(x[:, :, :5], 2, **options), [[[5, 8]]])
    np.testing.assert_array_equal(nn.max_pool1d(x, 2, **options), [[[5, 8, 9]]])
    np.testing.assert_array_equal(nn.avg_pool1d(x, 2, **options), [[[2.5, 5, 4.5]]])


def test_what_hangs_over_the_end_does_not_count_in_a_mean():
    x = np.array([[[1.0, 3, 2, 2, 5]]])
    np.testing.assert_array_equal(nn.avg_pool1d(x, ceil_mode=True), [[[2, 2, 5]]])
    np.testing.assert_array_equal(nn.avg_pool1d_backward(np.array([[[2.0, 4, 6]]]), x,
                                                         ceil_mode=True), [[[1, 1, 2, 2, 6]]])


def test_nan_wins_and_infinities_are_numbers():
    x = np.array([[[1.0, np.nan, -np.inf, -np.inf]]])
    y = nn.max_pool1d(x)
    assert np.isnan(y[0, 0, 0]) and y[0, 0, 1] == -np.inf
    np.testing.assert_array_equal(nn.max_pool1d_backward(np.array([[[7.0, 8]]]), x),
                                  [[[0, 7, 8, 0]]])
    padded = np.array([[[-np.inf, -np.inf]]])
    np.testing.assert_array_equal(nn.max_pool1d_indices(padded, 2, stride=1, padding=1),
                                  [[[0, 0, 1]]])
    late = np.array([[[0.0, 1, -np.inf]]])
    np.testing.assert_array_equal(nn.max_pool1d_indices(late, 3, stride=3, padding=1), [[[1]]])
    np.testing.assert_array_equal(
        nn.max_pool1d_indices(np.array([[[1.0, -np.inf, -np.inf, -np.inf]]]), 4, stride=3,
                              padding=2), [[[0, 1]]])


def test_a_window_of_padding_alone():
    """Dilation can step over the whole input; the window is -inf and passes no gradient."""
    x = np.array([[[3.0]]])
    assert nn.max_pool1d(x, 2, padding=1, dilation=2)[0, 0, 0] == -np.inf
    assert nn.max_pool1d_indices(x, 2, padding=1, dilation=2)[0, 0, 0] == -1
    np.testing.assert_array_equal(nn.max_pool1d_backward(np.ones((1, 1, 1)), x, 2, padding=1,
                                                         dilation=2), [[[0]]])


def test_one_frame_and_no_clips_are_enough():
    np.testing.assert_array_equal(nn.avg_depool1d(np.array([[[6.0]]])), [[[3, 3]]])
    np.testing.assert_array_equal(nn.avg_depool1d_backward(np.array([[[6.0, 2]]]),
                                                           np.ones((1, 1, 1))), [[[4]]])
    assert nn.max_unpool1d(np.zeros((0, 2, 3)), np.zeros((0, 2, 3), int), 5).shape == (0, 2, 5)


def test_places_may_be_unsigned():
    np.testing.assert_array_equal(nn.max_unpool1d(np.array([[[7.0]]]), np.array([[[1]]], np.uint8),
                                                  3), [[[0, 7, 0]]])


def test_the_later_value_stands_in_unpooling():
    h, indices = np.array([[[1.0, 2]]]), np.array([[[3, 3]]])
    np.testing.assert_array_equal(nn.max_unpool1d(h, indices, 4), [[[0, 0, 0, 2]]])
    np.testing.assert_array_equal(nn.max_unpool1d_backward(np.ones((1, 1, 4)), h, indices, 4),
                                  [[[0, 1]]])


def test_contracts():
    x = np.random.default_rng(0).normal(size=(2, 3, 8))
    for f, back in ((nn.max_pool1d, nn.max_pool1d_backward),
                    (nn.avg_pool1d, nn.avg_pool1d_backward),
                    (nn.avg_depool1d, nn.avg_depool1d_backward)):
        nn.check_contract(f, back, x, single=True, batched=(0,))


X = np.zeros((2, 3, 8))


@pytest.mark.parametrize("f", [nn.max_pool1d, nn.max_pool1d_indices, nn.avg_pool1d])
@pytest.mark.parametrize("x, width, options, words", [
    (X[0], 2, {}, r"x: found shape \(3, 8\)"), (X, 0, {}, "width: found 0"),
    (X, 2.0, {}, "width: found 2.0"), (X, 2, {"stride": 0}, "stride: found 0"),
    (X, 2, {"padding": 2}, "padding: found 2, needed at most half"),
    (X, 9, {}, "x: found 8 frames"), (X.astype(int), 2, {}, "x: found dtype int64"),
    (X[:, :, :0], 1, {}, "x: found 0 frames"), (X, 2, {"padding": -1}, "padding: found -1")])
def test_bad_input_is_named(f, x, width, options, words):
    with pytest.raises(ValueError, match=words):
        f(x, width, **options)


def test_more_bad_input():
    with pytest.raises(ValueError, match="x: found dtype complex128, needed real"):
        nn.max_pool1d(X.astype(complex))
    with pytest.raises(ValueError, match=r"dy: found shape \(2, 3, 5\), needed \(2, 3, 4\)"):
        nn.max_pool1d_backward(np.zeros((2, 3, 5)), X)
    with pytest.raises(ValueError, match="dy: found shape"):
        nn.avg_pool1d_backward(np.zeros((2, 3, 5)), X)
    with pytest.raises(ValueError, match="dx: found shape"):
        nn.avg_depool1d_backward(np.zeros((2, 3, 15)), X)
    with pytest.raises(ValueError, match="dilation: found 0"):
        nn.max_pool1d(X, 2, dilation=0)
    with pytest.raises(ValueError, match="indices: found shape"):
        nn.max_unpool1d(X, np.zeros((2, 3, 7), int), 9)
    with pytest.raises(ValueError,
                       match="indices: found int64 from 0 to 9, needed whole numbers from 0 to 8"):
        nn.max_unpool1d(X, np.full(X.shape, 9), 9)
    with pytest.raises(ValueError, match="length: found 0"):
        nn.max_unpool1d(X, np.zeros(X.shape, int), 0)
    with pytest.raises(ValueError, match="dx: found shape"):
        nn.max_unpool1d_backward(np.zeros((2, 3, 8)), X, np.zeros(X.shape, int), 9)


@given(st.integers(0, 10 ** 6), st.integers(1, 4), st.integers(1, 3), st.integers(1, 6),
       st.sampled_from([np.float32, np.float64, np.longdouble, np.complex128]))
def test_depooling_by_chance(seed, width, channels, frames, dtype):
    rng = np.random.default_rng(seed)
    h = rng.normal(size=(2, channels, frames)).astype(dtype)
    chosen = rng.integers(width, size=h.shape)
    x = nn.random_depool1d(h, chosen, width)
    assert x.dtype == dtype and x.shape == (2, channels, width * frames)
    pairs = x.reshape(h.shape + (width,))
    np.testing.assert_array_equal(np.take_along_axis(pairs, chosen[..., None], axis=-1)[..., 0], h)
    assert np.count_nonzero(pairs) == h.size                     # everything else is 0
    # nothing lost, nothing added
    np.testing.assert_allclose(nn.avg_pool1d(x, width), h / dtype(width), rtol=1e-6)
    every = [nn.random_depool1d(h, np.full(h.shape, k), width) for k in range(width)]
    # its mean is average-depooling
    np.testing.assert_allclose(sum(every) / dtype(width), nn.avg_depool1d(h, width), rtol=1e-6)
    dx = rng.normal(size=x.shape).astype(dtype)
    dh = nn.random_depool1d_backward(dx, h, chosen, width)
    assert dh.dtype == dtype
    # the adjoint
    np.testing.assert_allclose(np.sum(x * dx), np.sum(h * dh), rtol=1e-4, atol=1e-4)
    if dtype is np.float64:
        nn.check_gradient(lambda a: nn.random_depool1d(a, chosen, width), lambda d,
                          a: nn.random_depool1d_backward(d, a, chosen, width), h)


def test_depooling_by_chance_as_the_authors_code_draws_it(witness):
    """20 draws of the 2016 code: each is this operation with some choice, and the choice differs
    from unit to unit and from frame to frame.
    """
    data = np.load(witness / "2_kinks_and_noise.npz")
    h = data["depool_in"].astype(float)
    chosen = [(draw.reshape(1, 2, 6, 2) != 0).argmax(axis=-1) for draw in data["depool_draws"]]
    for draw, choice in zip(data["depool_draws"], chosen):
        np.testing.assert_array_equal(nn.random_depool1d(h, choice)[0], draw)
    assert (0.3 < np.mean(chosen) < 0.7 and np.std(chosen, axis=0).min() > 0
            and any((c[0, 0] != c[0, 1]).any() for c in chosen))


def test_depooling_by_chance_refuses():
    h, chosen = np.zeros((2, 3, 4)), np.zeros((2, 3, 4), int)
    for wrong, message in ((chosen + 2,
                            "chosen: found int64 from 0 to 2, needed whole numbers from 0 to 1"),
                           (chosen[:, :1], "chosen: found shape"),
                           (chosen + 0.0, "chosen: found float64"),
                           (chosen - 1, "chosen: found int64 from -1 to 0")):
        for call in (lambda c: nn.random_depool1d(h, c),
                     lambda c: nn.random_depool1d_backward(np.zeros((2, 3, 8)), h, c)):
            with pytest.raises(ValueError, match=message):
                call(wrong)
    with pytest.raises(ValueError, match="dx: found shape"):
        nn.random_depool1d_backward(h, h, chosen)
