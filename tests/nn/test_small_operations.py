"""relu, gram, norms, errors and Adam: by hand, by property, in their gradients, and at their kinks.
"""

from hypothesis import given, strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
import numpy as np
import pytest

from refimpl import nn

numbers = st.floats(-10, 10).map(lambda v: 0.0 if abs(v) < 1e-2 else v)
clips = arrays(float, array_shapes(min_dims=3, max_dims=3, min_side=1, max_side=5),
               elements=numbers)


def test_relu_by_hand():
    x = np.array([-1.0, 0.0, -0.0, 2.0, np.nan])
    np.testing.assert_array_equal(nn.relu(x), [0, 0, 0, 2, np.nan])
    np.testing.assert_array_equal(nn.relu_backward(np.full(5, 7.0), x), [0, 0, 0, 7, 0])


def test_relu_kink_is_bracketed():
    left, claimed, right = nn.check_kink(nn.relu, nn.relu_backward, np.zeros(3),
                                         direction=np.array([1.0, 0, 0]))
    assert claimed == 0 and sorted([left, right]) != [0, 0]


def test_gram_by_hand():
    h = np.array([[[1.0, 2], [3, 4]]])
    np.testing.assert_array_equal(nn.gram(h), [[[5, 11], [11, 25]]])
    np.testing.assert_array_equal(nn.gram_backward(np.array([[[0.0, 1], [0, 0]]]), h),
                                  [[[3, 4], [1, 2]]])


@given(clips)
def test_gram_is_symmetric_and_positive_semi_definite(h):
    G = nn.gram(h)
    np.testing.assert_array_equal(G, G.swapaxes(1, 2))
    assert (np.linalg.eigvalsh(G) >= -1e-9 * np.abs(G).max(initial=1)).all()
    # it forgets the order of the frames
    np.testing.assert_allclose(nn.gram(h[:, :, ::-1]), G, atol=1e-9)


@given(clips)
def test_gradients(h):
    nn.check_gradient(nn.relu, nn.relu_backward, np.where(h == 0, 1.0, h))
    nn.check_gradient(nn.gram, nn.gram_backward, h)
    nn.check_gradient(nn.sum_squares, nn.sum_squares_backward, h)
    nn.check_gradient(nn.mean_squares, nn.mean_squares_backward, h)
    nn.check_gradient(nn.norm, nn.norm_backward, np.where(np.abs(h) < 0.1, 1.0, h))
    nn.check_gradient(nn.l1, nn.l1_backward, np.where(h == 0, 1.0, h))


@pytest.mark.parametrize("reduction", ["none", "mean", "sum"])
@given(clips)
def test_error_gradients(reduction, x):
    y = np.cos(x) * 3 + 20.5
    for f, back in ((nn.squared_error, nn.squared_error_backward),
                    (nn.absolute_error, nn.absolute_error_backward)):
        nn.check_gradient(lambda a, b: f(a, b, reduction=reduction), lambda d, a,
                          b: back(d, a, b, reduction=reduction), x, y)


def test_norms_by_hand():
    r = np.array([[3.0, 4], [0, 0]])
    np.testing.assert_array_equal(nn.norm(r), [5, 0])
    np.testing.assert_array_equal(nn.sum_squares(r), [25, 0])
    np.testing.assert_array_equal(nn.mean_squares(r), [12.5, 0])
    np.testing.assert_allclose(nn.norm_backward(np.array([10.0, 10]), r), [[6, 8], [0, 0]])
    assert (nn.l1(r) == 7 and nn.squared_error(r, r + 2) == 4
            and nn.absolute_error(r, r + 2, reduction="sum") == 8)
    np.testing.assert_array_equal(nn.l1_backward(2.0, np.array([-3.0, 0, 5])), [-2, 0, 2])
    np.testing.assert_array_equal(nn.absolute_error_backward(1.0, np.array([1.0, 2]),
                                                             np.array([1.0, 0]),
                                                             reduction="sum")[0], [0, 1])


@pytest.mark.parametrize("size", [1e-200, 1e200])
def test_norm_neither_overflows_nor_vanishes(size):
    np.testing.assert_allclose(nn.norm(np.array([[3 * size, 4 * size]])), [5 * size])
    np.testing.assert_allclose(nn.norm_backward(np.ones(1), np.array([[3 * size, 4 * size]])),
                               [[0.6, 0.8]])


def test_every_clip_has_its_own_scale():
    r = np.array([[3e-200, 4e-200], [3e200, 4e200], [0, 0]])
    np.testing.assert_allclose(nn.norm(r), [5e-200, 5e200, 0])


def test_clips_of_one_number_and_of_none():
    np.testing.assert_array_equal(nn.norm(np.array([-3.0, 4])), [3, 4])
    np.testing.assert_array_equal(nn.norm_backward(np.array([2.0, 2]), np.array([-3.0, 4])),
                                  [-2, 2])
    np.testing.assert_array_equal(nn.norm(np.zeros((2, 0))), [0, 0])


def test_a_complex_upstream_number_keeps_its_digits():
    """As when a complex step passes through the backward itself."""
    a, third = np.array([2.0, -5.0]), 1 / 3 + 1j / 3
    np.testing.assert_array_equal(nn.l1_backward(third, a), [third, -third], strict=True)
    np.testing.assert_array_equal(nn.squared_error_backward(third, a, a - 1, reduction="sum")[0],
                                  [2 * third, 2 * third], strict=True)


def test_norm_kink_is_bracketed():
    direction = np.ones((1, 2, 3))
    left, claimed, right = nn.check_kink(nn.norm, nn.norm_backward, np.zeros((1, 2, 3)),
                                         direction=direction)
    assert claimed == 0 and left * right < 0


def test_contracts():
    h = np.random.default_rng(0).normal(size=(2, 3, 4))
    for name in ("relu", "gram", "sum_squares", "mean_squares", "norm"):
        nn.check_contract(getattr(nn, name), getattr(nn, f"{name}_backward"), h, single=True,
                          batched=(0,))
    nn.check_contract(nn.l1, nn.l1_backward, h, single=True)
    for name in ("squared_error", "absolute_error"):
        nn.check_contract(getattr(nn, name), getattr(nn, f"{name}_backward"), h, h + 1.5,
                          single=True)


@pytest.mark.parametrize("call, words", [
    (lambda: nn.relu(np.zeros(2, complex)), "x: found dtype complex128"),
    (lambda: nn.relu([1.0]), "x: found list"),
    (lambda: nn.relu_backward(np.zeros(3), np.zeros(2)), "dy: found shape"),
    (lambda: nn.gram(np.zeros((2, 3))), "h: found shape"),
    (lambda: nn.gram_backward(np.zeros((1, 2, 3)), np.zeros((1, 2, 4))), "dG: found shape"),
    (lambda: nn.norm(np.float64(1)), "r: found a scalar"),
    (lambda: nn.norm_backward(np.zeros(3), np.zeros((2, 2))), "dy: found shape"),
    (lambda: nn.l1(np.zeros(2, int)), "a: found dtype int64"),
    (lambda: nn.mean_squares(np.zeros((2, 0))), "at least one element"),
    (lambda: nn.squared_error(np.zeros(2), np.zeros(3)), "y: found shape"),
    (lambda: nn.squared_error(np.zeros(2), np.zeros(2), reduction="max"), "reduction: found 'max'"),
    (lambda: nn.squared_error(np.zeros(0), np.zeros(0)), "at least one element"),
    (lambda: nn.absolute_error_backward(np.zeros(1), np.zeros(2), np.zeros(2)),
     "dloss: found shape")])
def test_bad_input_is_named(call, words):
    with pytest.raises(ValueError, match=words):
        call()


def test_adam_by_hand():
    """With a constant gradient both corrected moments are g and g^2: every step is rate * sign(g).
    """
    p, s = {"w": np.array([1.0, -2.0])}, nn.adam_start({"w": np.zeros(2)})
    g = {"w": np.array([0.5, -3.0])}
    for _ in range(3):
        p, s = nn.adam_step(p, g, s, rate=0.1)
    np.testing.assert_allclose(p["w"], [1.0 - 0.3, -2.0 + 0.3], atol=1e-7)
    assert s["t"] == 3
    np.testing.assert_allclose(s["m"]["w"], g["w"] * (1 - 0.9 ** 3))
    np.testing.assert_allclose(s["v"]["w"], g["w"] ** 2 * (1 - 0.999 ** 3))


def test_adam_two_steps_by_hand():
    p, s = nn.adam_step({"w": np.array([0.0])}, {"w": np.array([1.0])},
                        nn.adam_start({"w": np.zeros(1)}))
    p, s = nn.adam_step(p, {"w": np.array([-2.0])}, s)
    m, v = 0.9 * 0.1 - 0.1 * 2, 0.999 * 0.001 + 0.001 * 4
    np.testing.assert_allclose(p["w"],
                               -1e-3 / (1 + 1e-8) - 1e-3 * (m / (1 - 0.81))
                               / (np.sqrt(v / (1 - 0.999 ** 2)) + 1e-8), rtol=1e-14)


def adam_after(variant, gradients):
    p, s = {"w": np.zeros_like(gradients[0])}, nn.adam_start({"w": np.zeros_like(gradients[0])})
    for g in gradients:
        p, s = nn.adam_step(p, {"w": g}, s, variant=variant)
    return p["w"]


def test_adam_variants_differ_where_gradients_are_tiny():
    gradients = [np.array([1e-9, 1.0, 0.0])] * 2
    plain, hat, uncorrected = (adam_after(v, gradients)
                               for v in ("kingma-ba", "epsilon-hat", "no-bias-correction"))
    assert (abs(plain[0] - hat[0]) > 0.1 * abs(plain[0])
            and abs(plain[1] - hat[1]) < 1e-6 * abs(plain[1]))
    assert abs(uncorrected[1]) > 2 * abs(plain[1])
    assert plain[2] == hat[2] == uncorrected[2] == 0


def test_adam_variants_by_hand():
    """Two steps with gradients of epsilon's size, epsilon large enough to be seen."""
    rate, a, b, e, g1, g2 = 0.1, 0.5, 0.75, 0.25, 2.0, -1.0
    # after both
    m, v = a * (1 - a) * g1 + (1 - a) * g2, b * (1 - b) * g1 ** 2 + (1 - b) * g2 ** 2
    steps = {
        "kingma-ba": g1 / (abs(g1) + e) + m / (1 - a ** 2) / (np.sqrt(v / (1 - b ** 2)) + e),
        "epsilon-hat": np.sqrt(1 - b) / (1 - a) * (1 - a) * g1 / (np.sqrt(1 - b) * abs(g1) + e)
        + np.sqrt(1 - b ** 2) / (1 - a ** 2) * m / (np.sqrt(v) + e),
        "no-bias-correction": (1 - a) * g1 / (np.sqrt(1 - b) * abs(g1) + e) + m / (np.sqrt(v) + e)}
    for variant, step in steps.items():
        p, s = {"w": np.array([5.0])}, nn.adam_start({"w": np.zeros(1)})
        for g in (g1, g2):
            p, s = nn.adam_step(p, {"w": np.array([g])}, s, rate=rate, beta1=a, beta2=b, epsilon=e,
                                variant=variant)
        np.testing.assert_allclose(p["w"], 5.0 - rate * step, rtol=1e-14)


def test_adam_without_memory_steps_by_the_sign_and_with_rate_0_not_at_all():
    p, g = {"w": np.array([1.0, -2.0])}, {"w": np.array([0.5, -3.0])}
    q, _ = nn.adam_step(p, g, nn.adam_start(p), rate=0.25, beta1=0, beta2=0, epsilon=0)
    np.testing.assert_array_equal(q["w"], [0.75, -1.75])
    np.testing.assert_array_equal(nn.adam_step(p, g, nn.adam_start(p), rate=0)[0]["w"], p["w"])


def test_adam_is_pure_and_keeps_precision():
    p, g = {"w": np.ones(2, np.float32)}, {"w": np.full(2, 0.5, np.float32)}
    s = nn.adam_start(p)
    q, t = nn.adam_step(p, g, s)
    assert s["t"] == 0 and not s["m"]["w"].any() and (p["w"] == 1).all()
    assert q["w"].dtype == t["m"]["w"].dtype == t["v"]["w"].dtype == np.float32


@pytest.mark.parametrize("change, words", [
    (dict(variant="amsgrad"), "variant: found 'amsgrad'"), (dict(rate=-1.0), "rate: found -1.0"),
    (dict(beta1=1.0), "beta1: found 1.0"),
    (dict(gradients={"v": np.zeros(2)}), r"gradients: found \['v'\]"),
    (dict(gradients={"w": np.zeros(3)}), r"gradients\['w'\]: found shape"),
    (dict(gradients={"w": np.zeros(2, np.float32)}), r"gradients\['w'\]: found dtype float32")])
def test_bad_input_of_adam_is_named(change, words):
    params = {"w": np.zeros(2)}
    arguments = {"gradients": {"w": np.zeros(2)}, **change}
    with pytest.raises(ValueError, match=words):
        nn.adam_step(params, arguments.pop("gradients"), nn.adam_start(params), **arguments)
