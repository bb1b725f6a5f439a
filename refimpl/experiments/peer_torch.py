"""The peer of `refimpl bench`: the same networks in PyTorch, each in every form that might be its
fastest. Imported by that command alone, if PyTorch is there.
"""

from collections.abc import Callable
import os
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F

VERSION = f"PyTorch {torch.__version__}"
# Its own number would be 1 here, since the command line holds MKL to one thread.
DEFAULT = int(os.environ.get("OMP_NUM_THREADS") or os.cpu_count() or 1)


def use_threads(threads: int | None) -> None:
    """As many threads from now on; None for PyTorch's own number."""
    torch.set_num_threads(threads or DEFAULT)


def _tensors(params):
    return {name: torch.tensor(p.copy()) for name, p in params.items()}


def _transform(X, p):
    A = F.relu(F.conv1d(X, p["W1"], p["b1"], padding="same"))
    A = F.relu(F.conv1d(A, p["W2"], p["b2"], padding="same"))
    return F.conv1d(A, p["W3"], p["b3"], padding="same")


def _encode(X, p):
    return F.relu(F.max_pool1d(F.conv1d(X, p["W0"], p["b0"], padding="same"), 2))


def _decode(H, p, later=None):
    D = (H.repeat_interleave(2, 2) / 2 if later is None
         else torch.stack([H * (1 - later), H * later], 3).flatten(2))
    return F.conv_transpose1d(D - p["b0"][:, None], p["W0"], padding=12)


def _channels_last(X, p):
    """P(T(X)) as 2-d convolutions over one row, in the channels-last memory format."""
    def _conv(x, w, b):
        return F.conv2d(x, p[w], p[b], padding=(0, 12))
    A = F.relu(_conv(F.relu(_conv(X, "W1", "b1")), "W2", "b2"))
    H = F.relu(F.max_pool2d(_conv(_conv(A, "W3", "b3"), "W0", "b0"), (1, 2)))
    D = H.repeat_interleave(2, 3) / 2
    return F.conv_transpose2d(D - p["b0"][:, None, None], p["W0"], padding=(0, 12))


def inference(problem: Any, X: np.ndarray) -> dict[str, Callable[[], Any]]:
    """P(T(X)) in every form.   ->  {name: f}"""
    p, x = _tensors({**problem.T, **problem.L}), torch.tensor(X)
    wide = {name: t[:, :, None].contiguous(memory_format=torch.channels_last) if t.ndim == 3 else t
            for name, t in p.items()}
    x_wide = x[:, :, None].contiguous(memory_format=torch.channels_last)

    def _stylise(x):
        return _decode(_encode(_transform(x, p), p), p)

    def _eager():
        with torch.no_grad():
            return _stylise(x)

    def _inference_mode():
        with torch.inference_mode():
            return _stylise(x)

    def _in_channels_last():
        with torch.inference_mode():
            return _channels_last(x_wide, wide)

    return {"torch eager": _eager, "torch inference_mode": _inference_mode,
            "torch channels_last": _in_channels_last,
            **_compiled(lambda compiled: (lambda: _quiet(compiled, x)), _stylise)}


def _quiet(f, *arguments):
    with torch.no_grad():
        return f(*arguments)


def _compiled(use, function):
    """The form made by torch.compile, where a compiler is at hand."""
    torch.compiler.reset()          # of other sizes, of which eight are kept
    try:
        work = use(torch.compile(function))
        work()
    except Exception:               # no compiler, or one that it does not like: the others stand
        return {}
    return {"torch compile": work}


def _stepping(loss, params):
    """A call that computes the loss and the gradients of params."""
    def _step(loss=loss):
        for p in params.values():
            p.grad = None
        loss().backward()
    return _step


def style_step(problem: Any, I: np.ndarray, grams: np.ndarray,
               weights: Any) -> dict[str, Callable[[], None]]:
    """The loss and the gradients of T's parameters in every form.   ->  {name: f}"""
    params = {name: t.requires_grad_() for name, t in _tensors(problem.T).items()}
    L, x, G = _tensors(problem.L), torch.tensor(I), torch.tensor(grams)

    def _loss(x, G):
        with torch.no_grad():
            wanted = _encode(x, L)
        H = _encode(_transform(x, params), L)
        content = ((wanted - H) ** 2).mean(dim=(1, 2))
        style = ((G - H @ H.transpose(1, 2)) ** 2).mean(dim=(1, 2))
        return (weights.content * content + weights.style * style).mean()

    return {"torch eager": _stepping(lambda: _loss(x, G), params),
            **_compiled(lambda f: _stepping(lambda: f(x, G), params), _loss)}


def autoencoder_step(problem: Any, X: np.ndarray, chosen: np.ndarray,
                     alpha: float) -> dict[str, Callable[[], None]]:
    """The loss and the gradients of the loss network's parameters in every form, with depooling by
    chance.   ->  {name: f}
    """
    params = {name: t.requires_grad_() for name, t in _tensors(problem.L).items()}
    x = torch.tensor(X)
    later = torch.tensor(chosen).to(x.dtype)
    size = sum(p.numel() for p in params.values())

    def _loss(x):
        sparsity = sum(p.abs().sum() for p in params.values()) / size
        return ((_decode(_encode(x, params), params, later) - x) ** 2).mean() + alpha * sparsity

    return {"torch eager": _stepping(lambda: _loss(x), params),
            **_compiled(lambda f: _stepping(lambda: f(x), params), _loss)}
