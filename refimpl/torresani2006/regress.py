r"""Learning the style of an interpolation (Torresani 2006, section 6): from z = [c_i, c_j, e_i, e_j, alpha] to e = (flow, weight, time).

c are principal components of the joint angles in radians, e styles. Each effort is a regression of its own, with its own hyper-parameters.
Inputs are standardised by the training examples and the mean label is taken out and put back, so that no ridge pulls at a constant (choices;
the paper is silent, and its equation 7 has no constant).
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.distance import cdist

from ..nn.arguments import check_positive, check_whole
from .align import checked, read_at
from .svr import fit_svr

COMPONENTS, LENGTH = 3, 50
MODELS = ("linear interpolation", "linear ridge", "kernel ridge", "support vector")
FOLDS = 10
WIDTHS = (0.02, 0.06, 0.2, 0.6, 2.0)                         # gamma times the number of inputs
LAMBDAS = tuple(10.0 ** np.arange(-4, 1.5, 0.5))
LINEAR_LAMBDAS = tuple(10.0 ** np.arange(-2, 3.5, 0.5))
BOXES, EPSILONS = (1.0, 5.0, 25.0), (0.05, 0.2)
TUNING_TOLERANCE, FINAL_TOLERANCE = 1e-2, 1e-4               # of the support vector machines that choose hyper-parameters, and of the last
E_I, E_J, ALPHA = slice(-7, -4), slice(-4, -1), slice(-1, None)          # where z has the styles and alpha, after both c


class RegressError(ValueError):
    """Examples that cannot be learnt from, or a model that is not there."""


@dataclass(frozen=True)
class Projection:
    """Principal components.   mean : (length D,);  basis : (components, length D), orthonormal rows;  length : frames stretched to."""

    mean: np.ndarray = field(repr=False)
    basis: np.ndarray = field(repr=False)
    length: int = LENGTH


def stretched(angles, length=LENGTH):
    """Joint angles at a set number of frames, linearly, first on first and last on last.   (T, D)  ->  (length, D)"""
    return read_at(angles, np.linspace(0, len(angles) - 1, check_whole("length", length, 1)))


def fit_pca(sequences, components=COMPONENTS, length=LENGTH):
    r"""The directions of largest variance of the stretched sequences: the first right singular vectors of X - mean.

    sequences : list of (T_i, D) in radians   ->  Projection
    Raises RegressError for more components than directions in which the sequences differ (at most one
    less than there are sequences) or angles that differ in number, AlignError for what is no sequence.
    """
    sequences = [checked(f"sequences[{i}]", angles) for i, angles in enumerate(sequences)]
    check_whole("length", length, 1)
    check_whole("components", components, 1)
    if len({angles.shape[1] for angles in sequences}) != 1:
        raise RegressError(f"sequences: found angles a frame {sorted({angles.shape[1] for angles in sequences})}, needed one number for all")
    X = np.stack([stretched(angles, length).ravel() for angles in sequences])
    mean = X.mean(axis=0)
    _, size, basis = np.linalg.svd(X - mean, full_matrices=False)
    noise = size[0] * max(X.shape) * np.finfo(float).eps + np.abs(X).max() * np.finfo(float).eps
    directions = min(len(X) - 1, int(np.sum(size > noise)))
    if not 1 <= components <= directions:
        raise RegressError(f"components: found {components}, needed 1 to {directions}, the directions in "
                           f"which these {len(X)} sequences differ; give more sequences or ask for "
                           "fewer")
    return Projection(mean, signed(basis[:components]), length)


def signed(basis: np.ndarray) -> np.ndarray:
    """Each row with the sign that makes its largest element positive.   (components, D)  ->  the same

    Elements equal to the largest by size up to 1e-9 count as equal; the first of them decides.

    >>> signed(np.array([[-0.6, 0.6 * (1 + 1e-15)], [0.1, -0.9]]))
    array([[ 0.6, -0.6],
           [-0.1,  0.9]])
    """
    size = np.abs(basis)
    first = np.argmax(size >= (1 - 1e-9) * size.max(axis=1, keepdims=True), axis=1)[:, None]
    return basis * np.where(np.take_along_axis(basis, first, axis=1) < 0, -1.0, 1.0)


def project(projection, angles):
    """c = basis (x - mean).   (T, D) radians  ->  (components,)"""
    return projection.basis @ (stretched(angles, projection.length).ravel() - projection.mean)


def inputs(c_i, c_j, e_i, e_j, alpha):
    """z of equation 1, one row an example.   c : (M, components), e : (M, 3), alpha : (M,)  ->  (M, 2 components + 7)"""
    return np.concatenate([c_i, c_j, e_i, e_j, np.asarray(alpha)[:, None]], axis=1)


def linear_interpolation(Z):
    """The baseline that needs no training:   (1 - alpha) e_i + alpha e_j.   Z : (M, 2 components + 7)  ->  (M, 3)

    Section 8 prints alpha e_i + (1 - alpha) e_j; that contradicts section 5, where alpha = 0 gives X_i, and section 5 holds here.
    """
    alpha = Z[:, ALPHA]
    return (1 - alpha) * Z[:, E_I] + alpha * Z[:, E_J]


def linear_ridge(Z, Y, ridge):
    r"""Equations 6 and 7 with a squared loss, lambda for the paper's U:   theta = (Z^T Z + lambda I)^-1 Z^T Y

    computed from [Z; sqrt(lambda) I] = Q R as   theta = R^-1 Q^T [Y; 0],   the same thing, since
    R^T R = Z^T Z + lambda I; that product itself would lose half the digits of nearly equal columns.

    Z : (N, d), Y : (N, ...), ridge : lambda above 0   ->  theta (d, ...)
    Raises RegressError for another lambda, shapes that do not fit, or numbers that are not finite.

    >>> linear_ridge(np.array([[1.0], [2.0]]), np.array([1.0, 2.0]), 5.0)
    array([0.5])
    """
    _check_ridge("Z", Z, Y, ridge)
    Q, R = np.linalg.qr(np.concatenate([Z, np.sqrt(ridge) * np.eye(Z.shape[1])]))
    try:
        return np.linalg.solve(R, Q[:len(Z)].T @ Y)
    except np.linalg.LinAlgError:
        raise RegressError(_lost("inputs", Z, ridge)) from None


def kernel_ridge(K, Y, ridge):
    r"""The same in the space of the kernel:   a = (K + lambda I)^-1 Y,   f(z) = sum_n a_n k(z_n, z)

    K : (N, N), Y : (N, ...), ridge : lambda above 0   ->  a (N, ...)
    Raises RegressError for another lambda, shapes that do not fit, numbers that are not finite, or a
    lambda so small beside K that it is lost in rounding and the matrix cannot be solved.

    >>> kernel_ridge(np.eye(2), np.array([1.0, 2.0]), 1.0)
    array([0.5, 1. ])
    """
    _check_ridge("K", K, Y, ridge)
    if K.shape[0] != K.shape[1]:
        raise RegressError(f"K: found shape {K.shape}, needed (examples, examples)")
    try:
        return np.linalg.solve(K + ridge * np.eye(len(K)), Y)
    except np.linalg.LinAlgError:
        raise RegressError(_lost("kernel values", K, ridge)) from None


def _lost(what, A, ridge):
    return (f"ridge: found lambda {ridge:g} beside {what} up to {np.abs(A).max():.3g}, in which it is "
            "lost; needed a larger one")


def _check_ridge(name, A, Y, ridge):
    check_positive("ridge", ridge, RegressError)
    if np.ndim(A) != 2 or np.ndim(Y) < 1 or len(A) != len(Y) or not np.size(A):
        raise RegressError(f"{name}, Y: found shapes {np.shape(A)} and {np.shape(Y)}, needed a row of "
                           "each for every example")
    if not (np.isfinite(A).all() and np.isfinite(Y).all()):
        raise RegressError(f"{name}, Y: found numbers that are not finite, needed finite ones")


def gaussian_kernel(A, B, gamma):
    r"""k(a, b) = exp( -gamma || a - b ||^2 ).   A : (M, d), B : (N, d), gamma above 0  ->  (M, N)

    >>> gaussian_kernel(np.array([[0.0]]), np.array([[0.0], [1.0]]), 1.0).round(4)
    array([[1.    , 0.3679]])
    """
    check_positive("gamma", gamma, RegressError)
    return np.exp(-gamma * squared_distances(A, B))


def squared_distances(A, B):
    """|| a - b ||^2 of every row with every row.   (M, d), (N, d)  ->  (M, N)

    The differences come first: |a|^2 + |b|^2 - 2 a.b would lose near points that lie far from 0.

    >>> squared_distances(np.array([[1e8]]), np.array([[1e8 + 1]]))
    array([[1.]])
    """
    return cdist(A, B, "sqeuclidean")


def make_folds(N, rng, folds=FOLDS):
    """Examples dealt into folds at random, sizes differing by one at most.   ->  (N,) fold numbers"""
    check_whole("N", N, 1)
    return rng.permutation(np.arange(N) % min(check_whole("folds", folds, 1), N))


def ridge_errors(K, Y, ridges, folds):
    r"""Mean squared error on the held-out examples, for many lambdas at once, without solving anew for each fold.

    With A = (K + lambda I)^-1 of all examples, the errors on a fold F of the model trained without it are   (A_FF)^-1 (A Y)_F.
    In `fit_model` the mean label and the scale of the inputs come from all examples, those of F among them: a small approximation.

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
    Z, Y = _examples(kind, Z, Y)
    folds = make_folds(len(Z), rng)
    if kind == "linear interpolation":
        return fit_with(kind, Z, Y, [{}] * Y.shape[1])
    shift, scale = _standard(Z)
    X, centred = (Z - shift) / scale, Y - Y.mean(axis=0)
    if kind == "linear ridge":
        best = ridge_errors(X @ X.T, centred, LINEAR_LAMBDAS, folds).argmin(axis=0)
        return fit_with(kind, Z, Y, [{"lambda": float(LINEAR_LAMBDAS[k])} for k in best])
    gammas = np.array(WIDTHS) / X.shape[1]
    Ks = np.exp(-gammas[:, None, None] * squared_distances(X, X))
    if kind == "kernel ridge":
        errors = np.stack([ridge_errors(K, centred, LAMBDAS, folds) for K in Ks])                # (widths, lambdas, E)
        grid = [{"gamma": float(gamma), "lambda": float(ridge)} for gamma in gammas for ridge in LAMBDAS]
    else:
        errors = svr_errors(Ks, Y, BOXES, EPSILONS, folds)                                       # (widths, C, epsilon, E)
        grid = [{"gamma": float(gamma), "C": C, "epsilon": epsilon} for gamma in gammas for C in BOXES for epsilon in EPSILONS]
    return fit_with(kind, Z, Y, [grid[k] for k in errors.reshape(len(grid), -1).argmin(axis=0)])


def fit_with(kind, Z, Y, chosen, tolerance=FINAL_TOLERANCE):
    """Train one of the four models with hyper-parameters that are known.

    Z : (N, d), Y : (N, E);  chosen : for each of the E efforts {} or {"lambda"} (linear ridge), {"gamma", "lambda"} (kernel ridge),
    {"gamma", "C", "epsilon"} (support vector), gamma for standardised inputs;  tolerance : of the support vector machine   ->  StyleModel
    Raises RegressError, SVRError.
    """
    Z, Y = _examples(kind, Z, Y)
    shift, scale = _standard(Z)
    X, offset = (Z - shift) / scale, Y.mean(axis=0)
    none = np.zeros(Y.shape[1])
    if kind == "linear interpolation":
        return StyleModel(kind, X, shift, scale, np.zeros((0, len(none))), none, none, ())
    columns = [Y[:, n] - offset[n] for n in range(len(none))]
    if kind == "linear ridge":
        weights = [linear_ridge(X, y, c["lambda"]) for y, c in zip(columns, chosen)]
        return StyleModel(kind, X, shift, scale, np.stack(weights, axis=1), offset, none, tuple(chosen))
    gamma = np.array([c["gamma"] for c in chosen])
    Ks = [gaussian_kernel(X, X, g) for g in gamma]
    if kind == "kernel ridge":
        weights = [kernel_ridge(K, y, c["lambda"]) for K, y, c in zip(Ks, columns, chosen)]
    else:
        fits = [fit_svr(K[None], Y[None, :, n], c["C"], c["epsilon"], tolerance=tolerance) for n, (K, c) in enumerate(zip(Ks, chosen))]
        weights, offset = [beta[0] for beta, _ in fits], np.array([b[0] for _, b in fits])
    return StyleModel(kind, X, shift, scale, np.stack(weights, axis=1), offset, gamma, tuple(chosen))


def _examples(kind, Z, Y):
    """Checked.   ->  Z (N, d), Y (N, E) as float64"""
    if kind not in MODELS:
        raise RegressError(f"kind: found {kind!r}, needed one of {', '.join(MODELS)}")
    Z, Y = np.asarray(Z, dtype=float), np.asarray(Y, dtype=float)
    if Z.ndim != 2 or Y.ndim != 2:
        raise RegressError(f"Z, Y: found shapes {Z.shape} and {Y.shape}, needed (examples, inputs) and (examples, efforts)")
    if len(Z) != len(Y) or len(Z) < 4 or not (np.isfinite(Z).all() and np.isfinite(Y).all()):
        raise RegressError(f"Z, Y: found {len(Z)} and {len(Y)} examples, needed as many, at least 4, all finite")
    return Z, Y


def _standard(Z):
    """Mean and standard deviation of each input; 1 for one that does not vary.   (N, d)  ->  (d,), (d,)"""
    scale = Z.std(axis=0)
    return Z.mean(axis=0), np.where(scale > 1e-12, scale, 1.0)


def predict(model, Z):
    """f(z) for many z.   Z : (M, d)  ->  (M, 3) flow, weight, time.   Raises RegressError for other inputs than the model learnt from."""
    Z = np.asarray(Z, dtype=float)
    if Z.ndim != 2 or Z.shape[1] != len(model.shift):
        raise RegressError(f"Z: found shape {Z.shape}, needed (M, {len(model.shift)}), inputs as the model learnt from")
    if model.kind == "linear interpolation":
        return linear_interpolation(Z)
    X = (Z - model.shift) / model.scale
    if model.kind == "linear ridge":
        return X @ model.weights + model.offset
    square = squared_distances(X, model.Z)
    return np.stack([np.exp(-gamma * square) @ a + b for gamma, a, b in zip(model.gamma, model.weights.T, model.offset)], axis=1)
