"""Values that fade from what is known."""

import numpy as np

from refimpl.motion.easing import blended


def test_values_fade_from_both_sides_and_a_short_gap_is_filled():
    values, known = np.full((30, 1), 2.0), np.zeros(30, bool)
    known[[5, 9, 25]] = True
    out = blended(values, known, 4)[:, 0]
    np.testing.assert_allclose(out[5:10], 2.0)
    assert (out[0] == out[17] == 0 and (np.diff(out[:6]) >= 0).all()
            and (np.diff(out[9:15]) <= 0).all() and 0 < out[13] < out[10] < 2)
    assert not blended(values, np.zeros(30, bool), 4).any()
