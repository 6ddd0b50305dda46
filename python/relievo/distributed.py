"""Many scans, or one scan that is too large for one machine, on the workers of a Dask cluster.

Dask (``pip install relievo[distributed]``) runs on a laptop, on Slurm, on Kubernetes and in clouds; whatever gives a
``dask.distributed.Client`` will do. Workers need relievo, and for :func:`complete_many` the folders of the scans and of
the results under the same paths.

A worker that dies costs its tasks another try: tasks have no state, and give the same bytes wherever and however often
they run. A task during which more workers die than Dask's ``distributed.scheduler.allowed-failures`` (3) is tried once
more while no others are at work; if workers die then, too, it has failed.

>>> from dask.distributed import Client                                                  # doctest: +SKIP
>>> with Client(n_workers=2) as client:                                                  # doctest: +SKIP
...     outcomes = complete_many(["scans/*.ply"], "results", client=client, holes="largest")
...     large = complete_tiled("large.ply", tile=200_000, client=client)
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, closing, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from . import _relievo
from ._call import arguments_of, json_of, report_of, threads_of, whole_number
from ._cluster import all_of, checked, clientele
from ._errors import RelievoError, UsageError, WorkError
from ._messages import in_python
from ._scan import Scan, opened

if TYPE_CHECKING:
    from distributed import Client, Future

    from ._reports import CompletionReport
    from ._types import PathLike, ScanLike

__all__ = ["Outcome", "TiledCompletion", "complete_many", "complete_tiled"]

_grow_tile = _relievo.grow_tile


@dataclass(frozen=True)
class Outcome:
    """What came of one scan of many."""

    #: The scan's path.
    input: str
    #: The result's path.
    output: str
    #: ``partly`` if some of the gaps stayed open, ``skipped`` if the result was there already (``resume``).
    status: Literal["done", "partly", "skipped", "failed"]
    #: Seconds that the work took on its worker.
    seconds: float
    #: What ``relievo run --json`` writes; of what failed, as far as it came; empty for what was skipped.
    report: dict[str, Any]
    #: Why it failed.
    error: str | None
    #: What relievo had to say of the scan.
    warnings: list[str]


@dataclass(frozen=True)
class TiledCompletion:
    """A scan that was completed in tiles."""

    #: First all that was there, bit for bit and in its order, then what is new.
    scan: Scan
    #: As of :func:`relievo.complete`: ``report["tiling"]`` says how the scan was divided, and ``report["seams"]`` how
    #: well the tiles fit together, as ratios of the steps across their borders to those of edges of the same direction
    #: within them (1 where no border shows).
    report: CompletionReport
    #: Whether some of the chosen gaps stayed open.
    partly: bool


def complete_many(
    paths: Sequence[PathLike],
    out: PathLike,
    *,
    client: Client | None = None,
    pipeline: PathLike | None = None,
    format: Literal["ply", "obj", "off", "stl", "glb"] | None = None,
    overwrite: bool = False,
    resume: bool = False,
    on_done: Callable[[Outcome], None] | None = None,
    seed: int | None = None,
    threads: int = 1,
    **options: Any,
) -> list[Outcome]:
    """Completes many scans, each on one worker: the same files, byte for byte, as ``relievo batch`` writes.

    Each scan has a process of its own on its worker, as with ``relievo batch``, and no more memory than Dask allows the
    worker, divided by the worker's threads. Results are recorded in ``out`` (in the folder ``.relievo``) as by
    ``relievo batch``: either goes on with what the other has begun. One of them at a time works in a folder.

    Parameters
    ----------
    paths : sequence of paths
        Scans, patterns such as ``"scans/**/*.ply"``, or files of jobs (``.json``), as ``relievo batch`` takes them.
        Relative ones, here and in pipelines, are relative to this process's working folder, whatever the workers' is.
    out : path
        Folder of the results, under the scans' names; made if it is not there.
    client : dask.distributed.Client, optional
        The cluster; by default the current client, or else processes on this machine, one a core, for this call.
    pipeline : path, optional
        What is done to each scan, as a file that ``relievo run`` takes; by default it is completed.
    format : str, optional
        Format of the results; by default the scan's if it can be written, or PLY.
    overwrite : bool, default False
        Whether files in ``out`` may be written over that no batch has written. Those of earlier batches are, unless
        ``resume`` leaves them as they are.
    resume : bool, default False
        Leave out scans whose results are there, made of the same content with the same options.
    on_done : function of an Outcome, optional
        Called for each scan as it ends.
    seed : int, optional
        Seed of all random choices; by default that of the pipeline, or 0.
    threads : int, default 1
        Threads of each task. Workers do as many tasks at a time as they have threads of Dask's: more than 1 is for
        workers with more cores than that.
    **options
        Options of :func:`relievo.complete`, as ``holes="largest"``.

    Returns
    -------
    list of Outcome
        In the order of the scans, failed ones among them: one scan that fails never stops the rest.

    Raises
    ------
    UsageError
        An option that cannot be, two scans with one result, a result that exists and that no batch has written, or a
        folder where another batch is at work.
    """
    given = checked(client)
    each = threads_of(threads) or 1
    outcomes: dict[int, Outcome] = {}

    def tell(number: int, outcome: Outcome) -> None:
        outcomes[number] = outcome
        if on_done is not None:
            on_done(outcome)

    planned = _batch(paths, out, pipeline, format, overwrite, resume, seed, options)
    with closing(planned) as batch, clientele(given) as cluster:
        scans = batch.scans()

        def to_do() -> Iterator[int]:
            for number, names in enumerate(scans):
                found = batch.found(number)
                if found is None:
                    yield number
                else:
                    tell(number, _outcome(names, json.loads(found)))

        with closing(all_of(cluster, _work, to_do(), batch.task, each)) as ended:
            for number, future in ended:
                tell(number, _outcome(scans[number], _line(future)))
    return [outcomes[number] for number in range(len(scans))]


def complete_tiled(
    scan: ScanLike,
    out: PathLike | None = None,
    *,
    tile: int = 200_000,
    overlap: float | None = None,
    client: Client | None = None,
    overwrite: bool = False,
    seed: int = 0,
    threads: int = 1,
    **options: Any,
) -> TiledCompletion:
    """Completes one scan in tiles, grown by the workers: the same, byte for byte, as ``relievo complete --tile``.

    This process reads the scan, fits its base surface, chooses its holes and puts the tiles together; matching and
    growing, which take most of time and memory, are the workers', of which none gets more than ``tile`` vertices. Tiles
    that touch are grown one after the other, the later continuing what the earlier has copied.

    Parameters
    ----------
    scan : ScanLike
        Scan, path, trimesh.Trimesh, or (vertices, faces).
    out : path, optional
        Where the completed scan is written, too; opened before the work, it appears when it is complete.
    tile : int, default 200_000
        Most vertices that a worker gets: new ones, those around them, and those to copy from. For coherent search a
        task takes some 3 kB a vertex, and so many tasks run on a worker as it has threads; what tables of
        neighborhoods may take, as those of exhaustive search, ``memory=`` bounds for each task.
    overlap : float, optional
        How far around its new vertices a tile sees everything, in the scan's unit; by default twice as far as a window.
    client : dask.distributed.Client, optional
        The cluster; by default the current client, or else processes on this machine, one a core, for this call.
    overwrite : bool, default False
        Whether ``out`` may be a file that is there, the scan's own among them.
    seed : int, default 0
        Seed of all random choices.
    threads : int, default 1
        Threads of each task. Workers do as many tasks at a time as they have threads of Dask's: more than 1 is for
        workers with more cores than that.
    **options
        Options of :func:`relievo.complete`, as ``holes="largest"``.

    Returns
    -------
    TiledCompletion

    Raises
    ------
    UsageError
        An option that cannot be, or a tile that is too small for its overlap.
    WriteError
        ``out`` is there already, or cannot be written.
    WorkError
        Nothing can be completed.
    """
    given = checked(client)
    unfit = set(options) & {"output", "report", "threads", "ascii"}
    if unfit:
        raise UsageError(f"{min(unfit)!r} is no option of a completion in tiles: leave it out")
    each = threads_of(threads) or 1
    asked = options | {"tile": tile, "overlap": overlap}
    output: AbstractContextManager[_relievo.Output | None]
    output = nullcontext() if out is None else opened(out, overwrite=overwrite)
    with output as file:
        members, held = arguments_of("complete", {"scan": scan}, asked, seed)
        tiles = _relievo.Tiles(members, held, None)
        with clientele(given) as cluster:
            for together in tiles.rounds():
                with closing(all_of(cluster, _grow, together, tiles.task, each)) as ended:
                    for number, future in ended:
                        grown = future.result()
                        if isinstance(grown, RelievoError):
                            raise grown
                        tiles.put(number, grown)
        done, told, partly = tiles.finish()
        if done is None:
            raise WorkError("relievo has made no scan; please report it")
        if file is not None:
            file.write(done, False)
    return TiledCompletion(Scan._of_held(done), report_of("complete", told, partly, scan), partly)


def _batch(
    paths: Sequence[PathLike],
    out: PathLike,
    pipeline: PathLike | None,
    format: str | None,
    overwrite: bool,
    resume: bool,
    seed: int | None,
    options: dict[str, Any],
) -> _relievo.Batch:
    """What `relievo batch` would do with these arguments."""
    if isinstance(paths, (str, os.PathLike)):
        raise UsageError("paths is a single path; give a list of them")
    words = [f"--out={os.fspath(out)}"]
    words += [] if seed is None else [f"--seed={whole_number('seed', seed)}"]
    words += [] if pipeline is None else [f"--pipeline={os.fspath(pipeline)}"]
    words += [] if format is None else [f"--format={format}"]
    words += ["--overwrite"] if overwrite else []
    words += ["--resume"] if resume else []
    for name, value in options.items():
        if value is not None:
            given = os.fspath(value) if isinstance(value, os.PathLike) else value
            words.append(f"--step=complete.{name}={given if isinstance(given, str) else json_of(given)}")
    return _relievo.Batch([*words, "--", *(os.fspath(path) for path in paths)])


class _MayPass(Exception):
    """A scan failed, and may go well another time; with its line."""


def _work(task: str, threads: int) -> str:
    """One scan, on a worker: the line that `relievo batch` has for it."""
    memory, is_wanted = _from_worker()
    line = _relievo.work_for_batch(task, threads, memory, is_wanted)
    if json.loads(line)["may_pass"]:
        raise _MayPass(line)
    return line


def _from_worker() -> tuple[int | None, Callable[[], bool]]:
    """How much memory a task of this worker may take, and whether the task is still wanted."""
    from distributed import get_worker

    try:
        worker = get_worker()
        key, state = worker.get_current_task(), worker.state
        most = worker.memory_manager.memory_limit
        memory = int(most) // max(1, state.nthreads) if most else None
    except (AttributeError, ValueError):
        # Not on a worker, or of a Dask that tells this in another way.
        return None, lambda: True

    def is_wanted() -> bool:
        task = state.tasks.get(key)
        return getattr(task, "state", None) != "cancelled"

    return memory, is_wanted


def _grow(task: bytes, threads: int) -> bytes | RelievoError:
    """One tile, on a worker; what fails would fail again, and is not tried again."""
    try:
        return _grow_tile(task, threads)
    except RelievoError as error:
        return error


def _line(future: Future[Any]) -> dict[str, Any]:
    """What came of a scan; whatever went wrong with it is told, and stops nothing else."""
    try:
        told = future.result()
    except _MayPass as error:
        told = error.args[0]
    except Exception as error:
        return {"status": "failed", "error": f"{type(error).__name__}: {error}"}
    line: dict[str, Any] = json.loads(told)
    return line


def _outcome(names: tuple[str, str], line: dict[str, Any]) -> Outcome:
    """The outcome that a line of a batch tells."""
    status, error, report = line["status"], line.get("error"), line.get("report")
    return Outcome(
        *names,
        status,
        line.get("seconds", float("nan")),
        {"command": "run", "version": _relievo.version(), "status": status, **report} if report else {},
        None if error is None else in_python(error),
        [in_python(warning) for warning in line.get("warnings", ())],
    )
