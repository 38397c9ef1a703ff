"""Why a vehicle cannot take the map in force."""

import sqlalchemy as sa
from alembic import op

revision = "0024"
down_revision = "0023"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column(
        "vehicles", sa.Column("map_failure", sa.String(length=64), nullable=False, server_default="")
    )


def downgrade() -> None:
    op.drop_column("vehicles", "map_failure")
