"""Driven legs, and the travel times by hour that are learnt from them."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "open_legs",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("from_stop", sa.String(length=200), nullable=False),
        sa.Column("left_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "vehicle_id", name=op.f("pk_open_legs")),
    )
    op.create_table(
        "driven_legs",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("left_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("from_stop", sa.String(length=200), nullable=False),
        sa.Column("to_stop", sa.String(length=200), nullable=False),
        sa.Column("hour", sa.Integer(), nullable=False),
        sa.Column("planned_s", sa.Float(), nullable=False),
        sa.Column("driven_s", sa.Float(), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "vehicle_id", "left_at", name=op.f("pk_driven_legs")),
    )
    op.create_table(
        "paces",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("factors", sa.Text(), nullable=False),
        sa.Column("legs", sa.Text(), nullable=False),
        sa.Column("learned_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", name=op.f("pk_paces")),
    )


def downgrade() -> None:
    op.drop_table("paces")
    op.drop_table("driven_legs")
    op.drop_table("open_legs")
