"""Readers in JavaScript and C, which use no source of the package, answer what they offer and count
the golden vectors that agree; a fault planted in one is convicted both ways.
"""

import json
from pathlib import Path
import shutil
import subprocess

import pytest

from refimpl.cli import main
from refimpl.conformance.golden import export

HERE = Path(__file__).parent
OFFERED = "conv1d,max_pool1d,relu,gram,mean_squares"
NODE, CC = shutil.which("node"), shutil.which("cc") or shutil.which("gcc")
# What to plant: name, text of reader.js and what replaces it, the same of reader.c.
FAULTS = (
    ("the larger half on the left", ("same: [half, span - half]", "same: [span - half, half]"),
     ("left = span / 2, right", "left = span - span / 2, right")),
    ("one group for all", ("I * Math.floor(o * groups / O) + c", "c"),
     ("o * G / O * I + c", "(pool ? o : c)")),
    ("dilation forgotten", ("u * stride + k * dilation - left", "u * stride + k - left"),
     ("u * stride + k * dilation - left", "u * stride + k - left")),
    ("relu of NaN is 0", ("Math.max(y, 0)", "(y > 0 ? y : 0)"),
     ("if (x.x[i] < 0)", "if (!(x.x[i] > 0))")),
    ("a sum for a mean", (" ** 2) / K", " ** 2)"), ("x.x[i] / size;", "x.x[i];")),
    ("padding of a pool is 0", (".filter((t) => t >= 0 && t < T).map((t)", ".map((t)"),
     ("else if (inside && (e > ", "else if ((e > ")),
    ("a transposed Gram matrix with its sign", ("at(h, n, c, t) * at(h, n, d, t)",
                                                "at(h, n, c, t) * -at(h, n, d, t)"),
     ("y->x[i] += x.x[i / C * T + t]", "y->x[i] -= x.x[i / C * T + t]")))


@pytest.fixture(scope="module")
def golden(tmp_path_factory):
    folder = tmp_path_factory.mktemp("golden")
    export(folder, operations=OFFERED.split(","))
    return folder


def started(language, folder, fault=None):
    """The words that start a reader, with a fault in it if one is given."""
    if (NODE if language == "js" else CC) is None:
        pytest.skip(f"no {'node' if language == 'js' else 'C compiler'} on this machine")
    text = (HERE / f"reader.{language}").read_text()
    if fault:
        right, wrong = fault[1 if language == "js" else 2]
        assert text.count(right) == 1, right
        text = text.replace(right, wrong)
    (folder / f"reader.{language}").write_text(text)
    if language == "js":
        return [NODE, str(folder / "reader.js")]
    subprocess.run([CC, "-O1", "-I", HERE, "-o", folder / "reader", folder / "reader.c", "-lm"],
                   check=True)
    return [str(folder / "reader")]


def asked(words):
    """The command that judges a reader; one that is slow to start stays."""
    return " ".join(words) + (" -" if words[0] == NODE else "")


def agreeing(words, folder):
    """How many golden vectors a reader says agree, of how many."""
    said = subprocess.run([*words, "--golden", folder], capture_output=True, text=True, check=True)
    return [int(word) for word in said.stdout.split() if word.isdigit()]


@pytest.mark.parametrize("language", ["js", "c"])
def test_readers_are_short_and_agree(language, golden, tmp_path, capsys):
    words = started(language, tmp_path)
    assert len((HERE / f"reader.{language}").read_text().splitlines()) <= 80
    agree, offered = agreeing(words, golden)
    assert agree == offered > 80
    report = tmp_path / "report.json"
    assert main(["check", "--command", asked(words), "--operations", OFFERED, "--json",
                 str(report), "--require", "conv1d,gram,relu,mean_squares"]) == 0
    grades = {(row["function"], row["grade"]) for row in json.loads(report.read_text())["rows"]}
    assert grades == {("max_pool1d", "not offered"), *(
        pair for name in OFFERED.split(",") for pair in (
            (name, "agrees"), (f"{name}_backward", "not offered")))}
    assert "max_pool1d (" in capsys.readouterr().out            # ceil_mode alone is not offered


def test_a_reader_in_javascript_is_started_for_each_case_too(tmp_path):
    assert main(["check", "--command", " ".join(started("js", tmp_path)),
                 "--operations", "relu", "--require", "relu"]) == 0


@pytest.mark.parametrize("language", ["js", "c"])
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault[0])
def test_a_fault_in_a_reader_is_convicted(language, fault, golden, tmp_path):
    words = started(language, tmp_path, fault)
    agree, offered = agreeing(words, golden)
    assert agree < offered
    assert main(["check", "--command", asked(words), "--operations", OFFERED]) == 1
