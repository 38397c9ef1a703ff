"""Requests for lidar scans, what came of them, and the point maps that are proposed."""

from sqlalchemy import BigInteger, Column, Float, Index, Integer, Table

from server.store.tables.metadata import campus_key, instant, key, metadata, optional_instant, string, text

scan_requests = Table(
    "scan_requests",
    metadata,
    campus_key(),
    key("request_id"),
    string("name", 500),
    text("outline"),
    Column("every_m", Float, nullable=False),
    Column("bytes_max", BigInteger, nullable=False),
    instant("until"),
    instant("started_at"),
    string("started_by", 200),
    optional_instant("ended_at"),
    string("ended_by", 200),
    string("end_reason"),
    Index(None, "campus_id", "started_at"),
    Index(None, "campus_id", "ended_at", "until"),
)
scan_contributions = Table(
    "scan_contributions",
    metadata,
    campus_key(),
    key("request_id"),
    key("vehicle_id"),
    string("state"),
    text("detail"),
    Column("scans", BigInteger, nullable=False),
    Column("way_m", Float, nullable=False),
    Column("bytes_kept", BigInteger, nullable=False),
    instant("reported_at"),
)
scan_parcels = Table(
    "scan_parcels",
    metadata,
    campus_key(),
    key("sha256"),
    string("request_id"),
    string("vehicle_id"),
    string("drive_id"),
    Column("number", Integer, nullable=False),
    Column("scans", Integer, nullable=False),
    Column("way_m", Float, nullable=False),
    Column("size_bytes", BigInteger, nullable=False),
    instant("received_at"),
    Index(None, "campus_id", "request_id"),
)
map_proposals = Table(
    "map_proposals",
    metadata,
    campus_key(),
    key("proposal_id"),
    string("request_id"),
    instant("started_at"),
    string("started_by", 200),
    string("state"),
    string("stage", 200),
    Column("percent", Integer, nullable=False),
    optional_instant("beat_at"),
    text("detail"),
    string("result_sha256"),
    text("comparison"),
    optional_instant("decided_at"),
    string("decided_by", 200),
    text("note"),
    Index(None, "campus_id", "started_at"),
    Index(None, "campus_id", "state"),
)
