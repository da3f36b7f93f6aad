"""Tasks over processes: copies of this one where that is safe, with what it has already made."""

import os
import threading

import pytest

from imu_lib.gap import parallel

MADE = {}


def square(x):
    return x * x, os.getpid(), dict(MADE)


def failing(x):
    raise ValueError(f"no {x}")


def test_copies_have_what_was_made_before_them(monkeypatch):
    monkeypatch.setattr(parallel, "_may_fork", lambda: True)
    monkeypatch.setitem(MADE, "layout", 1)
    found = list(parallel.each(square, [(i,) for i in range(5)], 2))
    assert sorted(f[0] for f in found) == [0, 1, 4, 9, 16]
    assert all(f[1] != os.getpid() and f[2] == {"layout": 1} for f in found)
    with pytest.raises(ValueError, match="no 3"):
        list(parallel.each(failing, [(3,), (3,)], 2))


def test_a_process_with_threads_is_not_copied():
    done = threading.Event()
    other = threading.Thread(target=done.wait)
    other.start()
    try:
        assert not parallel._may_fork()
    finally:
        done.set()
        other.join()
