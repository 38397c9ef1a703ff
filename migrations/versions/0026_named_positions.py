"""Commands that say where a vehicle stands."""

import sqlalchemy as sa
from alembic import op

revision = "0026"
down_revision = "0025"
branch_labels = None
depends_on = None

COLUMNS = ("pose_x_m", "pose_y_m", "pose_yaw_rad")


def upgrade() -> None:
    with op.batch_alter_table("vehicle_commands") as batch:
        for name in COLUMNS:
            batch.add_column(sa.Column(name, sa.Float(), nullable=True))


def downgrade() -> None:
    with op.batch_alter_table("vehicle_commands") as batch:
        for name in reversed(COLUMNS):
            batch.drop_column(name)
