"""A tick's inputs: everything that is not deterministic, in the order of its arrival."""

import msgspec

from contract.wire.messages import Command, Grants, Order, PassengerTap
from vehicle_agent.signals.arriving import (
    CanFrame,
    CodeTyped,
    DoorState,
    GnssFix,
    ImuSample,
    LinkState,
    ObstaclePercept,
    OtherVehicle,
    PedestrianPresence,
    SeatButton,
    SeatSensor,
    TrackPercept,
)
from vehicle_agent.signals.plans import PlanAnswer

ServerWord = Order | Grants | Command | PassengerTap
Percept = ObstaclePercept | TrackPercept
# What the link brings the tick.
LinkWord = ServerWord | LinkState | OtherVehicle | PedestrianPresence
Pressed = SeatButton | CodeTyped | SeatSensor | DoorState
Infrastructure = OtherVehicle | PedestrianPresence
InboxBody = (
    CanFrame
    | GnssFix
    | ImuSample
    | ObstaclePercept
    | TrackPercept
    | PlanAnswer
    | SeatButton
    | CodeTyped
    | SeatSensor
    | DoorState
    | LinkState
    | OtherVehicle
    | PedestrianPresence
    | Order
    | Grants
    | Command
    | PassengerTap
)


class InboxItem(msgspec.Struct, frozen=True):
    """Something that is not deterministic, at the moment it reached the vehicle computer."""

    arrival_ns: int
    source: str
    sequence: int
    body: InboxBody


class Inputs(msgspec.Struct, frozen=True):
    """One tick's drained inbox, sorted by (arrival_ns, source, sequence) and split by kind."""

    stamp_ns: int
    frames: tuple[CanFrame, ...] = ()
    poses: tuple[GnssFix | ImuSample, ...] = ()
    percepts: tuple[Percept, ...] = ()
    plans: tuple[PlanAnswer, ...] = ()
    infrastructure: tuple[Infrastructure, ...] = ()
    words: tuple[ServerWord, ...] = ()
    pressed: tuple[Pressed, ...] = ()
    link: LinkState | None = None
