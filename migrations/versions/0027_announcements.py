"""Operators' announcements, and which of them a command to a vehicle says."""

import sqlalchemy as sa
from alembic import op

revision = "0027"
down_revision = "0026"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "announcements",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("announcement_id", sa.String(length=64), nullable=False),
        sa.Column("text_zh", sa.Text(), nullable=False),
        sa.Column("text_en", sa.Text(), nullable=False),
        sa.Column("starts_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("ends_at", sa.DateTime(timezone=True), nullable=True),
        sa.Column("audience", sa.String(length=64), nullable=False),
        sa.Column("stop_ids", sa.Text(), nullable=False),
        sa.Column("vehicle_ids", sa.Text(), nullable=False),
        sa.Column("made_by", sa.String(length=200), nullable=False),
        sa.Column("made_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("sent_at", sa.DateTime(timezone=True), nullable=True),
        sa.Column("ended_by", sa.String(length=200), nullable=False),
        sa.Column("ended_at", sa.DateTime(timezone=True), nullable=True),
        sa.PrimaryKeyConstraint("campus_id", "announcement_id", name=op.f("pk_announcements")),
    )
    op.create_index(op.f("ix_announcements_campus_id_made_at"), "announcements", ["campus_id", "made_at"])
    op.create_index(
        op.f("ix_announcements_campus_id_ended_at_ends_at"),
        "announcements",
        ["campus_id", "ended_at", "ends_at"],
    )
    op.add_column(
        "vehicle_commands",
        sa.Column("announcement_id", sa.String(length=64), nullable=False, server_default=""),
    )


def downgrade() -> None:
    op.drop_column("vehicle_commands", "announcement_id")
    op.drop_index(op.f("ix_announcements_campus_id_ended_at_ends_at"), table_name="announcements")
    op.drop_index(op.f("ix_announcements_campus_id_made_at"), table_name="announcements")
    op.drop_table("announcements")
