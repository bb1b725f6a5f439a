"""Builds the pages to read in a browser: README, docs, notebooks with their outputs, and the API.

    pip install ".[docs]"
    python docs/build.py SITE                    # an empty folder, or one that this wrote
    python docs/build.py SITE --no-run           # notebooks without outputs, in a minute

Open SITE/index.html.
"""

import argparse
from pathlib import Path
import shutil
import subprocess
import sys

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = ("docs", "notebooks", "tests", "refimpl")
FILES = ("CONTRIBUTING.md", "CHANGELOG.md", "LICENSE", "CITATION.cff")
PARTS = {
    "Begin": ("docs/gallery", "docs/your_own_clips", "docs/bodies",
              "docs/perceptual_styles"),
    "The papers": ("docs/holden2017", "docs/torresani2006", "docs/code_of_2016", "docs/departures"),
    "Notebooks": ("notebooks/README", *(f"notebooks/{path.stem}" for path in
                                        sorted((ROOT / "notebooks").glob("[0-9]*.ipynb")))),
    "Measured": ("docs/results", "docs/paper_problem", "docs/recipe", "docs/torresani",
                 "docs/score", "docs/speed"),
    "Your own implementation": ("docs/kit", "docs/conventions"),
    "The house": ("CONTRIBUTING", "CHANGELOG", "api/index"),
}


def contents(parts):
    """The first page: README, and for the side of all pages the table of contents of each part."""
    lines = [(ROOT / "README.md").read_text(encoding="utf-8")]
    for title, pages in parts.items():
        lines += ["```{toctree}", f":caption: {title}", ":hidden:", ":maxdepth: 1", "", *pages,
                  "```", ""]
    return "\n".join(lines)


def rest(parts):
    """Pages that no part names, so that none is lost."""
    named = {page for pages in parts.values() for page in pages}
    found = [path.relative_to(ROOT).with_suffix("").as_posix() for folder in ("docs", "tests")
             for path in sorted((ROOT / folder).rglob("*.md")) if path.parent.name != "conventions"]
    return [page for page in found if page not in named]


ROOMS = ("nn", "gradcheck", "motion", "embedded", "holden2017", "holden2016", "torresani2006",
         "fast", "styles", "conformance", "experiments", "pictures")


def modules():
    """{room: its modules' dotted names}; of the kit what its users call, not what it is made of."""
    return {room: [f"refimpl.{room}"] if room == "conformance" else
            [f"refimpl.{room}.{path.stem}"
             for path in sorted((ROOT / "refimpl" / room).glob("*.py"))
             if path.stem not in ("__init__", "peer_torch", "peer_onnx")] for room in ROOMS}


def api(folder):
    """A page a room, in which Sphinx writes what the docstrings say."""
    folder.mkdir()
    rooms = modules()
    for room, names in rooms.items():
        lines = [f"# {room}", ""]
        for name in names:
            lines += [f"## {name}", "", "```{eval-rst}", f".. automodule:: {name}", "   :members:",
                      *(["   :imported-members:"] if room == "conformance" else []), "```", ""]
        (folder / f"{room}.md").write_text("\n".join(lines), encoding="utf-8")
    (folder / "index.md").write_text("\n".join(
        ["# API", "", "```{toctree}", ":maxdepth: 1", "", *rooms, "```", ""]), encoding="utf-8")


def stage(folder):
    """A folder that Sphinx reads: the tree's own files by links, and the pages made here."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name in FOLDERS:
        shutil.copytree(ROOT / name, folder / name, symlinks=True, ignore=shutil.ignore_patterns(
            "__pycache__", "wrong", ".ipynb_checkpoints"))
    for name in FILES:
        shutil.copy(ROOT / name, folder / name)
    api(folder / "api")
    with open(folder / "docs" / "conventions.md", "a", encoding="utf-8") as file:
        file.write("\n```{toctree}\n:hidden:\n:glob:\n\nconventions/*\n```\n")
    (folder / "index.md").write_text(contents({**PARTS, "How it is tested": rest(PARTS)}),
                                     encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("site", type=Path)
    parser.add_argument("--no-run", action="store_true", help="do not run the notebooks")
    args = parser.parse_args()
    site = args.site.resolve()
    if site.exists() and any(site.iterdir()) and not (site / "index.html").exists():
        parser.error(f"{args.site} holds other files; name an empty folder")
    source = site.with_name(site.name + ".source")
    stage(source)
    run = ["-D", "nb_execution_mode=off"] if args.no_run else []
    code = subprocess.run([sys.executable, "-m", "sphinx", "-q", "-b", "html", "-c",
                           str(ROOT / "docs"), *run, str(source), str(site)]).returncode
    shutil.rmtree(source)
    return code


if __name__ == "__main__":
    sys.exit(main())
