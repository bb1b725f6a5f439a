"""The tables of docs/paper_problem.md and docs/score.md, made of their JSON."""

SYSTEMS = [("style seen by joints", "{:.0%}"), ("style seen by directions", "{:.0%}"),
           ("content seen by joints", "{:.0%}"), ("content seen by directions", "{:.0%}"),
           ("style left (content = 1)", "{:.2f}"), ("Fréchet distance", "{:.0f}"),
           ("path met", "{:.0%}"), ("path error (legs)", "{:.2f}"), ("timing off (s)", "{:.3f}"),
           ("movement kept (correlation)", "{:.2f}"), ("slide (legs/s)", "{:.2f}"),
           ("jerk (legs/s^3)", "{:.0f}"), ("largest acceleration (legs/s^2)", "{:.0f}")]
STYLES = SYSTEMS[:1] + SYSTEMS[2:3] + SYSTEMS[4:5] + SYSTEMS[6:7]
GESTURES = ["excursion (content = 1)", "kept (correlation)", "style left (content = 1)"]


def line(cells):
    return "| " + " | ".join(cells) + " |"


def number(row, name, form):
    value, low, high = (row.get(key) for key in (name, f"{name}, low", f"{name}, high"))
    if value is None:
        return ""
    shown = [form.format(v) for v in (value, *((low, high) if low is not None else ()))]
    return shown[0] if len(set(shown)) == 1 else f"{shown[0]} ({shown[1]} to {shown[2]})"


def systems(report, columns=SYSTEMS, nulls=True):
    rows = [row for row in report["rows"] if row.get("row") == "system"
            and row["system"].startswith("null") <= nulls]
    head = [line(["system", *(name for name, _ in columns)]), line(["---"] * (1 + len(columns)))]
    return head + [line([row["system"], *(number(row, *column) for column in columns)])
                   for row in rows]


def bounds(report):
    said = {True: "yes", False: "no", None: "not told"}
    head = [line(["null", "must show", "so?"]), line(["---"] * 3)]
    return head + [line([row["system"].removeprefix("null: "), row["bound"], said[row["holds"]]])
                   for row in report["rows"] if "bound" in row]


def styles(report, system):
    head = [line(["style", *(name for name, _ in STYLES)]), line(["---"] * (1 + len(STYLES)))]
    return head + [line([row["style"], *(form.format(row[name]) for name, form in STYLES)])
                   for row in report["rows"] if row.get("row") == "style"
                   and row["system"] == system]


def other(report, table, of=None):
    """A table whose columns are the keys of its rows."""
    rows = [{k: v for k, v in row.items() if k not in ("table", "of")} for row in report["rows"]
            if row["table"] == table and of in (None, row.get("of"))]
    keys = list(dict.fromkeys(key for row in rows for key in row))
    cells = [[f"{row[k]:.3g}" if isinstance(row.get(k), float) else str(row.get(k) or "")
              for k in keys] for row in rows]
    return [line(keys), line(["---"] * len(keys)), *map(line, cells)]


def all_tables(report):
    """{name: lines}"""
    found = {"systems": systems(report), "bounds": bounds(report),
             "styles": styles(report, "2017, no clean-up")}
    for of in dict.fromkeys(row["of"] for row in report["rows"] if row["table"] == "statements"):
        found[of] = other(report, "statements", of)
    for table in ("body", "gestures"):
        if any(row["table"] == table for row in report["rows"]):
            found[table] = other(report, table)
    return found


def standing(report):
    """How well results stand (docs/results.md): the content, no clean-up, result."""
    columns = [("knee", "{:.2f}", 1), ("ankle", "{:.2f}", 1), ("elbow", "{:.2f}", 1),
               ("legs' jerk", "{:.2f}", 1), ("slide", "{:.1f}", 1), ("seen", "{:.0f} %", 100),
               ("path", "{:.0f}", 1)]
    rows = {(row["style"], row["what"]): row for row in report["rows"]
            if row["table"] == "results"}
    ways = ("content itself", "no clean-up", "result")
    return [line([style, *("; ".join(form.format(times * rows[style, way][name]) for way in ways)
                           for name, form, times in columns)])
            for style in dict.fromkeys(style for style, _ in rows)]
