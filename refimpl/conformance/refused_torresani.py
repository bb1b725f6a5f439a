"""Inputs that the system of 2006 has to refuse."""

import numpy as np

from .specification import Bad, refused


def pairs() -> list[Bad]:
    """Of `dtw_cost` and `dtw_path`."""
    X = np.zeros((3, 2))
    return [refused("no frames", "X", X[:0], X), refused("one axis", "X", X[0], X),
            refused("not a number", "Y", X, X * np.nan), refused("complex numbers", "X", X + 0j, X),
            refused("other angles", "X, Y", X, np.zeros((3, 4)))]


def interpolations() -> list[Bad]:
    """Of `space_time_interpolation`."""
    X = np.zeros((3, 2))
    root, path = np.zeros((3, 4)), np.array([[0, 0], [1, 1], [2, 2]])
    return [refused("alpha too large", "alpha", X, X, root, root, path, alpha=1.3),
            refused("alpha too small", "alpha", X, X, root, root, path, alpha=-0.3),
            refused("a path of three columns",
                    "path", X, X, root, root, path[:, [0, 1, 1]], alpha=0.5),
            refused("other angles", "X, Y", X, X[:, :1], root, root, path, alpha=0.5),
            refused("another pair's path", "path", X, X, root, root, path[:2], alpha=0.5)]


def components() -> list[Bad]:
    """Of `principal_components`."""
    return [refused("more components than differences",
                    "components", np.eye(4), lengths=(2, 2), components=2, length=2),
            refused("nothing but zeros",
                    "components", np.zeros((4, 2)), lengths=(2, 2), components=1, length=2)]


def segments() -> list[Bad]:
    """Of `one_stage_segmentation`."""
    X = np.zeros((4, 2))
    return [refused("no frames", "Y", X[:0], X, lengths=(4,)),
            refused("not a number", "Y", X * np.nan, X, lengths=(4,)),
            refused("no fragments", "fragments", X, X[:0], lengths=()),
            refused("other angles", "fragments[0]", X, np.zeros((4, 3)), lengths=(4,))]


def ridges(name: str) -> list[Bad]:
    """Of `linear_ridge` and `kernel_ridge`."""
    Y = np.ones((3, 2))
    return [refused("another count of rows", f"{name}, Y", np.eye(3), Y[:2], ridge=0.5),
            refused("not a number", f"{name}, Y", np.eye(3), Y * np.nan, ridge=0.5),
            refused("no ridge", "ridge", np.eye(3), np.ones((3, 2)), ridge=0.0),
            refused("negative", "ridge", np.eye(3), np.ones((3, 2)), ridge=-1.0)]


def kernel_ridges() -> list[Bad]:
    """Of `kernel_ridge`."""
    ones, Y = np.ones((3, 3)), np.ones((3, 1))
    return [*ridges("K"), refused("not square", "K", ones[:, :2], Y, ridge=0.5),
            refused("a ridge that is lost", "ridge", ones, Y, ridge=1e-300)]


def machines() -> list[Bad]:
    """Of `support_vector_regression`."""
    K, y, good = np.eye(3), np.ones(3), {"C": 1.0, "epsilon": 0.1}
    return [refused("another count of labels", "K, y", K, y[:2], K, **good),
            refused("not a number", "K, y", K, y * np.nan, K, **good),
            refused("a box below 0", "C, epsilon", K, y, K, **good | {"C": -1.0}),
            refused("a tube below 0", "C, epsilon", K, y, K, **good | {"epsilon": -0.1})]


def vectors() -> list[Bad]:
    """Of `exponential_map`."""
    return [refused("not a number", "v", np.full((1, 3), np.nan)),
            refused("infinite", "v", np.array([[0.0, np.inf, 0.0]]))]


def golden() -> list[Bad]:
    """Of `golden_section`."""
    one, c = np.ones(1), np.ones((1, 3))
    return [refused("ends in the wrong order", "low, high", c, one, 0 * one),
            refused("an end that is infinite", "low, high", c, one, np.inf * one),
            refused("not as many ends", "low, high", c, one, np.ones(2)),
            refused("a width that no number has", "tolerance", c, 0 * one, one, tolerance=1e-17)]


def measures() -> list[Bad]:
    """Of `effort_measures`."""
    return [refused("three frames", "positions", np.zeros((3, 2, 3)), fps=30.0),
            refused("two numbers a joint", "positions", np.zeros((6, 2, 2)), fps=30.0),
            refused("no frame rate", "fps", np.zeros((5, 2, 3)), fps=0.0)]
