"""hypothesis strategies of valid inputs, for property tests of an implementation:

    @given(conv1d_inputs())
    def test_mine(case):
        arrays, attributes = case
        assert_close(my_conv1d(*arrays, **attributes), nn.conv1d(*arrays, **attributes))
"""

from collections.abc import Callable
from typing import Any

from hypothesis import assume, strategies as st
from hypothesis.extra.numpy import arrays
import numpy as np

ELEMENTS = st.floats(-8, 8).map(lambda v: float(np.float32(v)))          # exact in both precisions
Drawn = tuple[tuple, dict[str, Any]]


def tensors(shape: tuple[int, ...], dtype: Any = np.float64) -> st.SearchStrategy:
    """Arrays of a shape with finite elements that both precisions hold exactly."""
    return arrays(dtype, shape, elements=ELEMENTS.map(dtype))


@st.composite
def conv1d_inputs(draw: Callable[..., Any], dtype: Any = np.float64, largest: int = 4,
                  frames: int = 14) -> Drawn:
    """((x, w, b or None), {stride, padding, dilation, groups}) for which `conv1d` makes an output;
    a batch may be empty.
    """
    groups, K = draw(st.integers(1, 3)), draw(st.integers(1, 7))
    per_group, out_per_group = draw(st.integers(1, largest)), draw(st.integers(1, largest))
    stride, dilation = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    same = [st.just("same")] if stride == 1 else []
    padding = draw(st.one_of(st.just("valid"), st.integers(0, 5),
                             st.tuples(st.integers(0, 5), st.integers(0, 5)), *same))
    if isinstance(padding, str):
        zeros = dilation * (K - 1) if padding == "same" else 0
    else:
        zeros = 2 * padding if isinstance(padding, int) else sum(padding)
    T = draw(st.integers(1, frames))
    assume(T + zeros >= dilation * (K - 1) + 1)
    x = draw(tensors((draw(st.integers(0, 3)), groups * per_group, T), dtype))
    w = draw(tensors((groups * out_per_group, per_group, K), dtype))
    b = draw(st.none() | tensors((len(w),), dtype))
    return (x, w, b), {"stride": stride, "padding": padding, "dilation": dilation, "groups": groups}


@st.composite
def pool_inputs(draw: Callable[..., Any], dtype: Any = np.float64, frames: int = 14) -> Drawn:
    """((x, width), {stride, padding, ceil_mode}) for which the pools make an output; ties are
    likely.
    """
    width = draw(st.integers(1, 5))
    attributes = {"stride": draw(st.none() | st.integers(1, 4)),
                  "padding": draw(st.integers(0, width // 2)), "ceil_mode": draw(st.booleans())}
    T = draw(st.integers(max(1, width - 2 * attributes["padding"]), frames + width))
    shape = draw(st.integers(0, 2)), draw(st.integers(1, 3)), T
    return (draw(arrays(dtype, shape, elements=st.integers(-3, 3).map(dtype))), width), attributes


@st.composite
def clips(draw: Callable[..., Any], dtype: Any = np.float64, channels: int = 5,
          frames: int = 8) -> np.ndarray:
    """(N, C, T) arrays, N from 0."""
    shape = (draw(st.integers(0, 3)), draw(st.integers(1, channels)), draw(st.integers(1, frames)))
    return draw(tensors(shape, dtype))
