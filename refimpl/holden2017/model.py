"""The two kinds of model file: a manifold (the loss network) and a style (a transformation network
with its manifold).
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..motion.features import FEATURES, LEG_RANGE
from ..motion.joints import BONES
from ..motion.windows import FORMS, Normaliser
from ..storage import FormatError, load_npz, plausible, save_npz
from .known import NUMBERS, Known
from .losses import READINGS
from .stylist import Stylist
from .objective import WEIGHED, Weights
from .train import DEPOOLING

# with 2 and 3 the root's velocity is seen from the frame that it leads to
VERSION, STYLE_VERSION = 2, 3
_SKELETON = ("mean", "deviation", "bones")
_FACTS = {"leg": float, "source": str, "normaliser": str, "depooling": str}


@dataclass(frozen=True)
class Manifold:
    """A trained loss network and what its numbers mean.

    params : W0, b0, and V0, c0 where the decoder is not tied;  normaliser : of the data it was
    trained on;  leg, bones : that data's skeleton, in its length unit;
    depooling : while it learnt, of `train.DEPOOLING`.
    """

    params: dict = field(repr=False)
    normaliser: Normaliser
    leg: float
    bones: np.ndarray
    depooling: str = "random"

    def network_input(self, features):
        """Features (T, 66) on this model's scale to what the networks take: (1, 66, T) in their
        precision.
        """
        return np.ascontiguousarray(
            self.normaliser.apply(features).T[None], dtype=self.params["W0"].dtype)

    def motion(self, output):
        """The inverse of `network_input`.   (1, 66, T)  ->  (T, 66) float64"""
        return self.normaliser.undo(output[0].T.astype(float))

    @cached_property
    def stylist(self):
        """The projection P, made ready for many clips."""
        return Stylist(None, self.params)


@dataclass(frozen=True)
class Style:
    """A trained transformation network.

    params : W1, b1 ... b3;  name : of the style;  pairs : {content it was trained for: content of
    its exemplars};
    learned, exemplars : names of the clips that it learnt on;  weights : of equation 10 in its
    training, for the manifold's unit;
    known : what it learnt on, to tell when a clip is something else.
    """

    params: dict = field(repr=False)
    manifold: Manifold
    name: str
    pairs: dict
    learned: tuple = ()
    exemplars: tuple = ()
    weights: Weights = Weights()
    known: Known | None = None

    @property
    def contents(self):
        return tuple(self.pairs)

    @cached_property
    def stylist(self):
        """T and P, made ready for many clips."""
        return Stylist(self.params, self.manifold.params)


def save_manifold(path, manifold):
    """Write a Manifold, whole or not at all."""
    save_npz(path, "manifold", VERSION, {**manifold.params, **_skeleton_arrays(manifold)},
             _facts(manifold))


def load_manifold(path):
    """Read a Manifold.   Raises FormatError when its parts do not fit each other."""
    arrays, facts = load_npz(path, "manifold", VERSION, ("W0", "b0", *_SKELETON), _FACTS)
    return _manifold(path, arrays, facts)


def save_style(path, style):
    """Write a Style together with its Manifold, so that one file is enough to stylise a clip."""
    seen = style.known or Known(np.zeros((0, NUMBERS), np.float32), np.ones(NUMBERS), 1.0)
    weights = np.array([getattr(style.weights, name) for name in WEIGHED], dtype=float)
    arrays = {**style.params, **style.manifold.params, **_skeleton_arrays(style.manifold),
              "weights": weights, "pieces": seen.pieces, "piece_scale": seen.scale}
    facts = {**_facts(style.manifold), "name": style.name, "contents": list(style.pairs),
             "exemplar_contents": list(style.pairs.values()), "learned": list(style.learned),
             "exemplars": list(style.exemplars), "reading": style.weights.reading,
             "usual": seen.usual}
    save_npz(path, "style", STYLE_VERSION, arrays, facts)


def load_style(path):
    """Read a Style.   Raises FormatError when its parts do not fit each other."""
    arrays, facts = load_npz(
        path, "style", STYLE_VERSION, ("W0", "b0", "W1", "b1", "W2", "b2", "W3", "b3", "weights",
                                       "pieces", "piece_scale", *_SKELETON),
        {
            **_FACTS, "name": str,
            **dict.fromkeys(("contents", "exemplar_contents", "learned", "exemplars"), list), "reading": str,
            "usual": float})
    manifold = _manifold(path, arrays, facts)
    params = {name: arrays[name] for name in ("W1", "b1", "W2", "b2", "W3", "b3")}
    channels = [FEATURES, params["b1"].size, params["b2"].size, FEATURES]
    for layer in (1, 2, 3):
        _check_filters(path, params, f"W{layer}", f"b{layer}", channels[layer], channels[layer - 1])
    if params["W1"].dtype != manifold.params["W0"].dtype:
        raise FormatError(
            f"{path}: found W1 of {params['W1'].dtype} beside W0 of {manifold.params['W0'].dtype}, "
            "needed one precision")
    if len(facts["contents"]) != len(facts["exemplar_contents"]):
        raise FormatError(
            f"{path}: found {len(facts['contents'])} contents and "
            f"{len(facts['exemplar_contents'])} of exemplars, needed pairs")
    values = arrays["weights"]
    if facts["reading"] not in READINGS or values.shape != (
            len(WEIGHED),) or values.dtype != float or not (np.isfinite(values) &
                                                             (values >= 0)).all():
        raise FormatError(
            f"{path}: found weights {values.dtype} {values.shape} and reading "
            f"{facts['reading'][:40]!r}, needed {len(WEIGHED)} numbers from 0 on "
            f"and one of {', '.join(READINGS)}")
    weights = Weights(**dict(zip(WEIGHED, values.tolist())), reading=facts["reading"])
    return Style(params, manifold, facts["name"],
                 dict(zip(facts["contents"], facts["exemplar_contents"])), tuple(facts["learned"]),
                 tuple(facts["exemplars"]), weights, _known(path, arrays, facts))


def _known(path, arrays, facts):
    pieces, scale = arrays["pieces"], arrays["piece_scale"]
    if (pieces.ndim != 2 or pieces.shape[1:] != scale.shape or scale.shape != (NUMBERS,)
            or pieces.dtype != np.float32 or scale.dtype != float
            or not (plausible(pieces) and plausible(scale) and
                    (scale > 0).all() and 0 < facts["usual"] < np.inf)):
        raise FormatError(
            f"{path}: found pieces of shape {pieces.shape} with scales of shape {scale.shape}, "
            f"needed (n, {NUMBERS}) and ({NUMBERS},) of plausible "
            "numbers, those of what the style learnt on")
    return Known(pieces, scale, facts["usual"]) if len(pieces) else None


def _skeleton_arrays(manifold):
    return {
        "mean": manifold.normaliser.mean, "deviation": manifold.normaliser.deviation,
        "bones": manifold.bones}


def _facts(manifold):
    return {
        "leg": manifold.leg, "source": manifold.normaliser.source,
        "normaliser": manifold.normaliser.form, "depooling": manifold.depooling}


def _manifold(path, arrays, facts):
    for name, shape in (("mean", (FEATURES,)), ("deviation", (FEATURES,)), ("bones",
                                                                              (len(BONES),))):
        if arrays[name].shape != shape or arrays[name].dtype != float or not plausible(
                arrays[name]):
            raise FormatError(
                f"{path}: found {name} of shape {arrays[name].shape}, needed finite numbers of "
                f"shape {shape}, none beyond 1e9")
    if not LEG_RANGE[0] <= facts["leg"] <= LEG_RANGE[1]:
        raise FormatError(
            f"{path}: found a leg {facts['leg']:g} long, needed one from {LEG_RANGE[0]:g} to "
            f"{LEG_RANGE[1]:g}")
    if not (arrays["deviation"] > 0).all():
        raise FormatError(f"{path}: found a deviation that is not above 0, needed positive ones")
    params = {name: arrays[name] for name in ("W0", "b0", "V0", "c0") if name in arrays}
    _check_filters(path, params, "W0", "b0", params["b0"].size, FEATURES)
    if "V0" in params or "c0" in params:
        _check_decoder(path, params)
    for name, known in (("normaliser", FORMS), ("depooling", DEPOOLING)):
        if facts[name] not in known:
            raise FormatError(
                f"{path}: found {name} {facts[name][:40]!r}, needed one of {', '.join(known)}")
    normaliser = Normaliser(arrays["mean"], arrays["deviation"], facts["source"],
                            facts["normaliser"])
    return Manifold(params, normaliser, facts["leg"], arrays["bones"], facts["depooling"])


def _check_decoder(path, params):
    V, c, W = params.get("V0"), params.get("c0"), params["W0"]
    if V is None or c is None or V.shape != W.shape or c.shape != (
            FEATURES,) or V.dtype != W.dtype or c.dtype != W.dtype or not (plausible(V)
                                                                            and plausible(c)):
        raise FormatError(
            f"{path}: found a decoder that does not fit W0 {W.dtype} {W.shape}, needed plausible "
            f"V0 of that kind and c0 ({FEATURES},)")


def _check_filters(path, params, filters, biases, c_out, c_in):
    W, b = params[filters], params[biases]
    if W.ndim != 3 or not W.size or W.shape[:2] != (c_out, c_in) or b.shape != (
            c_out,) or W.dtype != b.dtype or W.dtype not in (np.float32, np.float64):
        raise FormatError(
            f"{path}: found {filters} {W.dtype} {W.shape} and {biases} {b.dtype} {b.shape}, "
            f"needed ({c_out}, {c_in}, width) and ({c_out},) of one floating-point type")
    if not (plausible(W) and plausible(b)):
        raise FormatError(
            f"{path}: found values in {filters} or {biases} that are not finite or beyond 1e9, "
            "needed trained weights")
