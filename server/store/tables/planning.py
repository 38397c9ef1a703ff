"""Plans, orders, sections, and what driving takes."""

from sqlalchemy import BigInteger, Column, Float, Index, Integer, String, Table, UniqueConstraint

from server.store.columns import Utc
from server.store.tables.metadata import campus_key, instant, key, metadata, string, text

# resting_place_id is unique: no two vehicles ever head for one resting place.
plans = Table(
    "plans",
    metadata,
    campus_key(),
    key("vehicle_id"),
    Column("version", Integer, nullable=False),
    text("visits"),
    Column("resting_place_id", String(200), nullable=True),
    UniqueConstraint("campus_id", "resting_place_id"),
)
orders = Table(
    "orders",
    metadata,
    campus_key(),
    key("order_id"),
    Column("revision", Integer, primary_key=True, autoincrement=False),
    string("vehicle_id"),
    Column("number", BigInteger, nullable=False),
    Column("plan_version", Integer, nullable=False),
    string("state"),
    text("payload"),
    instant("issued_at"),
    text("reason"),
    Index(None, "campus_id", "vehicle_id", "number"),
)
held_sections = Table(
    "held_sections",
    metadata,
    campus_key(),
    Column("fence", BigInteger, primary_key=True, autoincrement=False),
    string("vehicle_id"),
    string("section_id", 200),
    Index(None, "campus_id", "vehicle_id"),
)
section_routes = Table(
    "section_routes",
    metadata,
    campus_key(),
    key("vehicle_id"),
    text("ahead"),
    Column("goal", String(200), nullable=True),
)
open_legs = Table(
    "open_legs",
    metadata,
    campus_key(),
    key("vehicle_id"),
    string("from_stop", 200),
    instant("left_at"),
)
driven_legs = Table(
    "driven_legs",
    metadata,
    campus_key(),
    key("vehicle_id"),
    Column("left_at", Utc(), primary_key=True),
    string("from_stop", 200),
    string("to_stop", 200),
    Column("hour", Integer, nullable=False),
    Column("planned_s", Float, nullable=False),
    Column("driven_s", Float, nullable=False),
)
travel_time_factors = Table(
    "travel_time_factors",
    metadata,
    campus_key(),
    text("factors"),
    text("legs"),
    instant("learned_at"),
)
