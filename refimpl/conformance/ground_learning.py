"""Where real code breaks: samples for the regression of 2006 and its searches over alpha."""

import numpy as np

from . import definitions_torresani as plain
from .ground_nn import along
from .ground_torresani import SIZES
from .specification import Sample, called


def kernel(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """Of points two apart hardly anything is left."""
    return plain.gaussian_kernel(A, B, gamma=0.5)


def kernels(rng: np.random.Generator) -> list[Sample]:
    """Counts, points near each other far from zero, exponents to where nothing is left."""
    n = rng.standard_normal
    found = along({"points": 3, "others": 2, "numbers": 2}, lambda points, others, numbers: called(
        "", n((points, numbers)), n((others, numbers)), gamma=0.5), (*SIZES, 255, 257, 513))
    A = n((4, 3))
    whole = 2.0 ** 26 + rng.integers(0, 9, (5, 3)) / 4
    found.append(called("near each other, far away",
                        whole, whole[::-1] + 0.25, gamma=0.3, firm=True))
    return found + [called("near each other far from zero", A + 1e8, A + 1e8 + 1e-3 * n((4, 3)),
                           gamma=2.0), called("very near", A, A + 1e-9 * n((4, 3)), gamma=1e17),
                    called("tiny gamma", A, n((3, 3)), gamma=1e-12),
                    called("nothing left", A * 50, -A * 50, gamma=3.0)]


def ridges(rng: np.random.Generator) -> list[Sample]:
    """Examples, inputs and targets in every relation; small and large ridges; columns of very
    different size."""
    n = rng.standard_normal
    found = [called(f"{examples} examples, {inputs} inputs, {targets} targets",
                    n((examples, inputs)), n((examples, targets)), ridge=0.3)
             for examples, inputs, targets in ((2, 1, 3),
                                               (3, 3, 3), (1, 4, 2), (9, 2, 5), (33, 8, 1),
                                               (8, 17, 9), (64, 16, 3), (129, 5, 2), (17, 65, 2))]
    Z, Y = n((9, 3)), n((9, 2))
    return found + [called("a large ridge", Z, Y, ridge=1e4),
                    called("columns of uneven size", Z * [1.0, 1e3, 1e-3], Y, ridge=0.1,
                           factors=(1e3,)), called("no ridge to speak of", Z, Y, ridge=1e-6),
                    called("a weak column, a weaker ridge",
                           np.array([[1.0, 1], [1, -1], [1, 1], [1, -1]]) * [1.0, 2.0 ** -33],
                           n((4, 2)), ridge=2.0 ** -70, factors=(1e3,))]


def kernel_ridges(rng: np.random.Generator) -> list[Sample]:
    """More and fewer targets than examples; ridges."""
    n, found = rng.standard_normal, []
    for examples, targets, ridge in ((2, 3, 0.5), (3, 3, 0.1), (1, 2, 1.0), (17, 1, 0.2),
                                     (33, 4, 10.0), (9, 12, 1e-3), (65, 2, 0.05), (129, 1, 0.5)):
        A = n((examples, 2))
        found.append(called(f"{examples} examples, {targets} targets, ridge {ridge:g}",
                            kernel(A, A), n((examples, targets)), ridge=ridge))
    K, few = n((6, 6)), n((6, 2))
    turned, _ = np.linalg.qr(n((70, 70)))
    steep = (turned * np.logspace(0, -4, 70)) @ turned.T
    return found + [called("a kernel of low rank, hardly a ridge",
                           few @ few.T, n((6, 3)), ridge=1e-7, factors=(1e4,)),
                    called("a large kernel of all sizes", (steep + steep.T) / 2,
                           n((70, 2)), ridge=1e-4, factors=(100.0,), large=True),
                    called("a kernel that is not positive", K + K.T, n((6, 3)), ridge=0.3)]


def golden(rng: np.random.Generator) -> list[Sample]:
    """Wide and narrow brackets, minima at both ends and beyond, flat bottoms, many at once."""
    at = rng.uniform(-1, 1, 33)
    bowls = np.stack([at ** 2, -2 * at, np.ones(33)], axis=1)
    ones = np.ones(33)
    return [called("many at once", bowls, -2 * ones, 2 * ones),
            called("wide brackets", bowls[:6], -1e6 * ones[:6], 1e6 * ones[:6]),
            called("narrow brackets", bowls[:6], at[:6] - 1e-4, at[:6] + 2e-4),
            called("minima beyond the ends", bowls[:6], 3 * ones[:6], 5 * ones[:6]),
            called("minima before them", bowls[:6], -5 * ones[:6], -3 * ones[:6]),
            called("narrow and wide brackets", bowls[:6],
                   at[:6] - 10.0 ** np.arange(-3.0, 3), at[:6] + 2 * 10.0 ** np.arange(-3.0, 3)),
            called("of the sixth degree",
                   np.array([[0.0, -1, 0.5, 0, 0, 1, 1], [0, 0.2, -1, 0, 0, 0, 2]]),
                   np.zeros(2), np.array([2.0, 1.0]))]


def machines(rng: np.random.Generator) -> list[Sample]:
    """No support vector, all of them, all at the box, many and few examples."""
    found, off = [], {"factors": (1.0, 1e3)}
    sizes = {"everything in the tube": (9, 1.0, 50.0), "no tube": (7, 2.0, 0.0),
             "all at the box": (8, 1e-3, 0.01), "many": (65, 1.0, 0.2), "one": (1, 1.0, 0.1),
             "two": (2, 3.0, 0.1), "a tiny box": (9, 1e-5, 0.1), "a wide box": (40, 1e4, 0.01)}
    for label, (count, C, epsilon) in sizes.items():
        A, new = rng.standard_normal((count, 2)), rng.standard_normal((3, 2))
        y = 2 * np.sin(A[:, 0]) + A[:, 1] + 3.0
        found.append(called(label, kernel(A, A), y, kernel(new, A), C=C, epsilon=epsilon,
                            large=count > 30, **off))
    A, new = rng.standard_normal((8, 2)), rng.standard_normal((3, 2))
    A[[1, 5]], y = A[[0, 4]], rng.standard_normal(8)
    K, K_new = kernel(A, A), kernel(new, A)
    return found + [called("examples met twice", K, y, K_new, C=10.0, epsilon=0.1, **off),
                    called("a tiny box, a large kernel", 1e6 * K, y, 1e6 * K_new, C=1e-5,
                           epsilon=0.1, **off)]


def alphas(rng: np.random.Generator) -> list[Sample]:
    """Valleys whose floors are nearly equal, narrower than a step, beyond both ends; steps."""
    found = []
    for samples in (4, 7, 12, 50):
        roots = np.sort(rng.uniform(-0.3, 1.3, (9, 2)), axis=1)
        valleys = np.stack([np.polynomial.polynomial.polyfromroots([a, a, b, b]) for a, b in roots])
        valleys[:, 1] += rng.uniform(-0.05, 0.05, 9)
        found.append(called(f"two valleys, {samples} samples", valleys, samples=samples))
    falling = np.array([[0.0, -1, 0], [0, 1, 0], [0, -1, 1], [0, -4, 1], [0, 1, 1]])
    narrow = np.stack([np.polynomial.polynomial.polyfromroots([a, a, 3.0, 3.0, -2.0, -2.0])
                       for a in rng.uniform(-0.2, 1.2, 5)])
    between = np.polynomial.polynomial.polyfromroots([0.5, 0.5, 1.2, 1.2])[None]
    between[:, :2] += [-0.0012, 0.001]                   # the lower floor is the one that 4 miss
    found += [called(f"a valley between samples, {samples} of them", between, samples=samples)
              for samples in (4, 13)]
    return found + [called("minima at and beyond the ends", falling),
                    called("of the sixth degree", narrow * 50), called("one", falling[2:3])]


def styles(rng: np.random.Generator) -> list[Sample]:
    """Columns of very different size and far from zero, constant ones; many and few examples."""
    n, found = rng.standard_normal, []
    settings = {"linear interpolation": {}, "linear ridge": {"ridge": 0.4},
                "kernel ridge": {"ridge": 0.2, "gamma": 0.05}}
    for kind, given in settings.items():
        for examples, targets, others in ((4, 3, 1), (33, 1, 9), (12, 3, 33)):
            found.append(
                called(f"{examples} examples, {targets} targets, {kind}", n((examples, 11)),
                       n((examples, targets)), n((others, 11)), kind=kind, **given))
        scale = 10.0 ** np.array([0, -9, 3, -6, 0, 2, 0, 0, -1, 0, 0])
        Z, new = n((9, 11)) * scale, n((4, 11)) * scale
        found.append(called(f"columns of uneven size, {kind}",
                            Z, n((9, 3)), new, kind=kind, **given))
        Z[:, [0, 5]] = 7.0, 0.0
        found.append(called(f"constant columns, {kind}",
                            Z, n((9, 3)) + 100, new, kind=kind, **given, factors=(10.0,)))
    return found
