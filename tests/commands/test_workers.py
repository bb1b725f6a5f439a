"""Commands in several processes: the same bits, and no worker that outlives its command."""

import json
import os
import re
import signal
import subprocess
import sys
import time

import pytest

from refimpl.cli import main
from refimpl.commands.workers import each, workers
from refimpl.storage import OutputError, atomic_write, protected
from tests.commands.terminals import HERE
from tests.hostile import targets


def _scaled(task, factor, more):
    return task * factor + more, os.getpid()


def _overwrite(task):
    with atomic_write(task, "w") as file:
        file.write("new")


def test_tasks_keep_their_order_and_are_given_the_constants():
    alone, together = (list(each(count, _scaled, range(9), 3, 1)) for count in (1, 2))
    assert [x for x, _ in alone] == [x for x, _ in together] == [1 + 3 * n for n in range(9)]
    assert {pid for _, pid in alone} == {os.getpid()} and os.getpid() not in dict(together).values()


def test_what_a_command_reads_is_protected_in_its_workers_too(tmp_path):
    (tmp_path / "read").write_text("old")
    for count in (1, 2):
        with protected([tmp_path / "read"]), pytest.raises(OutputError):
            list(each(count, _overwrite, [tmp_path / "read"]))
    assert (tmp_path / "read").read_text() == "old"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    out = tmp_path_factory.mktemp("workers")
    targets.made(out)
    return out


def without_clocks(folder):
    """What a command left, without the times that it took."""
    clock = re.compile(r'"(seconds(, low|, high)?|frames/s|2016, own form|2017|ratio)": [\d.e+-]+')
    return {p.name: clock.sub("", p.read_text()) if p.suffix == ".json" else p.read_bytes()
            for p in sorted(folder.iterdir())}


def test_evaluate_in_two_processes_gives_the_same_bits(made, monkeypatch):
    monkeypatch.chdir(made)
    for count in ("1", "2"):
        assert main(f"evaluate clips motions.npz old.npz --out out{count} --processes {count}"
                    .split()) == 0
    one, two = (without_clocks(made / f"out{count}") for count in ("1", "2"))
    assert one.keys() == two.keys() and len(one) > 4
    assert [name for name in one if one[name] != two[name]] == []


def test_bodies_in_two_processes_give_the_same_rows(made, monkeypatch):
    monkeypatch.chdir(made)
    for count in ("1", "2"):
        assert main(f"experiment bodies old.npz --most 2 --json b{count}.json --processes {count}"
                    .split()) == 0
    one, two = (json.loads((made / f"b{count}.json").read_text())["rows"] for count in ("1", "2"))
    assert json.dumps(one) == json.dumps(two) and len({row["clip"] for row in one}) == 2


@pytest.mark.skipif(not os.path.isdir("/proc"), reason="needs /proc")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_workers_end_with_their_command(made, number):
    run = subprocess.Popen([sys.executable, "-m", "refimpl", *"evaluate clips motions.npz old.npz "
                            "--out killed --processes 2".split()], cwd=made, env=HERE,
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while run.poll() is None and not children(run.pid):
        time.sleep(0.02)
    there = children(run.pid)
    assert there
    run.send_signal(number)
    run.wait()
    while any(map(alive, there)):                    # hangs where one outlives its parent
        time.sleep(0.02)
    assert not list(made.rglob("*.part")) or number == signal.SIGKILL


def children(pid):
    try:
        with open(f"/proc/{pid}/task/{pid}/children") as file:
            return [int(word) for word in file.read().split()]
    except OSError:
        return []


def alive(pid):
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def test_no_workers_for_one_process():
    with workers(1) as executor:
        assert executor is None
