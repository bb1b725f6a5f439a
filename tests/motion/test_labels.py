"""Labels with a begin and an end, 100STYLE's table, clips left out, mappings by pattern."""

import os
from pathlib import Path

import numpy as np
import pytest

from refimpl.cli import main
from refimpl.motion import bvh
from refimpl.motion.body import read_take
from refimpl.motion.dataset import load_dataset, read_piece
from refimpl.motion.labels import (LabelError, Excerpt, find_clips, labels_from_file,
                                   piece_named)

from . import bodies


@pytest.fixture
def folder(tmp_path):
    """Two skeletons in one folder, and a file that is none."""
    place = tmp_path / "clips"
    place.mkdir()
    for n, (name, scheme) in enumerate((("Old_FW", "100STYLE"), ("Old_ID", "100STYLE"),
                                        ("Happy_FW", "CMU"))):
        clip, _ = bodies.on_scheme(bodies.walker(seed=n), scheme)
        bvh.write_bvh(place / f"{name}.bvh", clip)
    (place / "Broken_FW.bvh").write_text("nothing\n")
    return place


CUTS = ("STYLE_NAME,FW_START,FW_STOP,ID_START,ID_STOP,BW_START,BW_STOP\nOld,10,70,5,100,N/A,N/A\n"
        "Happy,20,90,N/A,N/A,1,9\n")


def test_100styles_table_is_read_as_it_is(folder, tmp_path):
    table = tmp_path / "Frame_Cuts.csv"
    table.write_text(CUTS)
    labels = labels_from_file(sorted(folder.glob("*.bvh")), table, folder)
    assert labels == {Excerpt(folder / "Old_FW.bvh", 10, 70): ("FW", "Old"),
                      Excerpt(folder / "Old_ID.bvh", 5, 100): ("ID", "Old"),
                      Excerpt(folder / "Happy_FW.bvh", 20, 90): ("FW", "Happy")}
    assert main(["prepare", str(folder), "--labels", str(table), "-o",
                 str(tmp_path / "m.npz")]) == 0
    dataset = load_dataset(tmp_path / "m.npz")
    assert {c.name: len(c.features) for c in dataset.clips} == {
        "Old_FW[10:70]": 60, "Old_ID[5:100]": 95, "Happy_FW[20:90]": 70}
    feet = dataset.clips[0].features[:, :63].reshape(-1, 21, 3)      # one body for both skeletons
    lengths = [np.linalg.norm(c.features[:, 3:6] - c.features[:, 6:9], axis=1)
               for c in dataset.clips]
    assert feet.shape[0] in (60, 95, 70) and np.ptp(np.concatenate(lengths)) < 1e-6


@pytest.mark.parametrize("lines, words", [
    ("Old_FW,FW,Old,10,5", "two whole numbers"), ("Old_FW,FW,Old,a,5", "two whole numbers"),
    ("Old_FW,FW,Old", "needed clip,content,style,begin,end")])
def test_parts_that_cannot_be_are_named(folder, tmp_path, lines, words):
    table = tmp_path / "labels.csv"
    table.write_text("clip,content,style,begin,end\n" + lines + "\n")
    with pytest.raises(LabelError, match=f"labels.csv:2: .*{words}"):
        labels_from_file(sorted(folder.glob("*.bvh")), table, folder)


def test_a_part_beyond_the_clip_is_refused(folder, tmp_path, capsys):
    table = tmp_path / "labels.csv"
    table.write_text("clip,content,style,begin,end\nOld_FW,FW,Old,10,5000\n")
    assert main(["prepare", str(folder), "--labels", str(table), "-o",
                 str(tmp_path / "m.npz")]) == 2
    assert "found 120 rows, needed 5000" in capsys.readouterr().err


def test_bad_clips_are_left_out_and_listed(folder, tmp_path, capsys):
    arguments = ["prepare", str(folder), "--pattern", "(?P<style>[^_]+)_(?P<content>[^_]+)", "-o",
                 str(tmp_path / "m.npz"), "--hold-out", "0"]
    assert main(arguments) == 2 and not (tmp_path / "m.npz").exists()
    assert main([*arguments, "--skip-bad"]) == 0
    out = capsys.readouterr().out
    assert "left out, 1:" in out and "Broken_FW.bvh" in out
    assert "from the names: content FW, ID; style Broken, Happy, Old" in out
    assert len(load_dataset(tmp_path / "m.npz").clips) == 3


def test_a_mapping_for_some(folder, tmp_path, capsys):
    own = Path(tmp_path / "own.csv")
    own.write_text("Neck,Neck\nSpine,Chest2\n")
    arguments = ["prepare", str(folder), "--pattern", "(?P<style>[^_]+)_(?P<content>FW)", "-o",
                 str(tmp_path / "m.npz"), "--skip-bad", "--mapping-for"]
    assert main([*arguments, "Old", str(own)]) == 0
    assert main([*arguments, "Happy", str(own)]) == 0                # CMU has no Chest2
    assert "'Chest2'" in capsys.readouterr().out


def test_a_part_is_found_again_by_its_name(folder):
    paths = {path.stem: path for path in find_clips(folder)}
    piece = piece_named("Old_FW[10:70]", paths)
    assert read_piece(piece).clip.frames == 60
    whole = piece_named("Old_FW", paths)
    np.testing.assert_array_equal(read_piece(whole).positions,
                                  read_take(paths["Old_FW"]).positions)
    assert piece_named("Old_FX[10:70]", paths) is None is piece_named("Old_FX", paths)


def test_a_folder_of_points_alone_is_read(folder, tmp_path):
    place = tmp_path / "points"
    place.mkdir()
    for n in range(2):
        np.save(place / f"walk_old_{n}.npy", read_take(folder / "Happy_FW.bvh").positions / 100)
    assert main(["prepare", str(place), "-o", str(tmp_path / "points.npz")]) == 0
    assert len(load_dataset(tmp_path / "points.npz").clips) == 2


def test_a_name_that_two_clips_have_is_refused_and_its_path_is_not(tmp_path):
    for name in ("anna/take1.bvh", "bob/take1.bvh", "take2.bvh", "bob/take2.bvh"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("")
    paths, table = find_clips(tmp_path), tmp_path / "labels.csv"
    for name in ("take1", "take1.bvh", "take2"):
        table.write_text(f"clip,content,style\n{name},walk,old\n")
        with pytest.raises(LabelError, match=f"labels.csv:2: found '{name}', which 2 clips are"):
            labels_from_file(paths, table, tmp_path)
    table.write_text("clip,content,style\nanna/take1,walk,old\ntake2.bvh,walk,new\n")
    assert labels_from_file(paths, table, tmp_path) == {
        tmp_path / "anna/take1.bvh": ("walk", "old"), tmp_path / "take2.bvh": ("walk", "new")}
    table.write_text("STYLE_NAME,1_START,1_STOP\ntake1,0,10\n")
    for name in ("anna", "bob"):
        (tmp_path / name / "take1_1.bvh").write_text("")
    with pytest.raises(LabelError, match="which 2 clips are"):
        labels_from_file(find_clips(tmp_path), table, tmp_path)


def test_no_clip_is_left_out_without_a_word(tmp_path, monkeypatch):
    (tmp_path / "sub").mkdir()
    for name in ("a_b_1.bvh", "sub/a_b_1.bvh"):
        (tmp_path / name).write_text("")
    assert len(find_clips(tmp_path)) == 2
    (tmp_path / "sub" / "a_b_1.BVH").write_text("")
    with pytest.raises(LabelError, match="a_b_1.BVH beside it|a_b_1.bvh.*beside it"):
        find_clips(tmp_path)
    os.remove(tmp_path / "sub" / "a_b_1.BVH")
    listed = os.scandir

    def refuse(path):
        if str(path).endswith("sub"):
            raise PermissionError(13, "Permission denied", str(path))
        return listed(path)
    monkeypatch.setattr(os, "scandir", refuse)                   # root may read every folder
    with pytest.raises(PermissionError, match="sub"):
        find_clips(tmp_path)


@pytest.mark.parametrize("row, words", [("Old,1,x", "found rows 1 to x"),
                                        ("Old,1", "found 2 cells, needed 3"),
                                        ("Old,1,5\nOld,1,5", "a second time")])
def test_a_table_of_cuts_is_not_half_read(folder, tmp_path, row, words):
    table = tmp_path / "cuts.csv"
    table.write_text(f"STYLE_NAME,FW_START,FW_STOP\n{row}\n")
    with pytest.raises(LabelError, match=words):
        labels_from_file(sorted(folder.glob("*.bvh")), table, folder)


def test_what_could_not_be_read_again_is_not_written(tmp_path):
    from dataclasses import replace
    from refimpl.embedded import walkers
    from refimpl.motion.body import make_take
    from refimpl.motion.dataset import assemble, save_dataset
    good = assemble([("a", make_take(walkers.make_clip(seconds=1.0).clip))], {"a": ("b", "c")}, "s")
    for bad in (replace(good, leg=float("inf")), replace(good, bones=good.bones * 1e12),
                replace(good, clips=(replace(good.clips[0], features=good.clips[0].features
                                             * float("nan")),))):
        with pytest.raises(ValueError, match="m.npz: found arrays and labels that do not fit"):
            save_dataset(tmp_path / "m.npz", bad)
    assert not list(tmp_path.iterdir())
