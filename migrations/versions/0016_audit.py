"""The audit log, chained by hashes."""

import sqlalchemy as sa
from alembic import op

revision = "0016"
down_revision = "0015"
branch_labels = None
depends_on = None

_TEXTS = (
    ("kind", 64),
    ("made_by", 200),
    ("action", 64),
    ("subject", 300),
    ("outcome", 64),
    ("command_id", 64),
    ("address", 64),
    ("salt", 64),
    ("address_sha256", 64),
    ("previous_sha256", 64),
    ("sha256", 64),
)


def upgrade() -> None:
    op.create_table(
        "audit_entries",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("number", sa.BigInteger(), autoincrement=False, nullable=False),
        sa.Column("happened_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("detail", sa.Text(), nullable=False),
        *(sa.Column(name, sa.String(length=length), nullable=False) for name, length in _TEXTS),
        sa.PrimaryKeyConstraint("campus_id", "number", name=op.f("pk_audit_entries")),
    )
    op.create_index(
        op.f("ix_audit_entries_campus_id_command_id"), "audit_entries", ["campus_id", "command_id"]
    )


def downgrade() -> None:
    op.drop_index(op.f("ix_audit_entries_campus_id_command_id"), table_name="audit_entries")
    op.drop_table("audit_entries")
