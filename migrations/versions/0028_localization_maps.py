"""Localization maps: their manifests, which tiles are kept, and what vehicles use."""

import sqlalchemy as sa
from alembic import op

revision = "0028"
down_revision = "0027"
branch_labels = None
depends_on = None

VEHICLE_COLUMNS = ("localizes_by", "localization_map", "localization_change")


def upgrade() -> None:
    op.create_table(
        "localization_maps",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("map_version", sa.String(length=64), nullable=False),
        sa.Column("kind", sa.String(length=64), nullable=False),
        sa.Column("latitude_deg", sa.Double(), nullable=False),
        sa.Column("longitude_deg", sa.Double(), nullable=False),
        sa.Column("manifest", sa.LargeBinary(), nullable=False),
        sa.Column("manifest_sha256", sa.String(length=64), nullable=False),
        sa.Column("manifest_bytes", sa.Integer(), nullable=False),
        sa.Column("tile_count", sa.Integer(), nullable=False),
        sa.Column("size_bytes", sa.BigInteger(), nullable=False),
        sa.Column("road_map_version", sa.String(length=64), nullable=False),
        sa.Column("note", sa.Text(), nullable=False),
        sa.Column("published_by", sa.String(length=200), nullable=False),
        sa.Column("published_at", sa.DateTime(timezone=True), nullable=False),
        sa.Column("active", sa.Boolean(), nullable=False),
        sa.Column("activated_by", sa.String(length=200), nullable=False),
        sa.Column("activated_at", sa.DateTime(timezone=True), nullable=True),
        sa.PrimaryKeyConstraint("campus_id", "map_version", name=op.f("pk_localization_maps")),
    )
    op.create_table(
        "localization_tiles",
        sa.Column("campus_id", sa.String(length=64), nullable=False),
        sa.Column("sha256", sa.String(length=64), nullable=False),
        sa.Column("size_bytes", sa.Integer(), nullable=False),
        sa.Column("kept_at", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("campus_id", "sha256", name=op.f("pk_localization_tiles")),
    )
    for name in VEHICLE_COLUMNS:
        op.add_column("vehicles", sa.Column(name, sa.String(length=64), nullable=False, server_default=""))


def downgrade() -> None:
    for name in VEHICLE_COLUMNS:
        op.drop_column("vehicles", name)
    op.drop_table("localization_tiles")
    op.drop_table("localization_maps")
