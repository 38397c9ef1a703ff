"""A tick's outputs: each room's value, and all effects outside the tick."""

import msgspec

from contract.wire.messages import OrderAccepted, OrderRejected, Status, VehicleEvent
from vehicle_agent.signals.acting import Actuation, ControlCommand, GuardStatus, HmiOutput
from vehicle_agent.signals.arriving import CanFrame
from vehicle_agent.signals.localizing import LocalizationJob
from vehicle_agent.signals.plans import Path, PlanJob, Task
from vehicle_agent.signals.surroundings import Detections, World
from vehicle_agent.signals.vehicle import Ego, VehicleMotion


class Flow(msgspec.Struct, frozen=True):
    """The output of each room in one tick, in flow order; a run records it and a replay compares it."""

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
    """All effects of one tick outside the tick.

    jobs, localization_jobs  for the workers; each answer is an item of a later tick's inbox
    """

    frames: tuple[CanFrame, ...]
    hmi: HmiOutput
    events: tuple[VehicleEvent, ...]
    answers: tuple[OrderAccepted | OrderRejected, ...]
    report: Status
    flow: Flow
    jobs: tuple[PlanJob, ...] = ()
    localization_jobs: tuple[LocalizationJob, ...] = ()
