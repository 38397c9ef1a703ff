"""The interfaces of the onboard rooms, each generic in its state. A stack (`stacks/`) fills each with one
implementation."""

from dataclasses import dataclass
from typing import Protocol, TypeVar

from contract.roads.network import RoadNetwork
from contract.wire.messages import OrderAccepted, OrderRejected, VehicleEvent
from vehicle_agent.mission.memory import MissionMemory
from vehicle_agent.onboard.state import OnboardState, RoomState
from vehicle_agent.signals import (
    NO_SIGNALS,
    Actuation,
    Ages,
    CabinEvent,
    CanFrame,
    ControlCommand,
    Detections,
    Ego,
    Fault,
    GuardStatus,
    HmiOutput,
    Infrastructure,
    LinkState,
    LocalizationJob,
    MissionMessage,
    Navigation,
    Path,
    PerceptionInput,
    PlanAnswer,
    PlanJob,
    Task,
    VehicleMotion,
    VehicleSignals,
    World,
)

State = TypeVar("State")


class Can(Protocol[State]):
    def initial(self) -> State: ...
    def decode(
        self, state: State, frames: tuple[CanFrame, ...], now_ns: int
    ) -> tuple[VehicleMotion, State]: ...
    def encode(
        self, state: State, actuation: Actuation, now_ns: int, signals: VehicleSignals = NO_SIGNALS
    ) -> tuple[tuple[CanFrame, ...], State]: ...


class Localization(Protocol[State]):
    def initial(self) -> State: ...
    def step(
        self, state: State, motion: VehicleMotion, navigation: tuple[Navigation, ...], now_ns: int
    ) -> tuple[Ego, State]: ...
    def jobs(self, state: State) -> tuple[LocalizationJob, ...]:
        """Jobs for the localization worker, of the step that returned this state."""
        ...


class Perception(Protocol[State]):
    def initial(self) -> State: ...
    def step(
        self, state: State, percepts: tuple[PerceptionInput, ...], ego: Ego
    ) -> tuple[Detections, State]: ...
    def faults(self, state: State, now_ns: int) -> tuple[Fault, ...]:
        """What is wrong with single lidars, as their driver says."""
        ...


class WorldModel(Protocol[State]):
    def initial(self) -> State: ...
    def step(
        self,
        state: State,
        ego: Ego,
        detections: Detections,
        infrastructure: tuple[Infrastructure, ...],
        now_ns: int,
    ) -> tuple[World, State]: ...


class Mission(Protocol[State]):
    @property
    def network(self) -> RoadNetwork:
        """The map by which the vehicle drives."""
        ...

    def initial(self, memory: MissionMemory | None = None) -> State:
        """memory: the mission's memory before a crash (`mission.memory`)."""
        ...

    def step(
        self,
        state: State,
        messages: tuple[MissionMessage, ...],
        cabin_events: tuple[CabinEvent, ...],
        link: LinkState | None,
        ego: Ego,
        motion: VehicleMotion,
        world: World,
        now_ns: int,
    ) -> tuple[Task, State]: ...
    def events(self, state: State) -> tuple[VehicleEvent, ...]:
        """Events of the step that returned this state."""
        ...

    def answers(self, state: State) -> tuple[OrderAccepted | OrderRejected, ...]:
        """Answers to orders, of the step that returned this state."""
        ...


class Planning(Protocol[State]):
    def initial(self) -> State: ...
    def step(
        self, state: State, ego: Ego, world: World, task: Task, plans: tuple[PlanAnswer, ...]
    ) -> tuple[Path, State]: ...
    def jobs(self, state: State) -> tuple[PlanJob, ...]:
        """Jobs for the motion planner, of the step that returned this state."""
        ...


class Control(Protocol[State]):
    def initial(self) -> State: ...
    def step(
        self, state: State, ego: Ego, path: Path, motion: VehicleMotion
    ) -> tuple[ControlCommand, State]: ...


class Guard(Protocol[State]):
    def initial(self) -> State: ...
    def step(
        self,
        state: State,
        command: ControlCommand,
        motion: VehicleMotion,
        ego: Ego,
        world: World,
        task: Task,
        path: Path,
        ages: Ages,
    ) -> tuple[Actuation, GuardStatus, State]: ...
    def events(self, state: State) -> tuple[VehicleEvent, ...]: ...


class Hmi(Protocol[State]):
    def initial(self) -> State: ...
    def step(
        self, state: State, task: Task, path: Path, world: World, guard_status: GuardStatus, now_ns: int
    ) -> tuple[HmiOutput, State]: ...


@dataclass(frozen=True, slots=True)
class Car:
    """One vehicle's rooms, each a frozen struct of its parameters."""

    can: Can[RoomState]
    localization: Localization[RoomState]
    perception: Perception[RoomState]
    world: WorldModel[RoomState]
    mission: Mission[RoomState]
    planning: Planning[RoomState]
    control: Control[RoomState]
    guard: Guard[RoomState]
    hmi: Hmi[RoomState]


def initial_state(car: Car) -> OnboardState:
    """The state of every room at boot."""
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
