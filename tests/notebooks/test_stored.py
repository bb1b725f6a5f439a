"""What is kept of a notebook: source alone, in one form, with its neighbours, exercises and
answers.
"""

import ast
import re
import sys

import pytest

from . import books
from .sentences import SENTENCES

BOOKS = pytest.mark.parametrize("path", books.notebooks(), ids=lambda path: path.stem)
ALLOWED = {"numpy", "scipy", "matplotlib", "refimpl", "IPython"} | set(sys.stdlib_module_names)
NAMED = 40                                       # intermediates, at least
JUDGES = {"attempt", "verdict"}
FORGOTTEN = r"(?i)\b(todo|fixme|xxx|lorem)\b"


@BOOKS
def test_form(path):
    assert ((path.read_text(encoding="utf-8")
            == books.stored(books.read(
                path)))), f"write it again: python -m tests.notebooks.books {path.name}"
    book = books.read(path)
    ids = [cell["id"] for cell in book["cells"]]
    assert (len(set(ids)) == len(ids)
            and all(re.fullmatch(r"[a-zA-Z0-9_-]{1,64}", name) for name in ids))


@BOOKS
def test_valid(path):
    nbformat = pytest.importorskip("nbformat")
    nbformat.validate(nbformat.read(path, as_version=4))


@BOOKS
def test_name_and_length(path):
    assert path.stem in books.ORDER
    most = 45 if path.stem == books.ORDER[-1] else 36                    # the last one is a project
    assert 15 <= len(books.cells(path)) <= most, f"{len(books.cells(path))} cells"


@BOOKS
def test_opening_and_end(path):
    first, *_, last = books.cells(path)
    number = books.ORDER.index(path.stem)
    assert (first.kind == last.kind == "markdown"
            and first.source.startswith(f"# {path.stem[:2]} · "))
    assert "**You will**" in first.source and "**You need**" in first.source
    assert "## What to take along" in last.source
    for neighbour in books.ORDER[max(number - 1, 0):number] + books.ORDER[number + 1:number + 2]:
        assert f"({neighbour}.ipynb)" in first.source


@BOOKS
def test_code(path):
    for cell in books.cells(path):
        assert not re.search(FORGOTTEN, cell.source)
        if cell.kind != "code":
            continue
        tree = ast.parse(cell.source)
        long = [line for line in cell.source.splitlines() if len(line) > 105]
        assert not long, f"longer than the page is wide: {long}"
        for node in ast.walk(tree):
            names = ([alias.name for alias in node.names] if isinstance(node, ast.Import)
                     else [node.module] if isinstance(node, ast.ImportFrom) else [])
            assert {name.split(".")[0] for name in names} <= ALLOWED


@BOOKS
def test_blas_is_told_before_numpy_loads(path):
    """Two threads on small matrices wait for each other: six seconds become forty when the machine
    has other work.
    """
    code = [cell.source for cell in books.cells(path) if cell.kind == "code"][0]
    assert (0 <= code.find("prefer(os.environ)")
            < code.find("import numpy")), "begin the first code cell as the other notebooks do"


@BOOKS
def test_links(path):
    written = {other.stem for other in books.notebooks()}
    for target in re.findall(r"\]\(([^)#\s]+)\)",
                             "\n".join(cell.source for cell in books.cells(path)
                                       if cell.kind == "markdown")):
        if not target.startswith("http"):
            assert ((path.parent / target).exists() or target.removesuffix(".ipynb")
                    in set(books.ORDER) - written), target


def test_sentences_stand_in_their_notebooks():
    for path in books.notebooks():
        text = " ".join("".join(cell.source + " " for cell in books.cells(path)
                                if cell.kind == "markdown").split())
        for sentence, _ in SENTENCES.get(path.stem[:2], []):
            assert " ".join(sentence.split()) in text, f"{path.stem}: {sentence}"


@BOOKS
def test_every_result_is_used(path):
    """What a check makes of the answer is read in a later cell, or, in 18, named by its part."""
    found = [cell for cell in books.cells(path) if cell.kind == "code"]
    for i, cell in enumerate(found):
        if cell.check:
            made = set()
            for node in ast.parse(cell.source).body:
                if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and any(
                        isinstance(part, ast.Name) and part.id in made | JUDGES
                        for part in ast.walk(node.value)):
                    made.add(node.targets[0].id)
            later = [other.source for other in found[i + 1:] if not other.exercise]
            read = {node.id for source in later for node in ast.walk(ast.parse(source))
                    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}
            named = {name for name in made if any(f'"{name}"' in source for source in later)}
            assert made and made & (read | named), f"{cell.check}: its result is never used"


@BOOKS
def test_two_hints_above_each_exercise(path):
    """But in the last one, whose hints are the notebooks before it."""
    found = books.cells(path)
    for before, cell in zip(found, found[1:]):
        if cell.exercise and path.stem != books.ORDER[-1]:
            assert before.kind == "markdown", f"{cell.exercise}: no text above it"
            for hint in ("Hint 1", "Hint 2"):
                assert f"<details><summary>{hint}</summary>\n\n" in before.source, cell.exercise


def test_intermediates_are_named():
    """Results of exercises that are judged one by one under a name, over all notebooks."""
    named = {}
    for path in books.notebooks():
        for function in ast.parse(books.solutions(path).read_text(encoding="utf-8")).body:
            if isinstance(function, ast.FunctionDef) and (path.stem >= "18"
                                                          or "steps" in function.name):
                named[path.stem[:2], function.name] = [
                    key.value for node in ast.walk(function) if isinstance(node, ast.Return)
                    and isinstance(node.value, ast.Dict) for key in node.value.keys
                    if isinstance(key, ast.Constant)]
    assert sum(map(len, named.values())) >= NAMED, named


@BOOKS
def test_pictures_are_described_and_one_has_a_slider(path):
    source = "\n".join(cell.source for cell in books.cells(path) if cell.kind == "code")
    assert "plt.show()" not in source, "use plot.described(figure, words)"
    assert not re.search(r"(?m)^plot\.(strip|paths|curves)\(", source)
    slides = [call for call in ast.walk(ast.parse(source)) if isinstance(call, ast.Call)
              and getattr(call.func, "id", "") == "slide"]
    assert slides, "no slider"
    for call in slides:
        assert {"caption", "x", "y"} <= {option.arg for option in call.keywords}


def test_all_are_there():
    missing = [name for name in books.ORDER if not (books.FOLDER / f"{name}.ipynb").exists()]
    if missing:
        pytest.skip(f"still to be written: {', '.join(missing)}")


@BOOKS
def test_exercises_have_checks_answers_and_wrong_answers(path):
    found = books.cells(path)
    exercises = [cell.exercise for cell in found if cell.exercise]
    if not exercises:
        assert not [cell.check for cell in found if cell.check]
        return
    assert (len(set(exercises)) == len(exercises) and [cell.check for cell in found if cell.check]
            == exercises)
    for cell, after in zip(found, found[1:]):
        if cell.exercise:
            assert after.check == cell.exercise, "the check stands right below its exercise"
            assert ("raise NotImplementedError" in cell.source and f"def {cell.exercise}("
                    in cell.source)
    answers, wrong = books.functions(books.solutions(path)), books.functions(books.wrong(path))
    assert set(exercises) <= set(answers)
    for name in exercises:
        assert (sum(other.startswith(f"{name}__") for other in wrong)
                >= 3), f"{name}: fewer than three wrong answers"
    assert not [name for name in wrong if "__" in name and name.partition("__")[0] not in exercises]
