"""Notebooks 10 to 18: each result is used; intermediates are judged under their names."""

import ast

import pytest

from . import books

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")
LAST = [path for path in books.notebooks() if path.stem >= "10"]
BOOKS = pytest.mark.parametrize("path", LAST, ids=lambda path: path.stem)
NAMED = 40


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
