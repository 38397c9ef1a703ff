import numpy as np

from vehicle_agent.config import Profile
from vehicle_agent.control.excitation.pedal_program import program_pedals
from vehicle_agent.stacks.identification import pedal_program

PROGRAM = pedal_program(Profile())


def pedals_of(seconds: float) -> list[tuple[float, float, float]]:
    """(throttle, brake, speed) of a vehicle that follows its pedals at once."""
    state, speed, rows = PROGRAM.initial(), 0.0, []
    throttles, brakes = np.array(PROGRAM.throttle_ratios), np.array(PROGRAM.brake_ratios)
    for _ in range(round(seconds * 50)):
        throttle, brake = program_pedals(state, speed, 0.02, throttles, brakes, PROGRAM.row())
        speed = max(0.0, speed + 0.02 * (2.0 * throttle - 2.0 * brake))
        rows.append((throttle, brake, speed))
    return rows


def test_every_pedal_step_occurs_in_five_minutes() -> None:
    rows = pedals_of(300.0)
    assert {row[0] for row in rows} >= set(PROGRAM.throttle_ratios)
    assert {row[1] for row in rows} >= set(PROGRAM.brake_ratios)


def test_never_both_pedals() -> None:
    assert all(throttle == 0.0 or brake == 0.0 for throttle, brake, _ in pedals_of(60.0))


def test_the_speed_stays_within_the_program() -> None:
    assert max(speed for _, _, speed in pedals_of(300.0)) < PROGRAM.speed_mps_max + 0.1


def test_a_phase_that_does_not_reach_its_speed_ends() -> None:
    state = PROGRAM.initial()
    throttles, brakes = np.array(PROGRAM.throttle_ratios), np.array(PROGRAM.brake_ratios)
    phases = set()
    for _ in range(round(30.0 * 50)):
        program_pedals(state, 1.0, 0.02, throttles, brakes, PROGRAM.row())
        phases.add(float(state[0]))
    assert len(phases) >= 3
