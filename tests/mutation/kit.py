"""Random mutants of the text of operations and losses, under the conformance kit alone.

    python -m tests.mutation.kit [--mutants 362] [--seed 0] [--only 3,17]

One operator, number or name is changed at a time, anywhere in the text of a module, whether a case
runs the line or not. The package is imported once more with the change, its functions are offered
as a backend, and the kit with its own reference stays as it is. Prints the survivors and the share
that does not survive.
"""

import argparse
import ast
import copy
from importlib import abc, import_module, util
import os
from pathlib import Path
import random
import signal
import sys

import numpy as np

import refimpl
from refimpl.conformance import OPERATIONS, Backend, cases, judge
from tests.mutation.coverage import lines_run, statement_of

MODULES = {"nn": "activation adam arguments conv gram norms pool sums",
           "holden2017": "losses networks objective",
           "holden2016": "losses network rows search",
           "torresani2006": "align observe pca poses regress segment svr synthesise",
           "motion": "features ground rotation windows"}
SWAPS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
         ast.FloorDiv: ast.Mult, ast.Mod: ast.FloorDiv, ast.MatMult: ast.Mult, ast.Pow: ast.Mult,
         ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
         ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.And: ast.Or, ast.Or: ast.And,
         ast.In: ast.NotIn, ast.NotIn: ast.In, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd}
LIMIT = 60                                                       # seconds for one case
NAMES = {"max": "min", "min": "max", "sum": "mean", "maximum": "minimum", "minimum": "maximum",
         "argmax": "argmin", "zeros": "ones", "zeros_like": "ones_like", "sqrt": "abs",
         "isnan": "isinf"}


def places(tree):
    """(node, what) of all that can be changed; what an annotation says computes nothing."""
    for node in ast.walk(tree):
        for name in ("annotation", "returns"):
            if getattr(node, name, None) is not None:
                setattr(node, name, None if not isinstance(node, ast.AnnAssign)
                        else ast.Name("object", ast.Load()))
    found = []
    for node in ast.walk(tree):
        if isinstance(node, (ast.BinOp, ast.AugAssign, ast.BoolOp)) and type(node.op) in SWAPS:
            found.append((node, "operator"))
        elif isinstance(node, ast.Compare) and type(node.ops[0]) in SWAPS:
            found.append((node, "comparison"))
        elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
            found.append((node, "number"))
        elif isinstance(node, ast.UnaryOp):
            found.append((node, "sign"))
        elif isinstance(node, ast.Attribute) and node.attr in NAMES:
            found.append((node, "name"))
    return [(node, what) for node, what in found if hasattr(node, "lineno")]


def change(node, what, rng):
    """Change a node where it stands."""
    if what == "operator":
        node.op = SWAPS[type(node.op)]()
    elif what == "comparison":
        node.ops[0] = SWAPS[type(node.ops[0])]()
    elif what == "number":
        node.value = node.value + rng.choice((1, -1))
    elif what == "name":
        node.attr = NAMES[node.attr]
    else:
        node.op = {ast.USub: ast.UAdd, ast.UAdd: ast.USub, ast.Not: ast.UAdd,
                   ast.Invert: ast.UAdd}[type(node.op)]()


class Changed(abc.MetaPathFinder, abc.Loader):
    """Imports one module with another text, everything else as ever."""

    def __init__(self, name, path, tree):
        self.name, self.path, self.tree = name, path, tree

    def find_spec(self, name, path=None, target=None):
        return util.spec_from_loader(name, self, origin=self.path) if name == self.name else None

    def exec_module(self, module):
        module.__file__ = self.path
        exec(compile(ast.fix_missing_locations(self.tree), self.path, "exec"), vars(module))


def changed_functions(name, path, tree):
    """What the whole package offers when one of its modules has another text.   ->  {name: f}"""
    finder = Changed(name, path, tree)
    kept = {key: sys.modules.pop(key) for key in list(sys.modules) if key.startswith("refimpl")}
    sys.meta_path.insert(0, finder)
    try:
        return dict(import_module("refimpl.conformance.backend").reference().functions)
    finally:
        sys.meta_path.remove(finder)
        for key in [key for key in sys.modules if key.startswith("refimpl")]:
            del sys.modules[key]
        sys.modules.update(kept)


def convicted(name, path, tree, chosen):
    """The first of the chosen cases that tells a changed module, "" where none does."""
    try:
        functions = changed_functions(name, path, tree)
    except Exception as error:
        return f"does not load: {error}"
    mine = Backend(functions, name="refimpl")            # whose refusals have to name the argument
    for case in chosen:
        signal.alarm(LIMIT)
        if judge(case, mine).status == "failed":
            return case.id
    return ""


def in_a_child(*arguments):
    """What `convicted` says; a mutant may spoil the memory, or never end."""
    read, write = os.pipe()
    child = os.fork()
    if not child:
        signal.alarm(LIMIT)
        try:
            with np.errstate(all="ignore"):
                os.write(write, convicted(*arguments).encode()[:1000])
        except BaseException as error:
            os.write(write, f"spoils the judge: {error}".encode()[:1000])
        os._exit(0)
    os.close(write)
    with os.fdopen(read, "rb") as file:
        told = file.read().decode()
    _, status = os.waitpid(child, 0)
    return told or (f"ends its process ({status})" if status else "")


def drawn(count, seed):
    """So many of all places in the modules.   ->  list of (module, path, number of the place)"""
    root, found = Path(refimpl.__file__).parent, []
    for room, names in MODULES.items():
        for name in names.split():
            path = root / room / f"{name}.py"
            number = len(places(ast.parse(path.read_text())))
            found += [(f"refimpl.{room}.{name}", path, n) for n in range(number)]
    total = len(found)
    random.Random(seed).shuffle(found)
    return found[:count], total


def main(argv=None):
    """Draw mutants, judge each, print those that survive and the share that does not."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mutants", type=int, default=362)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="", metavar="N,N", help="numbers of mutants among these")
    arguments = parser.parse_args(argv)
    chosen, total = drawn(arguments.mutants, arguments.seed)
    only = [int(n) for n in arguments.only.split(",") if n] or range(len(chosen))
    kit = {name: cases(operations=[name]) for name in OPERATIONS}
    run = {name: lines_run(kit[name]) for name in kit}
    module, path, _ = chosen[0]                                  # as it is, but imported so
    told = in_a_child(module, str(path), ast.parse(path.read_text()), sum(kit.values(), []))
    if told:
        raise SystemExit(f"the unchanged text is convicted: {told}")
    survivors, untouched = 0, 0
    for n in only:
        module, path, number = chosen[n]
        tree = ast.parse(path.read_text())
        node, what = places(tree)[number]
        before = ast.unparse(copy.deepcopy(node))
        change(node, what, random.Random(f"{arguments.seed} {n}"))
        lines = statement_of(tree, node)
        asked = [name for name in kit if lines is None or any(
            (str(path), line) in run[name] for line in lines)]
        told = in_a_child(module, str(path), tree, [c for name in asked for c in kit[name]])
        if not told:
            survivors, untouched = survivors + 1, untouched + (not asked)
            print(f"{n}: {module}:{node.lineno}: {before}  ->  {ast.unparse(node)}"
                  + ("" if asked else "   (no case runs this line)"), flush=True)
    print(f"{len(only) - survivors} of {len(only)} mutants convicted, of {total} places; "
          f"{untouched} of the {survivors} that survive stand where no case runs")
    return 0


if __name__ == "__main__":
    sys.exit(main())
