"""The door list: every message that enters the tick, how often, and when it is too old to act on."""

import msgspec

MS = 1_000_000

TICK_NS = 20 * MS
LATE_TICK_FAULT_NS = 60 * MS
REPORT_EVERY_TICKS = 10
PLAN_EVERY_TICKS = 5


class Door(msgspec.Struct, frozen=True):
    """rate_hz 0 means: on event. stale_after_ns 0 means: never."""

    name: str
    rate_hz: float
    stale_after_ns: int
    recorded: bool = True


DOORS = (
    Door("can_frame", 30.0, 150 * MS),
    Door("gnss_fix", 50.0, 300 * MS),
    Door("imu_sample", 50.0, 300 * MS),
    Door("obstacle_percept", 10.0, 400 * MS),
    Door("track_percept", 10.0, 400 * MS),
    Door("plan_answer", 10.0, 500 * MS),
    Door("fleet_vehicle", 5.0, 1500 * MS),
    Door("pedestrian_presence", 1.0, 2500 * MS),
    Door("link_state", 1.0, 0),
    Door("order", 0.0, 0),
    Door("grants", 0.0, 0),
    Door("command", 0.0, 0),
    Door("passenger_tap", 0.0, 0),
    Door("seat_button", 0.0, 0),
    Door("code_typed", 0.0, 0),
    Door("seat_sensor", 0.0, 0),
    Door("door_state", 0.0, 0),
)

STALE_AFTER_NS = {door.name: door.stale_after_ns for door in DOORS}
