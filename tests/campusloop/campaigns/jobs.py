"""Jobs for the tests of campaigns; workers import them."""

import os
import signal
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Deadly:
    """A job that kills its worker as long as `marks` has fewer than `deaths` files."""

    number: int
    marks: Path
    deaths: int = 0


def squared(number: int) -> int:
    return number * number


def failing(number: int) -> int:
    if number == 1:
        raise ValueError(f"job {number} is wrong")
    return number


def number_of(job: Deadly) -> int:
    died = len(list(job.marks.glob(f"{job.number}-*")))
    if died < job.deaths:
        (job.marks / f"{job.number}-{died}").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return job.number


def environment_mark(_: object) -> str | None:
    return os.environ.get("CAMPUSLOOP_TEST_MARK")


def set_mark() -> None:
    os.environ["CAMPUSLOOP_TEST_MARK"] = "prepared"
