"""Recordings that operators start and stop."""

import sqlalchemy as sa
from alembic import op

revision = "0025"
down_revision = "0024"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "recordings",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("recording_id", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("name", sa.String(length=500), nullable=False),
        sa.Column("started_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("started_by", sa.String(length=200), nullable=False),
        sa.Column("state", sa.String(length=64), nullable=False),
        sa.Column("stop_id", sa.String(length=64), nullable=False),
        sa.Column("stopped_at", sa.DateTime(timezone=True), nullable=True),
        sa.Column("stopped_by", sa.String(length=200), nullable=False),
        sa.Column("begun_boot", sa.String(length=64), nullable=False),
        sa.Column("begun_ns", sa.BigInteger(), nullable=False),
        sa.Column("ended_boot", sa.String(length=64), nullable=False),
        sa.Column("ended_ns", sa.BigInteger(), nullable=False),
        sa.Column("detail", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "recording_id", name=op.f("pk_recordings")),
    )
    op.create_index(
        op.f("ix_recordings_campus_id_started_at"), "recordings", ["campus_id", "started_at"], unique=False
    )
    op.create_index(
        op.f("ix_recordings_campus_id_vehicle_id_started_at"),
        "recordings",
        ["campus_id", "vehicle_id", "started_at"],
        unique=False,
    )


def downgrade() -> None:
    op.drop_index(op.f("ix_recordings_campus_id_vehicle_id_started_at"), table_name="recordings")
    op.drop_index(op.f("ix_recordings_campus_id_started_at"), table_name="recordings")
    op.drop_table("recordings")
