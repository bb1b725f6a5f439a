"""Mutation testing: change the code in one place at a time; a test must fail, or the change must be
listed as equivalent.

    python tests/mutation/run.py [--only nn/conv.py ...] [--processes N]
                                    [--keep DIR] [--examples N] [--again]

Works in a copy of the repository; installs nothing. Needs mutmut 3, pytest, hypothesis and what
refimpl needs. Prints the table of README.md and every survivor that `equivalents.txt` does not
explain; the exit status is 0 if there is none, and no explanation without a survivor.
"""

import argparse
import ast
import difflib
import json
import os
from pathlib import Path
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = Path(__file__).resolve().parents[2]
EQUIVALENTS = Path(__file__).with_name("equivalents.txt")
FILES = ("nn/activation.py", "nn/gram.py", "gradcheck/errors.py", "nn/arguments.py", "nn/adam.py",
         "nn/norms.py", "nn/pool.py", "nn/conv.py", "gradcheck/derivative.py",
         "gradcheck/contract.py", "gradcheck/gradient.py", "nn/plan.py", "nn/tiled.py",
         "holden2017/losses.py")
TESTS = ("tests/nn", "tests/gradcheck", "tests/holden2017/test_losses.py",
         "--ignore=tests/nn/test_torch.py", "--ignore=tests/nn/test_witnesses.py")
# exit codes of a mutant's tests
ALIVE = {None: "not run", 0: "survived", 5: "without a test", 33: "without a test", 34: "skipped"}
TIMEOUTS = (24, 36, 152, 255, -24, -9)                           # killed, but by the clock


def prepare(folder):
    """A copy of the repository with mutmut's settings."""
    for name in ("refimpl", "tests"):
        shutil.copytree(ROOT / name, folder / name, dirs_exist_ok=True,
                        ignore=shutil.ignore_patterns("__pycache__", ".hypothesis", "mutants"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    settings = {"source_paths": ["refimpl"], "only_mutate": [f"refimpl/{file}" for file in FILES],
                "use_git_change_detection": ["false"], "timeout_constant": ["4"],
                "pytest_add_cli_args_test_selection": TESTS,
                "pytest_add_cli_args": ["-p", "no:cacheprovider", "-n", "0"]}
    lines = [f"{key} =" + "".join(f"\n    {value}" for value in values) for key,
             values in settings.items()]
    (folder / "setup.cfg").write_text((ROOT / "setup.cfg").read_text() + "\n[mutmut]\n"
                                      + "\n".join(lines) + "\n")


def exit_codes(folder, file):
    """{mutant: exit code of its tests, None if they did not run} of one file; a mutant's name is
    module.function__mutmut_number.
    """
    return json.loads((folder / "mutants" / "refimpl"
                       / f"{file}.meta").read_text())["exit_code_by_key"]


def forget(folder):
    """Let mutmut run again what survived and what the clock killed; it runs mutants of changed
    functions by itself.
    """
    for file in FILES:
        meta = folder / "mutants" / "refimpl" / f"{file}.meta"
        record = json.loads(meta.read_text())
        record["exit_code_by_key"] = {name: None if code in ALIVE or code in TIMEOUTS else code
                                      for name, code in record["exit_code_by_key"].items()}
        meta.write_text(json.dumps(record))


def changes(folder, file):
    """{mutant: (what it changes, as equivalents.txt has it; the lines before)} of one file:
    function, and the new lines without their comments.
    """
    text = (folder / "mutants" / "refimpl" / file).read_text()
    lines = text.splitlines()
    functions = {node.name: lines[node.lineno - 1:node.end_lineno]
                 for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef)}
    module, found = f"refimpl.{file.removesuffix('.py').replace('/', '.')}.", {}
    for mutant in functions:
        key, number = re.fullmatch(r"(.*?)(?:__mutmut_(\d+))?", mutant).groups()
        if number:
            function = key.removeprefix("x_").removeprefix("xǁ").replace("ǁ", ".")
            before, after = (re.sub(rf"\b{name}\b", function,
                                    "\n".join(functions[name])).splitlines()
                             for name in (f"{key}__mutmut_orig", mutant))
            difference = list(difflib.ndiff(before, after))
            new, old = ([re.sub(r"  +#.*", "", line[2:]).strip() for line in difference
                         if line.startswith(sign)] for sign in ("+ ", "- "))
            found[module + mutant] = (f"{function}: {' '.join(new or ['without', *old])}",
                                      " ".join(old))
    return found


def explained():
    """{file: {change: reason}} of equivalents.txt; a change that begins with "~ " is a regular
    expression for several.
    """
    found = {}
    for line in filter(None, EQUIVALENTS.read_text().splitlines()):
        if line.startswith("["):
            file = line.strip("[]")
        elif not line.startswith("#"):
            what, reason = line.split("  ## ")
            found.setdefault(file, {})[what] = reason
    return found


def judge(folder, files):
    """Print the table and the survivors that nothing explains.   ->  whether there is none"""
    reasons, good, totals = explained(), True, [0, 0, 0, 0]
    table = ["| file | mutants | killed | survived | of these equivalent | score |",
             "| --- | --- | --- | --- | --- | --- |"]
    for file in files:
        codes, what, known = exit_codes(folder, file), changes(folder, file), reasons.get(file, {})
        alive = [name for name, code in codes.items() if code in ALIVE]
        explains = {name: [change for change in known if _fits(change, what[name][0])]
                    for name in alive}
        equivalent = [name for name in alive if explains[name]]
        for name in codes:
            if name in alive and name not in equivalent:
                good = False
                print(
                    f"{ALIVE[codes[name]]}: {file} {name}\n    - {what[name][1]}\n    + "
                    f"{what[name][0]}")
            elif codes[name] in TIMEOUTS:
                print(f"killed by the clock: {file} {what[name][0]}")
        for change in known.keys() - {change for found in explains.values() for change in found}:
            good = False
            print(f"explained, but killed or gone: {file} {change}")
        row = [len(codes), len(codes) - len(alive), len(alive), len(equivalent)]
        totals = [a + b for a, b in zip(totals, row)]
        table.append(f"| `{file}` | {' | '.join(map(str, row))} | {_score(row)} |")
    print("\n".join(table + [f"| all | {' | '.join(map(str, totals))} | {_score(totals)} |"]))
    return good


def _fits(change, mutant):
    return (re.fullmatch(change[2:], mutant) is not None if change.startswith("~ ")
            else change == mutant)


def _score(row):
    """Killed, of those that can be killed."""
    return f"{100 * row[1] / max(1, row[0] - row[3]):.1f} %"


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=FILES, choices=FILES, metavar="FILE",
                        help="files below refimpl/")
    parser.add_argument("--processes", type=int, default=os.cpu_count(), metavar="N")
    parser.add_argument("--examples", default="10", metavar="N", help="of each hypothesis test")
    parser.add_argument("--keep", type=Path, metavar="DIR",
                        help="work here and leave it; the next run there begins sooner")
    parser.add_argument("--again", action="store_true",
                        help="with --keep: run the survivors, and what the clock killed, against "
                             "the tests as they are now")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        prepare(folder)
        chosen = [f"refimpl.{file.removesuffix('.py').replace('/', '.')}.*"
                  for file in options.only]
        if options.again:
            forget(folder)
            chosen = []                                          # of all files
        environment = {**os.environ, "REFIMPL_EXAMPLES": options.examples,
                       "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        mutmut = [sys.executable, "-c", "from mutmut.__main__ import cli; cli()", "run",
                  "--max-children", str(options.processes)]
        subprocess.run([*mutmut, *chosen], cwd=folder, env=environment, check=True)
        return 0 if judge(folder, options.only) else 1


if __name__ == "__main__":
    sys.exit(main())
