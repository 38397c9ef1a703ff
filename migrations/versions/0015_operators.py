"""Operators have roles, may be disabled, and may have a second factor. Operators of before have all roles."""

import sqlalchemy as sa
from alembic import op

revision = "0015"
down_revision = "0014"
branch_labels = None
depends_on = None

_ALL = '["admin","dispatcher","safety","viewer"]'


def upgrade() -> None:
    with op.batch_alter_table("operators", schema=None) as batch_op:
        batch_op.add_column(sa.Column("roles", sa.Text(), nullable=False, server_default=_ALL))
        batch_op.add_column(sa.Column("disabled_at", sa.DateTime(timezone=True), nullable=True))
        batch_op.add_column(sa.Column("initial_until", sa.DateTime(timezone=True), nullable=True))
    with op.batch_alter_table("operators", schema=None) as batch_op:
        batch_op.alter_column("roles", server_default=None, existing_type=sa.Text())
    with op.batch_alter_table("operator_sessions", schema=None) as batch_op:
        batch_op.add_column(sa.Column("checked_at", sa.DateTime(timezone=True), nullable=True))
    op.create_table(
        "second_factors",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("factor_id", sa.String(length=64), nullable=False),
        sa.Column("operator_id", sa.String(length=64), nullable=False),
        sa.Column("ticket_key_id", sa.String(length=64), nullable=False),
        sa.Column("made_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("confirmed_at", sa.DateTime(timezone=True), nullable=True),
        sa.Column("last_step", sa.BigInteger(), nullable=False),
        sa.Column("wrong_codes", sa.Integer(), nullable=False),
        sa.Column("recovery_sha256", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "factor_id", name=op.f("pk_second_factors")),
    )
    op.create_index(
        op.f("ix_second_factors_campus_id_operator_id"), "second_factors", ["campus_id", "operator_id"]
    )


def downgrade() -> None:
    """A version without roles would let operators in that are disabled: they are deleted."""
    op.execute("DELETE FROM operators WHERE disabled_at IS NOT NULL")
    op.drop_index(op.f("ix_second_factors_campus_id_operator_id"), table_name="second_factors")
    op.drop_table("second_factors")
    with op.batch_alter_table("operator_sessions", schema=None) as batch_op:
        batch_op.drop_column("checked_at")
    with op.batch_alter_table("operators", schema=None) as batch_op:
        for name in ("initial_until", "disabled_at", "roles"):
            batch_op.drop_column(name)
