"""The two kinds of model file: a manifold (the loss network) and a style (a transformation network
with its manifold)."""

from pathlib import Path
from typing import Any

import numpy as np

from ..holden2017.losses import READINGS
from ..holden2017.networks import DEPOOLING, T_NAMES
from ..holden2017.objective import WEIGHED, Weights
from ..holden2017.trained import Manifold, Style
from ..motion.features import FEATURES, LEG_RANGE
from ..motion.joints import BONES, JOINTS
from ..motion.known import QUANTITIES, Known
from ..motion.windows import FORMS, Normaliser
from ..storage import FormatError, load_npz, plausible, save_npz

# since these the root's velocity is that to the next frame
MANIFOLD_VERSION, STYLE_VERSION = 2, 4
_BODY = {"mean": (FEATURES,), "deviation": (FEATURES,), "bones": (len(BONES),)}
_FACTS = {"leg": float, "source": str, "normaliser": str, "depooling": str}
_STYLE_LISTS = ("contents", "exemplar_contents", "learned", "exemplars")
_STYLE_FACTS = {**_FACTS, "name": str, **dict.fromkeys(_STYLE_LISTS, list), "reading": str}


def save_manifold(path: str | Path, manifold: Manifold, *, half: bool = False) -> None:
    """Write a Manifold, whole or not at all.   half : its filters in half precision"""
    arrays, facts = _parts(manifold)
    arrays |= _halved(manifold.params) if half else {}
    save_npz(path, "manifold", MANIFOLD_VERSION, arrays, facts)


def load_manifold(path: str | Path) -> Manifold:
    """Read a Manifold.   Raises FormatError when its parts do not fit each other."""
    arrays, facts = load_npz(path, "manifold", MANIFOLD_VERSION, ("W0", "b0", *_BODY), _FACTS)
    return _manifold(path, _widened(arrays), facts)


def save_style(path: str | Path, style: Style, *, boxed: bool = False) -> None:
    """Write a Style together with its Manifold, so that one file is enough to stylise a clip.

    boxed : without it, and in half precision
    """
    arrays, facts = ({}, {}) if boxed else _parts(style.manifold)
    ends = style.known and [style.known.low, style.known.high]
    arrays |= {**(_halved(style.params) if boxed else style.params),
               "range": np.reshape(ends or [], (-1, len(QUANTITIES))), "weights": np.array(
                   [getattr(style.weights, name) for name in WEIGHED], dtype=float)}
    facts |= {"name": style.name, "contents": list(style.pairs), "exemplar_contents":
              list(style.pairs.values()), "learned": list(style.learned), "exemplars":
              list(style.exemplars), "reading": style.weights.reading}
    save_npz(path, "style", STYLE_VERSION, arrays, facts)


def load_style(path: str | Path, boxed_with: Manifold | None = None) -> Style:
    """Read a Style.   Raises FormatError when its parts do not fit each other.

    boxed_with : the Manifold of a file that was written without one
    """
    whole = ("W0", "b0", *_BODY) if boxed_with is None else ()
    arrays, facts = load_npz(path, "style", STYLE_VERSION, (
        *whole, *T_NAMES, "weights", "range"), {
            name: kind for name, kind in _STYLE_FACTS.items() if whole or name not in _FACTS})
    arrays = _widened(arrays)
    manifold = boxed_with or _manifold(path, arrays, facts)
    params = {name: arrays[name] for name in T_NAMES}
    sizes = [FEATURES, params["b1"].size, params["b2"].size, FEATURES]
    for layer in (1, 2, 3):
        _check_filters(path, params, f"W{layer}", f"b{layer}", sizes[layer], sizes[layer - 1])
    dtypes = params["W1"].dtype, manifold.params["W0"].dtype
    _need(path, dtypes[0] == dtypes[1], f"W1 of {dtypes[0]} beside W0 of {dtypes[1]}",
          "one precision")
    contents, shown = facts["contents"], facts["exemplar_contents"]
    _need(path, len(contents) == len(shown),
          f"{len(contents)} contents and {len(shown)} of exemplars", "pairs")
    values, reading = arrays["weights"], facts["reading"]
    _need(path, reading in READINGS and values.shape == (len(WEIGHED),) and values.dtype == float
          and bool((np.isfinite(values) & (values >= 0)).all()),
          f"weights {values.dtype} {values.shape} and reading {reading[:40]!r}",
          f"{len(WEIGHED)} numbers from 0 on and one of {', '.join(READINGS)}")
    return Style(params, manifold, facts["name"], dict(zip(contents, shown)),
                 tuple(facts["learned"]), tuple(facts["exemplars"]),
                 Weights(**dict(zip(WEIGHED, values.tolist())), reading=reading),
                 _known(path, arrays["range"]))


def _halved(params):
    return {name: p.astype(np.float16) for name, p in params.items()}


def _widened(arrays):
    return {name: a.astype(np.float32) if a.dtype == np.float16 else a
            for name, a in arrays.items()}


def _known(path, ends):
    _need(path, ends.ndim == 2 and ends.shape[1] == len(QUANTITIES) and len(ends) in (0, 2)
          and ends.dtype == float and plausible(ends) and (np.diff(ends, axis=0) >= 0).all(),
          f"a range of shape {ends.shape}", f"(2, {len(QUANTITIES)}) of plausible numbers, from "
          "the least to the largest that the style learnt on")
    return Known(*ends) if len(ends) else None


def _parts(manifold: Manifold) -> tuple[dict[str, Any], dict[str, Any]]:
    """->  arrays, facts of a file"""
    normaliser = manifold.normaliser
    rest = {} if manifold.rest is None else {"rest": manifold.rest}
    return ({**manifold.params, **rest, "mean": normaliser.mean, "deviation": normaliser.deviation,
             "bones": manifold.bones},
            {"leg": manifold.leg, "source": normaliser.source, "normaliser": normaliser.form,
             "depooling": manifold.depooling})


def _manifold(path, arrays, facts):
    shapes = {**_BODY, **({"rest": (JOINTS, 3)} if "rest" in arrays else {})}
    for name, shape in shapes.items():
        array = arrays[name]
        _need(path, array.shape == shape and array.dtype == float and plausible(array),
              f"{name} of shape {array.shape}", f"finite numbers of shape {shape}, none beyond 1e9")
    _need(path, LEG_RANGE[0] <= facts["leg"] <= LEG_RANGE[1], f"a leg {facts['leg']:g} long",
          f"one from {LEG_RANGE[0]:g} to {LEG_RANGE[1]:g}")
    _need(path, (arrays["deviation"] > 0).all(), "a deviation that is not above 0",
          "positive ones")
    params = {name: arrays[name] for name in ("W0", "b0", "V0", "c0") if name in arrays}
    _check_filters(path, params, "W0", "b0", params["b0"].size, FEATURES)
    W, V, c = params["W0"], params.get("V0"), params.get("c0")
    if V is not None or c is not None:
        _need(path, V is not None and c is not None and V.shape == W.shape
              and c.shape == (FEATURES,) and V.dtype == c.dtype == W.dtype and plausible(V)
              and plausible(c), f"a decoder that does not fit W0 {W.dtype} {W.shape}",
              f"plausible V0 of that kind and c0 ({FEATURES},)")
    for name, known in (("normaliser", FORMS), ("depooling", DEPOOLING)):
        _need(path, facts[name] in known, f"{name} {facts[name][:40]!r}",
              f"one of {', '.join(known)}")
    normaliser = Normaliser(arrays["mean"], arrays["deviation"], facts["source"],
                            facts["normaliser"])
    return Manifold(params, normaliser, facts["leg"], arrays["bones"], facts["depooling"],
                    arrays.get("rest"))


def _check_filters(path, params, filters, biases, c_out, c_in):
    W, b = params[filters], params[biases]
    _need(path, W.ndim == 3 and W.size > 0 and W.shape[:2] == (c_out, c_in) and b.shape == (c_out,)
          and W.dtype == b.dtype and W.dtype in (np.float32, np.float64),
          f"{filters} {W.dtype} {W.shape} and {biases} {b.dtype} {b.shape}",
          f"({c_out}, {c_in}, width) and ({c_out},) of one floating-point type")
    _need(path, plausible(W) and plausible(b),
          f"values in {filters} or {biases} that are not finite or beyond 1e9", "trained weights")


def _need(path: str | Path, good: bool, found: str, needed: str) -> None:
    if not good:
        raise FormatError(f"{path}: found {found}, needed {needed}")
