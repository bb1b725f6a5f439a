"""Dicts, tuples and constants: taken apart, checked array by array, named as the user does."""

from collections import namedtuple

import numpy as np
import pytest

from refimpl.gradcheck import GradientError, check_contract, check_direction, check_gradient

RNG = np.random.default_rng(0)
PARAMS = {"W": RNG.standard_normal((3, 2)), "b": RNG.standard_normal(2)}
X = RNG.standard_normal((4, 3))


def layer(params, x):
    return x @ params["W"] + params["b"]


def backward(dy, params, x):
    return {"b": dy.sum(axis=0), "W": x.T @ dy}, dy @ params["W"].T


def failure(*arguments, **options):
    with pytest.raises(GradientError) as caught:
        check_gradient(*arguments, **options)
    return str(caught.value)


def test_a_dict_of_parameters():
    report = check_gradient(layer, backward, PARAMS, X, names=("params", "x"), report=True)
    assert report.passed
    assert [row.name for row in report.rows] == ["params['W']", "params['b']", "x"]
    check_contract(layer, backward, PARAMS, X)
    check_direction(layer, backward, PARAMS, X)


def test_what_is_wrong_in_a_dict_is_named():
    def mean(dy, params, x):
        gradients, dx = backward(dy, params, x)
        return {**gradients, "b": dy.mean(axis=0)}, dx
    assert failure(layer, mean, PARAMS, X, names=("params", "x")).startswith("params['b'][")
    said = failure(layer, lambda *a: ({"W": backward(*a)[0]["W"]}, backward(*a)[1]), PARAMS, X,
                   names=("params", "x"))
    assert said == "params: found gradients of 'W', needed those of 'W', 'b'"
    said = failure(layer, lambda dy, params, x: (dy, dy @ params["W"].T), PARAMS, X,
                   names=("params", "x"))
    assert said == ("params: found a gradient that is a ndarray, needed the form of its input, a "
                    "dict")


def test_a_dict_alone_with_lists_and_named_tuples_within():
    Pair = namedtuple("Pair", "a b")
    given = {"pair": Pair(X, 2.0), "all": [X + 1, X + 2]}

    def f(given):
        return given["pair"].a * given["pair"].b * given["all"][0] + given["all"][1]

    def f_backward(dy, given):
        (a, b), (c, _) = given["pair"], given["all"]
        return {"pair": (dy * b * c, None), "all": [dy * a * b, dy * 1]}
    check_gradient(f, f_backward, given)
    said = failure(f, lambda dy, g: {**f_backward(dy, g), "all": [dy, dy * 1]}, given,
                   names=["given"])
    assert said.startswith("given['all'][0][")


def test_several_outputs_have_several_upstream_gradients():
    def f(x):
        return x ** 2, x.sum(axis=1)

    def f_backward(dy, x, part=1.0):
        assert isinstance(dy, tuple) and dy[0].shape == x.shape and dy[1].shape == x.shape[:1]
        return 2 * x * dy[0] + part * dy[1][:, None]
    check_gradient(f, f_backward, X)
    assert "needed" in failure(f, lambda dy, x: f_backward(dy, x, 0.0), X)


def test_a_constant_has_no_gradient_and_the_report_says_so():
    mask = (RNG.random(X.shape) > 0.5) * 1.0
    report = check_gradient(np.multiply, lambda dy, x, m: (dy * m, None), X, mask,
                            names=("x", "mask"), report=True)
    assert report.passed and [row.name for row in report.rows] == ["x"]
    assert report.notes[0] == "mask: no gradient is claimed, it is taken for a constant"
    check_contract(np.multiply, lambda dy, x, m: (dy * m, None), X, mask)


def test_a_count_of_gradients_that_fits_nothing():
    assert failure(layer, lambda dy, p, x: backward(dy, p, x) + (dy,), PARAMS, X,
                   names=("params", "x")) \
        == "f_backward: found 3 gradients, needed one for each of params, x"
