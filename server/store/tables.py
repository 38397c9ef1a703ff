"""Every table, in one place. A campus is the shard: campus_id leads every key.

Change a table only together with a migration in migrations/versions.
"""

from datetime import datetime

from sqlalchemy import (
    BigInteger,
    Boolean,
    Column,
    Date,
    Float,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    String,
    Table,
    Text,
    UniqueConstraint,
    false,
)

from server.store.columns import Utc

metadata = MetaData(
    naming_convention={
        "ix": "ix_%(table_name)s_%(column_0_N_name)s",
        "uq": "uq_%(table_name)s_%(column_0_N_name)s",
        "pk": "pk_%(table_name)s",
    }
)


def _campus() -> Column[str]:
    return Column("campus_id", String(64), primary_key=True)


def _key(name: str, length: int = 64) -> Column[str]:
    return Column(name, String(length), primary_key=True)


def _word(name: str, length: int = 64) -> Column[str]:
    return Column(name, String(length), nullable=False)


def _text(name: str) -> Column[str]:
    return Column(name, Text, nullable=False)


def _instant(name: str) -> Column[datetime]:
    return Column(name, Utc(), nullable=False)


def _later(name: str) -> Column[datetime]:
    return Column(name, Utc(), nullable=True)


maps = Table(
    "maps",
    metadata,
    _campus(),
    _key("map_version"),
    _word("name", 200),
    Column("content", LargeBinary, nullable=False),
    _instant("added_at"),
    Column("active", Boolean, nullable=False),
)

vehicles = Table(
    "vehicles",
    metadata,
    _campus(),
    _key("vehicle_id"),
    _word("name", 200),
    Column("seats", Integer, nullable=False),
    Column("wheelchair_places", Integer, nullable=False),
    _instant("enrolled_at"),
    Column("epoch", Integer, nullable=False),
    _word("boot_id"),
    Column("connected", Boolean, nullable=False),
    _word("software", 200),
    _word("stack", 200),
    _word("map_version"),
    _word("mode"),
    Column("held", Boolean, nullable=False),
    Column("in_service", Boolean, nullable=False),
    Column("placed", Boolean, nullable=False),
    Column("retired", Boolean, nullable=False),
    _later("unavailable_since"),
    _later("hold_ends"),
    Column("charging", Boolean, nullable=False, server_default=false()),
    Column("shifts", Text, nullable=True),
)

whereabouts = Table(
    "whereabouts",
    metadata,
    _campus(),
    _key("vehicle_id"),
    _instant("heard_at"),
    Column("status", Text, nullable=True),
)

history = Table(
    "history",
    metadata,
    _campus(),
    _key("vehicle_id"),
    _key("boot_id"),
    Column("stamp_ns", BigInteger, primary_key=True, autoincrement=False),
    _instant("received_at"),
    Column("x_m", Float, nullable=False),
    Column("y_m", Float, nullable=False),
    Column("yaw_rad", Float, nullable=False),
    Column("speed_mps", Float, nullable=False),
    _word("mode"),
    Column("battery_ratio", Float, nullable=False),
    Index(None, "campus_id", "received_at"),
)

vehicle_commands = Table(
    "vehicle_commands",
    metadata,
    _campus(),
    _key("command_id"),
    _word("vehicle_id"),
    _word("kind"),
    _text("text"),
    _word("made_by", 200),
    _instant("made_at"),
    _word("state"),
    _text("detail"),
    Index(None, "campus_id", "vehicle_id", "state"),
)

rides = Table(
    "rides",
    metadata,
    _campus(),
    _key("ride_id"),
    _word("ride_code", 16),
    _word("token", 128),
    _word("boarding_code", 16),
    _word("state"),
    _word("from_stop", 200),
    _word("to_stop", 200),
    Column("party", Integer, nullable=False),
    Column("wheelchairs", Integer, nullable=False),
    _instant("earliest"),
    _instant("requested_at"),
    _word("source"),
    _later("pickup_from"),
    _later("pickup_to"),
    _later("arrive_by"),
    _later("first_pickup_from"),
    _later("first_pickup_to"),
    _later("first_arrive_by"),
    Column("vehicle_id", String(64), nullable=True),
    _later("pickup_eta"),
    _later("arrival_eta"),
    _later("boarded_at"),
    Column("boarded_how", String(64), nullable=True),
    _later("ended_at"),
    _word("reason"),
    _text("reason_detail"),
    Column("promise_broken", Boolean, nullable=False),
    Column("left_early", Boolean, nullable=False),
    Column("idempotency_key", String(200), nullable=True),
    _later("arrive_before"),
    Column("first_to_stop", String(200), nullable=True),
    Column("let_out", Boolean, nullable=False, server_default=false()),
    Column("stranded_by", String(200), nullable=True),
    Column("series_id", String(64), nullable=True),
    Column("pinned", Boolean, nullable=False, server_default=false()),
    UniqueConstraint("campus_id", "token"),
    UniqueConstraint("campus_id", "idempotency_key"),
    Index(None, "campus_id", "ride_code"),
    Index(None, "campus_id", "state"),
    Index(None, "campus_id", "vehicle_id", "state"),
    Index(None, "campus_id", "requested_at"),
)

taps = Table(
    "taps",
    metadata,
    _campus(),
    _key("tap_id"),
    _word("ride_id"),
    _word("vehicle_id"),
    _word("kind"),
    _instant("made_at"),
    _word("state"),
    _text("reason"),
    Index(None, "campus_id", "vehicle_id", "state"),
)

# resting_place_id is unique: no two vehicles ever head for one resting place.
plans = Table(
    "plans",
    metadata,
    _campus(),
    _key("vehicle_id"),
    Column("version", Integer, nullable=False),
    _text("visits"),
    Column("resting_place_id", String(200), nullable=True),
    UniqueConstraint("campus_id", "resting_place_id"),
)

orders = Table(
    "orders",
    metadata,
    _campus(),
    _key("order_id"),
    Column("revision", Integer, primary_key=True, autoincrement=False),
    _word("vehicle_id"),
    Column("number", BigInteger, nullable=False),
    Column("plan_version", Integer, nullable=False),
    _word("state"),
    _text("payload"),
    _instant("issued_at"),
    _text("reason"),
    Index(None, "campus_id", "vehicle_id", "number"),
)

held_sections = Table(
    "held_sections",
    metadata,
    _campus(),
    Column("fence", BigInteger, primary_key=True, autoincrement=False),
    _word("vehicle_id"),
    _word("section_id", 200),
    Index(None, "campus_id", "vehicle_id"),
)

section_routes = Table(
    "section_routes",
    metadata,
    _campus(),
    _key("vehicle_id"),
    _text("ahead"),
    Column("goal", String(200), nullable=True),
)

counters = Table(
    "counters",
    metadata,
    _campus(),
    _key("name"),
    Column("value", BigInteger, nullable=False),
)

departures = Table(
    "departures",
    metadata,
    _campus(),
    _key("departure_id", 200),
    _word("trip_id", 200),
    _instant("first_call_at"),
    _text("calls"),
    _word("state"),
    Column("vehicle_id", String(64), nullable=True),
    _text("reason"),
    Index(None, "campus_id", "state"),
)

service_patterns = Table(
    "service_patterns",
    metadata,
    _campus(),
    _key("service_id"),
    _word("name", 200),
    _text("weekdays"),
    Column("starts_on", Date, nullable=True),
    Column("ends_on", Date, nullable=True),
    _text("hours"),
)

# service_id is empty for the whole campus: a holiday.
service_exceptions = Table(
    "service_exceptions",
    metadata,
    _campus(),
    Column("day", Date, primary_key=True),
    _key("service_id"),
    Column("runs", Boolean, nullable=False),
    _text("note"),
    _word("made_by", 200),
)

closures = Table(
    "closures",
    metadata,
    _campus(),
    _key("closure_id"),
    _text("lane_ids"),
    _text("section_ids"),
    _text("reason"),
    _instant("starts_at"),
    _later("ends_at"),
    _word("made_by", 200),
    _instant("made_at"),
    _word("state"),
    _word("lifted_by", 200),
    Index(None, "campus_id", "state"),
)

open_legs = Table(
    "open_legs",
    metadata,
    _campus(),
    _key("vehicle_id"),
    _word("from_stop", 200),
    _instant("left_at"),
)

driven_legs = Table(
    "driven_legs",
    metadata,
    _campus(),
    _key("vehicle_id"),
    Column("left_at", Utc(), primary_key=True),
    _word("from_stop", 200),
    _word("to_stop", 200),
    Column("hour", Integer, nullable=False),
    Column("planned_s", Float, nullable=False),
    Column("driven_s", Float, nullable=False),
)

paces = Table(
    "paces",
    metadata,
    _campus(),
    _text("factors"),
    _text("legs"),
    _instant("learned_at"),
)

series = Table(
    "series",
    metadata,
    _campus(),
    _key("series_id"),
    _word("token", 128),
    _word("from_stop", 200),
    _word("to_stop", 200),
    Column("party", Integer, nullable=False),
    Column("wheelchairs", Integer, nullable=False),
    _text("weekdays"),
    Column("leave_s", Integer, nullable=False),
    Column("starts_on", Date, nullable=False),
    Column("ends_on", Date, nullable=False),
    _instant("made_at"),
    _word("source"),
    _word("state"),
    _later("ended_at"),
    Column("idempotency_key", String(200), nullable=True),
    UniqueConstraint("campus_id", "token"),
    UniqueConstraint("campus_id", "idempotency_key"),
    Index(None, "campus_id", "state"),
)

occurrences = Table(
    "occurrences",
    metadata,
    _campus(),
    _key("series_id"),
    Column("day", Date, primary_key=True),
    _instant("leave_at"),
    _word("state"),
    Column("ride_id", String(64), nullable=True),
    _word("reason"),
    _text("reason_detail"),
    _later("tried_at"),
)

incidents = Table(
    "incidents",
    metadata,
    _campus(),
    _key("incident_id"),
    _word("kind"),
    Column("priority", Integer, nullable=False),
    _word("subject", 200),
    _text("cause"),
    _instant("opened_at"),
    Column("vehicle_id", String(64), nullable=True),
    Column("ride_id", String(64), nullable=True),
    _later("acknowledged_at"),
    _word("acknowledged_by", 200),
    _later("closed_at"),
    _word("closed_by", 200),
    Index(None, "campus_id", "closed_at"),
    Index(None, "campus_id", "kind", "subject"),
)

vehicle_events = Table(
    "vehicle_events",
    metadata,
    _campus(),
    _key("vehicle_id"),
    _key("boot_id"),
    Column("sequence", BigInteger, primary_key=True, autoincrement=False),
    Column("stamp_ns", BigInteger, nullable=False),
    Column("received_ns", BigInteger, nullable=False),
    _text("body"),
    Index(None, "campus_id", "received_ns"),
)

server_events = Table(
    "server_events",
    metadata,
    _campus(),
    Column("number", BigInteger, primary_key=True, autoincrement=False),
    _instant("happened_at"),
    _word("name"),
    _word("subject", 200),
    _word("made_by", 200),
    _text("detail"),
)

runs = Table(
    "runs",
    metadata,
    _campus(),
    _key("vehicle_id"),
    _key("boot_id"),
    _instant("started_at"),
    _word("software", 200),
    _word("stack", 200),
    _word("map_version"),
    Index(None, "campus_id", "started_at"),
)

segments = Table(
    "segments",
    metadata,
    _campus(),
    _key("sha256"),
    _word("vehicle_id"),
    _word("boot_id"),
    Column("number", Integer, nullable=False),
    Column("size_bytes", BigInteger, nullable=False),
    Column("first_ns", BigInteger, nullable=False),
    Column("last_ns", BigInteger, nullable=False),
    _instant("received_at"),
    UniqueConstraint("campus_id", "vehicle_id", "boot_id", "number"),
)

operators = Table(
    "operators",
    metadata,
    _campus(),
    _key("operator_id"),
    _word("name", 200),
    _text("password_hash"),
    _instant("created_at"),
    UniqueConstraint("campus_id", "name"),
)

operator_sessions = Table(
    "operator_sessions",
    metadata,
    _campus(),
    _key("token_sha256"),
    _word("operator_id"),
    _word("csrf_token", 128),
    _instant("opened_at"),
    _instant("expires_at"),
)

vehicle_keys = Table(
    "vehicle_keys",
    metadata,
    _campus(),
    _key("vehicle_id"),
    _word("public_key", 128),
    _instant("enrolled_at"),
    _later("revoked_at"),
)

enrolment_codes = Table(
    "enrolment_codes",
    metadata,
    _campus(),
    _key("code_sha256"),
    _word("vehicle_id"),
    _word("made_by", 200),
    _instant("expires_at"),
    _later("used_at"),
)

developer_tokens = Table(
    "developer_tokens",
    metadata,
    _campus(),
    _key("token_id"),
    _word("name", 200),
    _word("token_sha256"),
    _text("scopes"),
    _word("made_by", 200),
    _instant("created_at"),
    _instant("expires_at"),
    _later("revoked_at"),
    UniqueConstraint("campus_id", "token_sha256"),
)

leases = Table(
    "leases",
    metadata,
    _campus(),
    _key("name"),
    _word("holder"),
    Column("token", BigInteger, nullable=False),
    _instant("expires_at"),
)

decisions = Table(
    "decisions",
    metadata,
    _campus(),
    _key("decision_id"),
    _instant("made_at"),
    _word("kind"),
    Column("problem", LargeBinary, nullable=False),
    Column("given", LargeBinary, nullable=False),
    Column("answer", LargeBinary, nullable=False),
    Index(None, "campus_id", "made_at"),
)

ride_decisions = Table(
    "ride_decisions",
    metadata,
    _campus(),
    _key("ride_id"),
    _key("decision_id"),
    _instant("made_at"),
    _word("rule"),
    _text("best"),
    _text("runner_up"),
    _text("alternatives"),
    Column("vehicles", Integer, nullable=False),
    Index(None, "campus_id", "made_at"),
)
