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


def test_how_well_results_stand_is_that_of_its_file():
    report = json.loads((DOCS / "ground.json").read_text(encoding="utf-8"))
    page, (legs,) = (DOCS / "results.md").read_text(encoding="utf-8"), [
        row for row in report["rows"] if row["table"] == "legs"]
    lines = pages.standing(report)
    assert len(lines) == 3 and all(text in page for text in lines)
    departures = (DOCS / "departures.md").read_text(encoding="utf-8")
    said = (f"Of {legs['clips']} real takes (bandai2, CC BY-NC 4.0) the legs' jerk rises by "
            "{:.0%}, and of the {:.1f} cm/s that planted feet slide {:.1f} are left")
    said = said.format(legs["legs' jerk"] - 1, legs["slide before"], legs["slide"])
    assert said.replace("%", " %") in departures
