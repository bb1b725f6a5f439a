"""Upstream gradients of scalars of every kind of number, and arguments that are passed over."""

import numpy as np
import pytest

from refimpl import nn
from refimpl.nn.arguments import check_arrays


@pytest.mark.parametrize("number",
                         [2, 2.0, np.int32(2), np.uint8(2), np.float32(2), np.array(2),
                          np.array(2, np.uint16)], ids=repr)
def test_the_upstream_gradient_of_a_scalar_may_be_any_number(number):
    r = np.array([[1.0, -2.0, 0.5]])
    np.testing.assert_array_equal(nn.l1_backward(number, r), 2.0 * np.sign(r))


@pytest.mark.parametrize("number", ["2", True, None], ids=repr)
def test_what_is_no_number_is_refused(number):
    with pytest.raises(ValueError):
        nn.l1_backward(number, np.array([[1.0, -2.0]]))


def test_arguments_after_one_that_is_missing_are_checked_too():
    with pytest.raises(ValueError, match="^w: found dtype float32"):
        check_arrays(x=np.zeros(2), b=None, w=np.zeros(2, np.float32))
