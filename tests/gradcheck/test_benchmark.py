"""The benchmark of checkers, with two draws of each case: nothing false is said, nothing wrong is
accepted, and the benchmark itself tells a true sentence from a false one.
"""

import numpy as np
import pytest

from tests.gradcheck.benchmark import ours
from tests.gradcheck.cases import WRONG
from tests.gradcheck.cases_right import RIGHT
from tests.gradcheck.witness import Witness

DRAWS = range(2)


@pytest.mark.parametrize("case", WRONG, ids=lambda case: case.name)
def test_what_is_wrong_is_refused_by_a_true_sentence(case):
    for seed in DRAWS:
        answer = ours(case, seed)
        assert answer.verdict in ("refused", "undecided") and answer.true, answer.message


@pytest.mark.parametrize("case", RIGHT, ids=lambda case: case.name)
def test_what_is_right_is_never_refused(case):
    for seed in DRAWS:
        answer = ours(case, seed)
        assert answer.verdict in ("accepted", "undecided") and answer.true, answer.message


def test_most_of_it_is_decided():
    undecided = [case.name for case in WRONG + RIGHT if ours(case, 0).verdict == "undecided"]
    assert len(WRONG) == 34 and len(RIGHT) == 37 and len(undecided) <= 9, undecided


def test_the_witness_knows_a_lie():
    case = next(case for case in WRONG if case.name == "square")
    witness, (x,) = Witness(case), case.inputs(0)
    dy = np.random.default_rng(0).standard_normal(x.shape)
    witness.f(x)
    claimed = witness.f_backward(dy, x)[0, 0]
    truth = 2 * x[0, 0] * dy[0, 0]
    assert witness.bears_out(f"x[0, 0]: found {claimed:.17g}, needed {truth:.17g}")
    assert not witness.bears_out(f"x[0, 0]: found {claimed:.17g}, needed {truth * 1.01:.17g}")
    assert not witness.bears_out("its gradient is not linear in the upstream gradient")
