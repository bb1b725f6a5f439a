"""The judge itself: what passes, what is open, what fails and what the message says; and the motion
that notebooks show.
"""

import linecache

import numpy as np
import pytest

from refimpl import nn
from refimpl.exercise import attempt, slopes
from refimpl.embedded import sample
from refimpl.motion.bvh import write_bvh
from refimpl.embedded.walkers import make_clip

RNG = np.random.default_rng(0)
X, W, B = RNG.normal(size=(2, 3, 8)), RNG.normal(size=(4, 3, 5)), RNG.normal(size=4)


def gradients(dy, x, w, b):
    return nn.conv1d_backward(dy, x, w, b)


def filters(dy, x, w, b):
    return gradients(dy, x, w, b)[1]


def open_still(dy, x, w, b):
    raise NotImplementedError


def judge(mine, own=filters, wrt="w"):
    return attempt(mine, own, {"odd": (X, W, B)}, f=nn.conv1d, wrt=wrt)


@pytest.fixture
def said(capsys):
    """->  what a trial prints; it goes on with the answer only if that is right"""
    def _said(mine, own, cases, **options):
        goes_on = attempt(mine, own, cases, **options)
        printed = capsys.readouterr().out
        told = mine if printed.endswith("passed\n") else own
        assert goes_on is told or getattr(goes_on, "__wrapped__", None) is told
        assert ("wrong: " in printed) + printed.startswith("open: ") == (goes_on is own)
        return printed
    return _said


@pytest.fixture
def about_filters(said):
    return lambda mine, own=filters, wrt="w": said(mine, own, {"odd": (X, W, B)}, f=nn.conv1d,
                                                   wrt=wrt)


def test_a_right_gradient_is_returned_and_shown(capsys):
    assert judge(filters) is filters
    lines = capsys.readouterr().out.splitlines()
    assert (lines[0].split(" | ")[:4] == ["name   ", "exact", "approximate", "max difference"]
            and lines[-1] == "passed")
    assert ("complex step, 60 of 60 elements" in lines[1] and "the package's own function"
            in lines[2])


def test_several_gradients_at_once(said, capsys):
    assert judge(gradients, gradients, None) is gradients
    assert ([line.split(",")[0] for line in capsys.readouterr().out.splitlines()[1:-1]]
            == ["dx", "dw", "db"] * 2)
    printed = said(lambda *a: (*gradients(*a)[:2], 2 * gradients(*a)[2]), gradients,
                   {"odd": (X, W, B)}, f=nn.conv1d)
    assert "odd: db[" in printed and "Everything is twice what is needed" in printed
    assert "dx, dw: right." in printed


def test_an_open_exercise_goes_on_with_the_own_function(about_filters):
    assert about_filters(open_still).startswith("open: open_still is yours")
    assert "calls open_still" in about_filters(lambda *a: open_still(*a))


def test_the_worst_element_is_named(about_filters):
    def mine(dy, x, w, b):
        dw = filters(dy, x, w, b)
        dw[3, 1, 4] += 0.5
        dw[0, 0, 0] += 0.1
        return dw
    printed = about_filters(mine)
    assert "wrong: mine, odd: dw[3, 1, 4]: found " in printed
    assert "2 of 60 elements are wrong" in printed


@pytest.mark.parametrize("mine, message", [
    (lambda dy, x, w, b: None, "found None, needed dw; is there a return"),
    (lambda dy, x, w, b: filters(dy, x, w, b)[0], "found shape (3, 5), needed (4, 3, 5)"),
    (lambda dy, x, w, b: gradients(dy, x, w, b), "found 3 results, needed 1"),
    (lambda dy, x, w, b: filters(dy, x, w, b) * np.nan, "found nan"),
    (lambda dy, x, w, b: filters(np.multiply(dy, 2, out=dy) / 2, x, w, b), "found dy changed"),
    (lambda dy, x, w, b: filters(dy, x, w, b).astype(np.float32), "found float32, needed float64"),
    (lambda dy, x, w, b: filters(dy, x, w, b) * (1 + 0j), "found complex numbers"),
])
def test_what_is_no_gradient(about_filters, mine, message):
    assert message in about_filters(mine)


def test_a_list_does_for_an_array(about_filters, said):
    assert "passed" in about_filters(lambda *a: filters(*a).tolist())
    assert "passed" in about_filters(lambda *a: (filters(*a),))
    assert "passed" in said(lambda a: [a, a], lambda a: (a, a), {"two": (X,)})
    for mine in (lambda a: a.tolist(), lambda a: (a,), lambda a: list(a)):
        goes_on = attempt(mine, lambda a: a, {"one": (X,)})
        assert goes_on(X[:1]).shape == (1, 3, 8), "the cells after the check want an array"
    assert "passed" in said(lambda a: (1, 2), lambda a: np.array([1, 2]), {"two": (X,)})


def test_a_crash_is_told_in_five_lines(about_filters):
    def mine(dy, x, w, b):
        other = dy
        return other @ x
    first, second, third, fourth, _ = about_filters(mine).splitlines()
    assert first.startswith("wrong: mine, odd: it stopped with ValueError: matmul")
    assert second == "  at line 3 of mine: return other @ x"
    assert third == "  there: other (2, 4, 8), x (2, 3, 8)"
    assert fourth == "  called with: dy (2, 4, 8), x (2, 3, 8), w (4, 3, 5), b (4,)"


def test_arguments_are_left_alone(about_filters):
    def mine(dy, x, w, b):
        dw = filters(dy, x, w, b)
        x *= 2
        return dw
    before = X.copy()
    assert "found x changed" in about_filters(mine)
    assert np.array_equal(X, before)


def test_at_kinks_the_rule_decides(said):
    def at_zero(value):
        return lambda dy, x: np.where(x > 0, dy, np.where(x == 0, value * dy, 0.0))
    for value in (1.0, 0.5):
        rule = at_zero(value)
        # away from the kink any rule will do
        assert "passed" in said(rule, nn.relu_backward, {"random": (X,)}, f=nn.relu)
        printed = said(rule, nn.relu_backward, {"random": (X,)}, f=nn.relu,
                       kinks={"at 0": (np.round(X),)})
        assert "right in: random" in printed and "Wrong only where x is 0" in printed


def test_differences_decide_even_where_the_own_function_agrees(said):
    def wrong(dG, h):
        return 2 * dG @ h
    assert "dh[" in said(wrong, lambda dG, h: 2 * dG @ h, {"random": (X,)}, f=nn.gram)


MISTAKES = [
    (lambda dy, x: dy * x, "Everything is half of what is needed"),
    (lambda dy, x: -2 * dy * x, "the right one negated"),
    (lambda dy, x: 2 * x, "if dy were all ones or left out"),
    (lambda dy, x: 2 * dy * x[:, :, ::-1], "if x were reversed along the last axis"),
    (lambda dy, x: 2 * dy[::-1] * x[::-1], "reversed along the first axis"),
    (lambda dy, x: 2 * dy * x / x.size, "divided by the number of elements of dy once too often"),
    (lambda dy, x: 2 * np.roll(dy * x, 1, 2), "one position later along the last axis"),
    (lambda dy, x: 2 * dy * np.abs(x), "if x had lost its sign"),
    (lambda dy, x: 2 * dy * x * x, "if x were squared"),
    (lambda dy, x: (2 * dy * x).swapaxes(1, 2), "transposed"),
    (lambda dy, x: np.cumsum(2 * dy * x, axis=2), "summed up along the last axis"),
    (lambda dy, x: 2 * dy * x * (np.arange(3) > 0), "only in the first position of the last axis"),
    (lambda dy, x: 2 * dy * x + dy, "dy is added once too often"),
    (lambda dy, x: 2 * dy * np.maximum(x, 0), "if x were cut off below 0"),
    (lambda dy, x: 2 * dy * x[:1] * x / x, "along the first axis"),
    (lambda dy, x: 2 * dy * np.sign(x) * x ** 2 + x ** 3, "Doubling "),
]


@pytest.mark.parametrize("mine, words", MISTAKES)
def test_a_mistake_is_named(said, mine, words):
    square = RNG.normal(size=(2, 3, 3))
    assert words in said(mine, lambda dy, x: 2 * dy * x, {"square": (square,)},
                         f=lambda x: x * x)


def test_what_is_asked_too_often(said):
    def twice(f):
        return f(1.0) + f(1.0) - f(1.0)
    cases = {"a function": (np.cos,)}
    assert "passed" in said(twice, lambda f: f(1.0), cases, most_calls=3)
    assert "after 3 calls; 2 are enough" in said(twice, lambda f: f(1.0), cases, most_calls=2)

    def product(a, b):
        return a @ b + 0 * (a @ b)
    pair = {"matrices": (np.eye(3), RNG.normal(size=(3, 3)))}
    assert "passed" in said(product, np.matmul, pair, most_products=2)
    assert "by 2 products; 1 are enough" in said(product, np.matmul, pair, most_products=1)


def test_intermediates_are_told_by_name(said):
    def right(x):
        return {"p": x, "q": 2 * x, "r": x * x}
    printed = said(lambda x: {"r": x * x, "p": x, "q": x}, right, {"three": (X,)})
    assert "three: q[" in printed and "p, r: right." in printed
    slope = slopes(lambda x: np.sum(x ** 3), X)
    assert np.allclose(slope, 3 * X ** 2, rtol=1e-13)
    assert np.allclose(slopes(lambda x: nn.relu(x), X, X), X * (X > 0), rtol=1e-7)


def test_a_small_case_is_drawn(said):
    printed = said(lambda x: x + 1, lambda x: x, {"large": (X,), "small": (np.arange(3.0),)})
    assert "wrong: <lambda>, small" in printed
    assert [line.strip() for line in printed.splitlines() if " = [" in line] == [
        "x = [0. 1. 2.]", "yours = [1. 2. 3.]", "needed = [0. 1. 2.]"]


def test_values_numbers_and_verdicts(said):
    assert "passed" in said(np.cumsum, lambda a: np.cumsum(a), {"a": (X,)})
    said(lambda a: a > 0, lambda a: a > 0, {"yes": (1.0,), "no": (-1.0,)})
    assert "found 0, needed 1" in said(lambda a: a > 2, lambda a: a > 0, {"a": (1.0,)})
    assert "first axis and" not in said(lambda a: a, lambda a: a, {"a": (X,)})
    printed = said(lambda a: a.swapaxes(1, 2), lambda a: a, {"a": (X,)})
    assert "found shape (2, 8, 3)" in printed and "are exchanged" in printed
    assert "found 1 results, needed 2" in said(lambda a: a, lambda a: (a, a), {"a": (X[0],)})
    assert "output 1" in said(lambda a: (a, a), lambda a: (a, -a), {"a": (X,)})
    assert "1 of 3 elements" in said(lambda a: np.array([0, np.nan, 1]),
                                     lambda a: np.array([0, np.nan, np.nan]), {"a": (1,)})
    assert "passed" in said(lambda a: a * (1 + 1e-6), lambda a: a, {"a": (X,)}, tolerance=1e-5)
    assert "wrong" in said(lambda a: a * (1 + 1e-6), lambda a: a, {"a": (X,)})


def test_wrt_is_a_parameter():
    with pytest.raises(ValueError, match="wrt: found v, needed parameters of f among x, w, b"):
        judge(filters, wrt="v")


def test_sample_is_embedded_without_a_folder(monkeypatch):
    monkeypatch.delenv("REFIMPL_MOCAP", raising=False)
    take, credit = sample.sample_take("jog", "old", seconds=2.0)
    assert take.features.shape == (120, 66) and credit == "jog_old, made by refimpl"
    with pytest.raises(ValueError, match="content: found 'fly'"):
        sample.sample_take("fly")


def test_sample_is_a_recorded_clip_of_that_name(monkeypatch, tmp_path):
    clip = make_clip("jog", "old", seconds=3.0).clip
    write_bvh(tmp_path / "mine_run_elderly_1.bvh", clip)
    monkeypatch.setenv("REFIMPL_MOCAP", str(tmp_path))
    take, credit = sample.sample_take("jog", "old", seconds=2.0)
    assert len(take.features) == 180 and credit == "mine_run_elderly_1"
    # too short
    assert sample.sample_take("jog", "old", seconds=4.0)[1].endswith("made by refimpl")
    # another content
    assert sample.sample_take("walk", "old", seconds=2.0)[1].endswith("made by refimpl")
    monkeypatch.setenv("REFIMPL_MOCAP", str(tmp_path / "nowhere"))
    with pytest.raises(FileNotFoundError, match="nowhere"):
        sample.sample_take()


@pytest.mark.mocap
def test_sample_says_the_licence(mocap, monkeypatch):
    monkeypatch.setenv("REFIMPL_MOCAP", str(mocap))
    take, credit = sample.sample_take("walk", seconds=8.0)
    assert len(take.features) >= 480 and "Bandai" in credit and "CC BY-NC" in credit


def overwritten(dy, x):
    found = np.zeros_like(x)
    for k in range(2):
        found = dy * x
    return found


def of_all(x):
    while x.shape[0] > 2:                        # turned round it would not end
        x = x[1:]
    return x.sum(axis=0)


def test_the_line_and_the_kind_of_a_single_change_are_told(said):
    printed = said(overwritten, lambda dy, x: 2 * dy * x, {"two": (X, X)})
    assert "One change in line 4, `found = dy * x`, makes it right in every case: =, +=" in printed
    rows = {"five": (RNG.normal(size=(5, 3)),), "three": (RNG.normal(size=(3, 3)),)}
    printed = said(of_all, lambda x: x[-1:].sum(axis=0), rows)
    assert "line 2, `while x.shape[0] > 2:" in printed and printed.count("One change") == 1
    assert "One change" not in said(lambda x: x, lambda x: x + 1, rows)          # no text at hand


@pytest.mark.parametrize("mine, kind", [
    ("dy[:, None] - x", "a sign"), ("(dy[:, None] + x).sum(axis=1)", "something stands there"),
    ("(dy[:, None] + x) / 2", "something stands there"), ("dy[:, None] + x[::-1]", "an index"),
    ("dy[:, None] + x.T.T * 3", "something stands there"), ("dy + x", "an axis of length 1"),
    ("dy[:, None] + np.roll(x, 1)", "something stands there"),
    ("dy[:, None] + x ** 2", "something stands there"),
    ("dy[:, None] + x + dy.mean()", "something stands there")])
def test_kinds_of_a_change(said, mine, kind):
    names = {"np": np}
    text = f"def mine(dy, x):\n    return {mine}\n"
    linecache.cache["<a cell>"] = len(text), None, text.splitlines(keepends=True), "<a cell>"
    exec(compile(text, "<a cell>", "exec"), names)
    printed = said(names["mine"], lambda dy, x: dy[:, None] + x,
                   {"four": (RNG.normal(size=4), RNG.normal(size=(4, 3)))})
    assert f"makes it right in every case: {kind}" in printed


def test_a_costly_right_function_is_not_asked_for_ever(said):
    asked = []

    def costly(x):
        asked.append(max(max(0, n) for n in range(20000)))
        return 3 * x
    said(lambda x: x * x, costly, {"one": (X,), "another": (X[0],)})
    assert len(asked) < 40
