r"""How fast, compared with what: this package's forms of the same work, and PyTorch's where it is
installed, in one run.

Everything is measured interleaved, as medians, with the same number of threads on both sides and
with each side's default; what counts are ratios. The peers, `peer_torch` and `peer_onnx`, are the
only places where this package looks for other frameworks, and only when `refimpl bench` runs. Each
result is compared with the direct convolution in float64.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
import time
import tracemalloc
from typing import Any

import numpy as np

from .. import nn
from ..holden2017 import networks
from ..fast.autoencoder import autoencoder_gradients
from ..fast.gradients import style_gradients
from ..fast.shards import sharded
from ..fast.stylist import Stylist
from ..holden2017.objective import CONTENT, STYLE, Batch, Weights
from ..motion.joints import BONES
from ..fast import conv

FRAMES, BATCHES, SPARSITY = (240, 480, 960, 3840), (10, 32), 0.01
SETTLING = 0.05                                  # seconds
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
    """Median seconds of each of several functions, which take turns so that all meet the same
    machine. Calls in the first `SETTLING` seconds of a turn do not count: until then the threads of
    whoever came before go on spinning, and take a core.

    rivals : {name: f};  seconds : for each;  least : how often each is timed at least
    ->  {name: seconds}
    """
    for work in rivals.values():
        work()
    times: dict[str, list[float]] = {name: [] for name in rivals}
    began = time.perf_counter()
    while (time.perf_counter() - began < seconds * len(rivals)
           or len(next(iter(times.values()))) < least):
        for name, work in rivals.items():
            settled = time.perf_counter() + SETTLING
            while time.perf_counter() < settled:
                work()
            for _ in range(5):
                start = time.perf_counter()
                work()
                times[name].append(time.perf_counter() - start)
    return {name: float(np.median(t)) for name, t in times.items()}


def relative_error(found: np.ndarray, exact: np.ndarray) -> float:
    """|| found - exact || / || exact ||

    >>> relative_error(np.array([3.0, 4.5]), np.array([3.0, 4.0]))
    0.1
    """
    return float(np.linalg.norm(found.astype(float) - exact) / np.linalg.norm(exact))


@dataclass(frozen=True)
class Work:
    """One line of the table.

    ours : threads -> a call;  peers : {name: call} of the same work by others;  alone : the direct
    form's call, or None;  error : of ours against the direct form in float64, or None;
    default : our threads where nobody asks
    """

    name: str
    ours: Callable[[int], Callable]
    peers: Mapping[str, Callable]
    alone: Callable | None = None
    error: float | None = None
    default: int = 1

    @cached_property
    def operations(self) -> int:
        """`products` of ours, on one thread."""
        return products(self.ours(1))


def inference(problem: Problem, peers: Sequence[Any], frames: Sequence[int] = FRAMES,
              ) -> Iterator[Work]:
    """Stylise and project, batch 1.   peers : modules with an `inference`   ->  a Work a length"""
    wide = [{name: p.astype(float) for name, p in params.items()}
            for params in (problem.T, problem.L)]
    for count in frames:
        X = problem.motion(1, count)
        exact = networks.project(networks.transformation(X.astype(float), wide[0]), wide[1])
        calls: dict[str, Callable] = {}
        for peer in peers:
            calls |= peer.inference(problem, X)
        yield Work(f"stylise + project, {count} frames", _stylising(problem, X), calls,
                   _calling(_directly, problem, X),
                   relative_error(Stylist(problem.T, problem.L).stylise(X), exact))


def _stylising(problem, X):
    """threads -> a call"""
    return lambda threads: _calling(Stylist(problem.T, problem.L, threads=threads).stylise, X)


def _directly(problem, X):
    return networks.project(networks.transformation(X, problem.T), problem.L)


def _calling(f, *arguments):
    return lambda: f(*arguments)


def style_steps(problem: Problem, peers: Sequence[Any], batches: Sequence[int] = BATCHES,
                ) -> Iterator[Work]:
    """A training step of T with content and style loss: L(I), T(I), L(T(I)), both losses, and the
    gradients of T's parameters.   ->  a Work a batch
    """
    nothing: Any = None                             # neither loss reads what the constraints do
    for batch in batches:
        windows = Batch(problem.motion(batch, 240), problem.grams(batch), nothing, nothing, nothing)
        calls: dict[str, Callable] = {}
        for peer in peers:
            if hasattr(peer, "style_step"):
                calls |= peer.style_step(problem, windows.I, windows.gram, Weights())
        yield Work(f"training step of T, batch {batch}",
                   _in_parts(style_gradients, problem.T, windows, problem.L, np.zeros(66),
                             np.ones(66), Weights(), PERCEPTUAL), calls, default=2)


def autoencoder_steps(problem: Problem, peers: Sequence[Any], batch: int = 10) -> Iterator[Work]:
    """A training step of the loss network, with depooling by chance.   ->  one Work"""
    X = problem.motion(batch, 240)
    chosen = problem.rng.integers(2, size=(batch, 120, len(problem.L["b0"])),
                                  dtype=np.int8).swapaxes(1, 2)
    calls: dict[str, Callable] = {}
    for peer in peers:
        if hasattr(peer, "autoencoder_step"):
            calls |= peer.autoencoder_step(problem, X, chosen, SPARSITY)
    yield Work(f"training step of the loss network, batch {batch}",
               _in_parts(autoencoder_gradients, problem.L,
                         networks.Reconstruction(X, chosen=chosen), SPARSITY), calls, default=2)


def all_five(problem: Problem, peers: Sequence[Any], batch: int = 10) -> Iterator[Work]:
    """A training step of T with all five losses, without a peer.   ->  one Work"""
    rng = problem.rng
    contacts = (rng.random((batch, 4, 240)) < 0.5).astype(problem.dtype)
    trajectory = rng.normal(size=(batch, 3, 240)).astype(problem.dtype)
    windows = Batch(problem.motion(batch, 240), problem.grams(batch), contacts,
                    np.ones(len(BONES)), trajectory)
    yield Work(f"training step of T, all five losses, batch {batch}",
               _in_parts(style_gradients, problem.T, windows, problem.L, np.zeros(66), np.ones(66),
                         Weights()), {}, default=2)


def _in_parts(make, params, batch, *constants):
    """threads -> a call that computes losses and gradients of a batch in so many parts."""
    def _with(threads):
        executor = ThreadPoolExecutor(threads) if threads > 1 else None
        return _calling(sharded(make, threads, executor)(*constants), params, batch)
    return _with


def convolutions(problem: Problem, peers: Sequence[Any] = ()) -> Iterator[Work]:
    """One layer, 128 to 128 channels, batch 10: the direct convolution, which is the definition,
    and the tiles, without kept spectra.   ->  two Works
    """
    x, w, b = problem.motion(10, 240)[:, :1].repeat(128, axis=1), problem.T["W2"], problem.T["b2"]
    dy = problem.motion(10, 240)[:, :1].repeat(128, axis=1)
    yield Work("conv1d 128 to 128, batch 10, forward", lambda _: _calling(conv.conv1d, x, w, b), {},
               _calling(nn.conv1d, x, w, b))
    yield Work("the same, backward", lambda _: _calling(conv.conv1d_backward, dy, x, w, b), {},
               _calling(nn.conv1d_backward, dy, x, w, b))


def timed(work: Work, dtype: Any, threads: int | None, seconds: float, rate: float,
          peers: Sequence[Any] = ()) -> dict[str, Any]:
    """Medians of one line, everything interleaved.

    threads : of both sides, or None for each side's own default;  seconds : for each rival;
    rate : multiplications and additions a second of large products on so many threads
    """
    for peer in peers:
        peer.use_threads(threads)
    ours = work.ours(threads or work.default)
    rivals = {"ours": ours, **work.peers}
    if work.alone and threads == 1:
        rivals["direct"] = work.alone
    times = interleaved(rivals, seconds)
    best = min(work.peers, key=times.__getitem__, default=None)
    return {"work": work.name, "dtype": np.dtype(dtype).name,
            "threads": threads or f"each side's default ({work.default} here)",
            "seconds": times["ours"], "direct seconds": times.get("direct"), "peer": best,
            "peer seconds": times[best] if best else None,
            "ratio": times["ours"] / times[best] if best else None,
            "share of the limit": work.operations / rate / times["ours"],
            "relative error": work.error, "seconds of each": times}


def products(work: Callable[[], Any]) -> int:
    """Multiplications and additions that a call spends in matrix products.

    >>> products(lambda: np.matmul(np.ones((2, 3)), np.ones((3, 5))))
    60
    """
    real, counted = np.matmul, [0]

    def _counting(a, b, **options):
        result = real(a, b, **options)
        counted[0] += 2 * result.size * a.shape[-1]
        return result

    work()                                                       # what is made once does not count
    np.matmul = _counting                                        # type: ignore[misc, assignment]
    try:
        work()
    finally:
        np.matmul = real                                         # type: ignore[misc]
    return counted[0]


def peak_bytes(problem: Problem, frames: int) -> int:
    """Memory that stylise + project takes beyond motion in."""
    X = problem.motion(1, frames)
    tracemalloc.start()
    Stylist(problem.T, problem.L).stylise(X)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def gemm_rate(dtype: Any, threads: int = 1, seconds: float = 0.5, size: int = 1024) -> float:
    """Multiplications and additions a second of large matrix products, one a thread side by side:
    the machine's limit."""
    a = np.random.default_rng(0).normal(size=(size, size)).astype(dtype)
    outs = [np.empty_like(a) for _ in range(threads)]
    with ThreadPoolExecutor(threads) as pool:
        def _all():
            list(pool.map(lambda out: np.matmul(a, a, out=out), outs))
        return 2 * threads * size ** 3 / interleaved({"gemm": _all}, seconds)["gemm"]
