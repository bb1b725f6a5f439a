"""The README tells the truth: its snippets run, its commands exist, its links lead somewhere."""

import argparse
from pathlib import Path
import re

import pytest

from refimpl.cli import parser

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


@pytest.mark.parametrize("code", blocks("python"))
def test_python_snippets_run(code):
    for library in re.findall(r"^(?:from|import) (torch|jax)\b", code, re.MULTILINE):
        pytest.importorskip(library)
    exec(compile(code, "README.md", "exec"), {})


def test_commands_are_those_of_the_parser():
    words = set(re.findall(r"^refimpl ([a-z0-9-]+)", "\n".join(blocks("sh")), re.MULTILINE))
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
    for option in set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", README)):
        assert option in text or option == "--help", option


def test_links_and_pictures_are_there():
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        if not target.startswith("http"):
            assert (ROOT / target).exists(), target


def test_functions_of_the_map_exist():
    import importlib
    for dotted in set(re.findall(r"`((?:motion|nn|holden2017|torresani2006)[\w.]*)`", README)):
        parts = dotted.split(".")
        for cut in range(len(parts), 0, -1):
            try:
                found = importlib.import_module(".".join(["refimpl", *parts[:cut]]))
            except ImportError:
                continue
            for name in parts[cut:]:
                found = getattr(found, name)
            break
        else:
            raise AssertionError(dotted)
