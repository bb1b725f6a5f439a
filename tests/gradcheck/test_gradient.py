"""The checker checked: faults planted in a right convolution must all be caught, and what is right
must pass.
"""

import numpy as np
import pytest

from refimpl import nn
from refimpl.gradcheck import derivative

SEEDS = range(10)


def problem(seed):
    rng = np.random.default_rng([seed, 99])
    return rng.normal(size=(2, 2, 7)), rng.normal(size=(3, 2, 3)), rng.normal(size=3)


def right(dy, x, w, b):
    return nn.conv1d_backward(dy, x, w, b)


def bias_averaged(dy, x, w, b):
    dx, dw, db = right(dy, x, w, b)
    return dx, dw, db / len(x)


def flipped(dy, x, w, b):
    dx, dw, db = right(dy, x, w, b)
    return dx, dw[:, :, ::-1].copy(), db


def edge_dropped(dy, x, w, b):
    dx, dw, db = right(dy, x, w, b)
    dx[:, :, -1] = 0
    return dx, dw, db


def edge_of_the_filter_gradient_dropped(dy, x, w, b):
    shortened = dy.copy()
    shortened[:, :, 0] = 0
    return (nn.conv1d_backward(dy, x, w, b)[0], nn.conv1d_backward(shortened, x, w, b)[1],
            dy.sum(axis=(0, 2)))


def scaled(by):
    def backward(dy, x, w, b):
        dx, dw, db = right(dy, x, w, b)
        return dx, dw * (1 + by), db
    return backward


def one_element(change):
    def backward(dy, x, w, b):
        dx, dw, db = right(dy, x, w, b)
        dw[1, 0, 2] = change(dw[1, 0, 2])
        return dx, dw, db
    return backward


def input_mutated(dy, x, w, b):
    gradients = right(dy, x, w, b)
    x[0, 0, 0] += 1e-3
    return gradients


def upstream_mutated(dy, x, w, b):
    gradients = right(dy, x, w, b)
    dy *= 0
    return gradients


def noisy(dy, x, w, b):
    dx, dw, db = right(dy, x, w, b)
    return dx, dw * (1 + 1e-9 * np.random.standard_normal(dw.shape)), db


def counting():
    """Right on its first calls, wrong by a little afterwards."""
    calls = []

    def backward(dy, x, w, b):
        calls.append(None)
        dx, dw, db = right(dy, x, w, b)
        return dx, dw * (1 + 1e-15 * len(calls)) + 1e-13 * len(calls), db
    return backward


def single(dy, x, w, b):
    return tuple(g.astype(np.float32) for g in right(dy, x, w, b))


def wrong_on_strided_upstream(dy, x, w, b):
    return right(dy if dy.flags.c_contiguous else np.ascontiguousarray(dy)[::-1].copy(), x, w, b)


def reads_memory_order(dy, x, w, b):
    dx, dw, db = right(dy, x, w, b)
    return dx, dw, dy.ravel(order="K").reshape(dy.shape).sum(axis=(0, 2))


def aliased(dy, x, w, b):
    dx, dw, db = right(dy, x, w, b)
    # a view of the input, filled with the right numbers for a moment
    keep = x.reshape(-1)
    return dx, dw, np.lib.stride_tricks.as_strided(keep, (3,), keep.strides)


def in_one_buffer():
    """Every call fills the same array."""
    buffer = {}

    def backward(dy, x, w, b):
        dx, dw, db = right(dy, x, w, b)
        kept = buffer.setdefault(dw.shape, np.empty_like(dw))
        kept[...] = dw
        return dx, kept, db
    return backward


def wrong_on_a_spread_upstream(dy, x, w, b):
    return right(dy if all(dy.strides) else np.ascontiguousarray(dy) * 2, x, w, b)


def stale():
    """Remembers the first x it saw, as a layer that caches its input would."""
    seen = []

    def backward(dy, x, w, b):
        seen.append(x.copy())
        return right(dy, seen[-2] if len(seen) > 1 and seen[-2].shape == x.shape else x, w, b)
    return backward


def read_only(dy, x, w, b):
    dx, dw, db = right(dy, x, w, b)
    return dx, dw, np.broadcast_to(db, db.shape)


def wrong_shape(dy, x, w, b):
    dx, dw, db = right(dy, x, w, b)
    return dx, dw, db[:, None]


def quadratic(dy, x, w, b):
    dx, dw, db = right(dy, x, w, b)
    return dx, dw, db * (1 + 1e-9 * np.abs(dy).max())


def missing(dy, x, w, b):
    return right(dy, x, w, b)[:2]


def nan(dy, x, w, b):
    dx, dw, db = right(dy, x, w, b)
    dx[0, 1, 3] = np.nan
    return dx, dw, db


FAULTS = {
    "bias gradient averaged": lambda: bias_averaged, "flipped filter": lambda: flipped,
    "dropped edge": lambda: edge_dropped,
    "dropped edge in the filter gradient": lambda: edge_of_the_filter_gradient_dropped,
    "scale off by 1e-3": lambda: scaled(1e-3), "scale off by 1e-4": lambda: scaled(1e-4),
    "scale off by 1e-6": lambda: scaled(1e-6),
    "one sign": lambda: one_element(lambda v: -v),
    "one element off by 1 %": lambda: one_element(lambda v: 1.01 * v),
    "input mutated": lambda: input_mutated, "upstream mutated": lambda: upstream_mutated,
    "1e-9 noise": lambda: noisy,
    "hidden state": counting, "float32 returned": lambda: single,
    "wrong on a strided upstream gradient": lambda: wrong_on_strided_upstream,
    "wrong on an upstream gradient of stride 0": lambda: wrong_on_a_spread_upstream,
    "memory order": lambda: reads_memory_order, "aliased": lambda: aliased,
    "one buffer for all calls": in_one_buffer,
    "stale input": stale, "read-only gradient": lambda: read_only,
    "wrong shape": lambda: wrong_shape,
    "not linear in the upstream gradient": lambda: quadratic, "a gradient missing": lambda: missing,
    "NaN": lambda: nan}


@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_caught_with_every_seed(name):
    for seed in SEEDS:
        with pytest.raises(nn.GradientError):
            nn.check_gradient(nn.conv1d, FAULTS[name](), *problem(seed), names=("x", "w", "b"),
                              seed=seed)


@pytest.mark.parametrize("name",
                         ["flipped filter", "dropped edge", "scale off by 1e-3",
                          "scale off by 1e-6", "one sign", "one element off by 1 %"])
def test_the_same_faults_are_caught_where_no_complex_step_is_possible(name):
    """The absolute value of what is always positive: smooth, and real whatever it is given."""
    def f(x, w, b):
        return np.abs(nn.conv1d(x, w, b) + 30.0)

    def backward(dy, x, w, b):
        return FAULTS[name]()(dy * np.sign(nn.conv1d(x, w, b) + 30.0), x, w, b)
    for seed in SEEDS:
        with pytest.raises(nn.GradientError, match="central differences"):
            nn.check_gradient(f, backward, *problem(seed), names=("x", "w", "b"), seed=seed)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_right_gradient_passes(seed):
    nn.check_gradient(nn.conv1d, right, *problem(seed), seed=seed)
    nn.check_direction(nn.conv1d, right, *problem(seed), seed=seed)


def test_a_fault_that_ones_would_hide_is_caught():
    """Subtracting the mean: its backward without the mean's path sums to the right number, but not
    with a random upstream gradient.
    """
    def centre(x):
        return (x - x.mean(axis=1, keepdims=True)) ** 2

    def without_the_mean(dy, x):
        return 2 * dy * (x - x.mean(axis=1, keepdims=True))
    x = np.random.default_rng(0).normal(size=(3, 5))
    ones = np.ones(x.shape)
    along = derivative.line(centre, (x,), {0: np.cos(x)})
    np.testing.assert_allclose(derivative.complex_step(along, ones),
                               np.sum(without_the_mean(ones, x) * np.cos(x)))
    with pytest.raises(nn.GradientError):
        nn.check_gradient(centre, without_the_mean, x)


def test_the_message_names_the_worst_element():
    x, w, b = problem(0)
    with pytest.raises(nn.GradientError) as caught:
        nn.check_gradient(nn.conv1d, one_element(lambda v: 1.01 * v), x, w, b,
                          names=("x", "w", "b"), seed=4)
    message = str(caught.value)
    dy = np.random.default_rng(4).standard_normal((2, 3, 7))     # as the message says
    needed = nn.conv1d_backward(dy, x, w, b)[1][1, 0, 2]
    assert (message.startswith("w[1, 0, 2]: found ") and "1 of 18 elements" in message
            and "default_rng(4)" in message)
    found, wanted = (float(word.split(" ")[0].rstrip(","))
                     for word in (message.split("found ")[1], message.split("needed ")[1]))
    np.testing.assert_allclose([found, wanted], [1.01 * needed, needed], rtol=1e-12)


def test_the_worst_element_of_a_large_input_is_found():
    rng = np.random.default_rng(5)
    # 15 000 filter elements
    x, w = rng.normal(size=(1, 20, 30)), rng.normal(size=(30, 20, 25))

    def backward(dy, x, w):
        dx, dw, _ = nn.conv1d_backward(dy, x, w)
        dw[17, 3, 21] *= 1.01
        return dx, dw
    with pytest.raises(nn.GradientError, match=r"w\[17, 3, 21\]"):
        nn.check_gradient(nn.conv1d, backward, x, w, names=("x", "w"), contract=False)
    nn.check_gradient(nn.conv1d, lambda dy, x, w: nn.conv1d_backward(dy, x, w)[:2], x, w,
                      contract=False)


def test_the_report_says_what_the_check_says():
    x, w, b = problem(1)
    good = nn.check_gradient(nn.conv1d, right, x, w, b, names=("x", "w", "b"), report=True)
    assert good.passed and "passed" in str(good) and all(row.approximate for row in good.rows)
    assert str(good).splitlines()[0].startswith("name | exact | approximate | max difference")
    bad = nn.check_gradient(nn.conv1d, bias_averaged, x, w, b, names=("x", "w", "b"), report=True)
    assert (not bad.passed and "FAILED b[" in str(bad) and [row.approximate for row in bad.rows]
            == [True, True, False])
    unruly = nn.check_gradient(nn.conv1d, upstream_mutated, x, w, b, names=("x", "w", "b"),
                               report=True)
    assert (not unruly.passed and all(row.approximate for row in unruly.rows)
            and "upstream gradient" in str(unruly))
    misshapen = nn.check_gradient(nn.conv1d, wrong_shape, x, w, b, names=("x", "w", "b"),
                                  report=True)
    assert not misshapen.passed and "FAILED b: found a gradient of shape (3, 1)" in str(misshapen)


def test_inputs_without_a_gradient_are_passed_through():
    h, indices = np.array([[[1.0, 2.0]]]), np.array([[[3, 0]]])
    nn.check_gradient(nn.max_unpool1d, lambda d, *a: (nn.max_unpool1d_backward(d, *a), None, None),
                      h, indices, 4)
    x, w, _ = problem(2)
    nn.check_gradient(nn.conv1d, nn.conv1d_backward, x, w, None, names=("x", "w", "b"))


@pytest.mark.parametrize("inputs, words", [
    ((np.zeros((1, 2), np.float32),), "dtype float32, needed float64"),
    ((3,), "at least one array of float64"),
    ((np.zeros((1, 2), complex),), "needed")])
def test_inputs_that_allow_no_verdict_are_refused(inputs, words):
    with pytest.raises(ValueError, match=words):
        nn.check_gradient(np.positive, lambda dy, x: dy.copy(), *inputs)


def test_names_must_fit():
    with pytest.raises(ValueError, match="names: found 2"):
        nn.check_gradient(nn.conv1d, right, *problem(0), names=("x", "w"))
