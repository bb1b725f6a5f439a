"""Records of the system of Torresani et al. 2006, as functions of arrays alone, without gradients:
the paper has none.

Sequences of different length come end to end in one array, with their lengths. Everything is
float64; a backend that computes in single precision declares its tolerance.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from ..motion import rotation
from ..torresani2006 import align, observe
from . import definitions_learning as models, definitions_torresani as plain
from .functions_torresani import (
    best_alpha, content_clusters, continuous_exponential_maps, dtw_cost, dtw_path,
    gaussian_kernel, golden_section, kernel_ridge, linear_ridge, one_stage_segmentation,
    predicted_style, principal_components, space_time_interpolation, support_vector_regression)
from .specification import Bad, Operation, Sample


# Inputs.

# Predictions of a machine whose dual objective is right to 1e-9: others' solvers end at 1e-6.
SOLVED = 1e3


def walk(rng: np.random.Generator, frames: int, angles: int = 3) -> np.ndarray:
    """A smooth sequence: steps of a random walk."""
    return rng.standard_normal((frames, angles)).cumsum(axis=0) * 0.2


def pair_samples(rng: np.random.Generator) -> list[Sample]:
    X = walk(rng, 9)
    return [Sample("plain", (X, walk(rng, 6))), Sample("the same twice", (X, X.copy())),
            Sample("one frame each", (walk(rng, 1), walk(rng, 1))),
            Sample("one frame against many", (walk(rng, 1), walk(rng, 5))),
            Sample("one angle", (walk(rng, 7, 1), walk(rng, 12, 1))),
            Sample("all ways equal", (np.zeros((4, 2)), np.zeros((6, 2)))),
            Sample("a tie between p-1 and q-1", (np.array([[2.0], [0], [2], [1], [2]]),
                                                 np.array([[2.0], [1], [1], [2], [1]]))),
            Sample("whole numbers with ties", (rng.integers(0, 2, (7, 2)).astype(float),
                                               rng.integers(0, 2, (9, 2)).astype(float)))]


def bad_pairs() -> list[Bad]:
    X = np.zeros((3, 2))
    return [Bad("no frames", (X[:0], X), {}, "X"), Bad("one axis", (X[0], X), {}, "X"),
            Bad("not a number", (X, X * np.nan), {}, "Y"),
            Bad("other angles", (X, np.zeros((3, 4))), {}, "X, Y")]


def cluster_samples(rng: np.random.Generator) -> list[Sample]:
    d = rng.uniform(0, 1, (8, 8))
    d = d + d.T
    np.fill_diagonal(d, 0)
    chain = np.abs(np.subtract.outer(np.arange(5.0), np.arange(5.0)))
    return [Sample("plain", (d,), {"threshold": 0.5}),
            Sample("nothing matches", (d,), {"threshold": 0.0}),
            Sample("all match", (d,), {"threshold": 9.0}),
            Sample("a chain", (chain[np.ix_([0, 2, 4, 1, 3], [0, 2, 4, 1, 3])],),
                   {"threshold": 1.5}),
            Sample("a distance of the threshold is no match", (chain,), {"threshold": 1.0})]


def interpolation_samples(rng: np.random.Generator) -> list[Sample]:
    X, Y = walk(rng, 14), walk(rng, 9)
    roots = [walk(rng, len(x), 4) for x in (X, Y)]
    path = plain.dtw_path(X, Y)
    far = roots[1] + [0, 0, 0, 2 * np.pi * 3]
    return [Sample("half", (X, Y, *roots, path), {"alpha": 0.5}),
            *(Sample(f"alpha {alpha:g}", (X, Y, *roots, path), {"alpha": alpha})
              for alpha in (0.0, 1.0, -0.25, 1.25, 0.3)),
            Sample("z is up", (X, Y, *roots, path), {"alpha": 0.4, "up": "z"}),
            Sample("steps as they are", (X, Y, *roots, path), {"alpha": 0.6, "smooth": 0.0}),
            Sample("headings three turns apart", (X, Y, roots[0], far, path), {"alpha": 0.5})]


def bad_interpolations() -> list[Bad]:
    X = np.zeros((3, 2))
    root, path = np.zeros((3, 4)), np.array([[0, 0], [1, 1], [2, 2]])
    return [Bad("alpha too large", (X, X, root, root, path), {"alpha": 1.3}, "alpha"),
            Bad("another pair's path", (X, X, root, root, path[:2]), {"alpha": 0.5}, "path")]


def segment_samples(rng: np.random.Generator) -> list[Sample]:
    lengths = (5, 3, 4)
    frames = walk(rng, 12)
    pieces = plain.sequences(frames, lengths)
    Y = (np.concatenate([pieces[2], pieces[0], pieces[0], pieces[1]])
         + 0.01 * rng.standard_normal((17, 3)))
    return [Sample("known fragments and noise", (Y, frames), {"lengths": lengths}),
            Sample("something else", (walk(rng, 20), frames), {"lengths": lengths}),
            Sample("one frame", (Y[:1], frames), {"lengths": lengths}),
            Sample("one fragment of one frame", (Y[:4], frames[:1]), {"lengths": (1,)}),
            Sample("all equal", (np.zeros((6, 2)), np.zeros((5, 2))), {"lengths": (2, 3)})]


def bad_segments() -> list[Bad]:
    X = np.zeros((4, 2))
    return [Bad("no frames", (X[:0], X), {"lengths": (4,)}, "Y"),
            Bad("not a number", (X * np.nan, X), {"lengths": (4,)}, "Y"),
            Bad("other angles", (X, np.zeros((4, 3))), {"lengths": (4,)}, "fragments[0]")]


def component_samples(rng: np.random.Generator) -> list[Sample]:
    return [Sample("plain", (walk(rng, 30),),
                   {"lengths": (9, 6, 8, 7), "components": 2, "length": 5}),
            Sample("one component", (walk(rng, 11),),
                   {"lengths": (1, 4, 6), "components": 1, "length": 1})]


def kernel_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    A = n((5, 3))
    return [Sample("plain", (A, n((4, 3))), {"gamma": 0.7}),
            Sample("with itself", (A, A.copy()), {"gamma": 2.0}),
            Sample("far apart", (A * 100, n((3, 3))), {"gamma": 1.0})]


def ridge_samples(rng: np.random.Generator) -> list[Sample]:
    n = rng.standard_normal
    return [Sample("plain", (n((7, 3)), n((7, 2))), {"ridge": 0.5}),
            Sample("fewer examples than inputs", (n((2, 4)), n((2, 2))), {"ridge": 0.1})]


def bad_ridges() -> list[Bad]:
    return [Bad("no ridge", (np.eye(3), np.ones((3, 2))), {"ridge": 0.0}, "ridge"),
            Bad("negative", (np.eye(3), np.ones((3, 2))), {"ridge": -1.0}, "ridge")]


def kernel_ridge_samples(rng: np.random.Generator) -> list[Sample]:
    A = rng.standard_normal((6, 2))
    return [Sample("plain", (plain.gaussian_kernel(A, A, gamma=0.5), rng.standard_normal((6, 3))),
                   {"ridge": 0.3})]


def svr_samples(rng: np.random.Generator) -> list[Sample]:
    A, new = rng.standard_normal((9, 2)), rng.standard_normal((4, 2))
    K, K_new = plain.gaussian_kernel(A, A, gamma=0.5), plain.gaussian_kernel(new, A, gamma=0.5)
    y = 2 * np.sin(A[:, 0]) + A[:, 1]
    settings = {"plain": (10.0, 0.1), "a tight box": (0.3, 0.05), "a wide tube": (5.0, 0.8)}
    return [Sample(label, (K, y, K_new), {"C": C, "epsilon": epsilon}, factors=(1.0, SOLVED))
            for label, (C, epsilon) in settings.items()]


def style_samples(rng: np.random.Generator) -> list[Sample]:
    Z, Y, new = (rng.standard_normal((8, 11)), rng.uniform(-3, 3, (8, 3)),
                 rng.standard_normal((5, 11)))
    steady = Z.copy()
    steady[:, 2] = 1.5
    return [Sample("linear interpolation", (Z, Y, new), {"kind": "linear interpolation"}),
            Sample("linear ridge", (Z, Y, new), {"kind": "linear ridge", "ridge": 0.4}),
            Sample("kernel ridge", (Z, Y, new),
                   {"kind": "kernel ridge", "ridge": 0.2, "gamma": 0.05}),
            Sample("support vector", (Z, Y, new),
                   {"kind": "support vector", "gamma": 0.05, "C": 4.0, "epsilon": 0.2},
                   factors=(SOLVED,)),
            Sample("an input that does not vary", (steady, Y, new),
                   {"kind": "linear ridge", "ridge": 0.4})]


def vector_samples(rng: np.random.Generator) -> list[Sample]:
    return [Sample("plain", (rng.standard_normal((6, 3)),)),
            Sample("no turn", (np.zeros((2, 3)),)),
            Sample("a hair", (1e-9 * rng.standard_normal((3, 3)),)),
            Sample("several turns", (9.0 * rng.standard_normal((4, 3)) / 3,))]


def matrix_samples(rng: np.random.Generator) -> list[Sample]:
    v = rng.standard_normal((6, 3))
    v *= (rng.uniform(0.05, 3.1, 6) / np.linalg.norm(v, axis=1))[:, None]
    half = np.array([np.diag(d) for d in ((1.0, -1, -1), (-1, 1, -1), (-1, -1, 1))])
    return [Sample("plain", (models.exponential_map(v),)), Sample("no turn", (np.eye(3)[None],)),
            Sample("half a turn", (half,))]


def continuous_samples(rng: np.random.Generator) -> list[Sample]:
    t = np.linspace(0, 1, 40)
    axes = rng.standard_normal((2, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    turning = np.stack([models.exponential_map(np.outer(turns * 2 * np.pi * t, axis))
                        for turns, axis in zip((2.3, -0.4), axes)], axis=1)
    reference = models.exponential_map(rng.standard_normal((2, 3)))
    return [Sample("more than two turns", (turning, reference)),
            Sample("one frame", (turning[7:8], reference))]


def polynomial_samples(rng: np.random.Generator) -> np.ndarray:
    at = rng.uniform(-0.2, 1.2, 5)
    return np.stack([at ** 2, -2 * at, np.ones(5)], axis=1)      # (x - at)^2


def golden_samples(rng: np.random.Generator) -> list[Sample]:
    bowls, ones = polynomial_samples(rng), np.ones(5)
    return [Sample("bowls", (bowls, -0.25 * ones, 1.25 * ones)),
            Sample("the minimum at an end", (bowls * [0, 0, 1] + [0, 3.0, 0], ones, 2 * ones))]


def alpha_samples(rng: np.random.Generator) -> list[Sample]:
    two = 4 * np.stack([np.polynomial.polynomial.polyfromroots([a, a, b, b])
                        for a, b in ((0.0, 0.8), (0.0, 1.1))])
    # Minima near both ends, where a search of the whole interval takes the higher one.
    two[:, 1] += [0.05, -0.05]
    return [Sample("bowls", (polynomial_samples(rng),)), Sample("two minima", (two,)),
            Sample("few samples", (polynomial_samples(rng),), {"samples": 4})]


def measure_samples(rng: np.random.Generator) -> list[Sample]:
    return [Sample("plain", (walk(rng, 12, 15).reshape(12, 5, 3),), {"fps": 30.0}),
            Sample("four frames", (walk(rng, 4, 3).reshape(4, 1, 3),), {"fps": 60.0}),
            Sample("standing", (np.ones((6, 2, 3)),), {"fps": 30.0})]


def bad_measures() -> list[Bad]:
    return [Bad("three frames", (np.zeros((3, 2, 3)),), {"fps": 30.0}, "positions"),
            Bad("no frame rate", (np.zeros((5, 2, 3)),), {"fps": 0.0}, "fps")]


def another_path(found: tuple, arguments: tuple, attributes: dict[str, Any]) -> str:
    """A path of the steps of equations 3 to 5 that costs no more: ties may be decided otherwise."""
    (path,), (X, Y) = found, arguments
    steps, at = np.diff(path, axis=0), tuple(path.astype(int).T)
    allowed = path.ndim == 2 and ((steps == 0) | (steps == 1)).all() and steps.any(axis=1).all()
    ends = tuple(path[0]) == (0, 0) and tuple(path[-1]) == (len(X) - 1, len(Y) - 1)
    if not allowed or not ends or path.dtype.kind not in "iu":
        return ""
    cost = np.sum((X[at[0]] - Y[at[1]]) ** 2)
    return ("another path that costs as little"
            if abs(cost - align.dtw(X, Y)[0]) <= 1e-12 * max(cost, 1e-300) else "")


def operation(name: str, arguments: tuple[str, ...], f: Callable, definition: Callable,
              samples: Callable, bad: Callable = list, tolerance: float = 1.0, equation: str = "",
              same: Callable | None = None) -> Operation:
    return Operation(name, arguments, f, None, definition, samples, bad, batched=(),
                     tolerance=tolerance, equation=equation, precisions=("float64",), same=same)


OPERATIONS = (
    operation("dtw_cost", ("X", "Y"), dtw_cost, plain.dtw_cost, pair_samples, bad_pairs,
              equation="2006, equations 3 to 5"),
    operation("dtw_path", ("X", "Y"), dtw_path, plain.dtw_path, pair_samples, bad_pairs,
              equation="2006, equations 3 to 5", same=another_path),
    operation("content_clusters", ("ssd",), content_clusters, plain.content_clusters,
              cluster_samples, equation="2006, section 4"),
    operation("space_time_interpolation", ("X", "Y", "root_X", "root_Y", "path"),
              space_time_interpolation, plain.space_time_interpolation, interpolation_samples,
              bad_interpolations, equation="2006, section 5"),
    operation("principal_components", ("frames",), principal_components,
              plain.principal_components, component_samples, tolerance=100.0,
              equation="2006, section 6"),
    operation("gaussian_kernel", ("A", "B"), gaussian_kernel, plain.gaussian_kernel,
              kernel_samples, equation="2006, section 6"),
    operation("linear_ridge", ("Z", "Y"), linear_ridge, plain.linear_ridge, ridge_samples,
              bad_ridges, tolerance=10.0, equation="2006, section 6"),
    operation("kernel_ridge", ("K", "Y"), kernel_ridge, plain.kernel_ridge, kernel_ridge_samples,
              bad_ridges, tolerance=10.0, equation="2006, section 6"),
    operation("support_vector_regression", ("K", "y", "K_new"), support_vector_regression,
              models.support_vector_regression, svr_samples, tolerance=1e3,
              equation="2006, section 6"),
    operation("predicted_style", ("Z", "Y", "new"), predicted_style, models.predicted_style,
              style_samples, tolerance=1e3, equation="2006, equation 1"),
    operation("one_stage_segmentation", ("Y", "frames"), one_stage_segmentation,
              plain.one_stage_segmentation, segment_samples, bad_segments,
              equation="2006, equations 8 to 11"),
    operation("golden_section", ("coefficients", "low", "high"), golden_section,
              models.golden_section, golden_samples, tolerance=1e7, equation="2006, section 7.2"),
    operation("best_alpha", ("coefficients",), best_alpha, models.best_alpha, alpha_samples,
              tolerance=1e7, equation="2006, equation 12"),
    operation("exponential_map", ("v",), rotation.exp_map, models.exponential_map, vector_samples,
              equation="2006, section 3"),
    operation("rotation_vector", ("R",), rotation.log_map, models.rotation_vector, matrix_samples,
              tolerance=1e3, equation="2006, section 3"),
    operation("continuous_exponential_maps", ("R", "reference"), continuous_exponential_maps,
              models.continuous_exponential_maps, continuous_samples, tolerance=1e3,
              equation="2006, section 3"),
    operation("effort_measures", ("positions",), observe.measures, models.effort_measures,
              measure_samples, bad_measures, equation="computed observer"),
)
