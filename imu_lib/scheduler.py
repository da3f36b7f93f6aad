"""Many tasks over processes: here, or on a Dask cluster that is already there.

`run` is the one interface: it gives results as they come, takes what a lost worker was doing up
again, and stops asking when the caller does. A cluster of another kind (a batch queue, Kubernetes)
is reached by starting Dask's scheduler on it, as `dask-jobqueue` and `dask-kubernetes` do, and
naming its address.
"""

from __future__ import annotations

import asyncio
import logging
import os
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import TypeVar

from imu_lib.errors import InputError

T = TypeVar("T")
_LOG = logging.getLogger(__name__)

#: How often a task is taken up again whose worker was lost.
RETRIES = 3
#: Seconds without a result after which a cluster is asked whether it has workers, and between two
#: sentences that it has none.
PATIENCE, AGAIN = 10.0, 600.0
#: Workers are as many as there are processors: their libraries need no threads.
_ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in ("OPENBLAS", "MKL", "OMP")}


def cores() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class Lost:
    """The result of a task that ended every worker that took it up."""


def run(
    function: Callable,
    tasks: Iterable[tuple],
    *,
    workers: int | None = None,
    address: str | None = None,
    apart: bool = False,
) -> Iterator[tuple[int, object]]:
    """(number of the task, what `function(*task)` gave) as each ends, `Lost()` where nothing did.

    Parameters
    ----------
    function : callable
        Of a module, so that a process can be told its name.
    tasks : iterable of tuple
        Asked for as workers become free.
    workers : int, optional
        Processes here; default one per core. With 1 the tasks run in this process.
    address : str, optional
        Of a Dask scheduler, as in tcp://host:8786; `workers` is then its affair.
    apart : bool
        In a process of its own even with one worker: what ends it does not end the caller.

    Raises
    ------
    InputError
        Where nothing answers at `address`.
    """
    workers = workers or cores()
    if address is not None:
        yield from _on_dask(function, tasks, address)
    elif workers == 1 and not apart:
        for number, task in enumerate(tasks):
            yield number, function(*task)
    else:
        yield from _Here(function, tasks, workers)


def every(function: Callable, tasks: Iterable[tuple], *, progress=None, **options) -> list:
    """What `function(*task)` gives of every task, in the tasks' order.

    Parameters
    ----------
    function, tasks, options
        As for `run`.
    progress : callable, optional
        Called with the number of each task as it ends.

    Raises
    ------
    RuntimeError
        Where a task has ended every process that took it up.
    """
    found = {}
    for number, result in run(function, tasks, **options):
        if isinstance(result, Lost):
            raise RuntimeError(f"task {number} has ended every process that took it up")
        found[number] = result
        if progress is not None:
            progress(number)
    return [found[number] for number in sorted(found)]


class _Here:
    """Tasks over processes of this machine. A worker that dies takes the pool with it: what was
    running is taken up again, and what was running twice when that happened goes alone.
    """

    def __init__(self, function, tasks, workers):
        self.function, self.source, self.workers = function, enumerate(tasks), workers
        self.again, self.alone = deque(), deque()
        self.running, self.deaths = {}, {}

    def _pool(self, renew=False):
        from joblib.externals.loky import get_reusable_executor

        return get_reusable_executor(
            max_workers=self.workers, timeout=60, env=_ONE_THREAD, kill_workers=renew
        )

    def _fill(self):
        from concurrent.futures.process import BrokenProcessPool

        while len(self.running) < self.workers + 1:  # one more, so that nobody waits for us
            if self.again:
                number, task = self.again.popleft()
            else:
                number, task = next(self.source, (None, None))
                if number is None:
                    break
            try:
                self.running[self._pool().submit(self.function, *task)] = number, task
            except BrokenProcessPool:
                self.again.appendleft((number, task))
                self._pool(renew=True)
        if self.alone and not self.running:
            number, task = self.alone.popleft()
            self.running[self._pool(renew=True).submit(self.function, *task)] = number, task

    def __iter__(self):
        try:
            yield from self._results()
        finally:
            _ended(self._pool(), list(self.running))

    def _results(self):
        from concurrent.futures import FIRST_COMPLETED, wait
        from concurrent.futures.process import BrokenProcessPool

        self._fill()
        while self.running:
            dead = []
            for future in wait(self.running, return_when=FIRST_COMPLETED).done:
                number, task = self.running.pop(future)
                try:
                    result = future.result()
                except BrokenProcessPool:
                    dead.append((number, task))
                    continue
                yield number, result
            if dead:
                yield from self._buried(dead)
            self._fill()

    def _buried(self, dead):
        dead += self.running.values()
        self.running.clear()
        self._pool(renew=True)
        for number, task in sorted(dead, key=lambda d: d[0]):
            self.deaths[number] = self.deaths.get(number, 0) + 1
            if self.deaths[number] > RETRIES:
                yield number, Lost()
            elif self.deaths[number] > 1:
                self.alone.append((number, task))
            else:
                self.again.append((number, task))


def _on_dask(function, tasks, address):
    from concurrent import futures

    try:
        from distributed import Client
        from distributed.comm import CommClosedError
    except ImportError:
        raise InputError(
            "A Dask cluster needs the package distributed; install imu_lib[cluster]."
        ) from None
    try:
        client = Client(address, timeout="10s")
    except (OSError, ValueError) as error:
        raise InputError(
            f"--scheduler {address}: no Dask scheduler answers "
            f"({str(error).splitlines()[0][:90]}); start one with `dask scheduler` and give the "
            "address that it prints."
        ) from None
    # a scheduler that goes away is told in one sentence below
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    with client:
        threads = max(sum(client.nthreads().values()), 1)
        try:
            yield from _submitted(client, function, enumerate(tasks), 2 * threads, address)
        except (futures.CancelledError, asyncio.CancelledError, CommClosedError):
            raise InputError(
                f"The Dask scheduler at {address} is gone; what has ended until now is kept. Start "
                "it again and give the same command with its address: it goes on from there."
            ) from None


def _submitted(client, function, source, count, address):
    """Results of a cluster's workers, `count` tasks with them at a time."""
    import queue

    from distributed import KilledWorker

    ended, numbers = queue.SimpleQueue(), {}

    def submit(count):
        for number, task in islice(source, count):
            future = client.submit(function, *task, pure=False, retries=RETRIES)
            numbers[future] = number
            future.add_done_callback(ended.put)

    submit(count)
    while numbers:
        future = _next(ended, client, address)
        number = numbers.pop(future)
        try:
            result = future.result()
        except KilledWorker:
            result = Lost()
        yield number, result
        submit(1)


def _next(ended, client, address):
    """The next future that ends; while no worker is there, that is said now and then."""
    import queue

    said = None
    while True:
        try:
            return ended.get(timeout=PATIENCE)
        except queue.Empty:
            if client.status != "running":
                raise asyncio.CancelledError from None
        try:
            threads = client.nthreads()
        except OSError:  # the scheduler does not answer any more
            raise asyncio.CancelledError from None
        if threads:
            said = None
        elif said is None or time.monotonic() - said > AGAIN:
            said = time.monotonic()
            _LOG.warning(
                "No worker of the Dask scheduler at %s is there; waiting for one (`dask worker %s` "
                "starts one). Ctrl-C ends this; what has ended is kept.",
                address,
                address,
            )


def shared(function: Callable[..., T], tasks: list[tuple], workers: int) -> Iterator[T]:
    """Results as they come, this process being one of the workers: for few large tasks, where a
    process that only waits would cost its memory.
    """
    waiting = deque(tasks)
    if workers < 2 or len(waiting) < 2:
        for task in waiting:
            yield function(*task)
        return
    from joblib.externals.loky import get_reusable_executor

    pool = get_reusable_executor(max_workers=workers - 1, timeout=5, env=_ONE_THREAD)
    running = []
    try:
        while waiting or running:
            while waiting and len(running) < min(2 * (workers - 1), len(waiting)):
                running.append(pool.submit(function, *waiting.pop()))
            if waiting:
                yield function(*waiting.popleft())
            elif running:
                yield running.pop(0).result()
            for future in [f for f in running if f.done()]:
                running.remove(future)
                yield future.result()
    finally:
        _ended(pool, running)


def _ended(pool, running):
    """Give the processes back: joblib's own pool, which others use, is no heir of this one."""
    for future in running:
        future.cancel()
    pool.shutdown(wait=True, kill_workers=bool(running))
