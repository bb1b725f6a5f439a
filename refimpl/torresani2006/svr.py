r"""Epsilon-insensitive support vector regression, its dual solved by hand (Drucker et al. 1997;
Platt's sequential minimal optimisation).

The function is f(z) = sum_n beta_n k(z_n, z) + b. Errors up to epsilon are free. The dual, with
beta = a - a* of the textbooks, is

    minimise    D(beta) = 1/2 beta^T K beta - y^T beta + epsilon sum_n |beta_n|
    subject to  sum_n beta_n = 0,  -C_n <= beta_n <= C_n

C_n = 0 takes example n out, so that one kernel matrix serves all folds of a cross-validation.
"""

import numpy as np

KKT_TOLERANCE = 1e-6
MOST_STEPS = 200_000


class SVRError(ValueError):
    """A problem that cannot be, or one that did not come to an end."""


def dual_objective(K: np.ndarray, y: np.ndarray, beta: np.ndarray, epsilon: float) -> float:
    """D(beta), to be minimised.   K : (n, n), y, beta : (n,)

    >>> dual_objective(np.eye(2), np.array([3.0, 1.0]), np.array([1.0, -1.0]), 0.5)
    0.0
    """
    return float(0.5 * beta @ K @ beta - y @ beta + epsilon * np.abs(beta).sum())


def slopes(residual: np.ndarray, beta: np.ndarray, C: np.ndarray,
           epsilon: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    r"""How fast -D grows when one beta_n rises, and how fast it falls when one sinks; inf where the
    box forbids it. With the residual r = y - K beta:

        up_n  = r_n - epsilon if beta_n >= 0,  r_n + epsilon if beta_n < 0
        low_n = r_n - epsilon if beta_n > 0,   r_n + epsilon if beta_n <= 0

    all (..., n)  ->  up (-inf where beta_n = C_n), low (+inf where beta_n = -C_n)

    >>> slopes(np.array([2.0, 0.0]), np.array([1.0, 0.0]), np.array([1.0, 1.0]), 0.5)
    (array([-inf, -0.5]), array([1.5, 0.5]))
    """
    up = np.where(beta < C, residual - np.where(beta >= 0, epsilon, -epsilon), -np.inf)
    low = np.where(beta > -C, residual - np.where(beta > 0, epsilon, -epsilon), np.inf)
    return up, low


def kkt_violation(K: np.ndarray, y: np.ndarray, beta: np.ndarray, C: float | np.ndarray,
                  epsilon: float) -> float:
    r"""How far beta is from the Karush-Kuhn-Tucker conditions, 0 at the solution:

        max_n up_n <= b <= min_n low_n   for some b;   the excess is  max up - min low

    The largest breach of the box and that of sum beta = 0 are added.
    K : (n, n), y, beta : (n,), C : a number or (n,)

    >>> kkt_violation(np.eye(2), np.array([3.0, 1.0]), np.array([0.5, -0.5]), 1.0, 0.5)
    0.0
    """
    C = np.broadcast_to(np.asarray(C, dtype=float), beta.shape)
    up, low = slopes(y - K @ beta, beta, C, epsilon)
    excess = up.max() - low.min() if np.isfinite(up.max()) and np.isfinite(low.min()) else 0.0
    return float(max(excess, 0.0) + max((np.abs(beta) - C).max(), 0.0) + abs(beta.sum()))


def fit_svr(K: np.ndarray, y: np.ndarray, C: float | np.ndarray, epsilon: float | np.ndarray, *,
            kernel: np.ndarray | None = None, tolerance: float = KKT_TOLERANCE,
            steps: int = MOST_STEPS) -> tuple[np.ndarray, np.ndarray]:
    r"""Solve B problems side by side, two betas of each at a time.

    i is the example that most wants to rise. Of those j that want to sink, the one with the largest
    promised gain (up_i - low_j)^2 / eta, eta = K_ii + K_jj - 2 K_ij. Then beta_i += t, beta_j -= t
    (the sum stays 0) with

        t = min( (up_i - low_j) / eta,  room of i,  room of j ),

    the room ending at the box and at beta = 0, where the slope of |beta| jumps. Done when max up -
    min low < tolerance.

    K : (G, n, n) kernel matrices;  y : (B, n);  C : broadcastable to (B, n), 0 leaves an example
    out;  epsilon : (B,) or a number;  kernel : (B,) which matrix each problem has, the first unless
    given   ->  beta (B, n), b (B,).
    Raises SVRError for shapes or constants that cannot be, or when `steps` were not enough.

    >>> K = np.array([[[0.0, 0.0], [0.0, 1.0]]])             # z z' for the examples z = 0 and z = 1
    >>> beta, b = fit_svr(K, np.array([[0.0, 2.0]]), 10.0, 0.5)
    >>> predict_svr(K[0], beta[0], b[0])
    array([0.5, 1.5])
    """
    y, K = np.asarray(y, dtype=float), np.asarray(K, dtype=float)
    if y.ndim != 2 or K.ndim != 3 or K.shape[1:] != (y.shape[1],) * 2:
        raise SVRError(f"K, y: found shapes {K.shape} and {y.shape}, needed (G, n, n) and (B, n)")
    if not (np.isfinite(K).all() and np.isfinite(y).all()):
        raise SVRError("K, y: found numbers that are not finite, needed finite ones")
    B, n = y.shape
    C = np.broadcast_to(np.asarray(C, dtype=float), (B, n))
    epsilon = np.broadcast_to(np.asarray(epsilon, dtype=float), (B,))
    kernel = np.zeros(B, dtype=int) if kernel is None else np.asarray(kernel)
    if not ((C >= 0).all() and (C.max(axis=1) > 0).all() and (epsilon >= 0).all()
            and np.isfinite(C).all()):
        raise SVRError(f"C, epsilon: found {C.min():g} to {C.max():g} and {epsilon.min():g} to "
                       f"{epsilon.max():g}, needed C > 0, epsilon >= 0")
    beta_out, b_out = np.zeros((B, n)), np.zeros(B)
    todo = np.arange(B)
    beta, residual, box, eps = np.zeros((B, n)), y.copy(), C, epsilon[:, None]
    diagonal = K[:, np.arange(n), np.arange(n)]
    for _ in range(steps):
        rows = np.arange(len(todo))
        up, low = slopes(residual, beta, box, eps)
        i = up.argmax(axis=1)
        top, bottom = up[rows, i], low.min(axis=1)
        done = ~(top - bottom >= tolerance)
        if done.any():
            beta_out[todo[done]], b_out[todo[done]] = beta[done], 0.5 * (top + bottom)[done]
            keep = ~done
            todo, beta, residual, box, eps = (a[keep] for a in (todo, beta, residual, box, eps))
            if not len(todo):
                return beta_out, b_out
            rows, i, top, low = np.arange(len(todo)), i[keep], top[keep], low[keep]
        which = kernel[todo]
        row_i = K[which, i]
        eta = np.maximum(diagonal[which] + diagonal[which, i][:, None] - 2 * row_i, 1e-12)
        want = np.maximum(top[:, None] - low, 0.0)           # top is finite, low +inf at most
        j = (want * want / eta).argmax(axis=1)
        beta_i, beta_j, C_i, C_j = beta[rows, i], beta[rows, j], box[rows, i], box[rows, j]
        end_i, end_j = np.where(beta_i >= 0, C_i, 0.0), np.where(beta_j > 0, 0.0, -C_j)
        room_i, room_j = end_i - beta_i, beta_j - end_j
        t = np.minimum(want[rows, j] / eta[rows, j], np.minimum(room_i, room_j))
        beta[rows, i] = np.where(t >= room_i, end_i, beta_i + t)
        beta[rows, j] = np.where(t >= room_j, end_j, beta_j - t)
        residual -= t[:, None] * (row_i - K[which, j])
    raise SVRError(f"found {len(todo)} of {B} problems not at their end after {steps} steps, "
                   f"needed max up - min low below {tolerance:g}; scale the inputs, or take a "
                   "smaller C or a larger tolerance")


def predict_svr(K: np.ndarray, beta: np.ndarray, b: float) -> np.ndarray:
    """f(z) = sum_n beta_n k(z_n, z) + b.   K : (M, n) new against training, beta : (n,)  ->  (M,)

    >>> predict_svr(np.array([[1.0, 2.0]]), np.array([3.0, -3.0]), 0.5)
    array([-2.5])
    """
    return K @ beta + b
