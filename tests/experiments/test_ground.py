"""How well results stand: the measures on motion of which the answer is known, and the command."""

import json

import numpy as np
import pytest

from refimpl.cli import main
from refimpl.embedded.walkers import make_database
from refimpl.experiments import ground as experiment, holden
from refimpl.holden2017 import networks
from refimpl.holden2017.trained import Manifold, Style
from refimpl.motion.body import make_take
from refimpl.motion.features import bone_lengths
from refimpl.motion.windows import fit_normaliser


@pytest.fixture(scope="module")
def world():
    motions = make_database(seconds_per_clip=4.0, people=6, styles=("normal", "old"))
    takes = {m.name: make_take(m.clip, name=m.name) for m in motions if m.content == "walk"}
    labels = {m.name: (m.content, m.style) for m in motions if m.content == "walk"}
    ground = holden.ground(takes, labels, "test", kept_out="_000$", learn="_001$",
                           classify="_00[1-5]$")
    take = next(iter(takes.values()))
    manifold = Manifold(networks.init_loss_network(np.random.default_rng(0), hidden=16),
                        fit_normaliser(np.concatenate([t.features for t in takes.values()]),
                                       "test"), take.leg, bone_lengths(take.positions))
    style = Style(networks.init_transformation_network(np.random.default_rng(1), channels=8),
                  manifold, "old", {"walk": "walk"})
    return ground, takes, style


def test_real_takes_are_the_unit_and_the_content_keeps_its_path(world):
    rows = {row["what"]: row for row in experiment.result_rows(*world)}
    real, content, raw, clean = (rows[what] for what in ("real takes", "content itself",
                                                         "no clean-up", "result"))
    assert all(0.5 < real[name] < 2.0 for name in (*experiment.WATCHED, "legs' jerk"))
    assert real["seen"] == 1.0 and content["seen"] == 0.0 and real["clips"] == 1
    assert content["path"] < raw["path"] and clean["slide"] < 0.4 * raw["slide"]


def test_ends_that_go_on_are_nearer_to_the_clip_cut_later_than_zeros(world):
    rows = {row["what"]: row for row in experiment.end_rows(*world)}
    there, zeros = rows["goes on"], rows["zeros"]
    assert there["4 frames"] < 0.3 * zeros["4 frames"] and there["after"] < 0.1
    assert "bones, first" not in rows["after clean-up"]


def test_motion_that_needs_no_clean_up_is_hardly_moved(world):
    [row] = experiment.leg_rows(*world[:2])
    assert row["clips"] == 2 and row["slide"] < 0.4 * row["slide before"]
    assert row["legs' jerk"] < 1.4 and 0.1 < row["moved"] < 3.0


def test_the_command_measures_and_names_what_is_lacking(tmp_path, capsys):
    small = ["--hidden", "8", "--channels", "3", "--loss-epochs", "1", "--epochs", "1"]
    out = tmp_path / "rows.json"
    assert main(["experiment", "ground", *small, "--json", str(out)]) == 0
    rows = json.loads(out.read_text())["rows"]
    assert ([(row["table"], row["what"]) for row in rows]
            == [*(("results", what) for what in ("content itself", "no clean-up", "result",
                                                 "real takes")),
                *(("ends", what) for what in ("goes on", "after clean-up", "zeros")),
                ("legs", "real takes")])
    assert "slide before" in capsys.readouterr().out
    assert main(["experiment", "ground", "--styles", "giant"]) == 2
    assert "found no clip of style 'giant'" in capsys.readouterr().err
