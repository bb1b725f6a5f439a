"""Nothing lost, nothing let in: a small part of the fuzzing and the killing, and every way that a
disk can refuse.
"""

import errno
import json
import os
import resource
import subprocess
import sys
import tempfile
import zipfile

import numpy as np
import pytest

import refimpl
from refimpl.cli import main
from refimpl.commands.checkpoint import fingerprint, load_checkpoint, save_checkpoint
from refimpl.holden2017.train import Record, State, start_state
from refimpl.motion import bvh
from refimpl.embedded import walkers as synthetic
from refimpl.motion.clip import BVHError
from refimpl.storage import FormatError, atomic_write, load_npz, save_npz
from tests.hostile import faults, targets
from tests.commands.terminals import OnTerminal
from tests.hostile.fuzz import campaign, made_clips
from tests.hostile.kills import campaign as killing, commands, prepare_folder

ROOT = os.path.dirname(os.path.dirname(refimpl.__file__))

# Inputs of the fuzzer that once raised something else than they should: an archive whose members
# lie before its beginning, array headers that NumPy's reader cannot split into words, letters where
# numbers should be, and a label file that begins with an empty line.
ONCE_WRONG = (225, 238, 3863, 4567, 78118, 147428, 155574, 159569)


def test_a_fixed_part_of_the_fuzzing(tmp_path):
    outcomes, wrong = campaign([*ONCE_WRONG, *range(2000)], tmp_path, made_clips(),
                               seconds=np.inf)
    assert not wrong, wrong[0]
    # a fuzzer whose inputs are all refused, or all read, tests little
    for kind in ("grammar", "mutation", "npz", "labels", "mapping"):
        assert outcomes[f"{kind}: read"] > 0
    assert outcomes["grammar: BVHError"] > 0 and outcomes["npz: FormatError"] > 0


def test_killed_trainings_end_with_the_same_bits(tmp_path):
    made, under_way, finished, corrupt, differing = killing(tmp_path, 2, epochs=25)
    assert made == 2 and under_way and finished and not corrupt and not differing


def test_kills_at_events_lose_nothing_and_leave_nobody(tmp_path):
    """All commands, 500 times: `python -m tests.hostile.kills`."""
    done = subprocess.run([sys.executable, "-m", "tests.hostile.kills", "12", "prepare by two",
                           "inspect", "resume", "check"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "12 kills at events of 4 commands" in done.stdout


def test_the_same_seed_gives_the_same_bytes(tmp_path):
    prepare_folder(tmp_path)
    for name in ("whole", "again"):
        for words in commands(tmp_path, name):
            assert main(words) == 0
    for kind in ("manifold", "old"):
        assert ((tmp_path / f"whole-{kind}.npz").read_bytes()
                == (tmp_path / f"again-{kind}.npz").read_bytes())
    assert not list(tmp_path.glob("*.checkpoint"))                           # it has done its work
    assert main([*commands(tmp_path, "other")[0][:-2], "--batch", "3", "--seed", "1"]) == 0
    assert ((tmp_path / "other-manifold.npz").read_bytes()
            != (tmp_path / "whole-manifold.npz").read_bytes())


def test_a_checkpoint_of_another_run_is_refused(tmp_path, capsys):
    fresh = start_state({"W0": np.ones((1, 2, 3), np.float32)})
    state = State(fresh.params, {**fresh.adam, "t": 4}, 1)
    records = [Record(1, {"loss": 0.5}, 1.0, 2.0)]
    save_checkpoint(tmp_path / "c", state, records, fingerprint({"seed": 1}))
    again, told, exact = load_checkpoint(tmp_path / "c", fingerprint({"seed": 1}), fresh.params, 9)
    assert (exact and told == records and (again.epoch, again.adam["t"]) == (1, 4)
            and np.array_equal(again.params["W0"], state.params["W0"]))
    with pytest.raises(FormatError, match="other settings"):
        load_checkpoint(tmp_path / "c", fingerprint({"seed": 2}), fresh.params, 9)
    words = [fingerprint({}, np.zeros(*shape)).settings for shape in ((2,), (3,), (3, np.float32))]
    assert len(set(words)) == 3


def test_a_training_that_breaks_keeps_its_checkpoint_and_names_the_batch(tmp_path, capsys):
    prepare_folder(tmp_path)
    words = [*commands(tmp_path, "wild")[0], "--rate", "1e18"]
    with np.errstate(all="ignore"):
        assert main(words) == 2
    err = capsys.readouterr().err
    assert "batch" in err and "needed finite numbers" in err and "lower the learning rate" in err
    assert not (tmp_path / "wild-manifold.npz").exists()


def run(words, folder, **limits):
    """The command in a process of its own.   ->  status, standard error"""
    here = {**os.environ, "PYTHONPATH": ROOT}
    done = subprocess.run([sys.executable, "-m", "refimpl", *map(str, words)], cwd=folder, env=here,
                          capture_output=True, text=True, timeout=120, **limits)
    return done.returncode, done.stderr


def test_ctrl_c_ends_cleanly(tmp_path):
    import signal
    prepare_folder(tmp_path)
    words = commands(tmp_path, "stopped")[0]
    words[words.index("--epochs") + 1] = "100000"
    training = OnTerminal(words)
    assert training.until(r"epoch [1-9]\d*/")
    training.process.send_signal(signal.SIGINT)
    assert training.end() == 130
    assert "stopped" in training.seen()[-1] and "Traceback" not in training.text
    assert (tmp_path / "stopped-manifold.npz.checkpoint").exists()


def test_a_full_disk_is_one_line_and_leaves_nothing(tmp_path):
    """A limit on the size of files stands for the full disk: writing fails half-way with an
    OSError.
    """
    clips = tmp_path / "clips"
    clips.mkdir()
    for number in range(2):
        bvh.write_bvh(clips / f"walk_normal_{number}.bvh", synthetic.make_clip(seconds=4.0).clip)
    status, err = run(["prepare", clips, "-o", tmp_path / "motions.npz"], tmp_path,
                      preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE,
                                                            (20_000, 20_000)))
    assert (status == 2 and err.splitlines()[-1].startswith("refimpl: error:")
            and "Traceback" not in err)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["clips"]


@pytest.mark.parametrize("step, number",
                         [("open", errno.EACCES), ("open", errno.EROFS),
                          ("fsync", errno.ENOSPC), ("replace", errno.EPERM)])
def test_every_step_of_a_write_may_be_refused(step, number, tmp_path, monkeypatch, capsys):
    """Permission, a read-only file system, a disk that is full when the bytes go down, a name that
    may not be replaced.
    """
    clips = tmp_path / "clips"
    clips.mkdir()
    bvh.write_bvh(clips / "walk_normal_0.bvh", synthetic.make_clip(seconds=1.0).clip)
    (tmp_path / "motions.npz").write_text("old")

    def refuse(*arguments, **options):
        raise OSError(number, os.strerror(number), str(tmp_path / "motions.npz"))
    if step == "open":
        monkeypatch.setattr(tempfile, "TemporaryFile", refuse)
    else:
        monkeypatch.setattr(os, step, refuse)
    assert main(["prepare", str(clips), "-o", str(tmp_path / "motions.npz")]) == 2
    err = capsys.readouterr().err.splitlines()[-1]
    assert err.startswith("refimpl: error:") and os.strerror(number) in err
    assert ((tmp_path / "motions.npz").read_text() == "old"
            and sorted(p.name for p in tmp_path.iterdir()) == ["clips", "motions.npz"])


def test_each_call_of_a_commands_writing_may_fail(tmp_path):
    """All commands, in seven ways: `python -m tests.hostile.faults`."""
    targets.made(tmp_path)
    counts, wrong = faults.campaign(tmp_path, ["inspect"], ["no space", "memory", "SIGTERM"])
    more, worse = faults.campaign(tmp_path, ["resume"], ["device"])
    assert counts["inspect"][0] > 10 and more["resume"][0] > 10 and not wrong + worse


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_read_only_folder_is_one_line(tmp_path):
    clips = tmp_path / "clips"
    clips.mkdir()
    bvh.write_bvh(clips / "walk_normal_0.bvh", synthetic.make_clip(seconds=1.0).clip)
    clips.chmod(0o555)
    status, err = run(["prepare", clips, "-o", clips / "motions.npz"], tmp_path)
    assert status == 2 and err.count("\n") == 1 and "Permission denied" in err


def test_folders_where_files_are_meant(tmp_path, capsys):
    for words in (["inspect", str(tmp_path)],
                  ["train-autoencoder", str(tmp_path), "-o", str(tmp_path / "x")],
                  ["transfer", str(tmp_path), "x", "-o", "y.bvh"],
                  ["prepare", __file__, "-o", str(tmp_path / "x")],
                  ["prepare", str(tmp_path), "-o", str(tmp_path)]):
        assert main(words) == 2
        err = capsys.readouterr().err
        assert err.startswith("refimpl: error:") and err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_names_with_spaces_and_other_letters(tmp_path, capsys):
    folder = tmp_path / "Bewegungen – 歩く"
    folder.mkdir()
    path = folder / "gehen_müde_1.bvh"
    bvh.write_bvh(path, synthetic.make_clip(seconds=1.0).clip)
    assert main(["prepare", str(folder), "-o", str(folder / "alle Daten.npz")]) == 0
    assert "müde" in capsys.readouterr().out
    assert main(["inspect", str(path)]) == 0


def test_a_write_that_fails_leaves_the_old_file_and_no_other(tmp_path):
    path = tmp_path / "file"
    path.write_text("old")
    with pytest.raises(RuntimeError):
        with atomic_write(path) as file:
            file.write("half of the ne")
            raise RuntimeError
    assert path.read_text() == "old" and list(tmp_path.iterdir()) == [path]


def test_an_endless_line_is_refused_before_it_is_read(tmp_path):
    path = tmp_path / "long.bvh"
    with open(path, "wb") as file:
        file.write(b"HIERARCHY\nROOT ")
        # a gigabyte, most of it a hole in the file
        file.seek(1 << 30)
        file.write(b"\n")
    resource_before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(BVHError, match="long.bvh:2: found a line of more than"):
        bvh.read_bvh(path)
    # kilobytes
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - resource_before < 300_000


def test_huge_claims_are_refused(tmp_path):
    """Numbers that would fill the memory if they were believed."""
    text = bvh.format_bvh(synthetic.make_clip(seconds=0.1).clip)
    with pytest.raises(BVHError, match="999999999 as Frames: says"):
        bvh.parse_bvh(text.replace("Frames:\t6", "Frames:\t999999999"))
    with pytest.raises(BVHError, match="a whole number of frames"):
        bvh.parse_bvh(text.replace("Frames:\t6", "Frames:\t" + "9" * 5000))
    header = np.lib.format.magic(1, 0)
    claim = (str({"descr": "<f8", "fortran_order": False, "shape": (10 ** 13,)}).ljust(117).encode()
             + b"\n")
    with zipfile.ZipFile(tmp_path / "bomb.npz", "w") as archive:
        archive.writestr("W0.npy", header + len(claim).to_bytes(2, "little") + claim)
    with pytest.raises(FormatError, match="shorter than it claims"):
        load_npz(tmp_path / "bomb.npz", "manifold", 1, ())


def test_pickles_are_never_opened(tmp_path):
    class Bomb:
        def __reduce__(self):
            return (os.system, (f"touch {tmp_path}/went-off",))
    np.savez(tmp_path / "bomb.npz", header=np.array([Bomb()], dtype=object))
    with pytest.raises(FormatError, match="needed a refimpl manifold file"):
        load_npz(tmp_path / "bomb.npz", "manifold", 1, ())
    assert not (tmp_path / "went-off").exists()


def test_foreign_newer_and_incomplete_files_are_named(tmp_path):
    path = tmp_path / "file.npz"
    save_npz(path, "manifold", 2, {"W0": np.zeros(2)}, {"leg": 80.0})
    for arguments, words in ((("manifold", 1, ()), "version 2 of the manifold format"),
                             (("style", 2, ()), "a refimpl manifold file, needed a refimpl style"),
                             (("manifold", 2, ("b0",)), "found no b0"),
                             (("manifold", 2, (), {"leg": str}), "found no leg")):
        with pytest.raises(FormatError, match=words):
            load_npz(path, *arguments)
    data = path.read_bytes()
    for at in range(0, len(data) - 1, 37):
        path.write_bytes(data[:at])
        with pytest.raises(FormatError):
            load_npz(path, "manifold", 2, ())
    np.savez(path, header=np.array(json.dumps([1, 2])))
    with pytest.raises(FormatError, match="found a refimpl list file"):
        load_npz(path, "manifold", 2, ())
    np.savez_compressed(path, header=np.array("{}"))
    with pytest.raises(FormatError, match="no plain .npy"):
        load_npz(path, "manifold", 2, ())


@pytest.mark.mocap
def test_world_positions_agree_with_pybvh(mocap):
    """An independent reader. Needs pybvh (pip install pybvh)."""
    pytest.importorskip("pybvh", reason="needs pybvh from PyPI")
    from tests.hostile.witness import largest_difference
    for path in sorted(mocap.rglob("*.bvh"))[::60]:
        assert largest_difference(path) < 1e-9
