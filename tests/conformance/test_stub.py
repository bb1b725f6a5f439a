"""The ways into the kit: the list of operations, files to fill in, and pytest's decorator."""

import ast
import os
from pathlib import Path
import subprocess
import sys

import pytest

import refimpl
from refimpl import conformance, nn
from refimpl.cli import main
from refimpl.conformance import OPERATIONS, as_backend, cases, judge, judge_all, reference
from refimpl.conformance.explain import documentation, signature
from refimpl.conformance.stub import HEADS, stub

ROOT = Path(refimpl.__file__).parents[1]


def test_the_list_has_a_line_for_each_operation(capsys):
    assert main(["check", "--list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(OPERATIONS)
    for line, operation in zip(lines, OPERATIONS.values()):
        _, gradient, source = line.split(maxsplit=2)
        assert gradient == (f"{operation.name}_backward" if operation.backward else "-")
        assert source == operation.equation or source.startswith("refimpl.")


@pytest.mark.parametrize("library", HEADS)
def test_a_stub_has_every_function_with_its_defaults(library, capsys):
    assert main(["check", "--stub", library]) == 0
    text = capsys.readouterr().out
    assert max(map(len, text.splitlines())) <= 100
    found = {f.name: f for f in ast.parse(text).body if isinstance(f, ast.FunctionDef)}
    wanted = reference().functions if library == "numpy" else OPERATIONS
    assert set(found) == set(wanted)
    for name, function in found.items():
        assert ast.unparse(function.body[-1]) == "raise NotImplementedError"
        operation = OPERATIONS[name.removesuffix("_backward")]
        shown = operation.f if name in OPERATIONS else operation.backward
        assert ast.get_docstring(function).rstrip() == documentation(shown) != ""
        asked = ast.parse(f"def f{signature(operation)}: pass")
        arguments = function.args
        if name not in OPERATIONS:
            del arguments.args[0]                                # the upstream gradient
        assert ast.unparse(arguments) == ast.unparse(asked.body[0].args)


def last_line(said):
    return said.strip().splitlines()[-1]


def test_what_is_not_written_yet_is_not_offered(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = stub("numpy", ["gram", "l1"])
    run = ["--operations", "gram,l1", "--profile", "small"]
    (tmp_path / "blank.py").write_text(text)
    assert main(["check", "blank:BACKEND", *run]) == 1
    said = capsys.readouterr().out
    assert "not offered by the backend: gram, gram_backward, l1, l1_backward" in said
    assert "nothing checked" in said
    written = text.replace("raise NotImplementedError", "return h @ h.swapaxes(1, 2)", 1)
    (tmp_path / "begun.py").write_text(written)
    for how in ([], ["--in-process"]):
        assert main(["check", "begun:BACKEND", *run, *how]) == 0
        said = capsys.readouterr().out
        assert "not offered by the backend: gram_backward, l1, l1_backward" in said
        assert "wrong" not in last_line(said) and "undecidable" not in said
    assert main(["check", "begun:BACKEND", *run, "--require", "gram_backward"]) == 1


@pytest.mark.parametrize("library", ["torch", "jax"])
def test_a_stub_is_wired_with_its_library(library, tmp_path):
    pytest.importorskip(library)
    text = stub(library, ["l1", "relu"])
    written = text.replace("raise NotImplementedError", "return abs(a).sum()", 1)
    found = {}
    exec(written, found)
    grades = {(o.case.function, o.grade) for o in judge_all(
        found["BACKEND"], cases(operations=["l1", "relu"], profile="small")[:12])}
    assert ("l1", "agrees") in grades and ("l1_backward", "agrees") in grades
    assert {o.grade for o in judge_all(found["BACKEND"], cases(
        operations=["relu"], profile="small"))} == {"not offered"}


def test_a_function_that_answers_something_is_no_stub():
    def without_bias(x, w, b=None, **k):
        if b is not None:
            raise NotImplementedError("a bias")
        return nn.conv1d(x, w, b, **k)
    found = {o.grade for o in judge_all({"conv1d": without_bias}, cases(
        operations=["conv1d"], profile="small")) if o.case.function == "conv1d"}
    assert "not offered" not in found and "wrong" in found

    def broken(h):
        raise ValueError("h: found an array, needed another")
    found = judge_all({"gram": broken}, cases(operations=["gram"], profile="small"))
    assert {o.grade for o in found if o.case.function == "gram"} == {"wrong", "undecidable"}
    # one case alone cannot tell a stub from an option that is not taken
    alone = conformance.case("conv1d/plain/forward/float64")
    assert judge(alone, {"conv1d": without_bias}).status == "failed"


def test_unknown_names_are_refused(capsys):
    assert main(["check", "--stub", "numpy", "--operations", "gramm"]) == 2
    assert "do you mean gram?" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["check", "--stub", "fortran"])


MINE = """\
MINE = {"gram": lambda h: h @ h.swapaxes(1, 2), "l1": lambda a: abs(a).sum() / 2,
        "lacks": ["float32"]}
"""
TESTS = """\
from mine import MINE
from refimpl import conformance

@conformance.parametrize(MINE)
def test_mine(case, backend):
    case.check(backend)
"""


@pytest.mark.parametrize("processes", ["0", "2"])
def test_a_case_is_a_test_of_pytest(tmp_path, processes):
    (tmp_path / "mine.py").write_text(MINE)
    (tmp_path / "test_mine.py").write_text(TESTS)
    run = subprocess.run([sys.executable, "-m", "pytest", "-q", "-rA", "-n", processes, "-p",
                          "no:cacheprovider", "--rootdir", ".", "."], cwd=tmp_path, text=True,
                         capture_output=True, env={**os.environ, "PYTHONPATH": str(ROOT)})
    ended = {line.split(" - ")[0] for line in run.stdout.splitlines()
             if line.startswith(("PASSED", "FAILED"))}
    found = {}
    exec(MINE, found)
    outcomes = [judge(c, found["MINE"]) for c in cases(
        operations=["gram", "l1"], profile="small", supported_by=found["MINE"])]
    assert ended == {f"{o.status.upper()} test_mine.py::test_mine[{o.case.id}]" for o in outcomes
                     if o.grade != "not offered"}
    assert "PASSED test_mine.py::test_mine[gram/plain/forward/float64]" in ended
    assert "FAILED test_mine.py::test_mine[l1/plain/forward/float64]" in ended


def test_parametrize_takes_what_is_offered():
    mine = {"gram": nn.gram, "relu": nn.relu, "lacks": ["float32"]}
    marked = conformance.parametrize(mine, operations=["relu"], seed=3).args[1]
    again = conformance.parametrize(mine, operations=["relu"], seed=3).args[1]
    assert [m.id for m in marked] == [m.id for m in again] and len({m.id for m in marked}) > 5
    for one in marked:
        chosen, backend = one.values
        assert one.id == chosen.id and chosen.operation.name == "relu" and chosen.seed == 3
        assert backend.functions == as_backend(mine).functions
        assert chosen.kind == "refused" or chosen.precision == "float64"
    with pytest.raises(ValueError, match="found norm, needed some that the backend offers"):
        conformance.parametrize(mine, operations=["norm"])
    with pytest.raises(ValueError, match="do you mean gram?"):
        conformance.parametrize(mine, operations=["gramm"])
    core = conformance.parametrize(mine, operations=["relu"], profile="core").args[1]
    assert len(core) > len(marked)
