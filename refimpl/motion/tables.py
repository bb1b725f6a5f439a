"""Small tables that people write: labels, mappings, results."""

import csv
import itertools
from pathlib import Path


def read_table(path: str | Path, layout: str, refusal: type[ValueError]) -> list[list[str]]:
    """A small CSV file as lists of stripped cells, one a line.   Raises `refusal`, OSError."""
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            rows = [[cell.strip() for cell in row] for row in csv.reader(file, strict=True)]
    except (UnicodeDecodeError, csv.Error) as error:
        raise refusal(f"{path}: found {error}, needed UTF-8 text with {layout}") from None
    for cell in itertools.chain.from_iterable(rows):
        if any(ord(letter) < 32 for letter in cell):
            raise refusal(f"{path}: found {cell[:80]!r}, needed {layout} without line breaks and "
                          "the like in a cell; is a quotation mark left open?")
    return rows
