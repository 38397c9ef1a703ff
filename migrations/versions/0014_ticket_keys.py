"""Links and boarding codes are derived from a key outside the database; none is stored.

Of links that were made before, the hash is kept, so that they still work. Boarding codes are taken out of the
orders as well. Idempotency keys are stored as hashes: who repeats a booking gets its link.
"""

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"
branch_labels = None
depends_on = None

_BATCH = 1_000
Keys = tuple[str, ...]


def upgrade() -> None:
    op.create_table(
        "ticket_keys",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("key_id", sa.String(length=64), nullable=False),
        sa.Column("first_used_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "key_id", name=op.f("pk_ticket_keys")),
    )
    for table, key in (("rides", "ride_id"), ("series", "series_id")):
        with op.batch_alter_table(table, schema=None) as batch_op:
            batch_op.add_column(
                sa.Column("ticket_key_id", sa.String(length=64), nullable=False, server_default="")
            )
            batch_op.add_column(sa.Column("old_token_sha256", sa.String(length=64), nullable=True))
        _change(table, ("campus_id", key), "old_token_sha256", "token", _sha256)
        _change(table, ("campus_id", key), "idempotency_key", "idempotency_key", _hashed_key)
        with op.batch_alter_table(table, schema=None) as batch_op:
            batch_op.alter_column("ticket_key_id", server_default=None, existing_type=sa.String(length=64))
            batch_op.drop_constraint(op.f(f"uq_{table}_campus_id_token"), type_="unique")
            batch_op.create_unique_constraint(
                op.f(f"uq_{table}_campus_id_old_token_sha256"), ["campus_id", "old_token_sha256"]
            )
            batch_op.drop_column("token")
            if table == "rides":
                batch_op.drop_column("boarding_code")
    _change("orders", ("campus_id", "order_id", "revision"), "payload", "payload", _without_codes)


def downgrade() -> None:
    """Links of before cannot be made from their hashes: they end. Idempotency keys stay hashes."""
    for table, key in (("rides", "ride_id"), ("series", "series_id")):
        with op.batch_alter_table(table, schema=None) as batch_op:
            batch_op.add_column(sa.Column("token", sa.String(length=128), nullable=False, server_default=""))
            if table == "rides":
                batch_op.add_column(
                    sa.Column("boarding_code", sa.String(length=16), nullable=False, server_default="")
                )
        op.execute(f"UPDATE {table} SET token = {key}")
        with op.batch_alter_table(table, schema=None) as batch_op:
            batch_op.alter_column("token", server_default=None, existing_type=sa.String(length=128))
            if table == "rides":
                batch_op.alter_column(
                    "boarding_code", server_default=None, existing_type=sa.String(length=16)
                )
            batch_op.drop_constraint(op.f(f"uq_{table}_campus_id_old_token_sha256"), type_="unique")
            batch_op.create_unique_constraint(op.f(f"uq_{table}_campus_id_token"), ["campus_id", "token"])
            batch_op.drop_column("old_token_sha256")
            batch_op.drop_column("ticket_key_id")
    op.drop_table("ticket_keys")


def _change(table: str, keys: Keys, target: str, source: str, made: Callable[[str], str | None]) -> None:
    """Set `target` of every row to what is made of its `source`, where that is something."""
    rows = sa.table(table, *(sa.column(name) for name in dict.fromkeys((*keys, source, target))))
    is_row = (rows.c[name] == sa.bindparam(f"of_{name}") for name in keys)
    change = sa.update(rows).where(*is_row).values({target: sa.bindparam("made")})
    for batch in _batches(rows, keys, source):
        values = [
            {"made": text, **{f"of_{name}": row[name] for name in keys}}
            for row in batch
            if row[source] is not None and (text := made(row[source])) is not None
        ]
        if values:
            op.get_bind().execute(change, values)


def _batches(rows: sa.TableClause, keys: Keys, source: str) -> Iterator[Sequence[sa.RowMapping]]:
    """All rows, by key: there may be more than fit into the memory."""
    order = sa.tuple_(*(rows.c[name] for name in keys))
    statement = sa.select(*(rows.c[name] for name in dict.fromkeys((*keys, source)))).order_by(
        *(rows.c[name] for name in keys)
    )
    batch = op.get_bind().execute(statement.limit(_BATCH)).mappings().all()
    while batch:
        yield batch
        last = sa.tuple_(*(sa.literal(batch[-1][name]) for name in keys))
        batch = op.get_bind().execute(statement.where(order > last).limit(_BATCH)).mappings().all()


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _hashed_key(key: str) -> str | None:
    """Those of developers are hashes already, and those of days of a series are made by the server."""
    return None if key.startswith(("developer:", "series/")) else f"passenger:{_sha256(key)}"


def _without_codes(payload: str) -> str | None:
    if '"code"' not in payload:
        return None
    order = json.loads(payload)
    for visit in order.get("visits", ()):
        for rider in (*visit.get("board", ()), *visit.get("alight", ())):
            rider.pop("code", None)
    return json.dumps(order, ensure_ascii=False, separators=(",", ":"))
