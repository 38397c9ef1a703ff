"""What a tick gives: each room's value, and its whole effect outside."""

import msgspec

from contract.wire.messages import OrderAccepted, OrderRejected, Status, VehicleEvent
from vehicle_agent.signals.acting import Actuation, ControlCommand, GuardStatus, HmiOutput
from vehicle_agent.signals.arriving import CanFrame
from vehicle_agent.signals.plans import Path, PlanJob, Task
from vehicle_agent.signals.surroundings import Detections, World
from vehicle_agent.signals.vehicle import Ego, VehicleMotion


class Flow(msgspec.Struct, frozen=True):
    """What each room gave in one tick, in flow order: what a run records and a replay compares."""

    motion: VehicleMotion
    ego: Ego
    detections: Detections
    world: World
    task: Task
    path: Path
    command: ControlCommand
    actuation: Actuation
    guard_status: GuardStatus
    hmi: HmiOutput


class Outputs(msgspec.Struct, frozen=True):
    """One tick's whole effect on the world outside the tick.

    jobs  for the workers; each answer is an item of a later tick's inbox
    """

    frames: tuple[CanFrame, ...]
    hmi: HmiOutput
    events: tuple[VehicleEvent, ...]
    answers: tuple[OrderAccepted | OrderRejected, ...]
    report: Status
    flow: Flow
    jobs: tuple[PlanJob, ...] = ()
