"""`refimpl score`: results of anybody's motion style transfer, told from files alone."""

import argparse
from collections.abc import Mapping
import csv
import hashlib
import math
from pathlib import Path
from typing import Any

from ..experiments import judges as judging, nulls, score
from ..motion.body import read_take
from ..motion.dataset import Dataset, assemble, load_dataset
from ..motion.features import FPS
from ..motion.points import is_points
from ..motion.labels import PATTERN, find_clips, labels_by_pattern, labels_from_file
from ..motion.tables import read_table
from .options import InputPath, OutputPath, OutputPicture, pattern, write_report
from .progress import Progress, table

DESCRIPTION = """Each row of TABLE.csv names a content, an exemplar of the style, and what a system
made of both: BVH files or points (.npy), whoever made them. Path, timing, feet, floor, bones,
suddenness and ends are told beside the content's; what a result looks like by two judges that see
no network, which are fitted on your labelled clips. No number depends on the unit, the axes, the
names of joints or the place where a clip begins."""
COLUMNS, OWN_LABELS = ("content", "style", "result"), ("content_label", "style_label")
KEPT_BACK = 0.25
SHOWN = (("results", "{:.0f}"), ("style seen by joints", "{:.0%}"),
         ("style seen by directions", "{:.0%}"), ("content seen by joints", "{:.0%}"),
         ("content seen by directions", "{:.0%}"),
         ("Fréchet distance", "{:.1f}"), ("path error (legs)", "{:.2f}"), ("path met", "{:.0%}"),
         ("timing off (s)", "{:.2f}"), ("movement kept (correlation)", "{:.2f}"),
         ("slide (legs/s)", "{:.2f}"), ("lowest foot (legs)", "{:+.3f}"),
         ("bones off (share)", "{:.1%}"), ("hips width off (share)", "{:.1%}"),
         ("shoulders width off (share)", "{:.1%}"), ("jerk (legs/s^3)", "{:.0f}"),
         ("largest acceleration (legs/s^2)", "{:.0f}"), ("ends off (ratio)", "{:.1f}"))


def add_commands(commands: Any) -> None:
    """Add `score` to the subparsers of the program."""
    command = commands.add_parser("score", description=DESCRIPTION)
    command.add_argument("table", metavar="TABLE.csv", type=InputPath,
                         help="columns content,style,result, and system where there are several; "
                              "content_label and style_label where file names do not tell them")
    command.add_argument("--judges", metavar="FOLDER", nargs="+", type=InputPath, default=[],
                         help="labelled clips to fit the judges on, or one MOTIONS.npz of `refimpl "
                              "prepare`; of each class of four and more a quarter (of MOTIONS.npz "
                              "what is held out) is kept back, to tell how often they are right")
    labels = command.add_mutually_exclusive_group()
    labels.add_argument("--labels", metavar="LABELS.csv", type=InputPath,
                        help="header clip,content,style of the judges' clips")
    labels.add_argument("--pattern", metavar="REGEX", type=pattern, default=PATTERN,
                        help="content and style from file names, as in prepare")
    command.add_argument("--nulls", action="store_true",
                         help="also score what bounds the numbers: content and exemplar copied, "
                              "shuffled pairs, other real takes")
    command.add_argument("--json", metavar="FILE", type=OutputPath, help="write every row as JSON")
    command.add_argument("--sheet", metavar="PNG", type=OutputPicture,
                         help="draw exemplar, content and result of some rows")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Print a line a system. A ValueError says what cannot be scored."""
    read_lines(arguments.table)                      # what is wrong there is told before long work
    judges = (read_judges(arguments.judges, arguments.pattern, arguments.labels)
              if arguments.judges else None)
    entries, rows = score_file(arguments.table, judges, arguments.pattern, arguments.nulls)
    print_systems(rows, judges)
    if arguments.json:
        settings = {key: value for key, value in vars(arguments).items() if key != "run"}
        write_report(arguments.json, "score", settings, [plain(row) for row in rows],
                     judges=judges.facts if judges else None)
    if arguments.sheet:
        from ..pictures import figures
        figures.sheet([({"style": e.exemplar.positions, "content": e.content.positions,
                         "result": e.result.positions},
                        f"{e.system}: {Path(e.facts['result']).name}") for e in entries],
                      arguments.sheet)


def score_file(path: str | Path, judges: judging.Judges | None, pattern: str = PATTERN,
               with_nulls: bool = False) -> tuple[list[nulls.Entry], list[nulls.ScoreRow]]:
    """A table's entries, and its rows: those refused, results, systems, nulls.

    Raises ScoreError where no row can be scored.
    """
    lines = read_lines(path)
    progress = Progress(2 * len(lines), "result")
    entries, refused = read_entries(lines, Path(path), judges, pattern,
                                    lambda: progress.step("read"))
    if not entries:
        raise score.ScoreError(f"{path}: found no row that can be scored: {refused[0]['reason']}")
    rows = list(nulls.score_table(entries, judges, nulls=with_nulls,
                                  done=lambda: progress.step("scored")))
    for row in refused:                              # each where it stands in the table
        rows.insert(lines.index(row.pop("as read")), row)
    return entries, rows


def read_lines(path: str | Path) -> list[dict[str, str]]:
    """The rows of a table of results, by the words of its header.   Raises ScoreError, OSError."""
    found = read_table(path, f"the header {','.join(COLUMNS)}", score.ScoreError)
    if found and len(found[0]) == 1 and ";" in found[0][0]:
        found = [[cell.strip() for cell in row] for row in csv.reader(
            map(",".join, found), delimiter=";")]
    rows = [(n, row) for n, row in enumerate(found, start=1) if any(row)]
    header = [name.lower() for name in rows[0][1]] if rows else []
    missing = [name for name in COLUMNS if name not in header]
    if missing:
        raise score.ScoreError(f"{path}: found columns {', '.join(header) or 'none'}, needed "
                               f"{', '.join(missing)} too; the header is {','.join(COLUMNS)}")
    twice = {name for name in header if name and header.count(name) > 1}
    over = [n for n, row in rows[1:] if any(row[len(header):])]
    if twice or over:
        raise score.ScoreError(f"{path}{f':{over[0]}' if over else ''}: found "
                               + (f"two columns {', '.join(sorted(twice))}" if twice else
                                  f"more cells than the {len(header)} columns of the header")
                               + ", needed each value under one word; was a comma meant as part "
                               "of a name? Put it in quotes")
    if len(rows) < 2:
        raise score.ScoreError(f"{path}: found no row below the header, needed some results")
    return [{"line": str(n), **dict(zip(header, row))} for n, row in rows[1:]]


def read_entries(lines: list[dict[str, str]], path: Path, judges: judging.Judges | None,
                 pattern: str, done: Any = lambda: None
                 ) -> tuple[list[nulls.Entry], list[dict[str, Any]]]:
    """The motions of a table's rows, and the rows that cannot be scored, with the reason."""
    known: dict[Any, score.Track | str] = {}

    def _motion(name, beside=None):
        file = path.parent / name
        key = (file, id(beside)) if beside and is_points(file) else file
        if key not in known:
            try:
                known[key] = score.read_motion(file, beside)
            except (ValueError, OSError) as error:
                known[key] = " ".join(str(error).split())
        return known[key]
    entries, refused = [], []
    for line in lines:
        facts: dict[str, Any] = {name: line.get(name, "") for name in COLUMNS}
        empty = [name for name in COLUMNS if not facts[name]]
        motions = {} if empty else {name: _motion(facts[name]) for name in COLUMNS[:2]}
        if isinstance(motions.get("content"), score.Track):
            motions["result"] = _motion(facts["result"], motions["content"])
        wrong = ([f"found nothing for {empty[0]}, needed a file"] if empty else
                 [m for m in motions.values() if isinstance(m, str)])
        done()
        if wrong:
            refused.append({"row": "result", "system": line.get("system", ""), **facts,
                            "line": int(line["line"]), "reason": wrong[0], "as read": line})
            continue
        content, own = _label(facts["content"], motions["content"], judges, pattern)
        style = _label(facts["style"], motions["style"], judges, pattern)[1]
        labels = [line.get(name) or told for name, told in zip(OWN_LABELS, (content, style))]
        lasts = [len(motions[name].positions) / FPS for name in ("result", "content")]
        strange = [f"{what} {label!r} is none that the judges know" for what, label in zip(
            ("content", "style"), labels) if judges and label not in judges.facts[f"{what}s"]]
        if abs(lasts[0] - lasts[1]) > 0.1:
            strange.append(f"the result lasts {lasts[0]:.2f} s, its content {lasts[1]:.2f}: equal "
                           "times are compared over what both have")
        strange += [f"{name}: {why}" for name, m in motions.items() for why in m.doubts]
        if strange:
            facts |= {"line": int(line["line"]), "reason": "; ".join(strange)}
        entries.append(nulls.Entry(motions["content"], motions["style"], motions["result"],
                                   line.get("system") or "result", labels[0], labels[1],
                                   {**facts, "style of content": own}))
    return entries, refused


def _label(name, motion, judges, pattern):
    """Content and style of a clip, by its name, or else by what the judge of joints sees."""
    named = labels_by_pattern([Path(name)], pattern)
    if named or not judges:
        return next(iter(named.values()), ("", ""))
    told = judges.look(motion)[0]
    return told.get("content by joints", ""), told["style by joints"]


def read_judges(folders: list[str], pattern: str = PATTERN,
                table: str | None = None) -> judging.Judges:
    """Judges of the labelled clips in folders, or of one MOTIONS.npz.   table : of labels

    Raises ScoreError, LabelError, and what reading clips raises.
    """
    digest, source = hashlib.sha256(), ", ".join(folders)
    if any(path.endswith(".npz") for path in folders):
        if len(folders) > 1:
            raise score.ScoreError(f"--judges: found {source}, needed folders or one MOTIONS.npz")
        digest.update(Path(source).read_bytes())
        return judging.fit_judges(load_dataset(source), source=source, sha256=digest.hexdigest())
    labels: dict[Path, tuple[str, str]] = {}
    for folder in map(Path, folders):
        paths = find_clips(folder)
        labels |= (labels_from_file(paths, table, folder) if table
                   else labels_by_pattern(paths, pattern))
    if not labels:
        raise score.ScoreError(f"{source}: found no clip with labels, needed some; does --pattern "
                               "fit the file names?")
    progress, takes = Progress(len(labels), "clip of the judges"), {}
    for path in sorted(labels):
        digest.update(hashlib.sha256(path.read_bytes()).digest())
        takes[str(path)] = read_take(path)
        progress.step(path.name)
    dataset: Dataset = assemble(takes.items(), {str(p): both for p, both in labels.items()},
                                source, KEPT_BACK)
    return judging.fit_judges(dataset, source=source, sha256=digest.hexdigest())


def plain(row: Mapping[str, Any]) -> dict[str, Any]:
    """What JSON can hold: nothing for what cannot be told."""
    return {key: None if isinstance(value, float) and not math.isfinite(value) else value
            for key, value in row.items()}


def print_systems(rows: list[nulls.ScoreRow], judges: judging.Judges | None) -> None:
    """A column a system, what its nulls must show, and rows that could not be scored."""
    if judges:
        facts = judges.facts
        right = ", ".join(f"{name} {share:.0%}"
                          for name, share in facts["right_on_kept_back"].items())
        print(f"judges fitted on {facts['clips']} clips of {len(facts['styles'])} styles and "
              f"{len(facts['contents'])} contents; right on {facts['kept_back']} kept back: "
              f"{right or 'not tried'}")
    lines = [["", *(row["system"] for row in rows if row["row"] == "system")]]
    for name, form in SHOWN:
        cells = []
        for row in rows:
            if row["row"] == "system":
                values = [row.get(key) for key in (name, f"{name}, low", f"{name}, high")]
                cells.append("" if values[0] is None else form.format(values[0]) + (
                    f" ({form.format(values[1])} to {form.format(values[2])})"
                    if values[1] is not None and values[2] != values[1] else ""))
        lines.append([name, *cells])
    print("\n".join(table(lines)))
    for row in rows:
        if "bound" in row:
            held = {True: "as it must be", False: "NOT SO", None: "not told"}[row["holds"]]
            print(f"{row['system']}: {row['bound']}: {held}")
        elif row.get("reason"):
            print(f"line {row['line']}: {row['reason']}")
