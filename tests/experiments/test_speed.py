"""The benchmark measures what it says: rivals agree with each other, medians are medians, and
without PyTorch it says so.
"""

import json
import os
import time

import numpy as np
import pytest

from refimpl.experiments import speed as bench
from refimpl.blas import prefer
from refimpl.cli import main


def test_interleaved_medians_tell_fast_from_slow():
    times = bench.interleaved({"slow": lambda: time.sleep(0.004),
                               "fast": lambda: time.sleep(0.001)}, seconds=0.05)
    assert 0.004 <= times["slow"] < 0.02 and 0.001 <= times["fast"] < times["slow"]


def test_the_rivals_of_one_line_compute_the_same(monkeypatch):
    torch_side = pytest.importorskip("refimpl.experiments.peer_torch",
                                     reason="optional: pip install torch==2.13.0")
    # the same functions again, after a minute
    monkeypatch.setattr(torch_side, "_compiled", lambda use, function: {})
    problem = bench.Problem(np.float64)
    X, I, grams = problem.motion(1, 60), problem.motion(2, 60), problem.grams(2)
    stylised = bench.Stylist(problem.T, problem.L).stylise(X)
    for name, work in torch_side.inference(problem, X).items():
        np.testing.assert_allclose(np.squeeze(work().numpy()), stylised[0], atol=1e-9, err_msg=name)
    step = bench.StyleStep(2, 60, problem.T, problem.L, np.zeros(66), np.ones(66), bench.Weights(),
                           bench.PERCEPTUAL)
    _, gradients = step(problem.T, bench.Batch(I, grams, None, None, None))
    calls = torch_side.style_step(problem, I, grams, bench.Weights())
    # the tensors whose gradients the call fills
    params = calls["torch eager"].__closure__
    calls["torch eager"]()
    tensors = next(cell.cell_contents for cell in params if isinstance(cell.cell_contents, dict))
    for name, tensor in tensors.items():
        np.testing.assert_allclose(tensor.grad.numpy(), gradients[name],
                                   atol=1e-9 * np.abs(gradients[name]).max())


def test_a_line_without_a_peer_has_no_ratio():
    row = bench.inference(bench.Problem(np.float32), None, 0.01, frames=(50,))[0]
    assert (row["ratio"] is None and row["best peer"] is None
            and set(row["seconds"]) == {"tiled", "direct"})
    assert 0 < row["relative error"] < 2e-6


def test_the_command_writes_what_it_prints(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(bench, "FRAMES", (40,))
    monkeypatch.setattr(bench.inference, "__defaults__", ((40,),))
    monkeypatch.setattr(bench.style_steps, "__defaults__", ((1,),))
    monkeypatch.setattr(bench.autoencoder_steps, "__defaults__", (1,))
    monkeypatch.setattr(bench.all_five, "__defaults__", (1,))
    monkeypatch.setattr(bench.scaling, "__defaults__", ((60,), (1, 2)))
    assert main(["bench", "--no-peer", "--seconds", "0.01", "--json",
                 str(tmp_path / "bench.json")]) == 0
    printed = capsys.readouterr().out
    assert ("PyTorch was not measured: not asked for" in printed and "GFLOP/s" in printed
            and "stylise + project, 40 frames" in printed)
    written = json.loads((tmp_path / "bench.json").read_text())
    assert (len(written["rows"]) == 12
            and all(row["seconds"]["tiled"] > 0 for row in written["rows"]))


def test_blas_is_told_what_nobody_has_told_it():
    told = {"OPENBLAS_NUM_THREADS": "3"}
    prefer(told)
    assert told == {"OPENBLAS_NUM_THREADS": "3", "MKL_NUM_THREADS": "1"}
    prefer(os.environ)
