r"""Adam (Kingma and Ba 2014) on plain dicts of arrays."""

from collections.abc import Mapping
import sys
from typing import Any

import numpy as np

from .arguments import check_arrays, check_whole

VARIANTS = ("kingma-ba", "epsilon-hat", "no-bias-correction")
# a count that a float holds exactly
LARGEST_COUNT = 2 ** 53

Arrays = Mapping[str, np.ndarray]


def adam_start(params: Arrays) -> dict[str, Any]:
    """The state before the first step: t = 0, and both moments zero.

    params : {name: array}  ->  dict of t, m, v;   raises ValueError for what is no real array

    >>> adam_start({"w": np.ones(2)})
    {'t': 0, 'm': {'w': array([0., 0.])}, 'v': {'w': array([0., 0.])}}
    """
    for name, p in dict[str, Any](params).items():
        check_arrays(**{f"params[{name!r}]": p}, real=True, exact=False)
    zeros = [{name: np.zeros_like(p) for name, p in params.items()} for _ in "mv"]
    return {"t": 0, "m": zeros[0], "v": zeros[1]}


def adam_step(params: Arrays, gradients: Arrays, state: Mapping[str, Any], *, rate: float = 1e-3,
              beta1: float = 0.9, beta2: float = 0.999, epsilon: float = 1e-8,
              variant: str = "kingma-ba") -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    r"""One step of algorithm 1:

        t <- t + 1
        m <- beta1 m + (1 - beta1) g                        mean of the gradients
        v <- beta2 v + (1 - beta2) g^2                      mean of their squares
        p <- p - rate * m_hat / (sqrt(v_hat) + epsilon),
             m_hat = m / (1 - beta1^t),  v_hat = v / (1 - beta2^t)

    g^2 is multiplied from the left and the root taken before the correction, so that the largest
    gradients do not overflow on the way: in float32 up to 5e20 instead of 2e19.

    params, gradients : dicts with the same keys and shapes
    state : of `adam_start` or of the step before
    variant : "epsilon-hat" adds epsilon before the correction, p <- p - rate sqrt(1 - beta2^t) /
    (1 - beta1^t) m / (sqrt(v) + epsilon), as the paper proposes below its algorithm;
    "no-bias-correction" takes m_hat = m, v_hat = v
    ->  new params, new state; the arguments are left as they were, and the new arrays lie in memory
    as they do
    Raises ValueError for other keys, shapes, precisions, numbers, or a count of steps that is none.

    >>> params = {"w": np.array([1.0])}
    >>> new, state = adam_step(params, {"w": np.array([5.0])}, adam_start(params), rate=0.1)
    >>> new["w"].round(6), state["t"]
    (array([0.9]), 1)
    """
    _check(params, gradients, state, variant, rate=rate, beta1=beta1, beta2=beta2, epsilon=epsilon)
    # Python's numbers have no precision of their own: float32 stays float32.
    rate, beta1, beta2, epsilon = map(float, (rate, beta1, beta2, epsilon))
    t = int(state["t"]) + 1
    m = {k: beta1 * state["m"][k] + (1 - beta1) * g for k, g in gradients.items()}
    v = {k: beta2 * state["v"][k] + ((1 - beta2) * g) * g for k, g in gradients.items()}
    corrected = variant != "no-bias-correction"
    c1, c2 = (1 - beta1 ** t, (1 - beta2 ** t) ** 0.5) if corrected else (1.0, 1.0)
    if variant == "epsilon-hat":
        step = {k: rate * c2 / c1 * (m[k] / (np.sqrt(v[k]) + epsilon)) for k in params}
    else:
        step = {k: rate * ((m[k] / c1) / (np.sqrt(v[k]) / c2 + epsilon)) for k in params}
    return {k: p - step[k] for k, p in params.items()}, {"t": t, "m": m, "v": v}


def annealed(rate: float, epoch: int, epochs: int) -> float:
    """The learning rate of an epoch (from 1): constant in the first half, then falling in a
    straight line to nearly 0.

    Norms that are not squared pull equally hard near their minimum; with a constant rate the
    weights would tremble there to the end.

    >>> [annealed(1.0, epoch, 4) for epoch in (1, 2, 3, 4)]
    [1.0, 1.0, 0.75, 0.25]
    """
    return rate * min(1.0, 2.0 * (1.0 - (epoch - 0.5) / epochs))


def _check(params, gradients, state, variant, **numbers):
    if variant not in VARIANTS:
        raise ValueError(f"variant: found {variant!r}, needed one of {', '.join(VARIANTS)}")
    for name, number in numbers.items():
        below = 1 if name in ("beta1", "beta2") else np.inf
        if (isinstance(number, bool) or not isinstance(number, (int, float))
                or not 0 <= number < below or number > sys.float_info.max):
            raise ValueError(f"{name}: found {number!r:.60}, needed a Python number from 0 "
                             f"{'to below 1' if below == 1 else 'on'}")
    _check_keys("state", state, ("t", "m", "v"), "t, m and v; begin with adam_start(params)")
    check_whole("state['t']", state["t"], 0, LARGEST_COUNT)
    for what, other in (("gradients", gradients), ("state['m']", state["m"]),
                        ("state['v']", state["v"])):
        _check_keys(what, other, params, f"the keys of params, {sorted(params)}")
        for name, p in params.items():
            check_arrays(**{f"params[{name!r}]": p, f"{what}[{name!r}]": other[name]}, real=True,
                         exact=False, shape=p, because=", the shape of the parameter")


def _check_keys(what, found, keys, needed):
    if not isinstance(found, Mapping) or set(found) != set(keys):
        keys = sorted(found) if isinstance(found, Mapping) else type(found).__name__
        raise ValueError(f"{what}: found {keys}, needed {needed}")
