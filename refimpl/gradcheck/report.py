"""What a check says of each input, and tables in plain text."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass


def columns(rows: Sequence[Sequence[str]], align: str = "<>", between: str = "  ") -> list[str]:
    """Rows of cells as lines whose columns stand below each other.

    align : "<" or ">" for each column, the last one for all that follow

    >>> columns([["name", "size"], ["x", "12"]])
    ['name  size', 'x       12']
    """
    align += align[-1] * len(rows[0])
    widths = [max(map(len, column)) for column in zip(*rows)]
    return [between.join(f"{cell:{side}{width}}" for cell, side, width in zip(row, align, widths))
            .rstrip() for row in rows]


@dataclass(frozen=True)
class Row:
    """One input's verdict.

    exact : equal to the last bit;  approximate : within the tolerance;  difference : the largest
    one found
    """

    name: str
    exact: bool
    approximate: bool
    difference: float
    checked_by: str


def verdicts(rows: Iterable[Row]) -> list[str]:
    """The table `name | exact | approximate | max difference | checked by`.

    >>> print(*verdicts([Row("x", True, True, 0.0, "complex step")]), sep="\\n")
    name | exact | approximate | max difference | checked by
    x    | True  | True        |      0.000e+00 | complex step
    """
    cells = [(row.name, str(row.exact), str(row.approximate), f"{row.difference:.3e}",
              row.checked_by) for row in rows]
    return columns([("name", "exact", "approximate", "max difference", "checked by"), *cells],
                   align="<<<><", between=" | ")


@dataclass(frozen=True)
class Report:
    """All rows, and what failed; prints as the table of `verdicts` with the failures below it."""

    rows: tuple[Row, ...]
    failures: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Whether nothing failed."""
        return not self.failures

    def __str__(self) -> str:
        return "\n".join([*verdicts(self.rows), *(f"FAILED {f}" for f in self.failures),
                          *["passed"] * self.passed])
