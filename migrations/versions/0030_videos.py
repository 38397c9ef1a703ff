"""Video segments of vehicles' cameras."""

import sqlalchemy as sa
from alembic import op

revision = "0030"
down_revision = "0029"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "video_segments",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("sha256", sa.String(length=64), nullable=False),
        sa.Column("vehicle_id", sa.String(length=64), nullable=False),
        sa.Column("camera", sa.String(length=64), nullable=False),
        sa.Column("begins_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("ends_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("stamp_ns", sa.BigInteger(), nullable=False),
        sa.Column("size_bytes", sa.BigInteger(), nullable=False),
        sa.Column("received_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "sha256", name=op.f("pk_video_segments")),
    )
    for columns in (("vehicle_id", "begins_at"), ("received_at",)):
        name = op.f(f"ix_video_segments_campus_id_{'_'.join(columns)}")
        op.create_index(name, "video_segments", ["campus_id", *columns], unique=False)


def downgrade() -> None:
    op.drop_table("video_segments")
