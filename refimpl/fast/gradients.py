r"""Losses and gradients of one batch with everything shared that is shared, in one walk forwards
and one backwards: what training asks for, handed in as `gradients`.

`holden2017.objective.total_loss` with its backward is the definition, and for the loss network,
which `autoencoder` has, `holden2017.networks.autoencoder_loss`; these give the same numbers
(tested). They compute no layer twice, read a window's spectrum once for T's first layer and for the
loss network, decode at half resolution, and keep every large array from step to step. Arrays are
channel-last, (B, T, C). What comes back lasts until the next call.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..holden2017.networks import T_NAMES, Found, Params
from ..holden2017.objective import (CONTENT, EQUATION_10, STYLE, Batch, Terms, Weights, denormalise,
                                    reading, term_losses, term_losses_backward)
from ..nn.sums import wide_sum
from .decoder import check_even, pool_into, unpool_into
from .spectral import Plan, in_columns


def style_gradients(loss_network: Params, mean: np.ndarray, deviation: np.ndarray, weights: Weights,
                    terms: Terms = EQUATION_10) -> Callable[[Params, Batch], Found]:
    """`holden2017.objective.style_gradients`: (params, Batch) -> {term: mean}, gradients.

    A step is made for each size of batch and kept.
    """
    steps: dict[tuple[int, int], StyleStep] = {}

    def _of_batch(params, batch):
        B, _, T = batch.I.shape
        if (B, T) not in steps:
            steps[B, T] = StyleStep(B, T, params, loss_network, mean, deviation, weights, terms)
        return steps[B, T](params, batch)

    return _of_batch


class StyleStep:
    r"""The objective and its gradient for batches of B windows of T frames.

    loss_network : W0, b0, constants;  mean, deviation : (66,) of the normaliser;  weights : for the
    data's unit
    terms : of the objective; content and style are computed here, all others as they are written
    """

    def __init__(self, B: int, T: int, params: Params, loss_network: Params, mean: np.ndarray,
                 deviation: np.ndarray, weights: Weights, terms: Terms = EQUATION_10):
        check_even(T)
        self.names = [term.name for term in terms]
        here = [next((t for t in terms if t.loss is term.loss), replace(term, weight=0.0))
                for term in (CONTENT, STYLE)]
        self.content, self.style = (term.weight_of(weights) for term in here)
        self.of_hidden = [term for term in reading("hidden", terms) if term not in here]
        self.of_motion = reading("motion", terms)
        self.W0, self.b0 = loss_network["W0"], loss_network["b0"]
        dtype, (m, features, _) = self.W0.dtype, self.W0.shape
        self.mean, self.deviation = mean.astype(dtype), deviation.astype(dtype)
        self.weights = weights
        (c1, _, K), (c2, _, K2), (_, _, K3) = (params[name].shape for name in ("W1", "W2", "W3"))

        def _plan(C, O, width):
            return Plan(B, T, C, O, width, dtype, left=(width - 1) // 2)

        self.same_width = K == self.W0.shape[2]   # then W1 and W0 are one bank of filters for I
        self.layers = [_plan(features, c1 + m if self.same_width else c1, K), _plan(c1, c2, K2),
                       _plan(c2, features, K3)]
        self.of_input = (self.layers[0] if self.same_width
                         else _plan(features, m, self.W0.shape[2]))
        self.encoder = _plan(features, m, self.W0.shape[2])
        V0 = self.encoder.spectra(self.W0)
        self.V0 = in_columns(V0)
        self.V0_back = np.ascontiguousarray(V0.swapaxes(2, 3)).swapaxes(2, 3)   # O by C in memory
        first = self.layers[0]
        self.bank = np.empty((3, first.n // 2, features, first.shape[3]), dtype)
        self.V_input = self.of_input.spectra(
            self.W0, out=self.bank[..., c1:] if self.same_width else None)
        self.V1 = self.bank[..., :c1]
        self.V2, self.V3 = (np.empty((3, p.n // 2) + p.shape[2:4], dtype) for p in self.layers[1:])
        self.H, self.D, self.dH = (np.empty((B, T // 2, m), dtype) for _ in range(3))
        self.R, self.dZ = np.empty((B, m, m), dtype), np.empty((B, T // 2, 2, m), dtype)
        self.first, self.active = np.empty((B, T // 2, m), bool), np.empty((B, T // 2, m), bool)
        self.masks = [np.empty((B, T, c), bool) for c in (c1, c2)]

    def __call__(self, params: Params, batch: Batch) -> Found:
        """->  {term: mean over the Batch}, gradients with the keys of params"""
        O, H_input = self._forward(params, batch.I)
        if batch.hidden is not None:
            H_input[:] = batch.hidden.swapaxes(1, 2)
        found, dO = self._perceptual(O, H_input, batch)
        if self.of_motion:
            of_motion, dmotion = self._constraints(O, batch)
            found.update(of_motion)
            dO += dmotion.swapaxes(1, 2)
        return {name: found[name] for name in self.names}, self._backward(dO)

    def _forward(self, params, I):
        """T(I) (B, T, 66), and L(I) (B, T / 2, m) in D."""
        one, two, three = self.layers
        c1 = self.V1.shape[3]
        for plan, name, V in ((one, "W1", self.V1), (two, "W2", self.V2), (three, "W3", self.V3)):
            plan.spectra(params[name], out=V)
        one.input[:] = I.swapaxes(1, 2)
        Z = one.forward(self.bank)       # (B, T, 128 + 256): T's first layer, and L's of I
        if self.same_width:
            Z_input = Z[..., c1:]
        else:
            self.of_input.input[:] = one.input
            Z_input = self.of_input.forward(self.V_input)
        np.maximum(Z_input[:, 0::2], Z_input[:, 1::2], out=self.D)
        self.D += self.b0
        np.maximum(self.D, 0, out=self.D)
        Z1 = Z[..., :c1]
        Z1 += params["b1"]
        np.maximum(Z1, 0, out=two.input)
        Z2 = two.forward(self.V2)
        Z2 += params["b2"]
        np.maximum(Z2, 0, out=three.input)
        O = three.forward(self.V3)
        O += params["b3"]
        return O, self.D

    def _perceptual(self, O, H_input, batch):
        """What reads hidden units, content and style foremost, and its gradient with respect to O.

        ->  {term: mean}, dO (B, T, 66)
        """
        B, w = len(O), self.weights
        self.encoder.input[:] = O
        Z = self.encoder.forward(self.V0)
        Z += self.b0
        pool_into(Z, self.H, self.first, self.active)
        others, d_others = self._other_terms(batch, H_input)
        D = np.subtract(self.H, H_input, out=self.D)
        R = np.matmul(self.H.swapaxes(1, 2), self.H, out=self.R)
        for r, target in zip(R, batch.gram):
            r -= target
        content, d_content = _read(D, w.reading)
        style, d_style = _read(R, w.reading)
        R *= (2 * self.style / B) * d_style                # symmetric: (dG + dG^T) h = 2 dG h
        D *= (self.content / B) * d_content
        dH = np.matmul(self.H, R, out=self.dH)
        dH += D
        if d_others is not None:
            dH += d_others.swapaxes(1, 2)
        unpool_into(dH, self.first, self.active, self.dZ)
        dO, _ = self.encoder.backward(self.dZ.reshape(Z.shape), self.V0_back, to_filters=False)
        return {"content": self.content * content.mean(), "style": self.style * style.mean(),
                **others}, dO

    def _other_terms(self, batch, H_input):
        """Terms from outside that read hidden units.

        ->  {term: mean}, dH (B, m, T / 2) or None
        """
        if not self.of_hidden:
            return {}, None
        each = np.full(len(self.H), 1 / len(self.H), self.H.dtype)
        H = np.ascontiguousarray(self.H.swapaxes(1, 2))
        batch = replace(batch, hidden=H_input.swapaxes(1, 2).copy())
        found = term_losses(H, batch, self.of_hidden, self.weights)
        return ({name: loss.mean() for name, loss in found.items()},
                term_losses_backward(each, H, batch, self.of_hidden, self.weights))

    def _constraints(self, O, batch):
        """What reads motion.   ->  {term: mean}, gradient with respect to O as (B, 66, T)"""
        each = np.full(len(O), 1 / len(O), O.dtype)
        motion = np.ascontiguousarray((O * self.deviation + self.mean).swapaxes(1, 2))
        if any(term not in EQUATION_10 for term in self.of_motion):
            batch = replace(batch, motion=denormalise(batch.I, self.mean, self.deviation))
        found = term_losses(motion, batch, self.of_motion, self.weights)
        dmotion = term_losses_backward(each, motion, batch, self.of_motion, self.weights)
        return ({name: loss.mean() for name, loss in found.items()},
                dmotion * self.deviation[:, None])

    def _backward(self, dO):
        one, two, three = self.layers
        gradients = {}
        dA, gradients["W3"] = three.backward(dO, self.V3)
        gradients["b3"] = wide_sum(dO, (0, 1))
        dA *= np.greater(three.input, 0, out=self.masks[1])
        gradients["b2"] = wide_sum(dA, (0, 1))
        dA, gradients["W2"] = two.backward(dA, self.V2)
        dA *= np.greater(two.input, 0, out=self.masks[0])
        gradients["b1"] = wide_sum(dA, (0, 1))
        gradients["W1"] = one.backward(dA, None, to_input=False)[1]
        return {name: gradients[name] for name in T_NAMES}


def _read(r, reading):
    """The bars of equations 4 and 5 for each clip, and what r is multiplied by in their gradient.

    (B, ...)  ->  (B,), (B, 1, 1)
    """
    squares = np.array([np.vdot(one, one) for one in r])
    if reading == "norm":
        values = np.sqrt(squares)
        factors = 1 / np.where(values == 0, np.inf, values)      # 0 at a norm of 0 (the kink rule)
    else:
        count = r[0].size if reading == "mean_squares" else 1
        values, factors = squares / count, np.full(len(r), 2 / count)
    return values.astype(r.dtype), factors.astype(r.dtype)[:, None, None]
