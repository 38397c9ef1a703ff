"""Control of an identification drive: the path is followed, the pedals follow a program."""

import msgspec
import numpy as np

from contract.geometry import Array
from vehicle_agent.control.excitation.pedal_program import PedalProgram, program_pedals
from vehicle_agent.control.waypoint.waypoint_control import WaypointControl, WaypointControlState
from vehicle_agent.signals import ControlCommand, Ego, Path, VehicleMotion


class ExcitationState(msgspec.Struct, frozen=True):
    """program: see `pedal_program`."""

    inner: WaypointControlState
    program: Array


class ExcitationControl(msgspec.Struct, frozen=True):
    """Steers as `inner` does. Where the path is slower than slow_share of the program's speed, brakes at its
    end or demands a stop, the pedals are the inner controller's too, and the program begins again."""

    inner: WaypointControl
    program: PedalProgram
    slow_share: float = 0.7
    end_m: float = 15.0
    dt_s: float = 0.02

    def initial(self) -> ExcitationState:
        return ExcitationState(self.inner.initial(), self.program.initial())

    def step(
        self, state: ExcitationState, ego: Ego, path: Path, motion: VehicleMotion
    ) -> tuple[ControlCommand, ExcitationState]:
        command, inner = self.inner.step(state.inner, ego, path, motion)
        program = self.program
        free = (
            motion.enabled
            and not path.emergency
            and path.speed_mps >= self.slow_share * min(program.speed_mps_max, ego.speed_mps + 0.5)
            and path.stop_m > self.end_m
        )
        if not free:
            return command, ExcitationState(inner, program.initial())
        pedals = state.program.copy()
        throttle, brake = program_pedals(
            pedals,
            ego.speed_mps,
            self.dt_s,
            np.array(program.throttle_ratios),
            np.array(program.brake_ratios),
            program.row(),
        )
        excited = msgspec.structs.replace(command, throttle_ratio=float(throttle), brake_ratio=float(brake))
        return excited, ExcitationState(inner, pedals)
