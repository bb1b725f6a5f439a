r"""What every backward must keep, whatever it computes.

Inputs and upstream gradient are read and left as they were, to the last bit; the gradient has its
input's shape and type and memory of its own; it is the same bits on every call, whatever was
computed in between; it is linear in the upstream gradient; and it does not depend on how the arrays
lie in memory.
"""

import numpy as np

from .errors import GradientError

LINEAR, LAYOUT = 1e-12, 1e-12                                    # relative to the largest element


def check_contract(f, f_backward, *inputs, names=None, seed=0, batched=None, single=False):
    """Check all of it.

    f, f_backward, inputs, names : as for `check_gradient`;  batched : indices of the inputs whose
    first axis is the batch, to try a batch of 0 clips;  single : also try float32 (not for
    functions that hold float64 arrays of their own).   Raises GradientError.
    """
    names = names or tuple(f"input {i}" for i in range(len(inputs)))
    rng = np.random.default_rng([seed, 3])
    _left_alone("f", f, inputs, names)
    y = np.asarray(f(*inputs))
    dy = rng.standard_normal(y.shape).astype(y.dtype)
    _left_alone("f_backward", f_backward, (dy, *inputs), ("the upstream gradient", *names))
    gradients = _gradients(f_backward, dy, inputs)
    _own_memory(gradients, dy, inputs, names)
    _types(gradients, inputs, names)
    _repeatable(f, f_backward, dy, inputs, names, rng)
    _linear(f_backward, dy, inputs, names, gradients, rng)
    _spread_upstream(f_backward, y, inputs, names)
    _layouts(f, f_backward, dy, inputs, names, gradients)
    if single:
        small = [x.astype(np.float32) if _is_float(x) else x for x in inputs]
        _types(_gradients(f_backward,
                          np.asarray(f(*small)).astype(np.float32), small), small, names)
    if batched:
        _empty_batch(f, f_backward, inputs, names, batched)


def _is_float(x):
    return isinstance(x, np.ndarray) and x.dtype.kind == "f"


def _gradients(f_backward, dy, inputs):
    """{input: gradient} of the inputs that have one."""
    gradients = f_backward(dy, *inputs)
    gradients = gradients if isinstance(gradients, (tuple, list)) else (gradients,)
    chosen = [i for i, x in enumerate(inputs) if _is_float(x)]
    if len(gradients) == len(inputs):
        return {i: gradients[i] for i in chosen}
    return dict(zip(chosen, gradients))


def _left_alone(what, function, arguments, names):
    """Neither writeable nor read-only arguments may change."""
    for writeable in (True, False):
        copies = [x.copy() if isinstance(x, np.ndarray) else x for x in arguments]
        for copy in copies:
            if isinstance(copy, np.ndarray):
                copy.flags.writeable = writeable
        try:
            function(*copies)
        except ValueError as error:
            if "read-only" in str(error):
                raise GradientError(
                    f"{what}: tried to write to a read-only argument ({error}); inputs are only to "
                    "be read"
                ) from None
            raise
        for name, before, after in zip(names, arguments, copies):
            if isinstance(before, np.ndarray) and not _same_bits(before, after):
                where = np.argwhere(~((before == after) | ((before != before) & (after != after))))
                raise GradientError(
                    f"{what}: changed {name} at "
                    f"{where[0].tolist() if len(where) else 'a sign bit'}; inputs are only to be "
                    "read")


def _own_memory(gradients, dy, inputs, names):
    """No memory shared with an argument or another gradient, and writeable: the caller may add to
    it in place.
    """
    others = [("the upstream gradient", dy)] + [
        (name, x) for name, x in zip(names, inputs) if isinstance(x, np.ndarray)]
    for i, gradient in gradients.items():
        if not isinstance(gradient, np.ndarray):
            continue
        if not gradient.flags.writeable:
            raise GradientError(
                f"{names[i]}: found a read-only gradient (np.broadcast_to?), needed memory of its "
                "own")
        for name, other in others:
            if np.shares_memory(gradient, other):
                raise GradientError(
                    f"{names[i]}: its gradient shares memory with {name}, needed memory of its own")
        others.append((f"the gradient of {names[i]}", gradient))


def _types(gradients, inputs, names):
    for i, gradient in gradients.items():
        found = np.asarray(gradient)
        if found.shape != inputs[i].shape or found.dtype != inputs[i].dtype:
            raise GradientError(
                f"{names[i]}: found a gradient {found.dtype} {found.shape}, needed "
                f"{inputs[i].dtype} {inputs[i].shape}, as its input")


def _repeatable(f, f_backward, dy, inputs, names, rng):
    """Again, after other upstream gradients and other inputs: a hidden state, a stale cache or a
    buffer used twice would show.
    """
    first = _gradients(f_backward, dy, inputs)
    kept = {i: np.array(gradient) for i, gradient in first.items()}
    again = _gradients(f_backward, dy, inputs)
    _same_gradients(kept, again, names, "on a second call with the same arguments")
    f_backward(rng.standard_normal(dy.shape).astype(dy.dtype), *inputs)
    _same_gradients(kept, first, names,
                    "later in the array of the first call (a buffer used twice?)")
    _same_gradients(kept, _gradients(f_backward, dy, inputs), names,
                    "after a call with another upstream gradient")
    # the same numbers elsewhere: still where f is defined
    others = [np.flip(x).copy() if _is_float(x) else x for x in inputs]
    try:
        other_dy = rng.standard_normal(np.shape(f(*others))).astype(dy.dtype)
        f_backward(other_dy, *others)
        f(*others)
    except ValueError:
        # f takes special inputs only
        return
    _same_gradients(kept, _gradients(f_backward, dy, inputs), names,
                    "after calls with other inputs")


def _same_gradients(needed, found, names, when):
    for i, gradient in found.items():
        if not _same_bits(needed[i], gradient):
            raise GradientError(f"{names[i]}: found another gradient {when}; needed the same bits")


def _linear(f_backward, dy, inputs, names, gradients, rng):
    other = rng.standard_normal(dy.shape).astype(dy.dtype)
    a, b = 1.7, -0.6
    second, mixed = _gradients(f_backward, other,
                               inputs), _gradients(f_backward,
                                                   (a * dy + b * other).astype(dy.dtype), inputs)
    for i, gradient in gradients.items():
        expected = a * gradient + b * second[i]
        size = max(np.abs(a * gradient).max(initial=0.0), np.abs(b * second[i]).max(initial=0.0))
        if not np.abs(mixed[i]
                      - expected).max(initial=0.0) <= LINEAR * max(size,
                                                                   np.finfo(float).tiny):
            raise GradientError(
                f"{names[i]}: its gradient is not linear in the upstream gradient "
                f"(off by {np.abs(mixed[i] - expected).max():.3g} at a size of {size:.3g})")


def _spread_upstream(f_backward, y, inputs, names):
    """An upstream gradient of stride 0, as a sum's backward makes it with np.broadcast_to, is as
    good as any.
    """
    spread = np.broadcast_to(y.dtype.type(0.7), y.shape)
    needed = _gradients(f_backward, spread.copy(), inputs)
    for i, gradient in _gradients(f_backward, spread, inputs).items():
        if not _close(gradient, needed[i]):
            raise GradientError(
                f"{names[i]}: found another gradient for an upstream gradient of stride 0 "
                "(np.broadcast_to)")


def _reversed(x):
    """The same array, its memory running backwards."""
    return np.flip(np.ascontiguousarray(np.flip(x)))


LAYOUTS = {
    "Fortran order": np.asfortranarray,
    "every second element of a larger array": lambda x: _spread_out(x)[
        (slice(None, None, 2),) * x.ndim], "negative strides": _reversed, }


def _spread_out(x):
    large = np.full(tuple(2 * n for n in x.shape), np.nan, x.dtype)
    large[(slice(None, None, 2),) * x.ndim] = x
    return large


def _layouts(f, f_backward, dy, inputs, names, gradients):
    """Other strides, the same numbers: values and gradients must not change (beyond the order of a
    sum).
    """
    y = np.asarray(f(*inputs))
    for layout, lay in LAYOUTS.items():
        arrays = [lay(x) if _is_float(x) and x.ndim else x for x in inputs]
        if not _close(np.asarray(f(*arrays)), y):
            raise GradientError(f"f: found another value for inputs in {layout}")
        for i, gradient in _gradients(f_backward, lay(dy) if dy.ndim else dy, arrays).items():
            if not _close(gradient, gradients[i]):
                raise GradientError(
                    f"{names[i]}: found another gradient for inputs and upstream gradient in "
                    f"{layout}")


def _empty_batch(f, f_backward, inputs, names, batched):
    empty = [x[:0] if i in batched else x for i, x in enumerate(inputs)]
    y = np.asarray(f(*empty))
    gradients = _gradients(f_backward, np.zeros_like(y), empty)
    for i, gradient in gradients.items():
        if np.shape(gradient) != empty[i].shape or np.any(gradient):
            raise GradientError(
                f"{names[i]}: for a batch of 0 clips found a gradient of shape "
                f"{np.shape(gradient)}, needed zeros of {empty[i].shape}")


def _close(found, needed):
    return np.abs(found - needed).max(
        initial=0.0) <= LAYOUT * max(np.abs(needed).max(initial=0.0),
                                     np.finfo(float).tiny)


def _same_bits(a, b):
    a, b = np.asarray(a), np.asarray(b)
    return a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes()
