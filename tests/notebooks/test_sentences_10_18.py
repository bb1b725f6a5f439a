"""Notebooks 10 to 18: each sentence about a result stands in the text and holds, on embedded and on
recorded motion; each result is used; intermediates are judged under their names.
"""

import ast
import contextlib
import io
import linecache
import os

import pytest

from . import books
from .sentences_10_18 import SENTENCES

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")
LAST = [path for path in books.notebooks() if path.stem >= "10"]
BOOKS = pytest.mark.parametrize("path", LAST, ids=lambda path: path.stem)
NAMED = 40


def ends_as(path, folder):
    """Run a notebook with all answers.   ->  its names"""
    names, answers = {"__name__": "__main__"}, books.solutions(path).read_text(encoding="utf-8")
    before = dict(os.environ)
    with contextlib.chdir(folder), contextlib.redirect_stdout(io.StringIO()) as printed:
        for i, cell in enumerate(books.cells(path)):
            if cell.kind == "code":
                text, where = answers if cell.exercise else cell.source, f"<{path.stem} {i}>"
                linecache.cache[where] = len(text), None, text.splitlines(keepends=True), where
                exec(compile(text, where, "exec"), names)
    os.environ.clear()
    os.environ.update(before)
    assert "wrong:" not in printed.getvalue() and "open:" not in printed.getvalue()
    return names


def hold(path, folder):
    names = ends_as(path, folder)
    false = [sentence for sentence, holds in SENTENCES[path.stem[:2]] if not eval(holds, names)]
    assert not false, false


@BOOKS
def test_sentences_hold_on_embedded_motion(path, monkeypatch, tmp_path):
    monkeypatch.delenv("REFIMPL_MOCAP", raising=False)
    hold(path, tmp_path)


@pytest.mark.mocap
@BOOKS
def test_sentences_hold_on_recorded_motion(path, mocap, tmp_path):
    hold(path, tmp_path)


@BOOKS
def test_sentences_stand_in_the_text(path):
    text = " ".join("".join(cell.source + " " for cell in books.cells(path)
                            if cell.kind == "markdown").split())
    for sentence, _ in SENTENCES[path.stem[:2]]:
        assert " ".join(sentence.split()) in text, sentence


@BOOKS
def test_every_result_is_what_the_notebook_goes_on_with(path):
    found = [cell for cell in books.cells(path) if cell.kind == "code"]
    for i, cell in enumerate(found):
        if cell.check:
            made = {target.id for node in ast.walk(ast.parse(cell.source))
                    if isinstance(node, ast.Assign) and any(
                        isinstance(part, ast.Name) and part.id in ("attempt", "verdict")
                        for part in ast.walk(node.value)) for target in node.targets
                    if isinstance(target, ast.Name)}
            later = {node.id for other in found[i + 1:] if not other.exercise
                     for node in ast.walk(ast.parse(other.source))
                     if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}
            texts = "".join(other.source for other in found[i + 1:])
            by_name = {name for name in made if f'"{name}"' in texts}      # 18: by its part's name
            assert made and made & (later | by_name), f"{cell.check}: its result is never used"


def test_intermediates_are_named():
    """Results of exercises that are judged one by one under a name, over all notebooks."""
    named = {}
    for path in books.notebooks():
        tree = ast.parse(books.solutions(path).read_text(encoding="utf-8"))
        for function in tree.body:
            if isinstance(function, ast.FunctionDef):
                for node in ast.walk(function):
                    if isinstance(node, ast.Return) and isinstance(node.value, ast.Dict):
                        keys = [key.value for key in node.value.keys
                                if isinstance(key, ast.Constant)]
                        if path.stem >= "18" or "steps" in function.name:
                            named[path.stem[:2], function.name] = keys
    assert sum(map(len, named.values())) >= NAMED, named


@BOOKS
def test_pictures_have_words_and_one_can_be_moved(path):
    source = "\n".join(cell.source for cell in books.cells(path) if cell.kind == "code")
    assert "plt.show()" not in source
    assert source.count("plt.subplots(") == source.count("plot.described(figure")
    assert "\nslide(" in source, "no control"
