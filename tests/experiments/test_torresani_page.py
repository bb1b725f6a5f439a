"""docs/torresani.md shows what docs/torresani.json holds: the tables below "Tables" are those that
`python -m tests.experiments.test_torresani_page` writes there.
"""

import json
from pathlib import Path

from refimpl.commands.torresani_experiment import TABLES
from refimpl.experiments import learning

DOCS = Path(__file__).parents[2] / "docs"
BEFORE = "## Tables\n\n"


def shown(value):
    """A cell: a number, a mean with its standard error, or one number for each effort."""
    if not isinstance(value, list):
        return f"{value:g}" if isinstance(value, (int, float)) else ""
    return (" ± " if len(value) == 2 else " ").join(f"{x:g}" for x in value)


def lines(rows):
    head, *others = rows
    return ["", *(f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *others))]


def tables(stored):
    """The lines below "Tables": a section for each set of clips, a table for each of its keys."""
    for data, part in stored.items():
        yield f"### {data}: {part['fragments']} fragments, {part['performers']} performers"
        for labels, table in part.get("table 1", {}).items():
            yield from ["", f"Table 1, {labels}:", *lines(learning.table_rows(table))]
        for name in TABLES:
            table = part.get(name)
            if table and name != "table 1":
                columns = list(dict.fromkeys(word for row in table.values() for word in row))
                yield from lines([[name, *columns], *(
                    [row, *(shown(values.get(word)) for word in columns)]
                    for row, values in table.items())])
        yield ""


def page():
    return "\n".join(tables(json.loads((DOCS / "torresani.json").read_text()))).rstrip() + "\n"


def test_page_shows_the_stored_numbers():
    before, after = (DOCS / "torresani.md").read_text().split(BEFORE)
    assert after == page() and after.count("Table 1, ") >= 4


if __name__ == "__main__":
    text = (DOCS / "torresani.md").read_text().split(BEFORE)[0]
    (DOCS / "torresani.md").write_text(text + BEFORE + page())
