"""Orders wait for a vehicle's last word on what has happened, but not for ever."""

from contract.wire.messages import EventLogState
from server.fleet.backlog import PATIENCE_NS, Backlog


def announced(*logs: tuple[str, int], known: dict[str, int] | None = None) -> Backlog:
    """(boot, its next sequence) of each log of a hello at 100 ns."""
    backlog = Backlog()
    backlog.begin([EventLogState(boot, 0, count) for boot, count in logs], known or {}, 100)
    return backlog


def test_orders_wait_until_every_announced_event_is_stored() -> None:
    backlog = announced(("boot-1", 3), ("boot-2", 1))
    assert not backlog.stored("boot-1", 2)
    assert not backlog.stored("boot-1", 3)
    assert backlog.holds_back(101)
    assert backlog.stored("boot-2", 1)
    assert not backlog.holds_back(101)
    assert not backlog.is_waiting


def test_what_is_stored_already_is_not_waited_for() -> None:
    assert not announced(("boot-1", 3), known={"boot-1": 3}).is_waiting
    assert announced(("boot-1", 3), known={"boot-1": 2}).is_waiting
    assert not announced(("boot-1", 0)).is_waiting


def test_the_last_event_is_told_of_once() -> None:
    backlog = announced(("boot-1", 1))
    assert backlog.stored("boot-1", 1)
    assert not backlog.stored("boot-1", 2)
    assert not backlog.stored("another", 5)


def test_a_vehicle_that_does_not_send_what_it_announced_gets_its_order_after_five_seconds() -> None:
    backlog = announced(("boot-1", 3))
    assert backlog.holds_back(100 + PATIENCE_NS - 1)
    assert not backlog.holds_back(100 + PATIENCE_NS)
    assert not backlog.is_waiting
    assert PATIENCE_NS == 5_000_000_000
