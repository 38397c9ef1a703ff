"""Control of an identification drive: the path is followed, the pedals follow a program."""

import msgspec
import numpy as np

from contract.geometry import Array, Pose2
from vehicle_agent.control.excitation.pedal_program import PedalProgram, program_pedals
from vehicle_agent.control.waypoint.follower import FollowerState, predicted_pose
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
        # The kernels are compiled here, so that no tick waits for them; some stacks use them for this alone.
        origin = Pose2(0.0, 0.0, 0.0)
        predicted_pose(origin, 0.0, np.zeros(1), 1.0, self.dt_s)
        self.inner.follower.step(FollowerState(), origin, 0.0, np.zeros((1, 2)))
        self._pedals(self.program.initial(), 0.0)
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
        throttle, brake = self._pedals(pedals, ego.speed_mps)
        excited = msgspec.structs.replace(command, throttle_ratio=throttle, brake_ratio=brake)
        return excited, ExcitationState(inner, pedals)

    def _pedals(self, state: Array, speed_mps: float) -> tuple[float, float]:
        """(throttle, brake) of this tick; the program's state is advanced in place."""
        program = self.program
        throttle, brake = program_pedals(
            state,
            speed_mps,
            self.dt_s,
            np.array(program.throttle_ratios),
            np.array(program.brake_ratios),
            program.row(),
        )
        return float(throttle), float(brake)
