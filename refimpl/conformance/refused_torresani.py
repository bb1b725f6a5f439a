"""Inputs that the system of 2006 has to refuse."""

import numpy as np

from .specification import Bad


def pairs() -> list[Bad]:
    """Of `dtw_cost` and `dtw_path`."""
    X = np.zeros((3, 2))
    return [Bad("no frames", (X[:0], X), "X"), Bad("one axis", (X[0], X), "X"),
            Bad("not a number", (X, X * np.nan), "Y"),
            Bad("complex numbers", (X + 0j, X), "X"),
            Bad("other angles", (X, np.zeros((3, 4))), "X, Y")]


def interpolations() -> list[Bad]:
    """Of `space_time_interpolation`."""
    X = np.zeros((3, 2))
    root, path = np.zeros((3, 4)), np.array([[0, 0], [1, 1], [2, 2]])
    return [Bad("alpha too large", (X, X, root, root, path), "alpha", {"alpha": 1.3}),
            Bad("alpha too small", (X, X, root, root, path), "alpha", {"alpha": -0.3}),
            Bad("a path of three columns", (X, X, root, root, path[:, [0, 1, 1]]), "path",
                {"alpha": 0.5}),
            Bad("other angles", (X, X[:, :1], root, root, path), "X, Y", {"alpha": 0.5}),
            Bad("another pair's path", (X, X, root, root, path[:2]), "path", {"alpha": 0.5})]


def segments() -> list[Bad]:
    """Of `one_stage_segmentation`."""
    X = np.zeros((4, 2))
    return [Bad("no frames", (X[:0], X), "Y", {"lengths": (4,)}),
            Bad("not a number", (X * np.nan, X), "Y", {"lengths": (4,)}),
            Bad("no fragments", (X, X[:0]), "fragments", {"lengths": ()}),
            Bad("other angles", (X, np.zeros((4, 3))), "fragments[0]", {"lengths": (4,)})]


def ridges(name: str) -> list[Bad]:
    """Of `linear_ridge` and `kernel_ridge`."""
    Y = np.ones((3, 2))
    return [Bad("another count of rows", (np.eye(3), Y[:2]), f"{name}, Y", {"ridge": 0.5}),
            Bad("not a number", (np.eye(3), Y * np.nan), f"{name}, Y", {"ridge": 0.5}),
            Bad("no ridge", (np.eye(3), np.ones((3, 2))), "ridge", {"ridge": 0.0}),
            Bad("negative", (np.eye(3), np.ones((3, 2))), "ridge", {"ridge": -1.0})]


def kernel_ridges() -> list[Bad]:
    """Of `kernel_ridge`."""
    ones, Y = np.ones((3, 3)), np.ones((3, 1))
    return [*ridges("K"), Bad("not square", (ones[:, :2], Y), "K", {"ridge": 0.5}),
            Bad("a ridge that is lost", (ones, Y), "ridge", {"ridge": 1e-300})]


def machines() -> list[Bad]:
    """Of `support_vector_regression`."""
    K, y, good = np.eye(3), np.ones(3), {"C": 1.0, "epsilon": 0.1}
    return [Bad("another count of labels", (K, y[:2], K), "K, y", good),
            Bad("not a number", (K, y * np.nan, K), "K, y", good),
            Bad("a box below 0", (K, y, K), "C, epsilon", {**good, "C": -1.0}),
            Bad("a tube below 0", (K, y, K), "C, epsilon", {**good, "epsilon": -0.1})]


def vectors() -> list[Bad]:
    """Of `exponential_map`."""
    return [Bad("not a number", (np.full((1, 3), np.nan),), "v"),
            Bad("infinite", (np.array([[0.0, np.inf, 0.0]]),), "v")]


def golden() -> list[Bad]:
    """Of `golden_section`."""
    one, c = np.ones(1), np.ones((1, 3))
    return [Bad("ends in the wrong order", (c, one, 0 * one), "low, high"),
            Bad("an end that is infinite", (c, one, np.inf * one), "low, high"),
            Bad("not as many ends", (c, one, np.ones(2)), "low, high"),
            Bad("a width that no number has", (c, 0 * one, one), "tolerance", {"tolerance": 1e-17})]


def measures() -> list[Bad]:
    """Of `effort_measures`."""
    return [Bad("three frames", (np.zeros((3, 2, 3)),), "positions", {"fps": 30.0}),
            Bad("two numbers a joint", (np.zeros((6, 2, 2)),), "positions", {"fps": 30.0}),
            Bad("no frame rate", (np.zeros((5, 2, 3)),), "fps", {"fps": 0.0})]
