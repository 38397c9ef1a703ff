"""control, guard, hmi: commands, actuation, displays and announcements."""

from typing import Literal

import msgspec

from contract.wire.messages import DriveMode, Headlights, TurnSignal
from contract.wire.reasons import HoldReason
from vehicle_agent.signals.vehicle import Fault


class ControlCommand(msgspec.Struct, frozen=True):
    """control: the requested actuation, before the guard.

    faults  what control finds wrong with the vehicle
    """

    steer_rad: float
    throttle_ratio: float
    brake_ratio: float
    accel_mps2: float
    diagnostics: tuple[tuple[str, float], ...] = ()
    faults: tuple[Fault, ...] = ()


Gear = Literal["park", "reverse", "neutral", "drive"]


class Actuation(msgspec.Struct, frozen=True):
    """guard: the actuation that `can` encodes as frames; nothing else is."""

    enable: bool
    gear: Gear
    steer_rad: float
    throttle_ratio: float
    brake_ratio: float


class GuardStatus(msgspec.Struct, frozen=True):
    """guard: the drive mode, the intervention, the faults, and why the vehicle does not drive by itself.

    imminent  the guard brakes fully for a contact ahead
    """

    mode: DriveMode
    intervened: str
    faults: tuple[Fault, ...]
    reason: HoldReason | None = None
    detail: str = ""
    imminent: bool = False


class VehicleSignals(msgspec.Struct, frozen=True):
    """hmi: turn signals, headlights and horn, as `can` commands them where the by-wire has them."""

    turn: TurnSignal = "none"
    headlights: Headlights = "off"
    horn: bool = False


NO_SIGNALS = VehicleSignals()


class HmiOutput(msgspec.Struct, frozen=True):
    """hmi: texts and signals for people outside, and announcements, each once.

    screen, rear  the front LED screen, for people ahead, and the rear one, for traffic behind
    announce      set in the one tick in which the sentence begins
    """

    screen: str
    screen_zh: str
    announce: str
    announce_zh: str
    doors_open: bool
    rear: str = ""
    rear_zh: str = ""
    signals: VehicleSignals = NO_SIGNALS


class Ages(msgspec.Struct, frozen=True):
    """How old each input of the guard is, in ns; -1 when it has never come."""

    motion_ns: int
    pose_ns: int
    percept_ns: int
    path_ns: int
