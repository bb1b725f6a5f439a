"""Rooms that open when somebody looks in: `import refimpl` loads nothing, and dotted names work."""

from collections.abc import Callable, Iterable
import importlib
import pkgutil
import sys
from typing import Any


def opened(package: str, more: Iterable[str] = ()) -> tuple[Callable[[str], Any], Callable]:
    """`__getattr__` and `__dir__` of a package, which load its modules when they are asked for.

    package : its name, loaded;  more : names of the module `front` in it that stand beside them

    >>> opened("refimpl")[0]("motion").__name__
    'refimpl.motion'
    """
    module = sys.modules[package]

    def names() -> list[str]:
        return [found.name for found in pkgutil.iter_modules(module.__path__)
                if not found.name.startswith("_")]

    def load(name: str) -> Any:
        if name in more:
            return getattr(importlib.import_module(f"{package}.front"), name)
        if name.startswith("_") or name not in names():
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return importlib.import_module(f"{package}.{name}")

    return load, lambda: sorted({*vars(module), *names(), *more})
