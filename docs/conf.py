"""Settings of the rendered pages, for Sphinx; `docs/build.py` calls it."""

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


WORDS = {path.stem: set(re.findall(r"\w+", " ".join(
    "".join(cell["source"]) for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]
    if cell["cell_type"] == "code"))) for path in sorted((ROOT / "notebooks").glob("[0-9]*.ipynb"))}


def as_written(app, what, name, obj, options, lines):
    """Our docstrings are plain text: the first sentence as a paragraph, the rest as it stands, and
    the notebooks in which the function is used."""
    text = "\n".join(lines).split("\n\n", 1)
    lines[:] = re.sub(r"([|*`_\\])", r"\\\1", text[0]).splitlines()
    if len(text) > 1 and text[1].strip():
        lines += ["", ".. code-block:: text", ""]
        lines += [*("    " + line for line in text[1].splitlines()), ""]
    examples = [stem for stem, words in WORDS.items() if getattr(obj, "__name__", "") in words]
    if what == "function" and examples:
        lines += ["", "Used in " + ", ".join(f":doc:`/notebooks/{stem}`" for stem in examples), ""]


def in_words(app, doctree):
    """A picture that a notebook draws (`pictures.plot.described`) keeps the words beside it."""
    for bundle in doctree.findall(lambda node: isinstance(node, container)
                                  and node.get("nb_element") == "mime_bundle"):
        kinds = {shown["mime_type"]: shown for shown in bundle.children}
        if {"image/png", "text/plain"} <= set(kinds):
            for picture in kinds["image/png"].findall(image):
                picture["alt"] = kinds["text/plain"].astext()


def formula(display):
    """Writes a formula as MathML, which browsers show without a network."""
    def _visit(writer, node):
        text = re.sub(r"\\big[lr]?(?![a-z])", "", node.astext()).replace(r"\arg", r"\mathrm{arg}\,")
        writer.body.append(convert(text, display=display))
        raise SkipNode
    return _visit, None


def setup(app):
    app.connect("autodoc-process-docstring", as_written)
    app.connect("doctree-read", in_words)
    if convert:
        app.add_html_math_renderer("mathml", formula("inline"), formula("block"))
