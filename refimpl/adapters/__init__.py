"""Doors for other libraries: `refimpl.adapters.torch` and `refimpl.adapters.jax` make a backend of
somebody's functions, with gradients by the library's own differentiation.

Nothing in the package imports them; who has the library does.
"""

from ..lazy import opened

__getattr__, __dir__ = opened(__name__)
