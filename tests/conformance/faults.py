"""Faults planted in the reference, one at a time: the kit must catch each. Run as a script to write
the table FAULTS.md beside this file.
"""

from dataclasses import dataclass
import sys

import numpy as np

from refimpl import nn
from refimpl.conformance import cases, judge_all, reference
from refimpl.conformance.rivals import (adam_variant, epsilon_inside_the_root, flipped,
                                        flipped_backward, foot_without_rotation, journal_trajectory,
                                        larger_half_left, mean_over, nan_ignored, read_as,
                                        tie_split_equally, tie_to_all, tie_to_the_last)
from refimpl.holden2017 import losses
from refimpl.motion.joints import BONES
from tests.conformance import faults_2016, faults_new, faults_torresani, faults_whole

GOOD = reference().functions


@dataclass(frozen=True)
class Fault:
    """name : what is wrong;  function : of the backend;  wrong : what stands in its place"""

    name: str
    function: str
    wrong: callable


def changed(function, change, number=None):
    """The good function with one of its results changed by `change(result, *arguments)`."""
    def wrong(*arguments, **attributes):
        results = GOOD[function](*arguments, **attributes)
        if number is None:
            return change(results, *arguments)
        results = list(results)
        if results[number] is not None:
            results[number] = change(results[number], *arguments)
        return tuple(results)
    return wrong


def one_element(factor):
    """Multiply one element, the largest, so that the fault is seen in float64 and nowhere else."""
    def change(result, *arguments):
        result = result.copy()
        if result.size:
            result.flat[np.argmax(np.abs(result))] *= factor
        return result
    return change


def edge(index):
    """Forget the first or the last frame of the input gradient."""
    def change(result, *arguments):
        result = result.copy()
        result[:, :, index] = 0
        return result
    return change


def mutating(function, position):
    """Write into an argument, by a bit that is put back in no one's memory."""
    def wrong(*arguments, **attributes):
        results = GOOD[function](*arguments, **attributes)
        try:
            arguments[position][...] *= 1 + 1e-9
        except ValueError:
            # a read-only argument: nothing to see there
            pass
        return results
    return wrong


def with_noise(function):
    """Noise of 1e-9, as a parallel sum in changing order would make it, only larger."""
    rng = np.random.default_rng()
    return changed(function, lambda g, *a: g * (1 + 1e-9 * rng.standard_normal()), 0)


def with_state(function):
    """Remember the last filters and add a little of them: the same call gives something else after
    another one.
    """
    memory = {}

    def wrong(dy, x, w, *rest, **attributes):
        dx, dw, db = GOOD[function](dy, x, w, *rest, **attributes)
        if memory.get("w", w).shape == w.shape:
            dw = dw + 1e-6 * (memory.get("w", w) - w)
        memory["w"] = w.copy()
        return dx, dw, db
    return wrong


def only_contiguous(function):
    """Read the raw memory of the upstream gradient as if it lay in C order, as a careless binding
    does.
    """
    def wrong(dy, *arguments, **attributes):
        if not dy.flags.c_contiguous:
            dy = dy.ravel(order="K").reshape(dy.shape)
        return GOOD[function](dy, *arguments, **attributes)
    return wrong


def shared_memory(function):
    """Hand the upstream gradient back where it happens to be the answer."""
    def wrong(dy, x):
        return np.multiply(dy, x > 0, out=dy)
    return wrong


def bone_sign(dloss, motion, *, lengths):
    """The gradient of a bone's length with the same sign at both ends of one bone."""
    gradient = losses.bone_loss_backward(dloss, motion, lengths)
    alone = [b for b, (_, child) in enumerate(BONES)
             if all(child != parent for parent, _ in BONES)][0]
    joint = BONES[alone][1]
    gradient[:, 3 * joint:3 * joint + 3] *= -1
    return gradient


def foot_turn_forgotten(dloss, motion, contacts, *, target=0.0):
    gradient = losses.foot_loss_backward(dloss, motion, contacts, target=target)
    gradient[:, losses.TURN] = 0
    return gradient


def foot_position_forgotten(dloss, motion, contacts, *, target=0.0):
    """The rotation term's gradient missing in the positions: that of a motion which does not turn.
    """
    straight = motion.copy()
    straight[:, losses.TURN] = 0
    gradient = losses.foot_loss_backward(dloss, motion, contacts, target=target)
    gradient[:, losses.POSITIONS] = losses.foot_loss_backward(dloss, straight, contacts,
                                                              target=target)[:, losses.POSITIONS]
    return gradient


def tied_filters_once(dloss, X, W0, b0, **attributes):
    """The filters' gradient from the encoder forgotten: tied weights receive both."""
    from refimpl.holden2017 import networks
    dX, _, db0 = GOOD["autoencoder_loss_backward"](dloss, X, W0, b0, **attributes)
    params = {"W0": W0, "b0": b0}
    H = networks.encode(X, params)
    mean = attributes.get("mean", True)
    chosen = attributes.get("chosen")
    d = nn.squared_error_backward(dloss, networks.decode(H, params, chosen=chosen), X,
                                  reduction="mean" if mean else "sum")[0]
    return dX, networks.decode_backward(d, H, params, chosen=chosen)[1]["W0"], db0


def halved_squares(dloss, G, H, *, s=0.01, reading="norm"):
    half = 1 if reading == "norm" else dloss.dtype.type(0.5)
    return losses.style_loss_backward(dloss * half, G, H, s=s, reading=reading)


def relu_after(dy, x):
    return np.where(nn.relu(dy) > 0, np.where(x > 0, dy, 0), 0)


FAULTS = (
    Fault("bias gradient averaged over clips and frames", "conv1d_backward",
          mean_over((0, 2), 2, nn.conv1d_backward)),
    Fault("filter gradient averaged over clips", "conv1d_backward",
          mean_over((0,), 1, nn.conv1d_backward)),
    Fault("filter flipped, forward", "conv1d", flipped(nn.conv1d)),
    Fault("filter flipped, backward", "conv1d_backward", flipped_backward(nn.conv1d_backward)),
    Fault("first frame of the input gradient dropped", "conv1d_backward",
          changed("conv1d_backward", edge(0), 0)),
    Fault("last frame of the input gradient dropped", "conv1d_backward",
          changed("conv1d_backward", edge(-1), 0)),
    Fault("input gradient off by 1e-3 of itself", "conv1d_backward",
          changed("conv1d_backward", lambda g, *a: g * (1 + 1e-3), 0)),
    Fault("input gradient off by 1e-4 of itself", "conv1d_backward",
          changed("conv1d_backward", lambda g, *a: g * (1 + 1e-4), 0)),
    Fault("input gradient off by 1e-6 of itself", "conv1d_backward",
          changed("conv1d_backward", lambda g, *a: g * (1 + 1e-6), 0)),
    Fault("filter gradient off by 1e-9 of itself", "conv1d_backward",
          changed("conv1d_backward", lambda g, *a: g * (1 + 1e-9), 1)),
    Fault("one element of the filter gradient with the wrong sign", "conv1d_backward",
          changed("conv1d_backward", one_element(-1), 1)),
    Fault("one element of the input gradient off by 1 %", "conv1d_backward",
          changed("conv1d_backward", one_element(1.01), 0)),
    Fault("input changed", "conv1d_backward", mutating("conv1d_backward", 1)),
    Fault("upstream gradient changed", "conv1d_backward", mutating("conv1d_backward", 0)),
    Fault("noise of 1e-9", "conv1d_backward", with_noise("conv1d_backward")),
    Fault("hidden state", "conv1d_backward", with_state("conv1d_backward")),
    Fault("float32 returned for float64", "conv1d_backward",
          changed("conv1d_backward", lambda g, *a: g.astype(np.float32), 1)),
    Fault("wrong on an upstream gradient that is not contiguous", "conv1d_backward",
          only_contiguous("conv1d_backward")),
    Fault("float64 returned for float32", "conv1d",
          changed("conv1d", lambda y, *a: y.astype(float))),
    Fault("larger half of the zeros on the left", "conv1d", larger_half_left),
    Fault("bias added twice", "conv1d", lambda x, w, b=None,
          **k: nn.conv1d(x, w, None if b is None else 2 * b, **k)),
    Fault("bias forgotten", "conv1d", lambda x, w, b=None, **k: nn.conv1d(x, w, None, **k)),
    Fault("stride forgotten in the input gradient", "conv1d_backward",
          lambda d, x, w, b=None, **k: (np.zeros_like(x) if k.get("stride", 1) > 1
                                        else nn.conv1d_backward(d, x, w, b, **k)[0],
                                        *nn.conv1d_backward(d, x, w, b, **k)[1:])),
    Fault("padding not checked", "conv1d", lambda x, w, b=None,
          **k: nn.conv1d(x, w, b, **{**k, "padding": abs(k["padding"]) if k.get("padding") == -1
                                     else k.get("padding", "same")})),
    Fault("whole numbers accepted", "conv1d", lambda x, w, b=None,
          **k: nn.conv1d(x.astype(float) if x.dtype.kind == "i" else x, w, b, **k)),
    Fault("empty batch refused", "conv1d", lambda x, w, b=None, **k: nn.conv1d(x, w, b, **k)
          if len(x) else 1 / 0),
    Fault("filter flipped in the transposed convolution", "conv_transpose1d",
          flipped(nn.conv_transpose1d)),
    Fault("output padding on the left", "conv_transpose1d",
          changed("conv_transpose1d", lambda y, *a: np.roll(y, 1, axis=2))),
    Fault("tie to the last", "max_pool1d_backward", tie_to_the_last),
    Fault("tie to all", "max_pool1d_backward", tie_to_all),
    Fault("tie split equally", "max_pool1d_backward", tie_split_equally),
    Fault("NaN ignored", "max_pool1d", nan_ignored),
    Fault("ceil mode ignored", "max_pool1d", lambda x, width=2, *, ceil_mode=False,
          **k: nn.max_pool1d(x, width, **k)),
    Fault("padding not counted", "avg_pool1d", lambda x, width=2, *, count_include_pad=True,
          **k: nn.avg_pool1d(x, width, count_include_pad=False, **k)),
    Fault("depooling without its division", "avg_depool1d", lambda h,
          width=2: np.repeat(h, width, axis=2)),
    Fault("depooling gradient without its division", "avg_depool1d_backward", lambda d, h,
          width=2: nn.avg_depool1d_backward(d, h, width) * d.dtype.type(width)),
    Fault("relu's gradient 1 at 0", "relu_backward", lambda d,
          x: np.where(x >= 0, d, d.dtype.type(0))),
    Fault("relu's gradient 0.5 at 0", "relu_backward", lambda d,
          x: np.where(x > 0, d, np.where(x == 0, d / 2, d.dtype.type(0)))),
    Fault("relu applied to the upstream gradient too", "relu_backward", relu_after),
    Fault("gradient in the upstream gradient's own memory", "relu_backward",
          shared_memory("relu_backward")),
    Fault("Gram matrix divided by the frames", "gram",
          lambda h: nn.gram(h) / h.dtype.type(h.shape[2])),
    Fault("only one of the Gram gradient's two terms", "gram_backward", lambda d, h: d @ h),
    Fault("twice one term of the Gram gradient", "gram_backward", lambda d, h: 2 * (d @ h)),
    Fault("the norm's gradient not divided by the norm", "norm_backward", lambda d,
          r: nn.sum_squares_backward(d, r) / r.dtype.type(2)),
    Fault("NaN at a norm of 0", "norm_backward", lambda d,
          r: d.reshape((-1,) + (1,) * (r.ndim - 1)) * r
          / nn.norm(r).reshape((-1,) + (1,) * (r.ndim - 1))),
    Fault("sign(0) = 1", "l1_backward", lambda d,
          a: np.where(a >= 0, a.dtype.type(1), a.dtype.type(-1)) * a.dtype.type(d)),
    Fault("mean over clips only", "squared_error", lambda x, y, *,
          reduction="mean": nn.squared_error(x, y, reduction=reduction) if reduction != "mean"
          else ((x - y) ** 2).sum() / x.dtype.type(len(x))),
    Fault("target's gradient with the wrong sign", "squared_error_backward", lambda d, x, y,
          **k: (nn.squared_error_backward(d, x, y, **k)[0],) * 2),
    Fault("epsilon inside the root", "adam_step", epsilon_inside_the_root),
    Fault("no bias correction", "adam_step", adam_variant("no-bias-correction")),
    Fault("epsilon-hat", "adam_step", adam_variant("epsilon-hat")),
    Fault("foot loss without the rotation term", "foot_loss", foot_without_rotation),
    Fault("foot gradient without turning", "foot_loss_backward", foot_turn_forgotten),
    Fault("foot gradient without the positions' rotation term", "foot_loss_backward",
          foot_position_forgotten),
    Fault("bone gradient with the wrong sign on one end", "bone_loss_backward", bone_sign),
    Fault("bone lengths squared", "bone_loss", lambda m, *,
          lengths: losses.bone_loss(m, lengths ** 2)),
    Fault("turning error not squared", "trajectory_loss", journal_trajectory),
    Fault("turn weight applied twice", "trajectory_loss", lambda m, *, wanted,
          turn_weight=1.0: losses.trajectory_loss(m, wanted, turn_weight=turn_weight ** 2)),
    Fault("content loss squared", "content_loss", read_as(losses.content_loss, "sum_squares")),
    Fault("style loss without its weight", "style_loss", lambda g, h, *, s=0.01,
          reading="norm": losses.style_loss(g, h, s=1.0, reading=reading)),
    Fault("bars read as norms whatever is asked", "content_loss", lambda a, b, *, c=1.0,
          reading="norm": losses.content_loss(a, b, c=c)),
    Fault("style's squares without their factor 2", "style_loss_backward", halved_squares),
    Fault("weights of norms for means of squares", "total_loss", lambda *a, reading="norm",
          **k: GOOD["total_loss"](*a, **k)),
    Fault("half of each value in the chosen frame", "random_depool1d", lambda h, chosen,
          width=2: nn.random_depool1d(h / h.dtype.type(width), chosen, width)),
    Fault("the other frame chosen", "random_depool1d", lambda h, chosen,
          width=2: nn.random_depool1d(h, width - 1 - chosen, width)),
    Fault("the first unit's choice for all", "random_depool1d", lambda h, chosen,
          width=2: nn.random_depool1d(h, np.broadcast_to(chosen[:, :1], h.shape), width)),
    Fault("choices beyond the width wrapped", "random_depool1d", lambda h, chosen,
          width=2: nn.random_depool1d(h, chosen % width if np.size(width) and width else chosen,
                                      width)),
    Fault("the gradient of average-depooling", "random_depool1d_backward", lambda d, h, chosen,
          width=2: nn.avg_depool1d_backward(d, h, width)),
    Fault("the gradient of the frame not chosen", "random_depool1d_backward", lambda d, h, chosen,
          width=2: nn.random_depool1d_backward(d, h, width - 1 - chosen, width)),
    Fault("the choice forgotten in the decoder", "decode", lambda H, W0, b0, *,
          chosen=None: GOOD["decode"](H, W0, b0)),
    Fault("the choice forgotten in the decoder's gradient", "autoencoder_loss_backward",
          lambda d, X, W0, b0, *, chosen=None,
          **k: GOOD["autoencoder_loss_backward"](d, X, W0, b0, **k)),
    Fault("pooling before the bias of the encoder is added twice", "encode", lambda X, W0,
          b0: GOOD["encode"](X, W0, 2 * b0)),
    Fault("bias added in the decoder", "decode", lambda H, W0, b0,
          **k: GOOD["decode"](H, W0, -b0, **k)),
    Fault("tied filters receive one gradient of two", "autoencoder_loss_backward",
          tied_filters_once),
    Fault("the second relu of T forgotten", "transform", lambda X, W1, b1, W2, b2, W3,
          b3: nn.conv1d(nn.conv1d(nn.relu(nn.conv1d(X, W1, b1)), W2, b2), W3, b3)),
    Fault("batch summed, not averaged", "total_loss_backward", lambda d, *arrays,
          **k: tuple(g * g.dtype.type(len(k["I"]))
                     for g in GOOD["total_loss_backward"](d, *arrays, **k))),
    Fault("places counted from the window's begin", "max_pool1d_indices",
          changed("max_pool1d_indices", lambda found, *a: found % 2)),
    Fault("of two values for one place the first stands", "max_unpool1d",
          lambda h, indices, length: GOOD["max_unpool1d"](h[:, :, ::-1].copy(),
                                                          indices[:, :, ::-1].copy(), length)),
    Fault("two of the square forgotten", "sum_squares_backward",
          changed("sum_squares_backward", lambda g, *a: g / 2)),
    Fault("a mean over the batch too", "mean_squares",
          changed("mean_squares", lambda y, *a: np.full_like(y, y.mean()) if y.size else y)),
    Fault("the second gradient with the sign of the first", "absolute_error_backward",
          changed("absolute_error_backward", lambda g, *a: -g, 1)),
    *(Fault(*fault) for fault in faults_2016.FAULTS + faults_torresani.FAULTS
      + faults_whole.FAULTS + faults_new.FAULTS),
)


def caught_by(fault, seed):
    """The failing cases of the operation.   ->  list of Outcome"""
    backend = {**GOOD, fault.function: fault.wrong}
    chosen = cases(seed=seed, operations=[fault.function.removesuffix("_backward")],
                   profile="small")
    return [outcome for outcome in judge_all(backend, chosen) if outcome.status == "failed"]


def write_table(path, seeds=10):
    """The table of FAULTS.md: fault, first case that catches it, in how many seeds, the rival that
    the report names.
    """
    lines = ["# Planted faults", "",
             f"Each was planted in the reference alone and judged over {seeds} seeds. `python -m "
             f"tests.conformance.faults {seeds}` makes this table again.", "",
             "| fault | in | caught in | first caught by | the report says |",
             "| --- | --- | --- | --- | --- |"]
    for fault in FAULTS:
        found = [caught_by(fault, seed) for seed in range(seeds)]
        first = found[0][0] if found[0] else None
        rival = next((outcome.rival for outcome in found[0] if outcome.rival), "")
        lines.append(
            f"| {fault.name} | `{fault.function}` | {sum(map(bool, found))} of {seeds} seeds | "
            f"{first.case.id.split('/', 1)[1] if first else 'nothing'} | "
                     f"{'matches ' + rival.rsplit(', to ', 1)[0] if rival else ''} |")
        print(lines[-1], file=sys.stderr)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    from pathlib import Path
    write_table(Path(__file__).with_name("FAULTS.md"), *map(int, sys.argv[1:2]))
