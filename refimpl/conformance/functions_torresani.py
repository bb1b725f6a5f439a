"""The reference for the system of 2006 as functions of arrays alone: what a backend offers under
these names.

Sequences of different length come end to end in one array, with their lengths. Everything is
float64.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..torresani2006 import align, pca, poses, regress, segment, svr, synthesise
from . import definitions_torresani as plain
from .specification import Array


def dtw_cost(X: Array, Y: Array) -> Array:
    """SSD of equations 3 to 5 by dynamic programming, steps (1,0), (1,1), (0,1), each at the cost
    of the cell it enters.

    X : (P, D), Y : (Q, D), radians  ->  scalar, radians squared
    """
    return np.asarray(align.dtw(X, Y)[0])


def dtw_path(X: Array, Y: Array) -> Array:
    """The best path from (0, 0) to (P-1, Q-1); of equal ways back the diagonal, then (p-1, q), then
    (p, q-1).

    X : (P, D), Y : (Q, D), radians  ->  (L, 2) of whole numbers
    """
    return align.dtw(X, Y)[1]


def content_clusters(ssd: Array, *, threshold: float) -> Array:
    """Fragments linked by chains of SSD below the threshold.

    ssd : (N, N), threshold : radians squared  ->  (N,) numbers from 0 in the order of their first
    fragments
    """
    return align.clusters(ssd, threshold)


def space_time_interpolation(X: Array, Y: Array, root_X: Array, root_Y: Array,
                             path: Array, *, alpha: float, smooth: float = align.SMOOTH,
                             up: str = "y") -> tuple[Array, Array]:
    """Section 5: the blend of two sequences along a path, alpha = 0 the first, 1 the second.

    1. The path's steps in p, and in q, are smoothed by scipy.ndimage.gaussian_filter1d(steps,
       smooth), scaled to sum to P - 1 and Q - 1, and summed up again.
    2. T = round((1 - alpha) P + alpha Q), half to even, and no fewer than half of the shorter
       sequence, rounded up, and 2. Frame t asks each sequence for its place on the path where its
       own frame is t (P - 1) / (T - 1), of a stretch that waits the middle, and the two places are
       blended by alpha, held within the path and never running backwards; the first and the last
       frame lie at its ends.
    3. At that place p and q are read off the path and both sequences between frames, linearly;
       angles, heights and headings are blended by alpha, the headings of Y moved before by whole
       turns so that its first is the nearest to the first of X.
    4. Steps over the ground are turned out of their own heading where they begin, blended, and
       turned into the blended heading; the first place is the blend of both first places. A turn
       by h takes (x, z) to (x cos h + z sin h, z cos h - x sin h) where y is up, and (x, y) to
       (x cos h - y sin h, x sin h + y cos h) where z is.

    X : (P, D), Y : (Q, D), radians;  root_X : (P, 4), root_Y : (Q, 4): x, y, z (length) and heading
    (radians);  path : (L, 2);
    alpha : -0.25 to 1.25;  smooth : frames of the Gaussian over the path's steps, 0 for none;
    up : "y" or "z"
    ->  angles (T, D), root (T, 4)
    """
    a, b = (poses.Fragment(name, "", np.zeros(3), angles, root, 30.0)
            for name, angles, root in (("X", X, root_X), ("Y", Y, root_Y)))
    made = align.interpolate(a, b, alpha, path, up, smooth)
    return made.angles, made.root


def one_stage_segmentation(Y: Array, frames: Array, *, lengths: Sequence[int]) -> tuple[Array, ...]:
    """Equations 8 to 11: Y as the cheapest sequence of fragments, by dynamic programming:

        C(p, q, i) = d(p, q, i) + min( C(p-1, q, i), C(p-1, q-1, i), C(p, q-1, i) )     where q > 0
        C(p, 0, i) = d(p, 0, i) + min( C(p-1, 0, i), min over j of C(p-1, T_j - 1, j) )
        C(0, 0, i) = d(0, 0, i)

    d : squared distance of frame p of Y and frame q of fragment i. Of equal costs: the diagonal,
    then p-1, then q-1; staying in a fragment before entering one; the first fragment.

    Y : (P, D), frames : (sum of lengths, D), the fragments end to end, lengths : frames of each
    ->  total cost, fragment of each piece, its end (frame after its last) in Y, its cost
    """
    total, pieces = segment.segment(Y, plain.sequences(frames, lengths))
    found = [(p.fragment, p.end, p.cost) for p in pieces]
    return (np.asarray(total), *map(np.array, zip(*found)))


def principal_components(frames: Array, *, lengths: Sequence[int], components: int,
                         length: int) -> tuple[Array, Array, Array]:
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


def gaussian_kernel(A: Array, B: Array, *, gamma: float) -> Array:
    """k(a, b) = exp( -gamma || a - b ||^2 ).   A : (M, d), B : (N, d), gamma above 0  ->  (M, N)"""
    return regress.gaussian_kernel(A, B, gamma)


def linear_ridge(Z: Array, Y: Array, *, ridge: float) -> Array:
    """theta = (Z^T Z + ridge I)^-1 Z^T Y.   Z : (N, d), Y : (N, E), ridge above 0  ->  (d, E)"""
    return regress.linear_ridge(Z, Y, ridge)


def kernel_ridge(K: Array, Y: Array, *, ridge: float) -> Array:
    """a = (K + ridge I)^-1 Y.   K : (N, N), Y : (N, E), ridge above 0  ->  (N, E)"""
    return regress.kernel_ridge(K, Y, ridge)


def support_vector_regression(K: Array, y: Array, K_new: Array, *, C: float,
                              epsilon: float) -> tuple[Array, Array]:
    """Epsilon-insensitive support vector regression with offset, solved to the end.

    K : (N, N) kernel of the examples, y : (N,), K_new : (M, N);  C : box, epsilon : half width of
    the tube
    ->  the dual objective 1/2 b^T K b - y^T b + epsilon |b|, predictions (M,). Where no example
    lies inside the box the offset is the middle of what the conditions leave it.
    """
    (beta,), (b,) = svr.fit_svr(K[None], y[None], C, epsilon, tolerance=1e-12)
    objective = np.asarray(svr.dual_objective(K, y, beta, epsilon))
    return objective, svr.predict_svr(K_new, beta, b)


def predicted_style(Z: Array, Y: Array, new: Array, *, kind: str,
                    ridge: float | None = None, gamma: float | None = None,
                    C: float | None = None, epsilon: float | None = None) -> Array:
    """f of equation 1, fitted with known hyper-parameters: the columns of Z standardised by mean
    and deviation (of the population; a constant one is divided by 1), the mean label taken out and
    put back. "linear interpolation" is e_i + alpha (e_j - e_i) of the columns as they are.

    Z : (N, d), d = 2 components + 7, its last columns e_i (3), e_j (3), alpha;  Y : (N, E) styles;
    new : (M, d)
    kind : "linear interpolation", "linear ridge", "kernel ridge" or "support vector"   ->  (M, E)
    """
    chosen: dict[str, Any] = {"linear interpolation": {}, "linear ridge": {"lambda": ridge},
                              "kernel ridge": {"gamma": gamma, "lambda": ridge},
                              "support vector": {"gamma": gamma, "C": C, "epsilon": epsilon}}[kind]
    fitted = regress.fit_with(kind, Z, Y, [chosen] * Y.shape[1], tolerance=1e-12)
    return regress.predict(fitted, new)


def continuous_exponential_maps(R: Array, reference: Array) -> Array:
    """Rotation vectors v of reference^T R that run on past pi instead of jumping: in each frame the
    one of v + 2 pi k u, u = v / |v|, nearest to the frame before. The first frame has the shortest,
    or that minus 2 pi u if the whole track is then shorter in the mean and its longest step is not
    longer.

    R : (T, J, 3, 3), reference : (J, 3, 3)  ->  (T, 3 J) radians, joint after joint
    """
    return poses.exponential_maps(R, reference)


def polynomials(coefficients: Array) -> Callable[[Array], Array]:
    """Polynomials, coefficients (N, degree + 1) from the constant on, as a function of (N,).

    >>> polynomials(np.array([[1.0, 0.0, 2.0]]))(np.array([3.0]))
    array([19.])
    """
    return lambda x: np.array([np.polynomial.polynomial.polyval(value, c)
                               for value, c in zip(x, coefficients)])


def golden_section(coefficients: Array, low: Array, high: Array, *,
                   tolerance: float = 1e-6) -> Array:
    """Where polynomials have their minimum between two ends, by golden-section search: the middle
    of the last interval, which is no wider than the tolerance.

    coefficients : (N, degree + 1), from the constant on;  low, high : (N,)  ->  (N,)
    """
    return synthesise.golden_section(polynomials(coefficients), low, high, tolerance)


def best_alpha(coefficients: Array, *, samples: int = synthesise.SAMPLES,
               tolerance: float = 1e-6) -> Array:
    """Equation 12's search: the best of `samples` even steps over [-0.25, 1.25], then golden
    section between its neighbours, which stay inside that range.

    coefficients : (N, degree + 1) of polynomials that stand for the distance to the style asked for
    ->  (N,)
    """
    return synthesise.best_alpha(polynomials(coefficients), len(coefficients), samples, tolerance)
