"""The slope to both sides of a point, beside kinks, under noise, at any size; and what is said
where it cannot be told.
"""

import numpy as np
import pytest

from refimpl.gradcheck import (GradientError, UndecidedError, check_direction, check_gradient,
                               derivative)
from refimpl.gradcheck.slope import CERTAIN, Slope, noise, noise_of, slope_at

ONE = np.array(1.0)


def slope(f, x, v=1.0, size=1.0):
    return slope_at(derivative.line(f, (np.array(x),), {0: np.array(v)}), ONE, size)


def relu(x):
    return np.maximum(x, 0.0)


@pytest.mark.parametrize("beside", [1e-3, 1e-5, 1e-7, 1e-9, 1e-11, -1e-11, -1e-9, -1e-3])
def test_beside_a_kink_the_slope_is_that_of_the_own_side(beside):
    found = slope(relu, beside)
    assert not found.kink and not found.why
    assert abs(found.value - (beside > 0)) <= CERTAIN * found.error < 1e-2


@pytest.mark.parametrize("f, left, right", [
    (relu, 0, 1), (np.abs, -1, 1), (lambda x: np.abs(x) + np.sin(3 * x), 2, 4),
    (lambda x: np.where(x < 0, np.exp(x), 1 + 5 * x), 1, 5)])
def test_at_a_kink_both_sides_are_known(f, left, right):
    found = slope(f, 0.0)
    np.testing.assert_allclose(found[:2], [left, right], atol=1e-9)
    assert found.kink and found.distance((left + right) / 2) == 0
    assert found.distance(right + 1.0) == pytest.approx(1.0, abs=1e-9)
    assert found.distance(np.nan) == np.inf


@pytest.mark.parametrize("f, x, v, needed", [
    (lambda x: np.sin(1e5 * x), 0.3, 1.0, 1e5 * np.cos(3e4)),
    (np.sqrt, 1e-12, 1e-12, 5e5), (np.log, 1e-9, 1e-9, 1e9),
    (lambda x: np.abs(x ** 3), 1e-90, 1e-90, 3e-180),
    (lambda x: 1e9 + x, 0.3, 1.0, 1.0), (np.arccos, 0.999999, 1.0, -707.1069579492236)])
def test_steps_of_every_size_are_tried(f, x, v, needed):
    found = slope(f, x, v, abs(needed * v))
    assert abs(found.value - needed * v) <= CERTAIN * found.error + 1e-12 * abs(needed * v)
    assert CERTAIN * found.error < 1e-3 * abs(needed * v)


def test_a_small_kink_among_many_smooth_terms_is_seen():
    found = slope(lambda x: 1e4 * np.sin(x) + np.abs(x), 0.0, size=1e4)
    np.testing.assert_allclose(found[:2], [1e4 - 1, 1e4 + 1], rtol=1e-9)


def test_the_noise_of_rounding_is_found_and_that_of_curvature_is_none():
    rng = np.random.default_rng(0)
    assert 0.3 < noise_of(rng.standard_normal((8, 200))).mean() < 1.2
    assert noise_of(np.arange(8.0) ** 3) < 1e-12 and noise_of(np.exp(1e-3 * np.arange(8.0))) < 1e-13
    assert noise_of(1e-300 * rng.standard_normal(8)) > 1e-301

    def single(h):
        return float(np.sin(np.float32(0.7 + h))), 0.0
    assert 1e-9 < noise(single) < 1e-6 and noise(lambda h: (np.sin(0.7 + h), 0.0)) < 1e-15


@pytest.mark.parametrize("f, x, why", [
    (np.sqrt, 0.0, "without bound"), (lambda x: np.round(x, 4), 0.31234, "in steps"),
    (lambda x: x * np.nan, 1.0, "no finite values")])
def test_what_has_no_slope_says_why(f, x, why):
    assert why in slope(f, x).why


def test_where_f_has_one_side_alone_that_side_counts():
    found = slope(lambda x: np.where(x < 0, np.nan, 2 * x + x ** 2), 0.0)
    assert np.isnan(found.left) and found.value == pytest.approx(2, abs=1e-8)
    assert not found.kink and found.distance(2.0) < 1e-8


@pytest.mark.parametrize("half", [0.0, 0.25, 1.0])
def test_every_value_between_the_sides_is_right_and_none_outside(half):
    x = np.array([1.0, 0.0, -2.0])
    check_gradient(relu, lambda dy, x: dy * np.where(x == 0, half, x > 0), x)
    for outside in (1.001, -0.001, 7.0):
        with pytest.raises(GradientError, match=r"^input 0\[1\]: found .* needed a value between "):
            check_gradient(relu, lambda dy, x: dy * np.where(x == 0, outside, x > 0), x)


def test_wrong_within_a_hair_of_the_kink_is_wrong():
    x = np.array([1.0, 1e-9, -2.0])
    with pytest.raises(GradientError, match=r"^input 0\[1\]: found -?0 ?"):
        check_gradient(relu, lambda dy, x: dy * (x > 1e-7), x)


@pytest.mark.parametrize("f, backward", [
    (lambda x: np.sin(x.astype(np.float32)).astype(float), lambda dy, x: dy * np.cos(x)),
    (lambda x: np.abs(1e12 + x ** 2), lambda dy, x: 2 * dy * x)])
def test_too_few_digits_are_undecided_and_a_gross_fault_is_still_wrong(f, backward):
    x = np.array([0.3, 0.7, 1.1])
    with pytest.raises(UndecidedError, match="which is undecided: "):
        check_gradient(f, backward, x)
    report = check_gradient(f, backward, x, report=True)
    assert not report.failures and report.undecided and not report.passed
    assert "UNDECIDED input 0[" in str(report)
    with pytest.raises(GradientError) as caught:
        check_gradient(f, lambda dy, x: 1e6 * backward(dy, x), x)
    assert not isinstance(caught.value, UndecidedError)


def test_a_line_over_kinks_is_undecided():
    """Between its sides lie the right sums, but not only they."""
    x = np.zeros(6)
    with pytest.raises(UndecidedError):
        check_direction(np.abs, lambda dy, x: dy * 5.0, x)


@pytest.mark.parametrize("backward, where", [
    (lambda dy, x: 3 * dy * x * np.abs(x), "for inputs of the other sign"),
    (lambda dy, x: 3 * dy * x ** 2 * (1 + (len(x) == 1)), "for the first clip alone")])
def test_other_signs_and_a_single_clip_are_looked_at(backward, where):
    x = np.random.default_rng(0).random((3, 2)) + 0.1
    with pytest.raises(GradientError, match=f"^{where}, along a random line: found "):
        check_gradient(lambda x: x ** 3, backward, x)
    check_gradient(lambda x: x ** 3, backward, x, contract=False)


def test_what_f_does_not_take_is_not_held_against_it():
    def positive(x):
        if not (x > 0).all() or len(x) < 2:
            raise ValueError("needed at least two positive numbers")
        return np.log(x)
    report = check_gradient(positive, lambda dy, x: dy / x, np.array([[0.1], [1e-9]]), report=True)
    assert report.passed and report.notes == ()
    notes = check_gradient(np.sin, lambda dy, x: dy * np.cos(x), np.ones((2, 2)),
                           report=True).notes
    assert notes == ("a line through inputs of the other sign agrees",
                     "a line through the first clip alone agrees")


def test_a_slope_with_nothing_known():
    assert np.isnan(Slope(np.nan, np.nan, np.inf).value)
    assert Slope(np.nan, np.nan, np.inf).distance(1.0) == np.inf
