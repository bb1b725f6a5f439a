"""The floating-point text lies as near to the exact answer as its roundings allow."""

import numpy as np
import pytest

from refimpl import nn
from tests.proof.rounding import ROWS, UNIT, allowed, measured, table


@pytest.mark.parametrize("precision", UNIT)
@pytest.mark.parametrize("row", ROWS, ids=str)
def test_no_result_is_further_from_the_exact_one_than_its_roundings(row, precision):
    errors = measured(row, precision)
    assert len(errors) == len(row.roundings)
    assert all(error <= allowed(n, precision) for error, n in zip(errors, row.roundings))


@pytest.mark.parametrize("row", [row for row in ROWS if max(row.roundings)], ids=str)
def test_numbers_rounded_to_float32_on_the_way_are_seen_in_float64(row):
    def rounded(*inputs, **options):
        return row.f(*(x.astype(np.float32) for x in inputs), **options)
    errors = measured(row, "float64", rounded)
    assert all(error > allowed(n, "float64") for error, n in zip(errors, row.roundings))


def test_a_term_that_is_lost_is_seen_in_float32():
    def without_a_tap(x, w, b):
        w = w.copy()
        w[0, 0, 12] = 0
        return nn.conv1d(x, w, b)
    row, = (row for row in ROWS if row.roundings == (401,))
    assert measured(row, "float32", without_a_tap)[0] > allowed(401, "float32")


def test_the_table_has_a_line_for_each_result():
    lines = list(table(ROWS[2:4]))
    assert len(lines) == 1 + 1 + 3
    assert len({len(line) for line in lines}) == 1
