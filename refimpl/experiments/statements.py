"""What the paper says of its networks in passing, measured on trained ones: a sparse basis instead
of PCA's, half a second, the whole motion at once, an average over all frames.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from .. import nn
from ..fast import networks
from ..holden2017.losses import style_target
from ..holden2017.objective import LEG
from ..holden2017.trained import Manifold, Style
from ..holden2017.transfer import project_features, stylise
from ..motion.features import FEATURES, POSITIONS
from ..motion.joints import JOINTS
from .measures import hidden_units, style_distance
from .problem import Split

AFTER = (0, 6, 12, 24, 36, 48, 60)               # frames known after the one that is looked at
ACTIVE = 0.01                                    # of a unit's root mean square


def sparse_or_not(split: Split, manifold: Manifold, referee: Manifold) -> list[dict[str, Any]]:
    """A loss network and principal components of as many windows as wide: how well each gives a
    motion back, how many units it takes at a time, and what is left of the style: the distance of
    what comes back to what went in, that of a content in no style being 1.
    """
    width, count = manifold.params["W0"].shape[2], len(manifold.params["W0"])
    seen = {c.name: c.features for c in split.dataset.clips}
    inputs = [manifold.network_input(seen[name])[0].T for name in split.parts["loss"]]
    patches = np.concatenate([_patches(x, width)[::4] for x in inputs if len(x) >= width])
    mean = patches.mean(axis=0)
    values, axes = np.linalg.eigh(np.cov((patches - mean).T))
    basis = axes[:, np.argsort(values)[::-1][:count]]            # (width 66, count)
    own = [seen[name] for part in ("contents", "real") for name in split.parts[part]]
    rows = []
    for what in ("loss network", "principal components"):
        off, active, share, lost = [], [], [], []
        for features in own:
            if what == "loss network":
                H = hidden_units(features, manifold).T
                back = project_features(features, manifold, networks=networks)
            else:
                x = manifold.network_input(features)[0].T
                edge = np.pad(x, ((width // 2, width // 2), (0, 0)), mode="edge")
                H = (_patches(edge, width) - mean) @ basis
                middle = slice(width // 2 * FEATURES, (width // 2 + 1) * FEATURES)
                back = manifold.normaliser.undo((H @ basis.T + mean)[:, middle])
            apart = (back - features)[:, POSITIONS].reshape(len(features), JOINTS, 3)
            off.append(LEG / manifold.leg * np.linalg.norm(apart, axis=-1).mean())
            size = np.sqrt(np.mean(H ** 2))
            active.append(np.mean(np.abs(H) > ACTIVE * size))
            share.append(np.mean(np.abs(H) > size))
            nothing = seen[next(iter(split.parts["contents"]))]
            lost.append(style_distance(back, [features], referee) / len(back)
                        / (style_distance(nothing, [features], referee) / len(nothing))
                        if features is not nothing else np.nan)
        rows.append({"what": f"{what}, {count} of width {width}", "error (cm)": np.mean(off),
                     "units active (share)": np.mean(active),
                     "units above their usual size (share)": np.mean(share),
                     "style distance put in (content = 1)": np.nanmedian(lost)})
    return rows


def _patches(x, width):
    """(T, 66)  ->  (T - width + 1, width 66)"""
    found = sliding_window_view(x, width, axis=0).swapaxes(1, 2)
    return found.reshape(len(found), -1)


def reach(style: Style) -> list[dict[str, Any]]:
    """Which frames of the input move a frame of the output, by trying: of a hidden unit of L, of T,
    and of P(T(I))."""
    manifold, middle, T = style.manifold, 120, 240
    X = np.random.default_rng(0).normal(size=(1, FEATURES, T)).astype(
        manifold.params["W0"].dtype)
    ways = {"a hidden unit of L": lambda x: networks.encode(x, manifold.params)[..., middle // 2],
            "T(I)": lambda x: networks.transformation(x, style.params)[..., middle],
            "P(T(I))": lambda x: networks.project(networks.transformation(x, style.params),
                                                  manifold.params)[..., middle]}
    rows = []
    for what, way in ways.items():
        usual, moved = way(X), []
        for t in range(T):
            other = X.copy()
            other[..., t] += 3.0
            moved.append(np.abs(way(other) - usual).max() > 1e-4 * np.abs(usual).max())
        frames = np.flatnonzero(moved)
        rows.append({"what": what, "frames before": int(middle - frames[0]),
                     "frames after": int(frames[-1] - middle), "frames": len(frames),
                     "seconds": len(frames) / 60})
    return rows


def known_later(styles: Sequence[Style], contents: Sequence[np.ndarray]) -> list[dict[str, Any]]:
    """How far the joints of a result's frame lie from where they come to lie, when so many frames
    after it are known and the last is repeated for the rest.   contents : features (T, 66)
    """
    rows = []
    for after in AFTER:
        off = []
        for style in styles:
            for X in contents:
                whole = stylise(X, style, networks=networks)
                for t in range(60, len(X) - 72, 20):
                    cut = np.concatenate([X[:t + after + 1], np.repeat(X[t + after][None], 72,
                                                                       axis=0)])
                    apart = (stylise(cut, style, networks=networks)[t] - whole[t])[POSITIONS]
                    off.append(np.linalg.norm(apart.reshape(JOINTS, 3), axis=1).mean())
        rows.append({"what": "frames known after", "frames": after, "seconds": after / 60,
                     "error (cm)": LEG / styles[0].manifold.leg * float(np.mean(off))})
    return rows


def sum_or_average(split: Split, manifold: Manifold) -> list[dict[str, Any]]:
    """Gram matrices of the same exemplar once and twice over, as equation 6 sums them, and as an
    average over the frames: distance over size; and how long exemplars are.
    """
    rows, seen = [], {c.name: c.features for c in split.dataset.clips}
    found = []
    for name in split.parts["exemplars"]:
        once = hidden_units(seen[name], manifold)
        twice = hidden_units(np.tile(seen[name], (2, 1)), manifold)
        G, GG = (nn.gram(H[None])[0] for H in (once, twice))
        scaled = style_target([once], twice.shape[1])
        found.append([np.linalg.norm(GG - T) / np.linalg.norm(T) for T in (G, scaled)])
    for what, off in zip(("sum", "average"), np.median(found, axis=0)):
        rows.append({"what": f"an exemplar twice over, {what}", "distance / size": float(off)})
    lengths = [len(seen[name]) / 60 for name in split.parts["exemplars"]]
    rows.append({"what": "exemplars", "shortest (s)": min(lengths), "longest (s)": max(lengths)})
    return rows
