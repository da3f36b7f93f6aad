"""Many drives at once: one call, over this machine's cores or over a Dask cluster."""

import numpy as np
from joblib import Parallel, delayed, parallel_config
from tqdm import tqdm

from imu_lib import scheduler


def monte_carlo(task, count, *, seed, backend="loky", workers=2, client=None, progress=False):
    """Run `task(rng, number)` for number 0 .. count-1, each with a generator of its own, and
    return the list of results in order.

    The generators are spawned from `seed`, so that the results do not depend on the backend, the
    workers or the order. What a worker that dies was doing is taken up again (`scheduler.run`).

    task : a function that can be pickled; count : int; seed : int
    backend : "loky" (processes), "threading", "sequential" or "dask"; workers : of the first two
    client : distributed.Client; "dask" uses it, or the current one
    progress : show a bar on standard error, which moves as each run ends, on a cluster too
    """
    if count < 1:
        raise ValueError(f"`count` must be at least 1, not {count}")
    generators = np.random.default_rng(seed).spawn(count)
    bar = tqdm(total=count, disable=not progress, leave=False)
    out = [None] * count
    with bar:
        for number, result in _ended(task, generators, backend, workers, client):
            if isinstance(result, scheduler.Lost):
                raise RuntimeError(
                    f"run {number} of {count} has ended every process that took it up"
                )
            out[number] = result
            bar.update(1)
    return out


def _ended(task, generators, backend, workers, client):
    """(number, result) of each run as it ends."""
    tasks = [(task, generator, number) for number, generator in enumerate(generators)]
    if backend == "threading":
        with parallel_config(backend=backend, n_jobs=workers):
            yield from enumerate(Parallel(return_as="generator")(delayed(_one)(*t) for t in tasks))
        return
    address = None
    if backend == "dask":
        from distributed import get_client

        address = (client or get_client()).scheduler.address
    yield from scheduler.run(
        _one, tasks, workers=1 if backend == "sequential" else workers, address=address
    )


def _one(task, generator, number):
    return task(generator, number)
