"""`refimpl check`: prove the reference, or judge another implementation; `refimpl export`: golden vectors for readers without Python."""

import sys

from ..conformance import cases, judge_all, load_backend, reference
from ..conformance.backend import read_expected_failures
from ..conformance.golden import export, verify
from ..conformance.prove import prove
from ..conformance.report import failures, proof_table, table, write_json, write_junit
from ..storage import check_writable
from .options import whole


def add_commands(commands):
    check = commands.add_parser("check", help="prove the reference, or judge another implementation",
                                description="Without a backend: hold the reference against its second derivation and the gradient instruments. "
                                            "With one: hold the backend against the reference.")
    check.add_argument("backend", nargs="?", metavar="MODULE:OBJECT", help="a mapping of operation names to callables, imported from here")
    check.add_argument("--golden", metavar="DIR", help="verify a folder that `refimpl export` wrote")
    check.add_argument("--json", metavar="FILE", help="write every verdict as JSON")
    check.add_argument("--junit", metavar="FILE", help="write every verdict as JUnit XML")
    check.add_argument("--xfail", metavar="FILE", help="patterns of case ids that are known to fail, one a line")
    check.add_argument("--operations", metavar="A,B", help="only these operations (default: all)")
    check.add_argument("--seed", type=whole(0), default=0, metavar="N", help="of the random inputs (default: %(default)s)")
    check.set_defaults(run=run_check)

    golden = commands.add_parser("export", help="write golden vectors", description="Write inputs and outputs of every case, and a manifest, to a folder.")
    golden.add_argument("folder", metavar="DIR")
    golden.add_argument("--operations", metavar="A,B", help="only these operations (default: all)")
    golden.add_argument("--seed", type=whole(0), default=0, metavar="N", help="of the random inputs (default: %(default)s)")
    golden.set_defaults(run=run_export)


def run_check(arguments):
    for path in (arguments.json, arguments.junit):
        if path:
            check_writable(path)
    operations = arguments.operations.split(",") if arguments.operations else None
    if arguments.golden:
        return _check_golden(arguments)
    if not arguments.backend and not (arguments.json or arguments.junit):
        return _prove(arguments.seed, operations)
    backend = load_backend(arguments.backend) if arguments.backend else reference()
    patterns = read_expected_failures(arguments.xfail) if arguments.xfail else ()
    outcomes = list(judge_all(backend, cases(seed=arguments.seed, operations=operations), patterns))
    print("\n".join([f"{backend.name} against refimpl", "", *table(outcomes), *failures(outcomes)]))
    if arguments.json:
        write_json(arguments.json, backend, outcomes)
    if arguments.junit:
        write_junit(arguments.junit, backend, outcomes)
    return 1 if any(outcome.status in ("failed", "xpassed") for outcome in outcomes) else 0


def _prove(seed, operations):
    cases(seed=seed, operations=operations)                      # an unknown name is refused before any work
    proofs = []
    for proof in prove(seed=seed, operations=operations):
        proofs.append(proof)
        print(f"{proof.operation}: {'proved' if not proof.failures else f'{len(proof.failures)} failures'}", file=sys.stderr)
    wrong = [failure for proof in proofs for failure in proof.failures]
    print("\n".join([*proof_table(proofs), *wrong]))
    return 1 if wrong else 0


def _check_golden(arguments):
    functions = load_backend(arguments.backend).functions if arguments.backend else reference().functions
    verdicts = list(verify(arguments.golden, functions))
    wrong = [f"{identity}: {message}" for identity, message in verdicts if message]
    print("\n".join([*wrong, f"{arguments.golden}: {len(verdicts) - len(wrong)} of {len(verdicts)} golden vectors agree"]))
    return 1 if wrong else 0


def run_export(arguments):
    operations = arguments.operations.split(",") if arguments.operations else None
    print(f"{arguments.folder}: {export(arguments.folder, seed=arguments.seed, operations=operations)} golden vectors and manifest.json")
