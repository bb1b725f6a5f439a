"""The instruments: each against derivatives known in closed form, and honest about what it cannot
measure.
"""

import numpy as np
import pytest

from refimpl import nn
from refimpl.gradcheck import derivative

ONE = np.array(1.0)


def through(f, x=0.7, v=1.0):
    return derivative.line(f, (np.array(x),), {0: np.array(v)})


def test_line_leaves_the_other_inputs():
    along = derivative.line(lambda a, b, c: (a, b, c), (np.array(1.0), None, np.array(5.0)),
                            {2: np.array(2.0)})
    assert along(3.0) == (1.0, None, 11.0)


@pytest.mark.parametrize("f, slope",
                         [(np.sin, np.cos(0.7)), (np.exp, np.exp(0.7)),
                          (lambda x: x ** 3, 3 * 0.49), (np.sqrt, 0.5 / np.sqrt(0.7))])
def test_complex_step_and_central_differences(f, slope):
    np.testing.assert_allclose(derivative.complex_step(through(f), ONE), slope, rtol=1e-15)
    found, doubt = derivative.extrapolate(through(f), ONE)
    np.testing.assert_allclose(found, slope, rtol=1e-11)
    assert abs(found - slope) <= 10 * doubt < 1e-10


def test_complex_step_gives_up_where_complex_numbers_do():
    assert derivative.complex_step(through(np.abs), ONE) is None             # real again
    assert derivative.complex_step(through(nn.relu, [0.7]), ONE) is None     # refused

    def into_real(x):
        y = np.zeros(1)
        y[:] = x                                                             # NumPy only warns
        return y
    assert derivative.complex_step(through(into_real), ONE) is None


@pytest.mark.parametrize("f",
                         [lambda x: x * np.abs(x), lambda x: x * np.conj(x),
                          lambda x: x + np.real(x) ** 2])
def test_complex_functions_that_are_not_analytic_are_told_apart(f):
    assert not derivative.is_analytic(through(f), ONE)
    assert derivative.is_analytic(through(np.sin), ONE)


def test_a_function_that_keeps_complex_numbers_but_is_not_analytic_is_still_checked():
    x = np.random.default_rng(0).normal(size=(2, 3)) + 5
    nn.check_gradient(lambda a: a * np.abs(a), lambda dy, a: 2 * dy * np.abs(a), x, contract=False)
    with pytest.raises(nn.GradientError):
        nn.check_gradient(lambda a: a * np.abs(a), lambda dy, a: 2.000001 * dy * np.abs(a), x,
                          contract=False)


def test_rounding_of_a_large_value_is_doubted():
    """A slope of 1 on a value of 1e9 cannot be seen to 1e-8, and the doubt says so."""
    found, doubt = derivative.extrapolate(through(lambda x: x + 1e9), ONE)
    assert abs(found - 1) <= 10 * doubt and doubt > 1e-6
    # no difference at all: certain only in appearance
    found, doubt = derivative.extrapolate(through(lambda x: x + 1e15), ONE)
    assert found == 0 and doubt > 1


def test_steps_suit_the_size_of_the_input():
    for size in (1e-6, 1.0, 1e6):
        x = size * (2 + np.random.default_rng(1).random((2, 3)))
        nn.check_gradient(lambda a: np.log(np.abs(a)), lambda dy, a: dy / a, x, contract=False)


def test_remainder_falls_as_the_square_only_for_the_right_derivative():
    assert derivative.remainder_slope(through(np.sin), ONE,
                                      np.cos(0.7)) == pytest.approx(2, abs=0.01)
    assert derivative.remainder_slope(through(np.sin), ONE,
                                      np.cos(0.7) + 0.1) == pytest.approx(1, abs=0.05)
    assert derivative.remainder_slope(through(lambda x: 3 * x), ONE, 3.0) is None


def test_one_sided_derivatives():
    np.testing.assert_allclose(derivative.one_sided(through(np.abs, 0.0), ONE), (-1, 1), rtol=1e-9)
    np.testing.assert_allclose(derivative.one_sided(through(np.sin), ONE), (np.cos(0.7),) * 2,
                               rtol=1e-7)


def test_one_sided_derivatives_err_by_the_square_of_the_step():
    h, second, third = 1e-3, -np.sin(0.7), -np.cos(0.7)
    np.testing.assert_allclose(np.subtract(derivative.one_sided(through(np.sin), ONE, h=h),
                                           np.cos(0.7)), -h ** 2 / 12 * third * np.ones(2),
                               atol=h ** 3 * abs(second))


def test_a_claim_outside_the_bracket_is_refused():
    with pytest.raises(nn.GradientError, match="at the kink"):
        nn.check_kink(nn.relu, lambda dy, x: 1.5 * dy, np.zeros(1), direction=np.ones(1))
    with pytest.raises(nn.GradientError, match="at the kink"):
        nn.check_kink(nn.norm, lambda dy, r: 2 * dy[:, None] * np.ones(r.shape), np.zeros((1, 2)),
                      direction=np.array([[1.0, 0]]))


@pytest.mark.parametrize("f, backward", [(nn.l1, nn.l1_backward)])
def test_absolute_value_at_zero_is_bracketed_and_zero(f, backward):
    left, claimed, right = nn.check_kink(f, backward, np.zeros(2), direction=np.array([1.0, 0]))
    assert claimed == 0 and left * right < 0


def test_near_a_kink_the_right_gradient_passes_and_a_wrong_one_does_not():
    x = np.array([[3e-5, -2e-4, 1.0, -1.0]])                     # kinks within the usual steps
    nn.check_gradient(nn.relu, nn.relu_backward, x)
    with pytest.raises(nn.GradientError):
        nn.check_gradient(nn.relu, lambda dy, x: np.where(x > 1e-4, dy, 0.0), x)
