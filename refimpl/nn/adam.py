r"""Adam (Kingma and Ba 2014) on plain dicts of arrays."""

import numpy as np

from .arguments import check_arrays, check_shape

VARIANTS = ("kingma-ba", "epsilon-hat", "no-bias-correction")


def adam_start(params):
    """The state before the first step: t = 0, both moments zero.   params : {name: array}  ->  dict of t, m, v"""
    for name, p in params.items():
        check_arrays(**{f"params[{name!r}]": p}, real=True)
    return {"t": 0, "m": {k: np.zeros_like(p) for k, p in params.items()}, "v": {k: np.zeros_like(p) for k, p in params.items()}}


def adam_step(params, gradients, state, *, rate=1e-3, beta1=0.9, beta2=0.999, epsilon=1e-8, variant="kingma-ba"):
    r"""One step of algorithm 1:

        t <- t + 1
        m <- beta1 m + (1 - beta1) g                        mean of the gradients
        v <- beta2 v + (1 - beta2) g^2                      mean of their squares
        p <- p - rate * m_hat / (sqrt(v_hat) + epsilon),    m_hat = m / (1 - beta1^t),  v_hat = v / (1 - beta2^t)

    variant "epsilon-hat" adds epsilon before the correction, p <- p - rate sqrt(1 - beta2^t) / (1 - beta1^t) m / (sqrt(v) + epsilon), as the
    paper proposes below its algorithm; "no-bias-correction" takes m_hat = m, v_hat = v.
    params, gradients : dicts with the same keys and shapes;  state : of `adam_start` or of the step before
    ->  new params, new state; the arguments are left as they were
    """
    _check(params, gradients, state, variant, rate=rate, beta1=beta1, beta2=beta2, epsilon=epsilon)
    rate, beta1, beta2, epsilon = map(float, (rate, beta1, beta2, epsilon))  # of no precision of their own: float32 stays float32
    t = state["t"] + 1
    m = {k: beta1 * state["m"][k] + (1 - beta1) * g for k, g in gradients.items()}
    v = {k: beta2 * state["v"][k] + (1 - beta2) * (g * g) for k, g in gradients.items()}
    corrected = variant != "no-bias-correction"
    c1, c2 = (1 - beta1 ** t, 1 - beta2 ** t) if corrected else (1.0, 1.0)
    if variant == "epsilon-hat":
        step = {k: rate * float(np.sqrt(c2)) / c1 * (m[k] / (np.sqrt(v[k]) + epsilon)) for k in params}
    else:
        step = {k: rate * ((m[k] / c1) / (np.sqrt(v[k] / c2) + epsilon)) for k in params}
    return {k: p - step[k] for k, p in params.items()}, {"t": t, "m": m, "v": v}


def adam_update(params, gradients, state, *, rate=1e-3, beta1=0.9, beta2=0.999, epsilon=1e-8):
    r"""`adam_step` in place: params and state become what `adam_step` would return, to the last bit. For long training: it allocates nothing
    large, and goes through the arrays in pieces that stay in the processor's cache."""
    _check(params, gradients, state, "kingma-ba", rate=rate, beta1=beta1, beta2=beta2, epsilon=epsilon)
    rate, beta1, beta2, epsilon = map(float, (rate, beta1, beta2, epsilon))
    state["t"] += 1
    c1, c2 = 1 - beta1 ** state["t"], 1 - beta2 ** state["t"]
    for name, p in params.items():
        for p, g, m, v in _pieces(p, gradients[name], state["m"][name], state["v"][name]):
            m *= beta1
            m += (1 - beta1) * g
            v *= beta2
            v += (1 - beta2) * (g * g)
            p -= rate * ((m / c1) / (np.sqrt(v / c2) + epsilon))


def _pieces(p, *others, size=1 << 14):
    """Flat views of pieces of arrays that lie in memory alike; where they do not, views along the first axis."""
    if p.ndim and all(a.T.flags.c_contiguous for a in (p, *others)):
        p, *others = (a.T.ravel() for a in (p, *others))
    elif p.ndim and all(a.flags.c_contiguous for a in (p, *others)):
        p, *others = (a.ravel() for a in (p, *others))
    else:
        return [(p[...], *(a[...] for a in others))]
    return [[a[i:i + size] for a in (p, *others)] for i in range(0, p.size, size)]


def _check(params, gradients, state, variant, **numbers):
    if variant not in VARIANTS:
        raise ValueError(f"variant: found {variant!r}, needed one of {', '.join(VARIANTS)}")
    for name, number in numbers.items():
        if isinstance(number, (bool, np.bool_)) or not isinstance(number, (int, float)) or not number >= 0 or (name[:4] == "beta" and number >= 1):
            raise ValueError(f"{name}: found {number!r}, needed a Python number from 0 {'to below 1' if name[:4] == 'beta' else 'on'}")
    if not isinstance(state, dict) or set(state) != {"t", "m", "v"}:
        raise ValueError(f"state: found {sorted(state) if isinstance(state, dict) else type(state).__name__}, needed t, m and v; "
                         "begin with adam_start(params)")
    for what, other in (("gradients", gradients), ("state['m']", state["m"]), ("state['v']", state["v"])):
        if set(other) != set(params):
            raise ValueError(f"{what}: found {sorted(other)}, needed the keys of params, {sorted(params)}")
        for name, p in params.items():
            check_arrays(**{f"params[{name!r}]": p, f"{what}[{name!r}]": other[name]}, real=True)
            check_shape(f"{what}[{name!r}]", other[name], p.shape, ", the shape of the parameter")
