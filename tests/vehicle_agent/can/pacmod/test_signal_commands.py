"""Turn signals, headlights and horn by wire: from the command to the lamp, and back in the reports."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulator.ecus.safety_driver import SafetyDriver
from tests.vehicle_agent.can.pacmod.guarded_vehicle import GuardedVehicle
from vehicle_agent.can.dbc import layouts
from vehicle_agent.can.handshake import Handshake
from vehicle_agent.can.pacmod.braking import PacmodBraking
from vehicle_agent.can.pacmod.codec import HEADLIGHTS, TURN_SIGNALS
from vehicle_agent.can.pacmod.commands import COMMANDS, DRIVING_COMMANDS, CommandEncoder
from vehicle_agent.config import SteeringColumn
from vehicle_agent.signals import Actuation, CanFrame, Headlights, TurnSignal, VehicleSignals

S = 1_000_000_000
ENCODER = CommandEncoder(SteeringColumn(), wheel_rate_radps=5.0)
DRIVE = Actuation(True, "drive", 0.1, 0.3, 0.0)
SIGNALS = VehicleSignals("left", "low", True)


def values(frames: tuple[CanFrame, ...]) -> dict[str, dict[str, float]]:
    return {name: layouts()[name].unpack(frame.data) for name, frame in zip(COMMANDS, frames, strict=True)}


def shown(vehicle: GuardedVehicle) -> tuple[str | None, str | None, bool | None]:
    return vehicle.motion.turn_signal, vehicle.motion.headlights, vehicle.motion.horn


def driving(signals: VehicleSignals = SIGNALS) -> GuardedVehicle:
    vehicle = GuardedVehicle()
    vehicle.signals = signals
    vehicle.drive(2.0)
    assert vehicle.motion.enabled
    return vehicle


@given(st.sampled_from(TURN_SIGNALS), st.sampled_from(HEADLIGHTS), st.booleans(), st.integers(0, 15))
def test_each_signal_is_sent_as_its_code(
    turn: TurnSignal, headlights: Headlights, horn: bool, counter: int
) -> None:
    frames = ENCODER.frames(
        DRIVE, Handshake("on", 0), counter, False, S, VehicleSignals(turn, headlights, horn)
    )
    sent = values(frames)
    assert TURN_SIGNALS[int(sent["turn_command"]["turn_signal"])] == turn
    assert HEADLIGHTS[int(sent["headlight_command"]["headlights"])] == headlights
    assert bool(sent["horn_command"]["horn"]) is horn
    assert all(sent[name]["enable"] for name in ("turn_command", "horn_command", "headlight_command"))
    # The gate reads the same actuation whatever the signals are.
    assert PacmodBraking().commanded(frames).counter == counter


def test_until_by_wire_is_on_the_horn_is_silent() -> None:
    for phase in ("off", "clear", "enable"):
        frames = ENCODER.frames(DRIVE, Handshake(phase, 0), 1, False, S, SIGNALS)  # type: ignore[arg-type]
        assert values(frames)["horn_command"]["horn"] == 0.0


@given(st.sampled_from(TURN_SIGNALS), st.booleans(), st.integers(1, 300))
def test_a_gate_that_brakes_warns_the_traffic_behind_and_keeps_the_lights(
    turn: TurnSignal, horn: bool, steps: int
) -> None:
    told = ENCODER.frames(DRIVE, Handshake("on", 0), 3, False, S, VehicleSignals(turn, "low", horn))
    braking = values(PacmodBraking().braking_frames(told, steps, 2 * S, 0.6))
    assert TURN_SIGNALS[int(braking["turn_command"]["turn_signal"])] == "hazard"
    assert braking["horn_command"]["horn"] == 0.0
    assert HEADLIGHTS[int(braking["headlight_command"]["headlights"])] == "low"


@pytest.mark.parametrize("turn", TURN_SIGNALS)
def test_the_module_shows_what_is_commanded_and_reports_it(turn: TurnSignal) -> None:
    vehicle = driving(VehicleSignals(turn, "low", False))
    assert shown(vehicle) == (turn, "low", False)
    assert vehicle.raised() == []


def test_the_module_shows_nothing_while_by_wire_is_off() -> None:
    vehicle = GuardedVehicle()
    vehicle.signals, vehicle.resumed_ns = SIGNALS, 0
    vehicle.drive(1.0)
    assert not vehicle.motion.enabled
    assert shown(vehicle) == ("none", "off", False)


def test_the_driver_s_stalk_has_precedence_and_is_no_takeover() -> None:
    vehicle = driving()
    vehicle.module.driver = SafetyDriver(turn_signal="right")
    vehicle.drive(0.2)
    assert shown(vehicle) == ("right", "low", True)
    assert vehicle.motion.enabled
    vehicle.module.driver = SafetyDriver()
    vehicle.drive(0.2)
    assert shown(vehicle) == ("left", "low", True)


@pytest.mark.parametrize("name", COMMANDS[len(DRIVING_COMMANDS) :])
def test_signals_whose_commands_are_lost_go_dark_and_are_a_warning_and_the_vehicle_drives_on(
    name: str,
) -> None:
    vehicle = driving()
    vehicle.loses = frozenset({layouts()[name].arbitration_id})
    vehicle.drive(1.0)
    dark = {"turn_command": "none", "horn_command": False, "headlight_command": "off"}[name]
    assert dark in shown(vehicle)
    assert vehicle.raised() == [("bywire_signal_fault", False)]
    assert vehicle.status.mode == "autonomous"
    assert vehicle.motion.enabled
    vehicle.loses = frozenset()
    vehicle.drive(1.5)
    assert shown(vehicle) == ("left", "low", True)
    assert vehicle.raised()[-1] == ("bywire_signal_fault", True)


@pytest.mark.parametrize("name", DRIVING_COMMANDS)
def test_a_lost_driving_command_ends_by_wire(name: str) -> None:
    vehicle = driving()
    vehicle.loses = frozenset({layouts()[name].arbitration_id})
    vehicle.drive(0.3)
    assert not vehicle.module.enabled
    assert vehicle.status.mode in ("minimal_risk", "fault")
