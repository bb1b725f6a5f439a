"""Writes `speed.json` and the tables of `speed.md`, of what two runs of the benchmark found:

    refimpl bench --threads 2 --json two.json             # one thread and two
    OPENBLAS_CORETYPE=Haswell refimpl bench --json avx2.json
    python docs/speed.py two.json avx2.json
    python docs/speed.py --check          # says whether the page shows speed.json; writes nothing
"""

import argparse
import json
from pathlib import Path
import re
import sys

HERE = Path(__file__).parent
RUNS = ("as it is", "AVX2 alone")
TABLES = {"one thread": ("as it is", 1), "two threads": ("as it is", 2),
          "AVX2 alone": ("AVX2 alone", 1)}                       # name: run, threads
KEPT = ("work", "dtype", "threads", "seconds", "peer", "peer seconds", "share of the limit",
        "relative error")
STYLISE = [f"stylise + project, {count} frames" for count in (240, 480, 960, 3840)]
STEPS = [f"training step of T, batch {batch}" for batch in (10, 32)]
# Our time over the best peer's, in float32; with AVX2 alone 1.3 times what one thread is to reach.
GOALS = {"one thread": dict(zip(STYLISE + STEPS, (0.28, 0.22, 0.20, 0.19, 0.20, 0.20))),
         "two threads": dict(zip(STYLISE + STEPS, (0.28, 0.28, 0.30, 0.28, 0.24, 0.24)))}
GOALS["AVX2 alone"] = {work: 1.3 * goal for work, goal in GOALS["one thread"].items()}


def rounded(value):
    """Four digits of each number."""
    return float(f"{value:.4g}") if isinstance(value, float) else value


def kept(report):
    """What is stored of a run."""
    return {"settings": report["settings"],
            "large product, operations a second": {
                name: rounded(rate) for name, rate in report["gemm"].items()},
            "peak bytes, 15,360 frames": report["peak_bytes_15360_frames"],
            "rows": [{key: rounded(row[key]) for key in KEPT} for row in report["rows"]]}


def line(cells):
    return f"| {' | '.join(cells)} |"


def table(head, rows):
    return "\n".join([line(head), line(["---"] * len(head)), *map(line, rows)])


def ratio(row):
    return row["seconds"] / row["peer seconds"]


def rows_of(runs, table, dtype="float32"):
    """Rows of a table of one precision."""
    run, threads = TABLES[table]
    return [row for row in runs[run]["rows"] if (row["dtype"], row["threads"]) == (dtype, threads)]


def table_of(runs, name):
    found, goals = [], GOALS[name]
    for row in rows_of(runs, name):
        peer = row["peer"] is not None
        goal = goals.get(row["work"])
        found.append([
            row["work"], f"{1e3 * row['seconds']:.1f}",
            f"{1e3 * row['peer seconds']:.1f}, {row['peer']}" if peer else "",
            f"{ratio(row):.2f}" if peer else "", f"{goal:.2f}" if goal else "",
            f"{row['share of the limit']:.0%}"])
    return table(["work", "here, ms", "best peer, ms", "ratio", "goal", "of the limit"], found)


def met(runs):
    """Which goals are met, in a line a run."""
    lines = []
    for name, goals in GOALS.items():
        ratios = {row["work"]: ratio(row) for row in rows_of(runs, name) if row["work"] in goals}
        good = [work for work in goals if round(ratios[work], 2) <= round(goals[work], 2)]
        worst = max(goals, key=lambda work: ratios[work] / goals[work])
        lines.append(f"- {name}: {len(good)} of {len(goals)} goals met"
                     + (f", {'; '.join(good)}" if 0 < len(good) < len(goals) else "")
                     + f"; farthest from its goal: {worst}, {ratios[worst]:.2f} "
                     f"for {goals[worst]:.2f}.")
    return "\n".join(lines)


def blocks(report):
    """{name: Markdown} of all that the page shows of the numbers."""
    runs, here = report["runs"], report["runs"]["as it is"]
    said, rates = here["settings"], here["large product, operations a second"]
    found = {name: table_of(runs, name) for name in TABLES}
    found["machine"] = (
        f"{said['processor']} ({said['instructions']}), {said['cores']} cores, NumPy "
        f"{said['numpy']}, {' and '.join(said['peers'])}; a large product of matrices does "
        f"{rates['float32, 1 threads'] / 1e9:.0f} (float32) and "
        f"{rates['float64, 1 threads'] / 1e9:.0f} (float64) billion operations a second on one "
        f"thread. 15,360 frames of stylise + project take "
        f"{here['peak bytes, 15,360 frames'] / 2 ** 20:.0f} MiB beyond the motion itself.")
    found["met"] = met(runs)
    wide = [{row["work"]: row for row in rows_of(runs, name, "float64")} for name in TABLES]
    found["float64"] = table(
        ["work", *(f"ratio, {name}" for name in TABLES), "error"],
        [[work, *(f"{ratio(rows[work]):.2f}" for rows in wide),
          f"{row['relative error']:.0e}" if row["relative error"] else ""]
         for work, row in wide[0].items() if row["peer"]])
    found["defaults"] = table(
        ["work", "here, ms", "best peer, ms", "ratio"],
        [[row["work"], f"{1e3 * row['seconds']:.1f}",
          f"{1e3 * row['peer seconds']:.1f}, {row['peer']}", f"{ratio(row):.2f}"]
         for row in here["rows"] if isinstance(row["threads"], str) and row["peer"]
         and row["dtype"] == "float32"])
    return found


def shown(page, report):
    """The page with its blocks as the numbers have them."""
    for name, text in blocks(report).items():
        page, count = re.subn(rf"<!-- {name} -->\n.*?\n<!-- end -->", lambda _: (
            f"<!-- {name} -->\n\n{text}\n\n<!-- end -->"), page, flags=re.DOTALL)
        if count != 1:
            raise ValueError(f"speed.md: found {count} places for {name!r}, needed one: "
                             f"<!-- {name} --> ... <!-- end -->")
    return page


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", nargs="*", metavar="RUN.json", help=", ".join(RUNS))
    parser.add_argument("--check", action="store_true", help="say what differs, write nothing")
    arguments, store, path = parser.parse_args(), HERE / "speed.json", HERE / "speed.md"
    if len(arguments.runs) not in (0, len(RUNS)):
        parser.error(f"found {len(arguments.runs)} runs, needed {', '.join(RUNS)}, or none")
    if arguments.runs:
        read = [json.loads(Path(name).read_text(encoding="utf-8")) for name in arguments.runs]
        store.write_text(text_of(dict(zip(RUNS, map(kept, read)))), encoding="utf-8")
    page = path.read_text(encoding="utf-8")
    new = shown(page, json.loads(store.read_text(encoding="utf-8")))
    if arguments.check:
        print("nothing differs" if new == page else "speed.md differs from speed.json")
        return int(new != page)
    path.write_text(new, encoding="utf-8")
    return 0


def text_of(runs):
    """The stored text, a row a line."""
    text = json.dumps({"command": "python docs/speed.py", "runs": runs}, indent=1)
    return re.sub(r"\n {5,}|\n {4}(?=\})", " ", text) + "\n"


if __name__ == "__main__":
    sys.exit(main())
