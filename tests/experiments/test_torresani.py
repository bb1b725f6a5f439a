"""`refimpl experiment torresani`: its tables, and an analyst's sheets."""

import json

import numpy as np
import pytest

from refimpl.commands import torresani_experiment
from refimpl.experiments import (learning, observers, phrases, sheets, synthesis,
                                 torresani as experiment)
from refimpl.motion.dataset import LabelError
from refimpl.pictures import player
from refimpl.torresani2006 import database as databases, regress

from ..torresani2006.test_synthesise import command


def test_experiment_command(tmp_path, capsys, monkeypatch):
    few, cut_again = experiment.embedded_cast(3), phrases.cut_again
    monkeypatch.setattr(experiment, "embedded_cast", lambda: few)
    monkeypatch.setattr(phrases, "cut_again", lambda database,
                        seed: cut_again(database, 2, seed=seed))
    monkeypatch.setattr(torresani_experiment, "train", lambda database, seed=0, blends=20:
                        databases.train(database, blends=20, seed=seed))
    assert command("experiment", "torresani", "--draws", 1, "--splits", 1, "--trials", 1,
                   "--orders", 1, "--only", "observers", "table 1", "contents", "phrases",
                   "synthesis", "three fragments", "support vectors", "M", "figure 1",
                   "--out", tmp_path, "--into", tmp_path / "all.json") == 0
    report = json.loads((tmp_path / "report.json").read_text())
    assert len(report["table 1"]) == 3
    assert all(set(regress.MODELS) < set(rows) for rows in report["table 1"].values())
    assert report["phrases"]["newcomers, habits out, whitened"]["contents"] == 1.0
    rows = report["synthesis"]
    assert set(synthesis.CHOOSING) | {
        "the input", "style 0", "random fragments", "nearest fragments", "true cuts",
        "true cuts and contents", "random fragments, true contents"} == set(rows)
    assert rows["random fragments, true contents"]["kept"] > 0.9
    seen = report["observers"]
    assert len(seen) == 8 and seen["swings, passing"]["own r"][1] > 0.8
    assert seen["swings, noise of 0.005"]["95 %"][1] < 0.3 < seen["paths, eased"]["shuffled"] + 0.2
    assert rows["the input"]["nearer"][0] == 0 and rows["the input"]["kept"] == 1
    assert rows["the input"]["peak"] == 1 and "r" not in rows["style 0"]
    assert rows["equation 12"]["kept"] > 0.5
    assert command("experiment", "torresani", "--only", "contents", "--out", tmp_path,
                   "--into", tmp_path / "all.json") == 0
    assert json.loads((tmp_path / "all.json").read_text()) == {"embedded performers": report}
    (tmp_path / "all.json").write_text("[]")
    with pytest.raises(ValueError, match="all.json: found no tables that --into wrote"):
        command("experiment", "torresani", "--only", "contents", "--out", tmp_path,
                "--into", tmp_path / "all.json")
    assert len((tmp_path / "figure_1.csv").read_text().splitlines()) == 1 + 3 * 61
    assert ((tmp_path / "figure_1_3.png").stat().st_size > 1000
            and (tmp_path / "phrase.bvh").exists())


def test_learning_curve_tells_pairs_that_were_not_learnt_from():
    found = learning.learning_curve(experiment.embedded_cast(4).database, sizes=(40,), draws=2)
    seen, others = found["40"], found["40, other pairs"]
    assert seen["kernel ridge"][0] < seen["mean of the labels"][0]
    assert others["linear interpolation"] != seen["linear interpolation"]
    few = experiment.embedded_cast(12)
    lively = observers.worth(experiment.Cast(few.database, np.array(
        ["active" if n % 2 else "sad" for n in range(60)])))["paths, lively over weary"]
    assert lively["pairs"] == 180 and all(0 <= x <= 1 for x in lively["share"])


def test_a_planted_function_comes_back_from_sheets(tmp_path, capsys, monkeypatch):
    """A simulated analyst who sees the interpolation and one more in weight, with noise of 0.4."""
    few = experiment.embedded_cast(4)
    monkeypatch.setattr(experiment, "embedded_cast", lambda: few)
    monkeypatch.setattr(player, "write_player", lambda path, seen, align:
                        path.write_text(" ".join(seen)))
    words = ("experiment", "torresani", "--blends", 60)
    assert command(*words, "--export-blends", tmp_path) == 0
    header, *lines = (tmp_path / "sheet.csv").read_text().split()
    assert header == "clip,start,end,flow,weight,time,analyst" and len(lines) == 80
    assert len(list((tmp_path / "clips").iterdir())) == 80 and (tmp_path / "index.html").exists()
    with pytest.raises(LabelError, match="no line below the header with flow"):
        command(*words, "--labels", tmp_path / "sheet.csv")
    _, pairs, alpha, names = sheets.motions_of(few.database, 60)
    e, rng = np.random.default_rng(1).uniform(-1.5, 1.5, (20, 3)), np.random.default_rng(2)
    line = (1 - alpha[:, None]) * e[pairs[:, 0]] + alpha[:, None] * e[pairs[:, 1]]
    style = dict(zip(names, np.concatenate([e, line + [0, 1, 0]])))
    filled = [f"{name},,,{','.join(f'{x:.2f}' for x in np.clip(y, -3, 3))},{who}"
              for who in ("a", "b") for name in style
              for y in [style[name] + 0.4 * rng.normal(size=3)]]
    (tmp_path / "filled.csv").write_text("\n".join([header, *filled]))
    assert command(*words, "--labels", tmp_path / "filled.csv", "--json", tmp_path / "t.json") == 0
    told = json.loads((tmp_path / "t.json").read_text())
    rows = {row: np.array(x["error"]) for row, x in told["table 1"].items()}
    assert told["analysts"] == ["a", "b"] and told["agreement"]["flow"]["correlation"] > 0.7
    noise = 0.4 ** 2 / 2                                     # of the mean of two
    assert (rows["plus a constant"] < 2.5 * noise).all(), rows
    assert rows["linear interpolation"][1] > 0.8 and rows["mean of the labels"].min() > 3 * noise
