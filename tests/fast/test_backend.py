"""The conformance kit judges the fast room as it judges a stranger's: with cases that enter it, and
with faults planted in it, written by somebody who had not seen the kit."""

import importlib
from pathlib import Path
import shutil
import sys

import pytest

from refimpl.cli import main
from refimpl.conformance import cases, judge_all
from refimpl.fast import BACKEND, backend, spectral
from tests.fast.faults import FAULTS

OFFERED = sorted({name.removesuffix("_backward") for name in BACKEND})


def judged(functions, operations=OFFERED, seed=0):
    """Outcomes of the cases of what is offered."""
    return [o for o in judge_all(functions,
                                 cases(seed=seed, operations=operations, profile="small"))
            if o.status != "skipped"]


@pytest.mark.parametrize("seed", [0, 1])
def test_the_kit_finds_that_it_agrees(seed):
    assert [o.message for o in judged(BACKEND, seed=seed) if o.status != "passed"] == []


def test_extremes_differ_where_the_list_beside_says_and_nowhere_else(capsys):
    beside = str(Path(__file__).with_name("backend.xfail"))
    assert main(["check", "refimpl.fast:BACKEND", "--xfail", beside, "--operations",
                 ",".join(OFFERED)]) == 0, capsys.readouterr().out


def test_at_least_a_hundred_cases_enter_the_fast_path(monkeypatch):
    """A case enters it when a convolution plan is made while its backend answers."""
    made = []

    class Watched(spectral.Plan):
        def __init__(self, *arguments, **options):
            made.append(arguments)
            super().__init__(*arguments, **options)

    for name in ("conv", "stylist", "gradients", "autoencoder", "backend"):
        monkeypatch.setattr(importlib.import_module(f"refimpl.fast.{name}"), "Plan", Watched)
    entered = 0
    for case in cases(operations=OFFERED, profile="small"):
        made.clear()
        assert all(o.status in ("passed", "skipped") for o in judge_all(BACKEND, [case]))
        entered += bool(made)
    assert entered >= 100, entered


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault[0])
def test_a_fault_planted_in_it_is_caught(fault, tmp_path, monkeypatch):
    """The room is copied, the fault planted in the copy, and the copy judged."""
    _, file, old, new, _ = fault
    folder = tmp_path / "broken_fast"
    shutil.copytree(Path(backend.__file__).parent, folder,
                    ignore=shutil.ignore_patterns("__pycache__"))
    text = (folder / file).read_text()
    assert text.count(old) == 1
    (folder / file).write_text(text.replace(old, new))
    for path in folder.glob("*.py"):
        path.write_text(path.read_text().replace("from .. import", "from refimpl import")
                        .replace("from ..", "from refimpl."))
    monkeypatch.syspath_prepend(tmp_path)
    try:
        broken = importlib.import_module("broken_fast").BACKEND
        assert any(o.status == "failed" for o in judged(broken))
    finally:
        for name in [name for name in sys.modules if name.startswith("broken_fast")]:
            del sys.modules[name]
