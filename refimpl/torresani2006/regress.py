r"""Learning the style of an interpolation (Torresani 2006, section 6): from z = [c_i, c_j, e_i, e_j, alpha] to e = (flow, weight, time).

c are principal components of the joint angles, e styles. Each effort is a regression of its own, with its own hyper-parameters.
Inputs are standardised by the training examples and the mean label is taken out and put back (choices; the paper is silent).
"""

from dataclasses import dataclass, field

import numpy as np

from .align import read_at
from .svr import fit_svr

COMPONENTS, LENGTH = 3, 50
MODELS = ("linear interpolation", "linear ridge", "kernel ridge", "support vector")
FOLDS = 10
WIDTHS = (0.02, 0.06, 0.2, 0.6, 2.0)                         # gamma times the number of inputs
LAMBDAS = tuple(10.0 ** np.arange(-4, 1.5, 0.5))
LINEAR_LAMBDAS = tuple(10.0 ** np.arange(-2, 3.5, 0.5))
BOXES, EPSILONS = (1.0, 5.0, 25.0), (0.05, 0.2)
TUNING_TOLERANCE = 1e-2                                      # of the support vector machines that only choose hyper-parameters


class RegressError(ValueError):
    """Examples that cannot be learnt from, or a model that is not there."""


@dataclass(frozen=True)
class Projection:
    """Principal components.   mean : (length D,);  basis : (components, length D), orthonormal rows;  length : frames stretched to."""

    mean: np.ndarray = field(repr=False)
    basis: np.ndarray = field(repr=False)
    length: int = LENGTH


def stretched(angles, length=LENGTH):
    """Joint angles at a set number of frames, first on first and last on last.   (T, D)  ->  (length, D)"""
    return read_at(angles, np.linspace(0, len(angles) - 1, length))


def fit_pca(sequences, components=COMPONENTS, length=LENGTH):
    r"""The directions of largest variance of the stretched sequences: the first right singular vectors of X - mean.

    sequences : list of (T_i, D)   ->  Projection; each direction's largest element is positive.   Raises RegressError for too few of them.
    """
    X = np.stack([stretched(angles, length).ravel() for angles in sequences])
    if not 1 <= components <= min(X.shape):
        raise RegressError(f"components: found {components}, needed 1 to {min(X.shape)} for {len(X)} fragments")
    mean = X.mean(axis=0)
    basis = np.linalg.svd(X - mean, full_matrices=False)[2][:components]
    largest = np.take_along_axis(basis, np.abs(basis).argmax(axis=1)[:, None], axis=1)
    return Projection(mean, basis * np.where(largest < 0, -1.0, 1.0), length)


def project(projection, angles):
    """c = basis (x - mean).   (T, D)  ->  (components,)"""
    return projection.basis @ (stretched(angles, projection.length).ravel() - projection.mean)


def inputs(c_i, c_j, e_i, e_j, alpha):
    """z of equation 1, one row an example.   c : (M, components), e : (M, 3), alpha : (M,)  ->  (M, 2 components + 7)"""
    return np.concatenate([c_i, c_j, e_i, e_j, np.asarray(alpha)[:, None]], axis=1)


def linear_interpolation(Z):
    """The baseline that needs no training:   (1 - alpha) e_i + alpha e_j.   Z : (M, 2 components + 7)  ->  (M, 3)"""
    e_i, e_j, alpha = Z[:, -7:-4], Z[:, -4:-1], Z[:, -1:]
    return (1 - alpha) * e_i + alpha * e_j


def linear_ridge(Z, Y, ridge):
    r"""Equations 6 and 7 with a squared loss:   theta = (Z^T Z + lambda I)^-1 Z^T Y.   Z : (N, d), Y : (N, ...)  ->  theta (d, ...)"""
    return np.linalg.solve(Z.T @ Z + ridge * np.eye(Z.shape[1]), Z.T @ Y)


def kernel_ridge(K, Y, ridge):
    r"""The same in the space of the kernel:   a = (K + lambda I)^-1 Y,   f(z) = sum_n a_n k(z_n, z).   K : (N, N), Y : (N, ...)  ->  a"""
    return np.linalg.solve(K + ridge * np.eye(len(K)), Y)


def gaussian_kernel(A, B, gamma):
    r"""k(a, b) = exp( -gamma || a - b ||^2 ).   A : (M, d), B : (N, d)  ->  (M, N)"""
    return np.exp(-gamma * squared_distances(A, B))


def squared_distances(A, B):
    """|| a - b ||^2 of every row with every row, never below 0.   (M, d), (N, d)  ->  (M, N)"""
    return np.maximum(np.sum(A * A, axis=1)[:, None] + np.sum(B * B, axis=1) - 2 * A @ B.T, 0.0)


def make_folds(N, rng, folds=FOLDS):
    """Examples dealt into folds at random, sizes differing by one at most.   ->  (N,) fold numbers"""
    return rng.permutation(np.arange(N) % min(folds, N))


def ridge_errors(K, Y, ridges, folds):
    r"""Mean squared error on the held-out examples, for many lambdas at once, without solving anew for each fold.

    With A = (K + lambda I)^-1 of all examples, the errors on a fold F of the model trained without it are   (A_FF)^-1 (A Y)_F.

    K : (N, N), Y : (N, E), ridges : (L,), folds : (N,)  ->  (L, E)
    """
    values, vectors = np.linalg.eigh(K)
    inverse = 1.0 / (np.maximum(values, 0.0) + np.asarray(ridges)[:, None])                 # (L, N)
    A = (vectors * inverse[:, None, :]) @ vectors.T                                          # (L, N, N)
    AY = A @ Y
    errors = np.zeros((len(ridges), Y.shape[1]))
    for fold in range(folds.max() + 1):
        F = np.flatnonzero(folds == fold)
        errors += (np.linalg.solve(A[:, F[:, None], F], AY[:, F]) ** 2).sum(axis=1)
    return errors / len(Y)


def svr_errors(Ks, Y, boxes, epsilons, folds, tolerance=TUNING_TOLERANCE):
    r"""Mean squared error on the held-out examples for every kernel, C and epsilon; all machines are trained side by side.

    Ks : (G, N, N), Y : (N, E), boxes : (C,), epsilons : (P,), folds : (N,)  ->  (G, C, P, E)
    """
    F, (N, E) = folds.max() + 1, Y.shape
    grid = np.stack(np.meshgrid(np.arange(len(Ks)), np.arange(len(boxes)), np.arange(len(epsilons)), np.arange(E), np.arange(F),
                                indexing="ij"), axis=-1).reshape(-1, 5)
    g, c, p, e, f = grid.T
    box = np.asarray(boxes)[c][:, None] * (folds != f[:, None])
    beta, b = fit_svr(Ks, Y.T[e], box, np.asarray(epsilons)[p], kernel=g, tolerance=tolerance)
    predicted = np.empty_like(beta)
    for k, K in enumerate(Ks):
        predicted[g == k] = beta[g == k] @ K
    squares = (predicted + b[:, None] - Y.T[e]) ** 2 * (folds == f[:, None])
    return squares.sum(axis=1).reshape(len(Ks), len(boxes), len(epsilons), E, F).sum(axis=-1) / N


@dataclass(frozen=True)
class StyleModel:
    """f of equation 1, trained.

    kind : one of MODELS;  Z : (N, d) standardised examples, shift and scale : (d,) how;  weights : (N, 3), or (d, 3) of a linear model;
    offset : (3,);  gamma : (3,) of the kernels;  chosen : hyper-parameters by effort.
    """

    kind: str
    Z: np.ndarray = field(repr=False)
    shift: np.ndarray = field(repr=False)
    scale: np.ndarray = field(repr=False)
    weights: np.ndarray = field(repr=False)
    offset: np.ndarray = field(repr=False)
    gamma: np.ndarray = field(repr=False)
    chosen: tuple


def fit_model(kind, Z, Y, rng):
    """Train one of the four models, hyper-parameters by ten-fold cross-validation on the examples.

    Z : (N, d) of `inputs`, Y : (N, 3) styles, rng : deals the folds   ->  StyleModel.   Raises RegressError.
    """
    if kind not in MODELS:
        raise RegressError(f"kind: found {kind!r}, needed one of {', '.join(MODELS)}")
    if len(Z) != len(Y) or len(Z) < 4 or not (np.isfinite(Z).all() and np.isfinite(Y).all()):
        raise RegressError(f"Z, Y: found {len(Z)} and {len(Y)} examples, needed as many, at least 4, all finite")
    E = Y.shape[1]
    shift, scale = Z.mean(axis=0), Z.std(axis=0)
    scale = np.where(scale > 1e-12, scale, 1.0)
    X, none = (Z - shift) / scale, np.zeros(E)
    offset, folds = Y.mean(axis=0), make_folds(len(Z), rng)
    if kind == "linear interpolation":
        return StyleModel(kind, X, shift, scale, np.zeros((0, E)), none, none, ())
    if kind == "linear ridge":
        best = ridge_errors(X @ X.T, Y - offset, LINEAR_LAMBDAS, folds).argmin(axis=0)
        weights = np.stack([linear_ridge(X, Y[:, n] - offset[n], LINEAR_LAMBDAS[best[n]]) for n in range(E)], axis=1)
        return StyleModel(kind, X, shift, scale, weights, offset, none, tuple({"lambda": float(LINEAR_LAMBDAS[k])} for k in best))
    gammas = np.array(WIDTHS) / X.shape[1]
    Ks = np.exp(-gammas[:, None, None] * squared_distances(X, X))
    weights, chosen = np.empty((len(X), E)), []
    if kind == "kernel ridge":
        errors = np.stack([ridge_errors(K, Y - offset, LAMBDAS, folds) for K in Ks])
        for n in range(E):
            g, k = np.unravel_index(errors[..., n].argmin(), errors.shape[:2])
            weights[:, n] = kernel_ridge(Ks[g], Y[:, n] - offset[n], LAMBDAS[k])
            chosen.append({"gamma": float(gammas[g]), "lambda": float(LAMBDAS[k])})
    else:
        errors, offset = svr_errors(Ks, Y, BOXES, EPSILONS, folds), offset.copy()
        for n in range(E):
            g, c, p = np.unravel_index(errors[..., n].argmin(), errors.shape[:3])
            beta, b = fit_svr(Ks[g:g + 1], Y[None, :, n], BOXES[c], EPSILONS[p], tolerance=1e-4)
            weights[:, n], offset[n] = beta[0], b[0]
            chosen.append({"gamma": float(gammas[g]), "C": BOXES[c], "epsilon": EPSILONS[p]})
    return StyleModel(kind, X, shift, scale, weights, offset, np.array([c["gamma"] for c in chosen]), tuple(chosen))


def predict(model, Z):
    """f(z) for many z.   Z : (M, d)  ->  (M, 3) flow, weight, time"""
    if model.kind == "linear interpolation":
        return linear_interpolation(Z)
    X = (Z - model.shift) / model.scale
    if model.kind == "linear ridge":
        return X @ model.weights + model.offset
    square = squared_distances(X, model.Z)
    return np.stack([np.exp(-gamma * square) @ a + b for gamma, a, b in zip(model.gamma, model.weights.T, model.offset)], axis=1)
