"""Imports point in one direction, and Matplotlib is needed for pictures alone."""

import ast
from pathlib import Path
import subprocess
import sys

import pytest

import refimpl

ROOT = Path(refimpl.__file__).parent
# What each room may import from refimpl, besides itself. Rooms are folders or modules directly
# below refimpl/.
MAY_IMPORT = {
    "storage": set(),
    "nn": set(),
    "gradcheck": set(),
    "motion": {"storage"},
    "embedded": {"motion"},
    "holden2017": {"storage", "nn", "motion", "embedded"},
    "holden2016": {"storage", "nn", "motion", "embedded", "holden2017"},
    "torresani2006": {"storage", "nn", "motion", "embedded"},
    "fast": {"nn", "holden2017"},
    "styles": {"storage", "motion", "embedded", "holden2017", "fast"},
    "conformance": {"storage", "nn", "gradcheck", "motion", "holden2017", "holden2016",
                    "torresani2006"},
    "adapters": {"conformance"},
    "experiments": {"storage", "nn", "motion", "embedded", "holden2017", "holden2016",
                    "torresani2006", "fast", "styles"},
    "pictures": {"storage", "motion"},
    "exercise": {"nn", "gradcheck"},
    "commands": {"storage", "nn", "gradcheck", "motion", "embedded", "holden2017", "holden2016",
                 "torresani2006", "fast", "styles", "conformance", "experiments", "pictures"},
    "lazy": set(),
    "front": {"motion", "holden2017", "fast", "styles", "pictures"},
    "blas": set(),
    "cli": {"commands", "blas", "storage"},
    "__main__": {"cli"},
    "__init__": {"front"},
}


def imported_rooms(path):
    """Rooms of refimpl that a file imports, and the names of other packages."""
    inside, outside = set(), set()
    depth = len(path.relative_to(ROOT).parts)
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level:
            if node.level == depth:                              # up to refimpl itself
                inside |= ({node.module.split(".")[0]} if node.module
                           else {alias.name for alias in node.names})
            elif node.level > depth:
                raise AssertionError(f"{path}: imports from above refimpl")
        elif isinstance(node, ast.ImportFrom):
            outside.add(node.module.split(".")[0])
        elif isinstance(node, ast.Import):
            outside |= {alias.name.split(".")[0] for alias in node.names}
    return inside, outside


FILES = sorted(ROOT.rglob("*.py"))


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_imports_point_downwards(path):
    room = path.relative_to(ROOT).parts[0].removesuffix(".py")
    inside, outside = imported_rooms(path)
    assert inside - {room, "lazy", "__version__"} <= MAY_IMPORT[room]
    allowed = (set(sys.stdlib_module_names) | {"numpy", "scipy"}
               | ({"matplotlib"} if room == "pictures" else set()))
    # imported by `refimpl bench` alone, where these are installed
    if path.name in ("peer_torch.py", "peer_onnx.py"):
        allowed |= {"torch"} if path.name == "peer_torch.py" else {"onnx", "onnxruntime"}
    # imported by nobody here, but by who has the library
    if room == "adapters":
        allowed |= {path.stem}
    # imported by `parametrize` when it is called, inside somebody's tests
    if path.name == "cases.py":
        allowed |= {"pytest"}
    assert outside <= allowed


def test_two_levels_and_short_files():
    for path in FILES:
        assert len(path.relative_to(ROOT).parts) <= 2, f"{path}: two levels, never three"
        assert path.stem not in ("utils", "helpers", "common", "misc")
        assert len(path.read_text().splitlines()) <= 320, f"{path}: longer than a reader likes"


def test_no_library_of_others_is_imported():
    """Nothing in the package imports the adapters, so nothing needs what they need."""
    elsewhere = ("refimpl.adapters.torch", "refimpl.adapters.jax", "refimpl.__main__",
                 "refimpl.experiments.peer_torch", "refimpl.experiments.peer_onnx")
    code = ("import importlib, pkgutil, sys\n"
            "sys.modules.update(dict.fromkeys(['torch', 'jax', 'pytest']))\n"
            "import refimpl\n"
            "for m in pkgutil.walk_packages(refimpl.__path__, 'refimpl.'):\n"
            f"    m.name in {elsewhere} or importlib.import_module(m.name)\n"
            "assert not {'refimpl.adapters.torch', 'refimpl.adapters.jax'} & set(sys.modules)")
    subprocess.run([sys.executable, "-c", code], check=True)


def test_no_matplotlib_without_pictures():
    code = ("import sys; sys.modules['matplotlib'] = None\n"
            "import refimpl, refimpl.nn, refimpl.cli, refimpl.motion.body, "
            "refimpl.holden2017.train, refimpl.holden2017.transfer")
    subprocess.run([sys.executable, "-c", code], check=True)
