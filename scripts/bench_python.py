#!/usr/bin/env python3
"""How much longer a call from Python takes than the command line: one scan, read, completed and written by both.

    scripts/bench_python.py RELIEVO [REPEATS] [VERTICES]

RELIEVO is the program, built as the installed package is (`cargo build --release`, `maturin build --release`). Python's
times are taken twice: with the start of the interpreter (a new process for each, as the program's are), and without
(one process that has imported relievo). Writes a table to standard output.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import relievo

PROGRAM = """
import sys, relievo
done = relievo.complete(sys.argv[1])
relievo.write(done.scan, sys.argv[2], overwrite=True)
"""
ON_ARRAYS = """
import sys, numpy, relievo
scan = relievo.read(sys.argv[1])
done = relievo.complete((scan.vertices, scan.faces))
numpy.save(sys.argv[2] + ".npy", done.scan.vertices)
relievo.write(done.scan, sys.argv[2], overwrite=True)
"""


def timed(words: list[str]) -> float:
    began = time.perf_counter()
    subprocess.run(words, check=True, capture_output=True)
    return time.perf_counter() - began


def in_process(scan: Path, out: Path) -> float:
    began = time.perf_counter()
    relievo.write(relievo.complete(scan).scan, out, overwrite=True)
    return time.perf_counter() - began


def main() -> None:
    program = sys.argv[1]
    repeats = int(sys.argv[2]) if len(sys.argv) > 2 else 9
    vertices = sys.argv[3] if len(sys.argv) > 3 else "250000"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scan = folder / "scan.ply"
        subprocess.run([program, "synth", "golf-ball", "--vertices", vertices, "-o", str(scan)], check=True)
        outs = {kind: folder / f"{kind}.ply" for kind in ("command line", "python", "on arrays", "in process")}
        seconds: dict[str, list[float]] = {kind: [] for kind in outs}
        relievo.info(scan)
        for _ in range(repeats):
            run = {
                "command line": lambda out: timed([program, "complete", str(scan), "-o", str(out)]),
                "python": lambda out: timed([sys.executable, "-c", PROGRAM, str(scan), str(out)]),
                "on arrays": lambda out: timed([sys.executable, "-c", ON_ARRAYS, str(scan), str(out)]),
                "in process": lambda out: in_process(scan, out),
            }
            for kind, measure in run.items():
                seconds[kind].append(measure(outs[kind]))
        same = outs["python"].read_bytes() == outs["in process"].read_bytes() == outs["command line"].read_bytes()
        medians = {kind: statistics.median(times) for kind, times in seconds.items()}
        print(f"{vertices} vertices, {repeats} repeats in turn, same bytes: {same}")
        for kind, median in medians.items():
            ratio = median / medians["command line"]
            print(f"{kind:<14} {median:8.3f} s  {ratio:6.3f}  ({min(seconds[kind]):.3f} to {max(seconds[kind]):.3f})")
        print(json.dumps(seconds))


if __name__ == "__main__":
    main()
