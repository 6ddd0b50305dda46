"""Tasks on a Dask cluster: which client, and how many at a time."""

from __future__ import annotations

import os
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from ._errors import UsageError

if TYPE_CHECKING:
    from distributed import Client, Future

#: How often a task is begun again after an error that may pass, such as a file system that does not answer.
RETRIES = 3

#: Seconds after which workers that have come meanwhile are noticed.
_NOTICED = 1.0


def all_of(
    client: Client,
    function: Callable[[Any, int], Any],
    numbers: Iterable[int],
    argument: Callable[[int], Any],
    threads: int,
) -> Generator[tuple[int, Future[Any]], None, None]:
    """Runs the function on each number's argument, and gives the futures with their numbers as they end.

    Arguments are kept by the scheduler until their task is done, so that they outlive workers. There are as many tasks
    at a time as workers have threads: Dask counts the death of a worker against all tasks that it had been given.
    """
    from distributed import KilledWorker

    at_work: dict[Future[Any], int] = {}
    ended: SimpleQueue[Future[Any]] = SimpleQueue()
    waiting = iter(numbers)
    alone: deque[int] = deque()
    again: set[int] = set()

    def begin(number: int) -> None:
        with warnings.catch_warnings():
            # Dask advises against large arguments, which would be lost with a worker that keeps them.
            warnings.filterwarnings("ignore", "Sending large graph")
            future = client.submit(function, argument(number), threads, pure=False, retries=RETRIES)
        at_work[future] = number
        future.add_done_callback(ended.put)

    def fill() -> None:
        room = max(1, sum(client.nthreads().values()))
        while len(at_work) < room and (number := next(waiting, None)) is not None:
            begin(number)
        if not at_work and alone:
            begin(alone.popleft())

    try:
        fill()
        while at_work:
            try:
                future = ended.get(timeout=_NOTICED)
            except Empty:
                fill()
                continue
            number = at_work.pop(future)
            if number not in again and isinstance(_failure(future), KilledWorker):
                again.add(number)
                alone.append(number)
            else:
                yield number, future
            fill()
    finally:
        if at_work:
            client.cancel(list(at_work))


def _failure(future: Future[Any]) -> BaseException | None:
    return future.exception() if future.status == "error" else None


def checked(client: Client | None) -> Client | None:
    """The client that is given, or the current one, if there is any."""
    try:
        from distributed import Client as AnyClient
    except ImportError:
        raise UsageError("dask is not installed: pip install 'relievo[distributed]'") from None
    if client is None:
        with suppress(ValueError):
            client = AnyClient.current()
    if client is not None and not isinstance(client, AnyClient):
        raise UsageError(f"a {type(client).__name__} is no client; give a dask.distributed.Client")
    if client is not None and client.asynchronous:
        raise UsageError("the client is asynchronous; give one that waits: dask.distributed.Client(asynchronous=False)")
    return client


@contextmanager
def clientele(client: Client | None) -> Iterator[Client]:
    """The client, or workers on this machine for as long as they are needed."""
    if client is not None:
        yield client
        return
    from distributed import Client as NewClient

    # Any port will do: others may have a cluster here, too.
    with NewClient(n_workers=os.cpu_count() or 1, threads_per_worker=1, dashboard_address="127.0.0.1:0") as own:
        yield own
