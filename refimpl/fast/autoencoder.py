r"""Losses and gradients of one batch of the loss network's training, as `gradients` has those of
the style network's; `holden2017.networks.autoencoder_loss` and its backward are the definition."""

from collections.abc import Callable

import numpy as np

from ..holden2017.networks import Found, Params, Reconstruction
from ..nn.sums import wide_sum
from .decoder import (check_even, half_filters, half_filters_backward, pool_into, taps, unpool_into)
from .spectral import Plan


def autoencoder_gradients(alpha: float) -> Callable[[Params, Reconstruction], Found]:
    """`holden2017.networks.autoencoder_gradients`: (params, Reconstruction) -> losses, gradients.

    A step is made for each size of batch and kept.
    """
    steps: dict[tuple[int, int, bool], AutoencoderStep] = {}

    def _of_batch(params, batch):
        (B, _, T), random = batch.X.shape, batch.chosen is not None
        if (B, T, random) not in steps:
            steps[B, T, random] = AutoencoderStep(B, T, params, alpha=alpha, random=random)
        loss, gradients = steps[B, T, random](params, batch.X, batch.noisy, batch.chosen)
        return {"loss": loss}, gradients

    return _of_batch


class AutoencoderStep:
    """The loss network's loss (`mean=True`) and its gradient for batches of B windows of T frames,
    T even.

    random : whether it decodes with depooling by chance, which needs the full resolution
    """

    def __init__(self, B: int, T: int, params: Params, *, alpha: float = 0.01,
                 random: bool = False):
        check_even(T)
        W0, self.alpha, self.random = params["W0"], alpha, random
        dtype, (m, features, K) = W0.dtype, W0.shape
        self.encoder = Plan(B, T, features, m, K, dtype, left=(K - 1) // 2)
        if random:
            self.decoder = Plan(B, T, m, features, K, dtype, left=K - 1 - (K - 1) // 2)
        else:
            _, count, left = taps(K)
            self.decoder = Plan(B, T // 2, m, 2 * features, count, dtype, left=left)
        self.V, self.V_decoder = (np.empty((3, p.n // 2) + p.shape[2:4], dtype)
                                  for p in (self.encoder, self.decoder))
        self.H, self.dZ = np.empty((B, T // 2, m), dtype), np.empty((B, T // 2, 2, m), dtype)
        self.first, self.active = np.empty((B, T // 2, m), bool), np.empty((B, T // 2, m), bool)

    def __call__(self, params: Params, X: np.ndarray, noisy: np.ndarray | None = None,
                 chosen: np.ndarray | None = None) -> tuple[float, dict[str, np.ndarray]]:
        """X, noisy : (B, 66, T);  chosen : (B, m, T // 2) with `random`

        ->  loss, gradients with the keys of params
        """
        W0, b0 = params["W0"], params["b0"]
        size = W0.size + b0.size
        self.encoder.spectra(W0, out=self.V)
        self.decoder.spectra(
            _transposed(W0) if self.random else half_filters(W0), out=self.V_decoder)
        self.encoder.input[:] = (X if noisy is None else noisy).swapaxes(1, 2)
        Z = self.encoder.forward(self.V)
        Z += b0
        pool_into(Z, self.H, self.first, self.active)
        later = None if chosen is None else chosen.swapaxes(1, 2).astype(bool)   # (B, T / 2, m)
        self._depool_into(self.decoder.input, later)
        self.decoder.input -= b0
        # (B, T, 66), or (B, T / 2, 2 x 66) in the same order
        error = self.decoder.forward(self.V_decoder)
        shape = error.shape
        error = error.reshape(len(X), -1, X.shape[1])
        error -= X.swapaxes(1, 2)
        loss = (sum(float(np.vdot(e, e)) for e in error) / error.size
                + self.alpha * (np.abs(W0).sum() + np.abs(b0).sum()) / size)
        error *= Z.dtype.type(2 / error.size)
        dD, from_decoder = self.decoder.backward(error.reshape(shape), self.V_decoder)
        db0 = -wide_sum(dD, (0, 1))
        unpool_into(self._gathered(dD, later), self.first, self.active, self.dZ)
        dZ = self.dZ.reshape(Z.shape)
        dW0 = self.encoder.backward(dZ, None, to_input=False)[1]
        dW0 += (_transposed(from_decoder) if self.random
                else half_filters_backward(from_decoder, W0.shape[2]))
        dW0 += Z.dtype.type(self.alpha / size) * np.sign(W0)
        db0 += wide_sum(dZ, (0, 1)) + Z.dtype.type(self.alpha / size) * np.sign(b0)
        return loss, {"W0": dW0, "b0": db0}

    def _depool_into(self, D, later):
        """The units, all in one frame of each pair or, at half resolution, half of them."""
        if later is None:
            np.multiply(self.H, self.H.dtype.type(0.5), out=D)
            return
        pairs = D.reshape(self.dZ.shape)
        np.multiply(self.H, later, out=pairs[:, :, 1])
        np.subtract(self.H, pairs[:, :, 1], out=pairs[:, :, 0])

    def _gathered(self, dD, later):
        """The gradient of the units, from where they went."""
        if later is None:
            dD *= self.H.dtype.type(0.5)
            return dD
        pairs = dD.reshape(self.dZ.shape)
        return np.where(later, pairs[:, :, 1], pairs[:, :, 0])


def _transposed(W):
    """Filters of a transposed convolution as those of a correlation, and back.

    (m, C, K)  ->  (C, m, K)
    """
    return W[:, :, ::-1].swapaxes(0, 1)
