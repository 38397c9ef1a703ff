import pytest
from hypothesis import given
from hypothesis import strategies as st

from contract.wire.messages import CommandDone, EventLogState
from contract.wire.sequence import EventLog, LoggedEvent, SequenceGap, is_new


def event(number: int) -> CommandDone:
    return CommandDone(str(number), True)


@given(st.lists(st.sampled_from(["happen", "send", "lose", "crash"]), max_size=60))
def test_every_event_takes_effect_once_and_in_order_however_often_the_link_and_the_vehicle_fail(
    steps: list[str],
) -> None:
    boot = 0
    log = EventLog("boot-0")
    stored: dict[str, list[str]] = {}
    happened: dict[str, list[str]] = {"boot-0": []}

    def deliver(acknowledge: bool) -> None:
        for kept in log.pending():
            boot_events = stored.setdefault(kept.boot_id, [])
            if is_new(len(boot_events), kept.boot_id, kept.sequence):
                assert isinstance(kept.body, CommandDone)
                boot_events.append(kept.body.command_id)
            if acknowledge:
                log.acknowledge(kept.boot_id, len(boot_events))

    for number, step in enumerate(steps):
        if step == "happen":
            log.append(number, event(number))
            happened[log.boot_id].append(str(number))
        elif step == "crash":
            boot += 1
            log = EventLog(f"boot-{boot}", log.pending())
            happened[log.boot_id] = []
        else:
            deliver(acknowledge=step == "send")
    deliver(acknowledge=True)
    assert {key: value for key, value in stored.items() if value} == {
        key: value for key, value in happened.items() if value
    }
    assert log.pending() == []


def test_an_event_that_skips_another_names_the_one_expected() -> None:
    with pytest.raises(SequenceGap) as gap:
        is_new(3, "boot", 5)
    assert gap.value.expected == 3


def test_the_hello_says_where_each_boot_begins() -> None:
    log = EventLog("new", [LoggedEvent("old", 4, 1, event(4)), LoggedEvent("old", 5, 2, event(5))])
    log.append(3, event(0))
    log.acknowledge("new", 1)
    assert log.logs() == (EventLogState("old", 4, 6), EventLogState("new", 1, 1))


def test_acknowledging_a_boot_that_is_forgotten_changes_nothing() -> None:
    log = EventLog("new", [LoggedEvent("old", 0, 1, event(0))])
    assert log.acknowledge("old", 1) == 1
    assert log.acknowledge("old", 1) == 0
    assert log.acknowledge("elder", 9) == 0


def test_a_boot_that_reuses_an_id_is_refused() -> None:
    with pytest.raises(ValueError, match="new for every boot"):
        EventLog("old", [LoggedEvent("old", 0, 1, event(0))])
