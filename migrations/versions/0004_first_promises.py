"""What a ride was promised before the promise had to be changed."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None

_COLUMNS = ("first_pickup_from", "first_pickup_to", "first_arrive_by")


def upgrade() -> None:
    with op.batch_alter_table("rides", schema=None) as batch_op:
        for name in _COLUMNS:
            batch_op.add_column(sa.Column(name, sa.DateTime(timezone=True), nullable=True))


def downgrade() -> None:
    with op.batch_alter_table("rides", schema=None) as batch_op:
        for name in reversed(_COLUMNS):
            batch_op.drop_column(name)
