"""Which calls the tiles serve, that what they do not serve reaches the direct form with every
argument.
"""


import numpy as np
import pytest

from refimpl import nn
from refimpl.nn import conv
from refimpl.fast import conv as tiled
from refimpl.fast.spectral import Plan

GENERAL = [dict(stride=2), dict(dilation=2), dict(groups=2),
           dict(stride=2, padding=(1, 3), dilation=2, groups=2), dict(padding=(2, 0), stride=3)]


def arrays(seed=0, *, channels=4, out=6, width=9, frames=31, groups=1, dtype=float):
    rng = np.random.default_rng(seed)
    return (rng.normal(size=(2, channels, frames)).astype(dtype),
            rng.normal(size=(out, channels // groups, width)).astype(dtype),
            rng.normal(size=out).astype(dtype))


def same(found, wanted):
    for a, b in zip(found, wanted, strict=True):
        assert (a is None) == (b is None)
        if a is not None:
            np.testing.assert_array_equal(a, b)


@pytest.fixture
def calls(monkeypatch):
    """Names of the direct functions that are called, and how many plans are made."""
    seen = []
    for name in ("conv1d", "conv1d_backward", "conv_transpose1d", "conv_transpose1d_backward"):
        direct = getattr(conv, name)
        monkeypatch.setattr(tiled.conv, name, lambda *a, name=name, direct=direct,
                            **k: seen.append(name) or direct(*a, **k))
    monkeypatch.setattr(tiled, "Plan", lambda *a, **k: seen.append("plan") or Plan(*a, **k))
    return seen


@pytest.mark.parametrize("bias", [True, False])
@pytest.mark.parametrize("options", GENERAL, ids=str)
def test_a_general_convolution_is_handed_over_whole(options, bias, calls):
    x, w, b = arrays(groups=options.get("groups", 1))
    options = {"padding": (3, 1), **options}
    b = b if bias else None
    y = nn.conv1d(x, w, b, **options)
    np.testing.assert_array_equal(tiled.conv1d(x, w, b, **options), y)
    dy = np.random.default_rng(1).normal(size=y.shape)
    same(tiled.conv1d_backward(dy, x, w, b, **options), nn.conv1d_backward(dy, x, w, b, **options))
    assert "plan" not in calls


@pytest.mark.parametrize("bias", [True, False])
@pytest.mark.parametrize("options", [*GENERAL, dict(stride=3, output_padding=2)], ids=str)
def test_a_general_transposed_convolution_is_handed_over_whole(options, bias, calls):
    groups = options.get("groups", 1)
    h, w, _ = arrays(channels=6, out=6, groups=1)
    w = w[:, :4]
    b = np.arange(4.0 * groups) if bias else None
    options = {"padding": (3, 1), **options}
    x = nn.conv_transpose1d(h, w, b, **options)
    np.testing.assert_array_equal(tiled.conv_transpose1d(h, w, b, **options), x)
    dx = np.random.default_rng(1).normal(size=x.shape)
    same(tiled.conv_transpose1d_backward(dx, h, w, b, **options),
         nn.conv_transpose1d_backward(dx, h, w, b, **options))
    assert "plan" not in calls


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("width", [tiled.NARROWEST - 1, tiled.NARROWEST, 25])
def test_the_plain_case_of_wide_filters_is_served_by_tiles(width, dtype, calls):
    x, w, b = arrays(width=width, dtype=dtype)
    h = tiled.conv1d(x, w, b)
    tiled.conv1d_backward(h, x, w, b)
    tiled.conv_transpose1d(h, w)
    tiled.conv_transpose1d_backward(x, h, w)
    assert (calls == (["plan"] * 4 if width >= tiled.NARROWEST
                      else ["conv1d", "conv1d_backward", "conv_transpose1d",
                            "conv_transpose1d_backward"]))


def test_what_is_no_plain_case_is_not_served():
    x, w, _ = arrays()

    def served(x, w, stride=1, dilation=1, groups=1):
        options = {"stride": stride, "dilation": dilation, "groups": groups}
        return tiled._fits(tiled.NARROWEST, options, w, x)

    assert served(x, w)
    for wrong in ((x, w, 2, 1, 1), (x, w, 1, 2, 1), (x, w, 1, 1, 2), (x, w, True, 1, 1),
                  (x, w, 1.0, 1, 1), (x.astype(np.float32), w, 1, 1, 1), (x, w.tolist(), 1, 1, 1),
                  (x.tolist(), w, 1, 1, 1), (x, w[0], 1, 1, 1), (x, w[None], 1, 1, 1),
                  (x + 0j, w + 0j, 1, 1, 1), (x.astype(int), w.astype(int), 1, 1, 1),
                  (x, w[:, :, :tiled.NARROWEST - 1], 1, 1, 1)):
        assert not served(*wrong)


def test_no_bias_no_gradient_of_it_and_a_wrong_one_is_refused():
    x, w, b = arrays()
    y = tiled.conv1d(x, w, b)
    assert (tiled.conv1d_backward(y, x, w)[2] is None
            and tiled.conv_transpose1d_backward(x, y, w)[2] is None)
    np.testing.assert_allclose(tiled.conv1d_backward(y, x, w, b)[2], y.sum(axis=(0, 2)))
    np.testing.assert_allclose(tiled.conv_transpose1d_backward(x, y, w, np.ones(4))[2],
                               x.sum(axis=(0, 2)))
    for call in (lambda: tiled.conv1d(x, w, b[1:]), lambda: tiled.conv1d_backward(y, x, w, b[1:]),
                 lambda: tiled.conv_transpose1d(y, w, b),
                 lambda: tiled.conv_transpose1d_backward(x, y, w, b)):
        with pytest.raises(ValueError, match="^b: "):
            call()
    for call in (lambda: tiled.conv1d_backward(y[..., 1:], x, w),
                 lambda: tiled.conv_transpose1d_backward(x[..., 1:], y, w)):
        with pytest.raises(ValueError, match="^d[xy]: "):
            call()


def test_only_the_gradient_that_is_asked_for():
    x, w, _ = arrays()
    plan = Plan(2, 31, 4, 6, 9, float, left=4)
    plan.input[:] = x.swapaxes(1, 2)
    spectra = plan.spectra(w)
    dy = plan.forward(spectra).copy()
    assert (plan.backward(dy, spectra, to_filters=False)[1] is None
            and plan.backward(dy, spectra, to_input=False)[0] is None)
