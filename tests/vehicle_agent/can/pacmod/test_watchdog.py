"""What the watchdog and the components of a module report, and what the vehicle does about it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulator.ecus.injected_flags import UnknownFlagError
from tests.vehicle_agent.can.pacmod.test_subsystem_faults import driving, found, report
from vehicle_agent.can.dbc import layouts
from vehicle_agent.can.pacmod.codec import Pacmod
from vehicle_agent.can.pacmod.subsystems import DRIVING, FAULT_FLAGS
from vehicle_agent.can.pacmod.watchdog import COMPONENTS, WATCHDOGS, Watchdog, take_watchdog
from vehicle_agent.signals import CanFrame

NOW_NS = 1_000_000_000
SOUND = {"ready": 1.0, "counter": 3.0, "complement": 12.0}
# These say what another report says already, or nothing bad.
QUIET = {"enabled", "override_active"} | {
    f"{name.removesuffix('_report')}_{flag}" for name in DRIVING for flag in ("enabled", "override_active")
}


def codes(name: str, flag: str) -> set[str]:
    return {code for code, _ in found(report(name, **{flag: 1.0}))}


@pytest.mark.parametrize("name", WATCHDOGS)
def test_every_flag_of_the_watchdog_that_means_harm_is_a_fault(name: str) -> None:
    for flag in layouts()[name].signals:
        assert bool(codes(name, flag)) is (flag not in QUIET), flag


@pytest.mark.parametrize(("name", "code"), DRIVING.items())
@pytest.mark.parametrize("flag", FAULT_FLAGS)
def test_the_watchdog_names_the_subsystem_at_fault(name: str, code: str, flag: str) -> None:
    assert codes("watchdog_report", f"{name.removesuffix('_report')}_{flag}") == {code}


@pytest.mark.parametrize("flag", ["horn_timeout", "turn_timeout", "headlight_timeout"])
def test_lights_that_the_watchdog_misses_are_a_warning(flag: str) -> None:
    assert found(report("watchdog_report_2", **{flag: 1})) == [("bywire_signal_fault", "warning")]


@pytest.mark.parametrize("name", COMPONENTS)
@pytest.mark.parametrize("flag", ["config_fault", "supply_fault", "watchdog_fault"])
def test_a_fault_of_any_component_is_a_stop_fault(name: str, flag: str) -> None:
    assert found(report(name, **SOUND, **{flag: 1.0})) == [("bywire_component_fault", "stop")]
    # 2 is "not used" and 3 "not available".
    assert found(report(name, **SOUND, **{flag: 2.0})) == []
    assert found(report(name, **SOUND, **{flag: 3.0})) == []


@pytest.mark.parametrize(("ready", "faults"), [(0, True), (1, False), (2, True), (3, False)])
def test_a_component_that_is_not_ready_is_at_fault(ready: int, faults: bool) -> None:
    assert bool(found(report("component_report", **(SOUND | {"ready": ready})))) is faults


@pytest.mark.parametrize(("level", "severity"), [(0, None), (1, "warning"), (2, "warning"), (3, "stop")])
def test_a_component_s_warning_level_is_the_fault_s_severity(level: int, severity: str | None) -> None:
    expected = [] if severity is None else [("bywire_component_fault", severity)]
    assert found(report("component_report", **SOUND, warning_level=level)) == expected


def spoken(can: Pacmod, frames: dict[int, tuple[CanFrame, ...]], until_ns: int) -> set[str]:
    """The codes at the end, of a codec that gets these frames at their times."""
    state, last = can.initial(), set()
    for now_ns in range(NOW_NS, until_ns, 20_000_000):
        motion, state = can.decode(state, frames.get(now_ns, ()), now_ns)
        last = {fault.code for fault in motion.faults}
    return last


@pytest.mark.parametrize("kind", ["silent", "counter stands", "wrong complement", "lives"])
def test_a_component_that_no_longer_lives_is_missed(kind: str) -> None:
    frames: dict[int, tuple[CanFrame, ...]] = {}
    for k in range(60):
        stamp_ns, counter = NOW_NS + k * 20_000_000, k % 16
        if k > 10:
            if kind == "silent":
                continue
            counter = 10 if kind == "counter stands" else counter
        complement = 15 - counter if kind != "wrong complement" or k <= 10 else 15
        if kind == "wrong complement" and k > 10 and counter == 0:
            continue
        frames[stamp_ns] = (
            report("component_report", stamp_ns, ready=1, counter=counter, complement=complement),
        )
    missed = "can_component_report_lost" in spoken(Pacmod(), frames, NOW_NS + 1_000_000_000)
    assert missed is (kind != "lives")


def test_a_component_that_never_reports_is_not_there() -> None:
    assert "can_component_report_lost" not in spoken(Pacmod(), {}, NOW_NS + 3_000_000_000)


@given(
    st.lists(
        st.tuples(st.sampled_from((*COMPONENTS, *WATCHDOGS)), st.binary(min_size=0, max_size=8)), max_size=30
    )
)
def test_no_bytes_upset_the_reader_and_the_order_within_a_tick_does_not_matter_to_flags(
    frames: list[tuple[str, bytes]],
) -> None:
    sent = tuple(CanFrame(NOW_NS, layouts()[name].arbitration_id, data) for name, data in frames)
    forwards = take_watchdog(Watchdog(), sent)
    backwards = take_watchdog(Watchdog(), sent[::-1])
    assert forwards.flagged == backwards.flagged
    assert [c.faulted for c in forwards.components] == [c.faulted for c in backwards.components]
    for code, severity in forwards.faults(NOW_NS):
        assert severity in ("stop", "warning"), code


@pytest.mark.parametrize(
    ("name", "flag", "code"),
    [
        ("component_report", "supply_fault", "bywire_component_fault"),
        ("component_report", "ready", "bywire_component_fault"),
        ("component_report", "counter", "can_component_report_lost"),
        ("watchdog_report", "pacmod_1_can_timeout", "bywire_timeout"),
        ("watchdog_report", "steering_output_reported_fault", "bywire_steering_fault"),
        ("watchdog_report_2", "pacmod_1_component_timeout", "bywire_component_fault"),
    ],
)
def test_the_vehicle_stops_for_it_and_drives_again_when_it_is_over_and_the_operator_resumes(
    name: str, flag: str, code: str
) -> None:
    vehicle = driving()
    vehicle.module.inject(name, flag)
    vehicle.drive(3.0)
    assert (code, False) in vehicle.raised()
    assert vehicle.modes()[-1] == "minimal_risk"
    assert vehicle.speed_mps < 0.05
    vehicle.module.clear_injected(name, flag)
    vehicle.drive(1.5)
    vehicle.resume()
    vehicle.drive(2.5)
    assert vehicle.status.mode == "autonomous"
    assert vehicle.speed_mps > 0.3


def test_a_module_that_reports_another_fault_in_every_frame_stops_the_vehicle_once_and_lets_it_go_on() -> (
    None
):
    vehicle = driving()
    flags = [
        *(("watchdog_report", flag) for flag in layouts()["watchdog_report"].signals if flag not in QUIET),
        *(("watchdog_report_2", flag) for flag in layouts()["watchdog_report_2"].signals),
        *(("component_report", flag) for flag in ("config_fault", "supply_fault", "watchdog_fault")),
    ]
    for name, flag in flags:
        vehicle.module.inject(name, flag, reports=1)
        vehicle.drive(0.04)
    raised = [code for code, cleared in vehicle.raised() if not cleared]
    assert len(raised) == len(set(raised)) <= 12, "each code once, not once a frame"
    assert vehicle.speed_mps < 0.05
    assert set(vehicle.modes()[1:]) == {"minimal_risk"}
    vehicle.drive(1.5)
    vehicle.resume()
    vehicle.drive(2.5)
    assert vehicle.status.mode == "autonomous"
    assert vehicle.speed_mps > 0.3


def test_the_simulated_module_has_one_component() -> None:
    with pytest.raises(UnknownFlagError, match="component_4"):
        driving().module.inject("component_4_report", "config_fault")
