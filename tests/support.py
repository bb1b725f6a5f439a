"""What the package promises about Pythons and libraries, tried. `python -m tests.support [--suite
WORDS] [--only 3.13]`

It builds the source archive and the wheel, and for each row of the matrix makes a fresh
environment, installs the wheel with those versions, and runs `refimpl check` and some commands, on
the newest libraries with warnings as errors; with --suite also pytest with these words, from the
unpacked source archive alone. The table goes to standard output: that of tests/SUPPORT.md.

Rows: the stated minima together, each minimum beside the newest of the others, and the newest of
everything on every Python that is found (pyenv's, or `pythonX.Y` on the path).
"""

import argparse
import configparser
import os
from pathlib import Path
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time

ROOT = Path(__file__).parents[1]
PYTHONS = ("3.10", "3.11", "3.12", "3.13", "3.14")
CHECK = ["-m", "refimpl", "check"]
COMMANDS = ("--version", "inspect c.bvh --json i.json", "prepare clips -o m.npz",
            "train-autoencoder m.npz -o a.npz --hidden 6 --width 9 --epochs 1 --curves k.png",
            "train-style m.npz a.npz --style old -o s.npz --channels 4 --width 9 --epochs 1",
            "transfer s.npz c.bvh -o o.bvh --plot p.png --animate a.html")
MAKE_CLIPS = """
import pathlib
from refimpl.embedded import walkers
from refimpl.motion import bvh
pathlib.Path("clips").mkdir()
for style in ("normal", "old"):
    bvh.write_bvh(f"clips/walk_{style}_0.bvh", walkers.make_clip("walk", style, seconds=4.1).clip)
bvh.write_bvh("c.bvh", walkers.make_clip("walk", "normal", seconds=2.0).clip)
"""


def minima():
    """{library: lowest version} that setup.cfg states."""
    told = configparser.ConfigParser()
    told.read(ROOT / "setup.cfg")
    return dict(re.findall(r"^(\w+)>=([\d.]+)$", told["options"]["install_requires"], re.M))


def pythons():
    """{version: path of such an interpreter} for those that are found."""
    found = {}
    for version in PYTHONS:
        places = [*sorted(Path.home().glob(f".pyenv/versions/{version}.*/bin/python")),
                  *Path.home().glob(f".local/share/uv/python/cpython-{version}.*/bin/python3")]
        place = shutil.which(f"python{version}") if not places else places[-1]
        if place:
            found[version] = str(place)
    return found


def rows(found, lowest):
    """->  list of (Python, {library: version})"""
    oldest = [PYTHONS[0]] if PYTHONS[0] in found else []         # later ones lack their wheels
    return ([(version, lowest) for version in oldest] + [(version, {}) for version in found]
            + [(version, {name: lowest[name]}) for version in oldest for name in lowest])


def run(words, folder, **more):
    """->  None when it went well, else the last line that was said"""
    done = subprocess.run([*map(str, words)], cwd=folder, capture_output=True, text=True, **more)
    said = (done.stderr.strip() or done.stdout.strip()).splitlines()
    return None if done.returncode == 0 else (said[-1] if said else f"status {done.returncode}")


def build(scratch):
    """The source archive and, from it alone, the wheel.   ->  their paths"""
    subprocess.run([sys.executable, "-m", "venv", scratch / "builder"], check=True)
    python = scratch / "builder" / "bin" / "python"
    subprocess.run([python, "-m", "pip", "install", "-q", "setuptools>=64", "wheel"], check=True)
    source = scratch / "source"
    shutil.copytree(ROOT, source, ignore=shutil.ignore_patterns(".git", "build", "__pycache__",
                                                                 "*.egg-info", ".*_cache"))

    def make(kind, folder):
        code = f"from setuptools import build_meta as b; print(b.build_{kind}({str(scratch)!r}))"
        said = subprocess.run([python, "-c", code], cwd=folder, check=True, capture_output=True,
                              text=True).stdout
        return scratch / said.split()[-1]
    archive = make("sdist", source)
    with tarfile.open(archive) as file:
        file.extractall(scratch / "unpacked", filter="data") if hasattr(
            tarfile, "data_filter") else file.extractall(scratch / "unpacked")
    unpacked, = (scratch / "unpacked").iterdir()
    return make("wheel", unpacked), unpacked


def tried(python, versions, wheel, unpacked, suite, scratch):
    """One row of the matrix.   ->  libraries as installed, {what was tried: None or what failed}"""
    place = Path(tempfile.mkdtemp(dir=scratch))
    subprocess.run([python, "-m", "venv", place / "env"], check=True)
    mine = place / "env" / "bin" / "python"
    exact = [f"{name}=={version}" for name, version in versions.items()]
    extra = f"{wheel}[test]" if suite else str(wheel)
    if why := run([mine, "-m", "pip", "install", "-q", "--only-binary", ":all:", extra, *exact],
                  place):
        return "", {"install": why}
    told = subprocess.run(
        [mine, "-c", "import numpy, scipy, matplotlib, platform; print(platform.python_version(), "
         "numpy.__version__, scipy.__version__, matplotlib.__version__)"], capture_output=True,
        text=True, cwd=place).stdout.split()
    results = {"check": run([mine, *CHECK], place), "make": run([mine, "-c", MAKE_CLIPS], place)}
    for words in COMMANDS:
        strict = [] if versions else ["-W", "error"]             # old libraries warn of new ones
        results[words.split()[0]] = run([mine, *strict, "-m", "refimpl", *words.split()], place)
    if suite:
        results["suite"] = run(
            [mine, "-m", "pytest", "-p", "no:cacheprovider", *suite.split()], unpacked,
            env={**os.environ, "PATH": f"{place / 'env' / 'bin'}:{os.environ['PATH']}"})
    shutil.rmtree(place)
    return told, results


def main():
    """Print the table.   ->  whether something failed"""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--suite", metavar="WORDS", help="also run pytest with these words")
    options.add_argument("--only", metavar="X.Y", help="on this Python alone")
    arguments, failed = options.parse_args(), False
    found = {v: p for v, p in pythons().items() if arguments.only in (None, v)}
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        wheel, unpacked = build(scratch)
        print("| Python | NumPy | SciPy | Matplotlib | what failed | seconds |\n"
              "| --- | --- | --- | --- | --- | --- |")
        for version, versions in rows(found, minima()):
            began = time.perf_counter()
            told, results = tried(found[version], versions, wheel, unpacked, arguments.suite,
                                  scratch)
            bad = "; ".join(f"{name}: {why}" for name, why in results.items() if why)
            failed |= bool(bad)
            print(f"| {' | '.join(told or [version, str(versions), '', ''])} | "
                  f"{bad or 'nothing of ' + ', '.join(results)} | "
                  f"{time.perf_counter() - began:.0f} |", flush=True)
    missing = [version for version in PYTHONS if version not in found]
    if missing and not arguments.only:
        print(f"\nNot found on this machine: Python {', '.join(missing)}.")
    return failed


if __name__ == "__main__":
    sys.exit(main())
