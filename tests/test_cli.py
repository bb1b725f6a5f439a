"""The command line from BVH to BVH, and every wrong input that a newcomer might give it: one line,
status 2, nothing left behind.
"""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from refimpl.cli import main
from refimpl.styles.files import load_style, save_style
from refimpl.motion import bvh, body as take
from refimpl.embedded import walkers as synthetic
from refimpl.motion.feet import foot_skate


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """A small folder of BVH clips made by the program."""
    out = tmp_path_factory.mktemp("clips")
    for content in ("walk", "jog"):
        for number in range(2):
            for style in ("normal", "old"):
                made = synthetic.make_clip(content, style, synthetic.person(number), seconds=4.5,
                                           seed=number)
                bvh.write_bvh(out / f"{content}_{style}_{number}.bvh", made.clip)
    return out


@pytest.fixture(scope="session")
def models(folder, tmp_path_factory):
    """motions.npz, manifold.npz and old.npz, trained for two epochs only."""
    out = tmp_path_factory.mktemp("models")
    assert main(["prepare", str(folder), "-o", str(out / "motions.npz"), "--hold-out", "0.5"]) == 0
    assert main(["train-autoencoder", str(out / "motions.npz"), "-o", str(out / "manifold.npz"),
                 "--epochs", "2", "--hidden", "12", "--width", "9"]) == 0
    assert main(["train-style", str(out / "motions.npz"), str(out / "manifold.npz"), "--style",
                 "old", "-o", str(out / "old.npz"), "--epochs", "2", "--channels", "8", "--width",
                 "9", "--report", str(out / "old.json"), "--curves", str(out / "old.png")]) == 0
    return out


def test_every_step_leaves_its_file(models):
    measured = json.loads((models / "old.json").read_text())
    assert measured["style"] == "old" and len(measured["clips"]) == 2
    assert all(clip["content"] > 0 and clip["projected"] > 0 for clip in measured["clips"])
    assert (models / "old.png").stat().st_size > 1000


def test_transfer_keeps_skeleton_and_frames(models, folder, tmp_path, capsys):
    out = tmp_path / "stylised walk.bvh"
    assert main(["transfer", str(models / "old.npz"), str(folder / "walk_normal_1.bvh"), "-o",
                 str(out), "--plot", str(tmp_path / "strip.png"), "--animate",
                 str(tmp_path / "moving.html")]) == 0
    content, result = bvh.read_bvh(folder / "walk_normal_1.bvh"), bvh.read_bvh(out)
    assert result.joints == content.joints and result.frames == content.frames and result.fps == 60
    assert np.abs(result.values - content.values).max() > 1
    assert (tmp_path / "strip.png").read_bytes()[:4] == b"\x89PNG"
    assert ("</html>" in (tmp_path / "moving.html").read_text()
            or "<script" in (tmp_path / "moving.html").read_text())
    assert "60 frames/s in style 'old'" in capsys.readouterr().out


@pytest.mark.parametrize("optimise", [False, True], ids=["network", "optimise"])
def test_a_part_of_a_clip_alone_is_stylised_and_written(models, folder, tmp_path, capsys, optimise):
    clip, out = str(folder / "walk_normal_1.bvh"), tmp_path / "out.bvh"
    run = ["transfer", "-o", str(out), *(
        ["--method", "optimise", "--content", clip, "--style", str(folder / "walk_old_0.bvh"),
         "--manifold", str(models / "manifold.npz"), "--iterations", "2"] if optimise
        else [str(models / "old.npz"), clip])]
    assert main(run) == 0
    whole = bvh.read_bvh(out)
    assert main([*run, "--from", "1.5", "--to", "3"]) == 0
    part = bvh.read_bvh(out)
    assert part.frames == 90 and part.joints == whole.joints
    np.testing.assert_array_equal(part.values, whole.values[90:180])
    for wrong, words in ((["--from", "3", "--to", "2"], "found 3 to 2 seconds, needed a part"),
                         (["--to", "9"], "found 0 to 9 seconds, needed a part"),
                         (["--from", "4.5"], "found 4.5 to 4.5 seconds")):
        out.unlink(missing_ok=True)
        capsys.readouterr()
        assert main([*run, *wrong]) == 2 and not out.exists()
        said = capsys.readouterr().err
        assert words in said and said.count("\n") == 1
    with pytest.raises(SystemExit):
        main([*run, "--from", "-1"])


@pytest.mark.parametrize("still", [False, True])
def test_a_path_has_its_yardstick_and_a_clip_out_of_range_its_warning(models, folder, tmp_path,
                                                                      capsys, still):
    """A network of two epochs leaves any path; the result does not. Of a clip in which nothing
    moves it is told that nothing does and that the style has not seen it, a line each, and the
    command is done and good.
    """
    clip = bvh.read_bvh(folder / "walk_normal_1.bvh")
    values = np.repeat(clip.values[:1], 300, axis=0) if still else clip.values
    bvh.write_bvh(tmp_path / "in.bvh", dataclasses.replace(clip, values=values))
    assert main(["transfer", str(models / "old.npz"), str(tmp_path / "in.bvh"), "-o",
                 str(tmp_path / "out.bvh"), "--json", str(tmp_path / "out.json")]) == 0
    said, row = capsys.readouterr(), json.loads((tmp_path / "out.json").read_text())["rows"][0]
    assert "of a way of" in said.out and row["mean path error"] < 0.05 * row["way"] + 8
    assert said.err.count("outside of what the style learnt on") == still
    assert said.err.count("no joint moves in any frame") == still
    assert said.err.count("\n") == 2 * still
    assert (row["strangeness"] > 0.25) is still and bool(row["warnings"]) is still


def test_weights_of_a_reading_and_of_the_file(models, tmp_path):
    """What train-style was told stands in the file, fitted to unit and units; what it was not told
    is the reading's own.
    """
    for reading, style, foot in (("norm", 0.06, 0.01), ("mean_squares", 0.01, 2e-4 * 256 / 12)):
        assert main(["train-style", str(models / "motions.npz"), str(models / "manifold.npz"),
                     "--style", "old", "-o", str(tmp_path / "a.npz"), "--epochs", "1", "--channels",
                     "2", "--width", "3", "--reading", reading, "--weight-content", "0.7"]) == 0
        made = load_style(tmp_path / "a.npz")
        factor = (80 / made.manifold.leg) ** 2
        assert ((made.weights.reading, made.weights.content, made.weights.style)
                == (reading, 0.7, style))
        np.testing.assert_allclose([made.weights.foot, made.weights.turn],
                                   [foot * factor, 1e4 / factor])


def test_inspect(folder, capsys):
    assert main(["inspect", str(folder / "walk_old_0.bvh")]) == 0
    out = capsys.readouterr().out
    for words in ("21 joints", "60 frames/s", "centimetres", "y is up", "LeftFinger",
                  "XYZ pos ZXY", "m/s", "steps a minute"):
        assert words in out


def crossed(path, folder):
    """The names of an arm and a leg exchanged."""
    text = (folder / "walk_old_0.bvh").read_text()
    for old, new in (("LeftLeg", "one"), ("LeftForeArm", "LeftLeg"), ("one", "LeftForeArm")):
        text = text.replace(f"{old}\n", f"{new}\n")
    path.write_text(text)
    return path


def truncated(path, folder):
    text = (folder / "walk_old_0.bvh").read_text()
    path.write_text(text[:len(text) // 2])
    return path


def not_a_bvh(path, folder):
    path.write_text("hello\n")
    return path


@pytest.mark.parametrize("make, words",
                         [(crossed, "By the tree: "),
                          (truncated, "needed"), (not_a_bvh, "needed HIERARCHY"),
                                         (lambda path, folder: path, "No such file")])
@pytest.mark.parametrize("command", ["transfer", "prepare", "inspect"])
def test_bad_clips(make, words, command, models, folder, tmp_path, capsys):
    source = tmp_path / "in"
    source.mkdir()
    clip = make(source / "walk_normal_9.bvh", folder)
    out = tmp_path / "out.bvh"
    arguments = {"transfer": ["transfer", str(models / "old.npz"), str(clip), "-o", str(out)],
                 "prepare": ["prepare", str(source), "-o", str(out)],
                 "inspect": ["inspect", str(clip)]}[command]
    status = main(arguments)
    captured = capsys.readouterr()
    # what was found is shown all the same
    if command == "inspect" and make is crossed:
        assert "missing" in captured.out and "LeftUpLeg" in captured.out
    if command == "prepare" and not clip.exists():
        words = "found no BVH file"
    assert (status == 2 and words in captured.err and captured.err.count("\n") <= 2
            and "Traceback" not in captured.err)
    assert "refimpl: error:" in captured.err.splitlines()[-1]
    assert not out.exists() and {p.name for p in tmp_path.iterdir()} <= {"in"}


def test_other_wrong_input(models, folder, tmp_path, capsys):
    motions, manifold = str(models / "motions.npz"), str(models / "manifold.npz")
    empty, out = tmp_path / "empty", str(tmp_path / "out.npz")
    empty.mkdir()
    labels = tmp_path / "labels.csv"
    labels.write_text("clip,content,style\nnothing,walk,old\n")
    for arguments, words in (
            (["prepare", str(empty), "-o", out], "found no BVH file"),
            (["prepare", str(tmp_path / "nowhere"), "-o", out], "no such folder"),
            (["prepare", str(folder), "-o", out, "--pattern", "("], "needed a regular expression"),
            (["prepare", str(folder), "-o", out, "--pattern", "(?P<content>x)"],
             "needed the named groups"),
            (["prepare", str(folder), "-o", out, "--pattern", "(?P<content>X)(?P<style>Y)"],
             "found no clip with labels"),
            (["prepare", str(folder), "-o", out, "--labels", str(labels)],
             "labels.csv:2: found no clip 'nothing'"),
            (["prepare", str(folder), "-o", str(empty)], "is a folder"),
            (["prepare", str(folder), "-o", str(tmp_path / "no" / "out.npz")], "does not exist"),
            (["train-autoencoder", manifold, "-o", out],
             "found a refimpl manifold file, needed a refimpl motions file"),
            (["train-autoencoder", str(folder / "walk_old_0.bvh"), "-o", out],
             "needed a refimpl motions file"),
            (["train-style", motions, manifold, "--style", "vampire", "-o", out],
             "found no exemplar of style 'vampire'"),
            (["train-style", motions, manifold, "--style", "old", "--content-style", "robot", "-o",
              out], "found no clip of style 'robot'"),
            (["train-style", motions, manifold, "--style", "old", "--pair", "walk", "-o", out],
             "--pair"),
            (["train-style", motions, manifold, "--style", "old", "--pair", "walk=swim", "-o", out],
             "no exemplar of content 'swim'"),
            (["transfer", manifold, str(folder / "walk_old_0.bvh"), "-o", out + ".bvh"],
             "needed a refimpl style file")):
        assert main(arguments) == 2, arguments
        captured = capsys.readouterr()
        assert (words in captured.err and "Traceback" not in captured.err
                and captured.err.count("\n") == 1)
        assert sorted(p.name for p in tmp_path.iterdir()) == ["empty", "labels.csv"]


@pytest.mark.parametrize("words, message", [
    ([], "required: COMMAND"), (["swim"], "invalid choice: 'swim'"),
    (["prepare"], "required: FOLDER"),
    (["prepare", "x", "-o", "y", "--hold-out", "1.5"],
     "--hold-out: found '1.5', needed a number from 0 on and below 1"),
    (["train-autoencoder", "x", "-o", "y", "--epochs", "0"],
     "--epochs: found '0', needed a whole number from 1 on"),
    (["train-autoencoder", "x", "-o", "y", "--rate", "nan"],
     "--rate: found 'nan', needed a number above 0"),
    (["train-autoencoder", "x", "-o", "y", "--dropout", "1"], "--dropout: found '1'"),
    (["demo", "--seed", "-1"], "--seed"),
    (["train-style", "x", "y", "--style", "old", "-o", "z", "--weight-style", "inf"],
     "--weight-style: found 'inf'"),
    (["check", "--time-limit", "0.01"], "--time-limit: found '0.01', needed a number from 0.1 on"),
    (["check", "--memory-limit", "0"], "--memory-limit: found '0', needed a number from 0.1 on"),
    (["check", "--golden", ""], "--golden: found '', needed a name"),
    (["export", ""], "DIR: found '', needed a name"),
    (["transfer", "old", "x", "-o", "out.fbx"], "found out.fbx, which does not end in .bvh"),
    (["transfer", "old", "x", "-o", "o.bvh", "--plot", "a.docx"], "does not end in .png"),
    (["transfer", "old", "x", "-o", "o.bvh", "--animate", "a.gif"], "not end in .html or .htm"),
    (["synthesise", "x", "-o", "out"], "found out, which does not end in .bvh"),
    (["demo", "--style", "vampire"], "invalid choice: 'vampire'")])
def test_wrong_words_are_one_line(words, message, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(words)
    err = capsys.readouterr().err
    assert (stopped.value.code == 2 and message in err and err.startswith("refimpl: error:")
            and err.count("\n") == 1)


def test_labels_from_a_file(folder, tmp_path, capsys):
    labels = tmp_path / "labels.csv"
    labels.write_text(
        "clip,content,style\nwalk_old_0,stroll,ancient\nwalk_normal_0.bvh,stroll,normal\n")
    assert main(["prepare", str(folder), "-o", str(tmp_path / "m.npz"), "--labels",
                 str(labels)]) == 0
    out = capsys.readouterr().out
    assert "ancient" in out and "2 of 8 clips" in out


def test_help_of_every_command(capsys):
    for command in ("demo", "inspect", "prepare", "train-autoencoder", "train-style", "transfer"):
        with pytest.raises(SystemExit) as stopped:
            main([command, "--help"])
        assert stopped.value.code == 0
        assert "usage: refimpl" in capsys.readouterr().out


@pytest.mark.mocap
def test_a_real_clip_is_stylised_on_its_own_skeleton(mocap, models, tmp_path):
    """The small model knows the made skeleton only; the clip's proportions, joints and frame rate
    are its own.
    """
    clip = mocap / "bandai2" / "dataset-2_walk-turn-left_normal_001.bvh"
    out = tmp_path / "out.bvh"
    assert main(["transfer", str(models / "old.npz"), str(clip), "-o", str(out)]) == 0
    content, result = bvh.read_bvh(clip), bvh.read_bvh(out)
    assert (result.joints == content.joints and result.fps == content.fps
            and result.frames == content.frames)


def test_transfer_by_optimisation_needs_no_network_of_the_style(models, folder, tmp_path, capsys):
    out = tmp_path / "out.bvh"
    assert main(["transfer", "--method", "optimise", "--content", str(folder / "walk_normal_1.bvh"),
                 "--style", str(folder / "walk_old_0.bvh"), str(folder / "walk_old_1.bvh"),
                 "--manifold", str(models / "manifold.npz"), "-o", str(out), "--iterations",
                 "5"]) == 0
    content, result = bvh.read_bvh(folder / "walk_normal_1.bvh"), bvh.read_bvh(out)
    assert result.joints == content.joints and result.frames == content.frames and result.fps == 60
    assert "walk_old_0.bvh" in capsys.readouterr().out


def test_raw_leaves_the_feet_as_the_network_has_them(models, folder, tmp_path):
    results = {}
    for flag in ((), ("--raw",)):
        assert main(["transfer", str(models / "old.npz"), str(folder / "walk_normal_1.bvh"), "-o",
                     str(tmp_path / "out.bvh"), *flag]) == 0
        results[flag] = take.read_take(tmp_path / "out.bvh").positions
    contacts = take.read_take(folder / "walk_normal_1.bvh").contacts
    slides = [foot_skate(results[flag], contacts) for flag in ((), ("--raw",))]
    assert slides[0] < 0.4 * slides[1] and slides[1] > 1.0


@pytest.mark.parametrize("arguments, words", [
    (["a.npz"], "found no CLIP.bvh, needed STYLE, CLIP.bvh with --method network"),
    (["a.npz", "b.bvh", "--seed", "3"], "found --seed with --method network"),
    (["a.npz", "b.bvh", "--style", "c.bvh"], "found --style with --method network"),
    (["--method", "optimise", "--content", "b.bvh"],
     "found no --style, --manifold, needed --content, --style, --manifold"),
    (["--method", "optimise", "a.npz"], "found STYLE with --method optimise"),
    (["--method", "optimise", "--no-projection"], "found --no-projection with --method optimise")])
def test_the_two_methods_have_options_of_their_own(arguments, words, tmp_path, capsys):
    assert main(["transfer", *arguments, "-o", str(tmp_path / "out.bvh")]) == 2
    assert words in capsys.readouterr().err and not (tmp_path / "out.bvh").exists()


@pytest.mark.parametrize("again", [False, True])
def test_evaluate_measures_every_system(models, folder, tmp_path, capsys, again):
    """On a handful of embedded clips: the judges need clips that the style did not learn on."""
    assert main(["train-style", str(models / "motions.npz"), str(models / "manifold.npz"),
                 "--style", "old", "-o", str(tmp_path / "old.npz"), "--epochs", "1", "--channels",
                 "4", "--width", "9", "--contents", "walk" if again else "walk,jog",
                 *(["--exemplars", "0"] if again else [])]) == 0
    status = main(["evaluate", str(folder), str(models / "motions.npz"), str(tmp_path / "old.npz"),
                   "--out", str(tmp_path / "out")])
    said = capsys.readouterr()
    assert (status == 2 and "found no clip of style" in said.err
            and "train with --clips and --exemplars that leave some" in said.err)
    assert not (tmp_path / "out").exists()


def test_evaluate_from_clips_to_report(tmp_path, capsys):
    clips, run = tmp_path / "clips", ["--epochs", "1", "--width", "9"]
    clips.mkdir()
    for made in synthetic.make_database(seconds_per_clip=4.0, people=4, contents=("walk",),
                                        styles=("normal", "zombie")):
        bvh.write_bvh(clips / f"{made.name}.bvh", made.clip)
    motions, manifold, style, out = (str(tmp_path / name)
                                     for name in ("motions.npz", "manifold.npz", "zombie.npz",
                                                  "out"))
    assert main(["prepare", str(clips), "-o", motions, "--hold-out", "0.25"]) == 0
    assert main(["train-autoencoder", motions, "-o", manifold, "--hidden", "8", *run]) == 0
    assert main(["train-style", motions, manifold, "--style", "zombie", "-o", style, "--channels",
                 "4", "--clips", "[01]$", "--exemplars", "[01]$", *run]) == 0
    network, preprocess = str(tmp_path / "network.npz"), str(tmp_path / "preprocess.npz")
    assert main(["train-2016", motions, "-o", network, "--preprocess", preprocess, "--hidden", "6",
                 *run]) == 0
    assert (main(["evaluate", str(clips), motions, style, "--network", network, "--out", out]) == 2
            and "needed both or neither" in capsys.readouterr().err)
    assert main(["evaluate", str(clips), motions, style, "--out", out, "--network", network,
                 "--preprocess", preprocess, "--json", f"{out}.json"]) == 0
    report, said = (json.loads((tmp_path / "out" / "report.json").read_text()),
                    capsys.readouterr().out)
    systems = ["content", "2016, as coded", "2016, own form", "2017 T(I), raw", "2017",
               "2017, own pace", "real"]
    assert [line["system"] for line in report["summary"]] == systems
    told = json.loads(Path(f"{out}.json").read_text())
    assert (told["command"] == "evaluate" and [row["system"] for row in told["rows"]] == systems * 2
            and "2016, as coded" in told["table_1"][0])
    assert ("judges fitted on 2 clips" in said and "Table 1, seconds" in said
            and "projection (figure 2)" in said)
    assert (all(line["bones off (share)"] < 1e-6 for line in report["summary"][:6])
            and (tmp_path / "out" / "strip_zombie.png").stat().st_size > 10000)
    assert set(report["judges"]) == {"walk_normal_002", "walk_zombie_002"}
    assert (main(["evaluate", str(clips), motions, style, style, "--out", out]) == 2
            and "needed each style once" in capsys.readouterr().err)
    assert (main(["evaluate", str(clips), motions, style, "--content-style", "sad", "--out", out])
            == 2 and "--content-style: found 'sad'" in capsys.readouterr().err)


def test_the_recipe_is_measured(tmp_path, capsys):
    """Each table of `experiment holden`, with networks too small to be right: the rows, and the
    nulls beside them.
    """
    small = ["--hidden", "8", "--channels", "3", "--loss-epochs", "1", "--epochs", "1"]
    assert main(["experiment", "holden", *small, "--tables", "projection,path", "--json",
                 str(tmp_path / "rows.json")]) == 0
    rows = json.loads((tmp_path / "rows.json").read_text())["rows"]
    by_table = {name: [row for row in rows if row["table"] == name]
                for name in ("projection", "path")}
    assert ([(row["depooling"], row["normaliser"]) for row in by_table["projection"]]
            == [("average", "groups"), ("random", "groups"), ("random", "2016")])
    assert all(row["noise jerk"] > 50 and row["error"] > 0 for row in by_table["projection"])
    content, real, *ways = by_table["path"]
    assert ((content["left"], content["seen"], content["met"]) == (1.0, 0.0, 1.0)
            and real["seen"] == 1.0 and real["left"] < 0.2)
    assert ([row["constraints"] for row in ways] == [0.25, 0.5, 1.0, 2.0, 4.0]
            and all(row["path"] > 0 for row in ways))
    assert "noisy jerk" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["experiment", "holden", "--learn", "("])
    assert "needed a regular expression" in capsys.readouterr().err
    for wrong, words in ((["--tables", "x"], "--tables: found 'x'"),
                         (["--styles", "giant"], "found no clip of style 'giant'")):
        assert main(["experiment", "holden", *wrong]) == 2
        assert words in capsys.readouterr().err


@pytest.fixture(scope="module")
def of_2016(models, tmp_path_factory):
    """A network of the 2016 system in files like the authors' own, after one epoch."""
    out = tmp_path_factory.mktemp("2016")
    files = [str(out / "network_core.npz"), str(out / "preprocess_core.npz")]
    assert main(["train-2016", str(models / "motions.npz"), "-o", files[0], "--preprocess",
                 files[1], "--epochs", "1", "--hidden", "6", "--width", "5", "--rate", "1e-3",
                 "--curves", str(out / "curves.png")]) == 0
    assert ((out / "curves.png").stat().st_size > 1000
            and not (out / "network_core.npz.checkpoint").exists())
    return files


@pytest.mark.parametrize("more",
                         [[], ["--form", "coded"],
                          ["--form", "coded", "--raw", "--weight-style", "0.5"],
                          ["--start", "content", "--raw"]])
def test_transfer_with_a_network_of_2016(of_2016, folder, tmp_path, more):
    out, content = tmp_path / "out.bvh", folder / "walk_normal_1.bvh"
    assert main(["transfer", "--method", "optimise", "--content", str(content), "--style",
                 str(folder / "walk_old_0.bvh"), "--network", of_2016[0], "--preprocess",
                 of_2016[1], "-o", str(out), "--iterations", "3", *more]) == 0
    given, made = bvh.read_bvh(content), bvh.read_bvh(out)
    assert made.joints == given.joints and made.frames == given.frames and made.fps == 60


@pytest.mark.parametrize("more, words", [
    (["--network", "{0}"],
     "found no --preprocess, needed --content, --style, --network, --preprocess"),
    (["--form", "coded", "--manifold", "{m}"], "found no --network, --preprocess"),
    (["--network", "{0}", "--preprocess", "{1}", "--manifold", "{m}"],
     "found --manifold beside a network of 2016"),
    (["--network", "{0}", "--preprocess", "{1}", "--form", "coded", "--start", "content"],
     "always begins at noise"),
    (["--network", "{1}", "--preprocess", "{0}"],
     "found no Xmean, Xstd, needed a normaliser like the authors' preprocess_core.npz with Xmean, "
     "Xstd; is it the other one"),
    (["--network", "{0}", "--preprocess", "{1}", "--form", "coded", "--style", "{s}", "{s}"],
     "found 2 clips for --style")])
def test_a_network_of_2016_takes_its_own_options(of_2016, models, folder, tmp_path, capsys, more,
                                                 words):
    names = {"m": models / "manifold.npz", "s": folder / "walk_old_0.bvh"}
    more = [word.format(*of_2016, **names) for word in more]
    run = ["transfer", "--method", "optimise", "--content", str(folder / "walk_normal_1.bvh"),
           "--style", str(names["s"]), "-o", str(tmp_path / "out.bvh")]
    assert (main([*run, *more]) == 2 and words in capsys.readouterr().err
            and not (tmp_path / "out.bvh").exists())


def test_a_style_learns_on_a_network_of_2016(of_2016, models, folder, tmp_path, capsys):
    style, out = str(tmp_path / "old.npz"), tmp_path / "out.bvh"
    assert main(["train-style", str(models / "motions.npz"), of_2016[0], "--preprocess", of_2016[1],
                 "--style", "old", "-o", style, "--epochs", "1", "--channels", "4", "--width",
                 "5"]) == 0
    assert set(load_style(style).manifold.params) == {"W0", "b0", "V0", "c0"}
    assert (main(["transfer", style, str(folder / "walk_normal_1.bvh"), "-o", str(out)]) == 0
            and out.exists())
    assert main(["train-style", str(models / "motions.npz"), of_2016[0], "--style", "old", "-o",
                 style]) == 2
    assert "needed a refimpl manifold file" in capsys.readouterr().err


def test_a_mapping_file_serves_the_style_too(models, folder, tmp_path):
    text = (folder / "walk_old_0.bvh").read_text()
    (tmp_path / "odd.bvh").write_text(text.replace("LeftUpLeg", "Thigh_A"))
    (tmp_path / "odd_content.bvh").write_text((folder
                                               / "walk_normal_1.bvh").read_text().replace(
                                                   "LeftUpLeg", "Thigh_A"))
    (tmp_path / "map.csv").write_text("slot,joint\nLeftUpLeg,Thigh_A\n")
    run = ["transfer", "--method", "optimise", "--content", str(tmp_path / "odd_content.bvh"),
           "--manifold", str(models / "manifold.npz"), "--iterations", "1", "-o",
           str(tmp_path / "out.bvh"), "--mapping", str(tmp_path / "map.csv")]
    assert (main([*run, "--style", str(tmp_path / "odd.bvh")]) == 0
            and main([*run, "--style", str(folder / "walk_old_0.bvh")]) == 0)


def test_strength_parts_rate_and_points(models, folder, tmp_path, capsys):
    clip, style = folder / "walk_normal_0.bvh", str(models / "old.npz")
    content = bvh.read_bvh(clip)
    out = tmp_path / "o.bvh"
    assert main(["transfer", style, str(clip), "-o", str(out), "--strength", "0", "--raw"]) == 0
    same = bvh.read_bvh(out)
    assert same.joints == content.joints and same.frame_time == content.frame_time
    np.testing.assert_allclose(take.read_take(out).positions, take.read_take(clip).positions,
                               atol=1e-6)
    assert main(["transfer", style, str(clip), "-o", str(out), "--only", "arms", "--raw", "--fps",
                 "24"]) == 0
    arms = bvh.read_bvh(out)
    assert arms.fps == 24 and arms.frames == int((content.frames - 1) * 24 / 60 + 1e-6) + 1
    np.testing.assert_allclose(arms.values[0, :3], content.values[0, :3], atol=1e-6)
    with pytest.raises(SystemExit):
        main(["transfer", style, str(clip), "-o", str(out), "--only", "wings"])
    assert "needed some of hips, spine, head, arms, legs" in capsys.readouterr().err
    np.save(tmp_path / "p.npy", take.read_take(clip).positions)
    assert main(["transfer", style, str(tmp_path / "p.npy"), "-o", str(out), "--rate", "30"]) == 0
    made = bvh.read_bvh(out)
    assert made.fps == 30 and made.frames == len(take.read_take(clip).positions)
    assert main(["inspect", str(clip), "--rate", "30", "--json", str(tmp_path / "i.json")]) == 0
    told = json.loads((tmp_path / "i.json").read_text())
    assert told["fps"] == 30 and 0.2 < told["speed, m/s"] < 1.2 and told["steps a minute"] > 0


def test_what_was_found_is_written_to_be_completed(folder, tmp_path):
    clip = crossed(tmp_path / "c.bvh", folder)
    assert main(["inspect", str(clip), "--write-mapping", str(tmp_path / "m.csv")]) == 2
    lines = dict(line.split(",") for line in (tmp_path / "m.csv").read_text().splitlines())
    assert len(lines) == 21 and lines["Head"] == "Head"
    mended = {**lines, "LeftLeg": "LeftForeArm", "LeftForeArm": "LeftLeg"}
    (tmp_path / "m.csv").write_text("".join(f"{s},{j}\n" for s, j in mended.items()))
    assert main(["inspect", str(clip), "--mapping", str(tmp_path / "m.csv")]) == 0


def test_experiment_bodies(models, tmp_path, capsys):
    assert main(["experiment", "bodies", str(models / "old.npz"), "--most", "1", "--json",
                 str(tmp_path / "b.json")]) == 0
    rows = json.loads((tmp_path / "b.json").read_text())["rows"]
    assert {row["system"] for row in rows} == {"nothing", "P(content)", "old"}
    assert len(rows) == 3 * 16 and all(row["frames and joints kept"] for row in rows)
    assert all(row["hips off"] < 1e-9 and row["shoulders off"] < 1e-9 for row in rows)
    assert all(abs(row["hip height off"]) < 1e-9 for row in rows if row["system"] == "nothing")
    assert "broad shoulders" in capsys.readouterr().out
    assert main(["experiment", "bodies", str(models / "old.npz"), "--folder", str(tmp_path)]) == 2
