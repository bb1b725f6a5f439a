r"""Classifiers: what style and what content does a motion have? Fitted on real clips that no
transfer used.

A classifier is a linear discriminant: windows of a clip become vectors, standardised and turned to
their first principal components, and every class (a style of a content) is a Gaussian with its own
mean mu_k and the common covariance S of all classes, shrunk towards a sphere:

    score_k(x) = -1/2 (x - mu_k)^T S^-1 (x - mu_k),     S = (1 - r) S_within + r (tr S_within / d) 1

A clip's score is the mean over its windows; its style is that of the best class, its content too.
Two classifiers look at different things: `gram_vectors` at what the loss network sees,
`joint_vectors` at means, standard deviations, speeds and accelerations of the joints, without any
network.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..holden2017.trained import Manifold
from ..motion.features import POSITIONS
from ..nn import gram
from ..torresani2006.pca import principal_axes, standardisation
from .measures import hidden_units

SPAN, SPAN_HOP, DIMENSIONS, SHRINKAGE = 120, 30, 40, 0.2


def sliding_windows(features: np.ndarray, span: int = SPAN,
                    hop: int = SPAN_HOP) -> list[np.ndarray]:
    """Windows of `span` frames every `hop`; the last ends with the clip, a shorter clip is one
    window.   (T, D)  ->  list of (<= span, D)

    >>> [window.tolist() for window in sliding_windows(np.arange(6), span=3, hop=2)]
    [[0, 1, 2], [2, 3, 4], [3, 4, 5]]
    """
    if len(features) <= span:
        return [features]
    starts = list(range(0, len(features) - span, hop)) + [len(features) - span]
    return [features[s:s + span] for s in starts]


def joint_vectors(features: np.ndarray) -> np.ndarray:
    r"""What moves how: for each window the means and standard deviations of the 66 numbers, and the
    logarithms of the mean speed and of the mean acceleration of each joint in the character's
    frame.   (T, 66), T >= 3  ->  (windows, 66 + 66 + 21 + 21)

    >>> joint_vectors(np.zeros((200, 66))).shape
    (4, 174)
    """
    rows = []
    for window in sliding_windows(features):
        joints = window[:, POSITIONS].reshape(len(window), -1, 3)
        changes = [np.linalg.norm(np.diff(joints, n=n, axis=0), axis=-1).mean(axis=0)
                   for n in (1, 2)]
        rows.append(np.concatenate([window.mean(axis=0), window.std(axis=0),
                                    *(np.log(change + 1e-3) for change in changes)]))
    return np.array(rows)


def gram_vectors(features: np.ndarray, manifold: Manifold) -> np.ndarray:
    r"""What the loss network calls style: sqrt of the upper half of Gram(L(X)) / T, for each
    window.   (T, 66)  ->  (windows, m (m + 1) / 2)
    """
    H = hidden_units(features, manifold)                         # (m, T // 2)
    upper = np.triu_indices(len(H))
    rows = [gram(np.ascontiguousarray(window.T)[None])[0][upper] / len(window)
            for window in sliding_windows(H.T, SPAN // 2, SPAN_HOP // 2)]
    return np.sqrt(np.maximum(np.array(rows, dtype=float), 0.0))


@dataclass(frozen=True)
class Classifier:
    """A fitted discriminant.

    vectors : features (T, 66) ->  (windows, D);  labels : classes (style, content);  centre, scale
    (D,), basis (D, d) : standardise and turn;  whiten (d, d) : S^-1/2;  means (classes, d) : the
    mu_k, whitened.
    """

    vectors: Callable[[np.ndarray], np.ndarray]
    labels: tuple[tuple[str, str], ...]
    centre: np.ndarray = field(repr=False)
    scale: np.ndarray = field(repr=False)
    basis: np.ndarray = field(repr=False)
    whiten: np.ndarray = field(repr=False)
    means: np.ndarray = field(repr=False)

    def embed(self, features: np.ndarray) -> np.ndarray:
        """A clip's windows in the space where Euclidean distance is the classifier's.
        (T, 66)  ->  (windows, d)
        """
        return ((self.vectors(features) - self.centre) / self.scale) @ self.basis @ self.whiten

    def scores(self, features: np.ndarray) -> np.ndarray:
        """Mean log-likelihood of each class, up to a constant.   (T, 66)  ->  (classes,)"""
        x = self.embed(features)
        return -0.5 * np.mean(np.sum((x[:, None] - self.means) ** 2, axis=-1), axis=0)

    def classify(self, features: np.ndarray) -> tuple[str, str]:
        """The best class.   (T, 66)  ->  style, content"""
        return self.labels[int(np.argmax(self.scores(features)))]


def fit_classifier(clips: Sequence[tuple[np.ndarray, str, str]],
                   vectors: Callable[[np.ndarray], np.ndarray], *, components: int = DIMENSIONS,
                   shrinkage: float = SHRINKAGE) -> Classifier:
    """Fit the discriminant to labelled clips.

    clips : list of (features (T, 66), style, content), at least two classes;  vectors : of a clip's
    features, such as `joint_vectors`.   Raises ValueError.

    >>> clips = [(np.array([[at], [at + 2.0]]), style, "run") for at, style in ((0, "a"), (9, "b"))]
    >>> fit_classifier(clips, lambda features: features).classify(np.array([[7.0]]))
    ('b', 'run')
    """
    labels = tuple(sorted({(style, content) for _, style, content in clips}))
    if len(labels) < 2:
        raise ValueError(f"clips: found {len(labels)} classes of style and content, needed at "
                         "least two to tell apart")
    rows = [vectors(features) for features, _, _ in clips]
    owner = np.repeat([labels.index((style, content)) for _, style, content in clips],
                      [len(r) for r in rows])
    X = np.concatenate(rows)
    centre, scale = standardisation(X, least=1e-9 * X.std(axis=0).max())
    Z = (X - centre) / scale
    basis = principal_axes(Z, 1e-9)[:components].T
    Z = Z @ basis
    means = np.array([Z[owner == k].mean(axis=0) for k in range(len(labels))])
    within = _shrunk(Z - means[owner], shrinkage)
    if not np.trace(within) > 1e-12 * np.mean(Z ** 2):
        raise ValueError(
            f"clips: found {len(Z)} windows, no class with two that differ, needed more or longer "
            "clips to see how much a class varies")
    values, turned = np.linalg.eigh(within)
    whiten = turned / np.sqrt(np.maximum(values, 1e-12 * values.max()))
    return Classifier(vectors, labels, centre, scale, basis, whiten, means @ whiten)


def frechet_distance(x: np.ndarray, y: np.ndarray, *, shrinkage: float = SHRINKAGE) -> float:
    r"""Between the Gaussians of two clouds of points, covariances shrunk as above:

        || m_x - m_y ||^2 + tr(S_x + S_y - 2 (S_x S_y)^(1/2))

    x : (n, d), y : (m, d)

    >>> x = np.array([[0.0, 1.0], [1.0, 0.0], [2.0, 2.0]])
    >>> round(frechet_distance(x, x + [3.0, 4.0]), 9)
    25.0
    """
    centred = [a - a.mean(axis=0) for a in (x, y)]
    Sx, Sy = (_shrunk(c, shrinkage) for c in centred)
    values, axes = np.linalg.eigh(Sx)
    root = (axes * np.sqrt(np.maximum(values, 0))) @ axes.T
    # The trace of (S_x S_y)^(1/2), by a similar symmetric matrix.
    cross = np.sqrt(np.maximum(np.linalg.eigvalsh(root @ Sy @ root), 0)).sum()
    apart = np.sum((x.mean(axis=0) - y.mean(axis=0)) ** 2)
    return float(apart + np.trace(Sx) + np.trace(Sy) - 2 * cross)


def _shrunk(centred, r):
    """Covariance of centred points (n, d), shrunk.   ->  (d, d)"""
    S = centred.T @ centred / len(centred)
    return (1 - r) * S + r * np.trace(S) / len(S) * np.eye(len(S))
