"""Holds that end by themselves, vehicles that charge, and rides whose vehicle an operator chose."""

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None


def upgrade() -> None:
    with op.batch_alter_table("vehicles", schema=None) as batch_op:
        batch_op.add_column(sa.Column("hold_ends", sa.DateTime(timezone=True), nullable=True))
        batch_op.add_column(sa.Column("charging", sa.Boolean(), nullable=False, server_default=sa.false()))
    with op.batch_alter_table("rides", schema=None) as batch_op:
        batch_op.add_column(sa.Column("pinned", sa.Boolean(), nullable=False, server_default=sa.false()))


def downgrade() -> None:
    with op.batch_alter_table("rides", schema=None) as batch_op:
        batch_op.drop_column("pinned")
    with op.batch_alter_table("vehicles", schema=None) as batch_op:
        batch_op.drop_column("charging")
        batch_op.drop_column("hold_ends")
