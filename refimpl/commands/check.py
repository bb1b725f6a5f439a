"""`refimpl check`: hold the reference against its second derivation, or judge another
implementation.

`refimpl export`: golden vectors for readers without Python.
"""

import argparse
import os
from typing import Any

import numpy as np

from ..conformance import OPERATIONS, cases, judge_all, load_backend, reference
from ..conformance.apart import Request, judge_apart
from ..conformance.backend import meant, read_expected_failures
from ..conformance.cases import PROFILES, known_operation
from ..conformance.explain import explain, listed
from ..conformance.golden import export, read_folder
from ..conformance.program import judge_program
from ..conformance.recompute import objections
from ..conformance.report import (failures, idle_patterns, last_line, misspelt, row, table, verdict,
                                  verification_table, write_junit)
from ..conformance.schema import PROTOCOL
from ..conformance.stub import HEADS, stub
from ..conformance.verify import verify
from .options import (InputFolder, InputPath, OutputFolder, OutputPath, number, whole,
                      write_report)
from .progress import Progress

EXIT = """Exit status: 0 everything that ran agrees; 1 something is wrong, follows another
convention or cannot be decided, or nothing ran, or the folder is not the exported one; 2 input that
cannot be used. What is stricter or laxer with input, or is not offered, counts with --require
only."""


def add_commands(commands: Any) -> None:
    """Add `check` and `export` to the subparsers of the program."""
    check = commands.add_parser(
        "check",
        description="Without a backend: hold the reference against its second derivation and the "
        "gradient instruments. With one: hold the backend against the reference, or against golden "
        "vectors.", epilog=EXIT)
    check.add_argument("backend", nargs="?", metavar="MODULE:OBJECT",
                       help="a mapping of operation names to callables, imported from here")
    check.add_argument("--command", metavar="PROGRAM",
                       help="judge a program in any language, by the profile small unless another "
                       f"is asked for. {PROTOCOL}")
    check.add_argument("--golden", metavar="DIR", type=InputFolder,
                       help="judge by the vectors that `refimpl export` wrote to this folder")
    check.add_argument("--json", metavar="FILE", type=OutputPath,
                       help="write every verdict as JSON")
    check.add_argument("--junit", metavar="FILE", type=OutputPath,
                       help="write every verdict as JUnit XML")
    check.add_argument("--xfail", metavar="FILE", type=InputPath,
                       help="patterns of case ids that are known to fail, one a line; one that "
                       "nothing of fails any more is told, and the verdict is then disagrees")
    check.add_argument("--operations", metavar="A,B", help="only these operations (default: all)")
    check.add_argument("--require", metavar="A,B|all",
                       help="functions that must be offered (gram, gram_backward ...), and take "
                       "neither more nor less than the reference")
    check.add_argument("--seed", type=whole(0), metavar="N",
                       help="of the random inputs (default: 0)")
    check.add_argument("--profile", choices=PROFILES, metavar="NAME",
                       help="core (default), full: more of it, small: the operations' own samples, "
                       "or tf32 or bfloat16: values as near as products of that precision allow")
    check.add_argument("--time-limit", type=number(least=0.1), default=60.0, metavar="S",
                       help="seconds for one call, after which it counts as hanging "
                       "(default: %(default)g)")
    check.add_argument("--memory-limit", type=number(least=0.1), default=8.0, metavar="GB",
                       help="of one call, on Linux (default: %(default)g)")
    check.add_argument("--in-process", action="store_true",
                       help="call the backend in this process, for a debugger: a crash or a hang "
                       "then ends the judge too")
    check.add_argument("--explain", metavar="OPERATION",
                       help="print an operation's arguments, shapes, units, defaults and "
                       "conventions, and stop")
    check.add_argument("--list", action="store_true",
                       help="print every operation, its gradient, and where it comes from, and "
                       "stop")
    check.add_argument("--stub", choices=HEADS, metavar="LIBRARY",
                       help="print a Python file to fill in, with every operation as a function of "
                       "numpy, torch or jax that is not written yet, and stop")
    check.set_defaults(run=run_check, also_reads=_module)

    golden = commands.add_parser(
        "export",
        description="Write inputs and outputs of every case, and a manifest, to a folder.")
    golden.add_argument("folder", metavar="DIR", type=OutputFolder)
    golden.add_argument("--operations", metavar="A,B", help="only these operations (default: all)")
    golden.add_argument("--seed", type=whole(0), default=0, metavar="N",
                        help="of the random inputs (default: %(default)s)")
    golden.set_defaults(run=run_export)


def _module(arguments):
    """The file that the backend is imported from, where it lies below the current folder."""
    path = f"{(arguments.backend or '').partition(':')[0].replace('.', '/')}.py"
    return {"MODULE": path} if os.path.isfile(path) else {}


def run_check(arguments: argparse.Namespace) -> int:
    """Judge what is asked for and print the verdicts.   ->  the exit status, as EXIT tells it

    A ValueError says which options or names cannot be used.
    """
    if arguments.explain is not None:
        return _explain(arguments)
    if arguments.list:
        print("\n".join(listed()))
        return 0
    operations = _names("--operations", arguments.operations)
    if arguments.golden is None or arguments.stub is not None:
        for name in operations or ():
            known_operation(name)
    if arguments.stub is not None:
        print(stub(arguments.stub, operations), end="")
        return 0
    if arguments.command is not None and (arguments.backend is not None or arguments.in_process):
        raise ValueError(f"--command: found {arguments.backend or '--in-process'} beside it, "
                         "needed one thing to judge, in a process of its own; leave one out")
    if arguments.golden is not None:
        for option, why in (("seed", "have their seed"), ("profile", "are what they are")):
            value = getattr(arguments, option)
            if value is not None:
                raise ValueError(f"--{option}: found {value} beside --golden, whose vectors {why}; "
                                 "leave it out")
        return _judge(arguments, *_golden_cases(arguments.golden, operations))
    if arguments.backend is None and arguments.command is None:
        return _verify(arguments, arguments.seed or 0, operations)
    return _judge(arguments, None, [], operations)


def _names(word, text):
    """Names between commas.   ->  list of str, None where the option was not given"""
    if text is None:
        return None
    found = [name.strip() for name in text.split(",") if name.strip()]
    if not found:
        raise ValueError(f"{word}: found {text!r}, needed names with commas between them")
    return found


def _golden_cases(folder, operations):
    """->  cases, complaints"""
    found, complaints = read_folder(folder)
    complaints = complaints or list(objections(folder, found))
    there = {case.operation.name for case in found}
    for name in operations or () if not complaints else ():
        if name not in there:
            raise ValueError(f"--operations: found {name!r}, needed an operation of {folder}"
                             + meant(name, there))
    return [c for c in found if operations is None or c.operation.name in operations], complaints


def _required(text, there):
    """Functions that must be there.   ->  set of str"""
    found = set()
    for name in _names("--require", text) or ():
        functions = there if name == "all" else {name} & there
        if not functions:
            raise ValueError(f"--require: found {name!r}, needed all, or a function that is judged "
                             "here" + meant(name, there))
        found |= functions
    return found


def _judge(arguments, chosen, complaints, operations=None):
    """chosen : the cases of a golden folder, None where they are made from the operations"""
    patterns = read_expected_failures(arguments.xfail) if arguments.xfail is not None else ()
    names = list(operations or OPERATIONS) if chosen is None else list(
        dict.fromkeys(case.operation.name for case in chosen))
    there = {case.function for case in chosen} if chosen is not None else {
        function for function in reference().functions
        if function.removesuffix("_backward") in names}
    required = _required(arguments.require, there) if there or not complaints else set()
    if chosen is None:
        chosen = (case for name in names for case in cases(
            operations=[name], seed=arguments.seed or 0, profile=_profile(arguments)))
    if arguments.command is not None:
        backend, *outcomes = _followed(names, judge_program(
            arguments.command, chosen, patterns, time_limit=arguments.time_limit))
    elif arguments.backend is None or arguments.in_process:
        backend = load_backend(arguments.backend) if arguments.backend else reference()
        outcomes = list(_followed(names, judge_all(backend, chosen, patterns)))
    else:
        backend, *outcomes = _followed(names, judge_apart(Request(
            arguments.backend, tuple(names), arguments.seed or 0, _profile(arguments),
            arguments.golden, tuple(patterns), arguments.time_limit, arguments.memory_limit)))
    idle = idle_patterns(patterns, outcomes)
    said = "disagrees" if complaints or idle else verdict(outcomes, required)
    against = arguments.golden or "refimpl"
    lines = [f"{backend.name} against {against}", "", *(f"{against}: {c}" for c in complaints[:20])]
    if len(complaints) > 20:
        lines += [f"{against}: ... and {len(complaints) - 20} more"]
    lines += [f"expected to fail, and does not: {pattern}" for pattern in idle]
    if outcomes:
        lines += [*table(outcomes), *failures(outcomes)]
    if arguments.golden:
        agreeing = sum(o.grade == "agrees" for o in outcomes)
        lines += ["", f"{arguments.golden}: {agreeing} of {len(outcomes)} golden vectors agree"]
    absent = sorted({o.case.function for o in outcomes if o.grade == "not offered"} & required)
    lines += [f"required, but not offered: {', '.join(absent)}"] if absent else []
    print("\n".join([*lines, *misspelt(backend), "", last_line(outcomes, said)]))
    rows = [*(_complaint(c) for c in complaints), *map(row, outcomes)]
    _write(arguments, backend, rows, said)
    if arguments.junit:
        write_junit(arguments.junit, backend, outcomes, complaints)
    return 0 if said == "agrees" else 1


def _followed(names, outcomes):
    """Outcomes, and a backend that comes before them, as they come, with progress."""
    progress, now = Progress(len(names), "operation"), ""
    for outcome in outcomes:
        name = outcome.case.operation.name if hasattr(outcome, "case") else now
        if now not in ("", name):
            progress.step(now)
        now = name
        yield outcome


def _profile(arguments):
    return arguments.profile or ("core" if arguments.command is None else "small")


def _complaint(words):
    return {"operation": "", "case": "golden folder", "function": "", "dtype": "", "grade": "wrong",
            "convention": "", "found": words, "needed": "the folder as it was exported",
            "status": "failed", "message": words}


def _verify(arguments, seed, operations):
    for option in ("xfail", "junit", "require", "profile"):
        if getattr(arguments, option) is not None:
            raise ValueError(f"--{option}: found it without a backend or --golden, of which it "
                             "speaks; leave it out")
    found = []
    progress = Progress(len(operations or OPERATIONS), "operation")
    for one in verify(seed=seed, operations=operations):
        found.append(one)
        progress.step(f"{one.operation}: "
                      + (f"{len(one.failures)} failures" if one.failures else "agrees"))
    wrong = [failure for one in found for failure in one.failures]
    said = "disagrees" if wrong else "agrees"
    print("\n".join([
        *verification_table(found), *wrong, "",
        f"verdict: {said} (the reference with its second derivation, the gradient instruments and "
        "its own cases)"]))
    _write(arguments, reference(), [row for one in found for row in one.rows], said)
    return 1 if wrong else 0


def _write(arguments, backend, rows, said):
    if arguments.json is None:
        return
    settings = {"backend": backend.name, "tolerances": dict(backend.tolerances),
                "seed": arguments.seed or 0, "golden": arguments.golden,
                "operations": arguments.operations, "require": arguments.require,
                "profile": _profile(arguments), "time limit": arguments.time_limit,
                "xfail": arguments.xfail, "numpy": np.__version__,
                "blas threads": os.environ.get("OPENBLAS_NUM_THREADS", "")}
    unknown = [{"name": name, "nearest": near} for name, near in backend.unknown]
    write_report(arguments.json, "check", settings, rows, verdict=said, unknown=unknown)


def _explain(arguments):
    if arguments.explain not in OPERATIONS:
        raise ValueError(f"--explain: found {arguments.explain!r}, needed one of "
                         f"{', '.join(OPERATIONS)}" + meant(arguments.explain, OPERATIONS))
    print("\n".join(explain(OPERATIONS[arguments.explain])))
    return 0


def run_export(arguments: argparse.Namespace) -> None:
    """Write the golden vectors. A ValueError says what stands in the way."""
    names = _names("--operations", arguments.operations)
    count = export(arguments.folder, seed=arguments.seed, operations=names,
                   report=Progress(len(names or OPERATIONS), "operation").step)
    print(f"{arguments.folder}: {count} golden vectors and manifest.json")
