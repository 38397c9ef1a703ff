"""Road maps and localization maps, closures, announcements, calendars and departures."""

from sqlalchemy import BigInteger, Boolean, Column, Date, Double, Index, Integer, LargeBinary, String, Table

from server.store.tables.metadata import campus_key, instant, key, metadata, optional_instant, string, text

maps = Table(
    "maps",
    metadata,
    campus_key(),
    key("map_version"),
    string("name", 200),
    Column("content", LargeBinary, nullable=False),
    instant("added_at"),
    Column("active", Boolean, nullable=False),
)
localization_maps = Table(
    "localization_maps",
    metadata,
    campus_key(),
    key("map_version"),
    string("kind"),
    Column("latitude_deg", Double, nullable=False),
    Column("longitude_deg", Double, nullable=False),
    Column("manifest", LargeBinary, nullable=False),
    string("manifest_sha256"),
    Column("manifest_bytes", Integer, nullable=False),
    Column("tile_count", Integer, nullable=False),
    Column("size_bytes", BigInteger, nullable=False),
    string("road_map_version"),
    text("note"),
    string("published_by", 200),
    instant("published_at"),
    Column("active", Boolean, nullable=False),
    string("activated_by", 200),
    optional_instant("activated_at"),
)
# Tiles whose bytes the tile store keeps.
localization_tiles = Table(
    "localization_tiles",
    metadata,
    campus_key(),
    key("sha256"),
    Column("size_bytes", Integer, nullable=False),
    instant("kept_at"),
)
map_drafts = Table(
    "map_drafts",
    metadata,
    campus_key(),
    key("draft_id"),
    string("name", 200),
    Column("revision", Integer, nullable=False),
    string("based_on"),
    string("made_by", 200),
    instant("made_at"),
    string("changed_by", 200),
    instant("changed_at"),
    Column("content", LargeBinary, nullable=False),
)
departures = Table(
    "departures",
    metadata,
    campus_key(),
    key("departure_id", 200),
    string("trip_id", 200),
    instant("first_call_at"),
    text("calls"),
    string("state"),
    Column("vehicle_id", String(64), nullable=True),
    text("reason"),
    Index(None, "campus_id", "state"),
)
service_patterns = Table(
    "service_patterns",
    metadata,
    campus_key(),
    key("service_id"),
    string("name", 200),
    text("weekdays"),
    Column("starts_on", Date, nullable=True),
    Column("ends_on", Date, nullable=True),
    text("hours"),
)
# service_id is empty for the whole campus: a holiday.
service_exceptions = Table(
    "service_exceptions",
    metadata,
    campus_key(),
    Column("day", Date, primary_key=True),
    key("service_id"),
    Column("runs", Boolean, nullable=False),
    text("note"),
    string("made_by", 200),
)
timetables = Table(
    "timetables",
    metadata,
    campus_key(),
    Column("revision", Integer, primary_key=True, autoincrement=False),
    text("trips"),
    Column("trip_count", Integer, nullable=False),
    string("made_by", 200),
    instant("made_at"),
    text("note"),
)
announcements = Table(
    "announcements",
    metadata,
    campus_key(),
    key("announcement_id"),
    text("text_zh"),
    text("text_en"),
    instant("starts_at"),
    optional_instant("ends_at"),
    string("audience"),
    text("stop_ids"),
    text("vehicle_ids"),
    string("made_by", 200),
    instant("made_at"),
    optional_instant("sent_at"),
    string("ended_by", 200),
    optional_instant("ended_at"),
    Index(None, "campus_id", "made_at"),
    Index(None, "campus_id", "ended_at", "ends_at"),
)
closures = Table(
    "closures",
    metadata,
    campus_key(),
    key("closure_id"),
    text("lane_ids"),
    text("section_ids"),
    text("reason"),
    instant("starts_at"),
    optional_instant("ends_at"),
    string("made_by", 200),
    instant("made_at"),
    string("state"),
    string("lifted_by", 200),
    Index(None, "campus_id", "state"),
)
