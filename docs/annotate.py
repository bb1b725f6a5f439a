"""Writes the annotated papers, `holden2017.md` and `torresani2006.md`, and the pages on
conventions:

    python docs/annotate.py             # writes
    python docs/annotate.py --check     # says what differs, and writes nothing

What a page shows of the code, the kit and the departures is read from them.
"""

import argparse
import inspect
from pathlib import Path
import pkgutil
import re
import sys
import textwrap

from refimpl.conformance.backend import OPERATIONS
from refimpl.conformance.rivals import RIVALS
from refimpl.nn.conventions import CONVENTIONS

import statements

HERE = Path(__file__).parent
ROOT = HERE.parent


def departures():
    """{first cell: (here, reason)} of the table in departures.md"""
    rows = [re.split(r"(?<!\\) \| ", line.strip().strip("|").strip())
            for line in (HERE / "departures.md").read_text(encoding="utf-8").splitlines()
            if line.startswith("| ")]
    return {row[0]: (row[1], row[2]) for row in rows if len(row) == 3}


def source(dotted):
    """The text of a function beside its name, as Markdown."""
    thing = pkgutil.resolve_name(f"refimpl.{dotted}")
    path = Path(inspect.getsourcefile(thing)).resolve().relative_to(ROOT)
    text = textwrap.dedent(inspect.getsource(thing)).rstrip()
    return [f"[`{dotted}`](../{path})", "", "```python", text, "```", ""]


def kit(names):
    """What the kit holds an implementation to."""
    lines = []
    for name in names:
        rivals = [label for function in (name, f"{name}_backward")
                  for label, _ in RIVALS.get(function, ())]
        gradient = f" and `{name}_backward`" if OPERATIONS[name].backward else ""
        told = f"; told by name: {', '.join(dict.fromkeys(rivals))}" if rivals else ""
        lines.append(f"`{name}`{gradient} (`refimpl check --explain {name}`){told}")
    return ". ".join(lines)


def notebook(number):
    path = next((ROOT / "notebooks").glob(f"{number}_*.ipynb"))
    return f"[{number}](../notebooks/{path.name})"


def page(paper):
    """One paper in its own order."""
    rows = departures()
    lines = [f"# {paper.title}", "", paper.lead, "",
             "Written by `python docs/annotate.py` from the docstrings, the conformance kit and "
             "the [departures](departures.md).", ""]
    lines += [" · ".join(f"[{s.title.split(':')[0]}](#{anchor(s.title)})"
                         for s in paper.statements if re.match("Equation|Table|Figure", s.title)),
              ""]
    for s in paper.statements:
        lines += [f"## {s.title}", "", s.says, ""]
        for formula in s.formulas:
            lines += ["$$", formula, "$$", ""]
        for dotted in s.functions:
            lines += source(dotted)
        for key in s.departures:
            here, reason = rows[key]
            lines += [f"- **Departure** ({key}): {here}. *Why:* {reason}."]
        if s.here:
            lines += [f"- **Here**: {s.here}"]
        if s.operations:
            lines += [f"- **In the kit**: {kit(s.operations)}."]
        if s.notebooks:
            lines += [f"- **Notebook**: {', '.join(map(notebook, s.notebooks))}."]
        if s.witness:
            lines += [f"- **Witness**: {s.witness}"]
        lines += [""]
    return "\n".join(lines).rstrip() + "\n"


def anchor(title):
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def conventions():
    """{path: text}: one choice a page, and the page that lists them."""
    pages, index = {}, [
        "# Conventions on which implementations differ", "",
        "Where the mathematics leaves a choice, this is what holds here and what others do. "
        "`refimpl check` recognises most of these by name in somebody else's answers. Each page "
        "has an input on which the two answers differ.", "",
        "| where | here | others |", "| --- | --- | --- |"]
    for c in CONVENTIONS:
        name = re.sub(r"\W+", "_", re.sub(r"[|']", "", c.where).lower()).strip("_")[:40]
        title = c.where.replace("|", "\\|")
        others = "; ".join(f"{rule} ({who})" for rule, who in c.rivals) or "none known"
        index.append(f"| [{title}](conventions/{name}.md) | {c.here} | {others} |")
        lines = [f"# {c.where[0].upper() + c.where[1:]}", "", f"**Here:** {c.here}.", "",
                 f"*Why:* {c.why}.", ""]
        lines += [f"**Others:** {rule}. *Who:* {who}.\n" for rule, who in c.rivals]
        lines += ["```pycon", textwrap.dedent(statements.EXAMPLES[c.where]).strip(), "```", ""]
        lines += ["[All conventions](../conventions.md)", ""]
        pages[f"conventions/{name}.md"] = "\n".join(lines)
    return {"conventions.md": "\n".join(index) + "\n", **pages}


def pages():
    """{path below docs: text}"""
    return {"holden2017.md": page(statements.HOLDEN),
            "torresani2006.md": page(statements.TORRESANI), **conventions()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="say what differs, write nothing")
    check, differ = parser.parse_args().check, []
    for name, text in pages().items():
        path = HERE / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            differ.append(name)
            if not check:
                path.parent.mkdir(exist_ok=True)
                path.write_text(text, encoding="utf-8")
    print("\n".join(differ) or "nothing differs")
    return 1 if check and differ else 0


if __name__ == "__main__":
    sys.exit(main())
