"""Tasks one after the other, or over processes as they are done."""

from __future__ import annotations

from joblib import Parallel, delayed


def each(function, work, jobs: int):
    """Results of `function(*args)` for the tuples of `work`, in the order in which they are done."""
    if jobs == 1 or len(work) == 1:
        for args in work:
            yield function(*args)
        return
    yield from Parallel(n_jobs=jobs, return_as="generator_unordered", max_nbytes="2M")(
        delayed(function)(*args) for args in work
    )
