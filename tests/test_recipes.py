"""The recipes of CONTRIBUTING.md, tried from outside the package; and what still lacks its
specification, its planted fault, its test or its line in the map.
"""

from dataclasses import replace
from pathlib import Path
import re

import numpy as np
import pytest

from refimpl import nn
from refimpl.cli import parser
from refimpl.conformance import OPERATIONS, cases, judge_all
from refimpl.conformance.specification import Operation, Sample
from refimpl.conformance.verify import verify_operation
from refimpl.embedded import walkers
from refimpl.holden2017.objective import EQUATION_10
from refimpl.motion import joints, names
from refimpl.motion.mapping import map_clip
from tests.conformance.faults import FAULTS

ROOT = Path(__file__).parent.parent


def elu(x):
    """x above 0, exp(x) - 1 below."""
    return np.where(x.real > 0, x, np.expm1(x))


def elu_backward(dy, x):
    """dx = dy above 0, dy exp(x) below."""
    return dy * np.where(x > 0, 1.0, np.exp(np.minimum(x, 0)))


def elu_in_loops(x):
    """The same, element by element."""
    y = np.array(x)
    for place in np.ndindex(x.shape):
        y[place] = x[place] if x[place].real > 0 else np.exp(x[place]) - 1
    return y


def specified(backward):
    """The record that a new operation needs."""
    def samples(rng):
        return [Sample("both sides", (rng.standard_normal((2, 3, 4)),)),
                Sample("no clip", (np.zeros((0, 3, 4)),))]

    return Operation("elu", ("x",), elu, backward, elu_in_loops, samples, equation="elu")


def test_a_new_operation_is_verified_and_a_fault_in_it_is_caught(monkeypatch):
    for backward, right in ((elu_backward, True), (lambda dy, x: dy.copy(), False)):
        monkeypatch.setitem(OPERATIONS, "elu", specified(backward))
        assert (verify_operation(OPERATIONS["elu"]).failures == ()) == right
    monkeypatch.setitem(OPERATIONS, "elu", specified(elu_backward))
    outcomes = list(judge_all({"elu": lambda x: np.maximum(x, 0)}, cases(operations=["elu"])))
    assert any(outcome.status == "failed" for outcome in outcomes)


def test_a_new_skeletons_word_is_one_entry(monkeypatch):
    clip = walkers.make_clip("walk", "normal", seconds=1.0).clip
    strange = replace(clip, joints=tuple(replace(j, name=j.name.replace("ForeArm", "Unterarm"))
                                         for j in clip.joints))
    slot = joints.SLOT["LeftForeArm"]
    assert map_clip(strange).how[slot] == "tree"
    monkeypatch.setitem(names.PLACES["Arm"], "unterarm", (2,))
    monkeypatch.setattr(names, "KNOWN", names.KNOWN | {"unterarm"})
    assert map_clip(strange).how[slot] == "name"


def test_every_operation_has_its_specification_fault_test_and_line_in_the_map():
    texts = {path: path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("*.py")}
    pages = "".join(path.read_text(encoding="utf-8")
                    for path in (ROOT / "README.md", *(ROOT / "docs").rglob("*.md")))
    faulty = {fault.function.removesuffix("_backward") for fault in FAULTS}
    public = {name.removesuffix("_backward") for name in dir(nn) if name.endswith("_backward")}
    lacking = [f"{name}: no specification"
               for name in public | {f"{term.name}_loss" for term in EQUATION_10}
               if name not in OPERATIONS]
    lacking += [f"{name}: no planted fault" for name in OPERATIONS if name not in faulty]
    lacking += [f"{name}: no test names it" for name in public
                if not any(name in text for text in texts.values())]
    commands = next(action for action in parser()._actions if hasattr(action, "choices")
                    and isinstance(action.choices, dict)).choices
    lacking += [f"refimpl {name}: no line in the README or docs" for name in commands
                if not re.search(rf"refimpl {name}\b", pages)]
    lacking += [f"refimpl {name}: no test" for name in commands
                if not any(f'"{name}"' in text or f"{name} " in text for text in texts.values())]
    assert lacking == []
