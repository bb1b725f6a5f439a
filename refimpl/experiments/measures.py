r"""How near a motion is to a style, to a content and to a path."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .. import nn
from ..motion.body import to_scale
from ..fast import networks
from ..holden2017.losses import style_target
from ..holden2017.trained import Manifold
from ..holden2017.transfer import stylise


def hidden_units(features: np.ndarray, manifold: Manifold) -> np.ndarray:
    """L(X) of one clip on the model's scale.   (T, 66)  ->  (m, T // 2)"""
    return networks.encode(manifold.network_input(features), manifold.params)[0]


def style_distance(features: np.ndarray, exemplars: Sequence[np.ndarray],
                   manifold: Manifold) -> float:
    r"""|| Gram(L(S)) - Gram(L(X)) ||, the style target scaled to the clip's frames.

    features : (T, 66);  exemplars : list of features (T_e, 66)  ->  float
    """
    H = hidden_units(features, manifold)
    G = style_target([hidden_units(e, manifold) for e in exemplars], H.shape[1])
    return float(np.linalg.norm(G - nn.gram(H[None])[0]))


def content_distance(features: np.ndarray, content: np.ndarray, manifold: Manifold) -> float:
    """|| L(I) - L(X) || of two clips of the same length.   (T, 66), (T, 66)  ->  float"""
    return float(np.linalg.norm(hidden_units(features, manifold) - hidden_units(content, manifold)))


def held_out_distances(clips: Sequence[Any], exemplars: Mapping[str, Sequence[np.ndarray]],
                       style: Any, leg: float) -> list[dict[str, Any]]:
    """Style distances of clips that training never saw: of the content itself, of T(I) and of
    P(T(I)).

    clips : of Labelled;  exemplars : {content: list of features};  style : StyleNetwork;
    leg : of the clips' dataset
    ->  list of {"clip", "content", "transformed", "projected"}
    """
    measured = []
    for clip in clips:
        content = to_scale(clip.features, leg, style.manifold.leg)
        versions = {"content": content,
                    "transformed": stylise(content, style, projected=False, networks=networks),
                    "projected": stylise(content, style, networks=networks)}
        distance = {name: style_distance(features, exemplars[clip.content], style.manifold)
                    for name, features in versions.items()}
        measured.append({"clip": clip.name, **distance})
    return measured
