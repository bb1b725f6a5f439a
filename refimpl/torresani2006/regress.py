r"""Learning the style of an interpolation (section 6): from z = [c_i, c_j, e_i, e_j, alpha] to
e = (flow, weight, time).

c are principal components of the joint angles in radians, e styles. Each effort is a regression of
its own, with its own hyper-parameters. Inputs are standardised by the training examples and the
mean label is taken out and put back, so that no ridge pulls at a constant (choices; the paper is
silent, and its equation 7 has no constant).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from typing import Any

import numpy as np
from scipy.spatial.distance import cdist

from ..nn.arguments import check_positive, check_whole
from .pca import RegressError, standardisation
from .svr import fit_svr

MODELS = ("linear interpolation", "linear ridge", "kernel ridge", "support vector")
FOLDS = 10
WIDTHS = (0.02, 0.06, 0.2, 0.6, 2.0)                         # gamma times the number of inputs
LAMBDAS = tuple(10.0 ** np.arange(-4, 1.5, 0.5))
LINEAR_LAMBDAS = tuple(10.0 ** np.arange(-2, 3.5, 0.5))
BOXES, EPSILONS = (1.0, 5.0, 25.0), (0.05, 0.2)
# Of the support vector machines that choose hyper-parameters, and of the last one.
TUNING_TOLERANCE, FINAL_TOLERANCE = 1e-2, 1e-4
E_I, E_J, ALPHA = slice(-7, -4), slice(-4, -1), slice(-1, None)          # of z, after both c


def inputs(c_i: np.ndarray, c_j: np.ndarray, e_i: np.ndarray, e_j: np.ndarray,
           alpha: np.ndarray) -> np.ndarray:
    """z of section 6, one row an example.
    c : (M, components), e : (M, 3), alpha : (M,)  ->  (M, 2 components + 7)

    >>> inputs(*np.array([[[1, 1, 1]], [[2, 2, 2]], [[3, 3, 3]], [[4, 4, 4]]]), [0.5])
    array([[1. , 1. , 1. , 2. , 2. , 2. , 3. , 3. , 3. , 4. , 4. , 4. , 0.5]])
    """
    return np.concatenate([c_i, c_j, e_i, e_j, np.asarray(alpha)[:, None]], axis=1)


def linear_interpolation(Z: np.ndarray) -> np.ndarray:
    """The baseline that needs no training:   (1 - alpha) e_i + alpha e_j

    Z : (M, 2 components + 7)  ->  (M, 3). Section 8 prints alpha e_i + (1 - alpha) e_j; that
    contradicts section 5, where alpha = 0 gives X_i, and section 5 holds here.

    >>> linear_interpolation(np.array([[0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 0.5]]))
    array([[0.5, 1. , 1.5]])
    """
    alpha = Z[:, ALPHA]
    return (1 - alpha) * Z[:, E_I] + alpha * Z[:, E_J]


def linear_ridge(Z: np.ndarray, Y: np.ndarray, ridge: float) -> np.ndarray:
    r"""The parameters theta = (Z^T Z + lambda I)^-1 Z^T Y that minimise the regression's objective.

    Torresani 2006, Equation 6: E(theta) = U sum_n L(f(z_n, theta) - e_n) + ||theta||^2, here with
    the squared loss L and lambda = 1 / U.
    Torresani 2006, Equation 7: f(z, theta) = z^T theta.

    Computed from [Z; sqrt(lambda) I] = Q R as theta = R^-1 Q^T [Y; 0], the same thing, since
    R^T R = Z^T Z + lambda I; that product itself would lose half the digits of columns that are
    nearly equal.

    Z : (N, d), Y : (N, ...), ridge : lambda above 0   ->  theta (d, ...).
    Raises RegressError for another lambda, shapes that do not fit, or numbers that are not finite.

    >>> linear_ridge(np.array([[1.0], [2.0]]), np.array([1.0, 2.0]), 5.0)
    array([0.5])
    """
    _check_ridge("Z", Z, Y, ridge)
    Q, R = np.linalg.qr(np.concatenate([Z, np.sqrt(ridge) * np.eye(Z.shape[1])]))
    return _solve(R, Q[:len(Z)].T @ Y, ridge, "inputs", Z)


def kernel_ridge(K: np.ndarray, Y: np.ndarray, ridge: float) -> np.ndarray:
    r"""The same in the space of the kernel:   a = (K + lambda I)^-1 Y,   f(z) = sum_n a_n k(z_n, z)

    K : (N, N), Y : (N, ...), ridge : lambda above 0   ->  a (N, ...).
    Raises RegressError for another lambda, shapes that do not fit, numbers that are not finite, or
    a lambda so small beside K that it is lost in rounding and the matrix cannot be solved.

    >>> kernel_ridge(np.eye(2), np.array([1.0, 2.0]), 1.0)
    array([0.5, 1. ])
    """
    _check_ridge("K", K, Y, ridge)
    if K.shape[0] != K.shape[1]:
        raise RegressError(f"K: found shape {K.shape}, needed (examples, examples)")
    return _solve(K + ridge * np.eye(len(K)), Y, ridge, "kernel values", K)


def _solve(A, y, ridge, what, values):
    """A^-1 y, or a RegressError that says beside which values the ridge was lost."""
    try:
        return np.linalg.solve(A, y)
    except np.linalg.LinAlgError:
        raise RegressError(f"ridge: found lambda {ridge:g} beside {what} up to "
                           f"{np.abs(values).max():.3g}, in which it is lost; needed a larger "
                           "one") from None


def _check_ridge(name, A, Y, ridge):
    check_positive("ridge", ridge, RegressError)
    if np.ndim(A) != 2 or np.ndim(Y) < 1 or len(A) != len(Y) or not np.size(A):
        raise RegressError(f"{name}, Y: found shapes {np.shape(A)} and {np.shape(Y)}, needed a row "
                           "of each for every example")
    if not (np.isfinite(A).all() and np.isfinite(Y).all()):
        raise RegressError(f"{name}, Y: found numbers that are not finite, needed finite ones")


def gaussian_kernel(A: np.ndarray, B: np.ndarray, gamma: float) -> np.ndarray:
    r"""k(a, b) = exp( -gamma || a - b ||^2 ).   A : (M, d), B : (N, d), gamma above 0  ->  (M, N)

    >>> gaussian_kernel(np.array([[0.0]]), np.array([[0.0], [1.0]]), 1.0).round(4)
    array([[1.    , 0.3679]])
    """
    check_positive("gamma", gamma, RegressError)
    return np.exp(-gamma * squared_distances(A, B))


def squared_distances(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """|| a - b ||^2 of every row with every row.   (M, d), (N, d)  ->  (M, N)

    The differences come first: |a|^2 + |b|^2 - 2 a.b would lose near points that lie far from 0.

    >>> squared_distances(np.array([[1e8]]), np.array([[1e8 + 1]]))
    array([[1.]])
    """
    return cdist(A, B, "sqeuclidean")


def make_folds(N: int, rng: np.random.Generator, folds: int = FOLDS) -> np.ndarray:
    """Examples dealt into folds at random, whose sizes differ by one at most.   ->  (N,) numbers

    >>> np.bincount(make_folds(7, np.random.default_rng(0), 3))
    array([3, 2, 2])
    """
    check_whole("N", N, 1)
    return rng.permutation(np.arange(N) % min(check_whole("folds", folds, 1), N))


def ridge_errors(K: np.ndarray, Y: np.ndarray, ridges: Sequence[float],
                 folds: np.ndarray) -> np.ndarray:
    r"""Mean squared errors on the held-out examples, for many lambdas at once, without solving anew
    for each fold.

    With A = (K + lambda I)^-1 of all examples, the errors on a fold F of the model trained without
    it are (A_FF)^-1 (A Y)_F. In `fit_model` the mean label and the scale of the inputs come from
    all examples, those of F among them: a small approximation.

    K : (N, N), Y : (N, E), ridges : (L,), folds : (N,)  ->  (L, E)
    """
    values, vectors = np.linalg.eigh(K)
    inverse = 1.0 / (np.maximum(values, 0.0) + np.asarray(ridges)[:, None])          # (L, N)
    AY = (vectors * inverse[:, None, :]) @ (vectors.T @ Y)                            # (L, N, E)
    errors = np.zeros((len(ridges), Y.shape[1]))
    for fold in range(folds.max() + 1):
        F = np.flatnonzero(folds == fold)
        A_FF = (vectors[F] * inverse[:, None, :]) @ vectors[F].T
        errors += (np.linalg.solve(A_FF, AY[:, F]) ** 2).sum(axis=1)
    return errors / len(Y)


def svr_errors(Ks: np.ndarray, Y: np.ndarray, boxes: Sequence[float], epsilons: Sequence[float],
               folds: np.ndarray, tolerance: float = TUNING_TOLERANCE) -> np.ndarray:
    r"""Mean squared errors on the held-out examples for every kernel, C and epsilon; all machines
    are trained side by side.

    Ks : (G, N, N), Y : (N, E), boxes : (C,), epsilons : (P,), folds : (N,)  ->  (G, C, P, E)
    """
    N, E = Y.shape
    grid = (len(Ks), len(boxes), len(epsilons), E, folds.max() + 1)
    g, c, p, e, f = np.indices(grid).reshape(5, -1)
    held_out = folds == f[:, None]
    C = np.asarray(boxes)[c][:, None] * ~held_out
    beta, b = fit_svr(Ks, Y.T[e], C, np.asarray(epsilons)[p], kernel=g, tolerance=tolerance)
    predicted = np.empty_like(beta)
    for k, K in enumerate(Ks):
        predicted[g == k] = beta[g == k] @ K
    squares = (predicted + b[:, None] - Y.T[e]) ** 2 * held_out
    return squares.sum(axis=1).reshape(grid).sum(axis=-1) / N


@dataclass(frozen=True)
class StyleModel:
    """f of equation 1, trained.

    kind : one of MODELS;  Z : (N, d) standardised examples, shift and scale : (d,) how;
    weights : (N, 3), or (d, 3) of a linear model;  offset : (3,);  gamma : (3,) of the kernels;
    chosen : hyper-parameters by effort.
    """

    kind: str
    Z: np.ndarray = field(repr=False)
    shift: np.ndarray = field(repr=False)
    scale: np.ndarray = field(repr=False)
    weights: np.ndarray = field(repr=False)
    offset: np.ndarray = field(repr=False)
    gamma: np.ndarray = field(repr=False)
    chosen: tuple[dict[str, float], ...]


def fit_model(kind: str, Z: np.ndarray, Y: np.ndarray, rng: np.random.Generator) -> StyleModel:
    """Train one of the four models, hyper-parameters by ten-fold cross-validation on the examples.

    Z : (N, d) of `inputs`, Y : (N, 3) styles, rng : deals the folds.   Raises RegressError.

    >>> Z = np.random.default_rng(0).normal(size=(20, 2))
    >>> fit_model("linear ridge", Z, Z[:, :1] + 5, np.random.default_rng(0))
    StyleModel(kind='linear ridge', chosen=({'lambda': 0.01},))
    """
    Z, Y = _check_examples(kind, Z, Y)
    folds = make_folds(len(Z), rng)
    if kind == "linear interpolation":
        return fit_with(kind, Z, Y, [{}] * Y.shape[1])
    shift, scale = standardisation(Z)
    X, centred = (Z - shift) / scale, Y - Y.mean(axis=0)
    gammas = np.array(WIDTHS) / X.shape[1]
    Ks = np.exp(-gammas[:, None, None] * squared_distances(X, X))
    choices: dict[str, Any]                    # an axis of the errors each; the last is of efforts
    if kind == "linear ridge":
        choices = {"lambda": LINEAR_LAMBDAS}
        errors = ridge_errors(X @ X.T, centred, LINEAR_LAMBDAS, folds)
    elif kind == "kernel ridge":
        choices = {"gamma": gammas, "lambda": LAMBDAS}
        errors = np.stack([ridge_errors(K, centred, LAMBDAS, folds) for K in Ks])
    else:
        choices = {"gamma": gammas, "C": BOXES, "epsilon": EPSILONS}
        errors = svr_errors(Ks, Y, BOXES, EPSILONS, folds)
    grid = [dict(zip(choices, map(float, values))) for values in product(*choices.values())]
    return fit_with(kind, Z, Y, [grid[k] for k in errors.reshape(len(grid), -1).argmin(axis=0)])


def fit_with(kind: str, Z: np.ndarray, Y: np.ndarray, chosen: Sequence[dict[str, float]],
             tolerance: float = FINAL_TOLERANCE) -> StyleModel:
    """Train one of the four models with hyper-parameters that are known.

    Z : (N, d), Y : (N, E);  chosen : for each of the E efforts {}, {"lambda"} (linear ridge),
    {"gamma", "lambda"} (kernel ridge) or {"gamma", "C", "epsilon"} (support vector), gamma for
    standardised inputs;  tolerance : of the support vector machine.
    Raises RegressError, SVRError.
    """
    Z, Y = _check_examples(kind, Z, Y)
    shift, scale = standardisation(Z)
    X, offset, none = (Z - shift) / scale, Y.mean(axis=0), np.zeros(Y.shape[1])
    made = partial(StyleModel, kind, X, shift, scale)
    if kind == "linear interpolation":
        return made(np.zeros((0, len(none))), none, none, ())
    columns = [Y[:, n] - offset[n] for n in range(len(none))]
    if kind == "linear ridge":
        weights = [linear_ridge(X, y, c["lambda"]) for y, c in zip(columns, chosen)]
        return made(np.stack(weights, axis=1), offset, none, tuple(chosen))
    gamma = np.array([c["gamma"] for c in chosen])
    Ks = [gaussian_kernel(X, X, g) for g in gamma]
    if kind == "kernel ridge":
        weights = [kernel_ridge(K, y, c["lambda"]) for K, y, c in zip(Ks, columns, chosen)]
    else:
        fits = [fit_svr(K[None], y[None], c["C"], c["epsilon"], tolerance=tolerance)
                for K, y, c in zip(Ks, Y.T, chosen)]
        weights, offset = [beta[0] for beta, _ in fits], np.array([b[0] for _, b in fits])
    return made(np.stack(weights, axis=1), offset, gamma, tuple(chosen))


def _check_examples(kind, Z, Y):
    """Checked.   ->  Z (N, d), Y (N, E) as float64"""
    if kind not in MODELS:
        raise RegressError(f"kind: found {kind!r}, needed one of {', '.join(MODELS)}")
    Z, Y = np.asarray(Z, dtype=float), np.asarray(Y, dtype=float)
    if Z.ndim != 2 or Y.ndim != 2:
        raise RegressError(f"Z, Y: found shapes {Z.shape} and {Y.shape}, needed (examples, inputs) "
                           "and (examples, efforts)")
    if len(Z) != len(Y) or len(Z) < 4 or not (np.isfinite(Z).all() and np.isfinite(Y).all()):
        raise RegressError(f"Z, Y: found {len(Z)} and {len(Y)} examples, needed as many, at least "
                           "4, all finite")
    return Z, Y


def predict(model: StyleModel, Z: np.ndarray) -> np.ndarray:
    """The style of many interpolations.   Z : (M, d)  ->  (M, 3) flow, weight, time.

    Torresani 2006, Equation 1: e = f(X_i, X_j, e_i, e_j, alpha), the fragments X by their c in z.

    Raises RegressError for other inputs than the model learnt from.

    >>> Z = np.arange(12.0).reshape(6, 2)
    >>> predict(fit_with("linear ridge", Z, Z[:, :1], [{"lambda": 1e-9}]), Z[:2]).round(6)
    array([[0.],
           [2.]])
    """
    Z = np.asarray(Z, dtype=float)
    if Z.ndim != 2 or Z.shape[1] != len(model.shift):
        raise RegressError(f"Z: found shape {Z.shape}, needed (M, {len(model.shift)}), inputs as "
                           "the model learnt from")
    if model.kind == "linear interpolation":
        return linear_interpolation(Z)
    X = (Z - model.shift) / model.scale
    if model.kind == "linear ridge":
        return X @ model.weights + model.offset
    square = squared_distances(X, model.Z)
    return np.stack([np.exp(-gamma * square) @ a + b for gamma, a, b in
                     zip(model.gamma, model.weights.T, model.offset)], axis=1)
