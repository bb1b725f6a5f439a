"""Convolution: by hand, against scipy, against its own adjoint, and in its gradients."""

import textwrap

from hypothesis import assume, given, strategies as st
import numpy as np
import pytest
from scipy.signal import correlate

from refimpl import nn


def zeros_of(padding, K, dilation):
    """How many zeros a padding adds on both sides together."""
    if isinstance(padding, str):
        return {"valid": 0, "same": dilation * (K - 1)}[padding]
    return sum(padding) if isinstance(padding, tuple) else 2 * padding


@st.composite
def cases(draw):
    """A random convolution that makes some output: x, w, b, options, all float64."""
    rng = np.random.default_rng(draw(st.integers(0, 2 ** 32)))
    groups = draw(st.sampled_from([1, 1, 2, 3]))
    C, O, K = (groups * draw(st.integers(1, 3)), groups * draw(st.integers(1, 3)),
               draw(st.integers(1, 6)))
    stride, dilation = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    padding = draw(st.sampled_from(["valid"] + (["same"] if stride == 1 else []) + [0, 1, 2])
                   | st.tuples(st.integers(0, 4), st.integers(0, 4)))
    N, T = draw(st.integers(0, 3)), draw(st.integers(1, 14))
    assume(T + zeros_of(padding, K, dilation) >= dilation * (K - 1) + 1)
    options = dict(stride=stride, padding=padding, dilation=dilation, groups=groups)
    return (rng.normal(size=(N, C, T)), rng.normal(size=(O, C // groups, K)), rng.normal(size=O),
            options, rng)


def by_definition(x, w, b, *, stride, padding, dilation, groups):
    """The formula of `conv1d` in loops."""
    N, C, T = x.shape
    O, Cg, K = w.shape
    if padding == "same":
        left = dilation * (K - 1) // 2
        right = dilation * (K - 1) - left
    else:
        left, right = ((0, 0) if padding == "valid" else (padding, padding)
                       if isinstance(padding, int) else padding)
    T_out = (T + left + right - dilation * (K - 1) - 1) // stride + 1
    y = np.zeros((N, O, T_out))
    for n, o, t in np.ndindex(y.shape):
        y[n, o, t] = b[o]
        for c in range(Cg):
            for k in range(K):
                s = t * stride + k * dilation - left
                if 0 <= s < T:
                    y[n, o, t] += w[o, c, k] * x[n, o // (O // groups) * Cg + c, s]
    return y


def test_a_convolution_by_hand():
    x = np.array([[[1.0, 2, 3]]])
    w = np.array([[[10.0, 20]]])
    np.testing.assert_array_equal(nn.conv1d(x, w, padding="valid"), [[[50, 80]]])
    # same: the one zero goes to the right
    np.testing.assert_array_equal(nn.conv1d(x, w), [[[50, 80, 30]]])
    np.testing.assert_array_equal(nn.conv1d(x, w, np.array([1.0]), padding=(1, 0)),
                                  [[[21, 51, 81]]])


def test_its_gradient_by_hand():
    x, w, dy = np.array([[[1.0, 2, 3]]]), np.array([[[10.0, 20]]]), np.array([[[5.0, 7]]])
    dx, dw, db = nn.conv1d_backward(dy, x, w, np.zeros(1), padding="valid")
    np.testing.assert_array_equal(dx, [[[50, 100 + 70, 140]]])
    np.testing.assert_array_equal(dw, [[[5 * 1 + 7 * 2, 5 * 2 + 7 * 3]]])
    np.testing.assert_array_equal(db, [12])


def test_a_transposed_convolution_by_hand():
    h, w = np.array([[[1.0, 2]]]), np.array([[[10.0, 20]]])
    np.testing.assert_array_equal(nn.conv_transpose1d(h, w, padding="valid"), [[[10, 20 + 20, 40]]])
    np.testing.assert_array_equal(nn.conv_transpose1d(h, w, padding="valid", stride=2),
                                  [[[10, 20, 20, 40]]])


def test_frames_that_no_window_reaches_have_no_gradient():
    x, w, dy = np.array([[[1.0, 2, 3, 4]]]), np.array([[[10.0]]]), np.array([[[5.0, 7]]])
    np.testing.assert_array_equal(nn.conv1d_backward(dy, x, w, padding="valid", stride=2)[0],
                                  [[[50, 0, 70, 0]]])


def test_output_padding_by_hand():
    """The last output frame may lie beyond what the taps reach: then it is zero, and gives no
    gradient.
    """
    h, w = np.array([[[1.0, 2]]]), np.array([[[10.0, 20]]])
    options = dict(padding=(1, 0), stride=2, output_padding=1)
    np.testing.assert_array_equal(nn.conv_transpose1d(h, w, **options), [[[20, 20, 40, 0]]])
    dh, dw, _ = nn.conv_transpose1d_backward(np.array([[[1.0, 3, 5, 7]]]), h, w, **options)
    np.testing.assert_array_equal(dh, [[[20, 130]]])
    np.testing.assert_array_equal(dw, [[[2 * 3, 1 + 2 * 5]]])


def test_two_channels_by_hand():
    x = np.array([[[1.0, 0], [0, 1]]])
    w = np.array([[[1.0], [2]], [[3], [4]]])
    np.testing.assert_array_equal(nn.conv1d(x, w), [[[1, 2], [3, 4]]])


@given(cases())
def test_conv1d_is_its_definition(case):
    x, w, b, options, _ = case
    np.testing.assert_allclose(nn.conv1d(x, w, b, **options), by_definition(x, w, b, **options),
                               atol=1e-12)


@given(st.integers(0, 10 ** 6), st.integers(1, 9), st.integers(9, 30))
def test_scipy_correlates_the_same(seed, K, T):
    rng = np.random.default_rng(seed)
    x, w = rng.normal(size=T), rng.normal(size=K)
    np.testing.assert_allclose(nn.conv1d(x[None, None], w[None, None], padding="valid")[0, 0],
                               correlate(x, w, "valid"), atol=1e-12)
    left = (K - 1) // 2
    np.testing.assert_allclose(nn.conv1d(x[None, None], w[None, None])[0, 0],
                               correlate(np.pad(x, (left, K - 1 - left)), w, "valid"), atol=1e-12)


@given(cases())
def test_conv_transpose1d_is_the_adjoint(case):
    x, w, _, options, rng = case
    y = nn.conv1d(x, w, **options)
    h = rng.normal(size=y.shape)
    shortest = ((h.shape[2] - 1) * options["stride"] + options["dilation"] * (w.shape[2] - 1) + 1
                - zeros_of(options["padding"], w.shape[2], options["dilation"]))
    back = nn.conv_transpose1d(h, w, output_padding=x.shape[2] - shortest, **options)
    assert back.shape == x.shape
    np.testing.assert_allclose(np.sum(y * h), np.sum(x * back), atol=1e-10)
    np.testing.assert_allclose(nn.conv1d_backward(h, x, w, **options)[0], back, atol=1e-12)


@given(cases())
def test_gradients(case):
    x, w, b, options, rng = case
    nn.check_gradient(lambda *a: nn.conv1d(*a, **options), lambda d,
                      *a: nn.conv1d_backward(d, *a, **options), x, w, b, names=("x", "w", "b"))


@given(cases(), st.integers(0, 2))
def test_gradients_of_the_transposed_convolution(case, output_padding):
    x, w, _, options, rng = case
    assume(output_padding < max(options["stride"], options["dilation"]))
    h, b = nn.conv1d(x, w, **options), rng.normal(size=x.shape[1])
    options["output_padding"] = output_padding
    try:
        nn.conv_transpose1d(h, w, b, **options)
    except ValueError:
        assume(False)
    nn.check_gradient(lambda *a: nn.conv_transpose1d(*a, **options), lambda d,
                      *a: nn.conv_transpose1d_backward(d, *a, **options), h, w, b,
                      names=("h", "w", "b"))


@given(st.integers(0, 10 ** 6), st.integers(1, 5))
def test_shifting_the_input_shifts_the_output(seed, shift):
    rng = np.random.default_rng(seed)
    x, w, b = rng.normal(size=(1, 2, 30)), rng.normal(size=(3, 2, 5)), rng.normal(size=3)
    np.testing.assert_allclose(nn.conv1d(x[:, :, shift:], w, b, padding="valid"),
                               nn.conv1d(x, w, b, padding="valid")[:, :, shift:], atol=1e-13)


def test_the_2016_code_flips_its_filters():
    """Theano convolves: w[:, :, ::-1] maps one convention onto the other."""
    rng = np.random.default_rng(0)
    x, w = rng.normal(size=20), rng.normal(size=5)
    np.testing.assert_allclose(np.convolve(x, w, "valid"),
                               nn.conv1d(x[None, None], w[None, None, ::-1], padding="valid")[0, 0],
                               atol=1e-13)


@pytest.mark.parametrize("dtype, precision", [(np.float32, 1e-5), (np.float64, 1e-13)])
def test_the_long_form_in_the_docstring_is_the_same(dtype, precision):
    rng = np.random.default_rng(1)
    x, w, b = (rng.normal(size=shape).astype(dtype) for shape in ((2, 3, 9), (4, 3, 5), (4,)))
    lines = nn.conv1d.__doc__.split("in five lines:\n")[1].split("    x : ")[0]
    names = {"np": np, "x": x, "w": w, "b": b, "N": 2, "O": 4, "K": 5, "T": 9}
    exec(textwrap.dedent(lines), names)
    np.testing.assert_allclose(names["y"], nn.conv1d(x, w, b), atol=precision)


def test_contract_in_both_precisions_and_for_no_clips():
    rng = np.random.default_rng(2)
    x, w, b = rng.normal(size=(2, 4, 9)), rng.normal(size=(6, 2, 3)), rng.normal(size=6)
    options = dict(stride=2, padding=(1, 2), dilation=2, groups=2)
    nn.check_contract(lambda *a: nn.conv1d(*a, **options), lambda d,
                      *a: nn.conv1d_backward(d, *a, **options), x, w, b, single=True, batched=(0,))
    h, c = nn.conv1d(x, w, **options), rng.normal(size=4)
    nn.check_contract(lambda *a: nn.conv_transpose1d(*a, **options), lambda d,
                      *a: nn.conv_transpose1d_backward(d, *a, **options), h, w, c, single=True,
                      batched=(0,))


@pytest.mark.parametrize("dtype",
                         [np.float32, np.float64, np.longdouble, np.complex64, np.complex128,
                          np.clongdouble])
def test_precision_is_kept(dtype):
    x, w, b = np.ones((1, 2, 5), dtype), np.ones((3, 2, 3), dtype), np.ones(3, dtype)
    assert nn.conv1d(x, w, b).dtype == dtype
    assert all(g.dtype == dtype for g in nn.conv1d_backward(nn.conv1d(x, w), x, w, b))
    assert nn.conv_transpose1d(nn.conv1d(x, w), w).dtype == dtype


def test_one_complex_factor_makes_the_product_complex():
    """What is linear in each factor takes real and imaginary part of either apart, as a complex
    step through one factor needs it.
    """
    rng = np.random.default_rng(3)
    x, w, h = rng.normal(size=(2, 2, 7)), rng.normal(size=(3, 2, 3)), rng.normal(size=(2, 3, 7))
    for f, a, b in ((nn.conv1d, x, w), (nn.conv_transpose1d, h, w),
                    (lambda d, a: nn.conv1d_backward(d, a, w)[1], h, x),
                    (lambda a, d: nn.conv_transpose1d_backward(d, a, w)[1], h, x)):
        np.testing.assert_allclose(f(a * (1 + 2j), b), f(a, b) * (1 + 2j), atol=1e-13, strict=True)
        np.testing.assert_allclose(f(a, b * (1 + 2j)), f(a, b) * (1 + 2j), atol=1e-13, strict=True)


def test_longdouble_is_more_precise():
    x, w = np.full((1, 1, 3), np.longdouble(1) / 3), np.full((1, 1, 1), np.longdouble(1) / 7)
    if np.finfo(np.longdouble).eps < np.finfo(float).eps:
        assert nn.conv1d(x, w)[0, 0, 0] == np.longdouble(1) / 3 * (np.longdouble(1) / 7)


X, W, B = np.zeros((2, 4, 9)), np.zeros((6, 4, 3)), np.zeros(6)


@pytest.mark.parametrize("arguments, options, words", [
    ((X[0], W, B), {}, r"x: found shape \(4, 9\), needed 3 dimensions"),
    ((X, W[0], B), {}, "w: found shape"),
    ((X, W[:, :3], B), {}, r"x: found shape \(2, 4, 9\), needed \(N, 3, T\)"),
    ((X, W, B[:5]), {}, r"b: found shape \(5,\), needed \(6,\)"),
    ((X, W[:, :, :0], B), {}, "w: found shape"),
    ((X[:, :, :0], W, B), {}, "x: found 0 frames"),
    ((X.astype(int), W, B), {}, "x: found dtype int64.*dtype=float"),
    ((X.astype(np.float16), W, B), {}, "x: found dtype float16"),
    ((X.tolist(), W, B), {}, "x: found list"),
    ((X.astype(np.float32), W, B), {},
     "w: found dtype float64, needed the precision of x, float32"),
    ((X, W, B), {"stride": 0}, "stride: found 0"),
    ((X, W, B), {"stride": 1.0}, "stride: found 1.0"),
    ((X, W, B), {"stride": True}, "stride: found True"),
    ((X, W, B), {"stride": 2}, "padding: found 'same' with stride 2"),
    ((X, W, B), {"dilation": -1}, "dilation: found -1"),
    ((X, W, B), {"groups": 5}, "groups = 5"),
    ((X, W, B), {"groups": 2}, r"x: found shape \(2, 4, 9\), needed \(N, 8, T\)"),
    ((X, W, B), {"padding": "full"}, "padding: found 'full'"),
    ((X, W, B), {"padding": -1}, "padding: found -1"),
    ((X, W, B), {"padding": (1, 2, 3)}, "padding: found"),
    ((X, W, B), {"padding": "valid", "dilation": 5},
     "x: found 9 frames and 0 of padding, needed at least 11")])
def test_bad_input_is_named(arguments, options, words):
    with pytest.raises(ValueError, match=words):
        nn.conv1d(*arguments, **options)
    with pytest.raises(ValueError, match=words):
        nn.conv1d_backward(np.zeros((2, 6, 9)), *arguments, **options)


@pytest.mark.parametrize("arguments, options, words", [
    ((X[0], W), {}, "h: found shape"),
    ((X, W), {}, r"h: found shape \(2, 4, 9\), needed \(N, 6, T\)"),
    ((np.zeros((2, 6, 9)), W, B), {}, r"b: found shape \(6,\), needed \(4,\)"),
    ((np.zeros((2, 6, 9)), W), {"output_padding": 1}, "output_padding: found 1, needed less than"),
    ((np.zeros((2, 6, 9)), W), {"output_padding": -1}, "output_padding: found -1"),
    ((np.zeros((2, 6, 1)), W), {"padding": 2}, "h: found 1 frames")])
def test_bad_input_of_the_transposed_convolution_is_named(arguments, options, words):
    with pytest.raises(ValueError, match=words):
        nn.conv_transpose1d(*arguments, **options)
    with pytest.raises(ValueError, match=words):
        nn.conv_transpose1d_backward(np.zeros((2, 4, 9)), *arguments, **options)


def test_upstream_gradient_of_a_wrong_shape_is_named():
    with pytest.raises(ValueError, match=r"dy: found shape \(2, 6, 8\), needed \(2, 6, 9\)"):
        nn.conv1d_backward(np.zeros((2, 6, 8)), X, W, B)
    with pytest.raises(ValueError, match=r"dx: found shape \(2, 4, 8\), needed \(2, 4, 9\)"):
        nn.conv_transpose1d_backward(np.zeros((2, 4, 8)), np.zeros((2, 6, 9)), W)
