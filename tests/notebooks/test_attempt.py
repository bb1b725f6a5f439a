"""The judge itself: what passes, what is open, what fails and what the message says; and the motion
that notebooks show.
"""

import numpy as np
import pytest

from refimpl import nn
from refimpl.exercise import attempt
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


def test_a_right_gradient_is_returned_and_shown(capsys):
    assert judge(filters) is filters
    lines = capsys.readouterr().out.splitlines()
    assert (lines[0].split(" | ")[:4] == ["name   ", "exact", "approximate", "max difference"]
            and lines[-1] == "passed")
    assert ("complex step, 60 of 60 elements" in lines[1] and "the package's own function"
            in lines[2])


def test_several_gradients_at_once(capsys):
    assert judge(gradients, gradients, None) is gradients
    assert ([line.split(",")[0] for line in capsys.readouterr().out.splitlines()[1:-1]]
            == ["dx", "dw", "db"] * 2)
    with pytest.raises(AssertionError, match="db"):
        judge(lambda *a: (*gradients(*a)[:2], 2 * gradients(*a)[2]), gradients, None)


def test_an_open_exercise_goes_on_with_the_own_function(capsys):
    assert judge(open_still) is filters
    assert capsys.readouterr().out.startswith("open: open_still ")


def test_the_worst_element_is_named(capsys):
    def mine(dy, x, w, b):
        dw = filters(dy, x, w, b)
        dw[3, 1, 4] += 0.5
        dw[0, 0, 0] += 0.1
        return dw
    with pytest.raises(AssertionError,
                       match=r"mine, odd: dw\[3, 1, 4\]: found .* 2 of 60 elements are wrong"):
        judge(mine)
    assert "passed" not in capsys.readouterr().out


@pytest.mark.parametrize("mine, message", [
    (lambda dy, x, w, b: None, "NoneType"),
    (lambda dy, x, w, b: filters(dy, x, w, b)[0], r"shape \(3, 5\), needed \(4, 3, 5\)"),
    (lambda dy, x, w, b: gradients(dy, x, w, b), "found 3 gradients"),
    (lambda dy, x, w, b: filters(dy, x, w, b) * np.nan, "nan"),
    (lambda dy, x, w, b: filters(np.multiply(dy, 1, out=dy), x, w, b), "read-only"),
])
def test_what_is_no_gradient(mine, message):
    with pytest.raises(AssertionError, match=message):
        judge(mine)


def test_arguments_are_left_alone():
    def mine(dy, x, w, b):
        dw = filters(dy, x, w, b)
        x *= 2
        return dw
    before = X.copy()
    with pytest.raises(AssertionError, match="found x changed"):
        judge(mine)
    assert np.array_equal(X, before)


def test_at_kinks_the_rule_decides():
    def at_zero(value):
        return lambda dy, x: np.where(x > 0, dy, np.where(x == 0, value * dy, 0.0))
    for value in (1.0, 0.5):
        rule = at_zero(value)
        # away from the kink any rule will do
        assert attempt(rule, nn.relu_backward, {"random": (X,)}, f=nn.relu) is rule
        with pytest.raises(AssertionError, match="at 0.*own function"):
            attempt(rule, nn.relu_backward, {"random": (X,)}, f=nn.relu,
                    kinks={"at 0": (np.round(X),)})


def test_differences_decide_even_where_the_own_function_agrees():
    def wrong(dG, h):
        return 2 * dG @ h
    with pytest.raises(AssertionError, match="dh.*complex step"):
        attempt(wrong, wrong, {"random": (X,)}, f=nn.gram)


def test_values_numbers_and_verdicts(capsys):
    assert attempt(np.cumsum, np.cumsum, {"a": (X,)}) is np.cumsum
    attempt(lambda a: a > 0, lambda a: a > 0, {"yes": (1.0,), "no": (-1.0,)})
    attempt(lambda a: (a, -a), lambda a: (a, -a), {"two": (X,)})
    with pytest.raises(AssertionError, match=r"a: \[\]: found 0, needed 1"):
        attempt(lambda a: a > 2, lambda a: a > 0, {"a": (1.0,)})
    with pytest.raises(AssertionError, match="found shape .*8, 3"):
        attempt(lambda a: a.swapaxes(1, 2), lambda a: a, {"a": (X,)})
    with pytest.raises(AssertionError, match="found 1 outputs, needed 2"):
        attempt(lambda a: a, lambda a: (a, a), {"a": (X,)})
    with pytest.raises(AssertionError, match="output 1"):
        attempt(lambda a: (a, a), lambda a: (a, -a), {"a": (X,)})
    with pytest.raises(AssertionError, match="1 of 3 elements"):
        attempt(lambda a: np.array([0, np.nan, 1]), lambda a: np.array([0, np.nan, np.nan]),
                {"a": (1,)})
    attempt(lambda a: a * (1 + 1e-6), lambda a: a, {"a": (X,)}, tolerance=1e-5)
    with pytest.raises(AssertionError):
        attempt(lambda a: a * (1 + 1e-6), lambda a: a, {"a": (X,)})


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
