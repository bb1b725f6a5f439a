"""How far long work has come: one line with the time left before a person, nothing in a pipe."""

import contextlib
import io
import re
import subprocess
import sys

import pytest

from refimpl.commands import progress
from refimpl.commands.progress import Progress, duration
from refimpl.commands.terminal import Terminal
from refimpl.embedded.walkers import make_clip
from refimpl.motion.bvh import write_bvh

from .terminals import HERE, OnTerminal


class Screen(io.StringIO):
    """A stream that a person looks at."""

    def isatty(self):
        return True

    def fileno(self):
        raise OSError("no size is known")


@contextlib.contextmanager
def watching():
    """The standard error is looked at."""
    stream = Screen()
    with contextlib.redirect_stderr(Terminal(stream)):
        yield stream


@pytest.fixture
def clock(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    return now


def test_the_time_left_is_that_of_the_steps_left(clock):
    with watching() as screen:
        steps = Progress(10, "clip")
        for seconds, text in ((2.0, "a"), (4.0, "b"), (4.05, "too soon to be shown"), (8.0, "c")):
            clock[0] = seconds
            steps.step(text)
        shown = [part.rstrip() for part in screen.getvalue().split("\r") if part]
        assert shown == ["clip 0/10", "clip 1/10, 18 s left  a", "clip 2/10, 16 s left  b",
                         "clip 4/10, 12 s left  c"]


def test_shares_count_for_as_much_as_they_take(clock):
    with watching() as screen:
        steps = Progress(4, "part")
        clock[0] = 9.0
        steps.step("read", share=3)
        assert screen.getvalue().endswith("part 3/4, 3 s left  read")


def test_over_a_list(clock):
    with watching() as screen:
        assert list(Progress.over(["x", "y"], "name")) == ["x", "y"]
        assert "name 1/2, 0 s left  x" in screen.getvalue()


def test_what_is_written_takes_the_lines_place():
    with watching() as screen:
        out = Terminal(Screen(), sys.stderr)
        Progress(3, "epoch")
        out.write("a result")
        assert screen.getvalue().endswith("\r" + " " * len("epoch 0/3") + "\r")
        sys.stderr.write("an error")
        assert screen.getvalue().endswith("\ran error")              # wiped once


def test_a_line_never_wraps_and_never_breaks():
    with watching() as screen:
        sys.stderr.show("x\ny\x1b[2J " + "歩" * 60)                   # two columns each
        line = screen.getvalue()
        assert "\n" not in line and "\x1b" not in line
        assert 77 <= len(line.strip("\r")) + line.count("歩") <= 79


def test_nothing_where_nobody_looks():
    stream = io.StringIO()
    for one in (stream, Terminal(stream)):
        with contextlib.redirect_stderr(one):
            assert list(Progress.over([1, 2], "name")) == [1, 2]
    closed = open(__file__)
    closed.close()
    Terminal(closed).show("to nobody")
    assert stream.getvalue() == ""


def test_durations():
    assert [duration(s) for s in (0.4, 59.6, 3599, 7300)] == ["0 s", "1 min 00 s", "59 min 59 s",
                                                              "2 h 01 min"]


@pytest.fixture(scope="module")
def here(tmp_path_factory):
    folder = tmp_path_factory.mktemp("work")
    (folder / "clips").mkdir()
    for number in range(2):
        for style in ("normal", "old"):
            write_bvh(folder / "clips" / f"walk_{style}_{number}.bvh",
                      make_clip("walk", style, seconds=5.0).clip)
    return folder


LONG = {"prepare": (["prepare", "clips", "-o", "motions.npz"], r"clip 1/4, \d+ s left  walk_"),
        "train-autoencoder": (["train-autoencoder", "motions.npz", "-o", "m.npz", "--epochs", "2",
                               "--hidden", "6"], r"epoch 1/2, \d+ s left  loss"),
        "train-style": (["train-style", "motions.npz", "m.npz", "-o", "s.npz", "--style", "old",
                         "--epochs", "2", "--channels", "6"], r"epoch 1/2, \d+ s left  loss"),
        "transfer": (["transfer", "s.npz", "clips/walk_normal_0.bvh", "-o", "o.bvh", "--animate",
                      "o.html"], r"part 1/3, \d+ s left  read"),
        "segment": (["segment", "clips/walk_normal_0.bvh", "clips", "--contents", "2"],
                    r"clip 1/4, \d+ s left"),
        "check": (["check", "--operations", "gram,adam_step"],
                  r"operation 1/2, \d+ s left  gram: agrees"),
        "check a backend": (["check", "refimpl.nn", "--operations", "gram,conv1d", "--profile",
                             "small"], r"operation 1/2, \d+ s left  gram"),
        "export": (["export", "golden", "--operations", "gram,adam_step"],
                   r"operation 1/2, \d+ s left  gram")}


@pytest.mark.parametrize("name", LONG)
def test_long_commands_tell_how_long(here, name):
    """In the order above: the later ones need what the earlier ones wrote."""
    words, wanted = LONG[name]
    run = OnTerminal(words, cwd=here, stdout=subprocess.PIPE)
    out = run.process.stdout.read()
    run.process.stdout.close()
    assert run.end() == 0, run.text
    assert re.search(wanted, run.text), run.text
    assert not [line for line in run.seen() if " left" in line]  # nothing of it stays
    assert out and b" left" not in out and b"\r" not in out
    piped = subprocess.run([sys.executable, "-m", "refimpl", *words], cwd=here,
                           capture_output=True, text=True, env=HERE)
    assert piped.returncode == 0
    assert all(line.startswith("refimpl: warning") for line in piped.stderr.splitlines())
