"""The table of travel time factors under the field's name for them."""

from alembic import op

revision = "0010"
down_revision = "0009"
branch_labels = None
depends_on = None


def upgrade() -> None:
    _rename("paces", "travel_time_factors")


def downgrade() -> None:
    _rename("travel_time_factors", "paces")


def _rename(before: str, after: str) -> None:
    op.rename_table(before, after)
    # SQLite keeps a constraint's name inside the table, where nothing looks it up.
    if op.get_bind().dialect.name == "postgresql":
        op.execute(f"ALTER INDEX pk_{before} RENAME TO pk_{after}")
