"""Ctrl-C, and other threads that run on."""

from __future__ import annotations

import logging
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import relievo
from common import Command

# Seconds. The interrupt itself takes a twentieth of one; the rest is for machines with much to do.
SOON = 1.0


@pytest.fixture(scope="session")
def large(command: Command, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scan whose completion by the exhaustive method takes much longer than this test waits."""
    path = tmp_path_factory.mktemp("large") / "bark.ply"
    command("synth", "bark", "--vertices", 60000, "-o", path)
    return path


@pytest.fixture(scope="session")
def middling(command: Command, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scan whose completion takes about a second."""
    path = tmp_path_factory.mktemp("middling") / "golf-ball.ply"
    command("synth", "golf-ball", "--vertices", 8000, "-o", path)
    return path


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent differently there")
def test_an_interrupt_raises_at_once_and_leaves_nothing(large: Path, tmp_path: Path) -> None:
    code = f"""
import signal, sys, relievo
# What a script starts in the background ignores it.
signal.signal(signal.SIGINT, signal.default_int_handler)
scan = relievo.read({str(large)!r})
print("begun", flush=True)
try:
    relievo.complete(scan, method="exhaustive", report={str(tmp_path / "page.html")!r})
except KeyboardInterrupt:
    print("interrupted", flush=True)
    sys.exit(7)
"""
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "begun\n"
        time.sleep(1.5)
        assert process.poll() is None, "it is done already: this test needs a larger scan"
        sent = time.monotonic()
        process.send_signal(signal.SIGINT)
        assert process.stdout.readline() == "interrupted\n"
        raised = time.monotonic() - sent
        assert process.wait(timeout=30) == 7
        ended = time.monotonic() - sent
    print(f"raised after {raised:.3f} s, ended after {ended:.3f} s")
    assert raised < SOON and ended < SOON
    assert os.listdir(tmp_path) == []


def test_after_an_interrupt_the_work_soon_ends_and_the_next_call_works(large: Path, golf_ball: Path) -> None:
    def interrupt() -> None:
        time.sleep(1.0)
        signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Thread(target=interrupt)
    with pytest.raises(KeyboardInterrupt):
        timer.start()
        try:
            relievo.complete(large, method="exhaustive")
        finally:
            # It comes here at the latest, and not when the test is over.
            timer.join()
    signal.signal(signal.SIGINT, before)
    assert relievo.complete(golf_ball).report["status"] == "done"


def test_an_error_in_a_handler_of_messages_ends_the_work(large: Path, tmp_path: Path) -> None:
    class Failing(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            raise KeyboardInterrupt

    logger, handler = logging.getLogger("relievo"), Failing()
    scan = relievo.read(large)
    twice = relievo.Scan(scan.vertices, np.concatenate([scan.faces, scan.faces[:1]]))
    logger.addHandler(handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            relievo.complete(twice, method="exhaustive", report=tmp_path / "page.html")
    finally:
        logger.removeHandler(handler)
    # As long as it works it has an output open.
    since = time.monotonic()
    while os.listdir(tmp_path):
        assert time.monotonic() - since < 60, "it works on"
        time.sleep(0.05)


def test_a_fork_takes_nothing_from_its_parent(large: Path, tmp_path: Path) -> None:
    if not hasattr(os, "fork"):
        pytest.skip("this system has no forks")
    code = f"""
import os, signal, sys, threading, time, relievo
folder = {str(tmp_path)!r}
def complete():
    try:
        relievo.complete({str(large)!r}, method="exhaustive", report=folder + "/page.html")
    except KeyboardInterrupt:
        pass
threading.Thread(target=complete, daemon=True).start()
while not os.listdir(folder):
    time.sleep(0.01)
if os.fork() == 0:
    sys.exit()
os.wait()
assert os.listdir(folder), "the fork has taken it"
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=300)
    assert os.listdir(tmp_path) == []


def test_python_runs_on_while_relievo_works(middling: Path) -> None:
    scan = relievo.read(middling)
    done = threading.Event()
    count = 0

    def tick() -> None:
        nonlocal count
        while not done.is_set():
            count += 1
            time.sleep(0.01)

    ticking = threading.Thread(target=tick)
    ticking.start()
    began = time.monotonic()
    relievo.complete(scan, threads=1)
    seconds = time.monotonic() - began
    done.set()
    ticking.join()
    # With the interpreter's lock held it would be one or two.
    assert count > 10 * seconds


def test_two_threads_complete_at_the_same_time(middling: Path) -> None:
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if cores < 2:
        pytest.skip("there is one core only")
    scan = relievo.read(middling)
    done: list[tuple[float, float, relievo.Completed]] = []

    def one() -> None:
        began = time.monotonic()
        completed = relievo.complete(scan, threads=1)
        done.append((began, time.monotonic(), completed))

    threads = [threading.Thread(target=one) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    (began, ended, first), (began_too, ended_too, second) = done
    # With the interpreter's lock held the second would begin after the first has ended.
    overlap = min(ended, ended_too) - max(began, began_too)
    assert overlap > 0.5 * min(ended - began, ended_too - began_too)
    assert np.array_equal(first.scan.vertices, second.scan.vertices)
