"""Curves that begin and end gently: from rest to rest, up and back again, and from what is known
into what is not.
"""

from typing import Any

import numpy as np


def ease(u: Any) -> np.ndarray:
    r"""From 0 to 1 with zero velocity and acceleration at both ends: `6 u^5 - 15 u^4 + 10 u^3`,
    constant outside [0, 1].

    >>> ease([-1, 0, 0.25, 0.5, 1, 2]).round(4)
    array([0.    , 0.    , 0.1035, 0.5   , 1.    , 1.    ])
    """
    u = np.clip(u, 0.0, 1.0)
    return u ** 3 * (10.0 + u * (6.0 * u - 15.0))


def glide(u: Any) -> np.ndarray:
    r"""From 0 to 1 with zero velocity at both ends: `3 u^2 - 2 u^3`, constant outside [0, 1].

    It arrives later than `ease`, so that a swinging foot does not wait, out of the hips' reach, for
    its landing.

    >>> glide([-1, 0, 0.25, 0.5, 1, 2]).round(4)
    array([0.    , 0.    , 0.1562, 0.5   , 1.    , 1.    ])
    """
    u = np.clip(u, 0.0, 1.0)
    return u * u * (3.0 - 2.0 * u)


def bump(u: Any) -> np.ndarray:
    r"""From 0 up to 1 at u = 1/2 and back to 0: `64 u^3 (1 - u)^3`, zero outside [0, 1].

    >>> bump([-1, 0, 0.25, 0.5, 1, 2]).round(4)
    array([0.    , 0.    , 0.4219, 1.    , 0.    , 0.    ])
    """
    u = np.clip(u, 0.0, 1.0)
    return (4.0 * u * (1.0 - u)) ** 3


def blended(values: np.ndarray, known: np.ndarray, frames: int) -> np.ndarray:
    r"""Values where they are known; elsewhere those of the nearest known frames on both sides, each
    fading to 0 by `1 - 3 x^2 + 2 x^3`.

    x is the distance to that frame over `frames` + 1, or over the gap between the two where this is
    shorter: there the two weights add up to 1.

    values : (T, D), known : (T,) bool  ->  (T, D)

    >>> blended(np.full((7, 1), 8.0), np.array([1, 0, 0, 0, 0, 0, 0], bool), 3)[:, 0]
    array([8.  , 6.75, 4.  , 1.25, 0.  , 0.  , 0.  ])
    """
    at = np.flatnonzero(known)
    out = np.where(known[:, None], values, 0.0)
    if not len(at):
        return out
    t = np.arange(len(known))
    after = np.searchsorted(at, t)                   # the first known frame at or after t
    previous = at[np.maximum(after - 1, 0)]
    following = at[np.minimum(after, len(at) - 1)]
    between = (after > 0) & (after < len(at))
    reach = np.minimum(np.where(between, following - previous, frames + 1), frames + 1)
    for source, there in ((previous, after > 0), (following, after < len(at))):
        x = np.clip(np.abs(t - source) / np.maximum(reach, 1), 0.0, 1.0)
        weight = np.where(~known & there, 1 - 3 * x ** 2 + 2 * x ** 3, 0.0)[:, None]
        out += weight * np.where(weight > 0, values[source], 0.0)
    return out


def softened(asked: np.ndarray, free: np.ndarray, far: np.ndarray) -> np.ndarray:
    """How far a leg reaches that is asked to reach so far: the same as long as it is free, then
    ever less, and never all of `far`.   three of (T,)  ->  (T,)

    >>> softened(np.array([9.0, 9.7, 10.0, 12.0]), np.full(4, 9.7), np.full(4, 10.0)).round(2)
    array([ 9.  ,  9.7 ,  9.89, 10.  ])
    """
    room = np.maximum(far - free, 1e-9 * far)
    beyond = np.maximum(asked - free, 0.0)
    return np.where(beyond > 0, far - room * np.exp(-beyond / room), asked)
