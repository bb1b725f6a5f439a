"""A golden folder that is not as it was exported certifies nothing, and says why."""

from dataclasses import replace
import hashlib
import io
import json
import shutil

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from refimpl import nn
from refimpl.cli import main
from refimpl.conformance import OPERATIONS, cases
from refimpl.conformance.golden import ZEROS, export, manifest_hash, read_folder
from refimpl.conformance.recompute import objections
from refimpl.conformance.schema import CASE, SCHEMA, facts, mistakes, read_manifest
from refimpl.conformance.vectors import case_files, described, read_npy, with_answers
from refimpl.storage import FormatError

CHOSEN = ["gram", "max_pool1d", "relu"]
NAME = "gram-plain-forward-float64"


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    folder = tmp_path_factory.mktemp("exported") / "golden"
    export(folder, operations=CHOSEN)
    return folder


@pytest.fixture
def folder(exported, tmp_path):
    return shutil.copytree(exported, tmp_path / "golden")


def edited(folder, change, *, rehash=False):
    """Change the manifest, as by hand; with `rehash` as somebody does who knows of its hash."""
    manifest = json.loads((folder / "manifest.json").read_text())
    change(manifest)
    if rehash:
        manifest["sha256"] = ZEROS
    text = json.dumps(manifest)
    if rehash:
        text = text.replace(ZEROS, manifest_hash(text, ZEROS))
    (folder / "manifest.json").write_text(text)


def first(manifest):
    return manifest["cases"][0]


def pool(manifest):
    return next(c for c in manifest["cases"] if c["id"] == "max_pool1d/plain/forward/float64")


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
    "a case twice": lambda m: m["cases"].append(first(m)),
    "an unknown key": lambda m: first(m).update(more=1),
    "an operation gone": lambda m: m.update(
        cases=[c for c in m["cases"] if c["operation"] != "relu"]),
    "bounds without allowances": lambda m: first(m)["outputs"][0].pop("allowed"),
    "an allowance that is an answer": lambda m: first(m)["outputs"][0].update(allowed="out0"),
    "exact denied": lambda m: [c.update(exact=not c["exact"]) for c in m["cases"]],
    "another type": lambda m: first(m)["outputs"][0].update(dtype="float16"),
    "an option left unsaid": lambda m: pool(m)["attributes"].pop("stride"),
    "another option": lambda m: pool(m)["attributes"]["padding"].update(value=1),
    "a default said to be given": lambda m: pool(m)["attributes"]["padding"].pop("default"),
    "a width left unsaid": lambda m: pool(m)["arguments"].pop(),
    "the name of an output": lambda m: first(m)["outputs"][0].update(name="G"),
    "a formula changed": lambda m: m["operations"]["gram"]["text"].append("divided by T"),
    "a constant changed": lambda m: m["constants"].update(feet=[1, 2, 3, 4]),
    "a hash gone": lambda m: first(m)["files"].popitem(),
    "a hash of a file elsewhere": lambda m: first(m)["files"].update({"../x.npy": ZEROS}),
    "the hash of the README gone": lambda m: m["files"].pop("README.txt"),
    "an id that no terminal shows": lambda m: first(m).update(id="gram/\x1b[2J/forward/float64"),
    "an id of nobody": lambda m: first(m).update(id="gram/another/forward/float64"),
    "true for 1": lambda m: pool(m)["attributes"]["dilation"].update(value=True),
    "1.0 for 1": lambda m: pool(m)["attributes"]["dilation"].update(value=1.0),
    "another equation": lambda m: first(m).update(equation="equation 7"),
    "the meaning of a word": lambda m: m.update(allowed="anything"),
    "a formula gone": lambda m: m["operations"].pop("relu"),
    "a formula more": lambda m: m["operations"].update(grim=m["operations"]["gram"]),
    "no hash at all": lambda m: m.pop("sha256"),
}


@pytest.mark.parametrize("name", EDITS)
def test_an_edited_manifest(folder, name, capsys):
    edited(folder, EDITS[name])
    assert main(["check", "--golden", str(folder)]) == 1
    said = capsys.readouterr()
    assert ("manifest.json" in said.out and "verdict: disagrees" in said.out
            and "Traceback" not in said.err)


@pytest.mark.parametrize("name", EDITS)
def test_an_edited_manifest_whose_hash_was_mended(folder, name, capsys):
    if name == "an operation gone":                              # such a folder might be exported
        return
    edited(folder, EDITS[name], rehash=name != "no hash at all")
    assert main(["check", "--golden", str(folder)]) == 1
    assert "Traceback" not in capsys.readouterr().err


def test_another_release_may_have_other_texts_but_no_other_answers(folder):
    for name in ("a convention changed", "a formula changed", "a constant changed"):
        edited(folder, EDITS[name], rehash=True)
    edited(folder, lambda m: m.update(made_by="refimpl 0.0.1"), rehash=True)
    assert main(["check", "--golden", str(folder)]) == 0
    entry, arrays = stored(folder)
    assert answered_anew(folder, entry, {**arrays, "out0": 1.001 * arrays["out0"]}) == [
        f"{entry['id']}: is not the answer to its inputs"]


@pytest.mark.parametrize("name", ["README.txt", "manifest.schema.json"])
def test_a_text_whose_hash_was_mended(folder, name, capsys):
    text = (folder / name).read_text().replace("3", "4").encode()
    (folder / name).write_bytes(text)
    edited(folder, lambda m: m["files"].update({name: hashlib.sha256(text).hexdigest()}),
           rehash=True)
    assert main(["check", "--golden", str(folder)]) == 1
    assert f"{name}: is not that of refimpl" in capsys.readouterr().out


def test_a_case_that_is_taken_out_or_put_in(folder):
    def _without(manifest):
        entry = next(c for c in manifest["cases"] if c["folder"] == f"vectors/{NAME}")
        manifest["cases"].remove(entry)
        shutil.rmtree(folder / entry["folder"])
        (folder / entry["file"]).unlink()
    edited(folder, _without, rehash=True)
    found, wrong = read_folder(folder)
    assert wrong == [] and list(objections(folder, found)) == [
        "gram/plain/forward/float64: found no such case, needed all of its operation"]
    found[0] = replace(found[0], id="gram/another/forward/float32")
    assert "gram/another/forward/float32: found a case that" in "".join(objections(folder, found))


def test_any_seed_and_any_choice_of_operations_is_as_it_was_exported(tmp_path):
    """Also of an operation whose answers are searched for, and of trained networks."""
    export(tmp_path, seed=7, operations=["conv1d", "support_vector_regression", "total_loss", "l1",
                                         "train_loss_network", "autoencoder_loss", "best_pair"])
    found, wrong = read_folder(tmp_path)
    assert wrong == [] == list(objections(tmp_path, found))


def test_where_a_manifest_is_wrong_is_said(folder, capsys):
    lines = (folder / "manifest.json").read_text().splitlines()
    number = next(n for n, line in enumerate(lines) if '"bound": ' in line and "e-" in line)
    (folder / "manifest.json").write_text("\n".join(
        [*lines[:number], '     "bound": NaN', *lines[number + 1:]]))
    assert main(["check", "--golden", str(folder)]) == 2
    assert f"NaN is no number: line {number + 1})" in capsys.readouterr().err
    (folder / "manifest.json").write_text('{"format": "golden vectors", "version": 3,\n'
                                          ' "version": 3}')
    assert main(["check", "--golden", str(folder)]) == 2
    assert "the key 'version' stands 2 times" in capsys.readouterr().err


def test_a_case_that_is_no_case_is_called_by_its_id(folder, capsys):
    edited(folder, lambda m: pool(m)["attributes"].update(stride=2), rehash=True)
    assert main(["check", "--golden", str(folder)]) == 1
    assert "attributes.stride: found 2, needed object (max_pool1d/plain/forward/float64)" in (
        capsys.readouterr().out)


def test_an_option_said_to_be_given_is_not_as_it_was_exported(folder):
    found, _ = read_folder(folder)
    name = "max_pool1d/plain/forward/float64"
    number = next(n for n, case in enumerate(found) if case.id == name)
    found[number] = replace(found[number], attributes={"padding": 0})
    assert [line.partition(":")[0] for line in objections(folder, found)] == [name]


@pytest.mark.parametrize("name", [None, *EDITS])
def test_the_schema_says_what_a_validator_of_json_schema_says(exported, name):
    jsonschema = pytest.importorskip("jsonschema")
    manifest = json.loads((exported / "manifest.json").read_text())
    schema = json.loads((exported / "manifest.schema.json").read_text())
    assert schema == json.loads(json.dumps(SCHEMA))
    if name:
        EDITS[name](manifest)
    assert jsonschema.Draft202012Validator(schema).is_valid(manifest) == (not list(
        mistakes(manifest))), name


@pytest.mark.parametrize("value, schema, words", [
    (True, {"type": "integer"}, "found true, needed integer"), (1, {"const": True}, "needed true"),
    (1.5, {"type": ["integer", "null"]}, "needed integer or null"),
    ("x", {"enum": ["a", "b"]}, "needed one of a, b"), ("x", {"pattern": "^y"}, "needed ^y"),
    ([], {"minItems": 1}, "found 0 items"), (0.2, {"maximum": 0.1}, "needed at most 0.1"),
    (0, {"exclusiveMinimum": 0}, "needed above 0"), ({}, {"required": ["a"]}, "found no 'a'"),
    ({"a": 1}, {"additionalProperties": False}, "found 'a'"),
    ({"a": [1]}, {"properties": {"a": {"items": {"type": "string"}}}}, "a[0]: found 1"),
    ({"a": 1, "b": 1}, {"oneOf": [{"required": ["a"]}, {"required": ["b"]}]}, "either a or b")])
def test_a_mistake_is_named(value, schema, words):
    said, = mistakes(value, schema)
    assert words in said


@pytest.mark.parametrize("text", [
    "", "{}", "[]", "null", "nonsense", '{"format": "golden vectors", "format": "golden vectors"}',
    '{"format": "golden vectors", "version": 3, "cases": [NaN]}', "[" * 100_000, "\ufeff{}",
    '{"format": "golden vectors", "version": 2, "cases": []}',
    '{"format": "golden vectors", "version": true, "cases": []}'])
def test_what_is_no_manifest(folder, text, capsys):
    (folder / "manifest.json").write_text(text)
    assert main(["check", "--golden", str(folder)]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and "manifest.json" in err
    with pytest.raises(FormatError):
        read_manifest(folder)


def linked(path):
    there = path.rename(path.parent.parent.parent / "elsewhere")
    path.symlink_to(there)


PATHS = (f"vectors/{NAME}.npz", f"vectors/{NAME}/in0.npy", f"vectors/{NAME}/allowed0.npy",
         f"vectors/{NAME}/case.json", "README.txt", "manifest.schema.json")
HARM = {
    "a byte changed": lambda path: path.write_bytes(path.read_bytes()[:-1] + b"x"),
    "gone": lambda path: path.unlink(),
    "truncated": lambda path: path.write_bytes(path.read_bytes()[:100]),
    "a folder": lambda path: (path.unlink(), path.mkdir()),
    "a link": linked,
}


@pytest.mark.parametrize("harm", HARM)
@pytest.mark.parametrize("name", PATHS)
def test_a_file_that_is_not_the_exported_one(folder, name, harm, capsys):
    HARM[harm](folder / name)
    assert main(["check", "--golden", str(folder)]) == 1
    said = capsys.readouterr()
    assert [name in line for line in said.out.splitlines()].count(True) == 1
    assert "verdict: disagrees" in said.out and "Traceback" not in said.err


@pytest.mark.parametrize("name", ["vectors/more.npz", "vectors/more", f"vectors/{NAME}/out1.npy",
                                  "vectors/more/in0.npy"])
def test_a_file_more(folder, name, capsys):
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / name).write_text("more")
    assert main(["check", "--golden", str(folder)]) == 1
    assert f"{name}: found what the manifest does not list" in capsys.readouterr().out


def test_a_folder_more(folder, capsys):
    (folder / "vectors" / NAME / "more").mkdir()
    assert main(["check", "--golden", str(folder)]) == 1
    assert f"vectors/{NAME}/more: found what" in capsys.readouterr().out


def test_a_folder_that_is_a_link(folder, tmp_path, capsys):
    (folder / "vectors" / NAME).rename(tmp_path / "elsewhere")
    (folder / "vectors" / NAME).symlink_to(tmp_path / "elsewhere")
    assert main(["check", "--golden", str(folder)]) == 1
    assert f"vectors/{NAME}: found what" in capsys.readouterr().out


def rewritten(folder, save):
    """The same arrays of a case, written in another way, and the hashes mended."""
    place = folder / "vectors" / NAME
    with np.load(f"{place}.npz") as arrays:
        held = dict(arrays)
    save(place, held)

    def _mended(manifest):
        entry = next(c for c in manifest["cases"] if c["folder"] == f"vectors/{NAME}")
        entry["sha256"] = hashlib.sha256((place.parent / f"{NAME}.npz").read_bytes()).hexdigest()
        entry["files"] = {name: hashlib.sha256((place / name).read_bytes()).hexdigest()
                          for name in entry["files"]}
    edited(folder, _mended, rehash=True)


def everywhere(change):
    """Arrays changed in the archive and beside it."""
    def save(place, arrays):
        arrays = {name: change(name, array) for name, array in arrays.items()}
        np.savez(f"{place}.npz", **arrays)
        for name, array in arrays.items():
            np.save(place / f"{name}.npy", array)
    return save


REWRITTEN = {
    "compressed": lambda place, arrays: np.savez_compressed(f"{place}.npz", **arrays),
    "an array more": lambda place, arrays: np.savez(f"{place}.npz", more=np.zeros(1), **arrays),
    "an array gone": lambda place, arrays: np.savez(f"{place}.npz", in0=arrays["in0"]),
    "other answers in the archive alone": lambda place, arrays: np.savez(
        f"{place}.npz", **{**arrays, "out0": arrays["out0"] + 1}),
    "other answers beside it alone": lambda place, arrays: np.save(
        place / "out0.npy", arrays["out0"] + 1),
    "another header": lambda place, arrays: (place / "in0.npy").write_bytes(
        (place / "in0.npy").read_bytes().replace(b"'descr'", b'"descr"')),
    "another case.json": lambda place, arrays: (place / "case.json").write_text(
        (place / "case.json").read_text().replace("equation 6", "equation 7")),
    "Fortran order": everywhere(lambda name, a: np.asfortranarray(a)),
    "Fortran order in the archive alone": lambda place, arrays: np.savez(
        f"{place}.npz", **{name: np.asfortranarray(a) for name, a in arrays.items()}),
    "big-endian": everywhere(lambda name, a: a.astype(">f8")),
    "another shape": everywhere(lambda name, a: a[None]),
    "another type": everywhere(lambda name, a: a.astype("<f4")),
    "allowed more": everywhere(lambda name, a: a * 1e6 if name == "allowed0" else a),
    "allowed infinity": everywhere(lambda name, a: a * np.inf if name == "allowed0" else a),
    "allowed nothing": everywhere(lambda name, a: a * np.nan if name == "allowed0" else a),
    "allowed less than nothing": everywhere(
        lambda name, a: np.where(a == a.min(), -a, a) if name == "allowed0" else a),
    "complex": everywhere(lambda name, a: a + 1j),
    "words": everywhere(lambda name, a: a.astype(str)),
}


@pytest.mark.parametrize("name", REWRITTEN)
def test_files_whose_hashes_were_mended(folder, name, capsys):
    rewritten(folder, REWRITTEN[name])
    complaint, = read_folder(folder)[1]
    assert main(["check", "--golden", str(folder)]) == 1
    said = capsys.readouterr()
    assert (NAME in complaint.replace("/", "-") and complaint in said.out
            and "verdict: disagrees" in said.out and "Traceback" not in said.err)


def remade(folder, entry, outputs, arrays):
    """A case written anew by somebody who mends every number and every hash.   ->  complaints"""
    place = folder / entry["folder"]
    for path in place.iterdir():
        path.unlink()
    files = case_files({**{key: entry[key] for key in CASE}, "outputs": outputs}, arrays)
    for name, data in files.items():
        (place / name).write_bytes(data)
    np.savez(folder / entry["file"], **arrays)

    def _mended(manifest):
        mine = next(c for c in manifest["cases"] if c["id"] == entry["id"])
        mine["outputs"] = outputs
        mine["sha256"] = hashlib.sha256((folder / entry["file"]).read_bytes()).hexdigest()
        mine["files"] = {name: hashlib.sha256(data).hexdigest() for name, data in files.items()}
    edited(folder, _mended, rehash=True)
    return read_folder(folder)[1]


def test_what_is_exact_is_not_allowed_more_and_nothing_is_no_answer(folder):
    entry = next(c for c in read_manifest(folder)["cases"] if c["exact"])
    with np.load(folder / entry["file"]) as found:
        arrays = dict(found)
    assert arrays["allowed0"].max() > 0
    output, = entry["outputs"]
    assert remade(folder, entry, [output], arrays) == []
    complaint, = remade(folder, entry, [{**output, "bound": 2 * output["bound"]}],
                        {**arrays, "allowed0": 2 * arrays["allowed0"]})
    assert "another allowance than what is exact may have" in complaint
    inputs = {name: array for name, array in arrays.items() if name.startswith("in")}
    assert "outputs: found none" in remade(folder, entry, [None], inputs)[0]


def stored(folder, name=NAME):
    """A case's entry and its arrays."""
    entry = next(c for c in read_manifest(folder)["cases"] if c["folder"] == f"vectors/{name}")
    with np.load(folder / entry["file"]) as found:
        return entry, dict(found)


def answered_anew(folder, entry, arrays):
    """Arrays of a case in the place of others, and all that follows from them.   ->  objections"""
    case = next(case for case in read_folder(folder)[0] if case.id == entry["id"])
    made = replace(case, arguments=tuple(arrays[f"in{n}"] for n in range(len(case.arguments))))
    again, _ = with_answers(*described(made), [(arrays["out0"], arrays["allowed0"])])
    assert remade(folder, entry, again["outputs"], arrays) == []
    return [line.partition(";")[0] for line in objections(folder, read_folder(folder)[0])]


@pytest.mark.parametrize("change, said", [
    ({"out0": lambda y: y + 1e-3}, "is not the answer to its inputs"),
    ({"in0": lambda h: 2 * h}, "is not the answer to its inputs"),
    ({"allowed0": lambda a: 1000 * a}, "allows its answer to be off by more"),
    ({"out0": lambda y: 1.001 * y, "allowed0": lambda a: a + 0.1}, "allows its answer to be off"),
    ({"in0": lambda h: 2 * h, "out0": lambda y: 4 * y, "allowed0": lambda a: 4 * a}, ""),
    ({"allowed0": lambda a: 0.5 * a}, "")])
def test_what_a_case_says_is_computed_again(folder, change, said):
    """Whoever mends every hash must still be right: the last two are."""
    entry, arrays = stored(folder)
    arrays |= {name: alter(arrays[name]) for name, alter in change.items()}
    found = answered_anew(folder, entry, arrays)
    assert [entry["id"] in line and said in line for line in found] == [True] * bool(said)


def test_nothing_is_left_unsaid(exported):
    """Every argument and option of every case, by name; what was not given is marked."""
    manifest = read_manifest(exported)
    for entry in manifest["cases"]:
        known = manifest["operations"][entry["operation"]]
        names = [given["name"] for given in entry["arguments"]]
        assert names[-len(known["arguments"]):] == known["arguments"]
        assert list(entry["attributes"]) and set(entry["attributes"]) == set(known["options"]) or (
            known["options"] == [])
        for name, given in [*zip(names, entry["arguments"]), *entry["attributes"].items()]:
            assert "default" not in given or given["value"] == known["defaults"][name]
    plain = pool(manifest)
    assert plain["arguments"][1] == {"name": "width", "value": 2, "default": True}
    assert plain["attributes"]["ceil_mode"] == {"value": False, "default": True}
    assert set(manifest["operations"]) == set(OPERATIONS)        # a formula may name another
    assert "G[n, c, d] = sum_t" in "\n".join(manifest["operations"]["gram"]["text"])
    assert manifest["constants"]["weights of total_loss"]["norm"]["turn"] == 10000.0
    assert manifest["constants"]["joints"][manifest["constants"]["feet"][0]] == "LeftFoot"


@pytest.mark.parametrize("mode", ["reflect", "nearest"])
def test_the_gaussian_filter_is_what_the_manifest_says(mode):
    assert "floor(4 sigma + 1/2)" in facts()["constants"]["gaussian_filter1d(x, sigma)"]
    x, sigma = np.array([3.0, 1.0, 4.0, 1.0, 5.0, 9.0, 2.0, 6.0, 5.0, 3.0]), 1.7
    k = np.arange(-7, 8)                                         # floor(6.8 + 0.5) = 7
    g = np.exp(-k ** 2 / (2 * sigma ** 2))
    wide = np.pad(x, 7, mode="symmetric" if mode == "reflect" else "edge")
    np.testing.assert_allclose(gaussian_filter1d(x, sigma, mode=mode),
                               np.convolve(wide, g / g.sum(), "valid"), rtol=1e-12)


def test_equation_7_is_what_the_manifest_says():
    said = facts()["constants"]
    assert "omega x p = (turn p_z, 0, -turn p_x)" in said["equation 7"]
    motion = np.random.default_rng(0).normal(size=(1, 66, 2))
    rows, p = said["rows of the 66 numbers"], motion[0, :63].reshape(21, 3, 2)
    turn, forward, sideways = (motion[0, rows[name], 0] for name in ("turn", "forward", "sideways"))
    contacts = np.array([[[1, 0], [0, 0], [0, 0], [0, 0]]])
    (x, _, z), moved = p[said["feet"][0], :, 0], np.diff(p[said["feet"][0]])[:, 0]
    v = np.array([sideways + turn * z, 0.0, forward - turn * x]) + moved
    np.testing.assert_allclose(OPERATIONS["foot_loss"].f(motion, contacts), [v @ v])


def test_every_case_can_be_written_and_read_back(tmp_path):
    """Of the operations with the most kinds of arguments; a backend is given nothing more."""
    chosen = ["bone_loss", "principal_components", "max_unpool1d", "adam_step", "conv1d"]
    export(tmp_path, operations=chosen)
    found, wrong = read_folder(tmp_path)
    made = [case for case in cases(operations=chosen, profile="small")
            if case.kind in ("float64", "float32", "empty batch")]
    assert wrong == [] and len(found) == len(made)
    for a, b in zip(found, made):
        assert a.id == b.id and a.precision == b.precision and a.exact == b.exact
        assert list(a.attributes) == list(b.attributes) and len(a.arguments) == len(b.arguments)
        for x, y in zip((*a.arguments, *a.attributes.values(), *a.expected),
                        (*b.arguments, *b.attributes.values(), *b.expected)):
            np.testing.assert_array_equal(x, y)
        for x, y, out in zip(a.allowances(), b.allowances(), b.expected):
            if out is not None:
                np.testing.assert_allclose(*(np.broadcast_to(z, out.shape) for z in (x, y)),
                                           rtol=1e-12, atol=1e-320)


def test_a_folder_of_a_case_needs_no_archive(exported):
    place = exported / "vectors" / NAME
    case = json.loads((place / "case.json").read_text())
    entry = next(c for c in read_manifest(exported)["cases"] if c["id"] == case["id"])
    assert {key: entry[key] for key in case} == case
    h, wanted, allowed = (read_npy((place / f"{name}.npy").read_bytes())
                          for name in ("in0", "out0", "allowed0"))
    assert (np.abs(np.einsum("nct,ndt->ncd", h, h) - wanted) <= allowed).all()
    assert (place / "case.json").read_text().splitlines()[2] == ' "operation": "gram",'


@pytest.mark.parametrize("harm", [
    lambda d: b"", lambda d: d[:5], lambda d: d[:40], lambda d: b"x" + d, lambda d: d[:-1],
    lambda d: d + b"x", lambda d: d.replace(b"<f8", b">f8"), lambda d: d.replace(b"<f8", b"|O8"),
    lambda d: d.replace(b"<f8", b"<c8"), lambda d: d.replace(b"False", b"True "),
    lambda d: d.replace(b"(2, 3)", b"(3, 3)"), lambda d: d.replace(b"(2, 3)", b"(-2,3)"),
    lambda d: d.replace(b"(2, 3)", b"('2',)"), lambda d: d.replace(b"'shape'", b"' shape"),
    lambda d: d.replace(b"{'descr", b"{{{{(((")])
def test_what_is_no_npy_file_is_refused(harm):
    file = io.BytesIO()
    np.save(file, np.arange(6.0).reshape(2, 3))
    assert read_npy(file.getvalue()).tolist() == [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]
    with pytest.raises(ValueError, match="found"):
        read_npy(harm(file.getvalue()))


def test_what_was_exported_before_is_taken_away_and_nothing_else(folder):
    (folder / "vectors" / "relu-plain-forward-float64" / "notes.txt").write_text("mine")
    export(folder, operations=["gram"])
    left = {path.relative_to(folder / "vectors").as_posix()
            for path in (folder / "vectors").rglob("*") if "gram" not in str(path)}
    assert left == {"relu-plain-forward-float64", "relu-plain-forward-float64/notes.txt"}


@pytest.mark.parametrize("name", ["README.txt", "manifest.json", "manifest.schema.json"])
def test_nobodys_file_is_overwritten(tmp_path, name, capsys):
    (tmp_path / name).write_text('{"name": "mine"}')
    assert main(["export", str(tmp_path), "--operations", "gram"]) == 2
    assert f"{tmp_path / name}: found a file that no export wrote" in capsys.readouterr().err
    assert [path.read_text() for path in tmp_path.iterdir()] == ['{"name": "mine"}']


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
        "from refimpl import nn\nF = lambda h: nn.gram(h) * h.dtype.type(1 + 1e-6)\nSTRICT = "
        "{'gram': F}\nLOOSE = {'gram': F, 'tolerances': {'float64': 1e-5, 'float32': 1e-4}}\n")
    monkeypatch.chdir(tmp_path)
    assert main(["check", "rough:STRICT", "--golden", "golden"]) == 1
    assert main(["check", "rough:LOOSE", "--golden", "golden"]) == 0


def test_the_reference_passes_its_own_folder(folder):
    found, wrong = read_folder(folder)
    assert wrong == [] == list(objections(folder, found)) and len(found) > 20
    for case in found:
        case.check({"gram": nn.gram, "gram_backward": nn.gram_backward, "relu": nn.relu,
                    "relu_backward": nn.relu_backward})
