r"""Judges: what style and what content does a motion have? Fitted on real clips that no transfer
used.

A judge is a linear discriminant: windows of a clip become vectors, standardised and turned to their
first principal components, and every class (a style of a content) is a Gaussian with its own mean
mu_k and the common covariance S of all classes, shrunk towards a sphere:

    score_k(x) = -1/2 (x - mu_k)^T S^-1 (x - mu_k),      S = (1 - r) S_within + r (tr S_within / d) 1

A clip's score is the mean over its windows; its style is that of the best class, its content too.
Two judges look at different things: `gram_vectors` at what the loss network sees, `joint_vectors`
at means, deviations, speeds and accelerations of the joints, without any network.
"""

from dataclasses import dataclass, field

import numpy as np

from ..motion.features import POSITIONS
from ..nn import gram
from .measures import hidden_units

SPAN, HOP, COMPONENTS, SHRINKAGE = 120, 30, 40, 0.2


def pieces(features, span=SPAN, hop=HOP):
    """Windows of `span` frames every `hop`; the last ends with the clip, a shorter clip is one
    window.   (T, D)  ->  list of (<= span, D)
    """
    if len(features) <= span:
        return [features]
    starts = list(range(0, len(features) - span, hop)) + [len(features) - span]
    return [features[s:s + span] for s in starts]


def joint_vectors(features):
    r"""What moves how: for each window the means and deviations of the 66 numbers, and the
    logarithms of the mean speed and of the mean acceleration of each joint in the character's
    frame.   (T, 66), T >= 3  ->  (windows, 66 + 66 + 21 + 21)"""
    rows = []
    for window in pieces(features):
        joints = window[:, POSITIONS].reshape(len(window), -1, 3)
        speed = np.linalg.norm(np.diff(joints, axis=0), axis=-1).mean(axis=0)
        acceleration = np.linalg.norm(np.diff(joints, n=2, axis=0), axis=-1).mean(axis=0)
        rows.append(
            np.concatenate([
                window.mean(axis=0),
                window.std(axis=0),
                np.log(speed + 1e-3),
                np.log(acceleration + 1e-3)]))
    return np.array(rows)


def gram_vectors(features, manifold):
    r"""What the loss network calls style: sqrt of the upper half of Gram(L(X)) / T, for each
    window.   (T, 66)  ->  (windows, m (m + 1) / 2)
    """
    H = hidden_units(features, manifold)                         # (m, T // 2)
    upper = np.triu_indices(len(H))
    rows = [
        gram(np.ascontiguousarray(window.T)[None])[0][upper] / len(window)
        for window in pieces(H.T, SPAN // 2, HOP // 2)]
    return np.sqrt(np.maximum(np.array(rows, dtype=float), 0.0))


@dataclass(frozen=True)
class Judge:
    """A fitted discriminant.

    vectors : features (T, 66) ->  (windows, D);  labels : classes (style, content);  centre, scale
    (D,), basis (D, d) : standardise and turn; whiten (d, d) : S^-1/2;  means (classes, d) : the
    mu_k, whitened.
    """

    vectors: object
    labels: tuple
    centre: np.ndarray = field(repr=False)
    scale: np.ndarray = field(repr=False)
    basis: np.ndarray = field(repr=False)
    whiten: np.ndarray = field(repr=False)
    means: np.ndarray = field(repr=False)

    def embed(self, features):
        """A clip's windows in the space where Euclidean distance is the judge's.
        (T, 66)  ->  (windows, d)
        """
        return ((self.vectors(features) - self.centre) / self.scale) @ self.basis @ self.whiten

    def scores(self, features):
        """Mean log-likelihood of each class, up to a constant.   (T, 66)  ->  (classes,)"""
        x = self.embed(features)
        return -0.5 * np.mean(np.sum((x[:, None] - self.means) ** 2, axis=-1), axis=0)

    def verdict(self, features):
        """The best class.   (T, 66)  ->  style, content"""
        return self.labels[int(np.argmax(self.scores(features)))]


def fit_judge(clips, vectors, *, components=COMPONENTS, shrinkage=SHRINKAGE):
    """clips : list of (features (T, 66), style, content), at least two classes   ->  Judge.
    Raises ValueError.
    """
    labels = tuple(sorted({(style, content) for _, style, content in clips}))
    if len(labels) < 2:
        raise ValueError(
            f"clips: found {len(labels)} classes of style and content, needed at least two to tell "
            "apart")
    rows = [vectors(features) for features, _, _ in clips]
    owner = np.repeat([labels.index((style, content)) for _, style, content in clips],
                      [len(r) for r in rows])
    X = np.concatenate(rows)
    centre, scale = X.mean(axis=0), X.std(axis=0)
    scale = np.where(scale > 1e-9 * scale.max(), scale, 1.0)
    Z = (X - centre) / scale
    _, size, axes = np.linalg.svd(Z, full_matrices=False)
    basis = axes[:min(components, int(np.sum(size > 1e-9 * size[0])))].T
    Z = Z @ basis
    means = np.array([Z[owner == k].mean(axis=0) for k in range(len(labels))])
    within = _shrunk(Z - means[owner], shrinkage)
    if not np.trace(within) > 1e-12 * np.mean(Z ** 2):
        raise ValueError(
            f"clips: found {len(Z)} windows, no class with two that differ, needed more or longer "
            "clips to see how much a class varies")
    values, turned = np.linalg.eigh(within)
    whiten = turned / np.sqrt(np.maximum(values, 1e-12 * values.max()))
    return Judge(vectors, labels, centre, scale, basis, whiten, means @ whiten)


def frechet_distance(x, y, *, shrinkage=SHRINKAGE):
    r"""Between the Gaussians of two clouds of points, covariances shrunk as above:

        || m_x - m_y ||^2 + tr(S_x + S_y - 2 (S_x S_y)^(1/2))

    (n, d), (m, d)  ->  float
    """
    centred = [a - a.mean(axis=0) for a in (x, y)]
    Sx, Sy = (_shrunk(c, shrinkage) for c in centred)
    values, axes = np.linalg.eigh(Sx)
    root = (axes * np.sqrt(np.maximum(values, 0))) @ axes.T
    # tr (S_x S_y)^(1/2), by a similar symmetric matrix
    cross = np.sqrt(np.maximum(np.linalg.eigvalsh(root @ Sy @ root), 0)).sum()
    return float(
        np.sum((x.mean(axis=0) - y.mean(axis=0))**2) + np.trace(Sx) + np.trace(Sy) - 2 * cross)


def _shrunk(centred, r):
    """Covariance of centred points (n, d), shrunk.   ->  (d, d)"""
    S = centred.T @ centred / len(centred)
    return (1 - r) * S + r * np.trace(S) / len(S) * np.eye(len(S))
