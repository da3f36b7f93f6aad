"""Many drives at once: one call, over this machine's cores with joblib or over a Dask cluster."""

import numpy as np
from joblib import Parallel, delayed, parallel_config
from tqdm import tqdm


def monte_carlo(task, count, *, seed, backend="loky", workers=2, client=None, progress=False):
    """Run `task(rng, number)` for number 0 .. count-1, each with a generator of its own, and
    return the list of results in order.

    The generators are spawned from `seed`, so that the results do not depend on the backend, the
    workers or the order.

    task : a function that can be pickled; count : int; seed : int
    backend : "loky" (processes), "threading", "sequential" or "dask"; workers : of the first two
    client : distributed.Client; "dask" uses it, or the current one
    progress : show a bar on standard error
    """
    if count < 1:
        raise ValueError(f"`count` must be at least 1, not {count}")
    generators = np.random.default_rng(seed).spawn(count)
    options = {"n_jobs": workers}
    if backend == "dask":
        from distributed import get_client

        client = client or get_client()
        options = {"wait_for_workers_timeout": 60}
    with parallel_config(backend=backend, **options):
        # Dask hands results back all at once, the others one by one
        how = "list" if backend == "dask" else "generator"
        jobs = (delayed(task)(generator, number) for number, generator in enumerate(generators))
        return list(
            tqdm(Parallel(return_as=how)(jobs), total=count, disable=not progress, leave=False)
        )
