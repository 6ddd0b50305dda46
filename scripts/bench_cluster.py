#!/usr/bin/env python3
"""Measures relievo on Dask's workers against the command line on the same machine.

    scripts/bench_cluster.py many RELIEVO [SCANS [VERTICES]]
    scripts/bench_cluster.py tiled RELIEVO [VERTICES [TILE]]

RELIEVO is the program, as `cargo build --release` makes it; the package is the one that this Python has, built by
`maturin build --release`. `many` completes SCANS scans (48) of VERTICES vertices (25000) by `relievo batch` and on two
workers, of which one is killed in the middle. `tiled` completes one scan of VERTICES vertices (1000000) in one piece and
in tiles of TILE vertices (200000) on two workers, and tells the seams and each process's most memory.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from distributed import Client
from relievo.distributed import Outcome, complete_many, complete_tiled

KINDS = ["golf-ball", "bricks", "waves", "noise"]


def most_memory() -> float:
    """Of this process, in MiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.glob("*.ply"))}


def many(program: str, folder: Path, scans: int, vertices: int) -> None:
    sources = folder / "scans"
    sources.mkdir()
    for number in range(scans):
        words = [KINDS[number % len(KINDS)], "--vertices", vertices, "--hole", 0.01, "--seed", number]
        output = ["-o", sources / f"{number:03}.ply"]
        subprocess.run([program, "synth", *map(str, words + output)], check=True)
    pattern = str(sources / "*.ply")
    since = time.perf_counter()
    batch = [program, "batch", pattern, "--out", str(folder / "batch"), "--jobs", "2", "-q"]
    subprocess.run(batch, check=True, stdout=subprocess.DEVNULL)
    print(f"relievo batch, two at a time: {time.perf_counter() - since:.1f} s", flush=True)
    expected = files(folder / "batch")
    assert len(expected) == scans
    for is_killed in (False, True):
        name = "killed" if is_killed else "workers"
        with Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
            ended = 0

            def kill(_: Outcome) -> None:
                nonlocal ended
                ended += 1
                if is_killed and ended == scans // 2:
                    os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)

            since = time.perf_counter()
            outcomes = complete_many([pattern], folder / name, client=client, on_done=kill)
            seconds = time.perf_counter() - since
        same = files(folder / name) == expected
        done = sum(outcome.status == "done" for outcome in outcomes)
        told = ", one killed in the middle" if is_killed else ""
        print(f"two workers{told}: {seconds:.1f} s, {done} of {scans} done, same bytes: {same}", flush=True)


def tiled(program: str, folder: Path, vertices: int, tile: int) -> None:
    scan, whole, parts = (folder / name for name in ("scan.ply", "whole.ply", "tiled.ply"))
    synth = ["synth", "golf-ball", "--vertices", str(vertices), "--hole", "0.1", "-o", str(scan)]
    told = subprocess.run([program, *synth, "--json", "-"], check=True, capture_output=True)
    print(f"{json.loads(told.stdout)['vertices']} vertices, {scan.stat().st_size / 1e6:.0f} MB", flush=True)
    since = time.perf_counter()
    subprocess.run([program, "complete", str(scan), "-o", str(whole), "-q"], check=True)
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    print(f"in one piece, two threads: {time.perf_counter() - since:.1f} s, {peak:.0f} MiB", flush=True)
    with Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
        before = max(client.run(most_memory).values())
        since = time.perf_counter()
        done = complete_tiled(scan, parts, tile=tile, client=client)
        seconds = time.perf_counter() - since
        workers = max(client.run(most_memory).values())
    tiling, seams = done.report["tiling"], done.report["seams"]
    print(f"in tiles on two workers: {seconds:.1f} s, {tiling}, seams {seams}")
    print(f"a worker {workers:.0f} MiB ({before:.0f} before), this process {most_memory():.0f} MiB", flush=True)
    for name, path in (("one piece", whole), ("tiles", parts)):
        words = [program, "stats", str(path), "--pieces", "0", "-q", "--json", "-"]
        figures = json.loads(subprocess.run(words, check=True, capture_output=True).stdout)
        print(f"Sq of {name}: {[figures[part]['areal']['Sq'] for part in ('original', 'completed')]}", flush=True)


def main() -> None:
    what, program, *numbers = sys.argv[1:] or ["", ""]
    doing = {"many": (many, [48, 25_000]), "tiled": (tiled, [1_000_000, 200_000])}.get(what)
    if doing is None:
        sys.exit(__doc__)
    run, sizes = doing
    sizes[: len(numbers)] = map(int, numbers)
    with tempfile.TemporaryDirectory() as folder:
        run(program, Path(folder), *sizes)


if __name__ == "__main__":
    main()
