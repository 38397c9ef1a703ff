"""The audit log: what breaks its chain, and what does not."""

import pytest

from server.domain.record.audit import AuditAction, Caller, Head
from server.usecases.record import audit
from server.usecases.record.retention import forget_old
from tests.server.usecases.campus_under_test import CampusUnderTest

ANN = Caller("operator", "ann", "192.0.2.7")


@pytest.fixture
def five(campus: CampusUnderTest) -> CampusUnderTest:
    for number in range(5):
        campus.do(lambda uow, n=number: audit.append(uow, ANN, AuditAction("hold_vehicle", f"shuttle-{n}")))
        campus.clock.advance(1.0)
    return campus


def change(campus: CampusUnderTest, statement: str) -> None:
    """As one who writes the database by hand: no use case changes an entry."""
    with campus.engine.begin() as connection:
        connection.info["campus_locked"] = True
        connection.exec_driver_sql(statement)


def verdict(campus: CampusUnderTest) -> audit.Verdict:
    return campus.wait_for(audit.verify(campus.transactions))


def test_a_log_that_was_only_appended_to_is_intact(five: CampusUnderTest) -> None:
    found = verdict(five)
    assert found.broken is None
    assert found.head == five.read(lambda uow: uow.audit.head())
    assert found.head.number == 5


def test_an_empty_log_is_intact(campus: CampusUnderTest) -> None:
    assert verdict(campus) == audit.Verdict(None, Head())


@pytest.mark.parametrize(
    "column", ["made_by", "action", "subject", "detail", "outcome", "command_id", "kind", "address_sha256"]
)
def test_a_changed_entry_is_found(five: CampusUnderTest, column: str) -> None:
    change(five, f"UPDATE audit_entries SET {column} = 'forged' WHERE number = 3")
    broken = verdict(five).broken
    assert broken is not None
    assert (broken.number, broken.what) == (3, "its content was changed")


def test_another_time_is_found(five: CampusUnderTest) -> None:
    change(five, "UPDATE audit_entries SET happened_at = '2020-01-01 00:00:00.000000' WHERE number = 2")
    broken = verdict(five).broken
    assert broken is not None
    assert broken.number == 2


def test_a_deleted_entry_is_found(five: CampusUnderTest) -> None:
    change(five, "DELETE FROM audit_entries WHERE number = 3")
    broken = verdict(five).broken
    assert broken is not None
    assert (broken.number, broken.what) == (4, "entries 3 to 3 are missing")


def test_an_entry_of_another_chain_is_found(five: CampusUnderTest) -> None:
    change(five, "UPDATE audit_entries SET previous_sha256 = sha256 WHERE number = 4")
    broken = verdict(five).broken
    assert broken is not None
    assert (broken.number, broken.what) == (4, "it does not follow the entry before it")


def test_a_changed_address_is_found(five: CampusUnderTest) -> None:
    change(five, "UPDATE audit_entries SET address = '198.51.100.1' WHERE number = 5")
    broken = verdict(five).broken
    assert broken is not None
    assert (broken.number, broken.what) == (5, "its address was changed")


def test_a_log_that_was_cut_off_has_another_head_than_was_noted(five: CampusUnderTest) -> None:
    noted = five.read(lambda uow: uow.audit.head())
    change(five, "DELETE FROM audit_entries WHERE number = 5")
    found = verdict(five)
    assert found.broken is None
    assert found.head != noted


def test_addresses_are_forgotten_in_time_and_the_chain_stays_whole(five: CampusUnderTest) -> None:
    five.clock.advance(five.rules.audit_address_days * 86400.0 + 10.0)
    five.do(forget_old)
    entries = five.read(lambda uow: uow.audit.newest(10))
    assert {(entry.address, entry.salt) for entry in entries} == {("", "")}
    assert verdict(five).broken is None


def test_what_is_rolled_back_leaves_no_entry(campus: CampusUnderTest) -> None:
    def fail(uow: object) -> None:
        audit.append(uow, ANN, AuditAction("hold_vehicle"))  # type: ignore[arg-type]
        raise ValueError

    with pytest.raises(ValueError, match=r"^$"):
        campus.do(fail)
    assert campus.read(lambda uow: uow.audit.head()) == Head()
