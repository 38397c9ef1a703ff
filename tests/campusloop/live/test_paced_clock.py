"""The clock of a live campus, with a computer's clock that the tests move by hand."""

import os
from pathlib import Path
from unittest.mock import patch

from campusloop.live.paced_clock import (
    BEHIND_NS_MAX,
    CLOCK_FIELDS,
    JUMP_NS_MAX,
    PERIOD_NS,
    SLACK_NS,
    STALL_TIMEOUT_NS,
    MasterClock,
    PacedClock,
    PacedClocks,
    _fields,
)

MS = 1_000_000


class Campus:
    """A master clock and one process with a paced clock; `computer_ns` is the computer's clock."""

    def __init__(self, folder: Path) -> None:
        self.computer_ns = 1_000 * MS
        self.folder = folder
        PacedClocks(folder).create()
        self.master = MasterClock(_fields(folder / "clock", CLOCK_FIELDS), folder, self.monotonic)
        self.process = self.open("tick")

    def monotonic(self) -> int:
        return self.computer_ns

    def sleep(self, pause_s: float) -> None:
        self.computer_ns += round(pause_s * 1e9)

    def open(self, name: str) -> PacedClock:
        reservation = _fields(self.folder / f"{name}.reservation", 2)
        return PacedClock(_fields(self.folder / "clock", CLOCK_FIELDS), reservation, self.monotonic)

    def reserve(self, name: str, deadline_ns: int, pid: int = 0) -> None:
        """What a process does at the beginning of its wait."""
        reservation = _fields(self.folder / f"{name}.reservation", 2)
        reservation[0], reservation[1] = pid or os.getpid(), deadline_ns


def test_a_clock_without_a_master_is_the_computers(tmp_path: Path) -> None:
    PacedClocks(tmp_path).create()
    clock = PacedClocks(tmp_path).open("server")
    before = clock.now_ns()
    assert clock.lag_ns() == 0
    assert clock.now_ns() >= before


def test_the_clock_runs_with_the_computers_while_all_keep_up(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    for _ in range(100):
        now_ns = campus.process.now_ns()
        campus.reserve("tick", now_ns + PERIOD_NS)
        campus.master.advance_limit(now_ns + PERIOD_NS)
        campus.computer_ns += PERIOD_NS
        assert campus.process.now_ns() == campus.computer_ns
    assert campus.master.lag_ns() == 0


def test_the_clock_stands_for_a_process_that_is_late_and_goes_on_from_there(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    due_ns = campus.process.now_ns() + PERIOD_NS
    campus.reserve("tick", due_ns)
    campus.master.advance_limit(due_ns + PERIOD_NS)
    campus.computer_ns += 500 * MS
    campus.master.advance_limit(due_ns + PERIOD_NS)
    assert campus.process.now_ns() == due_ns + SLACK_NS
    campus.reserve("tick", due_ns + PERIOD_NS)
    campus.master.advance_limit(due_ns + PERIOD_NS)
    assert campus.process.now_ns() == due_ns + SLACK_NS
    campus.computer_ns += 2 * MS
    assert campus.process.now_ns() == due_ns + SLACK_NS + 2 * MS
    assert campus.master.lag_ns() == campus.computer_ns - campus.process.now_ns()


def test_the_clock_stands_while_the_master_gets_no_time(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    due_ns = campus.process.now_ns() + PERIOD_NS
    campus.master.advance_limit(due_ns)
    campus.computer_ns += 10_000 * MS
    assert campus.process.now_ns() == due_ns + SLACK_NS


def test_the_clock_never_goes_back(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    stamps_ns = []
    for pause_ms in (1, 80, 3, 200, 19, 0, 45):
        now_ns = campus.process.now_ns()
        campus.reserve("tick", now_ns + PERIOD_NS)
        campus.master.advance_limit(now_ns + PERIOD_NS)
        stamps_ns.append(campus.process.now_ns())
        campus.computer_ns += pause_ms * MS
        stamps_ns.append(campus.process.now_ns())
    assert stamps_ns == sorted(stamps_ns)


def test_a_process_that_has_ended_is_not_waited_for(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    gone = os.fork()
    if gone == 0:
        os._exit(0)
    os.waitpid(gone, 0)
    begun_ns = campus.process.now_ns()
    campus.reserve("tick", begun_ns - PERIOD_NS, gone)
    campus.master.advance_limit(begun_ns + 5 * PERIOD_NS)
    campus.computer_ns += 5 * PERIOD_NS
    assert campus.process.now_ns() == begun_ns + 5 * PERIOD_NS


def test_a_process_that_hangs_is_waited_for_so_long_and_no_longer(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    begun_ns = campus.process.now_ns()
    campus.reserve("tick", begun_ns)
    for _ in range(3):
        campus.master.advance_limit(begun_ns + 10 * PERIOD_NS)
        campus.computer_ns += STALL_TIMEOUT_NS - MS
        assert campus.process.now_ns() <= begun_ns + SLACK_NS
    campus.master.advance_limit(begun_ns + 10 * PERIOD_NS)
    campus.computer_ns += 10 * PERIOD_NS
    assert campus.process.now_ns() > begun_ns + SLACK_NS


def test_a_process_that_never_waits_is_not_waited_for(tmp_path: Path) -> None:
    """The server and the link only read the clock."""
    campus = Campus(tmp_path)
    campus.open("link")
    begun_ns = campus.process.now_ns()
    campus.master.advance_limit(begun_ns + PERIOD_NS)
    campus.computer_ns += PERIOD_NS
    assert campus.process.now_ns() == begun_ns + PERIOD_NS


def test_waiting_reserves_one_period_at_most(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    read, write = os.pipe()
    os.write(write, b"mail")
    now_ns = campus.process.now_ns()
    campus.process.wait(now_ns + 100 * PERIOD_NS, (read,))
    assert _fields(tmp_path / "tick.reservation", 2)[1] == now_ns + PERIOD_NS
    os.close(read)
    os.close(write)


def test_a_master_that_starts_again_goes_on_from_where_the_clock_stood(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    due_ns = campus.process.now_ns() + PERIOD_NS
    campus.master.advance_limit(due_ns)
    campus.computer_ns += 3_000 * MS
    again = MasterClock(_fields(tmp_path / "clock", CLOCK_FIELDS), tmp_path, campus.monotonic)
    again.advance_limit(due_ns + 2 * PERIOD_NS)
    assert campus.process.now_ns() == due_ns + SLACK_NS


def test_a_process_that_ends_in_order_is_not_waited_for(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    begun_ns = campus.process.now_ns()
    campus.reserve("tick", begun_ns)
    campus.process.close()
    campus.master.advance_limit(begun_ns + PERIOD_NS)
    campus.computer_ns += PERIOD_NS
    assert campus.process.now_ns() == begun_ns + PERIOD_NS


def test_the_clock_goes_on_while_a_process_works_until_its_work_is_due(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    begin_ns = campus.process.now_ns()
    campus.reserve("tick", begin_ns + PERIOD_NS)
    campus.process.work(begin_ns + 2 * PERIOD_NS)
    for step in range(1, 6):
        campus.master.advance_limit(begin_ns + step * PERIOD_NS)
        campus.computer_ns += PERIOD_NS
    assert campus.process.now_ns() == begin_ns + 2 * PERIOD_NS + SLACK_NS
    campus.reserve("tick", begin_ns + 6 * PERIOD_NS)
    campus.master.advance_limit(begin_ns + 6 * PERIOD_NS)
    campus.computer_ns += PERIOD_NS
    assert campus.process.now_ns() > begin_ns + 2 * PERIOD_NS + SLACK_NS


def wait_until(campus: Campus, due_ns: int) -> None:
    """The master waits, and the process beside it; they sleep by moving the computer's clock."""
    while campus.process.now_ns() < due_ns:
        campus.reserve("tick", campus.process.now_ns() + PERIOD_NS)
        with patch("time.sleep", campus.sleep):
            campus.master.wait(min(due_ns, campus.process.now_ns() + PERIOD_NS))


def stand(campus: Campus, span_ns: int) -> None:
    """The simulator takes so long for one step, and the clock stands meanwhile."""
    due_ns = campus.process.now_ns() + PERIOD_NS
    campus.reserve("tick", due_ns)
    campus.master.advance_limit(due_ns)
    campus.computer_ns += span_ns + PERIOD_NS + SLACK_NS
    assert campus.process.now_ns() == due_ns + SLACK_NS
    campus.master.advance_limit(due_ns + PERIOD_NS)


def test_short_stands_are_made_up(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    for _ in range(20):
        stand(campus, 12 * MS)
        assert campus.master.lag_ns() >= 12 * MS
        wait_until(campus, campus.process.now_ns() + 4 * PERIOD_NS)
        assert campus.master.lag_ns() == 0


def test_what_is_made_up_is_no_more_than_twice_the_speed(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    stand(campus, 300 * MS)
    begin_ns, computer_ns = campus.process.now_ns(), campus.computer_ns
    wait_until(campus, begin_ns + 100 * MS)
    assert 1.8 < (campus.process.now_ns() - begin_ns) / (campus.computer_ns - computer_ns) <= 2.1


def test_a_long_stand_is_not_made_up(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    stand(campus, 60_000 * MS)
    wait_until(campus, campus.process.now_ns() + 3_000 * MS)
    assert 60_000 * MS - BEHIND_NS_MAX <= campus.master.lag_ns() <= 60_000 * MS - BEHIND_NS_MAX + JUMP_NS_MAX


def test_a_clock_that_makes_up_waits_for_the_earliest_deadline(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    stand(campus, 300 * MS)
    due_ns = campus.process.now_ns() + PERIOD_NS
    campus.reserve("tick", due_ns)
    with patch("time.sleep", campus.sleep):
        campus.master.wait(due_ns + SLACK_NS)
    campus.computer_ns += 100 * MS
    assert campus.process.now_ns() == due_ns + SLACK_NS


def test_a_process_sleeps_half_as_long_while_the_clock_makes_up(tmp_path: Path) -> None:
    campus = Campus(tmp_path)
    assert campus.process.pause_s(PERIOD_NS) == 0.02
    stand(campus, 300 * MS)
    wait_until(campus, campus.process.now_ns() + PERIOD_NS)
    assert campus.process.pause_s(PERIOD_NS) == 0.01
    wait_until(campus, campus.process.now_ns() + 1_000 * MS)
    assert campus.process.pause_s(PERIOD_NS) == 0.02
