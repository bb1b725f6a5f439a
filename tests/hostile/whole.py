"""`python -m tests.hostile.whole COUNT FOLDER [--seed N] [--only COMMAND ...]`: whole commands.

Each case takes a clip (a walker by formulas, or a few seconds of a clip of FOLDER), alters it in a
way whose effect on the answer is known, runs one command on both, and compares the two answers.
A quarter of the cases damage the clip instead. What holds: the answer changes as it must, or exit
status 2 and one line that names the file; never a traceback, a silent other answer, a changed
input, or a file left behind. Exit status 1 if anything broke.
"""

import argparse
import contextlib
import hashlib
import io
import json
import pathlib
import re
import sys
import tempfile
import traceback
from collections import Counter, defaultdict
from dataclasses import dataclass, field, replace

import numpy as np

from refimpl.cli import main
from tests.hostile import answers
from tests.hostile.altered import Altered, mirrored, same, taken
from tests.hostile.answers import FILES
from tests.hostile.damaged import ALTERATIONS, DAMAGES, ONLY
from tests.hostile.strangers import Clip, height, read, walker, write

STYLES = ("old", "proud", "depressed", "childlike", "zombie")
WEIGHTS = {"transfer": 8, "inspect": 3, "observe": 3, "blend": 3, "score": 3, "prepare": 2,
           "segment": 1, "synthesise": 1}
LABELS = ("walk_plain_1", "walk_other_2", "walk_third_3", "walk_fourth_4")


@dataclass
class Run:
    """What a command did: exit status (or "traceback"), words, files."""

    status: int | str
    out: str
    err: str
    folder: pathlib.Path
    wrong: list[str] = field(default_factory=list)

    @property
    def told(self) -> str:
        """Warnings, wherever they stand."""
        said = [row.get("warnings") or row.get("reason") for row in self.rows.get("rows", [])]
        return " ".join(filter(None, [self.err.strip(), *said]))

    @property
    def rows(self) -> dict:
        path = self.folder / "answer.json"
        return json.loads(path.read_text()) if path.exists() else {}

    @property
    def clip(self) -> Clip:
        return read((self.folder / "answer.bvh").read_text())


def arguments(command: str, rng: np.random.Generator) -> list[str]:
    """Options that both runs get."""
    if command == "transfer":
        listed = [str(rng.choice(STYLES))]
        strength = float(rng.choice([0, 0.5, 1, 1, 1, 1.3]))
        listed += [] if strength == 1 else ["--strength", str(strength)]
        if rng.random() < 0.25:
            parts = rng.choice(["hips", "spine", "head", "arms", "legs"], rng.integers(1, 4), False)
            listed += ["--only", ",".join(parts)]
        return listed + [word for word in ("--raw", "--own-pace", "--no-projection")
                         if rng.random() < (0.5 if word == "--raw" and not strength else 0.1)]
    if command == "blend":
        return ["--alpha", str(rng.choice([0, 0.3, 0.5, 1]))]
    if command == "synthesise":
        return ["--flow", str(rng.choice([-1, 0, 1])), "--weight", "1"]
    return []


def perform(command: str, options: list[str], texts: list[str], folder: pathlib.Path,
            mapping: str = "", plant: str = "") -> Run:
    """Write the clips, run the command on them, and look at what it left."""
    (folder / "clips").mkdir(parents=True)
    paths = [folder / "clips" / f"{label}.bvh" for label in LABELS[:len(texts)]]
    if len(texts) > 3:
        (folder / "clips" / "base").mkdir()
        paths[1:] = [folder / "clips" / "base" / path.name for path in paths[1:]]
    for path, text in zip(paths, texts):
        path.write_bytes(text.encode())
    data, made = str(folder / "answer.json"), ["answer.json"]
    if mapping:
        (folder / "mapping.csv").write_text(mapping)
        if command in ("inspect", "transfer", "prepare"):
            options = [*options, "--mapping", str(folder / "mapping.csv")]
    if command == "score":
        (folder / "table.csv").write_text("content,style,result\n" + ",".join(map(str, paths)))
        argv = ["score", str(folder / "table.csv"), "--json", data]
    elif command == "prepare":
        made = ["answer.npz"]
        argv = ["prepare", str(folder / "clips"), "-o", str(folder / made[0]), *options]
    else:
        words = [str(path) for path in paths[:2]]
        if len(texts) > 3:
            words[1] = str(folder / "clips" / "base")
        before = options[:1] if command == "transfer" else []
        argv = [command, *before, *words, *options[len(before):]]
        if command in ("transfer", "blend", "synthesise"):
            argv += ["-o", str(folder / "answer.bvh")]
            made = ["answer.bvh"] + made * (command == "transfer")
        if "answer.json" in made:
            argv += ["--json", data]
    before_run = _listing(folder)
    run = call(argv, folder)
    if plant:
        run = PLANTS[plant](run)
    after = _listing(folder)
    for name, digest in before_run.items():
        if after.pop(name, "") != digest:
            run.wrong.append(f"{name} was changed")
    left = sorted(set(after) - set(made) if run.status == 0 else
                  set(after) - ({"answer.json"} if command == "inspect" else set()))
    run.wrong += [f"{name} was left behind" for name in left]
    if run.status == 0:
        run.wrong += [f"{name} was not written" for name in made if name not in after]
    if run.status not in (0, 2):
        run.wrong.append(f"exit status {run.status}: {(run.err.strip().splitlines() or [''])[-1]}")
    if run.status == 2:
        run.wrong += refusal(run, paths)
    return run


def _listing(folder: pathlib.Path) -> dict[str, str]:
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in folder.rglob("*") if path.is_file()}


def call(argv: list[str], folder: pathlib.Path) -> Run:
    """The command in this process, as it would end in one of its own."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = main(argv) or 0
        except SystemExit as end:
            status = end.code or 0
        except BaseException:
            traceback.print_exc()
            status = "traceback"
    if status == 143:
        raise KeyboardInterrupt
    return Run(status, out.getvalue(), err.getvalue(), folder)


def refusal(run: Run, paths: list[pathlib.Path]) -> list[str]:
    """What is wrong with a refusal: one line, the file's name, and what to do."""
    lines = run.err.strip().splitlines()
    if len(lines) != 1 or "error" not in lines[0]:
        return [f"refused in {len(lines)} lines: {' / '.join(lines)[:200]}"]
    if not any(path.stem in lines[0] for path in paths):
        return [f"refused without the file's name: {lines[0][:200]}"]
    if not re.search(r"needed|;|--\w|give|write|set", lines[0]):
        return [f"refused without a remedy: {lines[0][:200]}"]
    return []


# ----- planted faults --------------------------------------------------------------------------


def _spoilt(change):
    def plant(run: Run) -> Run:
        path = run.folder / "answer.bvh"
        if path.exists():
            path.write_text(write(change(read(path.read_text()))))
        return run
    return plant


def _late(clip: Clip) -> np.ndarray:
    return np.maximum(np.arange(len(clip.turns)) - 1, 0)


def _sides_exchanged(clip: Clip) -> Clip:
    other = mirrored(clip, np.random.default_rng(0)).clip
    if set(other.names) != set(clip.names):
        return clip
    return taken(other, [other.names.index(name) for name in clip.names])


def _torn(run: Run) -> Run:
    if run.status == 2:
        (run.folder / "answer.bvh").write_text("HIERARCHY\n")
    return run


PLANTS = {
    "late": _spoilt(lambda clip: replace(clip, turns=clip.turns[_late(clip)],
                                         places=clip.places[_late(clip)])),
    "mirrored": _spoilt(_sides_exchanged),
    "unscaled": _spoilt(lambda clip: answers.rescaled(clip, 150 / height(clip))),
    "rate": _spoilt(lambda clip: replace(clip, step=1 / 60)),
    "torn": _torn,
    "silent": lambda run: replace(run, status=0, err="", out="") if run.status == 2 else run,
}


# ----- cases -----------------------------------------------------------------------------------


def sources(command: str, clips: list[pathlib.Path], rng) -> tuple[str, list[Clip]]:
    """As many clips of one skeleton as the command takes, and what they are."""
    count, seconds = FILES[command], float(rng.uniform(1.5, 4))
    if not clips or rng.random() < 0.35:
        rate = float(rng.choice([30, 60, 120]))
        return f"walkers at {rate:g}", [walker(rng, seconds, rate) for _ in range(count)]
    first = clips[rng.integers(len(clips))]
    action = first.name.split("_")[1:2]
    alike = [path for path in clips if path.name.split("_")[1:2] == action and
             path.parent == first.parent]
    chosen = [first] + [alike[k] for k in rng.integers(0, len(alike), count - 1)]
    found = []
    for path in chosen:
        clip = read(path.read_text())
        rows = min(len(clip.turns), int(seconds / clip.step))
        begin = int(rng.integers(0, len(clip.turns) - rows + 1))
        found.append(replace(clip, turns=clip.turns[begin:begin + rows],
                             places=clip.places[begin:begin + rows]))
    return f"{chosen[0].stem}, {len(found[0].turns)} rows", found


def case(number: int, seed: int, clips, only: list[str], plant: str, folder: pathlib.Path):
    """One case: command, kind, outcome, description, worst share of a bound."""
    rng = np.random.default_rng([seed, number])
    odds = np.array([WEIGHTS[command] for command in only], dtype=float)
    command = str(rng.choice(only, p=odds / odds.sum()))
    source, base = sources(command, clips, rng)
    options = arguments(command, rng)
    damage = rng.random() < 0.25
    kind = str(rng.choice(sorted(name for name in (DAMAGES if damage else ALTERATIONS)
                                 if command in ONLY.get(name, FILES))))
    again = int(rng.integers(2**31))
    first = perform(command, options, [write(clip) for clip in base], folder / "base", plant=plant)
    what = f"{command} {' '.join(options)} on {source}, {kind}"
    if damage:
        damaged = DAMAGES[kind](base[0], np.random.default_rng(again))
        texts = [damaged.text] + [write(clip) for clip in base[1:]]
        second = perform(command, options, texts, folder / "altered", plant=plant)
        return command, kind, *answers.of_damage(command, kind, first, second, damaged), \
            f"{what} ({damaged.said})", 0.0
    changed: list[Altered] = [ALTERATIONS[kind](clip, np.random.default_rng(again))
                              for clip in base]
    if rng.random() < 0.5 and changed[0].frames is None and not changed[0].options and (
            command == "score" or command == "prepare" and kind != "mapped"):
        changed = [same(clip) for clip in base[:-1]] + changed[-1:]
    mapping = answers.mapping_of(base[0], changed[0], folder) if kind == "mapped" else ""
    second = perform(command, options + list(changed[0].options),
                     [a.text(a.clip) for a in changed], folder / "altered", mapping, plant)
    outcome, why, share = answers.compare(command, options, first, second, base, changed, kind)
    return command, kind, outcome, why, f"{what} ({changed[-1].said})", share


def run_all(words: list[str]) -> int:
    """The cases, a table of what held, and a line for each that broke."""
    parser = argparse.ArgumentParser(prog="python -m tests.hostile.whole", description=__doc__)
    parser.add_argument("count", type=int)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="+", choices=FILES, default=list(FILES))
    parser.add_argument("--case", type=int, help="this one alone")
    parser.add_argument("--keep", type=pathlib.Path, help="with --case: leave its files here")
    parser.add_argument("--plant", choices=PLANTS, default="", help="a fault to be found")
    given = parser.parse_args(words)
    clips = sorted(given.folder.rglob("*.bvh"))
    table: dict[tuple, Counter] = defaultdict(Counter)
    worst: dict[tuple, float] = defaultdict(float)
    broken = []
    for number in range(given.count) if given.case is None else [given.case]:
        with tempfile.TemporaryDirectory() as scratch:
            folder = given.keep if given.keep and given.case is not None else pathlib.Path(scratch)
            command, kind, outcome, why, what, share = case(
                number, given.seed, clips, given.only, given.plant, folder)
        table[kind, command][outcome] += 1
        worst[kind, command] = max(worst[kind, command], share)
        if outcome == "broken":
            broken.append(f"--seed {given.seed} --case {number}: {what}: {why}")
            print(broken[-1], flush=True)
        elif given.case is not None:
            print(f"{outcome}: {what}: {why}")
    names = ("held", "refused", "told", "silent", "broken", "base refused")
    print(f"{'kind':20} {'command':10} cases " + " ".join(f"{name:>12}" for name in names)
          + "  worst / bound")
    for key, counts in sorted(table.items()):
        print(f"{key[0]:20} {key[1]:10} {sum(counts.values()):5} "
              + " ".join(f"{counts[name]:12}" for name in names) + f"  {worst[key]:.3g}")
    print(f"{sum(sum(c.values()) for c in table.values())} cases, {len(broken)} broken")
    return int(bool(broken))


if __name__ == "__main__":
    sys.exit(run_all(sys.argv[1:]))
