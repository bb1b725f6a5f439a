"""`refimpl bench`: how fast, side by side with PyTorch where it is installed; ratios of medians,
one thread each.
"""

import importlib.util
import json
import os
import platform

import numpy as np

from ..experiments import speed as bench
from ..storage import atomic_write
from .options import OutputPath, number
from .progress import table


def add_commands(commands):
    command = commands.add_parser("bench", help="measure speed against PyTorch",
                                  description=__doc__)
    command.add_argument("--json", metavar="FILE", type=OutputPath, help="write every number")
    command.add_argument("--seconds", type=number(above=0), default=1.0, metavar="S",
                         help="for each rival of each line (default: %(default)s)")
    command.add_argument("--no-peer", action="store_true", help="measure this package alone")
    command.set_defaults(run=run)


def run(arguments):
    peer, version = (None, None) if arguments.no_peer else _peer()
    machine = {
        "processor": _processor(), "cores": os.cpu_count(), "numpy": np.__version__,
        "torch": version, "BLAS kernels": os.environ.get("OPENBLAS_CORETYPE", "as BLAS chooses")}
    print(", ".join(f"{key} {value}" for key, value in machine.items() if value))
    if peer is None:
        print("PyTorch was not measured: " +
              ("not asked for" if arguments.no_peer else "it is not installed (pip install torch)"))
    rows = []
    for dtype in (np.float32, np.float64):
        problem = bench.Problem(dtype)
        for part in (bench.inference, bench.style_steps, bench.autoencoder_steps):
            rows += _told(part(problem, peer, arguments.seconds))
        for part in (bench.all_five, bench.convolutions):
            rows += _told(part(problem, arguments.seconds))
    print()
    print("\n".join(table(_lines(rows))))
    problem = bench.Problem(np.float32)
    scaling, rates = bench.scaling(problem), {
        name: bench.gemm_rate(name) for name in ("float32", "float64")}
    print(
        "\nstylise + project in float32, by frames: microseconds a frame with 1 and 2 threads, "
        "memory at most")
    print("\n".join(
        table([["frames", "1 thread", "2 threads", "memory"]] + [[
            f"{row['frames']:,}", *(f"{1e6 * t / row['frames']:.2f}"
                                    for t in row["seconds by threads"].values()),
            f"{row['peak bytes'] / 2 ** 20:.0f} MiB"] for row in scaling])))
    shares = {
        row["work"]: bench.direct_operations(int(row["work"].split()[-2])) / row["seconds"]["tiled"]
        / rates[row["dtype"]] for row in rows
        if row["dtype"] == "float32" and row["work"].startswith("stylise")}
    print("\na large matrix product: " + ", ".join(f"{name} {rate / 1e9:.0f} GFLOP/s"
                                                   for name, rate in rates.items()))
    for work, share in shares.items():
        print(f"{work}: what the direct convolution would count, at {share:.1f} times that rate")
    if arguments.json:
        with atomic_write(arguments.json) as file:
            json.dump(
                {
                    "machine": machine, "rows": rows, "scaling": scaling, "gemm": rates,
                    "share of gemm, counted directly": shares}, file, indent=1)


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
        times, best = row["seconds"], row["best peer"]
        lines.append([
            row["work"], row["dtype"],
            _milliseconds(times["tiled"]),
            _milliseconds(times.get("direct")),
            _milliseconds(times.get(best)),
            best.removeprefix("torch ") if best else "-",
            "-" if best is None else f"{row['ratio']:.2f}",
            "-" if row["relative error"] is None else f"{row['relative error']:.1e}"])
    return lines


def _milliseconds(seconds):
    return "-" if seconds is None else f"{1e3 * seconds:.2f} ms"


def _processor():
    try:
        with open("/proc/cpuinfo", errors="replace") as file:
            names = [
                line.split(":", 1)[1].strip() for line in file if line.startswith("model name")]
    except OSError:
        names = []
    return names[0] if names else platform.processor() or platform.machine()
