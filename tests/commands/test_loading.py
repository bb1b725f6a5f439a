"""A command loads what it needs when it is typed, and is the same as among all of them."""

import json
import subprocess
import sys

import pytest

from refimpl.cli import COMMANDS, parser

LOADED = """
import contextlib, io, json, sys
from refimpl.cli import main, parser
words = json.loads(sys.argv[1])
with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
    parser() if words is None else main(words)
print(json.dumps(sorted(sys.modules)))
"""


def loaded(words):
    """Names of the modules that are there after a command, of all commands for None."""
    found = subprocess.run([sys.executable, "-c", LOADED, json.dumps(words)], check=True,
                           capture_output=True, text=True)
    return json.loads(found.stdout)


def test_help_loads_less_than_half_of_what_there_is():
    for words in (["--help"], ["--version"], []):
        found = loaded(words)
        assert 2 * len(found) < len(loaded(None)) and "scipy" not in found
    assert not [name for name in loaded(["inspect", "--help"]) if name.startswith((
        "refimpl.conformance", "refimpl.experiments", "refimpl.fast", "refimpl.commands.check"))]


def below(command):
    return next(a for a in command._actions if a.choices and "demo" in a.choices).choices


def test_the_table_has_every_command_in_its_order():
    assert list(below(parser())) == list(COMMANDS) == list(below(parser([])))


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_alone_is_the_same(name):
    alone, among_all = parser(["--ignored", name, "word"]), parser()
    assert below(alone)[name].format_help() == below(among_all)[name].format_help()
    assert alone.format_help() == among_all.format_help()
