"""A link that starts late, dies or hangs: it learns every event once, and a cut recording begins anew."""

import tempfile
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st

from contract.geometry import Pose2
from contract.wire.events import DoorsChanged, RiderBoarded
from contract.wire.status import Status
from vehicle_agent.link.bridge import TickUpdate
from vehicle_agent.runtime.processes.link.link_mail import LinkMail
from vehicle_agent.runtime.processes.mailbox import WAITING_MAX, Mail, Mailbox, TickReport
from vehicle_agent.runtime.recording.recorder import LogEntry, RunLogEntry

STATUS = Status(
    epoch=0,
    stamp_ns=1,
    pose_map=Pose2(0.0, 0.0, 0.0),
    speed_mps=0.0,
    accel_mps2=0.0,
    steer_rad=0.0,
    mode="held",
    battery_ratio=1.0,
    doors_open=True,
    lane_id="lane",
    s_m=0.0,
    order_id="",
    revision=0,
    visit_id="",
)


class Computer:
    """Each tick has an event, a run-log entry, and a segment's beginning when one is due."""

    def __init__(self, folder: Path) -> None:
        self.link_path = folder / "link"
        self._mailbox = Mailbox(folder / "tick", self._note_lost)
        self._link_mail = LinkMail(self._mailbox, self.link_path)
        self.ticks = 0
        self._begins = True

    def _note_lost(self, mail: Mail) -> None:
        self._link_mail.note_lost(mail)

    def run_ticks(self, count: int) -> None:
        for _ in range(count):
            number = self.ticks
            self.ticks += 1
            self._mailbox.take()
            entries: list[RunLogEntry] = [LogEntry("/tick", number, b"")]
            if self._begins:
                entries.insert(0, LogEntry("/begin", number, b""))
            update = TickUpdate(number, events=(RiderBoarded(f"ride-{number}", "code"),))
            self._begins = self._link_mail.post(update, entries)

    def close(self) -> None:
        self._mailbox.close()


class Link:
    """What a link process has read."""

    def __init__(self) -> None:
        self.events: list[tuple[int, str]] = []
        self.entries: list[tuple[str, int]] = []
        self.mailbox: Mailbox | None = None

    def begin(self, path: Path) -> None:
        self.entries.append(("link begins", -1))
        self.mailbox = Mailbox(path)

    def read(self) -> None:
        assert self.mailbox is not None
        for mail in self.mailbox.take():
            assert isinstance(mail, TickReport)
            if mail.update is not None:
                self.events += [(mail.update.stamp_ns, event.ride_id) for event in mail.update.events]
            self.entries += [(entry.topic, entry.stamp_ns) for entry in mail.entries]

    def die(self) -> None:
        """With nothing unread: mail that a killed process had received is lost with it."""
        self.read()
        assert self.mailbox is not None
        self.mailbox.close()
        self.mailbox = None


def assert_recordings_are_whole(entries: list[tuple[str, int]]) -> None:
    """What a link can write is whole segments: from a beginning on, no tick is missing."""
    writes, expected = False, 0
    for topic, tick in entries:
        if topic == "link begins":
            writes = False
        elif topic == "/begin":
            writes, expected = True, tick
        elif writes:
            assert tick == expected
            expected += 1


def test_a_tick_that_starts_before_its_link_loses_no_event_and_is_recorded_from_then_on(
    tmp_path: Path,
) -> None:
    computer, link = Computer(tmp_path), Link()
    computer.run_ticks(100)
    link.begin(computer.link_path)
    for _ in range(100):
        computer.run_ticks(1)
        link.read()
    assert link.events == [(number, f"ride-{number}") for number in range(200)]
    recorded = [tick for topic, tick in link.entries if topic == "/tick"]
    assert ("/begin", recorded[0]) in link.entries
    assert recorded == list(range(recorded[0], 200))
    assert recorded[0] <= 102
    link.die(), computer.close()


def test_a_hung_link_gets_what_it_missed_in_order(tmp_path: Path) -> None:
    computer, link = Computer(tmp_path), Link()
    link.begin(computer.link_path)
    computer.run_ticks(3 * WAITING_MAX)
    for _ in range(5 * WAITING_MAX):
        link.read()
        computer.run_ticks(1)
    link.read()
    assert link.events == [(number, f"ride-{number}") for number in range(computer.ticks)]
    assert_recordings_are_whole(link.entries)
    assert link.entries[-1] == ("/tick", computer.ticks - 1)
    link.die(), computer.close()


@settings(max_examples=15, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(["run", "away", "hung"]), st.integers(1, 300)), max_size=6))
def test_however_the_link_comes_and_goes_each_event_arrives_once(phases: list[tuple[str, int]]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        computer, link = Computer(Path(folder)), Link()
        for phase, ticks in [*phases, ("run", 1)]:
            if phase == "away" and link.mailbox is not None:
                link.die()
            elif phase != "away" and link.mailbox is None:
                link.begin(computer.link_path)
            for _ in range(ticks):
                computer.run_ticks(1)
                if phase == "run":
                    link.read()
        for _ in range(3 * computer.ticks):
            link.read()
            computer.run_ticks(1)
        link.read()
        assert link.events == [(number, f"ride-{number}") for number in range(computer.ticks)]
        assert_recordings_are_whole(link.entries)
        assert link.entries[-1] == ("/tick", computer.ticks - 1)
        link.die(), computer.close()


def test_where_the_vehicle_stood_meanwhile_is_not_told_later(tmp_path: Path) -> None:
    """A status is out of date by then; a door that opened and the mission's memory are not."""
    computer = Computer(tmp_path)
    tick = Mailbox(tmp_path / "other tick", lambda mail: link_mail.note_lost(mail))
    link_mail = LinkMail(tick, computer.link_path)
    link_mail.post(TickUpdate(1, report=STATUS), ())
    link_mail.post(TickUpdate(2, report=STATUS, events=(DoorsChanged(True, "visit-1"),), memory=b"m"), ())
    link = Mailbox(computer.link_path)
    assert link_mail.post(TickUpdate(3, report=STATUS), ())
    link_mail.post(TickUpdate(4, report=STATUS), ())
    told = [mail.update for mail in link.take() if isinstance(mail, TickReport) and mail.update is not None]
    assert [(update.stamp_ns, update.memory, update.report is None) for update in told] == [
        (2, b"m", True),
        (4, None, False),
    ]
    computer.close(), tick.close(), link.close()
