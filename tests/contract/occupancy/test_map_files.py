"""Occupancy maps on disk: what is written is read, and what was changed is refused."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contract.occupancy.map_files import MapFileError, read_map, write_map
from contract.occupancy.occupancy_map import FREE, OCCUPIED, UNKNOWN, OccupancyMap

CELLS = np.array([[OCCUPIED, FREE, UNKNOWN], [FREE, FREE, OCCUPIED]], dtype=np.uint8)
A_MAP = OccupancyMap(CELLS, 0.5, -1.0, 2.0)


@settings(max_examples=30)
@given(
    st.integers(1, 7),
    st.integers(1, 7),
    st.integers(0, 2**32 - 1),
    st.floats(0.01, 1.0),
    st.floats(-1e3, 1e3),
)
def test_a_map_comes_back_as_it_was(rows: int, columns: int, seed: int, cell_m: float, x_m: float) -> None:
    import tempfile

    cells = np.random.default_rng(seed).choice(np.array([FREE, OCCUPIED, UNKNOWN], np.uint8), (rows, columns))
    written = OccupancyMap(cells, cell_m, x_m, -x_m)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.yaml"
        write_map(written, path)
        read = read_map(path)
    assert (read.cells == cells).all()
    assert read.map_hash == written.map_hash


def test_a_point_finds_its_cell() -> None:
    assert A_MAP.state_at(-0.99, 2.01) == OCCUPIED
    assert A_MAP.state_at(-0.51, 2.51) == FREE
    assert A_MAP.state_at(0.49, 2.99) == OCCUPIED
    assert A_MAP.state_at(0.51, 2.0) == UNKNOWN


def test_the_first_row_of_the_image_is_the_greatest_y(tmp_path: Path) -> None:
    write_map(A_MAP, tmp_path / "map.yaml")
    assert (tmp_path / "map.pgm").read_bytes() == b"P5\n3 2\n255\n" + bytes([254, 254, 0, 0, 254, 205])


def test_a_map_of_map_server_is_read(tmp_path: Path) -> None:
    (tmp_path / "hall.pgm").write_bytes(b"P5\n# CREATOR: map_saver\n3 1\n255\n" + bytes([254, 0, 205]))
    (tmp_path / "hall.yaml").write_text(
        "image: hall.pgm\nresolution: 0.050000\norigin: [-10.5, 3, 0.0]\nnegate: 0\n"
        "occupied_thresh: 0.65 # ours\nfree_thresh: 0.196\n"
    )
    read = read_map(tmp_path / "hall.yaml")
    assert read.cells.tolist() == [[FREE, OCCUPIED, UNKNOWN]]
    assert (read.cell_m, read.origin_x_m, read.origin_y_m) == (0.05, -10.5, 3.0)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("resolution: 0.5", "resolution: 0.25"),
        ("resolution: 0.5", "resolution: -0.5"),
        ("resolution: 0.5", "resolution: nan"),
        ("resolution: 0.5\n", ""),
        ("[-1.0, 2.0, 0.0]", "[-1.0, 2.0, 0.3]"),
        ("[-1.0, 2.0, 0.0]", "[-1.0, 2.0]"),
        ("campusloop_format: 1", "campusloop_format: 2"),
        ('"map.pgm"', '"none.pgm"'),
        ('"map.pgm"', '"map.yaml"'),
    ],
)
def test_a_changed_map_is_refused_in_one_sentence(tmp_path: Path, old: str, new: str) -> None:
    path = tmp_path / "map.yaml"
    write_map(A_MAP, path)
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(MapFileError) as refused:
        read_map(path)
    assert "\n" not in str(refused.value)


def test_a_changed_or_cut_image_is_refused(tmp_path: Path) -> None:
    path, image = tmp_path / "map.yaml", tmp_path / "map.pgm"
    write_map(A_MAP, path)
    data = image.read_bytes()
    for changed in (data[:-1], data[:-1] + b"\x00"):
        image.write_bytes(changed)
        with pytest.raises(MapFileError):
            read_map(path)
