"""Service patterns and exceptions, recurring bookings, and rides whose destination can change."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "service_patterns",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("service_id", sa.String(length=64), nullable=False),
        sa.Column("name", sa.String(length=200), nullable=False),
        sa.Column("weekdays", sa.Text(), nullable=False),
        sa.Column("starts_on", sa.Date(), nullable=True),
        sa.Column("ends_on", sa.Date(), nullable=True),
        sa.Column("hours", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "service_id", name=op.f("pk_service_patterns")),
    )
    op.create_table(
        "service_exceptions",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("day", sa.Date(), nullable=False),
        sa.Column("service_id", sa.String(length=64), nullable=False),
        sa.Column("runs", sa.Boolean(), nullable=False),
        sa.Column("note", sa.Text(), nullable=False),
        sa.Column("made_by", sa.String(length=200), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "day", "service_id", name=op.f("pk_service_exceptions")),
    )
    op.create_table(
        "series",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("series_id", sa.String(length=64), nullable=False),
        sa.Column("token", sa.String(length=128), nullable=False),
        sa.Column("from_stop", sa.String(length=200), nullable=False),
        sa.Column("to_stop", sa.String(length=200), nullable=False),
        sa.Column("party", sa.Integer(), nullable=False),
        sa.Column("wheelchairs", sa.Integer(), nullable=False),
        sa.Column("weekdays", sa.Text(), nullable=False),
        sa.Column("leave_s", sa.Integer(), nullable=False),
        sa.Column("starts_on", sa.Date(), nullable=False),
        sa.Column("ends_on", sa.Date(), nullable=False),
        sa.Column("made_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("source", sa.String(length=64), nullable=False),
        sa.Column("state", sa.String(length=64), nullable=False),
        sa.Column("ended_at", sa.DateTime(timezone=True), nullable=True),
        sa.Column("idempotency_key", sa.String(length=200), nullable=True),
        sa.PrimaryKeyConstraint("campus_id", "series_id", name=op.f("pk_series")),
        sa.UniqueConstraint("campus_id", "token", name=op.f("uq_series_campus_id_token")),
        sa.UniqueConstraint("campus_id", "idempotency_key", name=op.f("uq_series_campus_id_idempotency_key")),
    )
    with op.batch_alter_table("series", schema=None) as batch_op:
        batch_op.create_index(batch_op.f("ix_series_campus_id_state"), ["campus_id", "state"], unique=False)

    op.create_table(
        "occurrences",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("series_id", sa.String(length=64), nullable=False),
        sa.Column("day", sa.Date(), nullable=False),
        sa.Column("leave_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("state", sa.String(length=64), nullable=False),
        sa.Column("ride_id", sa.String(length=64), nullable=True),
        sa.Column("reason", sa.String(length=64), nullable=False),
        sa.Column("reason_detail", sa.Text(), nullable=False),
        sa.Column("tried_at", sa.DateTime(timezone=True), nullable=True),
        sa.PrimaryKeyConstraint("campus_id", "series_id", "day", name=op.f("pk_occurrences")),
    )
    with op.batch_alter_table("rides", schema=None) as batch_op:
        batch_op.add_column(sa.Column("arrive_before", sa.DateTime(timezone=True), nullable=True))
        batch_op.add_column(sa.Column("first_to_stop", sa.String(length=200), nullable=True))
        batch_op.add_column(sa.Column("let_out", sa.Boolean(), nullable=False, server_default=sa.false()))
        batch_op.add_column(sa.Column("series_id", sa.String(length=64), nullable=True))


def downgrade() -> None:
    with op.batch_alter_table("rides", schema=None) as batch_op:
        batch_op.drop_column("series_id")
        batch_op.drop_column("let_out")
        batch_op.drop_column("first_to_stop")
        batch_op.drop_column("arrive_before")

    op.drop_table("occurrences")
    with op.batch_alter_table("series", schema=None) as batch_op:
        batch_op.drop_index(batch_op.f("ix_series_campus_id_state"))

    op.drop_table("series")
    op.drop_table("service_exceptions")
    op.drop_table("service_patterns")
