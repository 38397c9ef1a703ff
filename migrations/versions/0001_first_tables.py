"""First tables."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "counters",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("name", sa.String(length=64), nullable=False),
        sa.Column("value", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "name", name=op.f("pk_counters")),
    )
    op.create_table(
        "departures",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("departure_id", sa.String(length=200), nullable=False),
        sa.Column("trip_id", sa.String(length=200), nullable=False),
        sa.Column("first_call_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("calls", sa.Text(), nullable=False),
        sa.Column("state", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=True),
        sa.Column("reason", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "departure_id", name=op.f("pk_departures")),
    )
    with op.batch_alter_table("departures", schema=None) as batch_op:
        batch_op.create_index(
            batch_op.f("ix_departures_campus_id_state"), ["campus_id", "state"], unique=False
        )

    op.create_table(
        "developer_tokens",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("token_id", sa.String(length=64), nullable=False),
        sa.Column("name", sa.String(length=200), nullable=False),
        sa.Column("token_sha256", sa.String(length=64), nullable=False),
        sa.Column("scopes", sa.Text(), nullable=False),
        sa.Column("made_by", sa.String(length=200), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("expires_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("revoked_at", sa.DateTime(timezone=True), nullable=True),
        sa.PrimaryKeyConstraint("campus_id", "token_id", name=op.f("pk_developer_tokens")),
        sa.UniqueConstraint(
            "campus_id", "token_sha256", name=op.f("uq_developer_tokens_campus_id_token_sha256")
        ),
    )
    op.create_table(
        "enrolment_codes",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("code_sha256", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("made_by", sa.String(length=200), nullable=False),
        sa.Column("expires_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("used_at", sa.DateTime(timezone=True), nullable=True),
        sa.PrimaryKeyConstraint("campus_id", "code_sha256", name=op.f("pk_enrolment_codes")),
    )
    op.create_table(
        "held_sections",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("fence", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("section_id", sa.String(length=200), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "fence", name=op.f("pk_held_sections")),
    )
    with op.batch_alter_table("held_sections", schema=None) as batch_op:
        batch_op.create_index(
            batch_op.f("ix_held_sections_campus_id_vehicle_id"), ["campus_id", "vehicle_id"], unique=False
        )

    op.create_table(
        "history",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("boot_id", sa.String(length=64), nullable=False),
        sa.Column("stamp_ns", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("received_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("x_m", sa.Float(), nullable=False),
        sa.Column("y_m", sa.Float(), nullable=False),
        sa.Column("yaw_rad", sa.Float(), nullable=False),
        sa.Column("speed_mps", sa.Float(), nullable=False),
        sa.Column("mode", sa.String(length=64), nullable=False),
        sa.Column("battery_ratio", sa.Float(), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "vehicle_id", "boot_id", "stamp_ns", name=op.f("pk_history")),
    )
    with op.batch_alter_table("history", schema=None) as batch_op:
        batch_op.create_index(
            batch_op.f("ix_history_campus_id_received_at"), ["campus_id", "received_at"], unique=False
        )

    op.create_table(
        "incidents",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("incident_id", sa.String(length=64), nullable=False),
        sa.Column("kind", sa.String(length=64), nullable=False),
        sa.Column("priority", sa.Integer(), nullable=False),
        sa.Column("subject", sa.String(length=200), nullable=False),
        sa.Column("cause", sa.Text(), nullable=False),
        sa.Column("opened_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=True),
        sa.Column("ride_id", sa.String(length=64), nullable=True),
        sa.Column("acknowledged_at", sa.DateTime(timezone=True), nullable=True),
        sa.Column("acknowledged_by", sa.String(length=200), nullable=False),
        sa.Column("closed_at", sa.DateTime(timezone=True), nullable=True),
        sa.Column("closed_by", sa.String(length=200), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "incident_id", name=op.f("pk_incidents")),
    )
    with op.batch_alter_table("incidents", schema=None) as batch_op:
        batch_op.create_index(
            batch_op.f("ix_incidents_campus_id_closed_at"), ["campus_id", "closed_at"], unique=False
        )
        batch_op.create_index(
            batch_op.f("ix_incidents_campus_id_kind_subject"), ["campus_id", "kind", "subject"], unique=False
        )

    op.create_table(
        "leases",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("name", sa.String(length=64), nullable=False),
        sa.Column("holder", sa.String(length=64), nullable=False),
        sa.Column("token", sa.BigInteger(), nullable=False),
        sa.Column("expires_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "name", name=op.f("pk_leases")),
    )
    op.create_table(
        "maps",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("map_version", sa.String(length=64), nullable=False),
        sa.Column("name", sa.String(length=200), nullable=False),
        sa.Column("content", sa.LargeBinary(), nullable=False),
        sa.Column("added_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("active", sa.Boolean(), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "map_version", name=op.f("pk_maps")),
    )
    op.create_table(
        "operator_sessions",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("token_sha256", sa.String(length=64), nullable=False),
        sa.Column("operator_id", sa.String(length=64), nullable=False),
        sa.Column("csrf_token", sa.String(length=128), nullable=False),
        sa.Column("opened_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("expires_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "token_sha256", name=op.f("pk_operator_sessions")),
    )
    op.create_table(
        "operators",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("operator_id", sa.String(length=64), nullable=False),
        sa.Column("name", sa.String(length=200), nullable=False),
        sa.Column("password_hash", sa.Text(), nullable=False),
        sa.Column("created_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "operator_id", name=op.f("pk_operators")),
        sa.UniqueConstraint("campus_id", "name", name=op.f("uq_operators_campus_id_name")),
    )
    op.create_table(
        "orders",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("order_id", sa.String(length=64), nullable=False),
        sa.Column("revision", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("number", sa.BigInteger(), nullable=False),
        sa.Column("plan_version", sa.Integer(), nullable=False),
        sa.Column("state", sa.String(length=64), nullable=False),
        sa.Column("payload", sa.Text(), nullable=False),
        sa.Column("issued_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("reason", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "order_id", "revision", name=op.f("pk_orders")),
    )
    with op.batch_alter_table("orders", schema=None) as batch_op:
        batch_op.create_index(
            batch_op.f("ix_orders_campus_id_vehicle_id_number"),
            ["campus_id", "vehicle_id", "number"],
            unique=False,
        )

    op.create_table(
        "plans",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("version", sa.Integer(), nullable=False),
        sa.Column("visits", sa.Text(), nullable=False),
        sa.Column("resting_place_id", sa.String(length=200), nullable=True),
        sa.PrimaryKeyConstraint("campus_id", "vehicle_id", name=op.f("pk_plans")),
        sa.UniqueConstraint(
            "campus_id", "resting_place_id", name=op.f("uq_plans_campus_id_resting_place_id")
        ),
    )
    op.create_table(
        "rides",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("ride_id", sa.String(length=64), nullable=False),
        sa.Column("ride_code", sa.String(length=16), nullable=False),
        sa.Column("token", sa.String(length=128), nullable=False),
        sa.Column("boarding_code", sa.String(length=16), nullable=False),
        sa.Column("state", sa.String(length=64), nullable=False),
        sa.Column("from_stop", sa.String(length=200), nullable=False),
        sa.Column("to_stop", sa.String(length=200), nullable=False),
        sa.Column("party", sa.Integer(), nullable=False),
        sa.Column("wheelchairs", sa.Integer(), nullable=False),
        sa.Column("earliest", sa.DateTime(timezone=True), nullable=False),
        sa.Column("requested_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("source", sa.String(length=64), nullable=False),
        sa.Column("pickup_from", sa.DateTime(timezone=True), nullable=True),
        sa.Column("pickup_to", sa.DateTime(timezone=True), nullable=True),
        sa.Column("arrive_by", sa.DateTime(timezone=True), nullable=True),
        sa.Column("vehicle_id", sa.String(length=64), nullable=True),
        sa.Column("pickup_eta", sa.DateTime(timezone=True), nullable=True),
        sa.Column("arrival_eta", sa.DateTime(timezone=True), nullable=True),
        sa.Column("boarded_at", sa.DateTime(timezone=True), nullable=True),
        sa.Column("boarded_how", sa.String(length=64), nullable=True),
        sa.Column("ended_at", sa.DateTime(timezone=True), nullable=True),
        sa.Column("reason", sa.String(length=64), nullable=False),
        sa.Column("reason_detail", sa.Text(), nullable=False),
        sa.Column("promise_broken", sa.Boolean(), nullable=False),
        sa.Column("left_early", sa.Boolean(), nullable=False),
        sa.Column("idempotency_key", sa.String(length=200), nullable=True),
        sa.PrimaryKeyConstraint("campus_id", "ride_id", name=op.f("pk_rides")),
        sa.UniqueConstraint("campus_id", "idempotency_key", name=op.f("uq_rides_campus_id_idempotency_key")),
        sa.UniqueConstraint("campus_id", "token", name=op.f("uq_rides_campus_id_token")),
    )
    with op.batch_alter_table("rides", schema=None) as batch_op:
        batch_op.create_index(
            batch_op.f("ix_rides_campus_id_requested_at"), ["campus_id", "requested_at"], unique=False
        )
        batch_op.create_index(
            batch_op.f("ix_rides_campus_id_ride_code"), ["campus_id", "ride_code"], unique=False
        )
        batch_op.create_index(batch_op.f("ix_rides_campus_id_state"), ["campus_id", "state"], unique=False)
        batch_op.create_index(
            batch_op.f("ix_rides_campus_id_vehicle_id_state"),
            ["campus_id", "vehicle_id", "state"],
            unique=False,
        )

    op.create_table(
        "runs",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("boot_id", sa.String(length=64), nullable=False),
        sa.Column("started_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("software", sa.String(length=200), nullable=False),
        sa.Column("stack", sa.String(length=200), nullable=False),
        sa.Column("map_version", sa.String(length=64), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "vehicle_id", "boot_id", name=op.f("pk_runs")),
    )
    with op.batch_alter_table("runs", schema=None) as batch_op:
        batch_op.create_index(
            batch_op.f("ix_runs_campus_id_started_at"), ["campus_id", "started_at"], unique=False
        )

    op.create_table(
        "section_routes",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("ahead", sa.Text(), nullable=False),
        sa.Column("goal", sa.String(length=200), nullable=True),
        sa.PrimaryKeyConstraint("campus_id", "vehicle_id", name=op.f("pk_section_routes")),
    )
    op.create_table(
        "segments",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("sha256", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("boot_id", sa.String(length=64), nullable=False),
        sa.Column("number", sa.Integer(), nullable=False),
        sa.Column("size_bytes", sa.BigInteger(), nullable=False),
        sa.Column("first_ns", sa.BigInteger(), nullable=False),
        sa.Column("last_ns", sa.BigInteger(), nullable=False),
        sa.Column("received_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "sha256", name=op.f("pk_segments")),
        sa.UniqueConstraint(
            "campus_id",
            "vehicle_id",
            "boot_id",
            "number",
            name=op.f("uq_segments_campus_id_vehicle_id_boot_id_number"),
        ),
    )
    op.create_table(
        "server_events",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("number", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("happened_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("name", sa.String(length=64), nullable=False),
        sa.Column("subject", sa.String(length=200), nullable=False),
        sa.Column("made_by", sa.String(length=200), nullable=False),
        sa.Column("detail", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "number", name=op.f("pk_server_events")),
    )
    op.create_table(
        "taps",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("tap_id", sa.String(length=64), nullable=False),
        sa.Column("ride_id", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("kind", sa.String(length=64), nullable=False),
        sa.Column("made_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("state", sa.String(length=64), nullable=False),
        sa.Column("reason", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "tap_id", name=op.f("pk_taps")),
    )
    with op.batch_alter_table("taps", schema=None) as batch_op:
        batch_op.create_index(
            batch_op.f("ix_taps_campus_id_vehicle_id_state"),
            ["campus_id", "vehicle_id", "state"],
            unique=False,
        )

    op.create_table(
        "vehicle_commands",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("command_id", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("kind", sa.String(length=64), nullable=False),
        sa.Column("text", sa.Text(), nullable=False),
        sa.Column("made_by", sa.String(length=200), nullable=False),
        sa.Column("made_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("state", sa.String(length=64), nullable=False),
        sa.Column("detail", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "command_id", name=op.f("pk_vehicle_commands")),
    )
    with op.batch_alter_table("vehicle_commands", schema=None) as batch_op:
        batch_op.create_index(
            batch_op.f("ix_vehicle_commands_campus_id_vehicle_id_state"),
            ["campus_id", "vehicle_id", "state"],
            unique=False,
        )

    op.create_table(
        "vehicle_events",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("boot_id", sa.String(length=64), nullable=False),
        sa.Column("sequence", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("stamp_ns", sa.BigInteger(), nullable=False),
        sa.Column("received_ns", sa.BigInteger(), nullable=False),
        sa.Column("body", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint(
            "campus_id", "vehicle_id", "boot_id", "sequence", name=op.f("pk_vehicle_events")
        ),
    )
    with op.batch_alter_table("vehicle_events", schema=None) as batch_op:
        batch_op.create_index(
            batch_op.f("ix_vehicle_events_campus_id_received_ns"), ["campus_id", "received_ns"], unique=False
        )

    op.create_table(
        "vehicle_keys",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("public_key", sa.String(length=128), nullable=False),
        sa.Column("enrolled_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("revoked_at", sa.DateTime(timezone=True), nullable=True),
        sa.PrimaryKeyConstraint("campus_id", "vehicle_id", name=op.f("pk_vehicle_keys")),
    )
    op.create_table(
        "vehicles",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("name", sa.String(length=200), nullable=False),
        sa.Column("seats", sa.Integer(), nullable=False),
        sa.Column("wheelchair_places", sa.Integer(), nullable=False),
        sa.Column("enrolled_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("epoch", sa.Integer(), nullable=False),
        sa.Column("boot_id", sa.String(length=64), nullable=False),
        sa.Column("connected", sa.Boolean(), nullable=False),
        sa.Column("software", sa.String(length=200), nullable=False),
        sa.Column("stack", sa.String(length=200), nullable=False),
        sa.Column("map_version", sa.String(length=64), nullable=False),
        sa.Column("mode", sa.String(length=64), nullable=False),
        sa.Column("held", sa.Boolean(), nullable=False),
        sa.Column("in_service", sa.Boolean(), nullable=False),
        sa.Column("placed", sa.Boolean(), nullable=False),
        sa.Column("retired", sa.Boolean(), nullable=False),
        sa.Column("unavailable_since", sa.DateTime(timezone=True), nullable=True),
        sa.PrimaryKeyConstraint("campus_id", "vehicle_id", name=op.f("pk_vehicles")),
    )
    op.create_table(
        "whereabouts",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("heard_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("status", sa.Text(), nullable=True),
        sa.PrimaryKeyConstraint("campus_id", "vehicle_id", name=op.f("pk_whereabouts")),
    )


def downgrade() -> None:
    op.drop_table("whereabouts")
    op.drop_table("vehicles")
    op.drop_table("vehicle_keys")
    with op.batch_alter_table("vehicle_events", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_vehicle_events_campus_id_received_ns"))

    op.drop_table("vehicle_events")
    with op.batch_alter_table("vehicle_commands", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_vehicle_commands_campus_id_vehicle_id_state"))

    op.drop_table("vehicle_commands")
    with op.batch_alter_table("taps", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_taps_campus_id_vehicle_id_state"))

    op.drop_table("taps")
    op.drop_table("server_events")
    op.drop_table("segments")
    op.drop_table("section_routes")
    with op.batch_alter_table("runs", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_runs_campus_id_started_at"))

    op.drop_table("runs")
    with op.batch_alter_table("rides", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_rides_campus_id_vehicle_id_state"))
        batch_op.drop_index(batch_op.f("ix_rides_campus_id_state"))
        batch_op.drop_index(batch_op.f("ix_rides_campus_id_ride_code"))
        batch_op.drop_index(batch_op.f("ix_rides_campus_id_requested_at"))

    op.drop_table("rides")
    op.drop_table("plans")
    with op.batch_alter_table("orders", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_orders_campus_id_vehicle_id_number"))

    op.drop_table("orders")
    op.drop_table("operators")
    op.drop_table("operator_sessions")
    op.drop_table("maps")
    op.drop_table("leases")
    with op.batch_alter_table("incidents", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_incidents_campus_id_kind_subject"))
        batch_op.drop_index(batch_op.f("ix_incidents_campus_id_closed_at"))

    op.drop_table("incidents")
    with op.batch_alter_table("history", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_history_campus_id_received_at"))

    op.drop_table("history")
    with op.batch_alter_table("held_sections", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_held_sections_campus_id_vehicle_id"))

    op.drop_table("held_sections")
    op.drop_table("enrolment_codes")
    op.drop_table("developer_tokens")
    with op.batch_alter_table("departures", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_departures_campus_id_state"))

    op.drop_table("departures")
    op.drop_table("counters")
