import msgspec
import numpy as np

from contract.geometry import Pose2
from vehicle_agent.config import Profile
from vehicle_agent.signals import Ego, Path, VehicleMotion
from vehicle_agent.stacks.identification import excitation_control

CONTROL = excitation_control(Profile())
EGO = Ego(1, Pose2(0.0, 0.0, 0.0), 1.0, 0.0, 0.0, 0.0, 0.02, 1, True)
MOTION = VehicleMotion(1, 1.0, 0.0, 0.0, 0.0, True, False, True, 1.0)
POINTS = np.column_stack((np.arange(1.0, 30.0), np.zeros(29)))
FREE = Path(1, POINTS, np.full(29, 3.0), 3.0, "plan", None, 100.0, False)


def test_on_a_free_path_the_pedals_are_the_programs() -> None:
    command, _ = CONTROL.step(CONTROL.initial(), EGO, FREE, MOTION)
    assert command.throttle_ratio == CONTROL.program.throttle_ratios[0]
    assert command.brake_ratio == 0.0


def test_the_steering_is_the_followers() -> None:
    command, _ = CONTROL.step(CONTROL.initial(), EGO, FREE, MOTION)
    inner, _ = CONTROL.inner.step(CONTROL.inner.initial(), EGO, FREE, MOTION)
    assert command.steer_rad == inner.steer_rad


def test_near_the_paths_end_in_an_emergency_or_for_a_slow_path_the_pedals_are_the_followers() -> None:
    for changes in ({"stop_m": 5.0}, {"emergency": True}, {"speed_mps": 0.3}):
        path = msgspec.structs.replace(FREE, **changes)
        command, state = CONTROL.step(CONTROL.initial(), EGO, path, MOTION)
        inner, _ = CONTROL.inner.step(CONTROL.inner.initial(), EGO, path, MOTION)
        assert (command.throttle_ratio, command.brake_ratio) == (inner.throttle_ratio, inner.brake_ratio)
        assert state.program.tolist() == CONTROL.program.initial().tolist()


def test_without_by_wire_the_program_waits() -> None:
    motion = msgspec.structs.replace(MOTION, enabled=False)
    _, state = CONTROL.step(CONTROL.initial(), EGO, FREE, motion)
    assert state.program.tolist() == CONTROL.program.initial().tolist()
