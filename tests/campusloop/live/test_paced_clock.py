"""The clock of a live campus, with a computer's clock that the tests move by hand."""

import os
from pathlib import Path

from campusloop.live.paced_clock import (
    BEAT_NS,
    PATIENCE_NS,
    SLACK_NS,
    KeptClock,
    PacedClock,
    PacedClocks,
    _fields,
)

MS = 1_000_000


class Campus:
    """A kept clock and one process that lives by it; `computer_ns` is the computer's clock."""

    def __init__(self, folder: Path) -> None:
        self.computer_ns = 1_000 * MS
        self.folder = folder
        PacedClocks(folder).make()
        self.keeper = KeptClock(_fields(folder / "clock", 3), folder, self.monotonic)
        self.process = self.open("tick")

    def monotonic(self) -> int:
        return self.computer_ns

    def open(self, name: str) -> PacedClock:
        beat = _fields(self.folder / f"{name}.beat", 2)
        return PacedClock(_fields(self.folder / "clock", 3), beat, self.monotonic)

    def promise(self, name: str, due_ns: int, pid: int = 0) -> None:
        """What a process does at the beginning of its wait."""
        beat = _fields(self.folder / f"{name}.beat", 2)
        beat[0], beat[1] = pid or os.getpid(), due_ns


def test_a_clock_that_nobody_keeps_is_the_computers(tmp_path: Path) -> None:
    PacedClocks(tmp_path).make()
    clock = PacedClocks(tmp_path).open("server")
    before = clock.now_ns()
    assert clock.held_ns() == 0
    assert clock.now_ns() >= before


def test_the_clock_runs_with_the_computers_while_all_keep_up(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    for _ in range(100):
        now_ns = campus.process.now_ns()
        campus.promise("tick", now_ns + BEAT_NS)
        campus.keeper.let_run(now_ns + BEAT_NS)
        campus.computer_ns += BEAT_NS
        assert campus.process.now_ns() == campus.computer_ns
    assert campus.keeper.held_ns() == 0


def test_the_clock_stands_for_a_process_that_is_late_and_goes_on_from_there(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    due_ns = campus.process.now_ns() + BEAT_NS
    campus.promise("tick", due_ns)
    campus.keeper.let_run(due_ns + BEAT_NS)
    campus.computer_ns += 500 * MS
    campus.keeper.let_run(due_ns + BEAT_NS)
    assert campus.process.now_ns() == due_ns + SLACK_NS
    campus.promise("tick", due_ns + BEAT_NS)
    campus.keeper.let_run(due_ns + BEAT_NS)
    assert campus.process.now_ns() == due_ns + SLACK_NS
    campus.computer_ns += 2 * MS
    assert campus.process.now_ns() == due_ns + SLACK_NS + 2 * MS
    assert campus.keeper.held_ns() == campus.computer_ns - campus.process.now_ns()


def test_the_clock_stands_while_the_keeper_gets_no_time(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    due_ns = campus.process.now_ns() + BEAT_NS
    campus.keeper.let_run(due_ns)
    campus.computer_ns += 10_000 * MS
    assert campus.process.now_ns() == due_ns + SLACK_NS


def test_the_clock_never_goes_back(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    told = []
    for pause_ms in (1, 80, 3, 200, 19, 0, 45):
        now_ns = campus.process.now_ns()
        campus.promise("tick", now_ns + BEAT_NS)
        campus.keeper.let_run(now_ns + BEAT_NS)
        told.append(campus.process.now_ns())
        campus.computer_ns += pause_ms * MS
        told.append(campus.process.now_ns())
    assert told == sorted(told)


def test_a_process_that_has_ended_is_not_waited_for(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    gone = os.fork()
    if gone == 0:
        os._exit(0)
    os.waitpid(gone, 0)
    begun_ns = campus.process.now_ns()
    campus.promise("tick", begun_ns - BEAT_NS, gone)
    campus.keeper.let_run(begun_ns + 5 * BEAT_NS)
    campus.computer_ns += 5 * BEAT_NS
    assert campus.process.now_ns() == begun_ns + 5 * BEAT_NS


def test_a_process_that_hangs_is_waited_for_so_long_and_no_longer(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    begun_ns = campus.process.now_ns()
    campus.promise("tick", begun_ns)
    for _ in range(3):
        campus.keeper.let_run(begun_ns + 10 * BEAT_NS)
        campus.computer_ns += PATIENCE_NS - MS
        assert campus.process.now_ns() <= begun_ns + SLACK_NS
    campus.keeper.let_run(begun_ns + 10 * BEAT_NS)
    campus.computer_ns += 10 * BEAT_NS
    assert campus.process.now_ns() > begun_ns + SLACK_NS


def test_a_process_that_never_waits_is_not_waited_for(tmp_path: Path) -> None:
    """The server and the link only read the clock."""
    campus = Campus(tmp_path)
    campus.open("link")
    begun_ns = campus.process.now_ns()
    campus.keeper.let_run(begun_ns + BEAT_NS)
    campus.computer_ns += BEAT_NS
    assert campus.process.now_ns() == begun_ns + BEAT_NS


def test_waiting_promises_a_beat_at_most(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    read, write = os.pipe()
    os.write(write, b"mail")
    now_ns = campus.process.now_ns()
    campus.process.wait(now_ns + 100 * BEAT_NS, (read,))
    assert _fields(tmp_path / "tick.beat", 2)[1] == now_ns + BEAT_NS
    os.close(read)
    os.close(write)


def test_a_keeper_that_starts_again_goes_on_from_where_the_clock_stood(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    due_ns = campus.process.now_ns() + BEAT_NS
    campus.keeper.let_run(due_ns)
    campus.computer_ns += 3_000 * MS
    again = KeptClock(_fields(tmp_path / "clock", 3), tmp_path, campus.monotonic)
    again.let_run(due_ns + 2 * BEAT_NS)
    assert campus.process.now_ns() == due_ns + SLACK_NS


def test_a_process_that_ends_in_order_is_not_waited_for(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    begun_ns = campus.process.now_ns()
    campus.promise("tick", begun_ns)
    campus.process.close()
    campus.keeper.let_run(begun_ns + BEAT_NS)
    campus.computer_ns += BEAT_NS
    assert campus.process.now_ns() == begun_ns + BEAT_NS
