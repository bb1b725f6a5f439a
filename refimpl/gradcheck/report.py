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
    one found;  resolves : what could still be told, relative to the gradient's largest element
    """

    name: str
    exact: bool
    approximate: bool
    difference: float
    checked_by: str
    resolves: float = float("nan")


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
    """All rows, what failed, what could not be decided, and what else was looked at; prints as the
    table of `verdicts` with all of that below it.
    """

    rows: tuple[Row, ...]
    failures: tuple[str, ...]
    undecided: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether nothing failed, and nothing is undecided."""
        return not self.failures and not self.undecided

    def __str__(self) -> str:
        told = [f"{row.name}: told to {row.resolves:.0e} of its largest element"
                for row in self.rows if row.resolves == row.resolves]
        return "\n".join([*verdicts(self.rows), *told, *self.notes,
                          *(f"FAILED {f}" for f in self.failures),
                          *(f"UNDECIDED {u}" for u in self.undecided), *["passed"] * self.passed])
