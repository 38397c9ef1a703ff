"""Events in the order in which they were stored; a table of its own tells how many each boot has."""

import sqlalchemy as sa
from alembic import op

revision = "0018"
down_revision = "0017"
branch_labels = None
depends_on = None

_COLUMNS = "campus_id, vehicle_id, boot_id, sequence, stamp_ns, received_ns, body"
_BY_BOOT = "vehicle_id, boot_id, sequence"


def upgrade() -> None:
    op.create_table(
        "event_logs",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("boot_id", sa.String(length=64), nullable=False),
        sa.Column("next_sequence", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "vehicle_id", "boot_id", name=op.f("pk_event_logs")),
    )
    op.execute(
        "INSERT INTO event_logs (campus_id, vehicle_id, boot_id, next_sequence) "
        "SELECT campus_id, vehicle_id, boot_id, max(sequence) + 1 FROM vehicle_events "
        "GROUP BY campus_id, vehicle_id, boot_id"
    )
    _set_aside()
    _create(sa.Column("number", sa.BigInteger(), nullable=False), keys=("number",))
    op.execute(
        f"INSERT INTO vehicle_events (number, {_COLUMNS}) "
        f"SELECT row_number() OVER (PARTITION BY campus_id ORDER BY received_ns, {_BY_BOOT}), {_COLUMNS} "
        "FROM former_events"
    )
    op.execute(
        "INSERT INTO counters (campus_id, name, value) "
        "SELECT campus_id, 'vehicle_event', max(number) FROM vehicle_events GROUP BY campus_id"
    )
    op.drop_table("former_events")


def downgrade() -> None:
    _set_aside()
    _create(keys=("vehicle_id", "boot_id", "sequence"))
    op.execute(f"INSERT INTO vehicle_events ({_COLUMNS}) SELECT {_COLUMNS} FROM former_events")
    op.execute("DELETE FROM counters WHERE name = 'vehicle_event'")
    op.drop_table("former_events")
    op.drop_table("event_logs")


def _set_aside() -> None:
    """Rename the table; its names are free for the new one."""
    op.drop_index(op.f("ix_vehicle_events_campus_id_received_ns"), table_name="vehicle_events")
    op.rename_table("vehicle_events", "former_events")
    if op.get_bind().dialect.name == "postgresql":
        op.execute("ALTER INDEX pk_vehicle_events RENAME TO pk_former_events")


def _create(*more: sa.Column[int], keys: tuple[str, ...]) -> None:
    op.create_table(
        "vehicle_events",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        *more,
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("boot_id", sa.String(length=64), nullable=False),
        sa.Column("sequence", sa.BigInteger(), nullable=False),
        sa.Column("stamp_ns", sa.BigInteger(), nullable=False),
        sa.Column("received_ns", sa.BigInteger(), nullable=False),
        sa.Column("body", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", *keys, name=op.f("pk_vehicle_events")),
    )
    op.create_index(
        op.f("ix_vehicle_events_campus_id_received_ns"), "vehicle_events", ["campus_id", "received_ns"]
    )
