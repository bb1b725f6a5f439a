"""The fast convolution is the direct one: over random shapes, forward and backward, in both
precisions.
"""

from hypothesis import given, strategies as st
import numpy as np
import pytest

from refimpl import nn
from refimpl.fast import conv as tiled

shapes = st.tuples(st.integers(0, 10 ** 6), st.integers(0, 3), st.integers(1, 5), st.integers(1, 5),
                   st.integers(8, 40), st.integers(1, 150),
                   st.sampled_from(["same", "valid", 3, (0, 9), (30, 2)]))


def close(found, needed, precision):
    scale = np.abs(needed).max(initial=0) or 1.0
    assert (found.shape == needed.shape and np.abs(found - needed).max(initial=0)
            <= precision * scale)


@given(shapes)
def test_tiles_are_the_direct_convolution(case):
    seed, N, C, O, K, T, padding = case
    rng = np.random.default_rng(seed)
    x, w, b = rng.normal(size=(N, C, T)), rng.normal(size=(O, C, K)), rng.normal(size=O)
    try:
        y = nn.conv1d(x, w, b, padding=padding)
    except ValueError:
        with pytest.raises(ValueError):
            tiled.conv1d(x, w, b, padding=padding)
        return
    close(tiled.conv1d(x, w, b, padding=padding), y, 1e-13)
    dy = rng.normal(size=y.shape)
    for found, needed in zip(tiled.conv1d_backward(dy, x, w, b, padding=padding),
                             nn.conv1d_backward(dy, x, w, b, padding=padding)):
        close(found, needed, 2e-13)
    assert tiled.conv1d_backward(dy, x, w, padding=padding)[2] is None


@given(shapes)
def test_tiles_are_the_direct_transposed_convolution(case):
    seed, N, C, O, K, T, padding = case
    rng = np.random.default_rng(seed)
    h, w, b = rng.normal(size=(N, O, T)), rng.normal(size=(O, C, K)), rng.normal(size=C)
    try:
        x = nn.conv_transpose1d(h, w, b, padding=padding)
    except ValueError:
        with pytest.raises(ValueError):
            tiled.conv_transpose1d(h, w, b, padding=padding)
        return
    close(tiled.conv_transpose1d(h, w, b, padding=padding), x, 1e-13)
    dx = rng.normal(size=x.shape)
    for found, needed in zip(tiled.conv_transpose1d_backward(dx, h, w, b, padding=padding),
                             nn.conv_transpose1d_backward(dx, h, w, b, padding=padding)):
        close(found, needed, 2e-13)


def test_float32_stays_float32_and_precise():
    rng = np.random.default_rng(1)
    x, w, b = (rng.normal(size=s).astype(np.float32) for s in ((2, 66, 240), (128, 66, 25), (128,)))
    wide = nn.conv1d(*(a.astype(float) for a in (x, w, b)))
    y = tiled.conv1d(x, w, b)
    assert y.dtype == np.float32
    close(y, wide, 2e-6)
    assert all(g.dtype == np.float32 for g in tiled.conv1d_backward(y, x, w, b))


def test_what_tiles_do_not_serve_goes_to_the_direct_form():
    rng = np.random.default_rng(2)
    x, w = rng.normal(size=(1, 4, 60)), rng.normal(size=(4, 2, 9))
    for options in (dict(groups=2), dict(groups=2, stride=2, padding=1),
                    dict(groups=2, dilation=3)):
        np.testing.assert_array_equal(tiled.conv1d(x, w, **options), nn.conv1d(x, w, **options))
    narrow = rng.normal(size=(3, 4, 3))
    np.testing.assert_array_equal(tiled.conv1d(x, narrow), nn.conv1d(x, narrow))
    z = x.astype(complex)
    np.testing.assert_array_equal(tiled.conv1d(z, w, groups=2), nn.conv1d(z, w, groups=2))


def test_contract_and_bad_input():
    rng = np.random.default_rng(3)
    x, w, b = rng.normal(size=(2, 3, 50)), rng.normal(size=(4, 3, 11)), rng.normal(size=4)
    nn.check_gradient(tiled.conv1d, tiled.conv1d_backward, x, w, b, names=("x", "w", "b"))
    nn.check_contract(tiled.conv1d, tiled.conv1d_backward, x, w, b, single=True, batched=(0,))
    h, c = rng.normal(size=(2, 4, 50)), rng.normal(size=3)
    nn.check_gradient(tiled.conv_transpose1d, tiled.conv_transpose1d_backward, h, w, c,
                      names=("h", "w", "b"))
    for bad, words in (((x[:, :2], w, b), "x: found shape"), ((x, w, b[:3]), "b: found shape"),
                       ((x.astype(int), w, b), "x: found dtype int64"),
                       ((x.astype(np.float32), w, b), "needed the precision")):
        with pytest.raises(ValueError, match=words):
            tiled.conv1d(*bad)
    with pytest.raises(ValueError, match="dy: found shape"):
        tiled.conv1d_backward(np.zeros((2, 4, 49)), x, w, b)
