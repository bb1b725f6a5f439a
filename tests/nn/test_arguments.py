"""Precision and shapes at the edges: what every operation keeps, and what it refuses by name."""

import numpy as np
import pytest

from refimpl import nn

H = np.random.default_rng(0).normal(size=(2, 3, 6)) + 3.0
W = np.random.default_rng(1).normal(size=(4, 3, 3))
PLACES = np.random.default_rng(2).integers(0, 9, H.shape)
TYPES = [np.float32, np.float64, np.longdouble]
COMPLEX = [np.complex64, np.complex128, np.clongdouble]

# name: f, f_backward, the arrays, whether it takes complex numbers
OPERATIONS = {
    "conv1d": (nn.conv1d, nn.conv1d_backward, (H, W), True),
    "conv_transpose1d": (lambda h, w: nn.conv_transpose1d(h, w.swapaxes(0, 1)[:3]),
    lambda d, h, w: nn.conv_transpose1d_backward(d, h, w.swapaxes(0, 1)[:3]), (H, W), True),
    "max_pool1d": (nn.max_pool1d, nn.max_pool1d_backward, (H,), False),
    "avg_pool1d": (nn.avg_pool1d, nn.avg_pool1d_backward, (H,), True),
    "avg_depool1d": (nn.avg_depool1d, nn.avg_depool1d_backward, (H,), True),
    "relu": (nn.relu, nn.relu_backward, (H,), False),
    "gram": (nn.gram, nn.gram_backward, (H,), True),
    "norm": (nn.norm, nn.norm_backward, (H,), True),
    "sum_squares": (nn.sum_squares, nn.sum_squares_backward, (H,), True),
    "mean_squares": (nn.mean_squares, nn.mean_squares_backward, (H,), True),
    "l1": (nn.l1, nn.l1_backward, (H,), False),
    "squared_error": (nn.squared_error, nn.squared_error_backward, (H, H + 1), True),
    "absolute_error": (nn.absolute_error, nn.absolute_error_backward, (H, H + 1), False),
    "max_unpool1d": (lambda h: nn.max_unpool1d(h, PLACES, 9), lambda d,
                     h: nn.max_unpool1d_backward(d, h, PLACES, 9), (H,), True)}


@pytest.mark.parametrize("dtype", TYPES + COMPLEX)
@pytest.mark.parametrize("name", OPERATIONS)
def test_precision_is_kept_or_complex_numbers_are_refused(name, dtype):
    f, backward, arrays, analytic = OPERATIONS[name]
    arrays = [a.astype(dtype) for a in arrays]
    if dtype in COMPLEX and not analytic:
        with pytest.raises(ValueError, match="needed real numbers"):
            f(*arrays)
        return
    y = f(*arrays)
    assert y.dtype == dtype
    gradients = backward(y, *arrays)
    assert all(g.dtype == dtype
               for g in (gradients if isinstance(gradients, tuple) else (gradients,))
               if g is not None)


@pytest.mark.parametrize("dtype", [int, bool, np.float16, object, ">f8", "datetime64[s]"])
@pytest.mark.parametrize("name", OPERATIONS)
def test_other_types_are_refused_with_the_fix(name, dtype):
    f, _, arrays, _ = OPERATIONS[name]
    with pytest.raises(ValueError,
                       match=r"found dtype .*needed an array of float32, float64 or longdouble; "
                             r"try np.asarray"):
        f(np.zeros(arrays[0].shape, dtype), *arrays[1:])


@pytest.mark.parametrize("name",
                         [name for name, (_, _, arrays, _) in OPERATIONS.items()
                          if len(arrays) == 2])
def test_precisions_are_not_mixed(name):
    f, _, (a, b), _ = OPERATIONS[name]
    with pytest.raises(ValueError, match="found dtype float32, needed the precision of"):
        f(a, b.astype(np.float32))


@pytest.mark.parametrize("name", OPERATIONS)
def test_an_upstream_gradient_of_another_shape_or_precision_is_refused(name):
    f, backward, arrays, _ = OPERATIONS[name]
    y = np.asarray(f(*arrays))
    with pytest.raises(ValueError, match="found shape"):
        backward(np.zeros(y.shape + (1,)), *arrays)
    if y.ndim:
        with pytest.raises(ValueError, match="found dtype float32"):
            backward(np.zeros(y.shape, np.float32), *arrays)


def test_a_wide_type_keeps_its_digits():
    third = np.full((1, 1, 3), np.longdouble(1) / 3)
    assert (abs(nn.avg_pool1d(third, 3)[0, 0, 0] - np.longdouble(1) / 3)
            <= np.finfo(np.longdouble).eps)
    assert nn.avg_depool1d(third, 3)[0, 0, 0] == np.longdouble(1) / 3 / 3
    norm = nn.norm(third)[0]
    assert abs(norm * norm - np.longdouble(1) / 3) <= 4 * np.finfo(np.longdouble).eps


def test_infinity_in_an_averaged_window_stays_infinity():
    x = np.array([[[np.inf, 1.0, 2.0, 3.0]]])
    np.testing.assert_array_equal(nn.avg_pool1d(x, 2, padding=1), [[[np.inf, 1.5, 1.5]]])
    np.testing.assert_array_equal(nn.avg_pool1d_backward(np.array([[[np.inf, 2.0, 4.0]]]), x, 2,
                                                         padding=1), [[[np.inf, 1, 1, 2]]])


@pytest.mark.parametrize("call, words", [
    (lambda: nn.avg_depool1d(np.zeros((1, 2, 0))),
     r"h: found shape \(1, 2, 0\), needed at least one frame"),
    (lambda: nn.conv_transpose1d(np.zeros((1, 4, 0)), W), "h: found 0 frames"),
    (lambda: nn.conv1d(H, W, padding=True), "padding: found True"),
    (lambda: nn.conv1d(H, W, padding=(0, False)), "padding: found"),
    (lambda: nn.max_pool1d(H, 3, padding=2), "padding: found 2, needed at most half of width 3"),
    (lambda: nn.sum_squares_backward(np.zeros(3), H), r"dS: found shape \(3,\)"),
    (lambda: nn.mean_squares_backward(np.zeros(3), H), "dM: found shape"),
    (lambda: nn.l1_backward(np.zeros(1), H), r"dy: found shape \(1,\), needed \(\)"),
    (lambda: nn.l1_backward("2", H), "dy: found '2'"),
    (lambda: nn.squared_error_backward(np.zeros(H.shape, np.float32), H, H, reduction="none"),
     "dloss: found dtype float32"),
    (lambda: nn.adam_step({"w": H}, {"w": H}, {}), "state: found .*begin with adam_start"),
    (lambda: nn.adam_start({"w": np.zeros(2, int)}), r"params\['w'\]: found dtype int64")])
def test_bad_input_is_named(call, words):
    with pytest.raises(ValueError, match=words):
        call()


def test_without_a_bias_there_is_no_gradient_of_it():
    y = nn.conv1d(H, W)
    assert nn.conv1d_backward(y, H, W)[2] is None
    assert nn.conv_transpose1d_backward(H, y, W)[2] is None


def test_norm_of_infinity_is_infinity():
    np.testing.assert_array_equal(nn.norm(np.array([[np.inf, 1.0], [3.0, 4.0]])), [np.inf, 5.0])


def test_adam_takes_a_numpy_rate_without_widening():
    p = {"w": np.ones(2, np.float32)}
    q, state = nn.adam_step(p, p, nn.adam_start(p), rate=np.float64(0.1))
    assert q["w"].dtype == state["m"]["w"].dtype == np.float32


def test_parameters_may_have_any_name():
    p = {"ndim": np.ones(2), "real": np.ones(3)}
    q, _ = nn.adam_step(p, p, nn.adam_start(p))
    assert set(q) == set(p)
