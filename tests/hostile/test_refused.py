"""Inputs written from README and --help alone that were once taken without a word."""

import io

import numpy as np
import pytest

from refimpl.cli import main
from refimpl.holden2017.train import TrainingError, run_epoch, start_state
from refimpl.motion.points import PointsError, read_points
from refimpl.motion.joints import MappingError
from refimpl.motion.tables import read_table


@pytest.mark.parametrize("change", [
    lambda data: data + b"123", lambda data: data[:-8],
    lambda data: data.replace(b"(9, 21, 3)", b"(9000000000, 21, 3)", 1)])
def test_points_longer_or_shorter_than_they_claim(change, tmp_path):
    file = io.BytesIO()
    np.save(file, np.random.default_rng(0).normal(size=(9, 21, 3)))
    (tmp_path / "p.npy").write_bytes(change(file.getvalue()))
    with pytest.raises(PointsError, match="no array of numbers"):
        read_points(tmp_path / "p.npy")


def test_weights_that_the_last_step_blew_up():
    state = start_state({"W": np.ones((2, 2), np.float32)})
    with pytest.raises(TrainingError, match="W not finite or beyond 1e9"):
        run_epoch(state, 1, np.arange(4), 4, lambda params, _: ({"loss": 1.0}, params), 1e30)


def test_a_line_break_in_a_cell(tmp_path):
    (tmp_path / "t.csv").write_text('slot,joint\n"Head","Ne\nck"\n')
    with pytest.raises(MappingError, match="a quotation mark left open"):
        read_table(tmp_path / "t.csv", "lines slot,joint", MappingError)


@pytest.mark.parametrize("text, said", [
    ("content,style,result,result\na,b,c,d\n", "two columns result"),
    ("content,style,result\na,b,c,d\n", ":2: found more cells")])
def test_a_table_of_results_with_a_value_under_no_word(text, said, tmp_path, capsys):
    (tmp_path / "t.csv").write_text(text)
    assert main(["score", str(tmp_path / "t.csv")]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("option, value", [("--fps", "1e9"), ("--strength", "1e300")])
def test_options_beyond_all_measure(option, value, capsys):
    with pytest.raises(SystemExit) as stop:
        main(["transfer", "old", "c.bvh", "-o", "o.bvh", option, value])
    assert stop.value.code == 2 and "up to" in capsys.readouterr().err
