"""Road maps as bytes."""

from pathlib import Path

import msgspec
import pytest

from contract.roads.load import MapError, content_version, decode_map, encode_map, load_map
from tests.contract.roads.ring_map import ring_map


def test_a_map_survives_the_way_through_bytes() -> None:
    assert decode_map(encode_map(ring_map())) == ring_map()


def test_equal_maps_give_equal_bytes_and_versions() -> None:
    assert encode_map(ring_map()) == encode_map(ring_map())
    assert len(ring_map().map_version) == 16


def test_any_change_of_content_changes_the_version() -> None:
    changed = msgspec.structs.replace(ring_map(), name="Other")
    assert content_version(changed) != ring_map().map_version


def test_the_layout_of_the_json_does_not_matter() -> None:
    spread = msgspec.json.format(encode_map(ring_map()), indent=2)
    assert decode_map(spread).map_version == ring_map().map_version


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (b"", "map_empty"),
        (b"  \n", "map_empty"),
        (b"not json", "map_broken"),
        (b"\xff\xfe\x00", "map_broken"),
        (b'{"campus_id": 5}', "map_broken"),
        (b"[]", "map_broken"),
    ],
)
def test_bytes_that_are_no_map_are_refused_with_what_to_do(data: bytes, code: str) -> None:
    with pytest.raises(MapError) as caught:
        decode_map(data)
    assert caught.value.code == code
    assert "campusloop map import" in caught.value.detail


def test_a_map_cut_anywhere_is_refused() -> None:
    data = encode_map(ring_map()).rstrip()
    for cut in range(1, len(data), max(1, len(data) // 60)):
        with pytest.raises(MapError) as caught:
            decode_map(data[:cut])
        assert caught.value.code == "map_broken"


def test_a_map_edited_by_hand_is_refused_until_its_version_is_cleared() -> None:
    edited = encode_map(ring_map()).replace(b'"Ring"', b'"Rung"')
    with pytest.raises(MapError) as caught:
        decode_map(edited)
    assert caught.value.code == "map_altered"
    cleared = edited.replace(ring_map().map_version.encode(), b"")
    assert decode_map(cleared).name == "Rung"


def test_a_map_of_another_format_is_refused() -> None:
    other = msgspec.structs.replace(ring_map(), format_version=99)
    with pytest.raises(MapError) as caught:
        decode_map(encode_map(other))
    assert caught.value.code == "map_format"


def test_a_missing_file_is_a_map_error(tmp_path: Path) -> None:
    with pytest.raises(MapError) as caught:
        load_map(tmp_path / "none.json")
    assert caught.value.code == "map_missing"
