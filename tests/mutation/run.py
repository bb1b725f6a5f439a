"""Mutation testing: change the code in one place at a time; a test must fail, or the change must be listed as equivalent.

    python tests/mutation/run.py [--only nn/conv.py ...] [--processes N] [--keep DIR] [--examples N]

Works in a copy of the repository; installs nothing. Needs mutmut 3, pytest, hypothesis and what refimpl needs. Prints the table of README.md and every
survivor that `equivalents.txt` does not explain; the exit status is 0 if there is none, and no explanation without a mutant.
"""

import argparse
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
FILES = ("nn/arguments.py", "nn/conv.py", "nn/plain.py", "nn/pool.py", "nn/activation.py", "nn/gram.py", "nn/norms.py", "nn/adam.py",
         "holden2017/losses.py")
TESTS = ("tests/nn", "tests/holden2017/test_losses.py", "--ignore=tests/nn/test_witnesses.py")
STATUS = {0: "survived", 33: "without a test", 36: "killed", 152: "killed", 24: "killed", -24: "killed"}     # of mutmut's exit codes; else killed


def prepare(folder, files):
    """A copy of the repository with mutmut's settings."""
    for name in ("refimpl", "tests"):
        shutil.copytree(ROOT / name, folder / name, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__", ".hypothesis", "mutants"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    settings = {"source_paths": ["refimpl"], "only_mutate": [f"refimpl/{file}" for file in files], "pytest_add_cli_args_test_selection": TESTS,
                "pytest_add_cli_args": ["-p", "no:cacheprovider", "-p", "tests.mutation.fast_first"], "use_git_change_detection": ["false"]}
    lines = [f"{key} =" + "".join(f"\n    {value}" for value in values) if len(values) > 1 else f"{key} = {values[0]}"
             for key, values in settings.items()]
    (folder / "setup.cfg").write_text((ROOT / "setup.cfg").read_text() + "\n[mutmut]\n" + "\n".join(lines) + "\n")


def mutants(folder, file):
    """{mutant: status} of one file."""
    codes = json.loads((folder / "mutants" / "refimpl" / f"{file}.meta").read_text())["exit_code_by_key"]
    return {name: "not run" if code is None else STATUS.get(code, "killed") for name, code in codes.items()}


def change(folder, name):
    """What a mutant changes, as equivalents.txt has it: function, and the new line without its comment."""
    shown = subprocess.run(["mutmut", "show", name], cwd=folder, capture_output=True, text=True, check=True).stdout
    function = re.sub(r"__mutmut_\d+$", "", name.rsplit(".", 1)[1]).removeprefix("x_")
    new = [line[1:].strip() for line in shown.splitlines() if re.match(r"\+(?!\+\+ )", line)]
    old = [line[1:].strip() for line in shown.splitlines() if re.match(r"-(?!-- )", line)]
    return f"{function}: {' '.join(re.sub(r'  +#.*', '', line) for line in new or ['removed ' + ' '.join(old)])}", "\n".join(old)


def explained():
    """{file: {change: reason}} of equivalents.txt."""
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
    table = ["| file | mutants | killed | survived | of these equivalent | score |", "| --- | --- | --- | --- | --- | --- |"]
    for file in files:
        statuses = mutants(folder, file)
        alive = {name: change(folder, name) for name, status in statuses.items() if status != "killed"}
        equivalent = [name for name, (what, _) in alive.items() if what in reasons.get(file, {})]
        for name in alive.keys() - set(equivalent):
            good = False
            print(f"{statuses[name]}: {file} {name}\n    - {alive[name][1]}\n    + {alive[name][0]}")
        for what in reasons.get(file, {}).keys() - {what for what, _ in alive.values()}:
            good = False
            print(f"explained, but killed or gone: {file} {what}")
        row = [len(statuses), len(statuses) - len(alive), len(alive), len(equivalent)]
        totals = [a + b for a, b in zip(totals, row)]
        table.append(f"| `{file}` | {' | '.join(map(str, row))} | {_score(row)} |")
    print("\n".join(table + [f"| all | {' | '.join(map(str, totals))} | {_score(totals)} |"]))
    return good


def _score(row):
    """Killed, of those that can be killed."""
    return f"{100 * row[1] / max(1, row[0] - row[3]):.1f} %"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=FILES, metavar="FILE", help="files below refimpl/")
    parser.add_argument("--processes", type=int, default=os.cpu_count(), metavar="N")
    parser.add_argument("--examples", default="10", metavar="N", help="of each hypothesis test")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="work here and leave it; what was run there before is not run again")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or Path(temporary)
        prepare(folder, options.only)
        environment = {**os.environ, "REFIMPL_EXAMPLES": options.examples, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        subprocess.run(["mutmut", "run", "--max-children", str(options.processes)], cwd=folder, env=environment, check=True)
        return 0 if judge(folder, options.only) else 1


if __name__ == "__main__":
    sys.exit(main())
