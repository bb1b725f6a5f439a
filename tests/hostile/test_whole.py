"""Whole commands on altered walkers hold, and planted faults are found: a few cases of `whole`."""

import pytest

from tests.hostile import whole


def test_the_second_reader_reads_what_it_writes():
    import numpy as np

    from tests.hostile.strangers import read, walker, world, write
    clip = walker(np.random.default_rng(0), 0.5, 30)
    again = read(write(clip))
    assert again.names == clip.names and again.step == clip.step
    assert np.abs(world(again)[1] - world(clip)[1]).max() < 1e-7


def test_a_few_cases_hold(tmp_path, capsys):
    words = ["16", str(tmp_path), "--seed", "5", "--only", "inspect", "observe", "transfer"]
    assert whole.run_all(words) == 0, capsys.readouterr().out


@pytest.mark.parametrize("plant", ["late", "mirrored", "unscaled", "rate"])
def test_a_planted_fault_is_found(plant, tmp_path, capsys):
    words = ["1", str(tmp_path), "--seed", "5", "--only", "transfer", "--case", "0"]
    words[-1] = "2" if plant == "rate" else "0"
    assert whole.run_all(words) == 0
    assert whole.run_all([*words, "--plant", plant]) == 1
    assert "broken" in capsys.readouterr().out


@pytest.mark.parametrize("plant", ["torn", "silent"])
def test_a_planted_fault_of_refusals_is_found(plant, tmp_path):
    words = ["1", str(tmp_path), "--seed", "5", "--only", "transfer", "--case", "6"]
    assert whole.run_all(words) == 0
    assert whole.run_all([*words, "--plant", plant]) == 1
