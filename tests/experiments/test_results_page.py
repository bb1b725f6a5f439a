"""docs/results.md shows what docs/demo.json holds, and pages of measured tables say where their
numbers come from."""

import json
from pathlib import Path
import re

DOCS = Path(__file__).parents[2] / "docs"
PAGES = {path.name: path.read_text(encoding="utf-8") for path in DOCS.glob("*.md")}


def test_the_demo_is_told_as_it_is_stored():
    report = json.loads((DOCS / "demo.json").read_text(encoding="utf-8"))
    numbers, settings = report["rows"][0], report["settings"]
    before = numbers["style distance of T(I)"] / numbers["style distance of held-out content"]
    left, way = numbers["share of the style distance left"], "length of the content's path, cm"
    for words in (f"{settings['hidden']} hidden units, {settings['channels']} channels",
                  f"falls to {100 * left:.0f} % of", f"(to {100 * before:.0f} % before",
                  f"{numbers[way]:.0f} cm long"):
        assert words in PAGES["results.md"], words
    assert numbers["largest distance between the paths, cm"] < 1e-9


def test_a_page_of_numbers_has_a_file_or_says_that_none_is_kept():
    measured = {name for name, text in PAGES.items()
                if len(re.findall(r"^\|.*\d.*\|.*\d.*\|", text, re.MULTILINE)) > 5}
    assert {"recipe.md", "results.md", "bodies.md", "speed.md", "torresani.md",
            "paper_problem.md"} <= measured
    for name in measured - {"departures.md", "conventions.md"}:  # what is so, not what was measured
        stored = [DOCS / file for file in [name.replace(".md", ".json"),
                                           *re.findall(r"[\w.]+\.json", PAGES[name])]]
        dated = re.search(r"[Nn]o file .*kept", PAGES[name]) and re.search(
            r"\d+ November 20\d\d", PAGES[name])
        assert dated or any(map(Path.exists, stored)), name
