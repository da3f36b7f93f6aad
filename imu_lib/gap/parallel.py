"""Tasks one after the other, or over processes as they are done."""

from __future__ import annotations

import multiprocessing
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import Any


def each(function: Callable[..., Any], work: list[tuple[Any, ...]], jobs: int) -> Iterator[Any]:
    """Results of `function(*args)` for the tuples of `work`, in the order in which they are
    done.
    """
    if jobs == 1 or len(work) == 1:
        for args in work:
            yield function(*args)
    elif _may_fork():
        yield from _forked(function, work, jobs)
    else:
        from joblib import Parallel, delayed

        yield from Parallel(n_jobs=jobs, return_as="generator_unordered", max_nbytes="2M")(
            delayed(function)(*args) for args in work
        )


def _may_fork() -> bool:
    """Whether a copy of this process is safe: no other thread may hold a lock in it. A copy has
    imported and compiled what it needs, which takes a new process as long as a short record does.
    """
    return sys.platform == "linux" and threading.active_count() == 1


def _forked(function: Callable[..., Any], work: list[tuple[Any, ...]], jobs: int) -> Iterator[Any]:
    context = multiprocessing.get_context("fork")
    with ProcessPoolExecutor(min(jobs, len(work)), mp_context=context) as pool:
        futures = [pool.submit(function, *args) for args in work]
        try:
            for future in as_completed(futures):
                yield future.result()
        finally:  # nothing is begun for a caller that has gone
            for future in futures:
                future.cancel()
