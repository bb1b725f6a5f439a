"""One letter, one meaning: the table of notebooks/README.md, and the formulas of the notebooks."""

import re

import pytest

from . import books

BOOKS = pytest.mark.parametrize("path", books.notebooks(), ids=lambda path: path.stem)
GREEK = ("alpha|beta|gamma|delta|Delta|varepsilon|epsilon|eta|theta|lambda|mu|rho|sigma|varphi|"
         "psi|Psi|Phi|omega|ell|pi")
# d before an array is its gradient; Im and Re, R of real numbers, a transpose and words are none
NONE = (r"\\mathrm\{?\s*d\}?|\\math(?:bb|sf|rm)\s*\{?[A-Za-z]+\}?|\\begin\{array\}\{[lrc]*\}|"
        r"\\(?:text|operatorname\*?|begin|end)\s*\{[^{}]*\}|e(?=\^)")


def formulas(text):
    text = re.sub(r"```.*?```|`[^`]*`", "", text, flags=re.DOTALL)
    return [a or b for a, b in re.findall(r"\$\$(.*?)\$\$|\$([^$]+?)\$", text, flags=re.DOTALL)]


def letters(path):
    """The letters in the formulas of a notebook; a Greek one by its command."""
    found = set()
    for cell in books.cells(path):
        for formula in formulas(cell.source) if cell.kind == "markdown" else ():
            formula = re.sub(NONE, " ", formula)
            found |= set(re.findall(rf"\\(?:{GREEK})(?![a-zA-Z])", formula))
            found |= set(re.findall("[A-Za-z]", re.sub(r"\\[a-zA-Z]+\*?", " ", formula)))
    return found


def table():
    """{letter: [(meaning, numbers of the notebooks in which it holds, none for all others)]}"""
    text = (books.FOLDER / "README.md").read_text(encoding="utf-8")
    part = text.partition("## Letters")[2].partition("\n## ")[0]
    rows = {}
    for letter, meanings in re.findall(r"^\| \$([^$]+)\$ \| (.+) \|$", part, re.MULTILINE):
        assert letter not in rows, f"{letter} has two rows"
        rows[letter] = []
        for meaning in meanings.split("; "):
            words, _, numbers = meaning.removesuffix(")").rpartition(" (")
            known = re.fullmatch(r"[\d, ]+", numbers)
            rows[letter].append((words if known else meaning,
                                 set(numbers.split(", ")) if known else set()))
    return rows


@BOOKS
def test_each_letter_has_one_meaning_in_a_notebook(path):
    known, number = table(), path.stem[:2]
    for letter in sorted(letters(path)):
        here = [words for words, numbers in known.get(letter, ()) if number in numbers] or [
            words for words, numbers in known.get(letter, ()) if not numbers]
        assert len(here) == 1, f"{letter} in {number}: found {here or 'no row'}, needed one meaning"


def test_no_row_is_for_a_letter_that_is_not_used():
    used = {path.stem[:2]: letters(path) for path in books.notebooks()}
    for letter, meanings in table().items():
        everywhere = {number for number, found in used.items() if letter in found}
        named = set().union(*(numbers for _, numbers in meanings))
        assert named <= everywhere, f"{letter} is not in {sorted(named - everywhere)}"
        assert everywhere - named or all(numbers for _, numbers in meanings), (
            f"{letter}: no notebook is left for the meaning without numbers")
