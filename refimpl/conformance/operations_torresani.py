"""The specifications of the system of Torresani et al. 2006, as functions of arrays alone, without
gradients: the paper has none.

Sequences of different length come end to end in one array, with their lengths. Everything is
float64; a backend that computes in single precision declares its tolerance.
"""

import numpy as np

from ..motion import rotation
from ..torresani2006 import align, observe, segment
from . import definitions_learning as learning, definitions_torresani as plain
from . import (functions_torresani as functions, ground_learning, ground_torresani as ground,
               refused_torresani as bad)
from .specification import called, operation, refused

# Predictions of a machine whose dual objective is right to 1e-9: others' solvers end at 1e-6.
SOLVED = 1e3


def _pair_samples(rng):
    X = ground.walk(rng, 9)
    return [called("plain", X, ground.walk(rng, 6)), called("the same twice", X, X.copy()),
            called("one frame each", ground.walk(rng, 1), ground.walk(rng, 1)),
            called("one frame against many", ground.walk(rng, 1), ground.walk(rng, 5)),
            called("one angle", ground.walk(rng, 7, 1), ground.walk(rng, 12, 1)),
            called("all ways equal", np.zeros((4, 2)), np.zeros((6, 2))),
            called("a tie between p-1 and q-1",
                   np.array([[2.0], [0], [2], [1], [2]]), np.array([[2.0], [1], [1], [2], [1]])),
            called("whole numbers with ties", rng.integers(0, 2, (7, 2)).astype(float),
                   rng.integers(0, 2, (9, 2)).astype(float))]


def _cluster_samples(rng):
    d = rng.uniform(0, 1, (8, 8))
    d = d + d.T
    np.fill_diagonal(d, 0)
    chain = np.abs(np.subtract.outer(np.arange(5.0), np.arange(5.0)))
    return [called("plain", d, threshold=0.5),
            called("nothing matches", d, threshold=0.0), called("all match", d, threshold=9.0),
            called("a chain", chain[np.ix_([0, 2, 4, 1, 3], [0, 2, 4, 1, 3])], threshold=1.5),
            called("a distance of the threshold is no match", chain, threshold=1.0)]


def _interpolation_samples(rng):
    X, Y = ground.walk(rng, 14), ground.walk(rng, 9)
    roots = [ground.walk(rng, len(x), 4) for x in (X, Y)]
    path = plain.dtw_path(X, Y)
    far, far_too = (root + [0, 0, 0, 2 * np.pi * 3] for root in roots[::-1])
    return [called("half", X, Y, *roots, path, alpha=0.5),
            *(called(f"alpha {alpha:g}", X, Y, *roots, path, alpha=alpha)
              for alpha in (0.0, 1.0, -0.25, 1.25, 0.3)),
            called("z is up", X, Y, *roots, path, alpha=0.4, up="z"),
            called("steps as they are", X, Y, *roots, path, alpha=0.6, smooth=0.0),
            called("headings three turns apart", X, Y, roots[0], far, path, alpha=0.5),
            called("both headings far from 0", X, Y, far_too, roots[1], path, alpha=0.5)]


def _segment_samples(rng):
    lengths = (5, 3, 4)
    frames = ground.walk(rng, 12)
    pieces = plain.sequences(frames, lengths)
    Y = (np.concatenate([pieces[2], pieces[0], pieces[0], pieces[1]])
         + 0.01 * rng.standard_normal((17, 3)))
    return [called("known fragments and noise", Y, frames, lengths=lengths),
            called("something else", ground.walk(rng, 20), frames, lengths=lengths),
            called("one frame", Y[:1], frames, lengths=lengths),
            called("one fragment of one frame", Y[:4], frames[:1], lengths=(1,)),
            called("all equal", np.zeros((6, 2)), np.zeros((5, 2)), lengths=(2, 3))]


def _component_samples(rng):
    return [called("plain", ground.walk(rng, 30), lengths=(9, 6, 8, 7), components=2, length=5),
            called("one component",
                   ground.walk(rng, 11), lengths=(1, 4, 6), components=1, length=1)]


def _kernel_samples(rng):
    n = rng.standard_normal
    A = n((5, 3))
    return [called("plain", A, n((4, 3)), gamma=0.7), called("with itself", A, A.copy(), gamma=2.0),
            called("far apart", A * 100, n((3, 3)), gamma=1.0)]


def _ridge_samples(rng):
    n = rng.standard_normal
    return [called("plain", n((7, 3)), n((7, 2)), ridge=0.5),
            called("fewer examples than inputs", n((2, 4)), n((2, 2)), ridge=0.1)]


def _kernel_ridge_samples(rng):
    A = rng.standard_normal((6, 2))
    return [called("plain", ground_learning.kernel(A, A), rng.standard_normal((6, 3)), ridge=0.3)]


def _svr_samples(rng):
    A, new = rng.standard_normal((9, 2)), rng.standard_normal((4, 2))
    K, K_new = ground_learning.kernel(A, A), ground_learning.kernel(new, A)
    y = 2 * np.sin(A[:, 0]) + A[:, 1]
    settings = {"plain": (10.0, 0.1), "a tight box": (0.3, 0.05), "a wide tube": (5.0, 0.8)}
    return [called(label, K, y, K_new, C=C, epsilon=epsilon, factors=(1.0, SOLVED))
            for label, (C, epsilon) in settings.items()]


def _style_samples(rng):
    Z, Y, new = (rng.standard_normal((8, 11)), rng.uniform(-3, 3, (8, 3)),
                 rng.standard_normal((5, 11)))
    steady = Z.copy()
    steady[:, 2] = 1.5
    return [called("linear interpolation", Z, Y, new, kind="linear interpolation"),
            called("linear ridge", Z, Y, new, kind="linear ridge", ridge=0.4),
            called("kernel ridge", Z, Y, new, kind="kernel ridge", ridge=0.2, gamma=0.05),
            called("support vector", Z, Y,
                   new, kind="support vector", gamma=0.05, C=4.0, epsilon=0.2, factors=(SOLVED,)),
            called("an input that does not vary", steady, Y, new, kind="linear ridge", ridge=0.4)]


def _vector_samples(rng):
    return [called("plain", rng.standard_normal((6, 3))), called("no turn", np.zeros((2, 3))),
            called("a hair", 1e-9 * rng.standard_normal((3, 3))),
            called("several turns", 9.0 * rng.standard_normal((4, 3)) / 3)]


def _matrix_samples(rng):
    v = rng.standard_normal((6, 3))
    v *= (rng.uniform(0.05, 3.1, 6) / np.linalg.norm(v, axis=1))[:, None]
    half = np.array([np.diag(d) for d in ((1.0, -1, -1), (-1, 1, -1), (-1, -1, 1))])
    return [called("plain", learning.exponential_map(v)),
            called("no turn", np.eye(3)[None]), called("half a turn", half)]


def _continuous_samples(rng):
    t = np.linspace(0, 1, 40)
    axes = rng.standard_normal((2, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    turning = np.stack([learning.exponential_map(np.outer(turns * 2 * np.pi * t, axis))
                        for turns, axis in zip((2.3, -0.4), axes)], axis=1)
    reference = learning.exponential_map(rng.standard_normal((2, 3)))
    far = np.array([0.3, 3.1, 4.9, 7.8, 9.4, 8.0, 5.2, 2.4, -0.4, -3.1, -5.9])
    return [called("more than two turns", turning, reference),
            called("steps of almost half a turn",
                   learning.exponential_map(far[:, None, None] * axes), np.stack([np.eye(3)] * 2)),
            called("one frame", turning[7:8], reference)]


def _polynomials(rng):
    at = rng.uniform(-0.2, 1.2, 5)
    return np.stack([at ** 2, -2 * at, np.ones(5)], axis=1)      # (x - at)^2


def _golden_samples(rng):
    bowls, ones = _polynomials(rng), np.ones(5)
    return [called("bowls", bowls, -0.25 * ones, 1.25 * ones),
            called("the minimum at an end", bowls * [0, 0, 1] + [0, 3.0, 0], ones, 2 * ones)]


def _alpha_samples(rng):
    two = 4 * np.stack([np.polynomial.polynomial.polyfromroots([a, a, b, b])
                        for a, b in ((0.0, 0.8), (0.0, 1.1))])
    # Minima near both ends, where a search of the whole interval takes the higher one.
    two[:, 1] += [0.05, -0.05]
    return [called("bowls", _polynomials(rng)),
            called("two minima", two), called("few samples", _polynomials(rng), samples=4),
            called("many samples", two, samples=29)]


def _measure_samples(rng):
    return [called("plain", ground.walk(rng, 12, 15).reshape(12, 5, 3), fps=30.0),
            called("four frames", ground.walk(rng, 4, 3).reshape(4, 1, 3), fps=60.0),
            called("standing", np.ones((6, 2, 3)), fps=30.0)]


def _another_path(found, arguments, attributes):
    """A path of the steps of `align.dtw` that costs no more: ties may be decided otherwise."""
    (path,), (X, Y) = found, arguments
    steps, at = np.diff(path, axis=0), tuple(path.astype(int).T)
    allowed = path.ndim == 2 and ((steps == 0) | (steps == 1)).all() and steps.any(axis=1).all()
    ends = tuple(path[0]) == (0, 0) and tuple(path[-1]) == (len(X) - 1, len(Y) - 1)
    if not allowed or not ends or path.dtype.kind not in "iu":
        return ""
    cost = np.sum((X[at[0]] - Y[at[1]]) ** 2)
    as_cheap = abs(cost - align.dtw(X, Y)[0]) <= 1e-12 * max(cost, 1e-300)
    return "another path that costs as little" if as_cheap else ""


def _another_segmentation(found, arguments, attributes):
    """Pieces that cost no more: ties may be decided otherwise."""
    (total, fragments, ends, costs), (Y, frames) = found, arguments
    pieces = plain.sequences(frames, attributes["lengths"])
    if not 0 < len(fragments) == len(ends) == len(costs) or ends[-1] != len(Y):
        return ""
    starts = [0, *ends[:-1]]
    own = [align.dtw(Y[start:end], pieces[k])[0] for k, start, end in zip(fragments, starts, ends)]
    best = segment.segment(Y, pieces)[0]
    as_cheap = (np.allclose(own, costs, rtol=1e-9, atol=1e-12 * max(best, 1.0))
                and abs(sum(own) - best) <= 1e-12 * max(best, 1e-300)
                and abs(total - best) <= 1e-12 * max(best, 1.0))
    return "another segmentation that costs as little" if as_cheap else ""


def _other_sign(found, arguments, attributes):
    """Of half a turn v and -v are one rotation."""
    (v,), (R,) = found, arguments
    ours = rotation.log_map(R)
    half = np.linalg.norm(ours, axis=-1) > np.pi - 1e-9
    flipped = np.where((half & (np.sum(v * ours, axis=-1) < 0))[..., None], -v, v)
    return "the other sign of half a turn" if np.allclose(flipped, ours, 1e-9, 1e-9) else ""


def _one(f, arguments, samples, bad=list, part="", *, name="", **rest):
    definitions = learning if hasattr(learning, name or f.__name__) else plain
    return operation(f, arguments, definitions,
                     samples, bad, part, name=name, batched=(), precisions=("float64",), **rest)


OPERATIONS = (
    _one(functions.dtw_cost, "X Y", _pair_samples, bad.pairs, "2006, equations 3 to 5",
         ground=ground.time_warps),
    _one(functions.dtw_path, "X Y", _pair_samples, bad.pairs, "2006, equations 3 to 5",
         same=_another_path, ground=ground.time_warps),
    _one(functions.content_clusters, "ssd", _cluster_samples,
         lambda: [refused("not square", "ssd", np.ones((2, 3)), threshold=1.0)],
         "2006, section 4", ground=ground.clusters),
    _one(functions.space_time_interpolation, "X Y root_X root_Y path", _interpolation_samples,
         bad.interpolations, "2006, section 5", ground=ground.interpolations),
    _one(functions.principal_components, "frames", _component_samples,
         bad.components, "2006, section 6", tolerance=100.0, ground=ground.components),
    _one(functions.gaussian_kernel, "A B", _kernel_samples, part="2006, section 6",
         ground=ground_learning.kernels),
    _one(functions.linear_ridge, "Z Y", _ridge_samples, lambda: bad.ridges("Z"),
         "2006, section 6", tolerance=10.0, ground=ground_learning.ridges),
    _one(functions.kernel_ridge, "K Y", _kernel_ridge_samples, bad.kernel_ridges,
         "2006, section 6", tolerance=10.0, ground=ground_learning.kernel_ridges),
    _one(functions.support_vector_regression, "K y K_new", _svr_samples,
         bad.machines, "2006, section 6", tolerance=1e3, ground=ground_learning.machines),
    _one(functions.predicted_style, "Z Y new", _style_samples, part="2006, equation 1",
         ground=ground_learning.styles, tolerance=1e3),
    _one(functions.one_stage_segmentation, "Y frames", _segment_samples, bad.segments,
         "2006, equations 8 to 11", ground=ground.segmentations, same=_another_segmentation),
    _one(functions.golden_section, "coefficients low high", _golden_samples, bad.golden,
         "2006, section 7.2", tolerance=1e7, ground=ground_learning.golden),
    _one(functions.best_alpha, "coefficients", _alpha_samples,
         lambda: [refused("one sample", "samples", np.ones((1, 3)), samples=1)],
         "2006, equation 12", ground=ground_learning.alphas, tolerance=1e7),
    _one(rotation.exp_map, "v", _vector_samples, bad.vectors, "2006, section 3",
         name="exponential_map", ground=ground.vectors),
    _one(rotation.log_map, "R", _matrix_samples, part="2006, section 3", name="rotation_vector",
         tolerance=1e3, ground=ground.matrices, same=_other_sign),
    _one(functions.continuous_exponential_maps, "R reference", _continuous_samples,
         part="2006, section 3", tolerance=1e3, ground=ground.continuous),
    _one(observe.measures, "positions", _measure_samples, bad.measures, "computed observer",
         name="effort_measures", ground=ground.efforts))
