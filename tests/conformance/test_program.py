"""A program in any language is judged as a backend is, and by nothing but what it writes."""

from dataclasses import replace
import json
from pathlib import Path
import subprocess
import sys
from xml.etree import ElementTree

import numpy as np
import pytest

from refimpl.cli import main
from refimpl.conformance import BackendError, case, cases
from refimpl.conformance.golden import export
from refimpl.conformance.program import judge_program, write_call
from refimpl.conformance.vectors import read_npy

# A program that knows gram and relu forwards and backwards, and another behaviour for each word.
PROGRAM = r'''
import json, os, signal, sys, time
import numpy as np

def gram(h): return h @ h.swapaxes(1, 2)
def gram_backward(d, h): return (d + d.swapaxes(1, 2)) @ h
def relu(x): return np.maximum(x, 0)
def relu_backward(d, x): return np.where(x > 0, d, d.dtype.type(0))
KNOWN = {f.__name__: f for f in (gram, gram_backward, relu, relu_backward)}
how, calls = sys.argv[1], 0

class Leave(Exception): pass

def answer(folder):
    global calls
    calls += 1
    with open(os.path.join(folder, "case.json")) as file:
        call = json.load(file)
    with open("log", "a") as file:
        file.write(f"{os.getpid()} {call['id']}\n")
    name = call["function"]
    if name not in KNOWN or (how == "no float32" and call["precision"] == "float32"):
        raise Leave(3, "" if name not in KNOWN else "float32")
    inputs = [np.load(os.path.join(folder, given["array"] + ".npy")) for given in call["arguments"]]
    if name.startswith("gram") and inputs[-1].ndim != 3 or inputs[-1].dtype.kind != "f":
        if how == "crashes at what is bad":
            os.kill(os.getpid(), signal.SIGSEGV)
        if how != "lax":
            raise Leave(7, "needed another x")
        inputs[-1] = np.zeros((1, 1, 1))                         # whose answers nobody can count
        np.save(os.path.join(folder, "out1.npy"), inputs[-1])
    y = KNOWN[name](*inputs)
    path = os.path.join(folder, "out0.npy")
    if name == "relu":
        if how == "wide": y = y.astype(float)
        elif how == "one axis more": y = y[None]
        elif how == "flat": y = y.ravel()
        elif how == "Fortran order": y = np.array(y, order="F")
        elif how == "big-endian": y = y.astype(y.dtype.newbyteorder(">"))
        elif how == "words": y = y.astype(str)
        elif how == "whole numbers": y = y.astype(int)
        elif how == "noise": y = y + np.random.rand() * 1e-9
        elif how == "one more": np.save(os.path.join(folder, "out1.npy"), y)
        elif how == "refuses NaN" and np.isnan(y).any(): raise Leave(1, "NaN is not for me")
        elif how == "refuses no clips" and not y.size: raise Leave(1, "needed a clip")
        elif how == "refuses all": raise Leave(1, "not today")
        elif how == "nothing": return
        elif how == "hangs": time.sleep(1e6)
        elif how == "crashes": os.kill(os.getpid(), signal.SIGSEGV)
        elif how == "leaves": os._exit(0)
        elif how == "talks": print("one moment"); sys.stdout.flush()
        elif how == "talks for ever":
            while True: print("x" * 9999, end="", flush=True)
        elif how == "another nought": print("\N{ARABIC-INDIC DIGIT ZERO}", flush=True); return
        elif how == "closes": os.close(1); time.sleep(1e6)
        elif how == "signal 40": os.kill(os.getpid(), 40)
    if name == "gram" and how == "frames": y = y / y.dtype.type(max(inputs[0].shape[2], 1))
    if name == "gram_backward" and how == "frames" and inputs[1].shape[2] == 1:
        raise Leave(3, "T 1")
    if name == "gram_backward" and how == "absolute": y = gram_backward(abs(inputs[0]), inputs[1])
    np.save(path, y)
    if name == "relu" and how in ("truncated", "longer", "empty"):
        with open(path, "rb+") as file:
            file.truncate(0 if how == "empty" else os.path.getsize(path) - 4)
            if how == "longer": file.seek(0, 2); file.write(b"123456789")

def status(folder):
    try:
        answer(folder)
    except Leave as leave:
        return leave.args
    return 0, ""

if sys.argv[2] == "-":
    for line in sys.stdin:
        code, words = status(line.strip())
        print(f"{min(code, 3) if code != 7 else 1} {words}", flush=True)
else:
    code, words = status(sys.argv[2])
    print("a warning\n" + words, file=sys.stderr)
    sys.exit(code)
'''


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Judge the program, which behaves as told.   ->  status, report, text"""
    (tmp_path / "prog.py").write_text(PROGRAM)
    monkeypatch.chdir(tmp_path)

    def _run(how, *more, stays=True, operations="gram,relu"):
        words = f"'{sys.executable}' prog.py '{how}'" + " -" * stays
        Path("log").unlink(missing_ok=True)
        status = main(["check", "--command", words, "--operations", operations,
                       "--json", "out.json", *more])
        return status, json.loads(Path("out.json").read_text()), capsys.readouterr().out
    return _run


def grades(report, function):
    return {row["grade"] for row in report["rows"] if row["function"] == function}


def test_a_program_that_is_right_agrees(run):
    status, report, text = run("well", "--require", "all")
    assert status == 0 and report["settings"]["profile"] == "small"
    assert {row["grade"] for row in report["rows"]} == {"agrees"}
    asked = {case.kind for case in cases(operations=["gram"], profile="small")}
    kinds = {row["case"].rpartition("/")[2] for row in report["rows"]}
    assert {"float64", "float32", "empty batch", "refused", "same bits twice",
            "linear in the upstream gradient"} == kinds < asked      # memory is nobody's there
    assert len({line.split()[0] for line in Path("log").read_text().splitlines()}) == 1


def test_it_is_started_for_each_case_unless_it_stays(run):
    status, report, _ = run("well", "--require", "gram", stays=False, operations="gram")
    calls = Path("log").read_text().splitlines()
    assert status == 0 and len({line.split()[0] for line in calls}) == len(calls) > 20


def test_what_is_not_offered_is_no_failure(run):
    status, report, text = run("no float32", operations="gram,relu,norm")
    assert status == 0 and grades(report, "norm") == {"not offered"}
    assert "not offered by the backend: gram (float32)" in text
    assert "norm, norm_backward" in text
    wanted = {row["case"] for row in report["rows"] if row["dtype"] == "float32"
              or row["function"].startswith("norm")}
    assert wanted == {row["case"] for row in report["rows"] if row["grade"] == "not offered"}
    assert run("no float32", "--require", "gram")[0] == 1
    assert run("well", operations="norm")[0] == 1                # nothing checked


WRONG = {
    "wide": "found dtype float64, needed float32", "one axis more": "found shape",
    "flat": "found shape", "Fortran order": "Fortran order, needed", "big-endian": "found >f",
    "words": "found <U", "whole numbers": "found dtype int64", "nothing": "found None",
    "one more": "writes out1.npy, needed out0.npy alone", "truncated": "bytes of numbers",
    "longer": "bytes of numbers", "empty": "writes out0.npy", "noise": "other bits",
    "leaves": "ends without an answer (exit status 0)", "crashes": "crashes (SIGSEGV)",
    "talks": "needed a line", "signal 40": "crashes (signal 40)",
    "talks for ever": "goes on beyond 65536 bytes", "another nought": "needed a line"}


@pytest.mark.parametrize("how", WRONG)
def test_answers_are_read_strictly(run, how):
    status, report, text = run(how)
    assert status == 1 and WRONG[how] in " ".join(row["message"] for row in report["rows"])
    assert "wrong" in grades(report, "relu") and grades(report, "gram") == {"agrees"}
    assert "convention" not in grades(report, "relu")


def test_a_crash_is_no_refusal_and_is_not_asked_for_ever(run):
    _, report, _ = run("crashes", stays=False, operations="relu")
    rows = [row["grade"] for row in report["rows"] if row["function"] == "relu"]
    assert rows.count("wrong") == 3 and set(rows) == {"wrong", "undecidable"}
    assert grades(report, "relu_backward") == {"agrees"}


def test_a_crash_at_what_is_to_be_refused_is_no_refusal(run):
    status, report, _ = run("crashes at what is bad", operations="relu")
    wrong = [row["case"] for row in report["rows"] if row["grade"] == "wrong"]
    assert status == 1 and wrong and all(name.endswith("/refused") for name in wrong)


def test_a_program_that_closes_its_output(run):
    _, report, text = run("closes", "--time-limit", "3", operations="relu")
    assert "closes its standard output" in text and grades(report, "relu_backward") == {"agrees"}


@pytest.mark.parametrize("stays", [True, False])
def test_a_program_that_hangs(run, stays):
    status, report, text = run("hangs", "--time-limit", "3", stays=stays, operations="relu")
    assert status == 1 and "gives no answer within 3 s (it hangs)" in text
    assert "undecidable" in grades(report, "relu") and grades(report, "relu_backward") == {"agrees"}


def test_refusals_are_graded_and_say_why(run):
    status, report, text = run("refuses NaN", stays=False, operations="relu")
    row = next(r for r in report["rows"] if r["grade"] == "wrong")
    assert status == 1 and "Refused: exit status 1: NaN is not for me" in row["message"]
    assert run("refuses all")[0] == 1
    status, report, _ = run("refuses no clips")
    assert status == 0 and grades(report, "relu") == {"agrees", "stricter"}
    assert run("refuses no clips", "--require", "relu")[0] == 1
    status, report, _ = run("lax")
    assert status == 0 and grades(report, "gram") == {"agrees", "laxer"}
    assert run("lax", "--require", "gram")[0] == 1


def test_promises_and_conventions_are_judged_too(run):
    status, report, text = run("absolute")
    assert status == 1 and "is not linear in the upstream gradient" in text
    status, report, text = run("frames")
    assert "It matches a Gram matrix divided by the frames" in text
    assert grades(report, "gram_backward") == {"agrees", "not offered"}
    assert "not offered by the backend: gram_backward (T 1)" in text


def test_how_to_see_a_failure_again(run):
    _, _, text = run("frames")
    lines = [line.strip() for line in text.splitlines() if line.startswith("    ")]
    assert lines[:2] == ["from refimpl.conformance import case",
                         "c = case('gram/plain/forward/float32', seed=0)"]
    exec("\n".join(lines[:4]), {})
    assert sorted(path.name for path in Path("call").iterdir()) == ["case.json", "in0.npy"]
    how = lines[3].partition("then: ")[2]
    assert how == f"echo call | '{sys.executable}' prog.py 'frames' -"
    subprocess.run(how, shell=True, check=True, capture_output=True)
    assert Path("call", "out0.npy").exists()
    lines = run("frames", stays=False)[2].splitlines()
    assert any(line.endswith(f"then: '{sys.executable}' prog.py 'frames' call") for line in lines)


def test_the_folder_of_a_call(tmp_path):
    call = case("conv1d/asymmetric padding/backward/float32")
    write_call(tmp_path, call)
    told = json.loads((tmp_path / "case.json").read_text())
    assert told["function"] == "conv1d_backward" and told["precision"] == "float32"
    assert [given["name"] for given in told["arguments"]] == ["upstream gradient", "x", "w", "b"]
    assert told["attributes"] == {
        "padding": {"value": [0, 3]}, "stride": {"value": 1, "default": True},
        "dilation": {"value": 1, "default": True}, "groups": {"value": 1, "default": True}}
    assert told["outputs"][1] == {"name": "gradient of w", "array": "out1", "dtype": "float32"}
    x = read_npy((tmp_path / "in1.npy").read_bytes())
    assert np.array_equal(x, call.arguments[1]) and x.dtype == np.float32
    assert not list(tmp_path.glob("out*"))


def test_a_number_that_json_does_not_have_is_an_array(tmp_path):
    call = next(c for c in cases(operations=["adam_step"], profile="small"))
    write_call(tmp_path, replace(call, attributes={**call.attributes, "rate": float("-inf")}))
    told = json.loads((tmp_path / "case.json").read_text())["attributes"]
    assert told["rate"] == {"array": "attribute_rate", "dtype": "float64", "shape": []}
    assert read_npy((tmp_path / "attribute_rate.npy").read_bytes()) == float("-inf")


def test_flags_work_and_what_cannot_be_used_is_refused(run, capsys):
    export("golden", operations=["gram", "relu"])
    status, report, text = run("frames", "--golden", "golden", "--junit", "out.xml")
    assert status == 1 and "golden vectors agree" in text and "golden_case('golden'" in text
    assert ElementTree.parse("out.xml").getroot().get("failures") != "0"
    Path("known").write_text("gram/*/forward/*\n")
    status, report, text = run("frames", "--xfail", "known")
    assert status == 0 and "xfailed" in text
    status, report, _ = run("well", "--profile", "tf32", "--seed", "3")
    assert status == 0 and {row["case"].rpartition("/")[2] for row in report["rows"]} == {"tf32"}
    for words, said in ((["--command", "no-such-program x"], "no-such-program"),
                        (["--command", ""], "needed a program"), (["--command", "'"], "a program"),
                        (["--command", "./prog.py"], "needed a program"),
                        (["a:B", "--command", "ls"], "a:B"),
                        (["--command", "ls", "--in-process"], "--in-process")):
        assert main(["check", *words]) == 2
        err = capsys.readouterr().err
        assert err.count("\n") == 1 and said in err
    Path("prog").write_text("no program")
    Path("prog").chmod(0o755)
    assert main(["check", "--command", "./prog", "--operations", "relu"]) == 2


def test_a_program_ends_with_the_judge(tmp_path, monkeypatch):
    (tmp_path / "prog.py").write_text(PROGRAM)
    monkeypatch.chdir(tmp_path)
    found = judge_program(f"'{sys.executable}' prog.py well -", cases(
        operations=["relu"], profile="small"))
    assert next(found).functions["relu"] and next(found).grade == "agrees"
    pid = Path("log").read_text().split()[0]
    assert subprocess.run(["ps", "-p", pid], capture_output=True).returncode == 0
    found.close()
    assert subprocess.run(["ps", "-p", pid], capture_output=True).returncode == 1
    with pytest.raises(BackendError):
        next(judge_program("nothing-of-this-name", []))
