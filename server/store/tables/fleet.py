"""Vehicles, their positions and history, and their events."""

from sqlalchemy import BigInteger, Boolean, Column, Float, Index, Integer, String, Table, Text, false

from server.store.tables.metadata import campus_key, instant, key, metadata, optional_instant, string, text

vehicles = Table(
    "vehicles",
    metadata,
    campus_key(),
    key("vehicle_id"),
    string("name", 200),
    Column("seats", Integer, nullable=False),
    Column("wheelchair_places", Integer, nullable=False),
    instant("enrolled_at"),
    Column("epoch", Integer, nullable=False),
    string("boot_id"),
    Column("connected", Boolean, nullable=False),
    string("software", 200),
    string("stack", 200),
    string("map_version"),
    string("mode"),
    Column("held", Boolean, nullable=False),
    Column("in_service", Boolean, nullable=False),
    Column("placed", Boolean, nullable=False),
    Column("retired", Boolean, nullable=False),
    optional_instant("unavailable_since"),
    optional_instant("hold_ends"),
    Column("charging", Boolean, nullable=False, server_default=false()),
    Column("shifts", Text, nullable=True),
    optional_instant("quarantined_at"),
    Column("map_failure", String(64), nullable=False, server_default=""),
    Column("localizes_by", String(64), nullable=False, server_default=""),
    Column("localization_map", String(64), nullable=False, server_default=""),
    Column("localization_change", String(64), nullable=False, server_default=""),
)
whereabouts = Table(
    "whereabouts",
    metadata,
    campus_key(),
    key("vehicle_id"),
    instant("heard_at"),
    Column("status", Text, nullable=True),
)
history = Table(
    "history",
    metadata,
    campus_key(),
    key("vehicle_id"),
    key("boot_id"),
    Column("stamp_ns", BigInteger, primary_key=True, autoincrement=False),
    instant("received_at"),
    Column("x_m", Float, nullable=False),
    Column("y_m", Float, nullable=False),
    Column("yaw_rad", Float, nullable=False),
    Column("speed_mps", Float, nullable=False),
    string("mode"),
    Column("battery_ratio", Float, nullable=False),
    Index(None, "campus_id", "received_at"),
)
vehicle_commands = Table(
    "vehicle_commands",
    metadata,
    campus_key(),
    key("command_id"),
    string("vehicle_id"),
    string("kind"),
    text("text"),
    string("made_by", 200),
    instant("made_at"),
    string("state"),
    text("detail"),
    string("announcement_id"),
    # Where a vehicle stands, of a command that says so.
    Column("pose_x_m", Float, nullable=True),
    Column("pose_y_m", Float, nullable=True),
    Column("pose_yaw_rad", Float, nullable=True),
    Index(None, "campus_id", "vehicle_id", "state"),
)
# In the order in which they were stored, so that the events of a busy moment lie side by side: with their
# vehicle and boot as the key each one would be written to a page of its own.
vehicle_events = Table(
    "vehicle_events",
    metadata,
    campus_key(),
    Column("number", BigInteger, primary_key=True, autoincrement=False),
    string("vehicle_id"),
    string("boot_id"),
    Column("sequence", BigInteger, nullable=False),
    Column("stamp_ns", BigInteger, nullable=False),
    Column("received_ns", BigInteger, nullable=False),
    text("body"),
    Index(None, "campus_id", "received_ns"),
)
# Every event of the boot below `next_sequence` is stored.
event_logs = Table(
    "event_logs",
    metadata,
    campus_key(),
    key("vehicle_id"),
    key("boot_id"),
    Column("next_sequence", BigInteger, nullable=False),
)
server_events = Table(
    "server_events",
    metadata,
    campus_key(),
    Column("number", BigInteger, primary_key=True, autoincrement=False),
    instant("happened_at"),
    string("name"),
    string("subject", 200),
    string("made_by", 200),
    text("detail"),
    Index(None, "campus_id", "subject"),
)
