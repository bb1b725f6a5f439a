"""Mutants of the answers, under the notebooks' own checks.

    python -m tests.notebooks.mutants [--mutants 400] [--seed 0] [NN ...]

One operator, comparison, sign, number or name of an answer is changed at a time
(`tests.mutation.kit`), and the check of its notebook judges it. Prints the survivors and the share
that does not survive; which of them compute the same, a reader has to say.
"""

import argparse
import ast
import copy
import random
import resource
import signal
import sys
from unittest import mock

import numpy as np

from refimpl.exercise import trial
from tests.mutation.kit import change, places
from tests.notebooks import books, test_exercises

LIMIT, MEMORY = 20, 4 << 30                       # seconds for one check, bytes for all of them


def answers(path):
    """{exercise: the tree of its answer, with what its file says beside functions}"""
    tree = ast.parse(books.solutions(path).read_text(encoding="utf-8"))
    named = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
    others = [node for node in tree.body if node not in named.values()]
    helpers = [node for name, node in named.items() if not name.startswith("my_")]
    return {cell.exercise: ast.Module([*others, *helpers, named[cell.exercise]], [])
            for cell in books.cells(path) if cell.exercise}


def survives(path, exercise, tree):
    """Whether the check of the notebook calls a changed answer right."""
    def _late(*_):
        raise TimeoutError
    before = signal.signal(signal.SIGALRM, _late)
    signal.alarm(LIMIT)
    try:
        with mock.patch.object(trial, "_told", lambda *_: ["wrong: "]), np.errstate(all="ignore"):
            said = test_exercises.check(path, exercise, ast.unparse(tree), exercise)
        return "passed" in said and "wrong: " not in said
    except Exception:                            # it ends the cell, or does not end
        return False
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def main(argv=None):
    """Draw mutants, judge each, print those that survive and the share that does not."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("notebooks", nargs="*", metavar="NN")
    parser.add_argument("--mutants", type=int, default=400)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args(argv)
    found = [(path, exercise, n) for path in books.notebooks()
             if not arguments.notebooks or path.stem[:2] in arguments.notebooks
             for exercise, tree in answers(path).items() for n in range(len(places(tree)))]
    chosen = sorted(random.Random(arguments.seed).sample(
        range(len(found)), min(arguments.mutants, len(found))))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))     # a changed size may be any size
    alive = 0
    for number in chosen:
        path, exercise, n = found[number]
        tree = copy.deepcopy(answers(path)[exercise])
        node, what = places(tree)[n]
        before = ast.unparse(node)
        change(node, what, random.Random(f"{arguments.seed} {number}"))
        if survives(path, exercise, ast.fix_missing_locations(tree)):
            alive += 1
            print(f"{path.stem[:2]} {exercise}:{node.lineno}: {before}  ->  {ast.unparse(node)}",
                  flush=True)
    print(f"{len(chosen) - alive} of {len(chosen)} mutants refused, of {len(found)} places")
    return 0


if __name__ == "__main__":
    sys.exit(main())
