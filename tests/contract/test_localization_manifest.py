"""Manifests that come from anywhere: read, or refused with a sentence; never anything else."""

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from contract.localization_manifest import decode_manifest, tile_check
from contract.localization_maps import LocalizationMapError
from contract.point_map.map_files import TileEntry, version_of
from contract.roads.model import Origin
from tests.contract.localization_folders import occupancy_map, point_map

HERE = Origin(31.3, 121.4)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("maps")
    point_map(path / "points", HERE)
    occupancy_map(path / "cells", HERE)
    return path


def test_both_kinds_are_read_as_they_are_written(folder: Path) -> None:
    for name, kind in (("points", "points"), ("cells", "occupancy")):
        data = (folder / name / "index.json").read_bytes()
        manifest = decode_manifest(data)
        assert (manifest.kind, manifest.origin, len(manifest.tiles)) == (kind, HERE, 3)
        assert manifest.size_bytes == sum((folder / name / one.file).stat().st_size for one in manifest.tiles)
        check = tile_check(data)
        for tile in manifest.tiles:
            check(tile.sha256, (folder / name / tile.file).read_bytes())
            with pytest.raises(LocalizationMapError):
                check(tile.sha256, b"another")
        with pytest.raises(LocalizationMapError):
            check(64 * "0", b"")


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=8,
)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    field=st.sampled_from(["format", "map_version", "tile_m", "voxel_m", "frame", "origin", "tiles"]),
    value=JSON,
)
def test_a_manifest_with_any_other_value_is_refused_with_a_sentence(
    folder: Path, field: str, value: Any
) -> None:
    document = json.loads((folder / "points" / "index.json").read_bytes())
    if document[field] == value or (field in ("tile_m", "voxel_m") and isinstance(value, int | float)):
        return
    document[field] = value
    with pytest.raises(LocalizationMapError, match=r"\w"):
        decode_manifest(json.dumps(document).encode())


@settings(max_examples=200, deadline=None)
@given(data=st.binary(max_size=60) | JSON.map(lambda value: json.dumps(value).encode()))
def test_bytes_that_are_no_manifest_are_refused_with_a_sentence(data: bytes) -> None:
    with pytest.raises(LocalizationMapError, match=r"\w"):
        decode_manifest(data)


@pytest.mark.parametrize(
    "file",
    ["", "tiles/", "tiles/..", "tiles/a/b", "/etc/passwd", "tiles/.hidden", "tiles/a\x00", "other/1_1.tile"],
)
def test_a_tile_lies_below_the_maps_folder_or_the_manifest_is_refused(folder: Path, file: str) -> None:
    document = json.loads((folder / "points" / "index.json").read_bytes())
    document["tiles"][0]["file"] = file
    document["map_version"] = version_of([TileEntry(**one) for one in document["tiles"]])
    with pytest.raises(LocalizationMapError):
        decode_manifest(json.dumps(document).encode())
