"""What a reader meets in every file: lines that fit, types, examples, one place for each equation,
few steps into the first of them.
"""

import ast
from collections import Counter
from pathlib import Path
import re
import sys

import numpy as np
import pytest

import refimpl
from refimpl.holden2017 import networks

ROOT = Path(refimpl.__file__).parent
TEXTS = {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
         for path in sorted(ROOT.rglob("*.py"))}


def functions(text):
    """Public functions and methods of a file, inner ones too."""
    return [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef)
            and not node.name.startswith("_")]


@pytest.mark.parametrize("name", TEXTS)
def test_lines_fit_and_public_functions_are_typed(name):
    assert [line for line in TEXTS[name].splitlines() if len(line) > 100] == []
    assert [node.name for node in functions(TEXTS[name]) if node.returns is None] == []


def test_a_hundred_definitions_show_an_example():
    shown = sum(">>>" in (ast.get_docstring(node) or "") for text in TEXTS.values()
                for node in ast.walk(ast.parse(text))
                if isinstance(node, (ast.FunctionDef, ast.ClassDef)))
    assert shown >= 100


@pytest.mark.parametrize("paper, rooms, equations",
                         [("Holden 2017", ("nn/", "holden2017/"), 10),
                          ("Torresani 2006", ("torresani2006/",), 12)])
def test_each_equation_has_one_defining_place(paper, rooms, equations):
    found = [(int(number), name) for name,
             text in TEXTS.items() for number in re.findall(rf"{paper}, Equation (\d+)", text)]
    assert (Counter(number for number, _ in found)
            == {number: 1 for number in range(1, equations + 1)})
    assert all(name.startswith(rooms) for _, name in found)


def test_one_steps_through_five_files_and_nine_functions_into_equation_1():
    rng = np.random.default_rng(0)
    params, X, seen = (networks.init_loss_network(rng),
                       rng.normal(size=(1, 66, 240)).astype(np.float32), set())

    def note(frame, event, _):
        if event == "call" and frame.f_code.co_filename.startswith(str(ROOT)):
            seen.add((frame.f_code.co_filename, frame.f_code.co_name))

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        networks.encode(X, params)
    finally:
        sys.setprofile(before)
    assert len({file for file, _ in seen}) <= 5 and len(seen) <= 9, sorted(seen)


def test_the_papers_rooms_import_nothing_fast():
    for name, text in TEXTS.items():
        if name.startswith(("nn/", "holden2017/", "holden2016/", "torresani2006/")):
            assert ("kernels=" not in text
                    and not re.search(r"^from \.+fast", text, re.MULTILINE)), name
