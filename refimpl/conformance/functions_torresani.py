"""The reference for the system of 2006 as functions of arrays alone: what a backend offers under
these names.

Sequences of different length come end to end in one array, with their lengths. Everything is
float64.
"""

import numpy as np

from ..torresani2006 import align, pca, poses, regress, segment, svr, synthesise
from . import definitions_torresani as plain


def dtw_cost(X, Y):
    """SSD of equations 3 to 5 by dynamic programming, steps (1,0), (1,1), (0,1), each at the cost
    of the cell it enters.

    X : (P, D), Y : (Q, D), radians  ->  scalar, radians squared
    """
    return np.asarray(align.dtw(X, Y)[0])


def dtw_path(X, Y):
    """The best path from (0, 0) to (P-1, Q-1); of equal ways back the diagonal, then (p-1, q), then
    (p, q-1).

    X : (P, D), Y : (Q, D), radians  ->  (L, 2) of whole numbers
    """
    return align.dtw(X, Y)[1]


def content_clusters(ssd, *, threshold):
    """Fragments linked by chains of SSD below the threshold.

    ssd : (N, N), threshold : radians squared  ->  (N,) numbers from 0 in the order of their first
    fragments
    """
    return align.clusters(ssd, threshold)


def space_time_interpolation(X, Y, root_X, root_Y, path, *, alpha, smooth=6.0, up="y"):
    """Section 5: the blend of two sequences along a path, alpha = 0 the first, 1 the second.

    X : (P, D), Y : (Q, D), radians;  root_X : (P, 4), root_Y : (Q, 4): x, y, z (length) and heading
    (radians);  path : (L, 2);
    alpha : -0.25 to 1.25;  smooth : frames of the Gaussian over the path's steps, 0 for none;
    up : "y" or "z"
    ->  angles (T, D), root (T, 4)
    """
    a, b = (poses.Fragment(name, None, None, angles, root, 30.0)
            for name, angles, root in (("X", X, root_X), ("Y", Y, root_Y)))
    made = align.interpolate(a, b, alpha, path, up, smooth)
    return made.angles, made.root


def one_stage_segmentation(Y, frames, *, lengths):
    """Equations 8 to 11: Y as the cheapest sequence of fragments.

    Y : (P, D), frames : (sum of lengths, D), the fragments end to end, lengths : frames of each
    ->  total cost, fragment of each piece, its end (frame after its last) in Y, its cost
    """
    total, pieces = segment.segment(Y, plain.sequences(frames, lengths))
    return np.asarray(total), np.array([p.fragment for p in pieces
                                        ]), np.array([p.end for p in pieces
                                                      ]), np.array([p.cost for p in pieces])


def principal_components(frames, *, lengths, components, length):
    """The directions of largest variance of sequences stretched to one length (frames linearly
    interpolated).

    frames : (sum of lengths, D), the sequences end to end, lengths : frames of each;
    components : how many;  length : frames stretched to
    ->  mean (length D,), basis (components, length D), coefficients (sequences, components). The
    largest element of each direction is positive, of those equal up to 1e-9 the first.
    """
    sequences = plain.sequences(frames, lengths)
    fitted = pca.fit_pca(sequences, components, length)
    return fitted.mean, fitted.basis, np.array([pca.pca_scores(fitted, x) for x in sequences])


def gaussian_kernel(A, B, *, gamma):
    """k(a, b) = exp( -gamma || a - b ||^2 ).   A : (M, d), B : (N, d), gamma above 0  ->  (M, N)"""
    return regress.gaussian_kernel(A, B, gamma)


def linear_ridge(Z, Y, *, ridge):
    """theta = (Z^T Z + ridge I)^-1 Z^T Y.   Z : (N, d), Y : (N, E), ridge above 0  ->  (d, E)"""
    return regress.linear_ridge(Z, Y, ridge)


def kernel_ridge(K, Y, *, ridge):
    """a = (K + ridge I)^-1 Y.   K : (N, N), Y : (N, E), ridge above 0  ->  (N, E)"""
    return regress.kernel_ridge(K, Y, ridge)


def support_vector_regression(K, y, K_new, *, C, epsilon):
    """Epsilon-insensitive support vector regression with offset, solved to the end.

    K : (N, N) kernel of the examples, y : (N,), K_new : (M, N);  C : box, epsilon : half width of
    the tube
    ->  the dual objective 1/2 b^T K b - y^T b + epsilon |b|, predictions (M,)
    """
    beta, b = svr.fit_svr(K[None], y[None], C, epsilon, tolerance=1e-12)
    return np.asarray(svr.dual_objective(K, y, beta[0],
                                         epsilon)), svr.predict_svr(K_new, beta[0], b[0])


def predicted_style(Z, Y, new, *, kind, ridge=None, gamma=None, C=None, epsilon=None):
    """f of equation 1, fitted with known hyper-parameters: inputs standardised, the mean label
    taken out and put back.

    Z : (N, d), d = 2 components + 7, its last columns e_i (3), e_j (3), alpha;  Y : (N, E) styles;
    new : (M, d)
    kind : "linear interpolation", "linear ridge", "kernel ridge" or "support vector"   ->  (M, E)
    """
    chosen = {
        "linear interpolation": {}, "linear ridge": {"lambda": ridge},
        "kernel ridge": {"gamma": gamma, "lambda": ridge},
        "support vector": {"gamma": gamma, "C": C, "epsilon": epsilon}}[kind]
    return regress.predict(regress.fit_with(kind, Z, Y, [chosen] * Y.shape[1], tolerance=1e-12),
                           new)


def continuous_exponential_maps(R, reference):
    """Rotation vectors relative to a reference that run on past pi instead of jumping.

    R : (T, J, 3, 3), reference : (J, 3, 3)  ->  (T, J, 3) radians
    """
    return poses.exponential_maps(R, reference)


def _polynomials(coefficients):
    return lambda x: np.array([
        np.polynomial.polynomial.polyval(value, c) for value, c in zip(x, coefficients)])


def golden_section(coefficients, low, high, *, tolerance=1e-6):
    """Where polynomials have their minimum between two ends, by golden-section search.

    coefficients : (N, degree + 1), from the constant on;  low, high : (N,)  ->  (N,)
    """
    return synthesise.golden_section(_polynomials(coefficients), low, high, tolerance)


def best_alpha(coefficients, *, samples=13, tolerance=1e-6):
    """Equation 12's search: the best of `samples` even steps over [-0.25, 1.25], then golden
    section around it.

    coefficients : (N, degree + 1) of polynomials that stand for the distance to the style asked for
    ->  (N,)
    """
    return synthesise.best_alpha(_polynomials(coefficients), len(coefficients), samples, tolerance)
