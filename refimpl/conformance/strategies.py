"""hypothesis strategies of valid inputs, for property tests of an implementation. Needs hypothesis;
nothing else imports this module.

    from refimpl.conformance.strategies import conv1d_inputs

    @given(conv1d_inputs())
    def test_mine(case):
        arrays, attributes = case
        assert_close(my_conv1d(*arrays, **attributes), nn.conv1d(*arrays, **attributes))
"""

from hypothesis import assume, strategies as st
from hypothesis.extra.numpy import arrays
import numpy as np

ELEMENTS = st.floats(-8, 8).map(lambda v: float(np.float32(v)))          # exact in both precisions


def tensors(shape, dtype=np.float64):
    """Arrays of a shape with finite elements that both precisions hold exactly."""
    return arrays(dtype, shape, elements=ELEMENTS.map(dtype))


@st.composite
def conv1d_inputs(draw, dtype=np.float64, largest=4, frames=14):
    """((x, w, b or None), {stride, padding, dilation, groups}) for which `conv1d` makes an output;
    a batch may be empty.
    """
    groups = draw(st.integers(1, 3))
    per_group, out_per_group, K = draw(st.integers(1,
                                                   largest)), draw(st.integers(1, largest)), draw(
                                                       st.integers(1, 7))
    stride, dilation = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    padding = draw(
        st.one_of(st.just("valid"), st.integers(0, 5),
                  st.tuples(st.integers(0, 5), st.integers(0, 5)),
                  *([st.just("same")] if stride == 1 else [])))
    zeros = {"valid": 0, "same": dilation * (K - 1)}[padding] if isinstance(
        padding, str) else 2 * padding if isinstance(padding, int) else sum(padding)
    T = draw(st.integers(1, frames))
    assume(T + zeros >= dilation * (K - 1) + 1)
    x = draw(tensors((draw(st.integers(0, 3)), groups * per_group, T), dtype))
    w = draw(tensors((groups * out_per_group, per_group, K), dtype))
    b = draw(st.none() | tensors((len(w),), dtype))
    return (x, w, b), {"stride": stride, "padding": padding, "dilation": dilation, "groups": groups}


@st.composite
def pool_inputs(draw, dtype=np.float64, frames=14):
    """((x, width), {stride, padding, ceil_mode}) for which the pools make an output; ties are
    likely.
    """
    width = draw(st.integers(1, 5))
    attributes = {
        "stride": draw(st.none() | st.integers(1, 4)), "padding": draw(st.integers(0, width // 2)),
        "ceil_mode": draw(st.booleans())}
    T = draw(st.integers(max(1, width - 2 * attributes["padding"]), frames + width))
    x = draw(
        arrays(dtype, (draw(st.integers(0, 2)), draw(st.integers(1, 3)), T),
               elements=st.integers(-3, 3).map(dtype)))
    return (x, width), attributes


@st.composite
def clips(draw, dtype=np.float64, channels=5, frames=8):
    """(N, C, T) arrays, N from 0."""
    return draw(
        tensors(
            (draw(st.integers(0, 3)), draw(st.integers(1, channels)), draw(st.integers(1, frames))),
            dtype))
