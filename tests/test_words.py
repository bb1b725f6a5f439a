"""One word, one meaning: the glossary of CONTRIBUTING.md, and public names that stand in two
places.
"""

import ast
from collections import defaultdict
from pathlib import Path
import re

import refimpl

ROOT = Path(refimpl.__file__).parent
# The same thing in another form: the kit's second derivations and its functions of arrays, the fast
# forms, the predecessor's form of what 2017 has, and what every command has.
MIRRORS = ("conformance/", "fast/", "holden2016/", "commands/", "experiments/peer_",
           "__main__", "adapters/")
# The features' and the network's: each room's users look for these names.
STILL = {"encode", "decode"}


def defined():
    """{public name: files outside the mirrors that define it}"""
    found = defaultdict(list)
    for path in sorted(ROOT.rglob("*.py")):
        name = path.relative_to(ROOT).as_posix()
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            targets = (node.targets if isinstance(node, ast.Assign) else [node.target]
                       if isinstance(node, ast.AnnAssign) else [])
            names = [x.id for target in targets for x in ast.walk(target)
                     if isinstance(x, ast.Name)]
            names += [node.name] if isinstance(node, (ast.FunctionDef, ast.ClassDef)) else []
            for word in names:
                if not word.startswith("_") and not name.startswith(MIRRORS):
                    found[word].append(name)
    return found


def test_the_glossary_holds_at_most_forty_words():
    text = (ROOT.parent / "CONTRIBUTING.md").read_text(encoding="utf-8").partition("## Words")[2]
    words = re.findall(r"^\| ([^|]+) \| [^|]+ \|$", text, re.MULTILINE)[1:]
    words = [word for word in words if not word.startswith("---")]
    assert 20 <= len(words) <= 40 and len(set(words)) == len(words)


def test_no_public_name_has_a_second_meaning_that_is_not_known():
    twice = {word: files for word, files in defined().items() if len(files) > 1}
    assert {word: files for word, files in twice.items() if word not in STILL} == {}
    assert STILL <= set(twice), sorted(STILL - set(twice))
