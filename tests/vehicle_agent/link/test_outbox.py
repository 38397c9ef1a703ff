import os
import resource
from pathlib import Path

import msgspec
import pytest

from contract.wire.messages import CommandDone, VehicleEvent
from vehicle_agent.link.outbox import REWRITE_AFTER_LINES, Outbox, OutboxError, read_memory
from vehicle_agent.mission.memory import MissionMemory


def an_event(number: int) -> VehicleEvent:
    return CommandDone(f"command-{number}", True)


def append(outbox: Outbox, stamp_ns: int, *bodies: VehicleEvent) -> None:
    outbox.write(outbox.number_events(stamp_ns, bodies))
    outbox.compact()


def names(outbox: Outbox) -> list[str]:
    return [event.body.command_id for event in outbox.log.pending() if isinstance(event.body, CommandDone)]


def test_events_of_an_earlier_boot_are_kept_with_their_boot(tmp_path: Path) -> None:
    append(Outbox(tmp_path, "first"), 1, an_event(1), an_event(2))
    second = Outbox(tmp_path, "second")
    append(second, 5, an_event(3))
    third = Outbox(tmp_path, "third")
    assert [(e.boot_id, e.sequence) for e in third.log.pending()] == [
        ("first", 0),
        ("first", 1),
        ("second", 0),
    ]
    assert names(third) == ["command-1", "command-2", "command-3"]


def test_a_vehicle_that_has_never_run_gets_its_folders(tmp_path: Path) -> None:
    append(Outbox(tmp_path / "var" / "shuttle-1", "first"), 1, an_event(1))
    assert names(Outbox(tmp_path / "var" / "shuttle-1", "second")) == ["command-1"]


@pytest.mark.parametrize("sync", [True, False])
def test_events_and_memory_have_reached_the_disk_when_they_are_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sync: bool
) -> None:
    """A vehicle that loses its power may not have sent what it will not know after the start."""
    synced_sizes: list[int] = []
    monkeypatch.setattr(os, "fsync", lambda number: synced_sizes.append(os.fstat(number).st_size))
    outbox = Outbox(tmp_path, "first", sync=sync)
    synced_sizes.clear()
    append(outbox, 1, an_event(1))
    outbox.save_memory(b"order and riders", b"")
    folder_size = tmp_path.stat().st_size
    events_size = (tmp_path / "events.jsonl").stat().st_size
    expected = [events_size, (tmp_path / "memory.msgpack").stat().st_size, folder_size]
    assert synced_sizes == (expected if sync else [])
    outbox.close()


def test_acknowledged_events_are_gone_after_a_restart(tmp_path: Path) -> None:
    outbox = Outbox(tmp_path, "first")
    append(outbox, 1, an_event(1), an_event(2))
    outbox.log.acknowledge("first", 1)
    again = Outbox(tmp_path, "second")
    assert names(again) == ["command-1", "command-2"]
    again.log.acknowledge("first", 2)
    assert names(Outbox(tmp_path, "third")) == ["command-1", "command-2"]
    again.close()


def test_a_last_line_cut_by_a_power_loss_is_an_event_that_was_never_sent(tmp_path: Path) -> None:
    append(Outbox(tmp_path, "first"), 1, an_event(1), an_event(2))
    file = tmp_path / "events.jsonl"
    file.write_bytes(file.read_bytes()[:-7])
    assert names(Outbox(tmp_path, "second")) == ["command-1"]


def test_a_damaged_line_in_the_middle_is_refused_by_its_number(tmp_path: Path) -> None:
    append(Outbox(tmp_path, "first"), 1, an_event(1), an_event(2))
    file = tmp_path / "events.jsonl"
    file.write_bytes(b"{broken\n" + file.read_bytes())
    with pytest.raises(OutboxError, match=r"line 1.*move the file away"):
        Outbox(tmp_path, "second")


def test_the_file_does_not_grow_with_what_the_server_has(tmp_path: Path) -> None:
    outbox = Outbox(tmp_path, "first", sync=False)
    for number in range(3 * REWRITE_AFTER_LINES):
        append(outbox, number, an_event(number))
        outbox.log.acknowledge("first", number)
    assert (tmp_path / "events.jsonl").read_bytes().count(b"\n") <= REWRITE_AFTER_LINES + 1
    assert names(Outbox(tmp_path, "second", sync=False))[-1] == f"command-{3 * REWRITE_AFTER_LINES - 1}"


def test_memory_is_replaced_whole(tmp_path: Path) -> None:
    outbox = Outbox(tmp_path, "first")
    assert read_memory(tmp_path) is None
    outbox.save_memory(b"one", b"")
    outbox.save_memory(b"two", b"")
    assert read_memory(tmp_path) == b"two"


def test_a_memory_that_a_former_version_wrote_is_read(tmp_path: Path) -> None:
    memory = msgspec.msgpack.encode(MissionMemory(settled=("ride-1",)))
    (tmp_path / "memory.msgpack").write_bytes(memory)
    Outbox(tmp_path, "first").close()
    assert read_memory(tmp_path) == memory


def test_a_power_loss_between_memory_and_events_loses_no_event(tmp_path: Path) -> None:
    """The memory says that riders are aboard and sections are released: the server has to learn it too."""
    outbox = Outbox(tmp_path, "first", sync=False)
    append(outbox, 1, an_event(1))
    lines = outbox.number_events(2, (an_event(2), an_event(3)))
    outbox.save_memory(b"two more have happened", lines)
    outbox.close()
    after = Outbox(tmp_path, "second", sync=False)
    assert names(after) == ["command-1", "command-2", "command-3"]
    after.close()
    assert names(Outbox(tmp_path, "third", sync=False)) == ["command-1", "command-2", "command-3"]


def test_a_file_of_which_most_is_still_needed_is_not_written_anew(tmp_path: Path) -> None:
    """Rewriting thousands of events at every new one would stop the link on a long tunnel."""
    outbox = Outbox(tmp_path, "first", sync=False)
    file = tmp_path / "events.jsonl"
    append(outbox, 0, *(an_event(number) for number in range(REWRITE_AFTER_LINES + 10)))
    written = file.stat().st_ino
    outbox.log.acknowledge("first", REWRITE_AFTER_LINES // 2 - 100)
    append(outbox, 1, an_event(9999))
    assert file.stat().st_ino == written
    outbox.log.acknowledge("first", REWRITE_AFTER_LINES // 2 + 100)
    append(outbox, 2, an_event(10_000))
    assert file.stat().st_ino != written, "more than half of it is acknowledged"
    assert len(names(Outbox(tmp_path, "second", sync=False))) == REWRITE_AFTER_LINES // 2 - 100 + 12


def test_a_small_file_is_not_written_anew_at_every_acknowledgement(tmp_path: Path) -> None:
    outbox = Outbox(tmp_path, "first", sync=False)
    written = (tmp_path / "events.jsonl").stat().st_ino
    append(outbox, 0, an_event(0), an_event(1))
    outbox.log.acknowledge("first", 2)
    append(outbox, 1, an_event(2))
    assert (tmp_path / "events.jsonl").stat().st_ino == written


def test_events_that_a_full_disk_refused_are_written_once_when_there_is_room(tmp_path: Path) -> None:
    outbox = Outbox(tmp_path, "first")
    append(outbox, 1, an_event(1))
    lines = outbox.number_events(2, (an_event(2), an_event(3)))
    size = (tmp_path / "events.jsonl").stat().st_size
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size + len(lines) // 2, hard))
    try:
        for _ in range(2):
            with pytest.raises(OSError, match="too large"):
                outbox.write(lines)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    outbox.write(lines)
    append(outbox, 3, an_event(4))
    outbox.close()
    assert (tmp_path / "events.jsonl").read_bytes().count(b"\n") == 4
    assert names(Outbox(tmp_path, "second")) == ["command-1", "command-2", "command-3", "command-4"]
