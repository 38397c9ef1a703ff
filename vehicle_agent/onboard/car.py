"""The doors of the onboard rooms. A stack (`stacks/`) fills each with one implementation."""

from dataclasses import dataclass
from typing import Any, Protocol

from contract.wire.messages import OrderAccepted, OrderRejected, VehicleEvent
from vehicle_agent.onboard.state import OnboardState
from vehicle_agent.signals import (
    Actuation,
    Ages,
    CabinEvent,
    CanFrame,
    ControlCommand,
    Detections,
    Ego,
    GnssFix,
    GuardStatus,
    HmiOutput,
    ImuSample,
    Infrastructure,
    LinkState,
    MissionMessage,
    Path,
    Percept,
    PlanAnswer,
    PlanJob,
    Task,
    VehicleMotion,
    World,
)


class Can(Protocol):
    def initial(self) -> Any: ...
    def decode(self, state: Any, frames: tuple[CanFrame, ...], now_ns: int) -> tuple[VehicleMotion, Any]: ...
    def encode(self, state: Any, actuation: Actuation, now_ns: int) -> tuple[tuple[CanFrame, ...], Any]: ...


class Localization(Protocol):
    def initial(self) -> Any: ...
    def step(
        self, state: Any, motion: VehicleMotion, navigation: tuple[GnssFix | ImuSample, ...], now_ns: int
    ) -> tuple[Ego, Any]: ...


class Perception(Protocol):
    def initial(self) -> Any: ...
    def step(self, state: Any, percepts: tuple[Percept, ...], ego: Ego) -> tuple[Detections, Any]: ...


class WorldModel(Protocol):
    def initial(self) -> Any: ...
    def step(
        self,
        state: Any,
        ego: Ego,
        detections: Detections,
        infrastructure: tuple[Infrastructure, ...],
        now_ns: int,
    ) -> tuple[World, Any]: ...


class Mission(Protocol):
    def initial(self, memory: Any = None) -> Any:
        """memory: what the mission knew before a crash (`mission.memory`); it then comes up held."""
        ...

    def step(
        self,
        state: Any,
        messages: tuple[MissionMessage, ...],
        cabin_events: tuple[CabinEvent, ...],
        link: LinkState | None,
        ego: Ego,
        motion: VehicleMotion,
        world: World,
        now_ns: int,
    ) -> tuple[Task, Any]: ...
    def events(self, state: Any) -> tuple[VehicleEvent, ...]:
        """What happened in the step that made this state."""
        ...

    def answers(self, state: Any) -> tuple[OrderAccepted | OrderRejected, ...]:
        """Answers to orders that came in the step that made this state."""
        ...


class Planning(Protocol):
    def initial(self) -> Any: ...
    def step(
        self, state: Any, ego: Ego, world: World, task: Task, plans: tuple[PlanAnswer, ...]
    ) -> tuple[Path, Any]: ...
    def jobs(self, state: Any) -> tuple[PlanJob, ...]:
        """What the motion planner shall work on after the step that made this state."""
        ...


class Control(Protocol):
    def initial(self) -> Any: ...
    def step(self, state: Any, ego: Ego, path: Path, motion: VehicleMotion) -> tuple[ControlCommand, Any]: ...


class Guard(Protocol):
    def initial(self) -> Any: ...
    def step(
        self,
        state: Any,
        command: ControlCommand,
        motion: VehicleMotion,
        ego: Ego,
        world: World,
        task: Task,
        path: Path,
        ages: Ages,
    ) -> tuple[Actuation, GuardStatus, Any]: ...
    def events(self, state: Any) -> tuple[VehicleEvent, ...]: ...


class Hmi(Protocol):
    def initial(self) -> Any: ...
    def step(
        self, state: Any, task: Task, path: Path, world: World, guard_status: GuardStatus, now_ns: int
    ) -> tuple[HmiOutput, Any]: ...


@dataclass(frozen=True, slots=True)
class Car:
    """One vehicle's rooms, each a frozen struct of its parameters."""

    can: Can
    localization: Localization
    perception: Perception
    world: WorldModel
    mission: Mission
    planning: Planning
    control: Control
    guard: Guard
    hmi: Hmi


def initial_state(car: Car) -> OnboardState:
    """Every room at boot."""
    return OnboardState(
        0,
        car.can.initial(),
        car.localization.initial(),
        car.perception.initial(),
        car.world.initial(),
        car.mission.initial(),
        car.planning.initial(),
        car.control.initial(),
        car.guard.initial(),
        car.hmi.initial(),
    )
