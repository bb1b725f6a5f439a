r"""How fast, compared with what: this package's forms of the same work, and PyTorch's where it is
installed, in one run.

Everything is measured interleaved, one thread each, as medians; what counts are ratios. The peer is
the one place where this package looks for another framework, and only when `refimpl bench` runs. It
is also compared for truth: each result against the direct convolution in float64.
"""

from collections.abc import Callable, Mapping, Sequence
import time
import tracemalloc
from typing import Any

import numpy as np

from .. import nn
from ..holden2017 import networks
from ..fast.autoencoder import AutoencoderStep
from ..fast.gradients import StyleStep
from ..fast.stylist import Stylist
from ..holden2017.objective import CONTENT, STYLE, Batch, Weights
from ..motion.joints import BONES
from ..fast import conv

FRAMES, BATCHES = (240, 480, 960), (10, 32)
PERCEPTUAL = (CONTENT, STYLE)


class Problem:
    """Networks of the paper's sizes with random weights, and random motion, in one precision."""

    def __init__(self, dtype: Any, seed: int = 0) -> None:
        rng = np.random.default_rng(seed)
        self.dtype = np.dtype(dtype)
        self.T = networks.init_transformation_network(rng, dtype=dtype)
        self.L = networks.init_loss_network(rng, dtype=dtype)
        for params in (self.T, self.L):
            for name in params:
                if name[0] == "b":
                    params[name] = (0.05 * rng.normal(size=params[name].shape)).astype(dtype)
                params[name] = np.asfortranarray(params[name])
        self.rng = rng

    def motion(self, batch: int, frames: int) -> np.ndarray:
        """Random motion.   ->  (batch, 66, frames)"""
        return self.rng.normal(size=(batch, 66, frames)).astype(self.dtype)

    def grams(self, batch: int) -> np.ndarray:
        """Gram matrices of random hidden units.   ->  (batch, m, m)"""
        h = self.rng.normal(size=(batch, networks.HIDDEN, 20)).astype(self.dtype)
        return h @ h.swapaxes(1, 2)


def interleaved(rivals: Mapping[str, Callable[..., Any]], seconds: float = 1.5,
                least: int = 5) -> dict[str, float]:
    """Median seconds of each of several functions, called in turn so that all meet the same
    machine.

    rivals : {name: f};  seconds : for each;  least : how often each is called at least
    ->  {name: seconds}
    """
    for work in rivals.values():
        work()
        work()
    times: dict[str, list[float]] = {name: [] for name in rivals}
    began = time.perf_counter()
    while (time.perf_counter() - began < seconds * len(rivals)
           or len(next(iter(times.values()))) < least):
        for name, work in rivals.items():
            start = time.perf_counter()
            work()
            times[name].append(time.perf_counter() - start)
    return {name: float(np.median(t)) for name, t in times.items()}


def _row(work, dtype, rivals, seconds, error=None):
    """One line of the table: medians, the best peer, ratio of ours to it."""
    times = interleaved(rivals, seconds)
    peers = {name: t for name, t in times.items() if name.startswith("torch")}
    best = min(peers, key=peers.__getitem__) if peers else None
    return {"work": work, "dtype": np.dtype(dtype).name, "seconds": times, "best peer": best,
            "ratio": times["tiled"] / peers[best] if best else None, "relative error": error}


def relative_error(found: np.ndarray, exact: np.ndarray) -> float:
    """|| found - exact || / || exact ||

    >>> relative_error(np.array([3.0, 4.5]), np.array([3.0, 4.0]))
    0.1
    """
    return float(np.linalg.norm(found.astype(float) - exact) / np.linalg.norm(exact))


def inference(problem: Problem, peer: Any, seconds: float,
              frames: Sequence[int] = FRAMES) -> list[dict[str, Any]]:
    """Stylise and project, batch 1.

    peer : the module `peer_torch`, or None;  seconds : for each rival   ->  rows
    """
    stylist, rows = Stylist(problem.T, problem.L), []
    wide = [{name: p.astype(float) for name, p in params.items()}
            for params in (problem.T, problem.L)]
    for count in frames:
        X = problem.motion(1, count)
        exact = networks.project(networks.transformation(X.astype(float), wide[0]), wide[1])
        rivals = {
            "tiled": lambda: stylist.stylise(X),
            "direct": lambda: networks.project(networks.transformation(X, problem.T), problem.L),
            **(peer.inference(problem, X) if peer else {})}
        rows.append(_row(f"stylise + project, {count} frames", problem.dtype, rivals, seconds,
                         relative_error(stylist.stylise(X), exact)))
    return rows


def style_steps(problem: Problem, peer: Any, seconds: float,
                batches: Sequence[int] = BATCHES) -> list[dict[str, Any]]:
    """A training step of T with content and style loss: L(I), T(I), L(T(I)), both losses, and the
    gradients of T's parameters.   ->  a row a batch
    """
    rows = []
    for batch in batches:
        I, grams = problem.motion(batch, 240), problem.grams(batch)
        step = StyleStep(batch, 240, problem.T, problem.L, np.zeros(66), np.ones(66), Weights(),
                         PERCEPTUAL)
        nothing: Any = None                         # neither loss reads what the constraints do
        windows = Batch(I, grams, nothing, nothing, nothing)
        rivals = {
            "tiled": lambda step=step, windows=windows: step(problem.T, windows),
            **(peer.style_step(problem, I, grams, Weights()) if peer else {})}
        rows.append(_row(f"training step of T, batch {batch}", problem.dtype, rivals, seconds))
    return rows


def autoencoder_steps(problem: Problem, peer: Any, seconds: float,
                      batch: int = 10) -> list[dict[str, Any]]:
    """A training step of the loss network, with depooling by chance.   ->  one row"""
    X = problem.motion(batch, 240)
    chosen = problem.rng.integers(2, size=(batch, 120, len(problem.L["b0"])),
                                  dtype=np.int8).swapaxes(1, 2)
    step = AutoencoderStep(batch, 240, problem.L, random=True)
    rivals = {
        "tiled": lambda: step(problem.L, X, chosen=chosen),
        **(peer.autoencoder_step(problem, X, chosen, 0.01) if peer else {})}
    work = f"training step of the loss network, batch {batch}"
    return [_row(work, problem.dtype, rivals, seconds)]


def all_five(problem: Problem, seconds: float, batch: int = 10) -> list[dict[str, Any]]:
    """A training step of T with all five losses, without a peer.   ->  one row"""
    I, grams, rng = problem.motion(batch, 240), problem.grams(batch), problem.rng
    step = StyleStep(batch, 240, problem.T, problem.L, np.zeros(66), np.ones(66), Weights())
    contacts = (rng.random((batch, 4, 240)) < 0.5).astype(problem.dtype)
    trajectory = rng.normal(size=(batch, 3, 240)).astype(problem.dtype)
    windows = Batch(I, grams, contacts, np.ones(len(BONES)), trajectory)
    return [_row(f"training step of T, all five losses, batch {batch}", problem.dtype,
                 {"tiled": lambda: step(problem.T, windows)}, seconds)]


def convolutions(problem: Problem, seconds: float) -> list[dict[str, Any]]:
    """One layer, 128 to 128 channels, batch 10: the direct convolution, which is the definition,
    and the tiles, without kept spectra.   ->  two rows
    """
    x, w, b = problem.motion(10, 240)[:, :1].repeat(128, axis=1), problem.T["W2"], problem.T["b2"]
    dy = problem.motion(10, 240)[:, :1].repeat(128, axis=1)
    forward = {"tiled": lambda: conv.conv1d(x, w, b), "direct": lambda: nn.conv1d(x, w, b)}
    backward = {"tiled": lambda: conv.conv1d_backward(dy, x, w, b),
                "direct": lambda: nn.conv1d_backward(dy, x, w, b)}
    return [_row("conv1d 128 to 128, batch 10, forward", problem.dtype, forward, seconds),
            _row("the same, backward", problem.dtype, backward, seconds)]


def scaling(problem: Problem, frames: Sequence[int] = (240, 960, 3840, 15360),
            threads: Sequence[int] = (1, 2)) -> list[dict[str, Any]]:
    """Seconds for stylise + project by frames and threads, and the memory it takes beyond motion in
    and out.   ->  list of dicts
    """
    rows = []
    for count in frames:
        X = problem.motion(1, count)
        stylists = {n: Stylist(problem.T, problem.L, threads=n) for n in threads}
        times = interleaved({str(n): lambda s=s: s.stylise(X) for n, s in stylists.items()}, 0.5, 3)
        tracemalloc.start()
        Stylist(problem.T, problem.L).stylise(X)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        rows.append({"frames": count, "seconds by threads": times, "peak bytes": peak})
    return rows


def gemm_rate(dtype: Any, seconds: float = 0.5, size: int = 1024) -> float:
    """Multiplications and additions a second of one large matrix product, the machine's limit."""
    a = np.random.default_rng(0).normal(size=(size, size)).astype(dtype)
    out = np.empty_like(a)
    return 2 * size ** 3 / interleaved({"gemm": lambda: np.matmul(a, a, out=out)}, seconds)["gemm"]


def direct_operations(frames: int) -> int:
    """Multiplications and additions of stylise + project by the direct convolution, all layers."""
    pairs = 66 * 128 + 128 * 128 + 128 * 66 + 2 * 66 * 256
    return 2 * frames * 25 * pairs
