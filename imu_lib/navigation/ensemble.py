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
    tasks = [(task, generator, number) for number, generator in enumerate(generators)]
    with tqdm(total=count, disable=not progress, leave=False) as bar:
        if backend == "threading":
            return _on_threads(tasks, workers, bar)
        return scheduler.every(
            _one,
            tasks,
            workers=1 if backend == "sequential" else workers,
            address=_address(client) if backend == "dask" else None,
            progress=lambda _: bar.update(1),
        )


def _on_threads(tasks, workers, bar):
    out = []
    with parallel_config(backend="threading", n_jobs=workers):
        for result in Parallel(return_as="generator")(delayed(_one)(*t) for t in tasks):
            out.append(result)
            bar.update(1)
    return out


def _address(client):
    from distributed import get_client

    return (client or get_client()).scheduler.address


def _one(task, generator, number):
    return task(generator, number)
