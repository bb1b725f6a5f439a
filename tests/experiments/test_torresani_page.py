"""docs/torresani.md shows what docs/torresani.json holds, cell by cell."""

import json
from pathlib import Path

from refimpl.experiments import learning

DOCS = Path(__file__).parents[2] / "docs"


def shown(value):
    return (f"{value:g}" if isinstance(value, (int, float)) else
            " ".join(f"{x:g}" for x in value))


def rows_of(part):
    """Every row that the page must show of one set of clips."""
    for table in part.get("table 1", {}).values():
        yield from learning.table_rows(table)[1:]
    for key, found in part.items():
        if key.startswith(("blends", "known", "newcomers")):
            yield ["", *map(shown, found.values())]
        elif key in ("contents", "synthesis"):
            yield from ([way, *map(shown, row.values())] for way, row in found.items()
                        if isinstance(row, dict))


def test_page_shows_the_stored_numbers():
    stored = json.loads((DOCS / "torresani.json").read_text())
    sections = (DOCS / "torresani.md").read_text().split("\n### ")[1:]
    assert [section.split("\n")[0] for section in sections] == list(stored)
    for section, part in zip(sections, stored.values()):
        wanted = [f"| {' | '.join(row)} |" for row in rows_of(part)]
        tables = section.split("\n")
        assert len(wanted) > 3 and [row for row in wanted if row not in tables] == []
        numbers = [line for line in tables if line.startswith("|") and any(map(str.isdigit, line))]
        assert [line for line in numbers if line not in wanted and "model" not in line] == []
