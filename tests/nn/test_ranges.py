"""Long sums, the ends of each precision, infinities at the border, and arguments that wrap around.

Expected values are worked by hand or come from exact arithmetic, never from the package.
"""

from fractions import Fraction

import numpy as np
import pytest

from refimpl import nn
from refimpl.holden2017 import losses
from refimpl.motion import rotation
from refimpl.fast import conv as tiled
from refimpl.torresani2006 import pca, regress

ORDERS = {"as made": lambda a: a,
          "channels last": lambda a: np.ascontiguousarray(a.swapaxes(1, 2)).swapaxes(1, 2),
          "Fortran": np.asfortranarray}


# Sums.

@pytest.mark.parametrize("order", ORDERS)
def test_a_bias_gradient_of_many_windows_is_right_in_every_memory_order(order):
    """592 windows of 240 frames, the paper's training set, of 0.1: running float32 sums were off by
    1.3e-3.
    """
    dy = ORDERS[order](np.full((592, 66, 240), 0.1, np.float32))
    x, w, b = (np.zeros((592, 1, 240), np.float32), np.zeros((66, 1, 1), np.float32),
               np.zeros(66, np.float32))
    wanted = float(np.float32(0.1)) * 592 * 240
    for convolution in (nn, tiled):
        db = convolution.conv1d_backward(dy, x, w, b)[2]
        assert db.dtype == np.float32 and np.abs(db / wanted - 1).max() <= 1e-6
    db = nn.conv_transpose1d_backward(dy, np.zeros((592, 1, 240), np.float32), w.swapaxes(0, 1),
                                      b)[2]
    assert np.abs(db / wanted - 1).max() <= 1e-6


def test_twenty_million_clips_of_one_frame():
    dy = np.ones((20_000_000, 1, 1), np.float32)
    db = nn.conv1d_backward(dy, np.zeros_like(dy), np.zeros((1, 1, 1), np.float32),
                            np.zeros(1, np.float32))[2]
    assert db[0] == 20_000_000


@pytest.mark.parametrize("function", [nn.sum_squares, nn.mean_squares, nn.norm])
def test_measures_of_many_elements_in_every_memory_order(function):
    r = np.full((2, 500, 800), 0.1, np.float32)
    square = Fraction(float(np.float32(0.1))) ** 2
    wanted = {nn.sum_squares: float(square * 400_000), nn.mean_squares: float(square),
              nn.norm: float(square * 400_000) ** 0.5}[function]
    for order in ORDERS.values():
        assert np.abs(function(order(r)) / wanted - 1).max() <= 1e-6


def test_windows_of_a_hundred_thousand_frames():
    x = np.full((1, 2, 200_000), 0.1, np.float32)
    for order in ORDERS.values():
        assert np.abs(nn.avg_pool1d(order(x), 100_000) / np.float32(0.1) - 1).max() <= 1e-6


# Ranges.

@pytest.mark.parametrize("dtype, large", [(np.float32, 3e38), (np.float64, 1.7e308)])
def test_a_gradient_of_a_norm_too_large_for_its_precision(dtype, large):
    r = np.full((1, 3), large, dtype)
    np.testing.assert_allclose(nn.norm_backward(np.ones(1, dtype), r), np.full((1, 3), 3 ** -0.5),
                               rtol=1e-6)
    tiny = np.full((1, 4), np.finfo(dtype).tiny, dtype)
    assert nn.norm(tiny)[0] == 2 * np.finfo(dtype).tiny


@pytest.mark.parametrize("dtype, value, square",
                         [(np.float32, 1.2e19, 1.44e38), (np.float64, 1.3e154, 1.69e308)])
def test_means_that_can_be_held_are_held(dtype, value, square):
    r, zero = np.full((1, 100), value, dtype), np.zeros((1, 100), dtype)
    np.testing.assert_allclose(nn.mean_squares(r), [square], rtol=1e-6)
    np.testing.assert_allclose(nn.squared_error(r, zero), square, rtol=1e-6)
    np.testing.assert_allclose(nn.squared_error_backward(1.0, r, zero)[0],
                               np.full((1, 100), 2 * value / 100), rtol=1e-6)
    most = np.full((1, 1, 4), np.finfo(dtype).max)
    assert ((nn.avg_pool1d(most) == most.max()).all()
            and nn.absolute_error(most, np.zeros_like(most)) == most.max())


@pytest.mark.parametrize("size", [1e-22, 1e25])
def test_the_direction_of_a_bone_of_any_length(size):
    motion = np.zeros((1, 66, 1), np.float32)
    joints = losses.joint_positions(motion)
    joints[0, 1:, 1, 0] = np.arange(1, 21) * np.float32(size)
    d = losses.bone_loss_backward(np.full(1, 1e-30, np.float32) if size > 1
                                  else np.ones(1, np.float32), motion,
                                  np.full(20, 1.0 if size < 1 else 0.0))
    assert np.isfinite(d).all() and np.abs(losses.joint_positions(d)[0, :, 1]).max() > 0
    assert np.abs(losses.joint_positions(d)[0, :, [0, 2]]).max() == 0


def test_adam_recovers_from_the_largest_gradients():
    """3e19 once, then ones: a running v that overflowed would hold the parameter for ever."""
    for g, dtype in ((3e19, np.float32), (4e20, np.float32), (1e155, np.float64)):
        params = {"w": np.zeros(1, dtype)}
        state = nn.adam_start(params)
        params, state = nn.adam_step(params, {"w": np.full(1, g, dtype)}, state)
        # the first step is the rate, whatever the size
        np.testing.assert_allclose(params["w"], [-1e-3], rtol=1e-5)
        for _ in range(3):
            params, state = nn.adam_step(params, {"w": np.ones(1, dtype)}, state)
        assert np.isfinite(state["v"]["w"]).all() and -0.0027 < params["w"][0] < -0.0025


@pytest.mark.parametrize("t", [-1, 0.5, 10 ** 400, True, None, "1", float("nan")])
def test_a_count_of_steps_that_is_none(t):
    params = {"w": np.zeros(1)}
    with pytest.raises(ValueError, match=r"^state\['t'\]: found"):
        nn.adam_step(params, {"w": np.ones(1)}, {**nn.adam_start(params), "t": t})


def test_small_whole_numbers_of_numpy_do_not_wrap():
    params = {"w": np.zeros(1)}
    _, state = nn.adam_step(params, {"w": np.ones(1)},
                            {**nn.adam_start(params), "t": np.uint8(255)})
    assert state["t"] == 256
    x = np.ones((1, 1, 400))
    assert nn.max_pool1d(x, np.uint64(2), padding=np.uint64(1)).shape == (1, 1, 201)
    assert nn.conv1d(x, np.ones((1, 1, 3)), dilation=np.int8(100)).shape == (1, 1, 400)


@pytest.mark.parametrize("value", [2 ** 63, 10 ** 30])
def test_whole_numbers_beyond_every_index_are_refused_by_name(value):
    x, w = np.ones((1, 1, 9)), np.ones((1, 1, 3))
    for name, call in (("width", lambda v: nn.max_pool1d(x, v)),
                       ("stride", lambda v: nn.max_pool1d(x, 2, stride=v)),
                       ("dilation", lambda v: nn.max_pool1d(x, 1, dilation=v)),
                       ("width", lambda v: nn.avg_depool1d(x, v)),
                       ("stride", lambda v: nn.conv1d(x, w, stride=v, padding=0)),
                       ("dilation", lambda v: nn.conv1d(x, w, dilation=v)),
                       ("padding", lambda v: nn.conv1d(x, w, padding=v)),
                       ("padding", lambda v: nn.conv1d(x, w, padding=(0, v)))):
        with pytest.raises(ValueError, match=f"^{name}: found"):
            call(value)


# Infinity and NaN at the border: padding is zeros like any others (`conventions`).

@pytest.mark.parametrize("bad", [np.inf, -np.inf, np.nan])
@pytest.mark.parametrize("width", [3, 9])
@np.errstate(invalid="ignore")
def test_one_rule_for_infinite_filters_at_the_border(bad, width):
    from refimpl.conformance import definitions_nn as definitions
    x, w = np.arange(1.0, 13.0)[None, None], np.ones((1, 1, width))
    w[0, 0, 0] = bad
    forms = [f(x, w, np.zeros(1)) for f in (nn.conv1d, tiled.conv1d, definitions.conv1d)]
    assert np.isnan(forms[0][0, 0, :width // 2]).all()           # 0 times infinity
    assert (forms[0][0, 0, width // 2:] == bad).all() or np.isnan(bad)
    for other in forms[1:]:
        np.testing.assert_array_equal(other, forms[0])
    dy = np.ones_like(x)
    for ours, theirs in zip(nn.conv1d_backward(dy, x, w), tiled.conv1d_backward(dy, x, w)):
        np.testing.assert_array_equal(ours, theirs)


def test_one_frame_that_is_no_number_stays_in_its_filters_reach():
    """The tiles would spread it over all of theirs: the direct form takes such arrays."""
    rng = np.random.default_rng(0)
    x, w = rng.standard_normal((2, 3, 100)), rng.standard_normal((4, 3, 9))
    x[0, 1, 50] = np.nan
    y = tiled.conv1d(x, w)
    assert np.isnan(y[0, :, 46:55]).all() and np.isnan(y).sum() == 4 * 9
    np.testing.assert_array_equal(y, nn.conv1d(x, w))


def test_how_loud_frames_drown_quiet_ones_is_as_the_docstring_of_tiled_says():
    rng = np.random.default_rng(1)
    for ratio, least, most in ((1e2, 1e-6, 1e-4), (1e3, 1e-5, 1e-3), (1e6, 1e-2, 1.0)):
        x = rng.standard_normal((1, 8, 64)).astype(np.float32)
        w = rng.standard_normal((8, 8, 25)).astype(np.float32)
        x[..., 32:] *= np.float32(ratio)
        wanted = nn.conv1d(x.astype(float), w.astype(float))
        # no loud frame within their filters' reach
        quiet = wanted[..., :18]
        off = [np.abs(f(x, w)[..., :18] - quiet).max() / np.abs(quiet).max()
               for f in (tiled.conv1d, nn.conv1d)]
        assert least < off[0] < most and off[1] < 1e-6


# The 2006 system's algebra.

def test_the_gaussian_kernel_of_points_far_from_zero():
    def k(a, b, gamma=1.0):
        return regress.gaussian_kernel(np.array([[a]]), np.array([[b]]), gamma)[0, 0]
    assert k(1e8, 1e8 + 1) == pytest.approx(np.exp(-1), rel=1e-15)
    assert k(1e160, 1e160) == 1 and k(1e200, -1e200) == 0
    near = regress.squared_distances(np.array([[1.0]]), np.array([[1.0 + 2 ** -30]]))[0, 0]
    assert near == 2.0 ** -60
    for gamma in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(regress.RegressError, match="^gamma: found"):
            k(0.0, 1.0, gamma)


def test_the_sign_of_a_component_at_a_tie_is_no_matter_of_rounding():
    signs = set()
    for s in np.random.default_rng(0).uniform(0.1, 10, 400):
        fitted = pca.fit_pca([s * np.array([[0.0, 0], [1, -1], [2, -2]]) * (k + 1) + 0.1
                              for k in range(3)], 1, 3)
        signs.add(tuple(np.sign(np.round(fitted.basis[0], 6))))
    assert len(signs) == 1


def test_components_that_are_rounding_noise_are_refused():
    rng = np.random.default_rng(0)
    sequences = [rng.standard_normal((5, 2)) for _ in range(3)]
    assert pca.fit_pca(sequences, 2, 5).basis.shape == (2, 10)
    # copies add no direction
    for few in (sequences, [*sequences, sequences[0], sequences[1]]):
        with pytest.raises(regress.RegressError, match="^components: found 3, needed 1 to 2"):
            pca.fit_pca(few, 3, 5)


def test_ridge_of_columns_that_are_large_or_nearly_equal():
    Z = np.array([[1 + 1e-9, 1 - 1e-9], [1, 1], [1 - 1e-9, 1 + 1e-9]])
    Y, ridge = np.array([1.0, 2.0, 3.0]), Fraction(1, 10 ** 12)
    z, y = [[Fraction(float(v)) for v in row] for row in Z], [Fraction(v) for v in (1, 2, 3)]
    a, b, d = (sum(r[i] * r[j] for r in z) + (ridge if i == j else 0) for i,
               j in ((0, 0), (0, 1), (1, 1)))
    u, v = (sum(r[i] * t for r, t in zip(z, y)) for i in (0, 1))
    wanted = [float((d * u - b * v) / (a * d - b * b)), float((a * v - b * u) / (a * d - b * b))]
    # the normal equations: 1e-3
    np.testing.assert_allclose(regress.linear_ridge(Z, Y, 1e-12), wanted, rtol=1e-5)
    large = 1e10 * np.array([[1.0, 1.0], [2.0, 2.0], [3.0, 3.0]])
    assert np.isfinite(regress.linear_ridge(large, Y, 1e-3)).all()
    with pytest.raises(regress.RegressError,
                       match="^ridge: found lambda 1e-10 beside kernel values"):
        regress.kernel_ridge(np.full((2, 2), 1e10), np.ones(2), 1e-10)


def test_rotation_vectors_of_any_length():
    for v in ([1e200, 0, 0], [1e-200, 1e-300, 0], [3e150, -4e160, 1e155]):
        R = rotation.exp_map(v)
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-14)
    for v in ([np.inf, 0, 0], [np.nan, 0, 0], [1.7e308, 1.7e308, 0]):
        with pytest.raises(ValueError, match="^v: found"):
            rotation.exp_map(v)
