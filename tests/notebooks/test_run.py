"""Run All of every notebook in a kernel of its own, as a student does: as it is stored, in its
folder and with the embedded motion; and with all answers filled in, at the root of the repository
and with the real clips where REFIMPL_MOCAP is set."""

import os
from pathlib import Path
import re
import time

import pytest

import refimpl

from . import books

nbformat = pytest.importorskip("nbformat",
                               reason="notebooks need nbformat, nbclient and ipykernel: pip "
                                      "install '.[test]'")
nbclient = pytest.importorskip("nbclient",
                               reason="notebooks need nbformat, nbclient and ipykernel: pip "
                                      "install '.[test]'")
pytest.importorskip("ipykernel",
                    reason="notebooks need nbformat, nbclient and ipykernel: pip install '.[test]'")
pytestmark = pytest.mark.filterwarnings("default")

# seconds: of a whole run; beyond it the second run is cut short
LIMIT, SLOW = 60.0, 20.0
FRAMES = 90                                                      # pictures in a player
BOOKS = pytest.mark.parametrize("path", books.notebooks(), ids=lambda path: path.stem)
took = {}


@pytest.fixture(autouse=True)
def kernel_environment(monkeypatch, tmp_path):
    monkeypatch.setenv("PYTHONPATH", str(Path(refimpl.__file__).parent.parent))
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path))
    for name in [name for name in os.environ if name.startswith(("REFIMPL_", "OPENBLAS_", "MKL_"))
                 and name != "REFIMPL_MOCAP"]:
        # a student's shell knows none of these
        monkeypatch.delenv(name)


def run_all(path, folder, cells=None, answered=False):
    """Execute a notebook, or its first code cells, in a folder.
    ->  outputs of all cells, the less of seconds and processor seconds it took
    """
    book = nbformat.read(path, as_version=4)
    if answered:
        for cell, known in zip(book.cells, books.cells(path)):
            cell.source = (books.solutions(path).read_text(encoding="utf-8") if known.exercise
                           else cell.source)
    if cells is not None:
        book.cells = [cell for cell in book.cells if cell.cell_type == "code"][:cells]
    began, spent = time.perf_counter(), children()
    nbclient.NotebookClient(book, timeout=300, kernel_name="python3",
                            resources={"metadata": {"path": str(folder)}}).execute()
    seconds = min(time.perf_counter() - began, (children() - spent) or LIMIT)
    return ([output for cell in book.cells if cell.cell_type == "code" for output in cell.outputs],
            seconds)


def children():
    """Processor seconds of the kernels that have ended: the clock on the wall also shows what else
    the machine does.
    """
    times = os.times()
    return times.children_user + times.children_system


@BOOKS
def test_run_all_in_its_folder(path, monkeypatch):
    monkeypatch.delenv("REFIMPL_MOCAP", raising=False)
    outputs, took[path] = run_all(path, path.parent)
    assert took[path] < LIMIT
    assert not [output.text for output in outputs if output.get("name") == "stderr"]
    shown = [output.data for output in outputs if "data" in output]
    players = [data["text/html"] for data in shown if "new Animation(" in data.get("text/html", "")]
    assert players or any("image/png" in data for data in shown), "shows nothing"
    for player in players:
        wanted = int(re.search(r"new Array\((\d+)\)", player).group(1))
        drawn = re.findall(r'frames\[(\d+)\] = "data:image/png;base64,[^"]', player)
        assert (sorted(map(int, drawn)) == list(range(wanted))
                and wanted <= FRAMES), "frames were lost"


@BOOKS
def test_run_all_answered_at_the_root(path):
    """A notebook that takes long is run fully once; here then only as far as paths and clips are
    read.
    """
    outputs, _ = run_all(path, path.parents[1], 5 if took.get(path, 0.0) > SLOW else None,
                         answered=True)
    assert not [output.text for output in outputs if output.get("name") == "stderr"
                or "open:" in output.get("text", "")]
