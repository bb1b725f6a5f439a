"""The Gram matrix, which holds the style (Gatys et al.)."""

import numpy as np

from .arguments import check_arrays, check_shape


def gram(h: np.ndarray) -> np.ndarray:
    r"""Which hidden units are active together, summed over time (Holden 2017, Equation 6).

        G[n, c, d] = sum_t h[n, c, t] h[n, d, t]

    h : (N, C, T)  ->  (N, C, C)

    >>> gram(np.array([[[1.0, 2.0], [0.0, 3.0]]]))
    array([[[5., 6.],
            [6., 9.]]])
    """
    check_arrays(h=h, ndim={"h": 3})
    return h @ h.swapaxes(1, 2)


def gram_backward(dG: np.ndarray, h: np.ndarray) -> np.ndarray:
    r"""h[n, c, t] stands in row c and in column c of G, hence two terms:

        dh[n, c, t] = sum_d (dG[n, c, d] + dG[n, d, c]) h[n, d, t]

    dG : (N, C, C), h : (N, C, T)  ->  (N, C, T)

    >>> gram_backward(np.array([[[1.0, 0.0], [0.0, 0.0]]]), np.array([[[1.0, 2.0], [0.0, 3.0]]]))
    array([[[2., 4.],
            [0., 0.]]])
    """
    check_arrays(h=h, dG=dG, ndim={"h": 3})
    check_shape("dG", dG, h.shape[:2] + h.shape[1:2], ", the shape of the output")
    return (dG + dG.swapaxes(1, 2)) @ h
