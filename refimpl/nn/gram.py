"""The Gram matrix, which holds the style (Gatys et al.; Holden 2017, eq. 6)."""

from .arguments import check_arrays, check_shape


def gram(h):
    r"""Gram matrix: which hidden units are active together, summed over time (Holden 2017, eq. 6).

        G[n, c, d] = sum_t h[n, c, t] h[n, d, t]

    h : (N, C, T)  ->  (N, C, C)
    """
    check_arrays(h=h, ndim={"h": 3})
    return h @ h.swapaxes(1, 2)


def gram_backward(dG, h):
    r"""h[n, c, t] stands in row c and in column c of G, hence two terms:

        dh[n, c, t] = sum_d (dG[n, c, d] + dG[n, d, c]) h[n, d, t]

    dG : (N, C, C), h : (N, C, T)  ->  (N, C, T)
    """
    check_arrays(h=h, dG=dG, ndim={"h": 3})
    check_shape("dG", dG, (len(h), h.shape[1], h.shape[1]), ", the shape of the output")
    return (dG + dG.swapaxes(1, 2)) @ h
