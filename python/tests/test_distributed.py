"""Many scans and tiles of one on Dask's workers: the same bytes as the command line, whichever workers die."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import relievo
from common import SCANS, Command
from relievo import _relievo
from relievo._call import arguments_of

distributed = pytest.importorskip("distributed")
cloudpickle = pytest.importorskip("cloudpickle")

from relievo._cluster import all_of  # noqa: E402
from relievo.distributed import Outcome, complete_many, complete_tiled  # noqa: E402


# With more Dask gives a task up: `distributed.scheduler.allowed-failures`.
ALLOWED_DEATHS = 3 + 1


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    """Two workers, each a process, which are begun again when they die."""
    with distributed.Client(n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0") as client:
        yield client


@pytest.fixture(scope="module")
def scans(command: Command, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of scans with holes, in two folders, one of them broken."""
    folder = tmp_path_factory.mktemp("many")
    for number in range(6):
        place = folder / "scans" / ("odd" if number % 2 else "even")
        place.mkdir(parents=True, exist_ok=True)
        path = place / f"{number}.ply"
        command("synth", "waves", "--vertices", 1500, "--hole", 0.08, "--seed", number, "-o", path)
    (folder / "scans" / "odd" / "broken.ply").write_text("ply\nformat ascii 1.0\n")
    return folder


def files(folder: Path) -> dict[str, bytes]:
    """What a folder holds, but for what `relievo batch` notes there."""
    found = (path.relative_to(folder) for path in sorted(folder.rglob("*")) if path.is_file())
    return {str(path): (folder / path).read_bytes() for path in found if path.parts[0] != ".relievo"}


@pytest.fixture(scope="module")
def batch(command: Command, scans: Path) -> dict[str, bytes]:
    """What `relievo batch` makes of the scans."""
    options = ["--seed", 4, "--step.complete.window=3"]
    command("batch", scans / "scans" / "**" / "*.ply", "--out", scans / "batch", *options, code=1)
    made = files(scans / "batch")
    assert len(made) == 6
    return made


def worker_ids(client: Any) -> list[int]:
    ids: dict[str, int] = client.run(os.getpid)
    return sorted(ids.values())


def test_many_scans_are_completed_as_by_batch_and_a_broken_one_stops_nothing(
    client: Any, scans: Path, batch: dict[str, bytes]
) -> None:
    told: list[Outcome] = []
    outcomes = complete_many(
        [scans / "scans" / "**" / "*.ply"], scans / "dask", client=client, on_done=told.append, seed=4, window=3
    )
    assert files(scans / "dask") == batch
    assert len(outcomes) == 7 and sorted(map(id, told)) == sorted(map(id, outcomes))
    statuses = {Path(outcome.input).name: outcome.status for outcome in outcomes}
    assert statuses == {f"{number}.ply": "done" for number in range(6)} | {"broken.ply": "failed"}
    broken = next(outcome for outcome in outcomes if outcome.status == "failed")
    assert broken.error is not None and "broken.ply" in broken.error
    first = next(outcome for outcome in outcomes if outcome.status == "done")
    assert [step["type"] for step in first.report["steps"]] == ["read", "complete", "write"]
    assert first.report["command"] == "run" and first.seconds > 0
    assert [outcome.input for outcome in outcomes] == sorted(outcome.input for outcome in outcomes)
    assert all(Path(outcome.output).is_file() == (outcome.status == "done") for outcome in outcomes)


def test_a_worker_that_dies_costs_its_tasks_another_try_only(client: Any, scans: Path, batch: dict[str, bytes]) -> None:
    killed: list[int] = []

    def kill(_: Outcome) -> None:
        if not killed:
            killed.extend(worker_ids(client)[:1])
            os.kill(killed[0], signal.SIGKILL)

    pattern = scans / "scans" / "**" / "[0-9].ply"
    outcomes = complete_many([pattern], scans / "killed", client=client, on_done=kill, seed=4, window=3)
    assert killed and [outcome.status for outcome in outcomes] == 6 * ["done"]
    assert files(scans / "killed") == batch
    client.wait_for_workers(2, timeout=60)
    assert killed[0] not in worker_ids(client)


def test_options_that_cannot_be_are_told_before_anything_is_done(client: Any, scans: Path, tmp_path: Path) -> None:
    path = scans / "scans" / "even" / "0.ply"
    cases: list[tuple[list[Path], dict[str, Any], str]] = [
        ([path], {"windw": 3}, "did you mean `window`"),
        ([scans / "*.obj"], {}, "no file matches"),
        ([path], {"format": "xyz"}, "format"),
        ([path], {"holes": "some"}, "expected interior"),
    ]
    for paths, options, words in cases:
        with pytest.raises(relievo.UsageError, match=words):
            complete_many(paths, tmp_path / "out", client=client, **options)
    values: list[tuple[str, Any, str]] = [
        ("mask", object(), "no number, text or list"),
        ("tolerance", float("nan"), "a value that cannot be"),
    ]
    for name, value, words in values:
        with pytest.raises(relievo.UsageError, match=words):
            complete_many([path], tmp_path / "out", client=client, **{name: value})
    numbers: list[tuple[str, Any]] = [("seed", "two"), ("seed", -1), ("threads", 0), ("threads", "two")]
    for name, value in numbers:
        with pytest.raises(relievo.UsageError, match=f"{name} is"):
            complete_many([path], tmp_path / "out", client=client, **{name: value})
        with pytest.raises(relievo.UsageError, match=f"{name} is"):
            complete_tiled(path, client=client, **{name: value})
    assert not (tmp_path / "out").exists()
    with pytest.raises(relievo.UsageError, match="list"):
        complete_many(str(path), tmp_path / "out", client=client)
    (tmp_path / "0.ply").write_bytes(b"mine")
    with pytest.raises(relievo.UsageError, match="exists"):
        complete_many([path], tmp_path, client=client)
    assert (tmp_path / "0.ply").read_bytes() == b"mine"


def test_each_goes_on_with_what_the_other_has_begun(client: Any, scans: Path, command: Command, tmp_path: Path) -> None:
    pattern, out = scans / "scans" / "even" / "*.ply", tmp_path / "out"
    options: dict[str, Any] = {"window": 3, "holes": "largest", "seed": 2}

    def statuses(**more: Any) -> list[str]:
        return [outcome.status for outcome in complete_many([pattern], out, client=client, **options, **more)]

    assert statuses(resume=True) == ["done"] * 3
    words = ["--seed", 2, "--step.complete.window=3", "--step.complete.holes=largest", "--resume"]
    lines = command("batch", pattern, "--out", out, *words).stdout.splitlines()
    assert [json.loads(line)["status"] for line in lines] == ["skipped"] * 3
    told: list[Outcome] = []
    before = files(out)
    assert statuses(resume=True, on_done=told.append) == ["skipped"] * 3
    assert len(told) == 3 and all(outcome.error is None for outcome in told)
    # What somebody has changed is done again, and so is what is gone.
    (out / "0.ply").write_bytes(b"changed")
    (out / "2.ply").unlink()
    assert statuses(resume=True) == ["done", "done", "skipped"]
    assert files(out) == before
    # Without it all are, and what a batch has written may be written over.
    assert statuses() == ["done"] * 3
    assert files(out) == before


def test_the_folder_of_results_is_one_batchs_at_a_time(
    client: Any, scans: Path, command: Command, tmp_path: Path
) -> None:
    path, out = scans / "scans" / "even" / "0.ply", tmp_path / "out"
    said: list[str] = []

    def meanwhile(_: Outcome) -> None:
        said.append(command("batch", path, "--out", out, code=2).stderr)

    complete_many([path], out, client=client, on_done=meanwhile, window=3)
    assert "another batch is at work in this folder" in said[0]
    command("batch", path, "--out", out, "--step.complete.window=3", "--resume")


def test_seeds_of_pipelines_are_kept_unless_one_is_given(client: Any, scans: Path, tmp_path: Path) -> None:
    path = scans / "scans" / "even" / "0.ply"
    (tmp_path / "steps.json").write_text(json.dumps({"seed": 7, "pipeline": [{"type": "complete", "window": 3}]}))
    made: dict[Any, bytes] = {}
    for seed in (None, 7, 0):
        out = tmp_path / str(seed)
        complete_many([path], out, client=client, pipeline=tmp_path / "steps.json", seed=seed)
        made[seed] = (out / "0.ply").read_bytes()
    assert made[None] == made[7] != made[0]


def test_paths_are_relative_to_the_clients_folder(
    client: Any, scans: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "scans").mkdir()
    (tmp_path / "scans" / "0.ply").write_bytes((scans / "scans" / "even" / "0.ply").read_bytes())
    client.run(os.chdir, tmp_path / "elsewhere")
    monkeypatch.chdir(tmp_path)
    steps = [
        {"type": "complete", "window": 3, "report": "{stem}.html"},
        {"type": "stats", "csv": "{stem}.csv", "pieces": 64},
        {"type": "compare", "other": "scans/0.ply", "pieces": 64},
    ]
    Path("steps.json").write_text(json.dumps(steps))
    (done,) = complete_many(["scans/0.ply"], "out", client=client, pipeline="steps.json", seed=4)
    assert (done.status, done.error) == ("done", None)
    assert (done.input, done.output) == ("scans/0.ply", "out/0.ply")
    assert sorted(os.listdir()) == ["0.csv", "0.html", "elsewhere", "out", "scans", "steps.json"]
    assert os.listdir("elsewhere") == []
    (done,) = complete_many(["scans/0.ply"], "out", client=client, resume=True, pipeline="steps.json", seed=4)
    assert done.status == "skipped"
    client.run(os.chdir, "/")


def test_any_client_that_waits_will_do_and_no_other(client: Any, scans: Path, tmp_path: Path) -> None:
    path = scans / "scans" / "even" / "0.ply"
    address = client.scheduler.address
    with distributed.Client(address, set_as_default=False) as other:
        assert distributed.Client.current() is client
        (done,) = complete_many([path], tmp_path / "other", client=other, window=3)
        assert done.status == "done"
    # A loop of its own, and not the current one.
    cluster = distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address="127.0.0.1:0")
    with cluster, distributed.Client(cluster, set_as_default=False) as own:
        (done,) = complete_many([path], tmp_path / "own", client=own, window=3)
        assert done.status == "done"
    assert (tmp_path / "own" / "0.ply").read_bytes() == (tmp_path / "other" / "0.ply").read_bytes()

    async def asynchronous() -> None:
        async with distributed.Client(address, asynchronous=True) as waited:
            for function in (complete_many, complete_tiled):
                with pytest.raises(relievo.UsageError, match="asynchronous"):
                    function([path], tmp_path / "out", client=waited)

    asyncio.run(asynchronous())
    with pytest.raises(relievo.UsageError, match="a str is no client"):
        complete_many([path], tmp_path / "out", client=address)


def test_workers_that_come_later_get_tasks(tmp_path: Path) -> None:
    cloudpickle.register_pickle_by_value(sys.modules[__name__])
    cluster = distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address="127.0.0.1:0")
    with cluster, distributed.Client(cluster, set_as_default=False) as client:
        waiting, ended = iter(range(8)), []
        for number, future in all_of(client, _where, waiting, lambda number: number, 1):
            ended.append(future.result())
            if number == 1:
                cluster.scale(3)
                client.wait_for_workers(3, timeout=60)
        assert len(set(ended)) == 3


def test_a_task_during_which_many_workers_died_is_tried_once_more_by_itself(client: Any, tmp_path: Path) -> None:
    cloudpickle.register_pickle_by_value(sys.modules[__name__])
    client.wait_for_workers(2, timeout=60)
    tasks = {0: (str(tmp_path / "deaths"), ALLOWED_DEATHS), 1: ("", 0), 2: ("", 0), 3: ("", 0)}
    done = {number: future.result() for number, future in all_of(client, _die_often, iter(tasks), tasks.__getitem__, 1)}
    assert sorted(done) == [0, 1, 2, 3]
    assert len((tmp_path / "deaths").read_bytes()) == ALLOWED_DEATHS
    # The others have not paid for it: they are done before.
    assert list(done)[-1] == 0


def test_what_fails_for_good_is_not_tried_again_and_what_may_pass_is(client: Any, tmp_path: Path) -> None:
    cloudpickle.register_pickle_by_value(sys.modules[__name__])
    tried = {}
    for passing in (False, True):
        folder = tmp_path / str(passing)
        folder.mkdir()
        client.run(_fail_always, str(folder), passing)
        try:
            path = SCANS / "bricks-hole.ply"
            (failed,) = complete_many([path], folder / "out", client=client)
        finally:
            client.run(_fail_no_more)
        assert (failed.status, failed.error) == ("failed", "it is so")
        tried[passing] = len(list(folder.glob("tried*")))
    assert tried == {False: 1, True: 4}


def test_an_error_of_the_one_who_is_told_leaves_no_tasks(
    client: Any, scans: Path, command: Command, tmp_path: Path
) -> None:
    def fail(_: Outcome) -> None:
        raise KeyboardInterrupt

    (tmp_path / "scans").mkdir()
    (tmp_path / "scans" / "0.ply").write_bytes((scans / "scans" / "even" / "0.ply").read_bytes())
    # It would take much longer than this test waits.
    command("synth", "bark", "--vertices", 30000, "--hole", 0.2, "-o", tmp_path / "scans" / "1.ply")
    given: dict[str, Any] = {"client": client, "window": 3, "method": "exhaustive"}
    cloudpickle.register_pickle_by_value(sys.modules[__name__])
    with pytest.raises(KeyboardInterrupt):
        complete_many([tmp_path / "scans" / "*.ply"], tmp_path / "out", on_done=fail, **given)
    since = time.monotonic()
    while any(client.run(_processes).values()):
        assert time.monotonic() - since < 60, "a scan that nobody waits for is worked on"
        time.sleep(0.1)
    assert list(files(tmp_path / "out")) == ["0.ply"]
    # The folder is free again.
    (found,) = complete_many([tmp_path / "scans" / "0.ply"], tmp_path / "out", resume=True, **given)
    assert found.status == "skipped"


def test_a_scan_gets_no_more_memory_than_its_worker(scans: Path, tmp_path: Path) -> None:
    path = scans / "scans" / "even" / "0.ply"
    options: dict[str, Any] = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": "127.0.0.1:0"}
    if sys.platform != "linux":
        pytest.skip("only Linux tells the memory of other processes")
    with distributed.Client(memory_limit="400MB", set_as_default=False, **options) as client:
        cloudpickle.register_pickle_by_value(sys.modules[__name__])
        client.run(_limit_memory, 1 << 20)
        (failed,) = complete_many([path], tmp_path / "out", client=client, window=3)
    assert failed.status == "failed"
    assert failed.error is not None and "more than a thread of the worker may" in failed.error
    assert files(tmp_path / "out") == {}


@pytest.fixture(scope="module")
def large(command: Command, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, bytes, Any]:
    """A scan with a hole of several tiles, and what the command line makes of it."""
    folder = tmp_path_factory.mktemp("large")
    path, done = folder / "in.ply", folder / "done.ply"
    command("synth", "bricks", "--vertices", 4000, "--hole", 0.3, "-o", path)
    options = ["--tile", 1600, "--window", 2, "--rotations", 1, "--seed", 2]
    command("complete", path, "-o", done, *options)
    return path, done.read_bytes(), {"tile": 1600, "window": 2, "rotations": 1, "seed": 2}


def test_tiles_grown_by_workers_give_the_bytes_of_the_command_line(
    client: Any, large: tuple[Path, bytes, Any], tmp_path: Path
) -> None:
    path, expected, options = large
    before = path.read_bytes()
    out = tmp_path / "out.ply"
    for given in (path, relievo.read(path)):
        done = complete_tiled(given, out, client=client, overwrite=True, **options)
        assert out.read_bytes() == expected
    assert path.read_bytes() == before
    tiling, seams = done.report["tiling"], done.report["seams"]
    assert tiling["tiles"] > 2 and tiling["most_vertices"] <= 1600
    for ratio in (seams["heights"], seams["colors"]):
        assert ratio is not None and 0 < ratio <= 1.2, seams
    with pytest.raises(relievo.WriteError, match="there already"):
        complete_tiled(path, out, client=client, **options)
    for name, error in (("out.las", relievo.UsageError), ("none/out.ply", relievo.WriteError)):
        # No scan is read before that.
        with pytest.raises(error, match="out"):
            complete_tiled(tmp_path / "missing.ply", tmp_path / name, client=client)
    assert os.listdir(tmp_path) == ["out.ply"]
    with pytest.raises(relievo.UsageError, match="cannot be tiled"):
        complete_tiled(path, client=client, method="paper", **options)
    with pytest.raises(relievo.UsageError, match="leave it out"):
        complete_tiled(path, client=client, output="x.ply", **options)


def test_tiles_can_be_put_together_once_all_are_back(large: tuple[Path, bytes, Any]) -> None:
    path, _, options = large
    seed = options["seed"]
    asked = {name: value for name, value in options.items() if name != "seed"}
    members, held = arguments_of("complete", {"scan": path}, asked, seed)
    tiles = _relievo.Tiles(members, held, None)
    for together in tiles.rounds():
        for number in together:
            # As often as one likes: the tiles that are back stay.
            with pytest.raises(relievo.RelievoError, match="not been put back yet"):
                tiles.finish()
            tiles.put(number, _relievo.grow_tile(tiles.task(number), None))
    done, told, _ = tiles.finish()
    assert done is not None and "statistics" in told
    with pytest.raises(relievo.UsageError, match="put together already"):
        tiles.finish()


def test_a_worker_that_dies_with_a_tile_changes_nothing(
    client: Any, large: tuple[Path, bytes, Any], tmp_path: Path
) -> None:
    path, expected, options = large
    client.wait_for_workers(2, timeout=60)
    flag = tmp_path / "died"
    # Workers cannot import the tests.
    cloudpickle.register_pickle_by_value(sys.modules[__name__])
    client.run(_die_once, str(flag))
    done = complete_tiled(path, tmp_path / "out.ply", client=client, **options)
    assert flag.exists(), "no worker died"
    assert not done.partly
    assert (tmp_path / "out.ply").read_bytes() == expected


def _die_once(flag: str) -> None:
    """Lets the worker end hard in the middle of its first tile, once."""
    from relievo import _relievo, distributed

    def die(task: bytes, threads: int | None) -> bytes:
        try:
            os.close(os.open(flag, os.O_CREAT | os.O_EXCL))
        except FileExistsError:
            return _relievo.grow_tile(task, threads)
        os.kill(os.getpid(), signal.SIGKILL)
        raise AssertionError

    distributed._grow_tile = die


def _die_often(task: tuple[str, int], threads: int) -> int:
    """Kills its worker so many times."""
    path, times = task
    if times and (not os.path.exists(path) or os.path.getsize(path) < times):
        with open(path, "ab") as deaths:
            deaths.write(b"x")
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(0.5)
    return os.getpid()


def _where(_: int, threads: int) -> int:
    """Which worker it is, after a while."""
    time.sleep(0.3)
    return os.getpid()


def _fail_always(folder: str, passing: bool) -> None:
    """Lets scans fail, and count how often."""
    from relievo import _relievo

    def fail(task: str, threads: int, memory: int | None, is_wanted: Any) -> str:
        Path(folder, f"tried{time.monotonic_ns()}").touch()
        return json.dumps({"status": "failed", "error": "it is so", "seconds": 0.0, "may_pass": passing})

    _relievo.kept_work_for_batch = _relievo.work_for_batch  # type: ignore[attr-defined]
    _relievo.work_for_batch = fail


def _fail_no_more() -> None:
    from relievo import _relievo

    _relievo.work_for_batch = _relievo.kept_work_for_batch  # type: ignore[attr-defined]


def _processes() -> int:
    """How many scans a worker has processes for."""
    import psutil

    return len(psutil.Process().children())


def _limit_memory(most: int, dask_worker: Any) -> None:
    """As if Dask had been told so; with so little no worker would begin."""
    dask_worker.memory_manager.memory_limit = most
