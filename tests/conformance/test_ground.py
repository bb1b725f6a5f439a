"""Is the kit's ground wide enough, and are its bounds neither too wide nor too narrow? Faults of
each kind that real libraries had, and honest answers in other styles."""

import math

import numpy as np
import pytest

from refimpl import nn
from refimpl.conformance import OPERATIONS, cases, judge_all, reference
from refimpl.conformance.calls import Case, answered
from refimpl.conformance.ground_total import balanced, shares
from refimpl.conformance.specification import Sample
from refimpl.conformance.verify import too_light, verify
from refimpl.conformance.yardstick import Yardstick
from refimpl.holden2017 import objective

GOOD = reference().functions


def failures(function, wrong, **how):
    """Of the one function, put in the place of the good one."""
    chosen = [c for c in cases(operations=[function.removesuffix("_backward")], **how)
              if c.function == function]
    return [o for o in judge_all({**GOOD, function: wrong}, chosen) if o.status == "failed"]


def single_only(wrong, right):
    """The fault for float32 alone."""
    return lambda *a, **k: (wrong if any(getattr(x, "dtype", None) == np.float32 for x in a)
                            else right)(*a, **k)


def last_clip_of_33(x, w, b=None, **k):
    y = nn.conv1d(x, w, b, **k)
    y[32:33] = 0
    return y


def gram_as_if_packed(d, h):
    """Reads an upstream gradient of stride 0 from its memory."""
    expanded = 0 in d.strides and d.size > 1
    return nn.gram_backward(np.zeros_like(d) if expanded else d, h)


def stale_filters():
    """Keeps the first filters of a shape."""
    kept = {}

    def wrong(x, w, b=None, **k):
        return nn.conv1d(x, kept.setdefault((w.shape, w.dtype), w.copy()), b, **k)
    return wrong


def near_ties_to_the_first(dy, x, width=2, **k):
    x = np.round(x * 100) / 100 if np.isfinite(x).all() else x
    return nn.max_pool1d_backward(dy, x.astype(dy.dtype), width, **k)


def one_transform_for_two_clips(x, w, b=None, **k):
    """A small clip gets the rounding of its large neighbour."""
    y = nn.conv1d(x, w, b, **k)
    if len(x) > 1 and np.isfinite(y).all():
        y[1] += np.finfo(y.dtype).eps * np.abs(y[0]).max(initial=0)
    return y


def expanded_squares(x, y, *, reduction="mean"):
    """x^2 - 2 x y + y^2, which loses everything far from 0."""
    if not (np.isfinite(x).all() and np.isfinite(y).all()) or np.abs(x).max(initial=0) < 1e3:
        return nn.squared_error(x, y, reduction=reduction)
    squares = x * x - 2 * x * y + y * y
    return {"mean": np.mean, "sum": np.sum, "none": lambda s: s}[reduction](squares)


FAULTS = {
    "size: the last of 33 clips": ("conv1d", last_clip_of_33),
    "layout: an expanded gradient": ("gram_backward", gram_as_if_packed),
    "memory: filters kept from call to call": ("conv1d", stale_filters()),
    "kinks: near ties": ("max_pool1d_backward", near_ties_to_the_first),
    "range: two clips in one transform": ("conv1d", one_transform_for_two_clips),
    "range: a norm whose squares overflow": ("norm", lambda r: np.sqrt(np.sum(
        r * r, axis=tuple(range(1, r.ndim)), dtype=r.dtype))),
    "range: far from zero": ("squared_error", expanded_squares),
    "range: subnormal numbers flushed": ("relu", lambda x: np.where(
        np.abs(x) < np.finfo(x.dtype).tiny, 0 * x, nn.relu(x))),
    "NaN: swallowed": ("relu", single_only(lambda x: np.fmax(x, x.dtype.type(0)), nn.relu)),
    "options: padding forgotten where there is dilation": (
        "max_pool1d", lambda x, width=2, *, padding=0, dilation=1, **k: nn.max_pool1d(
            np.maximum(x, 0) if padding and dilation > 1 else x, width, padding=padding,
            dilation=dilation, **k)),
    "memory: a view where nothing is to do": (
        "avg_depool1d", single_only(lambda h, width=2: h if width == 1 else
                                    nn.avg_depool1d(h, width), nn.avg_depool1d)),
    "angles: a series up to 0.01": ("exponential_map", lambda v: np.where(
        (np.linalg.norm(v, axis=-1) < 1e-2)[..., None, None] & np.isfinite(v).all(),
        np.eye(3) + np.array([[[0, -z, y], [z, 0, -x], [-y, x, 0]] for x, y, z in v]).reshape(
            len(v), 3, 3), GOOD["exponential_map"](v))),
    "search: an absolute margin": ("best_alpha", lambda c, *, samples=13, tolerance=1e-6: GOOD[
        "best_alpha"](c, samples=13, tolerance=tolerance)),
    "small: an epsilon in the root": ("mean_squares", lambda r: nn.mean_squares(r) + r.dtype.type(
        1e-9))}


@pytest.mark.parametrize("name", FAULTS)
def test_each_kind_of_fault_is_convicted(name):
    assert failures(*FAULTS[name])


def by_fsum(x, w, b=None, *, stride=1, padding="same", dilation=1, groups=1):
    """Element by element, rounded once."""
    spread = dilation * (w.shape[2] - 1)
    left, right = {"same": (spread // 2, spread - spread // 2), "valid": (0, 0)}.get(
        padding, padding if isinstance(padding, tuple) else (padding, padding))
    padded = np.pad(x.astype(float), ((0, 0), (0, 0), (left, right)))
    frames = (padded.shape[2] - spread - 1) // stride + 1
    y = np.zeros((len(x), len(w), frames), x.dtype)
    for n, o, t in np.ndindex(y.shape):
        group = o // (len(w) // groups) * w.shape[1]
        part = padded[n, group:group + w.shape[1], t * stride:t * stride + spread + 1:dilation]
        y[n, o, t] = math.fsum([*(part * w[o]).ravel(), 0.0 if b is None else b[o]])
    return y


def one_after_the_other(h):
    """Sums in the inputs' own precision, as a plain loop in C has them."""
    y = np.zeros((len(h), h.shape[1], h.shape[1]), h.dtype)
    for t in range(h.shape[2]):
        y += h[:, :, None, t] * h[:, None, :, t]
    return y


def test_honest_answers_in_other_styles_agree():
    chosen = [c for c in cases(operations=["conv1d"]) if c.function == "conv1d"
              and c.kind in ("float64", "float32") and c.arguments[0].size < 300
              and np.isfinite(c.arguments[0]).all()]
    assert [o.message for o in judge_all({"conv1d": by_fsum}, chosen[::4])
            if o.status == "failed"] == []
    assert [o.message for o in failures("gram", one_after_the_other)
            if o.grade not in ("laxer", "stricter")] == []


def test_a_yardstick_is_what_an_element_sums():
    """Whatever cancels: 1000 terms of size 1 whose sum is nearly 0."""
    x = np.where(np.arange(1000) % 2, 1.0, -1.0)[None, None]
    w = np.full((1, 1, 1000), 1.0)
    call = Case("conv1d/x/forward", OPERATIONS["conv1d"], "conv1d", "", (x, w, None),
                {"padding": "valid"})
    case = answered(call, nn.conv1d, "float64")
    assert abs(case.expected[0]).max() == 0 and 300 < case.yardstick.sizes[0].max() < 3000
    firm = Yardstick(nn.conv1d, (x, w), {"padding": "valid"}, case.expected, firm=True)
    assert firm.sizes[0].max() == 0


def test_a_bound_is_of_a_clip_and_channel():
    """A small clip beside a large one has its own."""
    x = np.random.default_rng(0).standard_normal((2, 3, 8)) * np.array([1e6, 1e-6])[:, None, None]
    case = answered(Case("relu/x/forward", OPERATIONS["relu"], "relu", "", (x,), {}), nn.relu,
                    "float64")
    large, small = case.allowances()[0].max(axis=(1, 2))
    assert large > 1e-7 and small < 1e-14


@pytest.mark.parametrize("name", ["encode", "exponential_map", "best_alpha"])
def test_every_case_has_a_name_of_its_own(name):
    for profile in ("core", "full"):
        ids = [c.id for c in cases(operations=[name], profile=profile)]
        assert len(ids) == len(set(ids))


ROUNDED = {"tf32": 13, "bfloat16": 16}


def rounded_products(bits):
    """A convolution whose factors keep fewer digits, with exact sums."""
    def short(a):
        kept = a.astype(np.float32).view(np.uint32) + np.uint32(1 << (bits - 1))
        return (kept & np.uint32(0xFFFFFFFF << bits & 0xFFFFFFFF)).view(np.float32)
    return lambda x, w, b=None, **k: nn.conv1d(short(x), short(w), b, **k)


@pytest.mark.parametrize("profile", ROUNDED)
def test_products_of_fewer_digits_agree_in_their_profile_alone(profile):
    wrong = rounded_products(ROUNDED[profile])
    assert failures("conv1d", wrong, profile=profile) == []
    assert failures("conv1d", wrong, profile="small")
    assert failures("conv1d", lambda x, w, b=None, **k: nn.conv1d(x, w[:, :, ::-1].copy(), b, **k),
                    profile=profile)


def test_a_term_too_light_to_be_seen_is_told():
    alike = {term.name: 2.0 for term in objective.EQUATION_10}
    rng = np.random.default_rng(0)
    light = Sample("content of nearly no weight", *balanced(rng, "norm", {**alike,
                                                                         "content": 1e-6}))
    message, *_ = too_light(shares(light))
    assert message.startswith("content is") and "too little to be seen" in message
    assert too_light(shares(Sample("balanced", *balanced(rng, "norm", alike)))) == ()
    found, = verify(operations=["total_loss"])
    assert sum(row["case"].endswith("/terms") for row in found.rows) >= 2
