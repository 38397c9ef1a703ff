"""Video segments; their bytes are in files."""

from sqlalchemy import BigInteger, Column, Index, Table

from server.store.tables.metadata import campus_key, instant, key, metadata, string

video_segments = Table(
    "video_segments",
    metadata,
    campus_key(),
    key("sha256"),
    string("vehicle_id"),
    string("camera"),
    instant("begins_at"),
    instant("ends_at"),
    Column("stamp_ns", BigInteger, nullable=False),
    Column("size_bytes", BigInteger, nullable=False),
    instant("received_at"),
    Index(None, "campus_id", "vehicle_id", "begins_at"),
    Index(None, "campus_id", "received_at"),
)
