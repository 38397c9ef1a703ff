"""Incidents, recorded runs, identities, answers to commands, webhooks, leases and counters."""

from sqlalchemy import BigInteger, Column, Index, Integer, LargeBinary, String, Table, UniqueConstraint

from server.store.tables.metadata import campus_key, instant, key, metadata, optional_instant, string, text

counters = Table(
    "counters",
    metadata,
    campus_key(),
    key("name"),
    Column("value", BigInteger, nullable=False),
)
incidents = Table(
    "incidents",
    metadata,
    campus_key(),
    key("incident_id"),
    string("kind"),
    Column("priority", Integer, nullable=False),
    string("subject", 200),
    text("cause"),
    instant("opened_at"),
    Column("vehicle_id", String(64), nullable=True),
    Column("ride_id", String(64), nullable=True),
    optional_instant("acknowledged_at"),
    string("acknowledged_by", 200),
    optional_instant("closed_at"),
    string("closed_by", 200),
    Index(None, "campus_id", "closed_at"),
    Index(None, "campus_id", "kind", "subject"),
)
runs = Table(
    "runs",
    metadata,
    campus_key(),
    key("vehicle_id"),
    key("boot_id"),
    instant("started_at"),
    string("software", 200),
    string("stack", 200),
    string("map_version"),
    Index(None, "campus_id", "started_at"),
)
segments = Table(
    "segments",
    metadata,
    campus_key(),
    key("sha256"),
    string("vehicle_id"),
    string("boot_id"),
    Column("number", Integer, nullable=False),
    Column("size_bytes", BigInteger, nullable=False),
    Column("first_ns", BigInteger, nullable=False),
    Column("last_ns", BigInteger, nullable=False),
    instant("received_at"),
    UniqueConstraint("campus_id", "vehicle_id", "boot_id", "number"),
)
operators = Table(
    "operators",
    metadata,
    campus_key(),
    key("operator_id"),
    string("name", 200),
    text("password_hash"),
    instant("created_at"),
    UniqueConstraint("campus_id", "name"),
)
operator_sessions = Table(
    "operator_sessions",
    metadata,
    campus_key(),
    key("token_sha256"),
    string("operator_id"),
    instant("opened_at"),
    instant("expires_at"),
)
vehicle_keys = Table(
    "vehicle_keys",
    metadata,
    campus_key(),
    key("vehicle_id"),
    string("public_key", 128),
    instant("enrolled_at"),
    optional_instant("revoked_at"),
)
enrolment_codes = Table(
    "enrolment_codes",
    metadata,
    campus_key(),
    key("code_sha256"),
    string("vehicle_id"),
    string("made_by", 200),
    instant("expires_at"),
    optional_instant("used_at"),
)
developer_tokens = Table(
    "developer_tokens",
    metadata,
    campus_key(),
    key("token_id"),
    string("name", 200),
    string("token_sha256"),
    text("scopes"),
    string("made_by", 200),
    instant("created_at"),
    instant("expires_at"),
    optional_instant("revoked_at"),
    UniqueConstraint("campus_id", "token_sha256"),
)
ticket_keys = Table(
    "ticket_keys",
    metadata,
    campus_key(),
    key("key_id"),
    instant("first_used_at"),
)
command_answers = Table(
    "command_answers",
    metadata,
    campus_key(),
    key("account", 128),
    key("key_sha256"),
    string("request_sha256"),
    Column("sealed", LargeBinary, nullable=False),
    instant("made_at"),
    Index(None, "campus_id", "made_at"),
)
webhooks = Table(
    "webhooks",
    metadata,
    campus_key(),
    key("webhook_id"),
    text("url"),
    text("event_types"),
    string("account", 128),
    string("made_by", 200),
    instant("created_at"),
    string("ticket_key_id"),
    Column("version", Integer, nullable=False),
    string("old_ticket_key_id"),
    Column("old_version", Integer, nullable=False),
    optional_instant("old_key_until"),
    Column("cursor", BigInteger, nullable=False),
    optional_instant("last_success_at"),
    optional_instant("last_failure_at"),
    string("last_failure", 200),
    Column("failures", Integer, nullable=False),
    optional_instant("failing_since"),
    optional_instant("next_attempt_at"),
    optional_instant("disabled_at"),
    string("disabled_reason", 200),
)
leases = Table(
    "leases",
    metadata,
    campus_key(),
    key("name"),
    string("holder"),
    Column("token", BigInteger, nullable=False),
    instant("expires_at"),
)
