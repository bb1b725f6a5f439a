"""A golden folder that is not as it was exported certifies nothing, and says why."""

import json

import numpy as np
import pytest

from refimpl import nn
from refimpl.cli import main
from refimpl.conformance.golden import export, manifest_hash, read_folder, read_manifest
from refimpl.storage import FormatError

OPERATIONS = ["gram", "relu"]


@pytest.fixture
def folder(tmp_path):
    export(tmp_path / "golden", operations=OPERATIONS)
    return tmp_path / "golden"


def edited(folder, change, *, rehash=False):
    """Change the manifest, as by hand; with `rehash` as somebody does who knows of its hash."""
    manifest = json.loads((folder / "manifest.json").read_text())
    change(manifest)
    if rehash:
        manifest["sha256"] = manifest_hash(manifest)
    (folder / "manifest.json").write_text(json.dumps(manifest))


def first(manifest):
    return manifest["cases"][0]


# What a person may do to a manifest: each must be noticed.
EDITS = {
    "no cases": lambda m: m.update(cases=[]),
    "a case gone": lambda m: m["cases"].pop(),
    "a bound raised tenfold": lambda m:
    first(m)["outputs"][0].update(bound=10 * first(m)["outputs"][0]["bound"]),
    "all bounds 1e9": lambda m: [o.update(bound=1e9) for c in m["cases"] for o in c["outputs"]
                                 if o],
    "a bound of null": lambda m: first(m)["outputs"][0].update(bound=None),
    "a bound that is a word": lambda m: first(m)["outputs"][0].update(bound="1"),
    "outputs null": lambda m: first(m).update(outputs=[None]),
    "functions renamed": lambda m: [c.update(function="nonsense") for c in m["cases"]],
    "operation renamed": lambda m: first(m).update(operation="relu"),
    "argument names exchanged": lambda m: next(c for c in m["cases"]
                                               if len(c["arguments"]) > 1)["arguments"].reverse(),
    "equal ids": lambda m: m["cases"][1].update(id=first(m)["id"]),
    "precision": lambda m: first(m).update(precision="float16"),
    "shape": lambda m: first(m)["outputs"][0].update(shape=[1]),
    "a convention changed": lambda m: m["conventions"][0].update(here="another"),
    "a case that is a number": lambda m: m["cases"].append(5),
    "a case that is empty": lambda m: m["cases"].append({}),
    "attributes a list": lambda m: first(m).update(attributes=[1]),
    "a path outside": lambda m: first(m).update(file="../secret.npz"),
    "an absolute path": lambda m: first(m).update(file="/etc/passwd"),
    "an unknown key": lambda m: first(m).update(more=1),
}
# Of these the hash alone could tell; whoever knows of it and mends it is believed.
BY_HASH_ALONE = {"a case gone", "a bound raised tenfold", "a convention changed"}


@pytest.mark.parametrize("name", EDITS)
def test_an_edited_manifest(folder, name, capsys):
    edited(folder, EDITS[name])
    assert main(["check", "--golden", str(folder)]) == 1
    said = capsys.readouterr()
    assert ("manifest.json" in said.out and "verdict: disagrees" in said.out
            and "Traceback" not in said.err)


@pytest.mark.parametrize("name", sorted(EDITS.keys() - BY_HASH_ALONE))
def test_an_edited_manifest_whose_hash_was_mended(folder, name, capsys):
    edited(folder, EDITS[name], rehash=True)
    assert main(["check", "--golden", str(folder)]) == 1
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize("text",
                         ["", "{}", "[]", "null", "nonsense",
                          '{"format": "golden vectors", "format": "golden vectors"}',
                                  '{"format": "golden vectors", "version": 2, "cases": [NaN]}',
                          "[" * 100_000,
                                  '{"format": "golden vectors", "version": 1, "cases": []}',
                          '{"format": "golden vectors", "version": true, "cases": []}'])
def test_what_is_no_manifest(folder, text, capsys):
    (folder / "manifest.json").write_text(text)
    assert main(["check", "--golden", str(folder)]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and "manifest.json" in err
    with pytest.raises(FormatError):
        read_manifest(folder)


def unlisted(folder, victim):
    (folder / "vectors" / "more.npz").write_bytes(victim.read_bytes())


def linked(folder, victim):
    (folder / "elsewhere").write_bytes(victim.read_bytes())
    victim.unlink()
    victim.symlink_to(folder / "elsewhere")


def rewritten(folder, victim, save):
    """The same arrays, written in another way, and the hashes mended."""
    with np.load(victim) as arrays:
        held = dict(arrays)
    save(victim, held)
    import hashlib
    digest = hashlib.sha256(victim.read_bytes()).hexdigest()
    edited(folder, lambda m: next(c for c in m["cases"]
                                  if c["file"].endswith(victim.name)).update(sha256=digest),
           rehash=True)


FILES = {
    "a byte changed": lambda f, v: v.write_bytes(v.read_bytes()[:-1] + b"x"),
    "gone": lambda f, v: v.unlink(),
    "truncated": lambda f, v: v.write_bytes(v.read_bytes()[:100]),
    "a link": linked,
    "a file more": unlisted,
    "compressed": lambda f, v: rewritten(f, v, lambda path,
                                         arrays: np.savez_compressed(path, **arrays)),
    "Fortran order": lambda f,
    v: rewritten(f, v, lambda path,
                 arrays: np.savez(path, **{k: np.asfortranarray(a) for k, a in arrays.items()})),
    "an array more": lambda f,
    v: rewritten(f, v, lambda path, arrays: np.savez(path, more=np.zeros(1), **arrays)),
    "another shape": lambda f,
    v: rewritten(f, v, lambda path,
                 arrays: np.savez(path, **{k: a[None] for k, a in arrays.items()})),
    "other outputs": lambda f,
    v: rewritten(f, v, lambda path,
                 arrays: np.savez(path, **{k: a + (k[:3] == "out") for k, a in arrays.items()})),
}


@pytest.mark.parametrize("name", FILES)
def test_files_that_are_not_the_exported_ones(folder, name, capsys):
    victim = folder / "vectors" / "gram-plain-forward-float64.npz"
    FILES[name](folder, victim)
    assert main(["check", "--golden", str(folder)]) == 1
    assert ("gram-plain-forward-float64"
            in capsys.readouterr().out.replace("gram/plain/forward/float64",
                                               "gram-plain-forward-float64")
            or name == "a file more")


def test_only_what_ran_is_certified(folder, tmp_path, monkeypatch, capsys):
    (tmp_path / "part.py").write_text(
        "from refimpl import nn\nONE = {'gram': nn.gram}\nOTHER = {'norm': nn.norm}\n")
    monkeypatch.chdir(tmp_path)
    assert main(["check", "part:ONE", "--golden", "golden"]) == 0
    said = capsys.readouterr().out
    assert "not offered" in said and "gram_backward" in said
    assert main(["check", "part:ONE", "--golden", "golden", "--require", "all"]) == 1
    assert main(["check", "part:ONE", "--golden", "golden", "--require", "gram"]) == 0
    assert main(["check", "part:ONE", "--golden", "golden", "--require", "gram_backward"]) == 1
    assert main(["check", "part:OTHER", "--golden", "golden"]) == 1
    assert "nothing checked" in capsys.readouterr().out


def test_golden_vectors_see_what_the_kit_sees(folder, tmp_path, monkeypatch, capsys):
    """Precision, a changed argument, another convention: told alike with and without a folder."""
    (tmp_path / "faulty.py").write_text(
        "import numpy as np\nfrom refimpl import nn\n"
        "WIDE = {'gram': lambda h: nn.gram(h.astype(float))}\n"
        "FRAMES = {'gram': lambda h: nn.gram(h) / h.dtype.type(h.shape[2])}\n"
        "def changes(h):\n    y = nn.gram(h)\n    h *= 2\n    return y\nCHANGES = {'gram': "
        "changes}\n")
    monkeypatch.chdir(tmp_path)
    for name, words in (("WIDE", "found dtype float64, needed float32"),
                        ("FRAMES", "It matches a Gram matrix divided by the frames"),
                        ("CHANGES", "changed its argument h")):
        assert main(["check", f"faulty:{name}", "--golden", "golden"]) == 1
        assert words in capsys.readouterr().out


def test_flags_beside_golden_work_or_are_refused(folder, tmp_path, monkeypatch, capsys):
    (tmp_path / "wrong.py").write_text(
        "from refimpl import nn\nMINE = {'gram': lambda h: 2 * nn.gram(h), 'relu': nn.relu}\n")
    monkeypatch.chdir(tmp_path)
    run = ["check", "wrong:MINE", "--golden", "golden"]
    assert main([*run, "--json", "a.json", "--junit", "a.xml"]) == 1
    report = json.loads((tmp_path / "a.json").read_text())
    assert (report["verdict"] == "disagrees" and report["settings"]["golden"] == "golden"
            and (tmp_path / "a.xml").exists())
    assert main([*run, "--operations", "relu"]) == 0
    (tmp_path / "known").write_text("gram/*\n")
    capsys.readouterr()
    assert (main([*run, "--operations", "swim"]) == 2 and main([*run, "--seed", "1"]) == 2
            and main([*run, "--xfail", "nowhere"]) == 2)
    assert capsys.readouterr().err.count("refimpl: error:") == 3
    assert main([*run, "--xfail", "known"]) in (0, 1)
    assert "xfailed" in capsys.readouterr().out


def test_a_backends_own_tolerance_counts_there_too(folder, tmp_path, monkeypatch):
    (tmp_path / "rough.py").write_text(
        "from refimpl import nn\nF = lambda h: nn.gram(h) * h.dtype.type(1 + 1e-6)\n"
                                       "STRICT = {'gram': F}\nLOOSE = {'gram': F, 'tolerances': "
                                       "{'float64': 1e-5, 'float32': 1e-4}}\n")
    monkeypatch.chdir(tmp_path)
    assert main(["check", "rough:STRICT", "--golden", "golden"]) == 1
    assert main(["check", "rough:LOOSE", "--golden", "golden"]) == 0


def test_the_reference_passes_its_own_folder(folder):
    found, wrong = read_folder(folder)
    assert wrong == [] and len(found) > 20
    for case in found:
        case.check({"gram": nn.gram, "gram_backward": nn.gram_backward, "relu": nn.relu,
                    "relu_backward": nn.relu_backward})
