"""A log that cannot be written stops nothing, and says later what is missing."""

import io
import json

import pytest

from vehicle_agent.runtime.processes.journal import LastingStream


class FullDisk(io.StringIO):
    """Takes nothing while it is full."""

    is_full = False

    def write(self, text: str) -> int:
        if self.is_full:
            raise OSError(28, "No space left on device")
        return super().write(text)


def test_lines_that_cannot_be_written_are_counted_and_told_once_there_is_room() -> None:
    disk = FullDisk()
    journal = LastingStream(disk)
    print("before", file=journal, flush=True)
    disk.is_full = True
    for _ in range(3):
        print("lost", file=journal, flush=True)
    disk.is_full = False
    print("after", file=journal, flush=True)
    before, lost, after = disk.getvalue().splitlines()
    assert (before, after) == ("before", "after")
    assert json.loads(lost)["event"] == "journal.lost"
    assert json.loads(lost)["writes"] >= 3


def test_an_error_that_is_no_failure_of_the_disk_is_not_hidden() -> None:
    journal = LastingStream(io.StringIO())
    with pytest.raises(TypeError):
        journal.write(7)  # type: ignore[arg-type]
