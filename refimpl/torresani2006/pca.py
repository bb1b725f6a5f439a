"""Principal components of joint angles (section 6), and the standardisation that precedes a fit."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..nn.arguments import check_whole
from .align import check_sequence, read_at

COMPONENTS, LENGTH = 3, 50


class RegressError(ValueError):
    """Examples that cannot be learnt from, or a model that is not there."""


@dataclass(frozen=True)
class PrincipalComponents:
    """The directions of largest variance of sequences stretched to one length.

    mean : (length D,);  basis : (components, length D), orthonormal rows;  length : in frames.
    """

    mean: np.ndarray = field(repr=False)
    basis: np.ndarray = field(repr=False)
    length: int = LENGTH


def stretched(angles: np.ndarray, length: int = LENGTH) -> np.ndarray:
    """Joint angles at a set number of frames, linearly, first on first and last on last.
    (T, D)  ->  (length, D)

    >>> stretched(np.array([[0.0], [1.0]]), 5)[:, 0]
    array([0.  , 0.25, 0.5 , 0.75, 1.  ])
    """
    return read_at(angles, np.linspace(0, len(angles) - 1, check_whole("length", length, 1)))


def fit_pca(sequences: Sequence[np.ndarray], components: int = COMPONENTS,
            length: int = LENGTH) -> PrincipalComponents:
    r"""The first right singular vectors of X - mean, a row of X for each stretched sequence.

    sequences : list of (T_i, D) in radians.
    Raises RegressError for more components than directions in which the sequences differ (at most
    one less than there are sequences) or angles that differ in number, AlignError for what is no
    sequence.

    >>> fit_pca([np.array([[0.0, angle]]) for angle in (1.0, 2.0, 6.0)], 1, length=1)
    PrincipalComponents(length=1)
    """
    sequences = [check_sequence(f"sequences[{i}]", angles) for i, angles in enumerate(sequences)]
    check_whole("length", length, 1)
    check_whole("components", components, 1)
    widths = sorted({angles.shape[1] for angles in sequences})
    if len(widths) != 1:
        raise RegressError(f"sequences: found angles a frame {widths}, needed one number for all")
    X = np.stack([stretched(angles, length).ravel() for angles in sequences])
    mean, eps = X.mean(axis=0), np.finfo(float).eps
    axes = principal_axes(X - mean, max(X.shape) * eps, np.abs(X).max() * eps)[:len(X) - 1]
    if not 1 <= components <= len(axes):
        raise RegressError(
            f"components: found {components}, needed 1 to {len(axes)}, the directions in which "
            f"these {len(X)} sequences differ; give more sequences or ask for fewer")
    return PrincipalComponents(mean, signed(axes[:components]), length)


def principal_axes(centred: np.ndarray, relative: float, absolute: float = 0.0) -> np.ndarray:
    """The right singular vectors of centred rows, largest variance first, without those whose
    singular value is not above `relative` times the largest plus `absolute`.   (N, D)  ->  (n, D)

    >>> np.abs(principal_axes(np.array([[3.0, 4.0], [-3.0, -4.0]]), 1e-9)).round(9)
    array([[0.6, 0.8]])
    """
    _, size, axes = np.linalg.svd(centred, full_matrices=False)
    return axes[:int(np.sum(size > size[0] * relative + absolute))]


def signed(basis: np.ndarray) -> np.ndarray:
    """Each row with the sign that makes its largest element positive.   (components, D)  ->  same

    Elements equal to the largest by size up to 1e-9 count as equal; the first of them decides.

    >>> signed(np.array([[-0.6, 0.6 * (1 + 1e-15)], [0.1, -0.9]]))
    array([[ 0.6, -0.6],
           [-0.1,  0.9]])
    """
    size = np.abs(basis)
    first = np.argmax(size >= (1 - 1e-9) * size.max(axis=1, keepdims=True), axis=1)[:, None]
    return basis * np.where(np.take_along_axis(basis, first, axis=1) < 0, -1.0, 1.0)


def pca_scores(pca: PrincipalComponents, angles: np.ndarray) -> np.ndarray:
    """c = basis (x - mean), the coefficients of a sequence.   (T, D) radians  ->  (components,)

    >>> pca = fit_pca([np.array([[0.0, angle]]) for angle in (1.0, 2.0, 6.0)], 1, length=1)
    >>> pca_scores(pca, np.array([[0.0, 5.0]]))
    array([2.])
    """
    return pca.basis @ (stretched(angles, pca.length).ravel() - pca.mean)


def standardisation(X: np.ndarray, least: float = 1e-12) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard deviation of each column; 1 for one whose deviation is not above `least`.
    (N, D)  ->  (D,), (D,)

    >>> standardisation(np.array([[1.0, 5.0], [3.0, 5.0]]))
    (array([2., 5.]), array([1., 1.]))
    """
    deviation = X.std(axis=0)
    return X.mean(axis=0), np.where(deviation > least, deviation, 1.0)
