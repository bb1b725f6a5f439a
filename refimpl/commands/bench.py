"""`refimpl bench`: how fast, side by side with PyTorch and ONNX Runtime where they are installed;
ratios of medians of one run, with the same number of threads on both sides.
"""

import argparse
import importlib
import importlib.util
import os
import platform
from typing import Any

import numpy as np

from ..experiments import speed
from .options import OutputPath, number, whole, write_report
from .progress import Progress, table

PEERS = {"peer_torch": ("torch",), "peer_onnx": ("onnx", "onnxruntime")}
WORKS = (speed.inference, speed.style_steps, speed.autoencoder_steps, speed.all_five,
         speed.convolutions)


def add_commands(commands: Any) -> None:
    """Add `refimpl bench` to the subparsers of the command line."""
    command = commands.add_parser("bench", description=__doc__)
    command.add_argument("--threads", type=whole(1, 256), default=1, metavar="N",
                         help="of both sides; each side's own default is measured as well "
                              "(default: %(default)s)")
    command.add_argument("--json", metavar="FILE", type=OutputPath, help="write every number")
    command.add_argument("--seconds", type=number(above=0), default=1.0, metavar="S",
                         help="for each rival of each line (default: %(default)s)")
    command.add_argument("--no-peer", action="store_true", help="measure this package alone")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Measure, print a table and write every number if that is asked for."""
    peers = [] if arguments.no_peer else [
        importlib.import_module(f"refimpl.experiments.{name}") for name, needed in PEERS.items()
        if all(map(importlib.util.find_spec, needed))]
    machine = {"processor": _processor(), "instructions": _instructions(), "cores": os.cpu_count(),
               "numpy": np.__version__, "peers": [peer.VERSION for peer in peers],
               "seconds": arguments.seconds, "threads": arguments.threads, "seed": 0}
    print(", ".join(f"{key} {value}" for key, value in machine.items() if value))
    if not peers:
        why = "not asked for" if arguments.no_peer else "none is installed (pip install torch)"
        print(f"no peer was measured: {why}")
    rates = {(dtype, threads): speed.gemm_rate(dtype, threads)
             for dtype in ("float32", "float64") for threads in {1, 2, arguments.threads}}
    asked = sorted({1, arguments.threads})
    settings: list[int | None] = [*asked, None]
    rows, progress = [], Progress(2 * 10 * len(settings), "line")
    for dtype in ("float32", "float64"):
        problem = speed.Problem(dtype)
        for work in (line for make in WORKS for line in make(problem, peers)):
            for threads in settings:
                rate = rates[dtype, threads or work.default]
                rows.append(speed.timed(work, dtype, threads, arguments.seconds, rate, peers))
                progress.step(f"{work.name}, {dtype}")
    print("\n".join(["", *table(_lines(rows)), ""]))
    print("a large matrix product on one thread: " + ", ".join(
        f"{dtype} {rate / 1e9:.0f} GFLOP/s" for (dtype, n), rate in rates.items() if n == 1))
    peak = speed.peak_bytes(speed.Problem("float32"), 15360)
    print(f"15,360 frames of stylise + project: {peak / 2 ** 20:.0f} MiB at most")
    if arguments.json:
        write_report(arguments.json, "bench", machine, rows, peak_bytes_15360_frames=peak,
                     gemm={f"{dtype}, {n} threads": rate for (dtype, n), rate in rates.items()})


def _lines(rows):
    lines = [["work", "precision", "threads", "here", "direct", "peer", "its form", "ratio",
              "of the limit", "error"]]
    for row in rows:
        times = (row["seconds"], row["direct seconds"], row["peer seconds"])
        cells = ["-" if s is None else f"{1e3 * s:.2f} ms" for s in times]
        lines.append([row["work"], row["dtype"], str(row["threads"]), *cells, row["peer"] or "-",
                      "-" if row["ratio"] is None else f"{row['ratio']:.2f}",
                      f"{100 * row['share of the limit']:.0f} %",
                      "-" if row["relative error"] is None else f"{row['relative error']:.1e}"])
    return lines


def _cpuinfo(key):
    try:
        with open("/proc/cpuinfo", errors="replace") as file:
            found = (line.split(":", 1)[1].strip() for line in file if line.startswith(key))
            return next(found, "")
    except OSError:
        return ""


def _processor():
    return _cpuinfo("model name") or platform.processor() or platform.machine()


def _instructions():
    """What the processor offers, and what NumPy's products are held to."""
    held = os.environ.get("OPENBLAS_CORETYPE")
    flags = _cpuinfo("flags").split()
    best = next((name for name in ("avx512f", "avx2", "sse4_2") if name in flags), "unknown")
    return best + (f", OpenBLAS held to {held}" if held else "")
