"""A fleet on a Dask cluster of processes: kill -9 of its scheduler."""

import json
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from imu_lib import InputError, fleet
from imu_lib.model import Model
from imu_lib.writers import write_record

MODEL = Model.from_json({"gyro_x": [{"process": "white_noise", "N": 1e-4}]})
distributed = pytest.importorskip("distributed")


@pytest.fixture
def cluster(tmp_path):
    """(address, scheduler's process) of a scheduler with one worker."""
    told = tmp_path / "scheduler.json"
    call = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard"]
    quiet = {"stderr": subprocess.DEVNULL, "stdout": subprocess.DEVNULL}
    scheduler = subprocess.Popen([*call, "--scheduler-file", str(told)], **quiet)
    call = [sys.executable, "-m", "distributed.cli.dask_worker", "--scheduler-file", str(told)]
    more = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--death-timeout", "60"]
    worker = subprocess.Popen([*call, *more], **quiet)
    try:
        for _ in range(600):
            if told.exists() and told.stat().st_size:
                break
            time.sleep(0.1)
        yield json.loads(told.read_text())["address"], scheduler
    finally:
        for process in (worker, scheduler):
            process.kill()
            process.wait()


@pytest.mark.skipif(sys.platform != "linux", reason="Windows has no kill -9")
def test_the_scheduler_is_killed_and_nothing_is_lost(cluster, tmp_path):
    """One sentence, and the table of a quiet run when the command is given again."""
    address, scheduler = cluster
    (tmp_path / "records").mkdir()
    for unit in range(5):
        record = MODEL.simulate_record(1000, 50.0, np.random.default_rng(unit))
        write_record(record, tmp_path / "records" / f"unit{unit}.npz")
    entries, out = fleet.entries(tmp_path / "records"), tmp_path / "out"
    ended = []

    def kill(entry, rows):
        ended.append(entry.file)
        if len(ended) == 2:
            scheduler.send_signal(signal.SIGKILL)

    with pytest.raises(InputError, match="is gone; what has ended until now is kept"):
        fleet.characterise(entries, out, address=address, progress=kill)
    before = {p: p.stat().st_mtime_ns for p in out.glob("records/*.json")}
    assert 2 <= len(before) < 5
    again = []
    table = fleet.characterise(
        entries, out, workers=1, progress=lambda entry, rows: again.append(entry.file)
    )
    assert not set(ended) & set(again) and len(again) == 5 - len(before)
    assert all(p.stat().st_mtime_ns == moment for p, moment in before.items())
    assert (
        table.read_bytes()
        == fleet.characterise(entries, tmp_path / "quiet", workers=1).read_bytes()
    )


def test_a_cluster_without_workers_is_said(monkeypatch, caplog):
    """And the work goes on as soon as one comes."""
    from imu_lib import scheduler

    monkeypatch.setattr(scheduler, "PATIENCE", 0.2)
    quiet = {"processes": False, "dashboard_address": ":0"}
    with distributed.LocalCluster(n_workers=0, threads_per_worker=1, **quiet) as cluster:

        def come():
            while "No worker" not in caplog.text:
                time.sleep(0.05)
            cluster.scale(1)

        threading.Thread(target=come, daemon=True).start()
        found = scheduler.run(abs, [(-1,), (-2,)], address=cluster.scheduler_address)
        assert sorted(found) == [(0, 1), (1, 2)]
    assert "No worker of the Dask scheduler" in caplog.text and "`dask worker " in caplog.text
