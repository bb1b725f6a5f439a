"""Given fractions, an operation answers with fractions or refuses; never with rounded numbers."""

from fractions import Fraction

import numpy as np
import pytest

from refimpl import nn
from refimpl.conformance.backend import OPERATIONS
from refimpl.conformance.cases import generator
from refimpl.conformance.functions_holden import autoencoder_loss, autoencoder_loss_backward
from refimpl.conformance.specification import as_tuple
from refimpl.holden2017 import losses
from refimpl.nn.arguments import are_exact, in_precision
from refimpl.nn.sums import power_of_two, root, wide_sum
from tests.proof.exactly import exactly, fractions, is_exact

HALF, THIRD = Fraction(1, 2), Fraction(1, 3)
# Operations outside `nn` and the losses of 2017 that round what they are given. The list only gets
# shorter.
ROUNDED = {
    **dict.fromkeys(("autoencoder_loss_2016", "trajectory_loss_2016", "initial_filters"),
                    "a constant is a floating-point number"),
    **dict.fromkeys(("support_vector_regression", "predicted_style", "golden_section", "best_alpha",
                     "best_pair", "exponential_map", "rotation_vector", "effort_measures",
                     "continuous_exponential_maps", "motion_to_numbers", "numbers_to_motion",
                     "motion_windows", "normaliser", "extended", "motion_to_rows_2016",
                     "rows_to_motion_2016", "row_windows_2016", "row_normaliser_2016",
                     "posed_joints", "observed_styles", "machine_errors", "machine_violation",
                     "fitted_style", "joined_motions", "stylised_numbers", "projected_numbers",
                     "fitted_weights", "euler_to_matrix", "matrix_to_euler", "matrix_to_quaternion",
                     "quaternion_to_matrix", "slerp", "smooth_rotations", "shortest_rotation",
                     "scaled_numbers", "path_error", "path_length", "initial_networks",
                     "initial_noise", "motion_to_poses"), "the room computes in float64"),
    "cluster_threshold": "SciPy's squareform takes the fractions' memory for floats: not called"}


def answers(operation):
    """What it says to the kit's samples in small fractions, and its gradient, with its options as
    fractions and as they are; nothing where it refuses."""
    for sample in operation.samples(generator(operation, 0)):
        floats = [hasattr(a, "dtype") and a.dtype.kind == "f" for a in sample.inputs]
        if not any(floats) or not all(np.isfinite(a).all() for a, is_float
                                      in zip(sample.inputs, floats) if is_float):
            continue
        inputs = [exactly(np.round(a * 64) / 64) if is_float else a
                  for a, is_float in zip(sample.inputs, floats)]
        for options in (sample.attributes, {k: exactly(v) for k, v in sample.attributes.items()}):
            try:
                y = operation.f(*inputs, **options)
                yield y
                if operation.backward:
                    dy = fractions(range(3, 3 + np.size(y)), np.shape(y)) / 7
                    yield operation.backward(dy[()], *inputs, **options)
            except (ValueError, TypeError):
                pass


@pytest.mark.parametrize("name", [name for name in OPERATIONS if name != "cluster_threshold"])
def test_an_operation_of_the_kit_is_exact_or_refuses(name):
    exact = [is_exact(part) for y in answers(OPERATIONS[name]) for part in as_tuple(y)]
    assert all(exact) == (name not in ROUNDED)


def test_what_is_taken_for_exact_is_seen_to_be_rounded():
    assert is_exact(fractions([HALF, 2], 2)) and is_exact(np.array([1])) and is_exact(None)
    assert not is_exact(np.array([0.5])) and not is_exact(np.array([THIRD, 0.5]))


EXACT = ("conv1d", "conv_transpose1d", "max_pool1d", "max_unpool1d", "avg_pool1d", "avg_depool1d",
         "random_depool1d", "relu", "gram", "sum_squares", "mean_squares", "l1", "squared_error",
         "absolute_error", "encode", "decode", "transform", "content_loss", "style_loss",
         "foot_loss", "trajectory_loss")


@pytest.mark.parametrize("name", EXACT)
def test_these_answer_with_fractions_forward_and_backward(name):
    found = list(answers(OPERATIONS[name]))
    assert len(found) >= 2 and any(np.asarray(part).dtype == object
                                   for y in found for part in as_tuple(y))


X = fractions([THIRD, -2, HALF, 0, 5, -THIRD], (1, 2, 3))


@pytest.mark.parametrize("garbage", ["x", None, 0.5, np.float64(0.5), np.float32(1), True, np.True_,
                                     1j, np.int64(3), [1], Fraction])
def test_what_is_no_exact_number_is_refused_among_fractions(garbage):
    x = X.copy()
    x[0, 1, 1] = garbage
    for call in (lambda: nn.relu(x), lambda: nn.conv1d(X, x.swapaxes(0, 1)),
                 lambda: nn.sum_squares_backward(x[0, 1], X.reshape(3, 2)), lambda: nn.l1(x)):
        with pytest.raises(ValueError, match="found dtype object, needed an array of float32"):
            call()


def test_expressions_of_sympy_are_taken_unless_they_hold_a_rounded_number():
    sympy = pytest.importorskip("sympy")
    a, b = sympy.symbols("a b")
    assert nn.sum_squares(np.array([[a, b]])).tolist() == [a ** 2 + b ** 2]
    assert nn.avg_pool1d(np.array([[[a, sympy.Rational(1, 3)]]]))[0, 0, 0] == a / 2 + THIRD / 2
    with pytest.raises(ValueError, match="found dtype object"):
        nn.sum_squares(np.array([[a, 0.5 * b]]))
    with pytest.raises(TypeError, match="truth value"):
        nn.relu(np.array([a]))


def test_precisions_are_not_mixed_with_fractions():
    with pytest.raises(ValueError, match="w: found dtype object, needed the precision of x, float"):
        nn.conv1d(np.zeros((1, 2, 3)), X.swapaxes(0, 1))
    for number in ("1", None, 0.5, np.float32(1), True, 1j):
        with pytest.raises(ValueError, match="dloss: found .*, needed an exact number"):
            nn.squared_error_backward(number, X, X)
    with pytest.raises(ValueError, match="dy: found Fraction.*, needed a number"):
        nn.l1_backward(THIRD, np.zeros(2))


def test_whole_numbers_among_fractions_are_divided_exactly():
    h = np.array([[[1, THIRD, 0]]], dtype=object)
    assert nn.avg_depool1d(h)[0, 0].tolist() == [HALF, HALF, THIRD / 2, THIRD / 2, 0, 0]
    assert nn.avg_pool1d(h, 3).tolist() == [[[(1 + THIRD) / 3]]]
    assert is_exact(nn.avg_pool1d_backward(h, np.repeat(h, 2, 2)))
    assert is_exact(nn.mean_squares_backward(h[0, 0, :2], h[0, 0, [[0, 2], [1, 1]]]))
    assert is_exact(nn.absolute_error_backward(h, h, 2 * h, reduction="none")[0])
    assert is_exact(nn.squared_error_backward(1, h, 2 * h)[0])
    assert are_exact(np.array([THIRD, 0], object)) and not are_exact(np.array([1, 0], object))


def test_a_number_beside_fractions_is_the_fraction_that_it_is():
    assert in_precision([[0.25], [3]], X).tolist() == [[Fraction(1, 4)], [3]]
    assert type(in_precision(np.int8(3), X)) is Fraction
    assert in_precision(0.1, X) == Fraction(0.1) != Fraction(1, 10)
    assert losses.content_loss(X, 2 * X, reading="sum_squares")[0] == sum(X.ravel() ** 2)
    assert (losses.style_loss(nn.gram(2 * X), X, reading="sum_squares")[0]
            == Fraction(0.01) * 9 * sum(nn.gram(X).ravel() ** 2))
    dH, _ = losses.content_loss_backward(fractions([1], 1), X, 2 * X, reading="sum_squares")
    assert dH.tolist() == (-2 * X).tolist()
    dG, _ = losses.style_loss_backward(fractions([1], 1), nn.gram(2 * X), X, reading="sum_squares")
    assert dG.tolist() == (6 * Fraction(0.01) * nn.gram(X)).tolist()
    assert losses.style_target([X[0], X[0]], 1)[0, 0] == sum(X[0, 0] ** 2) / 3


def test_a_root_is_exact_or_refused():
    assert nn.norm(fractions([3, 4], (1, 2))).tolist() == [5]
    assert (nn.norm_backward(fractions([1], 1), fractions([3, 4], (1, 2))).tolist()
            == [[Fraction(3, 5), Fraction(4, 5)]])
    assert nn.norm_backward(fractions([1], 1), fractions([0, 0], (1, 2))).tolist() == [[0, 0]]
    with pytest.raises(ValueError, match="root: found 5, needed the square of a fraction"):
        nn.norm(fractions([1, 2], (1, 2)))
    assert root(np.array([2.25, 0.0])).tolist() == [1.5, 0.0]
    state = nn.adam_start({"w": np.zeros(6)})
    for call in (lambda: nn.adam_start({"w": X}),
                 lambda: nn.adam_step({"w": X[0]}, {"w": X[0]}, state)):
        with pytest.raises(ValueError, match=r"params\['w'\]: found exact numbers, needed float"):
            call()


def test_bones_of_whole_lengths_are_exact():
    motion = exactly(np.zeros((1, 66, 1)))
    motion[0, :6, 0] = fractions([1, 2, 3, 4, 6, 15], 6)         # 13 apart
    bone = {"bones": ((0, 1),), "lengths": [10.5]}
    assert losses.bone_loss(motion, **bone).tolist() == [Fraction(25, 4)]
    dmotion = losses.bone_loss_backward(fractions([1], 1), motion, **bone)
    assert dmotion[0, :6, 0].tolist() == [Fraction(n, 13) for n in (-15, -20, -60, 15, 20, 60)]
    motion[0, :6, 0] = 0
    assert is_exact(losses.bone_loss_backward(fractions([1], 1), motion, **bone))


def test_the_sparsity_of_equation_3_may_be_a_fraction():
    W0, b0 = fractions([1, -2, HALF, 1], (2, 2, 1)), fractions([THIRD, 1], 2)
    x = fractions([1, 2, 3, 4, -1, 0, 2, 5], (1, 2, 4))
    loss = autoencoder_loss(x, W0, b0, alpha=THIRD, mean=False)
    assert type(loss) is Fraction and is_exact(autoencoder_loss_backward(HALF, x, W0, b0,
                                                                         alpha=THIRD)[1])


def test_sums_and_scales_of_fractions():
    assert wide_sum(X) == sum(X.ravel()) and wide_sum(X, (0, 2)).shape == (2,)
    assert power_of_two(X, 2).tolist() == [[1, 1]] and type(power_of_two(X)[()]) is Fraction
