"""The history of one ride is read by its subject."""

from alembic import op

revision = "0021"
down_revision = "0020"
branch_labels = None
depends_on = None

INDEX = "ix_server_events_campus_id_subject"


def upgrade() -> None:
    op.create_index(op.f(INDEX), "server_events", ["campus_id", "subject"])


def downgrade() -> None:
    op.drop_index(op.f(INDEX), table_name="server_events")
