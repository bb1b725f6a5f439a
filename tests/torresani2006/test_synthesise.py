"""Equation 12, joined pieces, the whole way from a clip to a clip, and the experiments."""

import argparse
from dataclasses import replace
import json
import re

import numpy as np
import pytest

from refimpl.commands import torresani
from refimpl.motion import bvh
from refimpl.motion.skeleton import local_pose
from refimpl.torresani2006 import database as databases
from refimpl.experiments import torresani as experiment
from refimpl.embedded import performers
from refimpl.torresani2006 import poses, regress, segment, synthesise


@pytest.fixture(scope="module")
def trained():
    database = databases.embedded_database()
    return database, *databases.train(database, blends=120)


@pytest.fixture(scope="module")
def phrase(trained):
    return poses.fragment_of(performers.perform(tuple(performers.ACTIONS), 40).clip,
                             trained[0].body, "phrase")


def test_golden_section():
    centre = np.array([-0.2, 0.5, 2.0, 0.0])
    found = synthesise.golden_section(lambda x: np.abs(x - centre) ** 1.5, np.full(4, -1.0),
                                      np.full(4, 1.0))
    np.testing.assert_allclose(found, [-0.2, 0.5, 1.0, 0.0], atol=2e-5)
    for low, high, tolerance, message in (([0.0], [-1.0], 1e-5, "low <= high"),
                                          ([0.0], [np.inf], 1e-5, "finite"),
                                          (0.0, 1.0, 1e-5, "(M,)"),
                                          ([0.0], [1.0], 0.0, "tolerance: found 0.0"),
                                          ([0.0], [1.0], 1e-16, "tolerance: found 1e-16")):
        with pytest.raises(synthesise.SynthesisError, match=re.escape(message)):
            synthesise.golden_section(np.abs, low, high, tolerance)


def test_choice_is_the_best_of_a_fine_grid(trained):
    database, model, projection = trained
    members, target = synthesise.neighbours(database, 3, 5), np.array([1.0, -0.5, 0.7])
    assert members[0] == 3 and len(members) == 5
    best = synthesise.rank_pairs(database, model, projection, members, target)
    assert len(best) == 20 and best[0].error == min(choice.error for choice in best)
    c, e = databases.coefficients(database, projection), database.styles
    alphas = np.linspace(-0.25, 1.25, 1501)
    for choice in best:
        grid = regress.predict(model,
                               databases.blend_inputs(c, e,
                                                      np.tile([choice.i, choice.j], (1501, 1)),
                                                      alphas))
        assert choice.error <= np.linalg.norm(grid - target, axis=1).min() + 2e-3
        assert -0.25 <= choice.alpha <= 1.25


def test_target_of_a_fragment_is_met(trained):
    """The style of a fragment can be had from that fragment."""
    database, model, projection = trained
    choice = synthesise.rank_pairs(database, model, projection, synthesise.neighbours(database, 7),
                                   database.styles[7])[0]
    assert choice.error < 0.25


def test_wrong_styles(trained):
    database, model, projection = trained
    for target in ([4, 0, 0], [np.nan, 0, 0], [0, 0]):
        with pytest.raises(synthesise.SynthesisError, match="flow, weight and time"):
            synthesise.rank_pairs(database, model, projection, [0, 1], target)
    with pytest.raises(synthesise.SynthesisError, match="found 1 fragments"):
        synthesise.rank_pairs(database, model, projection, [0], [0, 0, 0])
    with pytest.raises(synthesise.SynthesisError, match="samples: found 1"):
        synthesise.rank_pairs(database, model, projection, [0, 1], [0, 0, 0], 1)


def test_what_cannot_be_synthesised(trained, phrase):
    database, model, projection = trained
    # one reach is left
    alone = databases.without(database, np.array([n > 10 for n in range(60)]))
    with pytest.raises(synthesise.SynthesisError,
                       match="frames 0 to .* match 'reach': found 1 fragment"):
        synthesise.synthesise(phrase, alone, model, projection, [0, 0, 0])
    with pytest.raises(synthesise.SynthesisError, match="found 60 frames/s, needed 30"):
        synthesise.synthesise(replace(phrase, fps=60.0), database, model, projection, [0, 0, 0])
    with pytest.raises(synthesise.SynthesisError, match="looks: found 0"):
        synthesise.synthesise(phrase, database, model, projection, [0, 0, 0], looks=0)
    with pytest.raises(synthesise.SynthesisError, match="parts: found 0"):
        synthesise.join([], database.body)
    with pytest.raises(synthesise.SynthesisError, match="parts: found 2 of .30.0, 60.0. frames/s"):
        synthesise.join([phrase, replace(phrase, fps=60.0)], database.body)


def test_looks_are_eight_unless_an_analyst_labelled(trained, phrase):
    database, model, projection = trained
    part = replace(phrase, angles=phrase.angles[:90], root=phrase.root[:90])
    pieces = segment.segment(part.angles, [fragment.angles for fragment in database.fragments])[1]
    for given, looks in ((database, 8), (replace(database, labelled=True), 1)):
        found, needed = (synthesise.restyle(part, pieces, given, model, projection, [2, 0, -2],
                                            looks=n) for n in (None, looks))
        assert (found.choices[0].alpha == needed.choices[0].alpha
                and found.choices[0].i == needed.choices[0].i)


def test_joined_motion_is_continuous(trained):
    database = trained[0]
    parts = [database.fragments[n] for n in (0, 17, 31, 44, 58)]
    whole = synthesise.join(parts, database.body)
    assert whole.frames == sum(part.frames for part in parts)
    usual = max(np.abs(np.diff(part.angles, axis=0)).max() for part in parts)
    assert np.abs(np.diff(whole.angles, axis=0)).max() < 1.3 * usual
    steps = np.linalg.norm(np.diff(whole.root[:, :3], axis=0), axis=1)
    assert (steps.max() < 1.3 * max(np.linalg.norm(np.diff(part.root[:, :3], axis=0), axis=1).max()
                                    for part in parts))
    seams = np.cumsum([part.frames for part in parts])[:-1]
    positions = poses.fragment_positions(whole, database.body)
    bends = np.linalg.norm(np.diff(positions, n=2, axis=0), axis=-1).max(axis=1)
    assert bends[[seam + k for seam in seams for k in (-2, -1, 0)]].max() < bends.max() * 1.001
    assert (synthesise.join(parts[:1], database.body).angles
            == pytest.approx(parts[0].angles, abs=1e-9))


def test_a_motion_cut_and_joined_is_itself(trained, phrase):
    """Cut in the middle of a movement; only the two frames at the cut may give way a little, and
    the way goes on as it was.
    """
    cuts = (0, 50, 130, phrase.frames)
    parts = [replace(phrase, angles=phrase.angles[a:b], root=phrase.root[a:b] + [30 * a, 0, -9, 0])
             for a, b in zip(cuts, cuts[1:])]
    whole = synthesise.join(parts, trained[0].body)
    assert np.abs(whole.angles - phrase.angles).max() < 0.05
    assert np.abs(whole.root - phrase.root - [0, 0, -9, 0]).max() < 2.0


def test_style_asked_for_is_observed(trained, phrase):
    database, model, projection = trained
    rng = np.random.default_rng(0)
    nearer = []
    for looks in (1, 8):
        for _ in range(4):
            target = (rng.uniform(0.2, 0.8,
                                  3) * (database.styles[rng.integers(60)]
                                        + database.styles[rng.integers(60)]))
            target = np.clip(target, -3, 3)
            made = synthesise.synthesise(phrase, database, model, projection, target, looks=looks)
            contents = synthesise.contents_of(database, made.pieces)
            before = synthesise.observed_style(phrase, (0, *(p.end for p in made.pieces)), contents,
                                               database.observer)
            after = synthesise.observed_style(made.fragment, made.cuts, contents, database.observer)
            nearer.append(np.linalg.norm(after - target) < np.linalg.norm(before - target))
            np.testing.assert_allclose(made.fragment.root[0, [0, 2, 3]], phrase.root[0, [0, 2, 3]],
                                       atol=1e-9)
    assert np.mean(nearer) >= 0.75


def test_analysts_labels(tmp_path):
    for number in range(3):
        made = performers.perform(("reach", "bow"), number)
        bvh.write_bvh(tmp_path / f"phrase{number}.bvh", made.clip)
        with open(tmp_path / "labels.csv", "a") as file:
            if number == 0:
                file.write("clip,start,end,flow,weight,time\n")
            for a, b in zip(made.cuts, made.cuts[1:]):
                file.write(f"phrase{number},{a},{b},{number - 1},0.5,{1 - number}\n")
    database = databases.read_database(tmp_path, labels=tmp_path / "labels.csv")
    assert database.labelled and len(database.fragments) == 6
    np.testing.assert_array_equal(database.styles[:, 0], [-1, -1, 0, 0, 1, 1])
    assert not database.warning
    with open(tmp_path / "labels.csv", "a") as file:
        file.write("phrase1,10,60,1,1,1\n")
    told = databases.read_database(tmp_path, labels=tmp_path / "labels.csv", contents=2).warning
    assert re.match(r"lines 4 and 8: frames 0 to \d+ and 10 to 60 of 'phrase1' overlap", told)
    (tmp_path / "again").mkdir()
    bvh.write_bvh(tmp_path / "again" / "phrase1.bvh", made.clip)
    with pytest.raises(databases.DatabaseError, match="csv:4: found 'phrase1' twice, as .*again"):
        databases.read_database(tmp_path, labels=tmp_path / "labels.csv")
    assert "have one name" in databases.read_database(tmp_path, contents=2).warning


def test_table_and_curves(trained):
    database, model, projection = trained
    found = experiment.figure_1(database, model, projection, points=7, looks=7)
    assert len(found) == 3
    for curves in found:
        assert (curves.predicted.shape == curves.linear.shape == curves.observed.shape == (7, 3)
                and curves.alpha[[0, -1]].tolist() == [-0.25, 1.25])
        np.testing.assert_allclose(curves.tried[[1, 5]], [0, 1], atol=1e-12)
        # alpha 0 and 1 are the fragments themselves
        for at, n in zip((1, 5), curves.pair):
            np.testing.assert_allclose(curves.observed[at], database.styles[n], atol=1e-6)
            np.testing.assert_allclose(curves.linear[at], database.styles[n], atol=1e-12)


def test_folder_without_enough_performers(tmp_path):
    bvh.write_bvh(tmp_path / "bow_0_1.bvh", performers.perform("bow", 0).clip)
    with pytest.raises(experiment.ExperimentError, match="1 actions by the same 1 performers"):
        experiment.folder_cast(tmp_path)


def test_sample_cast(tmp_path, monkeypatch):
    monkeypatch.delenv("REFIMPL_MOCAP", raising=False)
    cast, credit = experiment.sample_cast(2)
    assert len(cast.database.fragments) == 10 and credit == "performers made by refimpl"
    clips = {(action, n): performers.perform(action, n).clip for action in performers.ACTIONS
             for n in (7, 8)}
    bvh.write_bvh(tmp_path / "bow_7_1.bvh", clips["bow", 7])
    monkeypatch.setenv("REFIMPL_MOCAP", str(tmp_path))
    assert experiment.sample_cast(2)[1] == credit                    # not enough of them
    for (action, n), clip in clips.items():
        bvh.write_bvh(tmp_path / f"{action}_{n}_1.bvh", clip)
    cast, credit = experiment.sample_cast(2)
    assert set(cast.performer) == {"7", "8"} and credit == "clips of REFIMPL_MOCAP"
    monkeypatch.setenv("REFIMPL_MOCAP", str(tmp_path / "nowhere"))
    with pytest.raises(FileNotFoundError):
        experiment.sample_cast(2)


@pytest.mark.mocap
def test_sample_cast_names_whose_motion_it_is(mocap, monkeypatch):
    monkeypatch.setenv("REFIMPL_MOCAP", str(mocap / "bandai1"))
    assert "CC BY-NC" in experiment.sample_cast(2)[1]


def command(*words):
    parser = argparse.ArgumentParser()
    torresani.add_commands(parser.add_subparsers())
    arguments = parser.parse_args([str(word) for word in words])
    return arguments.run(arguments) or 0


def test_commands(tmp_path, capsys, trained, monkeypatch):
    monkeypatch.setattr(torresani, "embedded_database", lambda: trained[0])
    monkeypatch.setattr(torresani, "train", lambda *words, **more: trained[1:])
    clip = tmp_path / "phrase.bvh"
    bvh.write_bvh(clip, performers.perform(("kick", "bow"), 50).clip)
    told, seen = tmp_path / "told.json", ("begin", "end", "content", "ssd", "like")
    assert command("segment", clip, "--json", told) == 0
    report = json.loads(told.read_text())
    pieces = [{key: row[key] for key in seen} for row in report["rows"]]
    assert [piece["content"] for piece in pieces] == ["kick", "bow"]
    assert all(piece["ssd"] != round(piece["ssd"], 4) for piece in pieces)       # as computed
    assert report["settings"]["clip"] == str(clip) and not report["settings"]["as printed"]
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert [row[2] for row in rows[:3]] == ["content", "kick", "bow"] and len(rows) == 4
    assert [row[-1] for row in rows[1:3]] == ["yes", "yes"]
    out = tmp_path / "out.bvh"
    assert command("synthesise", clip, "--flow", 1, "--weight", -1, "--time", "0.5", "-o", out,
                   "--json", told) == 0
    report = json.loads(told.read_text())
    assert [{key: row[key] for key in seen} for row in report["rows"]] == pieces
    assert report["settings"]["weight"] == -1 and 0 <= report["rows"][0]["alpha"] <= 1
    text = capsys.readouterr().out
    assert "asked: flow 1.00, weight -1.00, time 0.50; predicted: flow" in text
    assert "seen by an observer that did not choose: flow" in text and "seams at" in text
    assert command("synthesise", clip, "--persona", "-o", out) == 0
    made, given = bvh.read_bvh(out), bvh.read_bvh(clip)
    assert made.joints == given.joints and made.fps == given.fps
    toes = [made.names.index(name) for name in ("LeftToe", "RightToe")]
    from refimpl.motion.skeleton import forward_kinematics
    assert forward_kinematics(made.parents, *local_pose(made))[1][:, toes, 1].min() > -4
    with pytest.raises(ValueError, match="style: found"):
        command("synthesise", clip, "--flow", 5, "-o", out)
    short, nothing = tmp_path / "short.bvh", tmp_path / "nothing.bvh"
    bvh.write_bvh(short, replace(given, values=given.values[:5]))
    with pytest.raises(synthesise.SynthesisError, match="four frames"):
        command("synthesise", short, "-o", nothing)
    assert not nothing.exists()
    for words in (("synthesise", clip, "--looks", 0, "-o", out),
                  ("synthesise", clip, "--neighbours", 1, "-o", out),
                  ("segment", clip, tmp_path, "--contents", 0),
                  ("synthesise", clip, "--seed", -1, "-o", out),
                  ("experiment", "torresani", "--splits", 0)):
        with pytest.raises(SystemExit):
            command(*words)
        assert (f"argument {next(word for word in words if str(word).startswith('--'))}: found"
                in capsys.readouterr().err)
