"""Every message that enters the tick, with its rate and the age at which it is too old."""

import msgspec

MS = 1_000_000

TICK_NS = 20 * MS
LATE_TICK_FAULT_NS = 60 * MS
REPORT_EVERY_TICKS = 10
PLAN_EVERY_TICKS = 5


class InputMessage(msgspec.Struct, frozen=True):
    """rate_hz 0 means: on event. stale_after_ns 0 means: never."""

    name: str
    rate_hz: float
    stale_after_ns: int
    recorded: bool = True


INPUT_MESSAGES = (
    InputMessage("can_frame", 30.0, 150 * MS),
    InputMessage("gnss_fix", 50.0, 300 * MS),
    InputMessage("imu_sample", 50.0, 300 * MS),
    InputMessage("obstacle_percept", 10.0, 400 * MS),
    InputMessage("track_percept", 10.0, 400 * MS),
    InputMessage("plan_answer", 10.0, 500 * MS),
    InputMessage("fleet_vehicle", 5.0, 1500 * MS),
    InputMessage("pedestrian_presence", 1.0, 2500 * MS),
    InputMessage("link_state", 1.0, 0),
    InputMessage("order", 0.0, 0),
    InputMessage("grants", 0.0, 0),
    InputMessage("command", 0.0, 0),
    InputMessage("passenger_tap", 0.0, 0),
    InputMessage("seat_button", 0.0, 0),
    InputMessage("code_typed", 0.0, 0),
    InputMessage("seat_sensor", 0.0, 0),
    InputMessage("door_state", 0.0, 0),
)

STALE_AFTER_NS = {message.name: message.stale_after_ns for message in INPUT_MESSAGES}
