"""No output destroys anything: an input, another output, a checkpoint, a link, a pipe, a device.
And every failure is one line.
"""

import json
import os
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

from refimpl.cli import main
from refimpl.commands import checkpoint
from refimpl.motion import bvh
from refimpl.embedded import walkers as synthetic
from refimpl.storage import OutputError, atomic_write, check_outputs, protected, save_npz

from .commands.terminals import OnTerminal
from .hostile import targets

TINY = ["--epochs", "1", "--width", "9", "--batch", "4"]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Clips, motions.npz, manifold.npz and old.npz of tiny networks."""
    out = tmp_path_factory.mktemp("made")
    (out / "clips").mkdir()
    for style in ("normal", "old"):
        for number in range(2):
            clip = synthetic.make_clip("walk", style, synthetic.person(number), seconds=4.1,
                                       seed=number).clip
            bvh.write_bvh(out / "clips" / f"walk_{style}_{number}.bvh", clip)
    assert main(["prepare", str(out / "clips"), "-o", str(out / "motions.npz")]) == 0
    assert main(["train-autoencoder", str(out / "motions.npz"), "-o", str(out / "manifold.npz"),
                 "--hidden", "6", *TINY]) == 0
    assert main(["train-style", str(out / "motions.npz"), str(out / "manifold.npz"), "--style",
                 "old", "-o", str(out / "old.npz"), "--channels", "4", *TINY]) == 0
    return out


@pytest.fixture
def here(made, tmp_path, monkeypatch):
    """A folder with copies of everything, and the current one."""
    import shutil
    shutil.copytree(made, tmp_path / "w")
    monkeypatch.chdir(tmp_path / "w")
    (tmp_path / "w" / "c.bvh").write_bytes((made / "clips" / "walk_normal_1.bvh").read_bytes())
    (tmp_path / "w" / "map.csv").write_text("Head,Head\n")
    (tmp_path / "w" / "labels.csv").write_text("clip,content,style\nwalk_old_0,walk,old\n")
    (tmp_path / "w" / "known").write_text("gram/*\n")
    os.link("c.bvh", "hard.bvh")
    os.link("c.bvh", "hard.png")
    os.symlink("c.bvh", "soft.bvh")
    return tmp_path / "w"


def contents(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*"))
            if p.is_file()}


COLLISIONS = [
    "transfer old.npz c.bvh -o c.bvh", "transfer old.npz c.bvh -o soft.bvh",
    "transfer old.npz c.bvh -o hard.bvh",
    "transfer old.npz c.bvh -o clips/../c.bvh", "transfer old.npz c.bvh -o new.bvh --plot hard.png",
    "transfer old.npz c.bvh -o new.bvh --json old.npz",
    "transfer old.npz c.bvh -o new.bvh --plot a.png --json a.png",
    "transfer old.npz c.bvh -o new.bvh --json new.bvh",
    "transfer old.npz c.bvh -o new.bvh --mapping map.csv --json map.csv",
    "transfer --method optimise --content c.bvh --style clips/walk_old_0.bvh --manifold "
    "manifold.npz -o clips/walk_old_0.bvh",
    "inspect c.bvh --json c.bvh", "inspect c.bvh --json hard.bvh",
    "inspect c.bvh --write-mapping c.bvh", "inspect c.bvh --json a --write-mapping a",
    "prepare clips -o clips/walk_old_0.bvh", "prepare clips -o labels.csv --labels labels.csv",
    "prepare clips -o map.csv --mapping map.csv",
    "train-autoencoder motions.npz -o motions.npz",
    "train-autoencoder motions.npz -o a.png --curves a.png",
    "train-style motions.npz manifold.npz --style old -o manifold.npz",
    "train-style motions.npz manifold.npz --style old -o a.npz --report a.npz",
    "train-style motions.npz manifold.npz --style old -o a.npz --report motions.npz",
    "evaluate clips motions.npz old.npz --out clips", "synthesise c.bvh clips -o c.bvh",
    "synthesise c.bvh clips -o clips/walk_old_0.bvh",
    "experiment torresani clips --out clips", "check --operations gram --json a --junit a",
    "check refimpl.nn --operations gram --xfail known --json known",
    "bench --json c.bvh/x",
]


@pytest.mark.parametrize("words", COLLISIONS)
def test_one_file_for_two_things_is_refused_before_any_work(words, here, capsys):
    before = contents(here)
    assert main(words.split()) == 2
    err = capsys.readouterr().err
    assert err.startswith("refimpl: error:") and err.count("\n") == 1
    assert contents(here) == before


def test_every_output_of_a_command_on_every_kind_of_target(made):
    """All commands on all kinds: `python -m tests.hostile.targets`."""
    for name in ("c.bvh", "known"):
        (made / name).write_bytes((made / "clips" / "walk_normal_1.bvh").read_bytes())
    some = targets.campaign(made, ["inspect", "prepare"], (*targets.REFUSED, *targets.WRITTEN))
    some += targets.campaign(made, ["transfer", "train-style", "train-2016"], targets.REFUSED)
    assert len(some) > 120 and not [row for row in some if row[3]]


def test_a_folder_written_into_may_not_overwrite_what_is_read(here, capsys):
    """`--out` writes files of fixed names; one of them may be an input under that name."""
    os.rename("motions.npz", "report.json")
    before = (here / "report.json").read_bytes()
    with protected(["report.json"]):
        with pytest.raises(OutputError, match="report.json: found an input"):
            with atomic_write("report.json") as file:
                file.write("x")
    assert (here / "report.json").read_bytes() == before


def test_a_folder_that_cannot_be_one_is_refused_before_any_work(made):
    for name in ("c.bvh", "known"):
        (made / name).write_bytes((made / "clips" / "walk_normal_1.bvh").read_bytes())
    told = targets.campaign(made, ["demo", "export", "experiment torresani", "styles", "evaluate"],
                            ())
    assert len(told) > 16 and not [row for row in told if row[3]], told


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_folder_that_may_not_be_written_to_is_refused_before_any_work(tmp_path, capsys):
    tmp_path.chmod(0o555)
    for words in ("demo --out {}/new", "experiment torresani --out {}", "export {}/a/b"):
        assert main(words.format(tmp_path).split()) == 2
        out, err = capsys.readouterr()
        assert not out and err.count("\n") == 1 and str(tmp_path) in err


def test_links_are_followed_and_stay(here):
    (here / "target.txt").write_text("data")
    for link, target in (("link.bvh", "target.txt"), ("dangling.bvh", "not there yet.txt")):
        os.symlink(target, link)
        assert main(["transfer", "old.npz", "c.bvh", "-o", link]) == 0
        assert os.path.islink(link) and (here / target).read_text().startswith("HIERARCHY")


def test_pipes_and_devices_are_written_to(here):
    os.mkfifo("pipe")
    read = []
    reader = threading.Thread(target=lambda: read.append((here / "pipe").read_text()))
    reader.start()
    assert main(["transfer", "old.npz", "c.bvh", "-o", "pipe"]) == 0
    reader.join()
    assert read[0].startswith("HIERARCHY") and not os.path.isfile("pipe")
    assert main(["transfer", "old.npz", "c.bvh", "-o", "/dev/null", "--plot", "/dev/null"]) == 0
    assert not os.path.isfile("/dev/null")
    done = subprocess.run([sys.executable, "-m", "refimpl", "inspect", "c.bvh", "--json",
                           "/dev/stdout"], capture_output=True, text=True)
    assert done.returncode == 0 and '"command": "inspect"' in done.stdout
    # the shell's > must not be pulled away from under it
    with open("kept.txt", "w") as out:
        subprocess.run([sys.executable, "-m", "refimpl", "inspect", "c.bvh", "--json",
                        "/dev/stdout"], stdout=out, check=True)
    assert "21 joints" in (here / "kept.txt").read_text()


def test_a_full_disk_is_one_line_with_the_files_name(here, capsys):
    assert main(["transfer", "old.npz", "c.bvh", "-o", "/dev/full"]) == 2
    assert capsys.readouterr().err == "refimpl: error: /dev/full: No space left on device\n"


def test_a_file_that_may_only_be_read_is_not_replaced(tmp_path):
    path = tmp_path / "a"
    path.write_text("data")
    path.chmod(0o444)
    with pytest.raises(PermissionError, match="may only be read"):
        with atomic_write(path) as file:
            file.write("x")
    assert path.read_text() == "data"


def test_what_check_outputs_compares(tmp_path):
    (tmp_path / "in").write_text("x")
    os.symlink(tmp_path, tmp_path / "same folder")
    for outputs in ({"-o": tmp_path / "in"}, {"-o": tmp_path / "same folder" / "in"},
                    {"-o": tmp_path / "new", "--plot": tmp_path / "same folder" / "new"}):
        with pytest.raises(OutputError):
            check_outputs(outputs, {"CLIP": tmp_path / "in"})
    check_outputs({"-o": "/dev/null", "--plot": "/dev/null"}, {"CLIP": "/dev/null"})
    with pytest.raises(IsADirectoryError):
        check_outputs({"-o": tmp_path}, {})
    with pytest.raises(FileNotFoundError):
        check_outputs({"-o": tmp_path / "no" / "file"}, {})


# Checkpoints.

def train(*more, epochs=3):
    return main(["train-autoencoder", "motions.npz", "-o", "a.npz", "--hidden", "6", "--width", "9",
                 "--epochs", str(epochs), *more])


def stop_after(monkeypatch, epochs):
    """Ctrl-C once so many checkpoints were written."""
    from refimpl.commands import train as command
    save, count = checkpoint.save_checkpoint, [0]

    def saving(*arguments):
        save(*arguments)
        count[0] += 1
        if count[0] == epochs:
            raise KeyboardInterrupt
    monkeypatch.setattr(command, "save_checkpoint", saving)


def test_a_checkpoint_is_set_aside_not_lost(here, monkeypatch, capsys):
    (here / "a.npz.checkpoint").write_text("somebody's")
    stop_after(monkeypatch, 2)
    assert train() == 130
    assert ("kept as a.npz.checkpoint.1" in capsys.readouterr().out
            and (here / "a.npz.checkpoint.1").read_text() == "somebody's")
    first = (here / "a.npz.checkpoint").read_bytes()
    monkeypatch.undo()
    monkeypatch.chdir(here)
    assert train() == 0
    assert (here / "a.npz.checkpoint.2").read_bytes() == first
    assert checkpoint.set_aside("not there") is None


def test_a_resume_on_another_processor_goes_on_and_says_so(here, monkeypatch, capsys):
    stop_after(monkeypatch, 2)
    assert train() == 130
    monkeypatch.undo()
    monkeypatch.chdir(here)
    from refimpl.commands import train as command
    exact = command.clean_windows
    monkeypatch.setattr(command, "clean_windows", lambda *a,
                        **k: (exact(*a, **k)[0] * np.float32(1 + 2e-7), exact(*a, **k)[1]))
    assert train("--resume") == 0
    assert "differ from today's in their last digits" in capsys.readouterr().out
    assert (here / "a.npz").exists() and not (here / "a.npz.checkpoint").exists()


def test_a_checkpoint_of_other_settings_or_data_is_refused_and_kept(here, monkeypatch, capsys):
    stop_after(monkeypatch, 2)
    assert train() == 130
    monkeypatch.undo()
    monkeypatch.chdir(here)
    kept = (here / "a.npz.checkpoint").read_bytes()
    assert train("--resume", epochs=4) == 2 and train("--resume", "--seed", "1") == 2
    from refimpl.commands import train as command
    exact = command.clean_windows
    monkeypatch.setattr(command, "clean_windows", lambda *a,
                        **k: (exact(*a, **k)[0] * 1.01, exact(*a, **k)[1]))
    assert train("--resume") == 2
    assert ("other settings or other data" in capsys.readouterr().err
            and (here / "a.npz.checkpoint").read_bytes() == kept)


@pytest.mark.parametrize("change",
                         [{"epoch": 10 ** 6}, {"epoch": -1}, {"steps": 10 ** 400}, {"steps": -5},
                          {"names": []}, {"names": ["W0"]}, {"records": "5"},
                                    {"records": "[1]"}, {"records": "[{}]"},
                          {"records": "[" * 10_000}, {"records": "no"}], ids=str)
def test_tampered_checkpoints_are_refused_in_one_line(change, here, monkeypatch, capsys):
    stop_after(monkeypatch, 2)
    assert train() == 130
    from refimpl.storage import load_npz
    arrays, facts = load_npz("a.npz.checkpoint", "checkpoint", checkpoint.VERSION, ())
    save_npz("a.npz.checkpoint", "checkpoint", checkpoint.VERSION, arrays, {**facts, **change})
    capsys.readouterr()
    assert train("--resume") == 2
    err = capsys.readouterr().err
    assert "a.npz.checkpoint: found" in err and err.count("\n") == 1


@pytest.mark.parametrize("damage", ["missing", "shape", "nan", "letters"])
def test_checkpoints_with_damaged_arrays_are_refused(damage, here, monkeypatch, capsys):
    stop_after(monkeypatch, 2)
    assert train() == 130
    from refimpl.storage import load_npz
    arrays, facts = load_npz("a.npz.checkpoint", "checkpoint", checkpoint.VERSION, ())
    if damage == "missing":
        del arrays["m W0"]
    else:
        arrays["m W0"] = {"shape": arrays["m W0"][:1], "nan": arrays["m W0"] * np.nan,
                          "letters": np.array("abc")}[damage]
    save_npz("a.npz.checkpoint", "checkpoint", checkpoint.VERSION, arrays, facts)
    assert train("--resume") == 2
    assert "a.npz.checkpoint: found" in capsys.readouterr().err


# Signals, readers that leave, letters that a terminal should not get.

def test_sigterm_leaves_nothing_half_written(here):
    training = OnTerminal(["train-autoencoder", "motions.npz", "-o", "b.npz", "--epochs", "100000",
                           "--hidden", "6"])
    assert training.until("epoch 1/")                            # the first epoch is done
    training.process.send_signal(signal.SIGTERM)
    assert (training.end() == 143 and "Traceback" not in training.text
            and training.seen()[-1].startswith("refimpl: told to end"))
    assert not list(here.glob(".*.part")) and (here / "b.npz.checkpoint").exists()


def test_a_reader_that_leaves_is_no_failure(here):
    command = f"set -o pipefail; {sys.executable} -m refimpl inspect c.bvh | true"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == ""


def test_an_output_that_is_closed_is_no_failure(here):
    for command in (["inspect", "c.bvh"], ["check", "refimpl.nn", "--operations", "gram",
                                           "--profile", "small"]):
        done = subprocess.run(["sh", "-c", '"$@" >&-', "sh", sys.executable, "-m", "refimpl",
                               *command], capture_output=True, text=True)
        assert done.returncode == 0 and done.stderr == ""


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="needs a place where nobody may write")
def test_what_cannot_be_written_is_called_by_its_name():
    with pytest.raises(OSError, match=r"x\.json"):
        check_outputs({"--json": "/proc/x.json"}, {})


def test_control_characters_do_not_reach_the_terminal(here, capsys):
    clip = (here / "c.bvh").read_text().replace("JOINT Spine", "JOINT \x1b[2JSpine")
    (here / "evil.bvh").write_text(clip)
    main(["inspect", "evil.bvh"])
    said = capsys.readouterr()
    assert "\x1b" not in said.out + said.err and "\\x1b[2JSpine" in said.out


def test_letters_that_the_terminal_lacks_are_no_failure(here):
    (here / "müde.bvh").write_bytes((here / "c.bvh").read_bytes())
    done = subprocess.run([sys.executable, "-m", "refimpl", "inspect", "müde.bvh"],
                          capture_output=True, env={**os.environ, "PYTHONIOENCODING": "ascii"})
    assert done.returncode == 0 and b"m\\xfcde.bvh" in done.stdout


# What programs read.

def test_version_inspect_and_transfer_for_programs(here, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["--version"])
    assert stopped.value.code == 0 and capsys.readouterr().out.count("\n") == 1
    assert main(["inspect", "c.bvh", "--json", "i.json", "--write-mapping", "m.csv"]) == 0
    told = json.loads((here / "i.json").read_text())
    assert (told["command"] == "inspect" and len(told["rows"]) == 21
            and {"slot", "joint"} <= set(told["rows"][0]))
    assert (told["frames"] == 246 and told["fps"] == pytest.approx(60) and told["up"] == "y"
            and told["unit"] == "centimetres" and 100 < told["height"] < 200)
    assert main(["inspect", "c.bvh", "--mapping", "m.csv"]) == 0   # what was written can be read
    assert main(["transfer", "old.npz", "c.bvh", "-o", "o.bvh", "--json", "t.json"]) == 0
    told = json.loads((here / "t.json").read_text())
    assert (told["command"] == "transfer" and told["rows"][0]["result"] == "o.bvh"
            and told["rows"][0]["mean path error"] >= 0)
    with pytest.raises(SystemExit, match="2"):
        main(["transfer", "old.npz", "c.bvh", "-o", "o.txt"])
    assert not (here / "o.txt").exists()


@pytest.mark.parametrize("error, words",
                         [(TypeError("no"), "could not go on (TypeError: no)"),
                          (ZeroDivisionError("division by zero"),
                           "numbers that cannot be computed"),
                                          (MemoryError(), "not enough memory"),
                          (KeyError("x"), "could not go on (KeyError")])
def test_what_nobody_foresaw_is_one_line_with_the_file(error, words, here, monkeypatch, capsys):
    from refimpl.commands import inspect

    def fails(path, *more, **how):
        raise error
    monkeypatch.setattr(inspect, "read_clip", fails)
    assert main(["inspect", "c.bvh"]) == 2
    err = capsys.readouterr().err
    assert err.startswith("refimpl: error: c.bvh: ") and words in err and err.count("\n") == 1


def test_the_path_that_is_told_is_the_one_that_was_written(here, capsys):
    """A root with two position channels cannot carry a path; the network's was told, 96 cm off, and
    nothing of it written.
    """
    clip = bvh.read_bvh("c.bvh")
    from dataclasses import replace
    root = clip.joints[0]
    assert root.channels[:3] == ("Xposition", "Yposition", "Zposition")
    flat = replace(clip, joints=(replace(root, channels=("Xposition", *root.channels[2:])),
                                 *clip.joints[1:]), values=np.delete(clip.values, 1, axis=1))
    bvh.write_bvh("flat.bvh", flat)
    assert main(["transfer", "old.npz", "flat.bvh", "-o", "o.bvh", "--json", "o.json"]) == 0
    assert "no joint with three position channels" in capsys.readouterr().out
    told = json.loads((here / "o.json").read_text())["rows"][0]
    a, b = bvh.read_bvh("flat.bvh").values[:, :2], bvh.read_bvh("o.bvh").values[:, :2]
    assert np.abs(a - b).max() < 1e-6 and told["mean path error"] < 1e-6


def test_an_error_in_one_of_many_clips_names_it(here, capsys):
    text = (here / "clips" / "walk_old_1.bvh").read_text()
    (here / "clips" / "walk_old_1.bvh").write_text(
        text.replace("Frame Time:", "Frame Time: 0.0000001 ")
        .replace("0.0000001 \t0.016666666666666666", "0.0000001"))
    assert main(["prepare", "clips", "-o", "n.npz"]) == 2
    assert "walk_old_1.bvh" in capsys.readouterr().err
