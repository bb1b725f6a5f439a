"""`refimpl score`: each fault moves its own column and hardly another, nothing depends on unit,
axis or place, and the nulls stand where they belong; from files alone.
"""

from dataclasses import replace
import json

import numpy as np
import pytest

from refimpl.cli import main
from refimpl.embedded.walkers import make_clip, make_database
from refimpl.experiments import judges, nulls, score
from refimpl.motion.body import make_take
from refimpl.motion.bvh import write_bvh
from refimpl.motion.dataset import assemble
from refimpl.motion.joints import FEET, SLOT
from refimpl.motion.rotation import axis_rotation, yaw_rotation

TAKE = make_take(make_clip("turn-left", seconds=4.0).clip)
CONTENT = score.motion_of(TAKE)
SAME = score.compare(CONTENT, CONTENT)
# what may be away from that of a copy where nothing is wrong, by column
NEAR = {name: (0.02 + 0.15 * abs(value)) for name, value in SAME.items()}


def changed(positions, **more):
    return replace(CONTENT, positions=positions, **more)


def moved(found):
    """The columns that moved."""
    return {name for name, value in found.items()
            if "of content" not in name and not abs(value - SAME[name]) <= NEAR[name]}


def slid():
    p = CONTENT.positions.copy()
    t = np.arange(len(p)) / 60
    p[:, FEET[:2], 0] += 0.08 * score.leg_length(p) * np.sin(2 * np.pi * 0.8 * t)[:, None]
    return changed(p)


def longer_forearm():
    p = CONTENT.positions.copy()
    for slot in ("LeftHand", "LeftFinger"):
        p[:, SLOT[slot]] += 0.3 * (CONTENT.positions[:, SLOT["LeftHand"]]
                                   - CONTENT.positions[:, SLOT["LeftForeArm"]])
    return changed(p)


def wider_shoulders():
    p = CONTENT.positions.copy()
    across = 0.3 * (p[:, SLOT["LeftArm"]] - p[:, SLOT["RightArm"]])
    for side, sign in (("Left", 1), ("Right", -1)):
        for part in ("Arm", "ForeArm", "Hand", "Finger"):
            p[:, SLOT[side + part]] += sign * across
    return changed(p)


def jumped():
    p = CONTENT.positions.copy()
    p[100, :, 1] += 20
    return changed(p)


def broken_end():
    p = CONTENT.positions.copy()
    p[-12:] = p[0] + (p[-12:, :1] - p[0, :1]) * [1, 0, 1] + [0, 0, 10]
    return changed(p)


def bent_path():
    """The path turned about its beginning, the body still facing as it did."""
    p = CONTENT.positions
    way = (p[:, :1] - p[:1, :1]) * [1, 0, 1]
    return changed(p - way + way @ yaw_rotation(np.radians(30)).T)


def warped():
    p, T = CONTENT.positions, len(CONTENT.positions)
    at = np.arange(T) + 20 * np.sin(np.pi * np.arange(T) / (T - 1))
    low = np.minimum(at.astype(int), T - 2)
    return changed(p[low] + (at - low)[:, None, None] * (p[low + 1] - p[low]))


@pytest.mark.parametrize("fault, column, also", [
    (slid, "slide (legs/s)", {"jerk (legs/s^3)", "largest acceleration (legs/s^2)",
                              "largest speed (legs/s)", "ends off (ratio)",
                              "bones vary (share)"}),                    # the shin stretches
    (lambda: changed(CONTENT.positions - [0, 8, 0]), "toes above floor (legs)",
     {"lowest foot (legs)"}),
    (longer_forearm, "bones off (share)", {"largest acceleration (legs/s^2)", "jerk (legs/s^3)"}),
    (wider_shoulders, "shoulders width off (share)", set()),
    (jumped, "largest acceleration (legs/s^2)", {"jerk (legs/s^3)", "largest speed (legs/s)"}),
    (broken_end, "ends off (ratio)", {
        "jerk (legs/s^3)", "largest speed (legs/s)", "largest acceleration (legs/s^2)",
        "movement kept (correlation)", "timing off (s)", "path error (legs)", "bones off (share)"}),
    (bent_path, "path error (legs)", {"path met", "slide (legs/s)", "largest speed (legs/s)",
                                      "largest acceleration (legs/s^2)", "jerk (legs/s^3)"}),
    (warped, "timing off (s)", {
        "movement kept (correlation)", "ends off (ratio)", "largest speed (legs/s)",
        "largest acceleration (legs/s^2)", "jerk (legs/s^3)", "slide (legs/s)"})])
def test_a_fault_moves_its_column_and_hardly_another(fault, column, also):
    found = moved(score.compare(fault(), CONTENT))
    assert column in found and found <= {column} | also


@pytest.mark.parametrize("way", [
    lambda p: 0.01 * p, lambda p: p @ yaw_rotation(1.0).T + [300, 0, -70]])
def test_unit_heading_and_place_change_nothing(way):
    other = slid()
    usual = score.compare(other, CONTENT)
    found = score.compare(changed(way(other.positions)), CONTENT)
    for name, value in usual.items():
        assert found[name] == pytest.approx(value, rel=2e-3, abs=2e-3), name


def test_a_warp_is_told_in_seconds():
    assert score.compare(warped(), CONTENT)["timing off (s)"] == pytest.approx(
        20 / 60 * 2 / np.pi, rel=0.15)                           # the mean of a half wave


def test_a_clip_shorter_than_the_farthest_lag_is_compared():
    few = CONTENT.positions[:20]
    assert not score.lags(few, few).any() and score.FARTHEST > len(few)


def test_a_file_with_z_up_is_read_alike(tmp_path):
    turn = axis_rotation("X", np.pi / 2)
    np.save(tmp_path / "z.npy", CONTENT.positions @ turn.T)
    found = score.compare(score.read_motion(tmp_path / "z.npy"), CONTENT)
    assert found["path error (legs)"] < 0.01 and found["movement kept (correlation)"] > 0.999


def test_intervals_hold_the_middle_and_do_not_know_the_order():
    rows = [{"style asked for": "ab"[n % 2], "x": float(n), "seen": n % 3 > 0, "word": "w"}
            for n in range(30)]
    found = score.summary(rows)
    assert found["x"] == 14.5 and found["seen"] == pytest.approx(2 / 3) and "word" not in found
    assert found["x, low"] < 14.5 < found["x, high"]
    assert score.summary(rows[::-1]) == found


@pytest.fixture(scope="module")
def labelled():
    motions = make_database(seconds_per_clip=3.0, people=5, contents=("walk", "jog"),
                            styles=("normal", "old", "zombie"))
    return {m.name: (m, make_take(m.clip, name=m.name)) for m in motions}


def test_each_null_stands_where_it_belongs(labelled):
    known = {n: take for n, (_, take) in labelled.items() if n[-1] in "012"}
    told = {name: (labelled[name][0].content, labelled[name][0].style) for name in known}
    fitted = judges.fit_judges(assemble(known.items(), told, "embedded", 0.34))
    assert fitted.facts["kept_back"] == 6 and min(
        fitted.facts["right_on_kept_back"].values()) == 1
    entries = []
    for content in ("walk", "jog"):
        for style in ("old", "zombie"):
            of = [score.motion_of(labelled[f"{content}_{s}_00{n}"][1])
                  for s, n in (("normal", 3), (style, 3), (style, 4))]
            entries.append(nulls.Entry(of[0], of[1], of[2], "real", content, style,
                                       {"style of content": "normal"}))
    rows = {row["system"]: row for row in nulls.score_table(entries, fitted, nulls=True)
            if row["row"] == "system"}
    assert [row["holds"] for row in rows.values() if "bound" in row] == [True, True, True, None]
    for way in judges.SEES:
        assert rows["real"][f"style seen by {way}"] == rows[nulls.REAL][f"style seen by {way}"] == 1
        assert rows[nulls.COPIED][f"style seen by {way}"] == 0
    assert rows[nulls.COPIED]["movement kept (correlation)"] == 1
    assert (rows[nulls.COPIED]["Fréchet distance"] > 2 * rows["real"]["Fréchet distance"])


@pytest.fixture(scope="module")
def folder(labelled, tmp_path_factory):
    out = tmp_path_factory.mktemp("score")
    (out / "known").mkdir()
    for name, (motion, _) in labelled.items():
        write_bvh((out / "known" if name[-1] in "012" else out) / f"{name}.bvh", motion.clip)
    return out


def test_files_alone_make_the_table(folder, capsys):
    lines = ["content,style,result,system",
             *(f"{c}_normal_003.bvh,{c}_old_003.bvh,{c}_old_004.bvh,mine" for c in ("walk", "jog"))]
    (folder / "t.csv").write_text("\n".join(lines))
    command = ["score", str(folder / "t.csv"), "--judges", str(folder / "known"), "--nulls"]
    assert main([*command, "--json", str(folder / "t.json"), "--sheet",
                 str(folder / "t.png")]) == 0
    assert "style seen by joints" in capsys.readouterr().out
    told = json.loads((folder / "t.json").read_text())
    assert told["command"] == "score" and len(told["judges"]["sha256"]) == 64
    assert ([row["row"] for row in told["rows"][:3]] == ["result", "result", "system"]
            and {nulls.COPIED, nulls.EXEMPLAR} < {row["system"] for row in told["rows"]})
    assert all(row["style seen by joints"] for row in told["rows"] if row["system"] == "mine")
    assert (folder / "t.png").stat().st_size > 10000
    (folder / "t.csv").write_text("﻿" + "\n".join(line.replace(",", ";") for line in (
        lines[0], "", *reversed(lines[1:]))))
    assert main([*command, "--json", str(folder / "again.json")]) == 0
    again = json.loads((folder / "again.json").read_text())
    assert ([row for row in told["rows"] if row["row"] == "system"]
            == [row for row in again["rows"] if row["row"] == "system"])


@pytest.mark.parametrize("lines, said", [
    ([], "found columns none"), (["content,result"], "needed style too"),
    (["content,style,result"], "found no row below the header"),
    (["content,style,result", "no.bvh,no.bvh,no.bvh"], "found no row that can be scored")])
def test_a_bad_table_is_refused_in_one_line(folder, capsys, lines, said):
    (folder / "bad.csv").write_text("\n".join(lines))
    assert main(["score", str(folder / "bad.csv")]) == 2
    assert said in capsys.readouterr().err


def test_a_row_that_cannot_be_scored_says_why(folder, capsys):
    (folder / "some.csv").write_text("\n".join([
        "content,style,result", "walk_normal_003.bvh,walk_old_003.bvh,gone.bvh",
        "walk_normal_003.bvh,walk_sad_003.bvh,walk_old_004.bvh",
        "walk_normal_003.bvh,walk_old_003.bvh,walk_old_004.bvh"]))
    np.save(folder / "walk_sad_003.npy", CONTENT.positions)
    text = (folder / "some.csv").read_text().replace("walk_sad_003.bvh", "walk_sad_003.npy")
    (folder / "some.csv").write_text(text)
    assert main(["score", str(folder / "some.csv"), "--judges", str(folder / "known"), "--json",
                 str(folder / "some.json")]) == 0
    rows = json.loads((folder / "some.json").read_text())["rows"]
    assert "gone.bvh" in rows[0]["reason"] and "none that the judges know" in rows[1]["reason"]
    assert rows[1]["style seen by joints"] is None and rows[2]["style seen by joints"] is True
    assert "line 2:" in capsys.readouterr().out


def test_a_body_that_lies_is_told(folder, capsys):
    np.save(folder / "lies.npy", CONTENT.positions[..., [1, 0, 2]])
    (folder / "lies.csv").write_text("content,style,result\n"
                                     "walk_normal_003.bvh,walk_old_003.bvh,lies.npy")
    assert main(["score", str(folder / "lies.csv")]) == 0
    assert "result: its head is" in capsys.readouterr().out


def test_points_have_the_rate_of_a_content_with_as_many_rows(tmp_path):
    np.save(tmp_path / "thin.npy", CONTENT.positions[::2])
    slow = replace(CONTENT, fps=30.0)
    found = score.compare(score.read_motion(tmp_path / "thin.npy", slow), slow)
    assert found["timing off (s)"] < 0.01 and abs(found["duration off (s)"]) <= 1 / 60
    alone = score.compare(score.read_motion(tmp_path / "thin.npy"), slow)
    assert alone["duration off (s)"] < -1
