"""Settings of the rendered pages, for Sphinx; `docs/build.py` calls it."""

import inspect
import json
from pathlib import Path
import re
import sys

from docutils.nodes import SkipNode, container, image
try:
    from latex2mathml.converter import convert
except ImportError:                          # then formulas need the network, for MathJax
    convert = None

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

project = "refimpl"
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.viewcode"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_timeout = 600
nb_execution_raise_on_error = True
nb_merge_streams = True
autodoc_typehints = "none"
autodoc_member_order = "bysource"
html_math_renderer = "mathml" if convert else "mathjax"
html_theme = "furo"
html_title = "refimpl"
html_copy_source = False
html_show_copyright = False
html_static_path = ["static"]
html_css_files = ["wide.css"]
suppress_warnings = ["myst.xref_missing", "myst.header"]


def words(text):
    return set(re.findall(r"\w+", text))


NOTEBOOKS = {path.stem: words(" ".join("".join(cell["source"]) for cell in json.loads(
    path.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"))
    for path in sorted((ROOT / "notebooks").glob("[0-9]*.ipynb"))}
FILES = {path.relative_to(ROOT).as_posix(): words(path.read_text(encoding="utf-8"))
         for folder in ("refimpl", "tests") for path in sorted((ROOT / folder).rglob("*.py"))
         if "wrong" not in path.parts}


def examples(function):
    """Where a function is used: in notebooks or, where none has it, in two files at most of the
    package and of its tests. What uses it names its module or its room, too."""
    name, (room, module) = function.__name__, ["", *function.__module__.split(".")][-2:]
    used = [f":doc:`/notebooks/{stem}`" for stem, found in NOTEBOOKS.items()
            if name in found and found & {room, module}]
    for folder in () if used else ("refimpl/", "tests/"):
        paths = [path for path, found in FILES.items() if path.startswith(folder) and name in found
                 and (module in found or path.startswith(f"refimpl/{room}/"))
                 and path != f"refimpl/{room}/{module}.py"]
        used += [f":download:`{path} </{path}>`" for path in paths[:2]]
    return used


def as_written(app, what, name, obj, options, lines):
    """Our docstrings are plain text: the first sentence as a paragraph, the rest as it stands, and
    where the function is used."""
    text = "\n".join(lines).split("\n\n", 1)
    lines[:] = re.sub(r"([|*`_\\])", r"\\\1", text[0]).splitlines()
    if len(text) > 1 and text[1].strip():
        lines += ["", ".. code-block:: text", ""]
        lines += [*("    " + line for line in text[1].splitlines()), ""]
    used = examples(obj) if inspect.isfunction(obj) else []
    if used:
        lines += ["", "Used in " + ", ".join(used), ""]


def in_words(app, doctree):
    """A picture that a notebook draws (`pictures.plot.described`) keeps the words beside it."""
    for bundle in doctree.findall(lambda node: isinstance(node, container)
                                  and node.get("nb_element") == "mime_bundle"):
        kinds = {shown["mime_type"]: shown for shown in bundle.children}
        if {"image/png", "text/plain"} <= set(kinds):
            for picture in kinds["image/png"].findall(image):
                picture["alt"] = kinds["text/plain"].astext()


# Browsers do not know the lengths with which the converter spaces an arrow's label.
LABELLED_ARROW = (r'<mstyle scriptlevel="0"><mo>&#x2192;</mo></mstyle>'
                  r'<mpadded [^>]*>(.*?)<mspace depth="\.25em" /></mpadded>',
                  r'<mo stretchy="true">&#x2192;</mo>\1')


def formula(display):
    """Writes a formula as MathML, which browsers show without a network."""
    def _visit(writer, node):
        text = re.sub(r"\\big[lr]?(?![a-z])", "", node.astext()).replace(r"\arg", r"\mathrm{arg}\,")
        writer.body.append(re.sub(*LABELLED_ARROW, convert(text, display=display)))
        raise SkipNode
    return _visit, None


def setup(app):
    app.connect("autodoc-process-docstring", as_written)
    app.connect("doctree-read", in_words)
    if convert:
        app.add_html_math_renderer("mathml", formula("inline"), formula("block"))
