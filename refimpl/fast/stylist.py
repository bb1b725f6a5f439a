r"""P(T(X)) as fast as it goes: plans with kept spectra, channel-last from end to end, the decoder
at half resolution, long clips in blocks.

`holden2017.networks.transformation` and `project` are the definition; `Stylist` gives the same
numbers (tested).
"""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
import math

import numpy as np

from ..holden2017.networks import Params
from .decoder import half_filters, taps
from .spectral import Plan, in_columns

BLOCK = 1920       # frames computed at a time: what they need stays in the processor's cache
HAND_OVER = 300    # frames that could be computed while one more thread begins (measured for two)


class Stylist:
    """The two networks, made ready for many clips.

    params : of T, or None to project only;  loss_network : W0, b0, and V0, c0 of an untied decoder,
    or None to transform only
    threads : Python threads, each with blocks of its own; of a short clip fewer take part (the same
    bits for the same number)
    block : frames computed at a time
    The arrays of params are read once: a Stylist does not see later changes.
    """

    def __init__(self, params: Params | None, loss_network: Params | None, *, threads: int = 1,
                 block: int = BLOCK):
        layers: list[tuple] = []
        if params is not None:
            layers = [(params[f"W{i}"], params[f"b{i}"]) for i in (1, 2, 3)]
        self.encoder, self.tied = len(layers), True              # the number of L's first layer
        if loss_network is not None:
            W0, b0 = loss_network["W0"], loss_network["b0"]
            self.tied = "V0" not in loss_network
            layers += [(W0, b0), (half_filters(loss_network.get("V0", W0)),
                                  None if self.tied else loss_network["c0"])]
        self.filters, self.biases = [W for W, _ in layers], [b for _, b in layers]
        self.dtype, self.block = self.filters[0].dtype, max(2, block - block % 2)
        # Frames that a result looks to each side, even for the pooling.
        self.reach = sum(W.shape[2] // 2 + 1 for W in self.filters[:self.encoder + 1])
        self.reach += 0 if loss_network is None else W0.shape[2] // 2 + 2
        self.reach += self.reach % 2
        self.threads = threads
        self.pool = ThreadPoolExecutor(threads) if threads > 1 else None
        self._spectra: dict = {}
        self._plans: list[dict] = [{} for _ in range(threads)]   # a plan serves one thread

    def transform(self, X: np.ndarray) -> np.ndarray:
        """T(X).   (N, 66, T)  ->  (N, 66, T)"""
        return self._in_blocks(X, range(self.encoder))

    def project(self, X: np.ndarray) -> np.ndarray:
        """P(X) = L+(L(X)).   (N, 66, T)  ->  (N, 66, T)"""
        return self._in_blocks(X, range(self.encoder, len(self.filters)))

    def stylise(self, X: np.ndarray) -> np.ndarray:
        """P(T(X)).   (N, 66, T)  ->  (N, 66, T)"""
        return self._in_blocks(X, range(len(self.filters)))

    def _in_blocks(self, X: np.ndarray, layers: Sequence[int]) -> np.ndarray:
        """Each block is computed with `reach` frames more on both sides, which makes it exact.

        ->  (N, 66, T), channel-last in memory
        """
        N, C, T = X.shape
        result = np.empty((N, T, C), self.dtype)
        threads, size = self._shares(T)

        def _every(lane):
            for begin in range(lane * size, T, threads * size):
                end = min(T, begin + size)
                first, last = max(0, begin - self.reach), min(T, end + self.reach)
                part = self._run(X[:, :, first:last], layers, self._plans[lane])
                result[:, begin:end] = part[:, begin - first:end - first]

        if threads == 1 or self.pool is None:
            _every(0)
        else:
            list(self.pool.map(_every, range(threads)))
        return result.swapaxes(1, 2)

    def _shares(self, T):
        """How many threads finish T frames first, and the even number of frames of a block."""
        def _frames(threads):
            """Those that the busiest thread computes."""
            neighbours = min(threads - 1, 2)
            return T / threads + neighbours * self.reach + (threads - 1) * HAND_OVER
        threads = min(range(1, self.threads + 1), key=_frames)
        blocks = threads * math.ceil(T / (threads * self.block))
        return threads, max(2, 2 * math.ceil(T / blocks / 2))

    def _run(self, X, layers, plans):
        """(N, 66, T)  ->  (N, T, 66), in a plan's memory"""
        N, C, T = X.shape
        encoder = self.encoder
        even = T + T % 2 if encoder in layers else T   # an odd last frame is doubled for pooling
        first = self._plan(plans, layers[0], N, even if layers[0] == encoder else T).input
        first[:, :T] = X.swapaxes(1, 2)
        first[:, T:] = X[:, None, :, -1]
        for layer in layers:
            frames = even if layer == encoder else even // 2 if layer > encoder else T
            plan = self._plan(plans, layer, N, frames)
            y = plan.forward(self._filter_spectra(layer, plan))
            if layer > encoder:              # (N, T / 2, 2 x 66): even and odd frames side by side
                X = y.reshape(N, even, C)[:, :T]
                return X if self.tied else X + self.biases[layer]
            if layer == encoder:
                self._pool_into(self._plan(plans, layer + 1, N, even // 2).input, y)
                continue
            y += self.biases[layer]
            if layer + 1 not in layers:
                return y
            after = even if layer + 1 == encoder else T
            following = self._plan(plans, layer + 1, N, after).input
            if layer + 1 < encoder:
                np.maximum(y, 0, out=following)
            else:
                following[:, :T] = y
                following[:, T:] = y[:, -1:]
        raise AssertionError("the last layer returns")

    def _pool_into(self, E, Z):
        """E = relu(max-pool(Z + b0)) / 2 - b0, what the decoder at half resolution reads (an untied
        one without - b0).   Z : (N, T, m), E : (N, T / 2, m)"""
        b0 = self.biases[self.encoder]
        np.maximum(Z[:, 0::2], Z[:, 1::2], out=E)
        E += b0
        np.maximum(E, 0, out=E)
        E *= self.dtype.type(0.5)
        if self.tied:
            E -= b0

    def _plan(self, plans, layer, N, T):
        """One plan for each layer and size; the sizes of the last two clips are kept."""
        sizes = plans.setdefault(layer, {})
        if (N, T) not in sizes:
            O, C, K = self.filters[layer].shape
            left = (K - 1) // 2
            if layer > self.encoder:
                left = taps(self.filters[self.encoder].shape[2])[2]
            while len(sizes) > 3:
                sizes.pop(next(iter(sizes)))
            sizes[N, T] = Plan(N, T, C, O, K, self.dtype, left=left)
        return sizes[N, T]

    def _filter_spectra(self, layer, plan):
        """Computed once for each layer and tile."""
        if (layer, plan.n) not in self._spectra:
            self._spectra[layer, plan.n] = in_columns(plan.spectra(self.filters[layer]))
        return self._spectra[layer, plan.n]
