"""The clock of a vehicle's processes, and the beat that is kept by it."""

import os
import pickle
import time
from collections.abc import Sequence

from vehicle_agent.runtime.processes.clock import MONOTONIC
from vehicle_agent.runtime.processes.pacing import Pacer
from vehicle_agent.signals.rates import TICK_NS


class SteppedClock:
    """Goes on by `pauses_ns` at each wait, whatever was waited for."""

    def __init__(self, *pauses_ns: int) -> None:
        self.stamp_ns = 0
        self._pauses_ns = list(pauses_ns)

    def now_ns(self) -> int:
        return self.stamp_ns

    def utc_offset_ns(self) -> int:
        return 0

    def wait(self, due_ns: int, files: Sequence[int] = ()) -> None:
        self.stamp_ns += self._pauses_ns.pop(0)

    def close(self) -> None: ...


def test_the_computers_clock_goes_to_another_process_as_it_is() -> None:
    assert pickle.loads(pickle.dumps(MONOTONIC)).open("gate") == MONOTONIC


def test_the_computers_clock_waits_until_the_moment_or_for_a_file() -> None:
    due_ns = time.monotonic_ns() + 5_000_000
    MONOTONIC.wait(due_ns)
    assert MONOTONIC.now_ns() >= due_ns
    read, write = os.pipe()
    os.write(write, b"mail")
    far_ns = MONOTONIC.now_ns() + 10**12
    MONOTONIC.wait(far_ns, (read,))
    assert MONOTONIC.now_ns() < far_ns
    os.close(read)
    os.close(write)


def test_a_beat_waits_on_through_a_clock_that_comes_back_early() -> None:
    pacer = Pacer(SteppedClock(TICK_NS // 2, TICK_NS // 4, TICK_NS))
    assert pacer.wait() == TICK_NS // 2 + TICK_NS // 4 + TICK_NS
    assert pacer.late_ns == 3 * TICK_NS // 4


def test_a_late_beat_runs_once_and_no_burst_catches_up() -> None:
    clock = SteppedClock(5 * TICK_NS + 7, TICK_NS)
    pacer = Pacer(clock)
    assert pacer.wait() == 5 * TICK_NS + 7
    assert pacer.late_ns == 4 * TICK_NS + 7
    assert pacer.wait() == 6 * TICK_NS + 7
    assert pacer.late_ns == 7
