"""Settings of the rendered pages, for Sphinx; `docs/build.py` calls it."""

from pathlib import Path
import re
import sys

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

project = "refimpl"
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.viewcode"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_timeout = 600
nb_execution_raise_on_error = True
nb_merge_streams = True
autodoc_typehints = "none"
autodoc_mock_imports = ["hypothesis"]        # an optional package of the kit
autodoc_member_order = "bysource"
html_theme = "furo"
html_title = "refimpl"
html_copy_source = False
html_static_path = ["static"]
html_css_files = ["wide.css"]
suppress_warnings = ["myst.xref_missing", "myst.header"]


def as_written(app, what, name, obj, options, lines):
    """Our docstrings are plain text: the first sentence as a paragraph, the rest as it stands."""
    text = "\n".join(lines).split("\n\n", 1)
    lines[:] = re.sub(r"([|*`_\\])", r"\\\1", text[0]).splitlines()
    if len(text) > 1 and text[1].strip():
        lines += ["", ".. code-block:: text", "", *("    " + line for line in text[1].splitlines()), ""]


def setup(app):
    app.connect("autodoc-process-docstring", as_written)
