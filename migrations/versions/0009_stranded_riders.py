"""The shuttle that carried a party and could not go on."""

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"
branch_labels = None
depends_on = None


def upgrade() -> None:
    with op.batch_alter_table("rides", schema=None) as batch_op:
        batch_op.add_column(sa.Column("stranded_by", sa.String(length=200), nullable=True))


def downgrade() -> None:
    with op.batch_alter_table("rides", schema=None) as batch_op:
        batch_op.drop_column("stranded_by")
