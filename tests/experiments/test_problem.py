"""The tables of `experiment holden` that write files, on embedded motion with networks too small to
be right: what is for what, and which columns know.
"""

import json

import numpy as np
import pytest

from refimpl.cli import main
from refimpl.experiments import problem

SMALL = ["--hidden", "8", "--channels", "4", "--loss-epochs", "1", "--epochs", "1", "--steps", "10"]


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    out = tmp_path_factory.mktemp("problem")
    assert main(["experiment", "holden", "--tables", "problem,statements,body,figures", "--out",
                 str(out / "out"), "--json", str(out / "told.json"), *SMALL]) == 0
    return out / "out", json.loads((out / "told.json").read_text())


def test_no_clip_is_for_two_things(told):
    _, report = told
    parts = report["split"]
    assert set(parts["learn"]) <= set(parts["loss"])
    apart = [set(parts[part]) for part in ("loss", "exemplars", "real", "contents")]
    assert sum(map(len, apart)) == len(set().union(*apart)) and all(apart)
    assert not set(parts["judges"]) & (apart[1] | apart[2] | apart[3] | set(parts["learn"]))
    assert not any("old" in name for name in parts["loss"])      # the style is none that L saw


def test_nulls_and_baselines_stand_where_they_belong(told):
    out, report = told
    rows = {row["system"]: row for row in report["rows"] if row.get("row") == "system"}
    assert {problem.AS_IT_IS, problem.OWN_PACE, problem.RAW, problem.POSTURE, problem.SPECTRA,
            problem.OTHER_TAKE} < set(rows)
    bound = [row["holds"] for row in rows.values() if "bound" in row]
    assert len(bound) >= 4 and False not in bound
    other = rows[problem.OTHER_TAKE]
    assert other["style seen by joints"] == 1 and other["style left (content = 1)"] < 0.5
    assert not rows[problem.POSTURE]["path met"] == rows[problem.SPECTRA]["path met"]
    assert (out / "table.csv").read_text().count("\n") > 40


def test_scoring_the_files_again_gives_the_last_digit(told, tmp_path):
    out, report = told
    assert main(["score", str(out / "table.csv"), "--judges", str(out / "judges"), "--json",
                 str(tmp_path / "again.json")]) == 0
    again = {row["system"]: row for row in json.loads((tmp_path / "again.json").read_text())["rows"]
             if row["row"] == "system"}
    for row in report["rows"]:
        if row.get("row") == "system" and row["system"] in again:
            same = again[row["system"]]
            assert same.items() <= row.items()


def test_what_the_paper_says_in_passing(told):
    _, report = told
    rows = [row for row in report["rows"] if row["table"] == "statements"]
    reach = {row["what"]: row["frames"] for row in rows if row["of"] == "reach"}
    assert reach == {"a hidden unit of L": 26, "T(I)": 73, "P(T(I))": 122}
    later = [row["error (cm)"] for row in rows if row["of"] == "known later"]
    assert later[0] > later[-1] >= 0 and later[-1] < 1e-3 * later[0]
    assert len([row for row in report["rows"] if row["table"] == "body"]) == 2


def test_the_figures_are_drawn(told):
    out, _ = told
    for number in (1, 2, 3, 4):
        assert (out / f"figure{number}.png").stat().st_size > 20000


def test_baselines_move_what_they_say():
    rng = np.random.default_rng(0)
    X, S = (np.cumsum(rng.normal(size=(n, 66)), axis=0) + m for n, m in ((200, 0), (150, 30)))
    for way in (problem.moved_posture, problem.moved_spectra):
        O = way(X, S)
        assert O.shape == X.shape
        np.testing.assert_allclose(O[:, :63].mean(axis=0), S[:, :63].mean(axis=0), atol=8)
    assert (problem.moved_spectra(X, S)[:, 63:] == X[:, 63:]).all()
