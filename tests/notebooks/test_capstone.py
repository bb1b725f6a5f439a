"""The file of notebook 18: it is written, judged by the program, and trained with; its loss curve is
the package's.
"""

import contextlib
import io
import linecache
import subprocess
import sys

import numpy as np
import pytest

from . import books

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")
PATH = books.FOLDER / "18_your_own_system.ipynb"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("mine")


def cells_run(folder, answered):
    """Run the notebook's cells in a folder.   ->  names, what was printed"""
    names, source = {"__name__": "__main__"}, books.solutions(PATH).read_text(encoding="utf-8")
    with contextlib.chdir(folder), contextlib.redirect_stdout(io.StringIO()) as printed:
        for i, cell in enumerate(books.cells(PATH)):
            if cell.kind == "code":
                text = source if answered and cell.exercise else cell.source
                where = f"<cell {i} {answered}>"              # a notebook's kernel does that too
                linecache.cache[where] = len(text), None, text.splitlines(keepends=True), where
                exec(compile(text, where, "exec"), names)
    return names, printed.getvalue()


@pytest.fixture(scope="module")
def answered(folder):
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("REFIMPL_MOCAP", raising=False)
        return cells_run(folder, True)


def test_the_loss_curve_is_the_packages(answered):
    names, printed = answered
    assert len(names["yours"]) == 12 and "open:" not in printed
    _, beside = names["train"](names["own_gradients"], names["own_adam"])
    assert np.abs(names["curve"] / beside - 1).max() < 1e-6      # 120 steps, float64
    assert names["gradients"].__globals__ is vars(names["system"]), "trained with the file"
    assert names["curve"][-1] < names["curve"][0] / 10


def test_it_is_near_the_style_beside_doing_nothing(answered):
    names, _ = answered
    found = [names["style_distance"](features, [names["X_style"]], names["manifold"])
             for features in names["distances"].values()]
    content, projected, _, result = found
    assert result < 0.2 * content and projected > 0.9 * content


def test_refimpl_check_agrees(answered, folder):
    run = subprocess.run(
        [sys.executable, "-m", "refimpl", "check", "my_system:BACKEND", "--profile", "small",
         "--operations", "motion_to_numbers,encode,transform,total_loss,adam_step,stylised_numbers"],
        cwd=folder, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    wrong = [o for o in answered[0]["outcomes"] if o.grade == "wrong"]
    assert len(answered[0]["outcomes"]) > 150 and not wrong


def test_a_file_of_ones_own_is_read_and_left_alone(answered, folder):
    mine = (folder / "my_system.py").read_text(encoding="utf-8")
    changed = mine.removeprefix(answered[0]["MARK"])
    assert changed != mine
    (folder / "my_system.py").write_text(changed, encoding="utf-8")
    names, _ = cells_run(folder, False)                          # all exercises open
    assert (folder / "my_system.py").read_text(encoding="utf-8") == changed
    assert len(names["yours"]) == 12 and names["gradients"].__globals__ is vars(names["system"])


def test_parts_that_are_open_are_not_in_the_file(tmp_path):
    names, printed = cells_run(tmp_path, False)
    assert not names["yours"] and not names["system"].BACKEND and "0 of 12 parts" in printed
    assert "style distance" in printed
