"""Run All of every notebook in a kernel of its own, as a student does: as it is stored, in its
folder and with the embedded motion; and, where REFIMPL_MOCAP names the real clips, with them, all
answers filled in, at the root of the repository. At the end what the text says of the results must
hold (`sentences`)."""

import os
import re
from pathlib import Path

import pytest

import refimpl

from . import books
from .sentences import SENTENCES

nbformat = pytest.importorskip("nbformat",
                               reason="notebooks need nbformat, nbclient and ipykernel: pip "
                                      "install '.[test]'")
nbclient = pytest.importorskip("nbclient",
                               reason="notebooks need nbformat, nbclient and ipykernel: pip "
                                      "install '.[test]'")
pytest.importorskip("ipykernel",
                    reason="notebooks need nbformat, nbclient and ipykernel: pip install '.[test]'")
pytestmark = pytest.mark.filterwarnings("default")

SAID = """
from refimpl.motion.features import FORWARD, POSITIONS, TRANSLATION, TURN, VELOCITIES
made_up = {made_up}
for sentence, holds in {said!r}:
    assert eval(holds), sentence
"""
COUNTED = ("00", "03", "04", "05", "06", "09", "10", "11", "15", "17", "18")     # trainings
WRITES = ("18_your_own_system",)                 # a file, beside itself
BOOKS = pytest.mark.parametrize("path", books.notebooks(), ids=lambda path: path.stem)


@pytest.fixture(autouse=True)
def kernel_environment(monkeypatch, tmp_path):
    monkeypatch.setenv("PYTHONPATH", str(Path(refimpl.__file__).parent.parent))
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path))
    for name in [name for name in os.environ if name.startswith(("REFIMPL_", "OPENBLAS_", "MKL_"))
                 and name != "REFIMPL_MOCAP"]:
        # a student's shell knows none of these
        monkeypatch.delenv(name)


def run_all(path, folder, answered=False):
    """Execute a notebook in a folder.   ->  outputs of all cells"""
    book = nbformat.read(path, as_version=4)
    if answered:
        for cell, known in zip(book.cells, books.cells(path)):
            cell.source = (books.solutions(path).read_text(encoding="utf-8") if known.exercise
                           else cell.source)
    book.cells.append(nbformat.v4.new_code_cell(SAID.format(
        made_up="REFIMPL_MOCAP" not in os.environ, said=SENTENCES.get(path.stem[:2], []))))
    nbclient.NotebookClient(book, timeout=300, kernel_name="python3",
                            resources={"metadata": {"path": str(folder)}}).execute()
    return [output for cell in book.cells if cell.cell_type == "code" for output in cell.outputs]


@BOOKS
def test_run_all_in_its_folder(path, monkeypatch, tmp_path):
    monkeypatch.delenv("REFIMPL_MOCAP", raising=False)
    outputs = run_all(path, tmp_path if path.stem in WRITES else path.parent)
    assert not [output.text for output in outputs if output.get("name") == "stderr"]
    shown = [output.data for output in outputs if "data" in output]
    if path.stem[:2] in COUNTED:
        assert re.search(r"\d (million|billion) multiplications", "".join(
            output.get("text", "") for output in outputs))
    assert any("refimpl-player" in data.get("text/html", "") or "image/png" in data
               for data in shown), "shows nothing"


@BOOKS
def test_run_all_answered_at_the_root(path, mocap, tmp_path):
    outputs = run_all(path, tmp_path if path.stem in WRITES else path.parents[1], answered=True)
    assert not [output.text for output in outputs if output.get("name") == "stderr"
                or "open:" in output.get("text", "")]
