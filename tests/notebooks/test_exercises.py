"""The checks of the exercises, each run as the notebook has it: the answer passes, the stub is
open, every wrong answer is caught.

The cells run in this process, without those tagged `aside`; what a check needs must not be in
those.
"""

import contextlib
from functools import lru_cache
import io
import linecache
import os
from unittest import mock

import pytest

from refimpl.exercise import trial

from . import books

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")
pytestmark = pytest.mark.filterwarnings("default")

EXERCISES = [pytest.param(path, cell.exercise, id=f"{path.stem[:2]}-{cell.exercise}")
             for path in books.notebooks() for cell in books.cells(path) if cell.exercise]
WRONG = [pytest.param(path, name, id=f"{path.stem[:2]}-{name}") for path in books.notebooks()
         if books.wrong(path).exists() for name in books.functions(books.wrong(path))
         if "__" in name]


def run(source, names, where):
    """Execute a cell, whose text is at hand as in a kernel.   ->  what it printed"""
    linecache.cache[where] = len(source), None, source.splitlines(keepends=True), where
    with contextlib.redirect_stdout(io.StringIO()) as printed, mock.patch.dict(os.environ):
        os.environ.pop("REFIMPL_MOCAP", None)    # recorded motion is for `test_run`
        exec(compile(source, where, "exec"), names)
    return printed.getvalue()


@lru_cache(maxsize=None)
def before_each_check(path):
    """What a notebook knows before each exercise, all earlier ones being answered.
    ->  {exercise: (names, source of the exercise, source of the check)}
    """
    names, known, exercise = {"__name__": "__main__"}, {}, ""
    answers = books.solutions(path).read_text(encoding="utf-8")
    found = books.cells(path)
    last = max(n for n, cell in enumerate(found) if cell.check)
    for cell in found[:last + 1]:
        if cell.kind != "code" or cell.aside:
            continue
        if cell.exercise:
            exercise = cell.exercise
            known[exercise] = [dict(names), cell.source]
            answered = dict(names)
            run(answers, answered, books.solutions(path).name)
            names[exercise] = answered[exercise]
            continue
        if cell.check:
            known[exercise].append(cell.source)
        run(cell.source, names, path.name)
    return known


def check(path, exercise, source, name):
    """Put a function of `source` in the place of the exercise and run the notebook's check.
    ->  what it printed
    """
    names, _, checking = before_each_check(path)[exercise]
    names = dict(names)
    run(source, names, "answer")
    names[exercise] = names[name]
    return run(checking, names, path.name)


@pytest.mark.parametrize("path, exercise", EXERCISES)
def test_answer_passes(path, exercise):
    printed = check(path, exercise, books.solutions(path).read_text(encoding="utf-8"), exercise)
    assert "| max difference" in printed and "passed" in printed and "open:" not in printed


@pytest.mark.parametrize("path, exercise", EXERCISES)
def test_stub_is_open(path, exercise):
    assert "open:" in check(path, exercise, before_each_check(path)[exercise][1], exercise)


@pytest.mark.parametrize("path, name", WRONG)
def test_wrong_answer_is_caught(path, name, monkeypatch):
    for asked in ("one_change", "explain"):      # what it looks like is asked below
        monkeypatch.setattr(trial, asked, lambda *_, **__: "")
    printed = check(path, name.partition("__")[0],
                    books.wrong(path).read_text(encoding="utf-8"), name)
    assert f"wrong: {name}" in printed and "\npassed" not in printed


@pytest.mark.parametrize("path, exercise", EXERCISES)
def test_a_wrong_answer_is_explained(path, exercise):
    """Of some wrong answer to each exercise is told what it looks like."""
    source = books.wrong(path).read_text(encoding="utf-8")
    names = [name for name in books.functions(books.wrong(path))
             if name.startswith(f"{exercise}__")]
    assert any("looks like: " in said or "One change in " in said or "it stopped with" in said
               for said in (check(path, exercise, source, name) for name in names))
