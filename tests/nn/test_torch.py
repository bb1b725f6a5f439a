"""PyTorch as an independent witness, in float64. Optional: needs the package `torch`, and is
skipped where it is not installed.
"""

import itertools

import numpy as np
import pytest

from refimpl import nn

torch = pytest.importorskip("torch", reason="the sweep against PyTorch needs the package torch")

TOLERANCE = 1e-12                                                # relative to the largest element


@pytest.fixture(autouse=True)
def one_thread():
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


def agree(found, needed):
    needed = needed.detach().numpy()
    assert found.shape == needed.shape
    size = max(1.0, np.abs(needed[np.isfinite(needed)]).max(initial=0.0))
    np.testing.assert_allclose(found, needed, rtol=0, atol=TOLERANCE * size)


def tensor(array):
    return torch.tensor(array, requires_grad=True)


def agree_in_value_and_gradients(y, gradients, value, tensors, dy):
    agree(y, value)
    for found, needed in zip(gradients,
                             torch.autograd.grad(value, tensors, torch.tensor(dy),
                                                 allow_unused=True)):
        agree(found, torch.zeros(found.shape, dtype=torch.float64) if needed is None else needed)


def padded(x, padding):
    return torch.nn.functional.pad(x, padding) if isinstance(padding, tuple) else x


@pytest.mark.filterwarnings("ignore:Using padding='same' with even kernel")
@pytest.mark.parametrize("stride, dilation, groups",
                         list(itertools.product((1, 2, 3), (1, 2, 3), (1, 2))))
def test_conv1d(stride, dilation, groups):
    rng = np.random.default_rng([stride, dilation, groups])
    for padding in ["valid", 0, 1, 3, (0, 2), (3, 1)] + ["same"] * (stride == 1):
        for _ in range(3):
            N, C, O, K = (rng.integers(1, 4), groups * rng.integers(1, 4),
                          groups * rng.integers(1, 4), rng.integers(1, 6))
            x = rng.normal(size=(N, C, dilation * (K - 1) + 1 + rng.integers(0, 9)))
            w, b = rng.normal(size=(O, C // groups, K)), rng.normal(size=O)
            options = dict(stride=stride, dilation=dilation, groups=groups)
            X, W, B = map(tensor, (x, w, b))
            value = torch.nn.functional.conv1d(padded(X, padding), W, B,
                                               padding=0 if isinstance(padding, tuple) else padding,
                                               **options)
            y = nn.conv1d(x, w, b, padding=padding, **options)
            dy = rng.normal(size=y.shape)
            agree_in_value_and_gradients(y,
                                         nn.conv1d_backward(dy, x, w, b, padding=padding,
                                                            **options), value, (X, W, B), dy)


@pytest.mark.parametrize("stride, dilation, groups",
                         list(itertools.product((1, 2, 3), (1, 2, 3), (1, 2))))
def test_conv_transpose1d(stride, dilation, groups):
    rng = np.random.default_rng([stride, dilation, groups, 1])
    for padding, output_padding in itertools.product((0, 1, 2), range(max(stride, dilation))):
        for _ in range(2):
            N, C, O, K = (rng.integers(1, 4), groups * rng.integers(1, 4),
                          groups * rng.integers(1, 4), rng.integers(2, 6))
            h = rng.normal(size=(N, O, 4 + rng.integers(0, 7)))
            w, b = rng.normal(size=(O, C // groups, K)), rng.normal(size=C)
            options = dict(stride=stride, padding=padding, output_padding=output_padding,
                           dilation=dilation, groups=groups)
            H, W, B = map(tensor, (h, w, b))
            x = nn.conv_transpose1d(h, w, b, **options)
            dx = rng.normal(size=x.shape)
            agree_in_value_and_gradients(x, nn.conv_transpose1d_backward(dx, h, w, b, **options),
                                         torch.nn.functional.conv_transpose1d(H, W, B, **options),
                                         (H, W, B), dx)


@pytest.mark.parametrize("width, ceil_mode",
                         list(itertools.product((1, 2, 3, 4, 5), (False, True))))
def test_pools(width, ceil_mode):
    """Values, places, gradients, and which arguments are refused."""
    rng = np.random.default_rng([width, ceil_mode])
    for stride, padding, dilation, T in itertools.product((None, 1, 2, 3), (0, 1, 2), (1, 2, 3),
                                                          (1, 2, 3, 5, 8)):
        x = rng.permutation(4 * T).reshape(2, 2, T).astype(float)
        options = dict(stride=stride, padding=padding, dilation=dilation, ceil_mode=ceil_mode)
        X = tensor(x)
        try:
            value, places = torch.nn.functional.max_pool1d(X, width, return_indices=True, **options)
        except (RuntimeError, ValueError):
            with pytest.raises(ValueError):
                nn.max_pool1d(x, width, **options)
            continue
        y = nn.max_pool1d(x, width, **options)
        np.testing.assert_array_equal(y, value.detach().numpy())
        inside = np.isfinite(y)
        np.testing.assert_array_equal(nn.max_pool1d_indices(x, width, **options)[inside],
                                      places.numpy()[inside])
        if inside.all():
            dy = rng.normal(size=y.shape)
            agree_in_value_and_gradients(y, (nn.max_pool1d_backward(dy, x, width, **options),),
                                         value, (X,), dy)
        if dilation == 1:
            del options["dilation"]
            for count_include_pad in (True, False):
                X = tensor(x)
                value = torch.nn.functional.avg_pool1d(X, width,
                                                       count_include_pad=count_include_pad,
                                                       **options)
                y = nn.avg_pool1d(x, width, count_include_pad=count_include_pad, **options)
                dy = rng.normal(size=y.shape)
                gradient = nn.avg_pool1d_backward(dy, x, width, count_include_pad=count_include_pad,
                                                  **options)
                agree_in_value_and_gradients(y, (gradient,), value, (X,), dy)


def test_max_pool_ties_and_nan():
    rng = np.random.default_rng(3)
    for _ in range(50):
        x = rng.integers(0, 2, (2, 3, 9)).astype(float)
        x[rng.random(x.shape) < 0.1] = np.nan
        width = int(rng.integers(1, 5))
        stride, padding = int(rng.integers(1, 4)), int(rng.integers(0, width // 2 + 1))
        X = tensor(x)
        value = torch.nn.functional.max_pool1d(X, width, stride, padding)
        y = nn.max_pool1d(x, width, stride=stride, padding=padding)
        np.testing.assert_array_equal(y, value.detach().numpy())
        if not np.isnan(x).any():
            dy = rng.normal(size=y.shape)
            agree_in_value_and_gradients(y,
                                         (nn.max_pool1d_backward(dy, x, width, stride=stride,
                                                                 padding=padding),), value, (X,),
                                         dy)


def test_max_unpool():
    rng = np.random.default_rng(4)
    x = rng.normal(size=(2, 3, 8))
    h, places = nn.max_pool1d(x), nn.max_pool1d_indices(x)
    H = tensor(h)
    value = torch.nn.functional.max_unpool1d(H, torch.tensor(places), 2)
    dx = rng.normal(size=x.shape)
    agree_in_value_and_gradients(nn.max_unpool1d(h, places, 8),
                                 (nn.max_unpool1d_backward(dx, h, places, 8),), value, (H,), dx)


OPERATIONS = {
    "relu": (nn.relu, nn.relu_backward, torch.relu),
    "gram": (nn.gram, nn.gram_backward, lambda h: torch.einsum("nct,ndt->ncd", h, h)),
    "norm": (nn.norm, nn.norm_backward, lambda r: torch.linalg.vector_norm(r, dim=(1, 2))),
    "sum_squares": (nn.sum_squares, nn.sum_squares_backward, lambda r: (r ** 2).sum(dim=(1, 2))),
    "mean_squares": (nn.mean_squares, nn.mean_squares_backward,
                     lambda r: (r ** 2).mean(dim=(1, 2))),
    "l1": (nn.l1, nn.l1_backward, lambda a: a.abs().sum()),
    "avg_depool1d": (nn.avg_depool1d, nn.avg_depool1d_backward,
                     lambda h: h.repeat_interleave(2, dim=2) / 2)}


@pytest.mark.parametrize("name", OPERATIONS)
def test_small_operations(name):
    f, backward, theirs = OPERATIONS[name]
    rng = np.random.default_rng(5)
    for shape in itertools.product((1, 3), (1, 4), (1, 6)):
        x = rng.normal(size=shape)
        if name != "norm":
            # the kinks of relu and l1: the same rule
            x[rng.random(shape) < 0.2] = 0
        X, y = tensor(x), f(x)
        dy = rng.normal(size=np.shape(y))
        agree_in_value_and_gradients(np.asarray(y), (backward(dy, x),), theirs(X), (X,), dy)


@pytest.mark.parametrize("reduction", ["none", "mean", "sum"])
@pytest.mark.parametrize("f, backward, theirs",
                         [(nn.squared_error, nn.squared_error_backward,
                           torch.nn.functional.mse_loss),
                                                 (nn.absolute_error, nn.absolute_error_backward,
                                                  torch.nn.functional.l1_loss)])
def test_errors(f, backward, theirs, reduction):
    rng = np.random.default_rng(6)
    x, y = rng.normal(size=(3, 4)), rng.normal(size=(3, 4))
    x[0, 0] = y[0, 0]
    X, Y = tensor(x), tensor(y)
    value = f(x, y, reduction=reduction)
    dloss = rng.normal(size=np.shape(value))
    agree_in_value_and_gradients(np.asarray(value), backward(dloss, x, y, reduction=reduction),
                                 theirs(X, Y, reduction=reduction), (X, Y), dloss)


@pytest.mark.parametrize("variant, same",
                         [("kingma-ba", True), ("epsilon-hat", False),
                          ("no-bias-correction", False)])
def test_adam_follows_algorithm_1_also_for_tiny_and_zero_gradients(variant, same):
    rng = np.random.default_rng(7)
    p = {"w": rng.normal(size=5), "b": rng.normal(size=3)}
    theirs = {k: torch.nn.Parameter(torch.tensor(v.copy())) for k, v in p.items()}
    optimiser, state, start = torch.optim.Adam(theirs.values(), lr=0.01), nn.adam_start(p), p
    for _ in range(20):
        g = {"w": rng.normal(size=5) * [1e-9, 1.0, 0.0, 1e-7, 1e3], "b": rng.normal(size=3)}
        p, state = nn.adam_step(p, g, state, rate=0.01, variant=variant)
        for k, tensor_ in theirs.items():
            tensor_.grad = torch.tensor(g[k])
        optimiser.step()
    difference = max(np.abs(p[k] - theirs[k].detach().numpy()).max() for k in p)
    moved = max(np.abs(p[k] - start[k]).max() for k in p)
    assert (difference <= TOLERANCE) if same else (difference > 1e-3 * moved)
