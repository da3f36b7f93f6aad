"""Many tasks over processes: here, or on a Dask cluster that is already there.

`run` is the one interface: it gives results as they come, takes what a lost worker was doing up
again, and stops asking when the caller does. A cluster of another kind (a batch queue, Kubernetes)
is reached by starting Dask's scheduler on it, as `dask-jobqueue` and `dask-kubernetes` do, and
naming its address.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator

from imu_lib.errors import InputError

#: How often a task is taken up again whose worker was lost.
RETRIES = 3


def cores() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run(
    function: Callable, tasks: Iterable[tuple], *, workers: int | None = None, address=None
) -> Iterator[tuple[int, object]]:
    """(number of the task, what `function(*task)` gave) as each ends.

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

    Raises
    ------
    InputError
        Where nothing answers at `address`.
    RuntimeError
        Where a task has lost its worker more than RETRIES times.
    """
    if address is not None:
        yield from _on_dask(function, tasks, address)
    elif (workers or cores()) == 1:
        for number, task in enumerate(tasks):
            yield number, function(*task)
    else:
        yield from _here(function, tasks, workers or cores())


def _here(function, tasks, workers):
    from concurrent.futures import FIRST_COMPLETED, wait
    from concurrent.futures.process import BrokenProcessPool

    from joblib.externals.loky import get_reusable_executor

    waiting = deque()  # tasks that a lost worker gives back
    source = enumerate(tasks)
    running, tries = {}, {}

    def submit():
        pool = get_reusable_executor(max_workers=workers, timeout=60)
        while len(running) < workers + 1:  # one more, so that nobody waits for this process
            number, task = waiting.popleft() if waiting else next(source, (None, None))
            if number is None:
                return
            running[pool.submit(function, *task)] = number, task

    submit()
    while running:
        done = wait(running, return_when=FIRST_COMPLETED).done
        for future in done:
            number, task = running.pop(future)
            try:
                result = future.result()
            except BrokenProcessPool:
                tries[number] = tries.get(number, 0) + 1
                if tries[number] > RETRIES:
                    raise RuntimeError(
                        f"task {number} has lost its worker {tries[number]} times"
                    ) from None
                waiting.append((number, task))
                continue
            yield number, result
        if waiting:  # a broken pool: whatever else was running is lost with it
            for _, (number, task) in list(running.items()):
                waiting.append((number, task))
            running.clear()
            get_reusable_executor(max_workers=workers, timeout=60, kill_workers=True)
        submit()


def _on_dask(function, tasks, address):
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise InputError(
            "A Dask cluster needs the package distributed; install imu_lib[cluster]."
        ) from None
    try:
        client = Client(address, timeout="10s")
    except (OSError, ValueError) as error:
        raise InputError(
            f"--scheduler {address}: no Dask scheduler answers ({str(error).splitlines()[0][:90]}); "
            "start one with `dask scheduler` and give the address that it prints."
        ) from None
    with client:
        source = enumerate(tasks)
        threads = max(sum(client.nthreads().values()), 1)
        pending = as_completed()
        numbers = {}

        def submit(count):
            for _ in range(count):
                number, task = next(source, (None, None))
                if number is None:
                    return
                future = client.submit(function, *task, pure=False, retries=RETRIES)
                numbers[future.key] = number
                pending.add(future)

        submit(2 * threads)
        for future in pending:
            yield numbers.pop(future.key), future.result()
            submit(1)


def shared(function: Callable, tasks: list[tuple], workers: int) -> Iterator[object]:
    """Results as they come, this process being one of the workers: for few large tasks, where a
    process that only waits would cost its memory.
    """
    waiting = deque(tasks)
    if workers < 2 or len(waiting) < 2:
        for task in waiting:
            yield function(*task)
        return
    from joblib.externals.loky import get_reusable_executor

    pool = get_reusable_executor(max_workers=workers - 1, timeout=5)
    running = []
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
