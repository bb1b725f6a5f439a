"""README and the pages of `docs` tell the truth: snippets run, commands exist, links lead
somewhere.
"""

import argparse
import doctest
from pathlib import Path
import pkgutil
import re
import subprocess
import sys

import numpy as np
import pytest

from refimpl.cli import parser
from refimpl.embedded.walkers import make_clip
from refimpl.motion import bvh

ROOT = Path(__file__).parent.parent
PAGES = {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
         for path in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md",
                      *sorted((ROOT / "docs").rglob("*.md")),
                      *sorted((ROOT / "notebooks").glob("*.md")),
                      *sorted((ROOT / "tests").rglob("*.md")))}
OURS = {name: text for name, text in PAGES.items()
        if name == "README.md" or name.startswith("docs/")}
ANNOTATED = ("docs/holden2017.md", "docs/torresani2006.md")


def blocks(text, language):
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


SNIPPETS = [pytest.param(code, id=f"{name}-{number}") for name, text in OURS.items()
            if name not in ANNOTATED for number, code in enumerate(blocks(text, "python"))]


@pytest.mark.parametrize("code", SNIPPETS)
def test_python_snippets_run(code, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    bvh.write_bvh("walk.bvh", make_clip("walk", seconds=2.0, seed=1).clip)
    for library in re.findall(r"^(?:from|import) (torch|jax)\b", code, re.MULTILINE):
        pytest.importorskip(library)
    code_object = compile(code, "snippet", "exec")
    if "network_core.npz" in code:                               # the authors' files, not ours
        code_object = compile("\n".join(re.findall(r"^from .*|^import .*", code, re.MULTILINE)),
                              "snippet", "exec")
    exec(code_object, {})


@pytest.mark.parametrize("name", [name for name in OURS if ">>> " in OURS[name]
                                  and name not in ANNOTATED])
def test_the_answers_shown_are_those_found(name):
    test = doctest.DocTestParser().get_doctest(OURS[name].replace("```", "\n"), {"np": np}, name,
                                               name, 0)
    result = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(test)
    assert result.attempted and not result.failed


def test_commands_are_those_of_the_parser():
    shown = "\n".join(block for text in OURS.values() for block in blocks(text, "sh"))
    words = set(re.findall(r"^refimpl ([a-z0-9-]+)", shown, re.MULTILINE))
    known = set(next(a for a in parser()._actions if a.choices and "demo" in a.choices).choices)
    assert words and words <= known


def commands(command):
    """A parser, and all below it."""
    yield command
    for action in command._actions:
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                yield from commands(below)


def test_options_named_are_known():
    text = "".join(command.format_help() for command in commands(parser()))
    foreign = {"--help", "--html", "--check"}                    # those of the programs in docs
    for name, page in OURS.items():
        if name not in ANNOTATED:
            for option in set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", page)) - foreign:
                assert option in text, (name, option)


def headings(name):
    """The anchors of a page, as GitHub makes them."""
    text = re.sub(r"```.*?```", "", PAGES[name], flags=re.DOTALL)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
            for title in re.findall(r"^#+ (.*)$", text, re.MULTILINE)}


@pytest.mark.parametrize("name", PAGES)
def test_links_lead_somewhere(name):
    page = ROOT / name
    for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"```.*?```", "", PAGES[name],
                                                        flags=re.DOTALL)):
        if re.match(r"[a-z]+:", target):
            continue
        file, _, place = target.partition("#")
        found = (page.parent / file).resolve() if file else page
        assert found.exists(), target
        if place:
            assert place in headings(found.relative_to(ROOT).as_posix()), target


def test_pictures_have_words_for_who_cannot_see_them():
    for name, text in PAGES.items():
        assert not re.findall(r"!\[\s*\]", text), name


def test_functions_of_the_map_exist():
    for dotted in set(re.findall(r"`((?:motion|nn|holden2017|torresani2006)[\w.]*)`",
                                 PAGES["README.md"])):
        assert pkgutil.resolve_name(f"refimpl.{dotted}"), dotted


def test_readme_is_of_one_screens_depth():
    assert len(re.sub(r"```.*?```", "", PAGES["README.md"], flags=re.DOTALL).split()) <= 1000


def test_every_page_is_reached_from_readme():
    reached, to_do = set(), ["README.md"]
    while to_do:
        name = to_do.pop()
        if name in PAGES and name not in reached:
            reached.add(name)
            for target in re.findall(r"\]\(([^)#\s]+)", PAGES[name]):
                found = (ROOT / name).parent.joinpath(target).resolve()
                if found.is_relative_to(ROOT):
                    to_do.append(found.relative_to(ROOT).as_posix())
    assert [name for name in OURS if name not in reached] == []


def test_annotated_papers_are_as_written_from_the_code():
    found = subprocess.run([sys.executable, "docs/annotate.py", "--check"], cwd=ROOT,
                           capture_output=True, text=True, env={"PYTHONPATH": str(ROOT)})
    assert found.returncode == 0, f"{found.stdout}{found.stderr}; python docs/annotate.py mends it"


@pytest.mark.parametrize("name, equations, others",
                         [("docs/holden2017.md", 10, ("Figure 1", "Figure 2", "Figure 3",
                                                      "Figure 4", "Table 1")),
                          ("docs/torresani2006.md", 12, ("Figure 1", "Table 1"))])
def test_each_equation_table_and_figure_has_its_place(name, equations, others):
    titles = re.findall(r"^## ((?:Equation|Figure|Table) \d+):", PAGES[name], re.MULTILINE)
    assert sorted(titles) == sorted([f"Equation {n}" for n in range(1, equations + 1)]
                                    + list(others))
    assert name in "".join(f"docs/{t}" if t in ("holden2017.md", "torresani2006.md") else t
                           for t in re.findall(r"\]\(([^)]+)\)", PAGES["README.md"]))


def test_the_package_page_leads_nowhere_that_is_not_there():
    """It is shown beside no other file: neither pictures nor links of the repository."""
    page = (ROOT / "PACKAGE.md").read_text(encoding="utf-8")
    assert not re.findall(r"\]\((?!https?://)", page) and "<img" not in page
    assert "long_description = file: PACKAGE.md" in (ROOT / "setup.cfg").read_text()
