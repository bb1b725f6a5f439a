"""The checker's numbers and words: how much is allowed, what is looked at, and what a failure says.
"""

import numpy as np
import pytest

from refimpl import gradcheck, nn
from refimpl.gradcheck import derivative
from refimpl.gradcheck.report import Report, Row
from refimpl.gradcheck.errors import describe

X = np.array([[1.0, -2.0, 0.5], [3.0, 0.25, -4.0]])
SLOPE = 3.0


def analytic(x):
    return SLOPE * x


def real(x):
    """The same, by a way that drops imaginary parts: for central differences."""
    return SLOPE * np.sign(x.real) * np.abs(x)


# the instrument, and what it must at least tell: relative to the element
INSTRUMENTS = [(analytic, "complex step", 2e-13), (real, "central differences", 1e-10)]


def wrong_by(off, place=None, slope=SLOPE):
    """A gradient of which one element, the largest unless given, is off by this part of the
    largest.
    """
    def backward(dy, x):
        dx = slope * dy
        at = np.unravel_index(np.argmax(np.abs(dx)), x.shape) if place is None else place
        dx[at] += off * np.abs(dx).max()
        return dx
    return backward


def failure(f, backward, *inputs, check=nn.check_gradient, **options):
    with pytest.raises(nn.GradientError) as caught:
        check(f, backward, *inputs, **options)
    return str(caught.value)


def rows(f, backward, *inputs, **options):
    return nn.check_gradient(f, backward, *inputs, report=True, contract=False, **options).rows


# how much is allowed


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("f, instrument, told", INSTRUMENTS)
def test_each_element_has_a_bound_of_its_own(f, instrument, told, scale):
    """The smallest of six, a millionth of the largest, counts as much as it does."""
    sizes = scale * np.array([[1.0, 10.0, 1e3], [1e-3, 0.1, 0.01]])

    def scaled(x):
        return sizes * f(x)
    for place in np.ndindex(X.shape):
        def backward(dy, x, off=0.0):
            dx = SLOPE * sizes * dy
            dx[place] *= 1 + off
            return dx
        nn.check_gradient(scaled, lambda dy, x: backward(dy, x, 3e-15), X, contract=False)
        said = failure(scaled, lambda dy, x: backward(dy, x, told), X, contract=False)
        assert instrument in said and said.startswith(f"input 0[{place[0]}, {place[1]}]: found ")


@pytest.mark.parametrize("f", [analytic, real])
def test_nothing_is_allowed_where_all_is_zero(f):
    nn.check_gradient(lambda x: 0 * f(x), lambda dy, x: 0 * dy, X)
    failure(lambda x: 0 * f(x), lambda dy, x: 0 * dy + 1e-290, X, contract=False)


@pytest.mark.parametrize("f", [analytic, real])
def test_an_input_without_elements_has_the_gradient_without_elements(f):
    empty = np.zeros((0, 3))
    nn.check_gradient(f, lambda dy, x: SLOPE * dy, empty)
    row, = rows(f, lambda dy, x: SLOPE * dy, empty)
    assert (row.exact and row.approximate and row.difference == 0
            and row.checked_by.endswith(", 0 of 0 elements"))


@pytest.mark.parametrize("offset, off, verdict",
                         [(2.0 ** 17, 1e-11, None), (2.0 ** 17, 3e-7, nn.GradientError),
                          (1e13, 0.0, gradcheck.UndecidedError),
                          (2.0 ** 33, 0.1, nn.GradientError)])
def test_what_rounding_hides_is_undecided_and_what_it_cannot_hide_is_wrong(offset, off, verdict):
    """A large value's digits are lost to the difference: with 2^17 some 1e-10 cannot be told, with
    1e13 nearly all.
    """
    def check():
        nn.check_gradient(lambda a: np.abs(a) + offset, lambda dy, a: dy * (1 + off),
                          np.array([1.0]), contract=False)
    if verdict is None:
        check()
        return
    with pytest.raises(nn.GradientError) as caught:
        check()
    assert type(caught.value) is verdict


@pytest.mark.parametrize("scale", [1e-8, 1.0, 1e8])
def test_a_kink_nearby_is_stepped_over_at_any_scale(scale):
    x = np.array([[3e-5, -2e-4, 1.0, -1.0]])
    nn.check_gradient(lambda a: scale * nn.relu(a), lambda dy, a: scale * nn.relu_backward(dy, a),
                      x)
    with pytest.raises(nn.GradientError):
        nn.check_gradient(lambda a: scale * nn.relu(a), lambda dy,
                          a: scale * np.where(a > 1e-4, dy, 0.0), x)


def test_inputs_may_be_zero_infinite_nowhere_used_or_of_any_size():
    nn.check_gradient(np.sin, lambda dy, x: dy * np.cos(x), np.zeros(3))
    nn.check_gradient(lambda x: np.abs(x + 3), lambda dy, x: dy * np.sign(x + 3), np.zeros(3))
    nn.check_gradient(lambda x: np.sin(x * 1e9), lambda dy, x: dy * 1e9 * np.cos(x * 1e9), X * 1e-9)
    nn.check_gradient(lambda x: np.abs(np.sin(x * 1e9) + 3), lambda dy,
                      x: dy * 1e9 * np.cos(x * 1e9), X * 1e-9)


# along random lines


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_along_a_line_what_rounding_leaves_and_what_one_allows_beyond_it(scale):
    """One term in one input: the derivative is that term."""
    x = np.array([2.0])

    def check(off, **options):
        nn.check_direction(lambda a: scale * a, lambda dy, a: scale * dy * (1 + off), x, **options)
    for tolerance, passes, fails in ((0.0, 1e-13, 1e-9), (1e-8, 0.9e-8, 1.1e-8), (0.1, 0.09, 0.12)):
        check(passes, tolerance=tolerance)
        with pytest.raises(nn.GradientError,
                           match=r"^along random direction 0: found .*; see it again with seed=0$"):
            check(fails, tolerance=tolerance)


def test_terms_that_cancel_along_a_line_still_count():
    """x - x has the derivative 0, but its two terms their size: twelve digits of it are allowed."""
    x = np.full(2, 1.0)
    recorded = []

    def f(a, b):
        recorded.append((a - x) / derivative.STEPS[0])
        return a - b

    def off(by):
        return lambda dy, a, b: (dy * (1 + by), -dy)
    nn.check_direction(f, off(0.0), x, x, directions=1)
    v = max(recorded, key=lambda r: np.abs(r).max())
    assert np.abs(v).max() > 0.1
    with pytest.raises(nn.GradientError, match="along random direction 0"):
        nn.check_direction(f, off(1e-6), x, x, directions=1)


def test_two_lines_unless_told_otherwise_each_a_new_one():
    def lines(**options):
        steps = []

        def f(x):
            steps.append(x - X)
            return np.sin(x)
        nn.check_direction(f, lambda dy, x: dy * np.cos(x), X, **options)
        return {tuple(np.round(np.ravel(step) / np.abs(step).max() * np.sign(step.flat[0]), 6))
                for step in steps if step.any()}
    assert len(lines()) == len(lines(directions=2)) == 2 and len(lines(directions=3)) == 3
    assert lines() == lines(seed=0) != lines(seed=1)


def test_a_line_goes_through_every_input_in_steps_of_its_size():
    """Three inputs of different size: each moves by some 4e-3 of its root of the mean square, and
    all at once; beside the one long step that tells which outputs never move.
    """
    sizes, moved = (1e-3, 1.0, 1e3), []

    def f(*inputs):
        moved.append([np.sqrt(np.mean((x - size) ** 2)) / size for x, size in zip(inputs, sizes)])
        return sum(x / size for x, size in zip(inputs, sizes))
    nn.check_direction(f, lambda dy, *inputs: tuple(dy / size for size in sizes),
                       *(np.full(1000, size) for size in sizes))
    np.testing.assert_allclose(max(m for m in moved if max(m) < 1e6), [4e-3] * 3, rtol=0.1)


def test_the_rate_is_named():
    found = failure(np.sin, lambda dy, x: 1.1 * dy * np.cos(x), np.array([0.7, 0.3]),
                    check=nn.check_direction, seed=5)
    assert found.endswith(" by central differences; the Taylor remainder falls as h^1.00, needed "
                          "h^2; see it again with seed=5")


# what is looked at


@pytest.mark.parametrize("f, instrument, tolerance", INSTRUMENTS)
def test_the_worst_element_of_a_large_input_is_found_wherever_it_is(f, instrument, tolerance):
    x = np.linspace(1.0, 2.0, 40).reshape(5, 8)
    for place in np.ndindex(x.shape):
        for off in (0.01, np.nan):
            found = failure(f, wrong_by(off, place), x, elements=3, names=["x"], contract=False)
            assert (found.startswith(f"x[{place[0]}, {place[1]}]: found ")
                    and f"by {instrument}; 1 of " in found)


def test_the_complex_step_finds_a_small_fault_under_large_values():
    """Of 3 x + 1e6 central differences know the slope to some 1e-7, the complex step to all digits.
    """
    x = np.linspace(1.0, 2.0, 40)
    for place in range(40):
        assert failure(lambda a: analytic(a) + 1e6, wrong_by(3e-8, place), x, elements=3,
                       contract=False).startswith(f"input 0[{place}]: found ")


@pytest.mark.parametrize("f, instrument, told", INSTRUMENTS)
def test_many_elements_are_sampled_and_one_more_is_looked_for_where_their_line_disagrees(
    f, instrument, told):
    x = np.linspace(1.0, 2.0, 5)

    def checked(off, elements):
        def backward(dy, x):
            dx = np.zeros_like(x)
            dx[2] = SLOPE * dy * (1 + off)
            return dx
        row, = rows(lambda a: f(a)[2], backward, x, elements=elements)
        return row.checked_by
    for off, disagrees in ((0.0, 0), (1e-15, 0), (10 * told, 1), (0.3, 1)):
        # the sample of one is another
        assert checked(off, 1) == f"{instrument}, {1 + disagrees} of 5 elements"
        assert checked(off, 5) == checked(off, 6) == f"{instrument}, 5 of 5 elements"


def test_two_thousand_elements_are_all_checked_and_two_hundred_of_more_no_one_twice():
    def probed(size):
        seen = []

        def f(x):
            seen.append(np.flatnonzero(np.imag(x)))
            return analytic(x)
        row, = rows(f, lambda dy, x: SLOPE * dy, np.ones(size))
        return row.checked_by, len({int(s[0]) for s in seen if len(s) == 1})
    assert probed(2000) == ("complex step, 2000 of 2000 elements", 2000)
    assert probed(2001) == ("complex step, 200 of 2001 elements", 200)


def test_the_same_seed_looks_at_the_same_elements():
    def table(**options):
        x = np.linspace(1, 2, 300)
        return str(nn.check_gradient(np.sin, lambda dy, x: dy * np.cos(x) * (1 + 1e-13 * x), x,
                                     report=True, elements=100, contract=False, **options))
    assert table() == table(seed=0) != table(seed=1)


def test_the_functions_get_copies_to_play_with():
    """What a backward does to its arguments is the contract's business; the caller's arrays stay as
    they are.
    """
    x = X.copy()

    def backward(dy, x):
        dx = SLOPE * dy
        x[...] = dy[...] = 0
        return dx
    nn.check_gradient(analytic, backward, x, contract=False)
    np.testing.assert_array_equal(x, X)


# what a failure says


@pytest.mark.parametrize("f, instrument, tolerance", INSTRUMENTS)
def test_the_message_shows_the_fault_and_how_to_see_it_again(f, instrument, tolerance):
    backward, seed = wrong_by(0.01, (1, 2)), 4
    dy = np.random.default_rng(seed).standard_normal(X.shape)
    claimed = backward(dy, X)
    needed = SLOPE * dy[1, 2]
    found = failure(f, backward, X, names=("weights",), seed=seed, contract=False)
    first, *code = found.split("\n")
    assert (first.startswith("weights[1, 2]: found ")
            and first.endswith(f") by {instrument}; 1 of 6 elements are wrong."))
    numbers = [float(first.split(word)[1].split()[0].rstrip(",)"))
               for word in ("found ", "needed ", "difference ", "allowed ")]
    assert 0 < numbers.pop() < tolerance * abs(needed)
    np.testing.assert_allclose(numbers, [claimed[1, 2], needed, abs(claimed[1, 2] - needed)],
                               rtol=1e-3)                        # the difference in three digits
    np.testing.assert_allclose(numbers[:2], [claimed[1, 2], needed], rtol=1e-10)
    assert code[0] == "See it again, with f, f_backward and inputs as they are now:"
    assert code[1] == "    dy = np.random.default_rng(4).standard_normal(np.shape(f(*inputs)))"
    assert (code[2].startswith(
        "    gradients = f_backward(dy, *inputs)      # the one of weights at [1, 2] should be ")
            and len(code) == 3)
    assert float(code[2].split("should be ")[1]) == numbers[1]
    scope = dict(np=np, f=f, f_backward=backward, inputs=(X,))
    exec("\n".join(line.strip() for line in code[1:]), scope)    # and it is so
    assert scope["gradients"][1, 2] == numbers[0]


def test_the_worst_of_several_is_named_and_nan_is_worst():
    def two(first, second):
        def backward(dy, x):
            dx = SLOPE * dy
            dx[0, 0] += first
            dx[1, 1] += second
            return dx
        return backward
    for f, _, _ in INSTRUMENTS:
        assert (failure(f, two(1e-3, 2e-3), X).startswith("input 0[1, 1]: ")
                and "; 2 of 6 elements are wrong." in failure(f, two(1e-3, 2e-3), X))
        assert failure(f, two(2e-3, 1e-3), X).startswith("input 0[0, 0]: ")
        assert failure(f, two(np.nan, 5.0), X).startswith("input 0[0, 0]: found nan")
        assert failure(f, two(5.0, np.nan), X).startswith("input 0[1, 1]: found nan")


def test_the_description_of_a_difference():
    assert describe(1.25, 1.5, 1e-12) == "found 1.25, needed 1.5 (difference 0.25, allowed 1e-12)"
    assert (describe(np.float32(2.0), -1, 0.125)
            == "found 2, needed -1 (difference 3, allowed 0.125)")


def test_the_report_as_it_is_printed():
    rows = (Row("x", True, True, 0.0, "complex step, 6 of 6 elements"),
            Row("weights", False, True, 1.5e-13, "complex step"))
    assert str(Report(rows, ())) == """\
name    | exact | approximate | max difference | checked by
x       | True  | True        |      0.000e+00 | complex step, 6 of 6 elements
weights | False | True        |      1.500e-13 | complex step
passed"""
    assert str(Report(rows[:1], ("x[1]: found so", "also this"))) == """\
name | exact | approximate | max difference | checked by
x    | True  | True        |      0.000e+00 | complex step, 6 of 6 elements
FAILED x[1]: found so
FAILED also this"""


def test_the_rows_of_the_report():
    dy = np.random.default_rng(0).standard_normal(X.shape)
    exact, = rows(lambda x: x + 0, lambda dy, x: +dy, X)
    assert (exact.name, exact.exact, exact.approximate, exact.difference, exact.checked_by) == \
        ("input 0", True, True, 0.0, "complex step, 6 of 6 elements")
    off, = rows(lambda x: x + 0, lambda dy, x: dy + 2.0 ** -60, X, names=["x"])
    assert ((off.name, off.exact, off.approximate) == ("x", bool((dy + 2.0 ** -60 == dy).all()),
                                                       True))
    wrong, = rows(lambda x: x + 0, lambda dy, x: dy + 0.5, X)
    assert ((wrong.exact, wrong.approximate) == (False, False)
            and wrong.difference == pytest.approx(0.5, abs=1e-15))
    misshapen, = rows(lambda x: x + 0, lambda dy, x: dy[:1].copy(), X)
    assert misshapen == Row("input 0", False, False, np.inf, "its shape")


def test_the_report_holds_every_failure():
    def f(a, b):
        return a * b

    def backward(dy, a, b):
        return dy * b * 1.1, dy[:1].copy()
    report = nn.check_gradient(f, backward, X, X + 1, names=("a", "b"), report=True)
    assert ([row.name for row in report.rows] == ["a", "b"] and len(report.failures) == 2
            and not report.passed)
    assert (report.failures[0].startswith("a[")
            and report.failures[1]
            == "b: found a gradient of shape (1, 3), needed (2, 3), the input's")
    assert failure(f, backward, X, X + 1, names=("a", "b")) == report.failures[0]


def test_the_contract_is_checked_too_unless_told_otherwise():
    def backward(dy, x):
        dx = SLOPE * dy
        dy[...] = 0
        return dx
    report = nn.check_gradient(analytic, backward, X, names=["x"], seed=3, report=True)
    assert (report.rows[0].approximate
            and report.failures
            == ("f_backward: changed the upstream gradient at [0, 0]; inputs are only to be read",))
    assert nn.check_gradient(analytic, backward, X, contract=False, report=True).passed
    assert nn.check_gradient(analytic, backward, X, contract=False) is None


REFUSALS = [
    (lambda: nn.check_gradient(lambda x: x.astype(np.float32), lambda dy, x: dy, X), ValueError,
     "f: found an output of dtype float32, needed one array of float64; verdicts need its digits"),
    (lambda: nn.check_gradient(np.positive, lambda dy, x: dy, X.astype(np.float32)), ValueError,
     "input 0: found dtype float32, needed float64; verdicts need its digits, try input "
     "0.astype(float)"),
    (lambda: nn.check_gradient(np.positive, lambda dy, x: dy, X.astype(complex), names=["x"]),
     ValueError,
     "x: found dtype complex128, needed float64; verdicts need its digits, try x.astype(float)"),
    (lambda: nn.check_gradient(np.positive, lambda dy, x: dy, 3), ValueError,
     "inputs: found int, needed at least one array of float64"),
    (lambda: nn.check_gradient(np.add, lambda dy, x: dy, 3, np.arange(2)), ValueError,
     "inputs: found int, ndarray, needed at least one array of float64"),
    (lambda: nn.check_gradient(lambda: 1.0, lambda dy: ()), ValueError,
     "inputs: found none, needed at least one array of float64"),
    (lambda: nn.check_gradient(np.add, lambda dy, x, y: (dy, dy), X, X, names=["x"]), ValueError,
     "names: found 1, needed one for each of 2 inputs"),
    (lambda: nn.check_gradient(np.add, lambda dy, x, y: (dy,) * 3, X, X, names=["x", "y"]),
     nn.GradientError,
     "f_backward: found 3 gradients, needed one for each of x, y"),
    (lambda: nn.check_gradient(np.add, lambda dy, x, y: (dy.copy(), 0.0), X, X), nn.GradientError,
     "input 1: found a gradient that is float, needed a float64 array"),
    (lambda: nn.check_gradient(np.add, lambda dy, x, y: (None, None), X, X), nn.GradientError,
     "f_backward: found NoneType for every gradient, needed one for each of input 0, input 1"),
    (lambda: nn.check_gradient(np.add, lambda dy, x, y: (dy.astype("f"), dy.copy()), X, X),
     nn.GradientError, "input 0: found a gradient of dtype float32, needed float64, as its input"),
    (lambda: nn.check_gradient(np.positive, lambda dy, x: dy.astype(int), X), nn.GradientError,
     "input 0: found a gradient that is int64, needed a float64 array"),
    (lambda: nn.check_gradient(np.positive, lambda dy, x: dy.tolist(), X[0]), nn.GradientError,
     "f_backward: found 3 gradients, needed one for each of input 0"),
    (lambda: nn.check_kink(nn.relu, lambda dy, x: 3 * np.abs(dy), np.zeros(1),
                           direction=np.array([8.0])), nn.GradientError,
     f"at the kink: found {24 * abs(np.random.default_rng(0).standard_normal()):.6g}, needed a "
     "value between the one-sided derivatives "
     f"{0:.6g} and {8 * np.random.default_rng(0).standard_normal():.6g}"),
]


@pytest.mark.parametrize("call, error, message", REFUSALS)
def test_refusals_word_for_word(call, error, message):
    with pytest.raises(error) as refusal:
        call()
    assert str(refusal.value) == message


# kinks


def test_both_sides_of_a_kink_and_what_is_claimed_between():
    """A corner with slopes -1 and 3 in the second input: for an upstream gradient d the sides are
    -d and 3 d, in any order of size.
    """
    def corner(scale, x):
        return scale * np.where(x < 0, -x, 3 * x)

    def claiming(slope):
        return lambda dy, scale, x: (dy * 0, dy * slope)
    for seed in range(6):
        d = np.random.default_rng(seed).standard_normal((1,))[0]
        for slope in (-1.0, -0.9999, 0.0, 3.0):
            found = nn.check_kink(corner, claiming(slope), np.ones(1), np.zeros(1),
                                  direction=np.array([2.0]), wrt=1, seed=seed)
            np.testing.assert_allclose(found, [-2 * d, 2 * slope * d, 6 * d], rtol=1e-8)
    # within a millionth of the larger side, 3
    for slope in (-1.0 - 2e-6, 3.0 + 2e-6):
        nn.check_kink(corner, claiming(slope), np.ones(1), np.zeros(1), direction=np.ones(1), wrt=1)
    for slope in (-1.0 - 4e-6, 3.0 + 4e-6, np.nan):
        with pytest.raises(nn.GradientError, match="^at the kink: found "):
            nn.check_kink(corner, claiming(slope), np.ones(1), np.zeros(1), direction=np.ones(1),
                          wrt=1)


def test_a_flat_kink_allows_zero_alone():
    nn.check_kink(lambda x: 0 * x, lambda dy, x: 0 * dy, np.zeros(2), direction=np.ones(2))
    with pytest.raises(nn.GradientError):
        nn.check_kink(lambda x: 0 * x, lambda dy, x: 1e-300 * np.abs(dy), np.zeros(2),
                      direction=np.ones(2))
