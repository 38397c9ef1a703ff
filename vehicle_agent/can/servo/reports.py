"""The servo drive-by-wire's latest reports."""

import math
from functools import cache

import msgspec

from contract.wire.reasons import FaultCode
from vehicle_agent.can.dbc import SERVO, FrameError, MessageLayout, layouts
from vehicle_agent.can.speed_plausibility import is_doubted
from vehicle_agent.signals import CanFrame

# report message -> our field <- its signal
READ: dict[str, dict[str, str]] = {
    "drive_report": {
        "armed": "armed",
        "overridden": "overridden",
        "timed_out": "timed_out",
        "fault": "fault",
        "homed": "homed",
        "stop_pressed": "stop_pressed",
    },
    "brake_report": {"travel": "travel"},
    "throttle_report": {"duty": "duty"},
    "steering_report": {"shaft_rad": "shaft_angle"},
    "encoder_report": {"encoder_mps": "front_left"},
    "battery_report": {"charge_ratio": "charge"},
}
STAMPED = ("drive", "brake", "throttle", "steering", "encoder")


class ServoReports(msgspec.Struct, frozen=True):
    """Newest value of each report; `*_ns` are arrival stamps, 0 before the first.

    doubted_mps, doubted_ns  an encoder report that is not plausible yet
    """

    armed: float = 0.0
    overridden: float = 0.0
    timed_out: float = 0.0
    fault: float = 0.0
    homed: float = 0.0
    stop_pressed: float = 0.0
    travel: float = 0.0
    duty: float = 0.0
    shaft_rad: float = 0.0
    encoder_mps: float = 0.0
    charge_ratio: float = 0.0
    drive_ns: int = 0
    brake_ns: int = 0
    throttle_ns: int = 0
    steering_ns: int = 0
    encoder_ns: int = 0
    malformed_ns: int = 0
    doubted_mps: float = 0.0
    doubted_ns: int = 0

    def stamps_ns(self) -> tuple[tuple[FaultCode, int], ...]:
        """Arrival of each cyclic report, by the fault of its loss."""
        return (
            ("can_drive_report_lost", self.drive_ns),
            ("can_brake_report_lost", self.brake_ns),
            ("can_throttle_report_lost", self.throttle_ns),
            ("can_steering_report_lost", self.steering_ns),
            ("can_encoder_report_lost", self.encoder_ns),
        )


@cache
def _known() -> dict[int, MessageLayout]:
    return {layouts(SERVO)[name].arbitration_id: layouts(SERVO)[name] for name in READ}


def take_reports(reports: ServoReports, frames: tuple[CanFrame, ...]) -> ServoReports:
    """The reports after these frames, in order; frames of other modules are ignored.

    A frame of the wrong length and a speed that leaps are noted as malformed and change nothing else.
    """
    known = _known()
    values = msgspec.structs.asdict(reports)
    for frame in frames:
        layout = known.get(frame.arbitration_id)
        if layout is not None:
            _take(values, layout, frame)
    return msgspec.structs.replace(reports, **values)


def _take(values: dict[str, float], layout: MessageLayout, frame: CanFrame) -> None:
    try:
        read = layout.unpack(frame.data)
    except FrameError:
        values["malformed_ns"] = frame.stamp_ns
        return
    if layout.name == "encoder_report":
        speed_mps = read["front_left"]
        if is_doubted(values, speed_mps, frame.stamp_ns, "encoder_mps", "encoder_ns"):
            return
    values.update({field: read[signal] for field, signal in READ[layout.name].items()})
    name = layout.name.removesuffix("_report")
    if name in STAMPED:
        values[f"{name}_ns"] = frame.stamp_ns


def encoder_ratio(steer_rad: float, wheelbase_m: float, track_width_m: float) -> float:
    """Speed of the left front wheel over that of the rear axle's centre, for a turning rigid body.

    The wheel is a wheelbase ahead and half a track to the left: v_wheel = v |(1 - k w/2, k L)| with the
    curvature k = tan(delta) / L.
    """
    curvature_1pm = math.tan(steer_rad) / wheelbase_m
    return math.hypot(1.0 - 0.5 * track_width_m * curvature_1pm, curvature_1pm * wheelbase_m)
