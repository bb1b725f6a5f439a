"""What docs/paper_problem.md and docs/score.md show is what their JSON says."""

import json
from pathlib import Path

import pytest

import refimpl

from . import pages

DOCS = Path(refimpl.__file__).parents[1] / "docs"
REPORT = json.loads((DOCS / "paper_problem.json").read_text(encoding="utf-8"))
TABLES = pages.all_tables(REPORT)


@pytest.mark.parametrize("name", TABLES)
def test_each_table_is_that_of_the_json(name):
    page = "score.md" if name == "bounds" else "paper_problem.md"
    assert "\n".join(TABLES[name]) in (DOCS / page).read_text(encoding="utf-8")


def test_no_clip_is_learnt_on_and_shown():
    parts = {part: set(names) for part, names in REPORT["split"].items()}
    for learnt in ("loss", "learn", "exemplars", "judges"):
        for shown in ("contents", "real"):
            assert not parts[learnt] & parts[shown]
    assert not parts["exemplars"] & parts["judges"]
