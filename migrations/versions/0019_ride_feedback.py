"""Passengers rate a ride and say what they left in the shuttle."""

import sqlalchemy as sa
from alembic import op

revision = "0019"
down_revision = "0018"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "ride_feedback",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("ride_id", sa.String(length=64), nullable=False),
        sa.Column("rating", sa.Integer(), nullable=True),
        sa.Column("lost_property", sa.Text(), nullable=False),
        sa.Column("made_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "ride_id", name=op.f("pk_ride_feedback")),
    )


def downgrade() -> None:
    op.drop_table("ride_feedback")
