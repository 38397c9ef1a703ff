"""The messages that control a running simulation, and its reports.

They are msgpack datagrams on the loopback. A sender of `Subscribe` gets reports of taps, of riders who have
alighted, and once a second of the scores.
"""

from typing import Literal

import msgspec

from contract.geometry import Pose2


class Subscribe(msgspec.Struct, frozen=True, tag="subscribe"):
    """Send reports to the address that this datagram came from."""


class RiderComes(msgspec.Struct, frozen=True, tag="rider_comes"):
    """A party that has booked goes to its stop. Poses are rear-axle poses of the two stops."""

    ride_id: str
    code: str
    party: int
    how: Literal["code", "tap", "sensor"]
    from_map: Pose2
    to_map: Pose2


class RideAssigned(msgspec.Struct, frozen=True, tag="ride_assigned"):
    """The rider now boards this vehicle when it stands at the stop; "" for none."""

    ride_id: str
    vehicle_id: str


class SeatPressed(msgspec.Struct, frozen=True, tag="seat_pressed"):
    vehicle_id: str
    seat: int


class DriverActs(msgspec.Struct, frozen=True, tag="driver_acts"):
    """The safety driver's pedals and steering from now on; all zero and None: no input."""

    vehicle_id: str
    brake_ratio: float = 0.0
    throttle_ratio: float = 0.0
    steer_rad: float | None = None


class StopButton(msgspec.Struct, frozen=True, tag="stop_button"):
    vehicle_id: str
    pressed: bool


class GnssOutage(msgspec.Struct, frozen=True, tag="gnss_outage"):
    vehicle_id: str
    silent: bool


class ByWireFault(msgspec.Struct, frozen=True, tag="by_wire_fault"):
    """The by-wire module reports an internal fault and disables itself while the fault is present."""

    vehicle_id: str
    present: bool


class ByWireFlag(msgspec.Struct, frozen=True, tag="by_wire_flag"):
    """A flag of a report of the PACMod module, for example brake_report and vehicle_fault.

    Beside flags, some broken values (`simulator.ecus.by_wire.ByWire`), as a speed_report's speed.

    reports  how many reports have it, None for all from now on; 0 ends it
    """

    vehicle_id: str
    report: str
    flag: str
    reports: int | None = None


class SteeringStuck(msgspec.Struct, frozen=True, tag="steering_stuck"):
    """The steering motor does not move while it is stuck; the module does not report it."""

    vehicle_id: str
    stuck: bool


class FramesLost(msgspec.Struct, frozen=True, tag="frames_lost"):
    """Frames to the module, or from it, are lost while the flag is set."""

    vehicle_id: str
    to_module: bool
    to_vehicle: bool


class PersonPlaced(msgspec.Struct, frozen=True, tag="person_placed"):
    """A person stands at a place of the map, and walks to the waypoints if there are any."""

    x_m: float
    y_m: float
    waypoints: tuple[tuple[float, float], ...] = ()


class RiderTapped(msgspec.Struct, frozen=True, tag="tapped"):
    """A rider tapped on the phone; the demo forwards it as the phone would."""

    ride_id: str
    kind: Literal["board", "alight"]


class RiderLeft(msgspec.Struct, frozen=True, tag="rider_left"):
    ride_id: str


class CameraReported(msgspec.Struct, frozen=True, tag="camera_reported"):
    """What the camera of an observation area saw age_s ago; the demo forwards it as the camera would."""

    area_id: str
    count: int
    age_s: float


class ScoreReport(msgspec.Struct, frozen=True, tag="score_told"):
    vehicle_id: str
    distance_m: float
    contacts: int
    encounters: int
    stopped_for_people_s: float
    hardest_braking_mps2: float


Intervention = (
    SeatPressed
    | DriverActs
    | StopButton
    | GnssOutage
    | ByWireFault
    | ByWireFlag
    | SteeringStuck
    | FramesLost
    | PersonPlaced
)
ToSimulation = Subscribe | RiderComes | RideAssigned | Intervention
FromSimulation = RiderTapped | RiderLeft | CameraReported | ScoreReport

decode_to_simulation = msgspec.msgpack.Decoder(ToSimulation).decode
decode_from_simulation = msgspec.msgpack.Decoder(FromSimulation).decode
encode = msgspec.msgpack.Encoder().encode
