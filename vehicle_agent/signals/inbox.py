"""A tick's inputs: everything that is not deterministic, in the order of its arrival."""

import msgspec

from contract.runlog.matched_scans import MatchedScan
from contract.wire.messages import Command, Grants, Order, PassengerTap
from vehicle_agent.signals.arriving import (
    CanFrame,
    CodeTyped,
    DestinationChoice,
    DoorState,
    FleetVehicle,
    GnssFix,
    HelpButton,
    ImuSample,
    LidarConditions,
    LinkState,
    ObstaclePercept,
    PedestrianPresence,
    ScanPose,
    ScanUnplaced,
    SeatButton,
    SeatSensor,
    SignPercept,
    ThinnedScan,
    TrackPercept,
)
from vehicle_agent.signals.localizing import PoseHint
from vehicle_agent.signals.plans import PlanAnswer

# What the localization worker answers.
ScanAnswer = ScanPose | ScanUnplaced
Navigation = GnssFix | ImuSample | ScanPose | ScanUnplaced | PoseHint
MissionMessage = Order | Grants | Command | PassengerTap
Percept = ObstaclePercept | TrackPercept
# What the tick's perception reads; the gate has its own ears for percepts.
PerceptionInput = Percept | SignPercept | LidarConditions
# For people who look at a run: no room reads it, so it is no part of the input tape.
ForViewers = MatchedScan | ThinnedScan
# What the link delivers to the tick.
LinkMessage = MissionMessage | LinkState | FleetVehicle | PedestrianPresence
CabinEvent = SeatButton | HelpButton | CodeTyped | DestinationChoice | SeatSensor | DoorState
Infrastructure = FleetVehicle | PedestrianPresence
InboxBody = (
    CanFrame
    | GnssFix
    | ImuSample
    | ScanPose
    | ScanUnplaced
    | ObstaclePercept
    | TrackPercept
    | SignPercept
    | LidarConditions
    | MatchedScan
    | ThinnedScan
    | PlanAnswer
    | SeatButton
    | HelpButton
    | CodeTyped
    | DestinationChoice
    | SeatSensor
    | DoorState
    | LinkState
    | FleetVehicle
    | PedestrianPresence
    | Order
    | Grants
    | Command
    | PassengerTap
)


class InboxItem(msgspec.Struct, frozen=True):
    """One input with its arrival time at the vehicle computer."""

    arrival_ns: int
    source: str
    sequence: int
    body: InboxBody


class Inputs(msgspec.Struct, frozen=True):
    """One tick's drained inbox, sorted by (arrival_ns, source, sequence) and split by kind."""

    stamp_ns: int
    frames: tuple[CanFrame, ...] = ()
    navigation: tuple[Navigation, ...] = ()
    percepts: tuple[PerceptionInput, ...] = ()
    plans: tuple[PlanAnswer, ...] = ()
    infrastructure: tuple[Infrastructure, ...] = ()
    messages: tuple[MissionMessage, ...] = ()
    cabin_events: tuple[CabinEvent, ...] = ()
    link: LinkState | None = None
