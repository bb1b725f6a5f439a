"""The benchmark measures what it says: rivals agree with each other, medians are medians, and
without PyTorch it says so.
"""

import json
import os
from pathlib import Path
import shutil
import subprocess
import sys
import time

import numpy as np
import pytest

from refimpl.experiments import speed as bench
from refimpl.blas import prefer
from refimpl.cli import main

DOCS = Path(__file__).parents[2] / "docs"


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
    step = bench.style_gradients(problem.L, np.zeros(66), np.ones(66), bench.Weights(),
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


def test_onnx_runtime_computes_the_same():
    for name in ("onnx", "onnxruntime"):
        pytest.importorskip(name, reason="optional: pip install onnx onnxruntime")
    from refimpl.experiments import peer_onnx
    problem = bench.Problem(np.float32)
    X = problem.motion(1, 60)
    peer_onnx.use_threads(1)
    found = peer_onnx.inference(problem, X)["onnxruntime"]()
    np.testing.assert_allclose(found, bench.Stylist(problem.T, problem.L).stylise(X), atol=2e-4)
    assert peer_onnx.inference(bench.Problem(np.float64), X) == {}


def test_a_line_without_a_peer_has_no_ratio():
    work, = bench.inference(bench.Problem(np.float32), [], frames=(50,))
    row = bench.timed(work, np.float32, 1, 0.01, 1e9)
    assert row["ratio"] is row["peer"] is row["peer seconds"] is None
    assert row["seconds"] > 0 and row["direct seconds"] > 0
    assert 0 < row["relative error"] < 2e-6


def test_a_peer_is_told_its_threads_and_the_fastest_form_counts():
    class Peer:
        told = []

        @staticmethod
        def use_threads(threads):
            Peer.told.append(threads)

        @staticmethod
        def inference(problem, X):
            return {"slow form": lambda: time.sleep(0.05), "fast form": lambda: time.sleep(0.02)}

    work, = bench.inference(bench.Problem(np.float32), [Peer], frames=(50,))
    rows = [bench.timed(work, np.float32, threads, 0.01, 1e9, [Peer]) for threads in (2, None)]
    assert Peer.told == [2, None] and all(row["peer"] == "fast form" for row in rows)
    assert all(row["ratio"] == row["seconds"] / row["peer seconds"] for row in rows)
    assert rows[0]["threads"] == 2 and "default" in rows[1]["threads"]


def test_products_are_counted_and_numpy_is_left_as_it_was():
    real = np.matmul
    problem = bench.Problem(np.float32)
    works = {work.name: bench.products(work.ours(1))
             for work in bench.inference(problem, [], frames=(240, 480))}
    assert np.matmul is real
    direct = 2 * 240 * 25 * (66 * 128 + 128 * 128 + 128 * 66 + 2 * 66 * 256)
    assert 0.1 * direct < works["stylise + project, 240 frames"] < 0.5 * direct
    assert 1.5 < (works["stylise + project, 480 frames"]
                  / works["stylise + project, 240 frames"]) < 2.1
    with pytest.raises(ZeroDivisionError):
        bench.products(lambda: 1 / 0)
    assert np.matmul is real


def test_the_command_writes_what_it_prints(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(bench.inference, "__defaults__", ((40,),))
    monkeypatch.setattr(bench.style_steps, "__defaults__", ((2,),))
    monkeypatch.setattr(bench.autoencoder_steps, "__defaults__", (2,))
    monkeypatch.setattr(bench.all_five, "__defaults__", (2,))
    assert main(["bench", "--no-peer", "--threads", "2", "--seconds", "0.01", "--json",
                 str(tmp_path / "bench.json")]) == 0
    printed = capsys.readouterr().out
    assert ("no peer was measured: not asked for" in printed and "GFLOP/s" in printed
            and "stylise + project, 40 frames" in printed)
    written = json.loads((tmp_path / "bench.json").read_text())
    assert written["command"] == "bench" and written["settings"]["threads"] == 2
    assert len(written["rows"]) == 2 * 6 * 3
    assert {row["threads"] for row in written["rows"]} >= {1, 2}
    assert all(row["seconds"] > 0 and row["share of the limit"] >= 0 for row in written["rows"])


def test_blas_is_told_what_nobody_has_told_it():
    told = {"OPENBLAS_NUM_THREADS": "3"}
    prefer(told)
    assert told == {"OPENBLAS_NUM_THREADS": "3", "MKL_NUM_THREADS": "1"}
    prefer(os.environ)


def test_the_page_shows_the_stored_numbers_and_a_run_would_be_stored_so(tmp_path):
    docs = tmp_path / "docs"
    docs.mkdir()
    for name in ("speed.py", "speed.md", "speed.json"):
        shutil.copy(DOCS / name, docs)

    def _run(*words):
        return subprocess.run([sys.executable, docs / "speed.py", *words], capture_output=True,
                              text=True)
    assert _run("--check").stdout == "nothing differs\n"
    stored = json.loads((DOCS / "speed.json").read_text())["runs"]
    for name, run in stored.items():                             # as `bench` writes them
        report = {"settings": run["settings"], "rows": run["rows"],
                  "gemm": run["large product, operations a second"],
                  "peak_bytes_15360_frames": run["peak bytes, 15,360 frames"]}
        (tmp_path / name).write_text(json.dumps(report))
    assert _run(*(tmp_path / name for name in stored)).returncode == 0
    for name in ("speed.md", "speed.json"):
        assert (docs / name).read_text() == (DOCS / name).read_text()
    other = (docs / "speed.json").read_text().replace('"seconds": 0.00', '"seconds": 0.01')
    (docs / "speed.json").write_text(other)
    assert _run("--check").returncode == 1
