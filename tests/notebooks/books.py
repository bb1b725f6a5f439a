"""The notebooks as the tests see them: cells with tags, and the files that belong to each.

    python -m tests.notebooks.books notebooks/03_*.ipynb

writes them without outputs and in the form that is stored.
"""

import ast
from dataclasses import dataclass
import json
from pathlib import Path
import sys

FOLDER = Path(__file__).parents[2] / "notebooks"
ORDER = ("00_start_here", "01_read_a_motion", "02_the_66_numbers",
         "03_convolution_and_its_gradient", "04_pooling_and_kinks", "05_check_a_gradient",
         "06_gram_matrix_and_style", "07_motion_constraints", "08_adam", "09_train_the_manifold",
         "10_style_by_optimisation_2016", "11_fast_style_2017", "12_plant_the_feet",
         "13_fast_convolution", "14_align_and_interpolate", "15_learn_effort",
         "16_segment_and_synthesise", "17_check_your_own_backend", "18_your_own_system")
METADATA = {"kernelspec": {"display_name": "Python 3 (ipykernel)", "language": "python",
                           "name": "python3"}, "language_info": {"name": "python"}}


@dataclass(frozen=True)
class Cell:
    """kind : "code" or "markdown";  exercise, check : the name in such a tag, or "";  aside : no
    later cell needs it.
    """

    kind: str
    source: str
    tags: tuple

    def tagged(self, kind):
        return next((tag.partition(":")[2] for tag in self.tags if tag.startswith(kind + ":")), "")

    @property
    def exercise(self):
        return self.tagged("exercise")

    @property
    def check(self):
        return self.tagged("check")

    @property
    def aside(self):
        return "aside" in self.tags


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


def cells(path):
    return [Cell(cell["cell_type"], "".join(cell["source"]),
                 tuple(cell["metadata"].get("tags", ()))) for cell in read(path)["cells"]]


def notebooks():
    return sorted(FOLDER.glob("*.ipynb"))


def solutions(path):
    """The file with the answers to a notebook's exercises."""
    return path.parent / "solutions" / f"{path.stem}.py"


def wrong(path):
    """The file with wrong answers, functions `exercise__what_is_wrong`."""
    return Path(__file__).parent / "wrong" / f"{path.stem[:2]}.py"


def functions(path):
    """Names of the functions that a file defines, in order."""
    return [node.name for node in ast.parse(path.read_text(encoding="utf-8")).body
            if isinstance(node, ast.FunctionDef)]


def stored(book):
    """The text of a notebook as it is kept: no outputs, no counts, nothing of an editor's."""
    kept = []
    for cell in book["cells"]:
        tags = cell.get("metadata", {}).get("tags", [])
        plain = {"cell_type": cell["cell_type"], "id": cell["id"],
                 "metadata": {"tags": tags} if tags else {}}
        if cell["cell_type"] == "code":
            plain |= {"execution_count": None, "outputs": []}
        kept.append(dict(sorted((plain
                                 | {"source": "".join(cell["source"]).splitlines(
                                     keepends=True)}).items())))
    clean = {"cells": kept, "metadata": METADATA, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(clean, indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    for name in sys.argv[1:]:
        Path(name).write_text(stored(read(Path(name))), encoding="utf-8")
