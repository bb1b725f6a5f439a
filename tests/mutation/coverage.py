"""Which statements of the papers' rooms does no case of the kit run?

    python -m tests.mutation.coverage [--missing]

Calls every case of the core profile once, and prints for each file how many statements of its
functions run; `--missing` lists the others. What is no mathematics (`NO_MATHEMATICS`) is counted
apart.
"""

import argparse
import ast
from pathlib import Path
import sys

import numpy as np

import refimpl
from refimpl.conformance import OPERATIONS, cases, reference

ROOMS = ("nn", "holden2017", "holden2016", "torresani2006")
WATCHED = (*ROOMS, "motion")
# Functions that are none of the papers' mathematics, by file, and what they are; "" for the others.
NO_MATHEMATICS = {
    "holden2016/bridge.py": {"": "between the code's rows and this package's clips"},
    "holden2016/files.py": {"": "files"},
    "holden2016/own.py": {"transfer": "clips"},
    "holden2016/rows.py": {"read_points": "files"},
    "holden2017/networks.py": {"__len__": "lists", "part": "lists"},
    "holden2017/pairing.py": {"gram_targets": "clips", "pair_contents": "names", "style": "clips",
                              "make_training_set": "clips", "_by": "words"},
    "holden2017/trained.py": {"contents": "names"},
    "holden2017/transfer.py": {"transfer": "clips"},
    "nn/__init__.py": {"__getattr__": "names"},
    "nn/arguments.py": {name: "fractions and symbols, for tests/proof" for name in (
        "are_exact", "_is_exact", "in_precision", "_fraction")},
    "nn/norms.py": {"_number": "fractions and symbols", "_share": "fractions and symbols"},
    "nn/sums.py": {"_exact_root": "fractions", "power_of_two": "fractions"},
    "torresani2006/align.py": {"dtw_definition": "the long form, beside the fast one"},
    "torresani2006/database.py": {"embedded_database": "clips", "read_database": "files",
                                  "without": "lists", "random_blends": "draws", "train": "draws"},
    "torresani2006/observe.py": {"read_labels": "files", "_label": "files"},
    "torresani2006/poses.py": {"clip_of": "clips", "check_skeleton": "clips",
                               "_odd_names": "clips"},
}


def is_no_mathematics(place, function):
    """Whether a function of a file is none of the papers' mathematics."""
    return bool({"", function} & set(NO_MATHEMATICS.get(place, ())))


def lines_run(chosen):
    """Lines of the rooms that these cases run when the reference answers them.

    ->  set of (path, line)
    """
    root, run = Path(refimpl.__file__).parent, set()
    files = {str(path) for room in WATCHED for path in (root / room).glob("*.py")}

    def _line(frame, event, argument):
        run.add((frame.f_code.co_filename, frame.f_lineno))
        return _line

    def _call(frame, event, argument):
        return _line(frame, event, argument) if frame.f_code.co_filename in files else None
    backend = reference()
    sys.settrace(_call)
    try:
        for case in chosen:
            try:
                with np.errstate(all="ignore"):
                    case.call(backend)
            except Exception:                                    # refused, as it should be
                pass
    finally:
        sys.settrace(None)
    return run


def statements(tree):
    """(function, statement) of all that a call may run, docstrings apart."""
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef):
            inner = {id(s) for f in ast.walk(function) if isinstance(f, ast.FunctionDef)
                     and f is not function for s in ast.walk(f) if isinstance(s, ast.stmt)}
            for s in ast.walk(function):
                if (isinstance(s, ast.stmt) and s is not function and id(s) not in inner
                        and not isinstance(s, (ast.FunctionDef, ast.ClassDef))
                        and not (isinstance(s, ast.AnnAssign) and s.value is None)
                        and not (isinstance(s, ast.Expr) and isinstance(s.value, ast.Constant))):
                    yield function, s


def own_lines(statement):
    """Lines of a statement without the block below it."""
    end = statement.body[0].lineno - 1 if hasattr(statement, "body") else statement.end_lineno
    return range(statement.lineno, max(end, statement.lineno) + 1)


def statement_of(tree, node):
    """Lines of the statement of a function that a node stands in.   ->  range, None where it stands
    outside of all"""
    for _, statement in statements(tree):
        if node.lineno in own_lines(statement):
            return own_lines(statement)
    return None


def main(argv=None):
    """Print a row for each file, and what is missing if that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--missing", action="store_true", help="list the statements as well")
    missing = parser.parse_args(argv).missing
    root = Path(refimpl.__file__).parent
    run = set()
    for name in OPERATIONS:
        run |= lines_run(cases(operations=[name]))
    print("| file | statements | run | not run: refusals | other mathematics | no mathematics |",
          "| --- | --- | --- | --- | --- | --- |", sep="\n")
    everything, lists = np.zeros(5, int), []
    for path in sorted(p for room in ROOMS for p in (root / room).glob("*.py")):
        counts, text = np.zeros(5, int), path.read_text()
        for function, statement in statements(ast.parse(text)):
            ran = any((str(path), line) in run for line in own_lines(statement))
            place = f"{path.parent.name}/{path.name}"
            kind = 1 if ran else 4 if is_no_mathematics(place, function.name) else (
                2 if isinstance(statement, ast.Raise) else 3)
            counts[[0, kind]] += 1
            if not ran:
                what, line = ("refusal", "missing", "apart")[kind - 2], statement.lineno
                lists.append(f"{place}:{line}: {what}: {function.name}: "
                             f"{text.splitlines()[line - 1].strip()}")
        everything += counts
        if counts[0]:
            print("|", f"`{place}`", "|", *(f"{n} |" for n in counts))
    print("| all |", *(f"{n} |" for n in everything))
    print(*lists if missing else [], sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
