"""The file of notebook 18: it is written, judged by the program, and trained with; its loss curve
is the package's.
"""

import ast
import contextlib
import io
import linecache
import os
from pathlib import Path
import subprocess
import sys

import numpy as np
import pytest

import refimpl

from . import books

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")
PATH = books.FOLDER / "18_your_own_system.ipynb"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("mine")


def answer(name):
    """The source of one answer."""
    text = books.solutions(PATH).read_text(encoding="utf-8")
    return next(ast.get_source_segment(text, node) for node in ast.parse(text).body
                if isinstance(node, ast.FunctionDef) and node.name == name)


def cells_run(folder, written, train=True):
    """Run the notebook's cells in a folder, some exercises written.   ->  names, what it printed"""
    names = {"__name__": "__main__"}
    with contextlib.chdir(folder), contextlib.redirect_stdout(io.StringIO()) as printed:
        for i, cell in enumerate(books.cells(PATH)):
            shows = "\nwalked = " in cell.source or "on_the_spot" in cell.source
            if cell.kind == "code" and (train or not shows):
                text = answer(cell.exercise) if cell.exercise in written else cell.source
                if not train:
                    text = text.replace("= 9, 48, 24, 120, 120", "= 9, 4, 2, 40, 120")
                where = f"<cell {i} of {folder.name}, {len(written)}>"    # a kernel does that too
                linecache.cache[where] = len(text), None, text.splitlines(keepends=True), where
                exec(compile(text, where, "exec"), names)
    return names, printed.getvalue()


@pytest.fixture(scope="module")
def answered(folder):
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("REFIMPL_MOCAP", raising=False)
        return cells_run(folder, [cell.exercise for cell in books.cells(PATH) if cell.exercise])


def test_the_loss_curve_is_the_packages(answered):
    names, printed = answered
    assert len(names["yours"]) == 12 and "open:" not in printed
    _, beside = names["train"](names["own_gradients"], names["own_adam"])
    assert np.abs(names["curve"] / beside - 1).max() < 1e-6      # 120 steps, float64
    assert names["gradients"] is names["system"].my_gradients, "not trained with the file"
    assert names["curve"][-1] < names["curve"][0] / 10


def test_it_is_near_the_style_beside_doing_nothing(answered):
    names, _ = answered
    found = [names["style_distance"](features, [names["X_style"]], names["manifold"])
             for features in names["distances"].values()]
    content, projected, _, result = found
    assert result < 0.2 * content and projected > 0.9 * content


def test_refimpl_check_agrees(answered, folder):
    here = str(Path(refimpl.__file__).parents[1])
    run = subprocess.run(
        [sys.executable, "-m", "refimpl", "check", "my_system:BACKEND", "--profile", "small",
         "--operations",
         "motion_to_numbers,encode,transform,total_loss,adam_step,stylised_numbers"],
        cwd=folder, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": here})
    assert run.returncode == 0, run.stdout + run.stderr
    wrong = [o for o in answered[0]["outcomes"] if o.grade == "wrong"]
    assert len(answered[0]["outcomes"]) > 150 and not wrong


def test_a_file_of_ones_own_is_read_and_left_alone(answered, folder):
    mine = (folder / "my_system.py").read_text(encoding="utf-8")
    changed = mine.removeprefix(answered[0]["MARK"])
    assert changed != mine
    (folder / "my_system.py").write_text(changed, encoding="utf-8")
    names, _ = cells_run(folder, [])                          # all exercises open
    assert (folder / "my_system.py").read_text(encoding="utf-8") == changed
    assert len(names["yours"]) == 12 and names["gradients"] is names["system"].my_gradients


def test_parts_that_are_open_are_not_in_the_file(tmp_path):
    names, printed = cells_run(tmp_path, [])
    assert not names["yours"] and not names["system"].BACKEND and "0 of 12 parts" in printed
    assert "style distance" in printed


def test_some_parts_lean_on_the_package(tmp_path):
    """Two answers of twelve: the file holds them and offers what needs nothing else, and the
    notebook trains with them."""
    names, _ = cells_run(tmp_path, ["my_hidden", "my_gradients"], train=False)
    assert names["yours"] == ["hidden", "gradients"]
    assert list(names["system"].BACKEND) == ["encode"]
    assert {o.grade for o in names["outcomes"]} == {"agrees"}
    assert names["gradients"] is names["system"].my_gradients and len(names["curve"]) == 40
