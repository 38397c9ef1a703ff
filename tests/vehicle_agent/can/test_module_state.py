"""What a by-wire module's reports say is wrong, and for how long."""

import msgspec
import pytest

from vehicle_agent.can.handshake import Handshake
from vehicle_agent.can.module_state import (
    BOOT_GRACE_NS,
    FAULT_SHOWN_NS,
    MALFORMED_SHOWN_NS,
    REFUSALS_MAX,
    REPORT_LOST_NS,
    CodecState,
    ModuleStatus,
    with_faults,
)

NOW_NS = 10_000_000_000
BOOTED = CodecState(boot_ns=1)
ON = CodecState(Handshake("on", 1), boot_ns=1)
HEALTHY = ModuleStatus(True, NOW_NS, False, False, False, False, (("can_speed_report_lost", NOW_NS),), 0)


def faults(state: CodecState, now_ns: int = NOW_NS, **changes: object) -> list[tuple[str, str]]:
    status = msgspec.structs.replace(HEALTHY, **changes)
    return [(fault.code, fault.severity) for fault in with_faults(state, status, (), now_ns).faults]


def test_a_healthy_module_has_no_faults() -> None:
    assert faults(BOOTED) == []
    assert faults(ON) == []


@pytest.mark.parametrize(
    ("age_ns", "expected"), [(REPORT_LOST_NS, []), (REPORT_LOST_NS + 1, [("can_speed_report_lost", "stop")])]
)
def test_a_report_that_is_too_old_is_lost(age_ns: int, expected: list[tuple[str, str]]) -> None:
    stamps = (("can_speed_report_lost", NOW_NS - age_ns),)
    assert faults(BOOTED, stamps_ns=stamps) == expected


@pytest.mark.parametrize(("since_boot_ns", "lost"), [(BOOT_GRACE_NS, False), (BOOT_GRACE_NS + 1, True)])
def test_just_after_the_start_no_report_is_missed_yet(since_boot_ns: int, lost: bool) -> None:
    state = CodecState(boot_ns=NOW_NS - since_boot_ns)
    assert bool(faults(state, stamps_ns=(("can_speed_report_lost", 0),))) == lost


def test_the_first_tick_is_the_start_of_the_grace() -> None:
    first = with_faults(CodecState(), HEALTHY, (), NOW_NS)
    assert first.boot_ns == NOW_NS
    assert with_faults(first, HEALTHY, (), NOW_NS + 20).boot_ns == NOW_NS


def test_the_stop_button_and_the_modules_own_faults_stop_the_vehicle() -> None:
    assert faults(BOOTED, stop_pressed=True) == [("emergency_stop_pressed", "stop")]
    assert faults(BOOTED, faulted=True) == [("bywire_fault", "stop")]


def test_a_timeout_stops_a_vehicle_that_drives_and_is_a_note_otherwise() -> None:
    assert faults(BOOTED, timed_out=True) == [("bywire_timeout", "info")]
    assert faults(ON, timed_out=True) == [("bywire_timeout", "stop")]


@pytest.mark.parametrize(
    ("state", "overridden", "lost"), [(ON, False, True), (ON, True, False), (BOOTED, False, False)]
)
def test_a_module_that_lets_go_while_driving_is_lost_unless_a_driver_took_it(
    state: CodecState, overridden: bool, lost: bool
) -> None:
    found = faults(state, enabled=False, overridden=overridden)
    assert found == ([("bywire_lost", "stop")] if lost else [])


@pytest.mark.parametrize(("refusals", "refuses"), [(REFUSALS_MAX - 1, False), (REFUSALS_MAX, True)])
def test_three_requests_without_an_answer_are_a_refusal(refusals: int, refuses: bool) -> None:
    state = CodecState(Handshake("clear", 1, refusals), boot_ns=1)
    assert faults(state) == ([("bywire_refuses_enable", "stop")] if refuses else [])


@pytest.mark.parametrize(
    ("age_ns", "shown"), [(0, True), (MALFORMED_SHOWN_NS, True), (MALFORMED_SHOWN_NS + 1, False)]
)
def test_a_malformed_frame_is_shown_for_a_second(age_ns: int, shown: bool) -> None:
    found = faults(BOOTED, malformed_ns=NOW_NS - age_ns)
    assert found == ([("can_frame_malformed", "warning")] if shown else [])


def test_several_faults_come_in_a_fixed_order_and_keep_when_they_began() -> None:
    first = with_faults(ON, msgspec.structs.replace(HEALTHY, faulted=True), (), NOW_NS)
    both = msgspec.structs.replace(HEALTHY, faulted=True, stop_pressed=True)
    second = with_faults(first, both, (), NOW_NS + 20)
    assert [(fault.code, fault.since_ns) for fault in second.faults] == [
        ("bywire_fault", NOW_NS),
        ("emergency_stop_pressed", NOW_NS + 20),
    ]


def test_a_fault_that_comes_and_goes_is_one_fault_until_a_second_after_its_last_report() -> None:
    state = ON
    for number in range(20):
        status = msgspec.structs.replace(HEALTHY, faulted=number % 2 == 0)
        state = with_faults(state, status, (), NOW_NS + number)
        assert [(fault.code, fault.since_ns) for fault in state.faults] == [("bywire_fault", NOW_NS)]
    fresh, last_ns = msgspec.structs.replace(HEALTHY, stamps_ns=()), NOW_NS + 18
    assert with_faults(state, fresh, (), last_ns + FAULT_SHOWN_NS).faults[0].code == "bywire_fault"
    assert with_faults(state, fresh, (), last_ns + FAULT_SHOWN_NS + 1).faults == ()


@pytest.mark.parametrize(
    ("was", "overridden", "enabled", "age_ns", "expected"),
    [
        (False, True, True, 0, True),
        (True, False, False, 0, True),
        (True, False, True, REPORT_LOST_NS, False),
        (True, False, True, REPORT_LOST_NS + 1, True),
        (False, False, False, 0, False),
    ],
)
def test_a_takeover_lasts_until_by_wire_reports_that_it_has_the_vehicle_again(
    was: bool, overridden: bool, enabled: bool, age_ns: int, expected: bool
) -> None:
    state = msgspec.structs.replace(BOOTED, overridden=was)
    status = msgspec.structs.replace(
        HEALTHY, overridden=overridden, enabled=enabled, enabled_ns=NOW_NS - age_ns
    )
    assert with_faults(state, status, (), NOW_NS).overridden is expected
