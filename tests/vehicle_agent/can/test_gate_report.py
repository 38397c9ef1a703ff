"""What the gate tells the tick: that it brakes and why, for as long as it says so."""

import pytest

from vehicle_agent.can.gate_report import (
    CAUSES,
    GATE_LOST_NS,
    GATE_REPORT_ID,
    GateCause,
    GateStatus,
    gate_report,
    take_gate_reports,
)
from vehicle_agent.signals import GATE_BRAKING, CanFrame

S = 1_000_000_000


def after(*frames: CanFrame) -> GateStatus:
    return take_gate_reports(GateStatus(), frames)


@pytest.mark.parametrize("cause", CAUSES)
def test_every_cause_arrives_as_a_fault_of_its_own_that_stops_the_vehicle(cause: GateCause) -> None:
    assert after(gate_report(cause, S)).active(S) == [(f"{GATE_BRAKING}_{cause}", "stop")]


def test_a_gate_that_does_not_brake_is_no_fault() -> None:
    assert after(gate_report(None, S)).active(S) == []
    assert GateStatus().active(0) == []
    assert after(gate_report("footprint", S), gate_report(None, S + 1)).active(S + 1) == []


def test_a_word_counts_until_it_is_lost() -> None:
    word = after(gate_report("footprint", S))
    assert word.active(S + GATE_LOST_NS)
    assert not word.active(S + GATE_LOST_NS + 1)


@pytest.mark.parametrize(
    ("number", "data"), [(0x123, b"\x01"), (GATE_REPORT_ID, b""), (GATE_REPORT_ID, b"\x01\x00")]
)
def test_frames_of_others_and_broken_ones_pass_by(number: int, data: bytes) -> None:
    assert after(CanFrame(S, number, data)) == GateStatus()


def test_a_cause_that_only_a_newer_gate_knows_passes_by() -> None:
    assert after(CanFrame(S, GATE_REPORT_ID, bytes([len(CAUSES)]))).cause == CAUSES[-1]
    assert after(CanFrame(S, GATE_REPORT_ID, bytes([len(CAUSES) + 1]))) == GateStatus()
