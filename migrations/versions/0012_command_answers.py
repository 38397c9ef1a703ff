"""Answers to commands with an idempotency key, so that a repeat gets the first one."""

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0011"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "command_answers",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("account", sa.String(length=128), nullable=False),
        sa.Column("key_sha256", sa.String(length=64), nullable=False),
        sa.Column("request_sha256", sa.String(length=64), nullable=False),
        sa.Column("sealed", sa.LargeBinary(), nullable=False),
        sa.Column("made_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "account", "key_sha256", name=op.f("pk_command_answers")),
    )
    op.create_index(op.f("ix_command_answers_campus_id_made_at"), "command_answers", ["campus_id", "made_at"])


def downgrade() -> None:
    op.drop_index(op.f("ix_command_answers_campus_id_made_at"), "command_answers")
    op.drop_table("command_answers")
