"""Sweeps on dask.distributed: a killed worker loses nothing, and two processes build the same kernels at once."""

import os
import signal
import threading
import time

from distributed import LocalCluster
from run_folders import entries, pixels

from swimlab.sweep.engine import ANY_PORT

SWEEP = """
version = 1
name = "killed"
sequences = ["road-shift"]
techniques = ["pixel-point"]
frames = "0-7"
size = [96, 54]
samples = 400
chunk = 4
"""


def kill_one_at_work(out, killed, finished):
    """Kill the first process seen in the midst of a chunk of which it has written a frame."""
    while not killed and not finished.is_set():
        for frame in out.glob("chunks/*/.*.tmp/reference/0*.exr"):
            folder = frame.parent.parent
            os.kill(int(folder.name.split(".")[-2]), signal.SIGKILL)
            killed.append(folder)
            return
        time.sleep(0.002)


def test_a_killed_worker_loses_nothing(swimlab, tmp_path):
    """One of two is killed by SIGKILL in the midst of a chunk: pixels and scores are those of one process."""
    (tmp_path / "sweep.toml").write_text(SWEEP, encoding="utf-8")
    assert swimlab("sweep", "sweep.toml", "-o", "local", "-q")[0] == 0
    killed, finished = [], threading.Event()
    killer = threading.Thread(target=kill_one_at_work, args=(tmp_path / "cluster", killed, finished))
    with LocalCluster(n_workers=2, threads_per_worker=1, memory_limit=0, dashboard_address=ANY_PORT) as cluster:
        killer.start()
        words = ("--engine", "dask", "--scheduler", cluster.scheduler_address, "--threads", "1")
        code, _, err = swimlab("sweep", "sweep.toml", "-o", "cluster", "-q", *words)
        finished.set()
        killer.join()
    assert code == 0, err
    assert len(killed) == 1
    assert not (tmp_path / "cluster" / "failures").exists()
    assert not list((tmp_path / "cluster").rglob("*.tmp"))
    for folder in ("chunks", "runs"):
        assert pixels(tmp_path / "local" / folder) == pixels(tmp_path / "cluster" / folder)
    assert entries(tmp_path / "local" / "scores.json") == entries(tmp_path / "cluster" / "scores.json")
