"""A process of a pool ends with the process that made it, even if that is killed."""

import subprocess
import sys
import time
from pathlib import Path

import psutil

ROOT = Path(__file__).resolve().parents[3]
GONE_WITHIN_S = 20.0
# Two workers that wait for work: their pool's maker says who they are, and waits too.
MAKER = """
import os, sys, time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from server.supervision.parent_end import end_with_parent

if __name__ == "__main__":
    pool = ProcessPoolExecutor(2, get_context("spawn"), end_with_parent)
    print(*{pool.submit(os.getpid).result() for _ in range(20)}, flush=True)
    time.sleep(600)
"""


def test_workers_that_wait_for_work_end_when_their_maker_is_killed(tmp_path: Path) -> None:
    program = tmp_path / "maker.py"
    program.write_text(MAKER)
    maker = subprocess.Popen(
        [sys.executable, str(program)],
        cwd=ROOT,
        env={"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin"},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert maker.stdout is not None
    workers = [psutil.Process(int(pid)) for pid in maker.stdout.readline().split()]
    assert workers
    assert all(worker.is_running() for worker in workers)
    maker.kill()
    maker.wait()
    maker.stdout.close()
    until_s = time.monotonic() + GONE_WITHIN_S
    while any(_works(worker) for worker in workers) and time.monotonic() < until_s:
        time.sleep(0.05)
    assert not [worker.pid for worker in workers if _works(worker)]


def _works(worker: psutil.Process) -> bool:
    try:
        return worker.is_running() and worker.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False
