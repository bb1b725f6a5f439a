"""Do two answers of a command differ as their inputs do? What `whole` holds them to, and why.

`EXACT`: an alteration that changes no place of the body (names, units, axes, print) may change
the answer by what text and rounding are worth: a clip has six decimals of a degree or twelve
digits, and the clean-up of feet decides by thresholds that rounding alone rarely crosses; 1e-4 of
the body's height is 0.15 mm of a person. What is not exact is held, by the mean over joints and
frames, to `NEAR`, in shares of the body's height, each below what a wrong answer of that
kind gives: sides exchanged (0.1 and more in a walk), a row too late at 30 a second (0.02). `SEEN`
is the same for the observers' scale of six. `PROMISED` says which commands must notice a damage;
where the others say nothing the outcome is `silent`, which is counted and not held against them.
"""

import json
import re
from dataclasses import replace

import numpy as np

from tests.hostile.altered import side_and_part
from tests.hostile.strangers import Clip, height, world, write

EXACT = 1e-4
ON_PATH = 0.05          # a manner leans the hips to one side: up to 0.037 of a body without P
NEAR = {"mirrored": 0.08, "resampled": 0.02, "repeated": 0.03, "cut": 0.05, "fewer": 0.03,
        "other_rate": 0.01, "extra": 0.1}
SEEN = {"mirrored": 1.5, "resampled": 1.0, "repeated": 1.5, "cut": 3.0, "fewer": 1.0, "extra": 0.3}
FILES = {"inspect": 1, "observe": 1, "transfer": 1, "blend": 2, "score": 3, "prepare": 3,
         "segment": 4, "synthesise": 4}
PROMISED = {"broken_text": list(FILES), "headless": ["inspect", "transfer", "prepare"],
            "teleporting": ["inspect", "transfer", "prepare"], "sized": ["inspect", "transfer"],
            "lost": ["inspect", "transfer", "prepare"], "short": [], "frozen": []}
PARTS = {"hips": "Hips", "spine": "Spine Spine1", "head": "Neck1 Head",
         "arms": "Arm ForeArm Hand", "legs": "UpLeg Leg Foot ToeBase"}


def rescaled(clip: Clip, scale: float) -> Clip:
    """`clip`, `scale` times as large."""
    return replace(clip, places=clip.places * scale, offsets=clip.offsets * scale)


def mapping_of(base: Clip, changed, folder) -> str:
    """The mapping file that `inspect` writes of the base, with the altered clip's names."""
    from tests.hostile.whole import call
    (folder / "named").mkdir()
    (folder / "named" / "clip.bvh").write_text(write(base))
    path = folder / "named" / "mapping.csv"
    call(["inspect", str(folder / "named" / "clip.bvh"), "--write-mapping", str(path)], folder)
    lines = [line.split(",") for line in path.read_text().splitlines()]
    return "\n".join(",".join([a, *(changed.names.get(b, b) for b in rest)]) for a, *rest in lines
                     ) + "\n"


def of_damage(command, kind, first, second, damaged) -> tuple[str, str]:
    """Refused, or told, or (where that is right) answered; broken otherwise."""
    if first.wrong:
        return "broken", "of the base: " + "; ".join(first.wrong)
    if second.wrong:
        return "broken", "; ".join(second.wrong)
    if second.status == 2:
        return "refused", second.err.strip()
    new = set(words(second.out + second.told)) - set(words(first.out + first.told))
    if new:
        return "told", " ".join(sorted(new))
    return ("broken" if command in PROMISED[kind] else "silent"), "not a word of it"


def words(text: str) -> list[str]:
    """The words of a text without names of files and numbers."""
    return re.findall(r"(?<![\w/.])[A-Za-z]{3,}(?![\w/])", text)


def compare(command, options, first, second, base, changed, kind) -> tuple[str, str, float]:
    """Outcome, reason and the worst deviation as a share of its bound."""
    if first.wrong or second.wrong:
        return "broken", "; ".join(["of the base: " + w for w in first.wrong] + second.wrong), 0.0
    foreign = any(one.foreign for one in changed)
    if first.status == 2:
        return "base refused", first.err.strip(), 0.0
    if second.status == 2:
        if foreign or command in ("observe", "score", "blend") and kind == "mapped":
            return "refused", second.err.strip(), 0.0
        return "broken", "refused: " + second.err.strip()[:300], 0.0
    found = ALL[command](options, first, second, base, changed, kind)
    worst = max(found, key=lambda row: row[1] / row[2], default=("", 0.0, 1.0))
    share = worst[1] / worst[2]
    wrong = "; ".join(f"{what} {value:.3g} > {bound:g}" for what, value, bound in found
                      if not value <= bound)
    if wrong and foreign and second.told:
        return "told", second.told, 0.0
    if wrong and foreign and command not in ("inspect", "transfer", "prepare", "score"):
        return "silent", wrong, 0.0
    return ("broken" if wrong else "held"), wrong, share


def _names(command, clip: Clip, out: Clip, what: str) -> list[tuple]:
    """Joints, tree and channels are the clip's own."""
    return [(f"{what}: names", float(clip.names != out.names), 0.5),
            (f"{what}: tree", float(clip.parents != out.parents), 0.5),
            (f"{what}: channels", float(clip.channels != out.channels), 0.5)]


def _content(options, run, clip: Clip, what: str, first_names, up) -> list[tuple]:
    """What a result keeps of its content, whatever the style."""
    out = run.clip
    rows = _names("transfer", clip, out, what)
    rows += [(f"{what}: rows", float(len(out.turns) != len(clip.turns)), 0.5),
             (f"{what}: rate", abs(out.step / clip.step - 1), 1e-6)]
    if any(value > bound for _, value, bound in rows):
        return rows
    size = height(clip)
    still = np.ptp(clip.places, axis=0).max(axis=1) < 1e-4 * size
    length = np.linalg.norm(out.places, axis=2) - np.linalg.norm(clip.places, axis=2)
    rows.append((f"{what}: bones", float(np.abs(length[:, still]).max()) / size, EXACT))
    turns, points = world(clip)
    turns_out, points_out = world(out)
    if "--only" in options:
        asked = options[options.index("--only") + 1].split(",")
        kept = {name for key, names in PARTS.items() if key not in asked for name in names.split()
                if not (key == "legs" and "hips" in asked)}
        apart = [float(np.abs(out.turns[:, j] - clip.turns[:, j]).max())
                 for j, name in enumerate(first_names) if side_and_part(name)[1] in kept]
        rows.append((f"{what}: other parts than {asked}", max(apart, default=0.0),
                     1e-4 if what != "resampled" else 0.1))
    if "--strength" in options and float(options[options.index("--strength") + 1]) == 0 and \
            "--raw" in options and "--own-pace" not in options:
        rows.append((f"{what}: strength 0", float(np.abs(points_out - points).max()) / size,
                     1e-5 if what != "resampled" else 0.02))     # between rows each has its curve
    if "--own-pace" not in options and "--raw" not in options:
        rows.append((f"{what}: path", _path(points, points_out, first_names, up) / size, ON_PATH))
    return rows


def _path(points, points_out, first_names, up) -> float:
    """By how much the hips leave their way, level, at equal times, with what sways taken out."""
    hips = next((j for j, name in enumerate(first_names) if side_and_part(name)[1] == "Hips"), 0)
    level = np.eye(3) - np.outer(up, up)
    away = (points_out[:, hips] - points[:, hips]) @ level
    return float(np.linalg.norm(away.mean(axis=0)))


def _places(out: Clip, out_changed: Clip, one, kind: str, adrift: bool = False) -> list[tuple]:
    """Places of the two answers, the first brought to where the second should be.

    Results that leave their path by what their networks say (`--raw`, `--own-pace`), `adrift`, are
    compared as seen from the hips unless they must be equal.
    """
    turns, points = world(out)
    turns_new, points_new = world(out_changed)
    pairs = [(out.names.index(a), out_changed.names.index(b)) for a, b in one.names.items()
             if a in out.names and b in out_changed.names]
    if not pairs:
        return [("no joint of the names asked for", 1.0, 0.5)]
    old, new = map(list, zip(*pairs))
    rows, rows_new = one.frames or (np.arange(len(points)),) * 2
    if rows_new[-1] >= len(points_new) or rows[-1] >= len(points):
        return [("rows of the answer", 1.0, 0.5)]
    size = height(out) * one.scale
    wanted = one.scale * points[rows][:, old] @ one.turn.T + one.shift
    away = points_new[rows_new][:, new] - wanted
    if adrift and not one.exact:
        away = away - away[:, [list(one.names).index("Hips")]]
    away = np.linalg.norm(away, axis=2) / size
    if one.exact:
        joint = list(one.names)[int(away.max(axis=0).argmax())]
        return [(f"place of {joint}", float(away.max()), EXACT)]
    return [("mean place", float(away.mean()), NEAR[kind])]


def _transfer(options, first, second, base, changed, kind):
    one, known = changed[0], {new: old for old, new in changed[0].names.items()}
    rows = _content(options, first, base[0], "base", base[0].names, np.eye(3)[1])
    what = "resampled" if kind == "other_rate" else "altered"
    rows += _content(options, second, one.clip, what,
                     [known.get(name, "") for name in one.clip.names], one.turn[:, 1])
    if any(value > bound for _, value, bound in rows):
        return rows
    rows += _places(first.clip, second.clip, one, kind, {"--raw", "--own-pace"} & set(options))
    said, said_new = first.rows["rows"][0], second.rows["rows"][0]
    if one.exact and one.frames is None:
        for key in ("mean path error", "way"):
            wanted = said[key] * one.scale
            rows.append((key, abs(said_new[key] - wanted) / (said["way"] * one.scale + 1e-9), 1e-3))
        rows.append(("strangeness", abs(said_new["strangeness"] - said["strangeness"]), 1e-3))
    return rows


def _of_the_body(one, clip):
    """Without a root above the hips, which says nothing of a body."""
    if clip.parents.count(0) != 1:
        return one
    return replace(one, names={a: b for a, b in one.names.items() if a != clip.names[0]})


def _blend(options, first, second, base, changed, kind):
    rows = _names("blend", base[0], first.clip, "base")
    rows += _names("blend", changed[0].clip, second.clip, "altered")
    one = changed[0]
    if one.frames is not None:
        return rows
    above = int(base[0].parents.count(0) == 1)
    one = _of_the_body(one, base[0])
    alpha = float(options[1])
    if alpha in (0, 1) and one.exact:
        own, out = base[int(alpha)], first.clip
        rows.append(("rows of a copy", abs(len(own.turns) - len(out.turns)), 0.5))
        if len(own.turns) == len(out.turns):
            away = np.linalg.norm(np.diff(
                (world(out)[1] - world(own)[1])[:, above:], axis=0), axis=-1).max() / height(own)
            rows.append(("a copy", float(away), EXACT))
    if kind == "extra":
        one = replace(one, exact=False)
    return rows + _places(first.clip, second.clip, one, kind)


def _inspect(options, first, second, base, changed, kind):
    one, old, new = changed[0], first.rows, second.rows
    rows = []
    for a, b in zip(old["rows"], new["rows"], strict=True):
        if a["joint"] in one.names or one.exact:
            wanted = one.names.get(a["joint"], a["joint"])
            slot = a["slot"]
            if kind == "mirrored":
                slot = slot.translate(str.maketrans({})).replace("Left", "#").replace(
                    "Right", "Left").replace("#", "Right")
                b = next(row for row in new["rows"] if row["slot"] == slot)
            rows.append((f"{slot}: {b['joint']}, not {wanted}", float(wanted != b["joint"]), 0.5))
    rows.append(("frames", abs(new["frames"] - len(one.clip.turns)), 0.5))
    rows.append(("fps", abs(new["fps"] * one.clip.step - 1), 1e-4))
    near = 1e-4 if one.exact else 0.05
    rows.append(("height", abs(new["height"] / (old["height"] * one.scale) - 1), near))
    axis = one.turn @ np.array([0, 1, 0])
    up = ("-" if axis.sum() < 0 else "") + "xyz"[int(np.abs(axis).argmax())]
    rows.append((f"up {new['up']}, not {up}", float(new["up"] != up), 0.5))
    for key in ("speed, m/s", "steps a minute"):
        if one.exact and kind != "scaled" and old.get(key) is not None:
            rows.append((key, abs(new[key] / (old[key] or 1) - (1 if old[key] else 0)), 1e-3))
    return rows


def _observe(options, first, second, base, changed, kind):
    bound = 0.0101 if changed[0].exact and kind != "extra" else SEEN[kind]
    return [(f"{a['observer']} {key}", abs(a[key] - b[key]), bound)
            for a, b in zip(first.rows["rows"], second.rows["rows"], strict=True)
            for key in ("flow", "weight", "time")]


def _score(options, first, second, base, changed, kind):
    rows = []
    alone = changed[0].clip is base[0] and kind == "moved"
    if not all(one.exact for one in changed):
        return rows
    for a, b in zip(first.rows["rows"], second.rows["rows"], strict=True):
        for key, value in a.items():
            if alone and re.search("floor|foot|ends", key):
                continue
            if isinstance(value, (int, float)):
                if b.get(key) is None:
                    rows.append((f"{key} is gone", 1.0, 0.5))
                else:
                    rows.append((key, abs(b[key] - value), 1e-4 * max(1.0, abs(value))))
            elif value is None and b.get(key) is not None:
                rows.append((f"{key} was none", 1.0, 0.5))
    return rows


def _prepare(options, first, second, base, changed, kind):
    old, new = (np.load(run.folder / "answer.npz") for run in (first, second))
    if not all(one.exact for one in changed):
        return [("arrays", float(old.files != new.files), 0.5)]
    heads = [json.loads(str(kept["header"]))["facts"] for kept in (old, new)]
    rows = []
    for key in old.files:
        if old[key].shape != new[key].shape:
            rows.append((f"{key}: shape", 1.0, 0.5))
        elif key != "header" and old[key].size:
            sizes = [np.ones(old[key].shape[-1]) for _ in heads]
            for size, head in zip(sizes, heads):
                if key in ("features", "bones", "rest"):
                    size[:63] = size[64:] = head["leg"]
            away = np.abs(old[key] / sizes[0] - new[key] / sizes[1])
            rows.append((key, float(away.max()), 1e-3))
    return rows + [(key, float(heads[0][key] != heads[1][key]), 0.5)
                   for key in ("contents", "styles", "names")]


def _segment(options, first, second, base, changed, kind):
    old, new = first.rows["rows"], second.rows["rows"]
    if not changed[0].exact or kind == "extra":  # fragments are compared by all joints of a clip
        return []
    if len(old) != len(new):
        return [("pieces", 1.0, 0.5)]
    return [(key, float(a[key] != b[key]), 0.5) for a, b in zip(old, new)
            for key in ("begin", "end", "content", "fragment", "like")] + [
        (key, abs(a[key] - b[key]), 1e-3 * max(1, abs(a[key]))) for a, b in zip(old, new)
        for key in ("ssd", "distance")]


def _synthesise(options, first, second, base, changed, kind):
    if not changed[0].exact or kind == "extra":  # as `_segment`
        return _names("synthesise", changed[0].clip, second.clip, "altered")
    return _places(first.clip, second.clip, _of_the_body(changed[0], base[0]), kind)


ALL = {"transfer": _transfer, "blend": _blend, "inspect": _inspect, "observe": _observe,
       "score": _score, "prepare": _prepare, "segment": _segment, "synthesise": _synthesise}
