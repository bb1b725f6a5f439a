"""`refimpl bench`: how fast, side by side with PyTorch where it is installed; ratios of medians,
one thread each.
"""

import argparse
from collections.abc import Callable
import importlib.util
import os
import platform
from typing import Any

import numpy as np

from ..experiments import speed as bench
from .options import OutputPath, number, write_json
from .progress import table


def add_commands(commands: Any) -> None:
    """Add `refimpl bench` to the subparsers of the command line."""
    command = commands.add_parser("bench", help="measure speed against PyTorch",
                                  description=__doc__)
    command.add_argument("--json", metavar="FILE", type=OutputPath, help="write every number")
    command.add_argument("--seconds", type=number(above=0), default=1.0, metavar="S",
                         help="for each rival of each line (default: %(default)s)")
    command.add_argument("--no-peer", action="store_true", help="measure this package alone")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> None:
    """Measure, print a table and write every number if that is asked for."""
    peer, version = (None, None) if arguments.no_peer else _peer()
    machine = {"processor": _processor(), "cores": os.cpu_count(), "numpy": np.__version__,
               "torch": version,
               "BLAS kernels": os.environ.get("OPENBLAS_CORETYPE", "as BLAS chooses")}
    print(", ".join(f"{key} {value}" for key, value in machine.items() if value))
    if peer is None:
        why = "not asked for" if arguments.no_peer else "it is not installed (pip install torch)"
        print(f"PyTorch was not measured: {why}")
    rivalled: list[Callable] = [bench.inference, bench.style_steps, bench.autoencoder_steps]
    rows = []
    for dtype in (np.float32, np.float64):
        problem = bench.Problem(dtype)
        for part in rivalled:
            rows += _told(part(problem, peer, arguments.seconds))
        for alone in (bench.all_five, bench.convolutions):
            rows += _told(alone(problem, arguments.seconds))
    print()
    print("\n".join(table(_lines(rows))))
    problem = bench.Problem(np.float32)
    scaling = bench.scaling(problem)
    rates = {name: bench.gemm_rate(name) for name in ("float32", "float64")}
    print("\nstylise + project in float32, by frames: microseconds a frame with 1 and 2 threads, "
          "memory at most")
    by_frames = [["frames", "1 thread", "2 threads", "memory"]]
    for row in scaling:
        times = row["seconds by threads"].values()
        by_frames.append([f"{row['frames']:,}", *(f"{1e6 * t / row['frames']:.2f}" for t in times),
                          f"{row['peak bytes'] / 2 ** 20:.0f} MiB"])
    print("\n".join(table(by_frames)))
    shares = {row["work"]: bench.direct_operations(int(row["work"].split()[-2]))
              / row["seconds"]["tiled"] / rates["float32"] for row in rows
              if row["dtype"] == "float32" and row["work"].startswith("stylise")}
    print("\na large matrix product: " + ", ".join(f"{name} {rate / 1e9:.0f} GFLOP/s"
                                                   for name, rate in rates.items()))
    for work, share in shares.items():
        print(f"{work}: what the direct convolution would count, at {share:.1f} times that rate")
    if arguments.json:
        write_json(arguments.json, {"machine": machine, "rows": rows, "scaling": scaling,
                                    "gemm": rates, "share of gemm, counted directly": shares})


def _peer():
    """The PyTorch side and its version, or None twice."""
    if importlib.util.find_spec("torch") is None:
        return None, None
    from ..experiments import peer_torch
    return peer_torch, peer_torch.torch.__version__


def _told(rows):
    for row in rows:
        print(f"measured: {row['work']} {row['dtype']}", flush=True)
    return rows


def _lines(rows):
    lines = [["work", "precision", "here", "direct", "PyTorch", "its form", "ratio", "error"]]
    for row in rows:
        best, error = row["best peer"], row["relative error"]
        times = (row["seconds"].get(rival) for rival in ("tiled", "direct", best))
        lines.append([row["work"], row["dtype"],
                      *("-" if seconds is None else f"{1e3 * seconds:.2f} ms" for seconds in times),
                      best.removeprefix("torch ") if best else "-",
                      "-" if best is None else f"{row['ratio']:.2f}",
                      "-" if error is None else f"{error:.1e}"])
    return lines


def _processor():
    try:
        with open("/proc/cpuinfo", errors="replace") as file:
            names = [line.split(":", 1)[1] for line in file if line.startswith("model name")]
    except OSError:
        names = []
    return names[0].strip() if names else platform.processor() or platform.machine()
