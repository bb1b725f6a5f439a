"""Random mutants of the operations' and losses' text, under the conformance kit alone.

    python -m tests.mutation.kit [--mutants 200] [--seed 0]

One operator, number or name is changed at a time, on a line that some case of the kit runs; the
module with the change is offered as a backend, function by function, and the reference stays as it
is. Prints the survivors. A mutant that answers every call like the reference may be equivalent.
"""

import argparse
import ast
import copy
import importlib
import os
from pathlib import Path
import random
import signal
import sys
import types

import numpy as np

import refimpl
from refimpl.conformance import OPERATIONS, Backend, cases, judge_all, reference

MODULES = ("nn.activation", "nn.adam", "nn.conv", "nn.gram", "nn.norms", "nn.pool",
           "holden2017.losses", "holden2016.losses", "conformance.operations_nn")
SWAPS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult,
         ast.FloorDiv: ast.Mult, ast.Mod: ast.FloorDiv, ast.MatMult: ast.Mult, ast.Pow: ast.Mult,
         ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
         ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.And: ast.Or, ast.Or: ast.And,
         ast.In: ast.NotIn, ast.NotIn: ast.In, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd}
LIMIT = 300                                                      # seconds for one mutant
NAMES = {"max": "min", "min": "max", "sum": "mean", "maximum": "minimum", "minimum": "maximum",
         "argmax": "argmin", "zeros": "ones", "zeros_like": "ones_like", "sqrt": "abs",
         "isnan": "isinf"}


def places(tree):
    """(node, what) of all that can be changed inside of functions."""
    found = []
    for function in ast.walk(tree):
        if not isinstance(function, ast.FunctionDef):
            continue
        for node in ast.walk(ast.Module(body=function.body, type_ignores=[])):
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


def lines_run(module, path):
    """Lines of a file that the small profile runs by way of its own functions.   ->  set of int"""
    run = set()

    def _trace(frame, event, argument):
        if frame.f_code.co_filename != path:
            return None
        run.add(frame.f_lineno)
        return _trace
    chosen = [case for case in cases(operations=operations_of(module), profile="small")
              if is_of(module, reference().functions[case.function])]
    sys.settrace(_trace)
    for case in chosen:
        try:
            case.call(reference())
        except Exception:
            pass
    sys.settrace(None)
    return run


def is_of(module, function):
    """Whether it is the module's own, and no form of it made for the kit."""
    return function is not None and getattr(module, function.__name__, None) is function


def operations_of(module):
    """Operations with a function of the module."""
    return [name for name, operation in OPERATIONS.items()
            if any(is_of(module, f) for f in (operation.f, operation.backward) if f)]


def mutated(module, tree):
    """The module with another text.   ->  namespace"""
    twin = types.ModuleType(module.__name__)
    twin.__package__, twin.__file__ = module.__package__, module.__file__
    sys.modules[module.__name__], kept = twin, sys.modules[module.__name__]
    try:
        exec(compile(ast.fix_missing_locations(tree), module.__file__, "exec"), vars(twin))
    finally:
        sys.modules[module.__name__] = kept
    return vars(twin)


def convicted(module, tree):
    """The first case that tells a changed module, "" where none does."""
    try:
        changed = mutated(module, tree)
    except Exception as error:
        return f"does not load: {error}"
    backend = dict(reference().functions)
    for name in operations_of(module):
        for function in (name, f"{name}_backward"):
            original = backend.get(function)
            if is_of(module, original):
                backend[function] = changed[original.__name__]
    mine = Backend(backend, name="refimpl")              # whose refusals have to name the argument
    for name in operations_of(module):
        for profile in ("small", "core"):
            for outcome in judge_all(mine, cases(operations=[name], profile=profile)):
                if outcome.status == "failed":
                    return outcome.case.id
    return ""


def in_a_child(judge, module, tree):
    """What `judge` says; a mutant may spoil the memory, or never end."""
    read, write = os.pipe()
    child = os.fork()
    if not child:
        signal.alarm(LIMIT)
        try:
            with np.errstate(all="ignore"):
                os.write(write, judge(module, tree).encode()[:1000])
        except BaseException as error:
            os.write(write, f"spoils the judge: {error}".encode()[:1000])
        os._exit(0)
    os.close(write)
    with os.fdopen(read, "rb") as file:
        told = file.read().decode()
    _, status = os.waitpid(child, 0)
    return told or (f"ends its process ({status})" if status else "")


def main(argv=None):
    """Draw mutants, judge each, print those that survive and the share that does not."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mutants", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args(argv)
    rng, drawn = random.Random(arguments.seed), []
    for name in MODULES:
        module = importlib.import_module(f"refimpl.{name}")
        path = str(Path(refimpl.__file__).parent / f"{name.replace('.', '/')}.py")
        text = Path(path).read_text()
        run = lines_run(module, path)
        drawn += [(module, text, number) for number, (node, _) in enumerate(places(ast.parse(text)))
                  if node.lineno in run]
    rng.shuffle(drawn)
    survivors, judged = [], 0
    for module, text, number in drawn[:arguments.mutants]:
        tree = ast.parse(text)
        node, what = places(tree)[number]
        before = ast.unparse(copy.deepcopy(node))
        change(node, what, rng)
        judged += 1
        told = in_a_child(convicted, module, tree)
        if not told:
            survivors.append(f"{module.__name__}:{node.lineno}: {before}  ->  {ast.unparse(node)}")
            print("survives", survivors[-1], flush=True)
    print(f"{judged - len(survivors)} of {judged} mutants convicted "
          f"({len(drawn)} places on lines that run)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
