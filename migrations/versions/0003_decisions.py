"""The dispatcher's decisions, kept to be explained and repeated."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "decisions",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("decision_id", sa.String(length=64), nullable=False),
        sa.Column("made_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("kind", sa.String(length=64), nullable=False),
        sa.Column("problem", sa.LargeBinary(), nullable=False),
        sa.Column("given", sa.LargeBinary(), nullable=False),
        sa.Column("answer", sa.LargeBinary(), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "decision_id", name=op.f("pk_decisions")),
    )
    with op.batch_alter_table("decisions", schema=None) as batch_op:
        batch_op.create_index(
            batch_op.f("ix_decisions_campus_id_made_at"), ["campus_id", "made_at"], unique=False
        )

    op.create_table(
        "ride_decisions",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("ride_id", sa.String(length=64), nullable=False),
        sa.Column("decision_id", sa.String(length=64), nullable=False),
        sa.Column("made_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("rule", sa.String(length=64), nullable=False),
        sa.Column("best", sa.Text(), nullable=False),
        sa.Column("runner_up", sa.Text(), nullable=False),
        sa.Column("alternatives", sa.Text(), nullable=False),
        sa.Column("vehicles", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "ride_id", "decision_id", name=op.f("pk_ride_decisions")),
    )
    with op.batch_alter_table("ride_decisions", schema=None) as batch_op:
        batch_op.create_index(
            batch_op.f("ix_ride_decisions_campus_id_made_at"), ["campus_id", "made_at"], unique=False
        )


def downgrade() -> None:
    op.drop_table("ride_decisions")
    op.drop_table("decisions")
